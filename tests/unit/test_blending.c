/* SPDX-License-Identifier: MIT */
/*
 * test_blending.c - numbers that GIMP's blending turns into the right 16-bit levels, found once
 */
#undef NDEBUG
#include "../../gimp-plugin/gegl/blending.h"

#include <assert.h>

enum { LEVELS = 65536, LOST = 33 /* levels that babl never gives at gamma 2.2 */ };

static pixels stored_in(const Babl *space, const char *name, gint channels)
{
    return (pixels) { .format = babl_format_with_space(name, space),
                      .type = NTP_TYPE_U16,
                      .channels = channels,
                      .bytes = 2 * channels };
}

static const Babl *gamma_space(void)
{
    return babl_space_from_chromaticities("test", 0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15,
                                          0.06, babl_trc_gamma(2.2), NULL, NULL,
                                          BABL_SPACE_FLAG_EQUALIZE);
}

/* The levels come back, but for those that babl leaves out. */
static void check_levels(const blending *b, const Babl *light, const pixels *stored)
{
    guint16 *texels = g_new(guint16, 3 * LEVELS), *back = g_new(guint16, 3 * LEVELS);
    gfloat *numbers = g_new(gfloat, 4 * LEVELS);
    gint wrong = 0;
    for (gint i = 0; i < 3 * LEVELS; i++)
        texels[i] = (guint16) (i / 3);
    blending_put(b, 3, texels, numbers, LEVELS);
    babl_process(babl_fish(light, stored->format), numbers, back, LEVELS);
    for (gint i = 0; i < 3 * LEVELS; i++)
        wrong += texels[i] != back[i];
    assert(wrong <= 3 * LOST);
    g_free(texels);
    g_free(back);
    g_free(numbers);
}

int main(void)
{
    babl_init();
    const pixels rgb = stored_in(gamma_space(), "R'G'B' u16", 3);
    const pixels plain = stored_in(babl_space("sRGB"), "R'G'B' u16", 3);
    const blending *first = NULL, *second = NULL, *none = NULL;
    const Babl *light = blending_prepare(&first, &rgb);
    assert(light != NULL && blending_prepare(&second, &rgb) == light);
    assert(first == second); /* another operation does not find the numbers again */
    check_levels(first, light, &rgb);
    assert(blending_prepare(&none, &plain) == NULL && none == NULL);
    babl_exit();
    return 0;
}
