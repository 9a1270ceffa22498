/* SPDX-License-Identifier: MIT */
/*
 * luminance.c - the luminance of colors, as GIMP's own Normal Map filter takes it for the height
 */
#include "luminance.h"

#include <math.h>

enum { MOST_LEVELS = 65536 };

/* The transfer curve: a power, or that of sRGB. */
typedef struct curve {
    gboolean srgb;
    gdouble power; /* 1: linear */
} curve;

struct luminance {
    curve stored, made;
    gboolean same_curve;
    gdouble weights[3];
    gint channels;                 /* of the colors */
    gint levels;                   /* of integers; 0: float */
    gdouble of_level[MOST_LEVELS]; /* the light of a level */
};

static gdouble to_light(const curve *c, gdouble value)
{
    if (c->srgb) /* IEC 61966-2-1 */
        return value > 0.04045 ? pow((value + 0.055) / 1.055, 2.4) : value / 12.92;
    if (c->power == 1)
        return value;
    return value > 0 ? pow(value, c->power) : 0;
}

static gdouble from_light(const curve *c, gdouble light)
{
    if (c->srgb)
        return light > 0.04045 / 12.92 ? 1.055 * pow(light, 1 / 2.4) - 0.055 : light * 12.92;
    if (c->power == 1)
        return light;
    return light > 0 ? pow(light, 1 / c->power) : 0;
}

static gboolean curve_of_space(const Babl *space, curve *found)
{
    const Babl *trc[3];
    babl_space_get(space, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, &trc[0], &trc[1],
                   &trc[2]);
    if (trc[0] != trc[1] || trc[1] != trc[2])
        return FALSE;
    *found = (curve) { .srgb = trc[0] == babl_trc("sRGB"), .power = babl_space_get_gamma(space) };
    if (trc[0] == babl_trc("linear"))
        found->power = 1;
    return found->srgb || found->power > 0;
}

static luminance *make(const Babl *stored)
{
    const Babl *space = babl_format_get_space(stored), *type = babl_format_get_type(stored, 0);
    const BablModelFlag flags = babl_get_model_flags(babl_format_get_model(stored));
    luminance *l = g_new0(luminance, 1);
    l->channels = babl_format_get_n_components(stored);
    l->levels = type == babl_type("u8") ? 256 : type == babl_type("u16") ? MOST_LEVELS : 0;
    if (l->channels < 3 || (l->levels == 0 && type != babl_type("float")) ||
        !curve_of_space(space, &l->made)) {
        g_free(l);
        return NULL;
    }
    l->stored = l->made;
    if ((flags & BABL_MODEL_FLAG_LINEAR) != 0)
        l->stored = (curve) { .power = 1 };
    else if ((flags & BABL_MODEL_FLAG_PERCEPTUAL) != 0)
        l->stored = (curve) { .srgb = TRUE };
    l->same_curve = l->stored.srgb == l->made.srgb && l->stored.power == l->made.power;
    babl_space_get_rgb_luminance(space, &l->weights[0], &l->weights[1], &l->weights[2]);
    for (gint i = 0; i < l->levels; i++)
        l->of_level[i] = to_light(&l->stored, i / (l->levels - 1.0));
    return l;
}

const luminance *luminance_of(const Babl *stored)
{
    static GMutex busy;
    static GHashTable *made;
    gpointer found = NULL;
    g_mutex_lock(&busy);
    if (made == NULL)
        made = g_hash_table_new(NULL, NULL);
    if (!g_hash_table_lookup_extended(made, stored, NULL, &found)) {
        found = make(stored);
        g_hash_table_insert(made, (gpointer) (guintptr) stored, found);
    }
    g_mutex_unlock(&busy);
    return found;
}

/* Sample c of colors, as a number and as light. */
static gdouble number_of(const luminance *l, gconstpointer colors, gsize c)
{
    return l->levels == 256           ? ((const guint8 *) colors)[c] / 255.0
           : l->levels == MOST_LEVELS ? ((const guint16 *) colors)[c] / 65535.0
                                      : (gdouble) ((const gfloat *) colors)[c];
}

static gdouble light_of(const luminance *l, gconstpointer colors, gsize c)
{
    return l->levels == 256           ? l->of_level[((const guint8 *) colors)[c]]
           : l->levels == MOST_LEVELS ? l->of_level[((const guint16 *) colors)[c]]
                                      : to_light(&l->stored, ((const gfloat *) colors)[c]);
}

static gdouble luminance_at(const luminance *l, gconstpointer colors, gsize first)
{
    const gdouble red = light_of(l, colors, first), green = light_of(l, colors, first + 1),
                  blue = light_of(l, colors, first + 2);
    if (l->same_curve && !(red < green || red > green || green < blue || green > blue))
        return number_of(l, colors, first);
    return from_light(&l->made, l->weights[0] * red + l->weights[1] * green + l->weights[2] * blue);
}

void luminance_make(const luminance *l, gconstpointer colors, gfloat *made, gsize count,
                    gboolean alpha)
{
    for (gsize i = 0; i < count; i++) {
        const gsize first = i * (gsize) l->channels;
        *made++ = (gfloat) luminance_at(l, colors, first);
        if (alpha)
            *made++ = l->channels == 4 ? (gfloat) number_of(l, colors, first + 3) : 1;
    }
}
