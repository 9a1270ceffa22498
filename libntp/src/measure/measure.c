/* SPDX-License-Identifier: MIT */
/*
 * measure.c - one pass over the texels, into a tally; see tally.h for the idea
 */
#include "measure/tally.h"

#include "base/cpu.h"
#include "base/inlining.h"
#include "texel/kernels_avx512.h"
#include "texel/level.h"

#include <string.h>

size_t ntp_tally_size(void)
{
    return sizeof(ntp_tally);
}

/* Unused colors, judged many at once: the last one, and how often it came; those before it. */
typedef struct unused_colors {
    int32_t c[3];
    uint32_t count;
    ntp__color_batch narrow, wide;
} unused_colors;

static void no_unused(unused_colors *unused)
{
    unused->count = 0;
    unused->narrow.n = unused->wide.n = 0;
}

static void end_run(ntp_tally *t, unused_colors *unused, int32_t m)
{
    const int32_t *c = unused->c;
    const ntp_encoding as = ntp__judged_as((ntp_encoding) t->encoding);
    const bool narrow = c[0] % 257 == 0 && c[1] % 257 == 0 && c[2] % 257 == 0;
    if (m == 255 || narrow) {
        const int32_t by = m == 255 ? 1 : 257, at8[] = { c[0] / by, c[1] / by, c[2] / by };
        ntp__put_color(&t->transparent_narrow, &unused->narrow, at8, unused->count, 255, as);
    }
    if (m != 255) {
        t->is_wide |= !narrow;
        ntp__put_color(&t->transparent_wide, &unused->wide, c, unused->count, m, as);
    }
    unused->count = 0;
}

static void end_unused(ntp_tally *t, unused_colors *unused, int32_t m)
{
    const ntp_encoding as = ntp__judged_as((ntp_encoding) t->encoding);
    if (unused->count == 0)
        return;
    end_run(t, unused, m);
    ntp__end_batch(&t->transparent_narrow, &unused->narrow, 255, as);
    ntp__end_batch(&t->transparent_wide, &unused->wide, m, as);
}

static void add_levels(ntp__channel_sums *sums, uint32_t level)
{
    sums->sum += level;
    if (level > sums->max)
        sums->max = level;
    if (~level > sums->inverted_min)
        sums->inverted_min = ~level;
}

static void merge_levels(ntp__channel_sums *into, const ntp__channel_sums *from)
{
    into->sum += from->sum;
    ntp__merge_max(&into->max, from->max);
    ntp__merge_max(&into->inverted_min, from->inverted_min);
}

static void add_color(ntp_tally *t, int32_t r, int32_t g, int32_t b)
{
    add_levels(&t->channel[0], (uint32_t) r);
    add_levels(&t->channel[1], (uint32_t) g);
    add_levels(&t->channel[2], (uint32_t) b);
}

static void add_transparent(ntp_tally *t, unused_colors *unused, int32_t r, int32_t g, int32_t b,
                            int32_t m)
{
    t->transparent++;
    t->gray -= r == g && g == b; /* counted on the way here */
    if (unused->count > 0 && (unused->c[0] != r || unused->c[1] != g || unused->c[2] != b))
        end_run(t, unused, m);
    unused->c[0] = r;
    unused->c[1] = g;
    unused->c[2] = b;
    unused->count++;
}

/* Counts a gray texel; true: it is black or white, and unused for that. */
static inline bool count_black_white(ntp_tally *t, int32_t v, int32_t m)
{
    t->gray++;
    if (v == 0 && !(t->touched & NTP_UNUSED_BLACK)) {
        t->black++;
        return true;
    }
    if (v == m && !(t->touched & NTP_UNUSED_WHITE)) {
        t->white++;
        return true;
    }
    return false;
}

/* Storing it again would be waited for. */
static inline void note_far(ntp_tally *t, uint32_t row, uint32_t b)
{
    const uint32_t quarter = (uint32_t) NTP__SEEN_QUARTER << b / NTP__QUARTER;
    if (!(t->cells.at.row_seen[row] & quarter))
        t->cells.at.row_seen[row] |= (uint8_t) quarter;
}

