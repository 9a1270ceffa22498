/* SPDX-License-Identifier: MIT */
/*
 * test_evidence.c - what texels say about levels does not depend on how they lie in rows, so that no
 * row counts more or fewer than it has; nor on the instruction set.
 */
#include "base/cpu.h"
#include "guarded.h"
#include "to_height/evidence.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 75, HEIGHT = 60, TEXELS = WIDTH * HEIGHT };

static uint32_t state = 1;

static int32_t random_below(int32_t n)
{
    state = state * 1664525u + 1013904223u;
    return (int32_t) ((state >> 8) % (uint32_t) n);
}

static void gather_by(ntp__gather_evidence_fn *by, evidence *e, const uint8_t *texels,
                      int32_t width)
{
    ntp_image view =
        ntp_image_packed((void *) (uintptr_t) texels, width, TEXELS / width, 3, NTP_TYPE_U8);
    const ntp_const_image src = ntp_image_as_const(&view);
    memset(e, 0, sizeof *e);
    e->unorm = (rule) { .zero = 255, .unit = 1 / 255.0 };
    e->trunc = (rule) { .zero = 254, .unit = 1 / 255.0 };
    e->snorm = (rule) { .zero = 256, .unit = 1 / 254.0 };
    e->most_rest = 0.81 * 255 * 255;
    e->most_off = 255.0 * 255;
    by(e, &src, 0, true);
}

/* The same by every instruction set, to the last bit. */
static void gather(evidence *e, const uint8_t *texels, int32_t width)
{
    gather_by(ntp__gather_evidence_base, e, texels, width);
#ifdef NTP_HAVE_AVX2
    static evidence other;
    const void *bytes = e, *others = &other;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return;
    gather_by(ntp__gather_evidence_avx2, &other, texels, width);
    CHECK(memcmp(bytes, others, sizeof other) == 0);
#endif
}

static bool close_to(double a, double b)
{
    double off = a - b, most = 1e-9 * (b < 0 ? -b : b);
    return off <= most && -off <= most;
}

/* Counts are the same, sums nearly. */
static void compare(const evidence *a, const evidence *b)
{
    CHECK(a->all == b->all && a->right == b->right && a->count == b->count);
    CHECK(a->tilted == b->tilted && a->derived == b->derived && a->too_long == b->too_long);
    CHECK(a->negative == b->negative && a->level == b->level && a->beside == b->beside);
    CHECK(a->pile[0] == b->pile[0] && a->pile[1] == b->pile[1]);
    CHECK(close_to(a->lengths, b->lengths) && close_to(a->longer, b->longer));
    CHECK(close_to(a->rest, b->rest) && close_to(a->rest2, b->rest2));
    CHECK(close_to(a->z2, b->z2) && close_to(a->z4, b->z4) && close_to(a->both, b->both));
    CHECK(close_to(a->negative2, b->negative2));
    CHECK(close_to(a->unorm.sum, b->unorm.sum) && close_to(a->trunc.sum, b->trunc.sum));
}

int main(void)
{
    static uint8_t texels[3 * TEXELS];
    static evidence rows, one_row, narrow;
    for (int32_t i = 0; i < TEXELS; i++) {
        int32_t near = random_below(3) > 0;
        for (int32_t c = 0; c < 3; c++)
            texels[3 * i + c] = (uint8_t) (near ? 112 + random_below(32) : 1 + random_below(254));
    }
    gather(&rows, texels, WIDTH);
    gather(&one_row, texels, TEXELS);
    gather(&narrow, texels, TEXELS / 250);
    CHECK(rows.right > 0 && rows.tilted > 0 && rows.negative > 0 && rows.too_long > 0);
    compare(&rows, &one_row);
    compare(&narrow, &one_row);
    return 0;
}
