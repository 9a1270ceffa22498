/* SPDX-License-Identifier: MIT */
/*
 * split16_tmpl.h - tells texels of 16 bit apart, of which each is counted in its own way; included by measure.c,
 * whose counts it uses
 *
 * In pictures that are drawn, or dithered, any of a few colors may come next.  A branch for each texel would be
 * foreseen as seldom as it is there, so lists are made without branches: all of them get each texel, and one of
 * them grows.
 */

/* A bit below 256 where any of these levels is none of 8 bit times 257. */
static inline int32_t apart_from_narrow(int32_t r, int32_t g, int32_t b)
{
    return ((r >> 8 ^ r) | (g >> 8 ^ g) | (b >> 8 ^ b)) & 255;
}

/* What a block is made of, and what each of its texels is: marks. */
enum { IS_NARROW = 1, IS_WIDE = 2, LANES16 = 16 };
typedef struct kinds16 {
    int32_t mark[NTP__BLOCK];
    int32_t gray, black, white; /* how many */
    int32_t some;               /* the bits of any mark */
} kinds16;

/* Works on whole lanes: the planes change beyond n. */
ONE_COPY static void find_kinds(kinds16 *restrict k, ntp__block *restrict block, int32_t n,
                                uint32_t touched)
{
    const int32_t black = touched & NTP_UNUSED_BLACK ? -1 : 0,
                  white = touched & NTP_UNUSED_WHITE ? -1 : 65535;
    int32_t counts = 0, some = 0; /* of gray, black and white, ten bits each */
    for (int32_t i = n; i % LANES16 != 0; i++) {
        block->c[0][i] = 0;
        block->c[1][i] = block->c[2][i] = 257; /* no gray, and none that is not of 8 bit */
    }
    for (int32_t i = 0; i < ((n + LANES16 - 1) & -LANES16); i++) {
        const int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i];
        const int32_t is_gray = ((r ^ g) | (g ^ b)) == 0;
        const int32_t is_black = is_gray & (b == black), is_white = is_gray & (b == white);
        const int32_t is_wide = apart_from_narrow(r, g, b) != 0;
        const int32_t mark = is_wide ? IS_WIDE : 1 - (is_black | is_white);
        counts += is_gray | is_black << 10 | is_white << 20;
        some |= mark;
        k->mark[i] = mark;
    }
    k->gray = counts & 1023;
    k->black = counts >> 10 & 1023;
    k->white = counts >> 20;
    k->some = some;
}

/* Texels that are finite, and that no alpha makes unused. */
static void count_opaque16(ntp_tally *t, packed_counts *counts, ntp__block *block, int32_t n)
{
    kinds16 kinds;
    narrow_texels narrow;
    int32_t wide = 0;
    find_kinds(&kinds, block, n, t->touched);
    t->gray += (uint32_t) kinds.gray;
    t->black += (uint32_t) kinds.black;
    t->white += (uint32_t) kinds.white;
    if (kinds.some & IS_NARROW) {
        int32_t few = 0;
        for (int32_t i = 0; i < n; i++) {
            uint8_t *const p = narrow.rgb + 3 * few;
            p[0] = (uint8_t) block->c[0][i];
            p[1] = (uint8_t) block->c[1][i];
            p[2] = (uint8_t) block->c[2][i];
            few += kinds.mark[i] & IS_NARROW;
        }
        narrow.n = few;
        count_narrow(t, counts, &narrow);
    }
    if (!(kinds.some & IS_WIDE))
        return;
    t->is_wide = 1;
    for (int32_t i = 0; i < n; i++) {
        for (int32_t k = 0; k < 3; k++)
            block->c[k][wide] = block->c[k][i];
        wide += kinds.mark[i] / IS_WIDE;
    }
    for (int32_t i = 0; i < wide; i++)
        note_flat(t, block->c[0][i], block->c[1][i], block->c[2][i]);
    count_wide(t, block, wide);
}