static void count_far(ntp_tally *t, uint32_t entry, uint32_t b)
{
    uint32_t row = ntp__entry_cells(entry) / NTP__NEAR;
    ntp__count_far(&t->cells.at, row * NTP__ROW_CELLS + b, 1);
    note_far(t, row, b);
}

/* Before the first texels that are counted by count_color, which notes no rows. */
static inline void begin_look_ups(ntp_tally *t)
{
    if (!t->cells.rows_ready)
        ntp__rows_prepare(&t->cells);
    t->cells.unnoted = 1;
}

/* Counts a color, and notes its row. */
static void count_noted(ntp_tally *t, int32_t r, int32_t g, int32_t b)
{
    uint32_t pair = (uint32_t) (r | g << 8);
    uint32_t entry = t->cells.rows_ready ? t->cells.row_of[pair] : ntp__find_row(&t->cells, r, g);
    uint32_t cells = ntp__entry_cells(entry), place = (uint32_t) b - ntp__entry_first(entry);
    if (place < NTP__NEAR) {
        t->cells.at.near[cells + place]++;
        t->cells.at.row_seen[cells / NTP__NEAR] |= NTP__SEEN_NEAR;
    } else {
        count_far(t, entry, (uint32_t) b);
    }
}

/* Used texels of 8-bit content, to be counted many at once. */
typedef struct narrow_texels {
    uint8_t rgb[3 * NTP__BLOCK];
    int32_t n;
} narrow_texels;

static inline void add_narrow(narrow_texels *to, int32_t r, int32_t g, int32_t b)
{
    uint8_t *const p = to->rgb + 3 * to->n++;
    p[0] = (uint8_t) r;
    p[1] = (uint8_t) g;
    p[2] = (uint8_t) b;
}

/* X*X + Y*Y <= M*M at 8 bit. */
static inline bool in_disc8(int32_t a, int32_t b)
{
    return ntp__rest(a, b, 255) >= 0;
}

#include "measure/packed8_tmpl.h"

/* Is this level one of 8 bit times 257?  Then its two bytes are equal. */
static inline bool is_narrow(int32_t level)
{
    return (level >> 8) == (level & 255);
}

static void add_alpha(ntp_tally *t, int32_t a, int32_t m)
{
    t->alpha[m == 255 ? a : ntp__narrow(a)]++;
    if (m == 255)
        return;
    add_levels(&t->alpha_levels, (uint32_t) a);
    t->wide_alpha_ends[0] += a == 0;
    t->wide_alpha_ends[1] += a == m;
}

static void note_color(ntp_tally *t, int32_t r, int32_t g, int32_t b)
{
    if (t->colors == 0) {
        t->color[0] = (uint32_t) r;
        t->color[1] = (uint32_t) g;
        t->color[2] = (uint32_t) b;
        t->colors = 1;
    } else if (t->colors == 1 && (t->color[0] != (uint32_t) r || t->color[1] != (uint32_t) g ||
                                  t->color[2] != (uint32_t) b)) {
        t->colors = 2;
    }
}

static void note_flat(ntp_tally *t, int32_t r, int32_t g, int32_t b)
{
    if (r < 32767 || r > 32768 || g < 32767 || g > 32768)
        return;
    t->wide_flat++;
    t->wide_flat_seen[((r - 32767) | (g - 32767) << 1) * 8192 + (b >> 3)] |=
        (uint8_t) (1 << (b & 7));
}

/* Used 16-bit texels, c[0..2] of the block, that are not 8-bit content. */
static void count_wide(ntp_tally *t, ntp__block *block, int32_t n)
{
    const ntp_encoding as = ntp__judged_as((ntp_encoding) t->encoding);
    if (as == NTP_ENCODING_STANDARD)
        ntp__add_close_block(&t->wide, &t->close, &t->far, block, n);
    else
        ntp__add_block(&t->wide, block, NULL, n, 65535, as);
}

static void count_narrow(ntp_tally *t, packed_counts *counts, const narrow_texels *texels)
{
    const uint8_t *const p = texels->rgb;
    const uint64_t gray = t->gray; /* these were counted on the way here */
    if (!t->cells.few) {
        count_packed8(t, counts, p, texels->n, 3);
        t->gray = gray;
        return;
    }
    t->narrow += (uint32_t) texels->n;
    for (int32_t i = 0; i < texels->n; i++)
        count_noted(t, p[3 * i], p[3 * i + 1], p[3 * i + 2]);
}

static void add_planes(ntp_tally *t, const ntp__survey *survey)
{
    for (int32_t k = 0; k < 3; k++) {
        ntp__channel_sums *sums = &t->channel[k];
        sums->sum += survey->sum[k];
        ntp__merge_max(&sums->max, survey->greatest[k]);
        ntp__merge_max(&sums->inverted_min, ~survey->least[k]);
    }
}

#include "measure/split16_tmpl.h"

/* Alpha of texels, and how many have green and alpha on the disc: of all, or of used ones. */
static void count_alpha(ntp_tally *t, const ntp__block *block, int32_t n, int32_t m, bool all)
{
    for (int32_t i = 0; i < n; i++) {
        const int32_t g = block->c[1][i], a = block->c[3][i];
        add_alpha(t, a, m);
        t->is_wide |= m != 255 && !is_narrow(a);
        if (a == m || (!all && ((block->any_broken && block->broken[i]) ||
                                ntp__unused(block->c[0][i], g, block->c[2][i], a, m, t->touched))))
            continue;
        const int32_t a8 = m == 255 ? a : ntp__narrow(a), g8 = m == 255 ? g : ntp__narrow(g);
        t->ag_in_disc += in_disc8(a8, g8);
    }
}

/* Texels whose levels are in the sums of channels, but for what of them is not finite. */
static void count_each(ntp_tally *t, packed_counts *counts, ntp__block *block, int32_t n, int32_t m)
{
    unused_colors unused;
    narrow_texels narrow;
    int32_t wide = 0;
    no_unused(&unused);
    narrow.n = 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i], a = block->c[3][i];
        if (block->any_broken && block->broken[i]) {
            t->not_finite++;
            continue;
        }
        if (block->any_broken)
            add_color(t, r, g, b);
        if (r == g && g == b && count_black_white(t, b, m))
            continue;
        if (a == 0 && !(t->touched & NTP_UNUSED_TRANSPARENT)) {
            add_transparent(t, &unused, r, g, b, m);
            continue;
        }
        if (m == 255) {
            add_narrow(&narrow, r, g, b);
            continue;
        }
        block->c[0][wide] = r;
        block->c[1][wide] = g;
        block->c[2][wide++] = b;
    }
    end_unused(t, &unused, m);
    if (narrow.n > 0)
        count_narrow(t, counts, &narrow);
    const uint64_t gray = t->gray; /* these were counted on the way here */
    count_opaque16(t, counts, block, wide);
    t->gray = gray;
}

/* All but alpha; `opaque`: no texel is unused for that. */
static void count_planes(ntp_tally *t, packed_counts *counts, ntp__block *block, int32_t n,
                         int32_t m, bool opaque)
{
    if (!block->any_broken) {
        ntp__survey survey;
        ntp__kernels(NTP__CPU_ALL)->survey(&survey, block->c[0], block->c[1], block->c[2], n);
        add_planes(t, &survey);
        /* As mostly, these are all for count_wide, and none is flat: nothing is left for each. */
        if (m == 65535 && opaque && survey.odd == 0) {
            t->is_wide = 1;
            count_wide(t, block, n);
            return;
        }
        if (m == 65535 && opaque) {
            count_opaque16(t, counts, block, n);
            return;
        }
    }
    count_each(t, counts, block, n, m);
}

static void count_block(ntp_tally *t, packed_counts *counts, ntp__block *block, int32_t n,
                        int32_t m)
{
    if (t->channels == 4)
        count_alpha(t, block, n, m, false);
    count_planes(t, counts, block, n, m, t->channels == 3);
}

#include "measure/packed16_tmpl.h"

/* Pictures and heights: their channels are described, and nothing is judged. */
static void count_picture(ntp_tally *t, ntp__block *block, int32_t n, int32_t m)
{
    const int32_t *const r = block->c[0], *const g = block->c[1], *const b = block->c[2];
    ntp__survey survey;
    kinds16 kinds;
    ntp__kernels(NTP__CPU_ALL)->survey(&survey, block->c[0], block->c[1], block->c[2], n);
    add_planes(t, &survey);
    find_kinds(&kinds, block, n, 0);
    t->gray += (uint32_t) kinds.gray;
    t->is_wide |= m != 255 && (kinds.some & IS_WIDE);
    if (t->channels == 2 || t->channels == 4)
        count_alpha(t, block, n, m, true);
    for (int32_t i = 0; block->any_broken && i < n; i++)
        t->not_finite += block->broken[i];
    for (int32_t i = 0; t->colors < 2 && i < n; i++)
        note_color(t, r[i], g[i], b[i]);
}

/* The same of packed bytes of one channel.  Any three of them are added up as a color is. */
static void count_gray8(ntp_tally *t, const uint8_t *p, int32_t n)
{
    ntp__channel_sums before[3];
    memcpy(before, t->channel, sizeof before);
    memset(t->channel, 0, sizeof t->channel);
    add_bytes(t, p, n / 3, 3);
    for (int32_t i = n / 3 * 3; i < n; i++)
        add_levels(&t->channel[0], p[i]);
    for (int32_t k = 1; k < 3; k++)
        merge_levels(&t->channel[0], &t->channel[k]);
    for (int32_t k = 2; k >= 0; k--) {
        merge_levels(&before[k], &t->channel[0]);
        t->channel[k] = before[k];
    }
    t->gray += (uint32_t) n;
    for (int32_t i = 0; t->colors < 2 && i < n; i++)
        note_color(t, p[i], p[i], p[i]);
}

/* Looks for a second used color.  Only images of one color are searched to the end. */
static void note_colors(ntp_tally *t, const ntp__block *block, int32_t n, int32_t m)
{
    if (n == NTP__BLOCK && !ntp__may_differ(t, block, m))
        return;
    for (int32_t i = 0; i < n && t->colors < 2; i++) {
        int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i];
        if ((!block->any_broken || !block->broken[i]) &&
            !ntp__unused(r, g, b, block->c[3][i], m, t->touched))
            note_color(t, r, g, b);
    }
}

/* Are all texels so far of the one color that is noted? */
static bool has_one_color(const ntp_tally *t)
{
    bool one = t->colors == 1;
    for (int32_t k = 0; k < 3; k++)
        one = one && t->channel[k].max == ~t->channel[k].inverted_min;
    return one;
}

static void note_row(ntp_tally *t, const ntp_const_image *src, int32_t x0, int32_t x1, int32_t y)
{
    ntp__block block;
    for (int32_t x = x0; x < x1 && t->colors < 2; x += NTP__BLOCK) {
        int32_t n = x1 - x < NTP__BLOCK ? x1 - x : NTP__BLOCK;
        ntp__unpack(&block, src, x, y, n);
        note_colors(t, &block, n, ntp__max(src->type));
    }
}

static void count_row(ntp_tally *t, waiting *w, packed_counts *packed, const ntp_const_image *src,
                      int32_t x0, int32_t x1, int32_t y)
{
    bool picture = src->encoding == NTP_ENCODING_HEIGHT;
    bool bytes = !picture && !t->cells.few && src->type == NTP_TYPE_U8 && src->channels >= 3 &&
                 ntp__is_packed(src);
    bool words = src->encoding == NTP_ENCODING_STANDARD && src->type == NTP_TYPE_U16 &&
                 src->channels >= 3 && ntp__is_packed(src) && w->count_exact != NULL;
    bool gray = picture && src->type == NTP_TYPE_U8 && src->channels == 1 && ntp__is_packed(src);
    int32_t m = ntp__max(src->type), step = bytes || gray ? x1 - x0
                                            : words       ? RGBA_AT_ONCE
                                                          : NTP__BLOCK;
    const uint64_t used = t->narrow + t->wide.texels;
    for (int32_t x = x0, n; x < x1; x += n) {
        n = x1 - x < step ? x1 - x : step;
        if (gray) {
            count_gray8(t, ntp__at(src, x, y), n);
        } else if (bytes) {
            count_packed8(t, packed, ntp__at(src, x, y), n, src->channels);
        } else if (words && src->channels == 4) {
            count_rgba16(t, w, src, x, y, n);
        } else if (words) {
            n = x1 - x;
            count_words(t, w, ntp__at(src, x, y), n);
        } else {
            ntp__block block;
            ntp__unpack(&block, src, x, y, n);
            if (picture)
                count_picture(t, &block, n, m);
            else
                count_block(t, &w->narrow, &block, n, m);
        }
    }
    if (t->colors < 2)
        end_survey(t, packed);
    if (!picture && t->colors < 2 && (w->n > 0 || t->narrow + t->wide.texels > used) &&
        !has_one_color(t))
        note_row(t, src, x0, x1, y);
    ntp__sample_row(t, src, x0, x1, y);
}

/* Makes the tally one of this kind of image; an error: it is one of another kind. */
static ntp_status adopt(ntp_tally *t, const ntp_const_image *src, uint32_t touch, uint64_t texels)
{
    uint32_t depth = src->type == NTP_TYPE_U8 ? 8 : 16;
    if (touch > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    if (t->depth != 0) {
        if (t->depth != depth || t->channels != (uint32_t) src->channels ||
            t->encoding != (uint32_t) src->encoding || t->touched != touch)
            return NTP_ERR_FORMAT;
    }
    if (t->texels + texels > UINT32_MAX)
        return NTP_ERR_SHAPE;
    t->depth = depth;
    t->channels = (uint32_t) src->channels;
    t->encoding = (uint32_t) src->encoding;
    t->touched = touch;
    return NTP_OK;
}

ntp_status ntp_tally_add(ntp_tally *tally, const ntp_const_image *src, uint32_t touch_unused,
                         const ntp_rect *area)
{
    if (tally == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_view(src));
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    uint64_t width = (uint64_t) (rect.x1 - rect.x0), height = (uint64_t) (rect.y1 - rect.y0);
    NTP__TRY(adopt(tally, src, touch_unused, width * height));
    tally->cells.few = !tally->cells.unnoted && tally->texels + width * height <= NTP__FEW;
    tally->summed = 0;
    waiting left;
    left.n = left.noise = left.n_hidden = 0;
    left.count_exact = exact_kernel();
    left.block.any_broken = left.hidden.any_broken = left.clear = false;
    for (int32_t i = 0; i < NTP__BLOCK; i++)
        left.block.c[3][i] = 65535;
    packed_counts packed;
    begin_packed(&packed, touch_unused, false);
    begin_packed(&left.narrow, touch_unused, true);
    left.narrow.alpha.visible = 0; /* colors of alpha 0 are counted apart */
    for (int32_t y = rect.y0; y < rect.y1; y++)
        count_row(tally, &left, &packed, src, rect.x0, rect.x1, y);
    end_survey(tally, &packed);
    end_waiting(tally, &left, true);
    end_hidden(tally, &left, true);
    if (src->channels == 4) {
        end_alpha(tally, &packed.alpha);
        end_alpha(tally, &left.narrow.alpha);
    }
    tally->texels += width * height;
    return NTP_OK;
}
