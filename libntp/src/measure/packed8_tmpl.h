/* SPDX-License-Identifier: MIT */
/*
 * packed8_tmpl.h - counts packed RGB and RGBA of 8 bit; included by measure.c, whose counts it uses
 *
 * With AVX2, texels close to exact are counted first (texel/cells_avx2.c), unless few are.  Of what
 * is left, or of all, a group of texels of one color is counted at once.  In other groups each texel is
 * one look-up and one count.
 */

#include "texel/cells_avx2.h"

enum { GROUP = 16 /* packed texels that are looked at together */ };

/* Adds sums and extremes of texels. */
static void add_survey(ntp_tally *t, const ntp__survey8 *survey)
{
    for (int32_t k = 0; k < 3; k++) {
        t->channel[k].sum += survey->sum[k];
        ntp__merge_max(&t->channel[k].max, survey->greatest[k]);
        ntp__merge_max(&t->channel[k].inverted_min, ~survey->least[k]);
    }
}

/* Sums and extremes of packed texels. */
static void add_bytes(ntp_tally *t, const uint8_t *p, int32_t n, int32_t channels)
{
    ntp__survey8 survey;
    const int32_t done = ntp__kernels(NTP__CPU_ALL)->survey8(&survey, p, n, channels);
    if (done > 0)
        add_survey(t, &survey);
    for (int32_t i = done; i < n; i++)
        add_color(t, p[channels * i], p[channels * i + 1], p[channels * i + 2]);
}

/* Are all texels of a group the same?  Each is compared with the next one, eight bytes at once. */
static inline bool is_even_rgb8(const uint8_t *p)
{
    enum { LAST = 3 * (GROUP - 1) - 8 };
    uint64_t a, b;
    for (int32_t i = 0; i <= LAST; i = i + 8 > LAST && i < LAST ? LAST : i + 8) {
        memcpy(&a, p + i, 8);
        memcpy(&b, p + i + 3, 8);
        if (a != b)
            return false;
    }
    return true;
}

static inline bool is_even_rgba8(const uint8_t *p)
{
    uint32_t texel[GROUP], all = UINT32_MAX, any = 0;
    memcpy(texel, p, sizeof texel);
    for (int32_t i = 0; i < GROUP; i++) {
        all &= texel[i];
        any |= texel[i];
    }
    return all == any;
}

/* Counts `count` texels of this color outside the near cells, where all grays are.  Returns how
 * many of them are black or white, and unused for that. */
static uint32_t count_odd(ntp_tally *t, const uint8_t *p, uint32_t entry, uint32_t count)
{
    if ((p[0] == p[1]) & (p[1] == p[2])) {
        t->gray += count;
        if (p[2] == 0 && !(t->touched & NTP_UNUSED_BLACK)) {
            t->black += count;
            return count;
        }
        if (p[2] == 255 && !(t->touched & NTP_UNUSED_WHITE)) {
            t->white += count;
            return count;
        }
    }
    uint32_t row = ntp__entry_cells(entry) / NTP__NEAR;
    t->cells.far_texels += count;
    ntp__count_far(&t->cells.at, row * NTP__ROW_CELLS + p[2], count);
    note_far(t, row, p[2]);
    return 0;
}

/* `ntp check` spends its time here and on decoding files: one look-up, one count. */
static inline uint32_t count_color(ntp_tally *t, const uint32_t *row_of, uint32_t *near,
                                   const uint8_t *p, uint32_t count)
{
    uint32_t entry = row_of[p[0] | (uint32_t) p[1] << 8];
    uint32_t place = p[2] - ntp__entry_first(entry);
    if (place >= NTP__NEAR)
        return count_odd(t, p, entry, count);
    near[ntp__entry_cells(entry) + place] += count;
    return 0;
}

/* Are many of some texels far from their derived blue, as in photographs?  Then these counts are waited for,
 * and the next texels are counted in another way.  Where few are, near cells are enough, and most memory stays
 * untouched. */
static inline bool are_many(uint64_t far, int32_t of)
{
    enum { ONE_IN = 4 };
    return far >= (uint64_t) of / ONE_IN;
}

/* Are many of the first `done` texels that were looked up, or of those before them? */
static inline bool are_far(ntp_tally *t, uint64_t far_before, int32_t done)
{
    enum { LEAST = 4 * GROUP };
    t->cells.mostly_far |= done >= LEAST && are_many(t->cells.far_texels - far_before, done);
    return t->cells.mostly_far != 0;
}

enum { CLEAR_BITS = 8 };

/* What alpha is counted by, over rows.  Colors of alpha 0 are judged once for many texels: each has one place
 * here, and gives way to another one that needs it. */
typedef struct alpha_counts {
    uint32_t color[1 << CLEAR_BITS], count[1 << CLEAR_BITS]; /* r | g << 8 | b << 16; 0: none */
    ntp__color_batch batch;
    int32_t visible;     /* the least alpha of a used texel */
    ntp__alphas8 alphas; /* of texels beside those that the tally holds */
} alpha_counts;

static void begin_alpha(alpha_counts *c, uint32_t touch)
{
    memset(c->count, 0, sizeof c->count);
    memset(&c->alphas, 0, sizeof c->alphas);
    c->batch.n = 0;
    c->visible = touch & NTP_UNUSED_TRANSPARENT ? 0 : 1;
}

static void judge_clear(ntp_tally *t, alpha_counts *c, uint32_t place)
{
    const uint32_t color = c->color[place];
    const int32_t rgb[] = { (int32_t) (color & 255), (int32_t) (color >> 8 & 255),
                            (int32_t) (color >> 16) };
    ntp__put_color(&t->transparent_narrow, &c->batch, rgb, c->count[place], 255,
                   ntp__judged_as((ntp_encoding) t->encoding));
    c->count[place] = 0;
}

static void end_alpha(ntp_tally *t, alpha_counts *c)
{
    for (uint32_t i = 0; i < 1 << CLEAR_BITS; i++) {
        if (c->count[i] > 0)
            judge_clear(t, c, i);
    }
    for (int32_t k = 0; k < 4; k++)
        ntp__merge_counts(t->alpha, c->alphas.count[k], 256);
    t->ag_in_disc += c->alphas.in_disc;
    if (c->batch.n > 0)
        ntp__end_batch(&t->transparent_narrow, &c->batch, 255,
                       ntp__judged_as((ntp_encoding) t->encoding));
}

/* Texels of alpha 0 that are unused for it, if they are not for their color. */
ONE_COPY static void count_clear(ntp_tally *t, alpha_counts *c, uint32_t color, uint32_t count)
{
    const uint32_t golden_section = 2654435769u; /* of 2^32: spreads similar colors */
    t->narrow -= count;
    if (color == 0 && !(t->touched & NTP_UNUSED_BLACK)) {
        t->gray += count;
        t->black += count;
        return;
    }
    if (color == 0xffffff && !(t->touched & NTP_UNUSED_WHITE)) {
        t->gray += count;
        t->white += count;
        return;
    }
    const uint32_t place = color * golden_section >> (32 - CLEAR_BITS);
    t->transparent += count;
    if (c->count[place] > 0 && (c->color[place] != color || c->count[place] > INT32_MAX))
        judge_clear(t, c, place);
    c->color[place] = color;
    c->count[place] += count;
}

/* Counts the alpha of `count` texels that are equal. */
static inline void count_one_alpha(ntp_tally *t, alpha_counts *c, const uint8_t *p, uint32_t count)
{
    const int32_t g = p[1], a = p[3];
    c->alphas.count[0][a] += count;
    if (a < c->visible)
        count_clear(t, c, p[0] | (uint32_t) p[1] << 8 | (uint32_t) p[2] << 16, count);
    else
        c->alphas.in_disc += in_disc8(a, g) ? count : 0;
}

/* The alpha of a row, and the colors of texels that are unused for it. */
static void count_alphas(ntp_tally *t, alpha_counts *c, const uint8_t *p, int32_t n)
{
    ntp__count_alpha8_fn *const count = ntp__kernels(NTP__CPU_ALL)->count_alpha8;
    while (n > 0) {
        const int32_t quick = count != NULL ? count(&c->alphas, p, n, c->visible) : 0;
        const uint32_t clear = c->alphas.clear;
        p += 4 * quick;
        n -= quick;
        if (clear > 0) {
            count_clear(t, c, c->alphas.color, clear);
            c->alphas.clear = 0;
            continue; /* with the next color */
        }
        const int32_t end = n < GROUP ? n : GROUP;
        const bool even = end == GROUP && is_even_rgba8(p);
        for (int32_t i = 0; !even && i < end; i++)
            count_one_alpha(t, c, p + 4 * i, 1);
        if (even)
            count_one_alpha(t, c, p, GROUP);
        p += 4 * end;
        n -= end;
    }
}

/* What packed texels are counted by, over rows. */
typedef struct packed_counts {
    ntp__count_close8_fn *close;
    ntp__count8_fn *cells;
    bool counts_only; /* levels are in the sums of channels already */
    ntp__close8_block part;
    ntp__packed_survey survey; /* is not in the tally yet */
    alpha_counts alpha;
} packed_counts;

static void begin_packed(packed_counts *c, uint32_t touch, bool counts_only)
{
    ntp__kernels_table kernels;
    ntp__pick_kernels(&kernels, NTP__CPU_ALL);
    c->close = kernels.count_close8;
    c->cells = kernels.count_cells;
    c->counts_only = counts_only;
    begin_alpha(&c->alpha, touch);
    c->part.visible = c->alpha.visible;
    c->part.found = (ntp__found8) { .used = (touch & NTP_UNUSED_BLACK ? NTP__BLACK8 : 0) |
                                            (touch & NTP_UNUSED_WHITE ? NTP__WHITE8 : 0) |
                                            (touch & NTP_UNUSED_TRANSPARENT ? NTP__CLEAR8 : 0),
                                    .survey = &c->survey };
    memset(&c->survey, 0, sizeof c->survey);
}

/* Adds what is in the survey to the tally. */
static void end_survey(ntp_tally *t, packed_counts *c)
{
    ntp__packed_survey *const s = &c->survey;
    ntp__survey8 least, all;
    if (s->texels == 0)
        return;
    ntp__kernels(NTP__CPU_ALL)->survey8(&least, s->extremes[0], sizeof s->extremes[0] / 4, 4);
    ntp__kernels(NTP__CPU_ALL)->survey8(&all, s->extremes[1], sizeof s->extremes[1] / 4, 4);
    for (int32_t k = 0; k < 3; k++) {
        all.sum[k] = s->sum[k];
        all.least[k] = 255 - least.greatest[k];
    }
    add_survey(t, &all);
    memset(s, 0, sizeof *s);
}

/* Adds alpha, sums and extremes of texels whose colors are counted one by one. */
static void add_rest(ntp_tally *t, packed_counts *c, const uint8_t *p, int32_t n, int32_t channels)
{
    if (n > 0 && !c->counts_only)
        add_bytes(t, p, n, channels);
    if (channels == 4)
        count_alphas(t, &c->alpha, p, n);
}

/* Adds the alpha of texels that a kernel just counted. */
static void add_alphas(ntp_tally *t, packed_counts *c, const uint8_t *p, int32_t n,
                       int32_t channels)
{
    if (channels == 4 && c->survey.translucent)
        count_alphas(t, &c->alpha, p, n);
    else if (channels == 4)
        c->alpha.alphas.count[0][255] += (uint32_t) n;
    c->survey.translucent = 0;
}

/* Adds what a kernel found among the grays. */
static void add_grays(ntp_tally *t, ntp__found8 *found)
{
    t->gray += found->gray;
    t->black += found->black;
    t->white += found->white;
    t->narrow -= found->black + found->white;
    found->gray = found->black = found->white = 0;
}

/* Counts whole groups of these in another way, and returns how many texels that were. */
static int32_t count_groups(ntp_tally *t, packed_counts *c, const uint8_t *p, int32_t n,
                            int32_t channels, size_t ahead)
{
    if (c->cells == NULL)
        return 0;
    const int32_t done = c->cells(&t->cells.at, &c->part.found, p, n, channels, ahead);
    t->cells.grouped |= done > 0;
    t->cells.undefined |= done > 0;
    add_grays(t, &c->part.found);
    add_alphas(t, c, p, done, channels);
    return done;
}

/* Counts close texels of the first ones of a row of texels, and returns of how many; `next` ones after them
 * are to be counted in another way.  What it leaves takes several times as long.  So where that is more than one
 * used texel in FEW_LEFT, as in photographs, close texels are looked for again later. */
static int32_t count_close(ntp_tally *t, packed_counts *c, int32_t *next, const uint8_t *p,
                           int32_t n, int32_t channels, size_t ahead)
{
    enum {
        BLOCK = 256,
        STEP = NTP__KERNEL_LANES,
        AT_ONCE = NTP__CLOSE8_AT_ONCE,
        MOST = 256 * BLOCK,
        FEW_LEFT = 4
    };
    ntp__close8_block *const part = &c->part;
    int32_t size = (n < AT_ONCE ? n : AT_ONCE) / STEP * STEP;
    part->others = part->colors = 0;
    *next = n;
    if (c->close == NULL || size == 0)
        return 0;
    if (t->not_close == 0) {
        size = c->close(part, t->cells.close, p, size, channels, ahead);
        add_alphas(t, c, p, size, channels);
        const int32_t left = part->others + part->colors;
        const int32_t used =
            size - part->hidden - (int32_t) (part->found.black + part->found.white);
        const int32_t close = used - left;
        add_grays(t, &part->found);
        t->cells.grouped |= 4 * left > size;
        if (FEW_LEFT * left <= used)
            t->last_not_close = 0;
        else if (t->last_not_close < MOST)
            t->last_not_close = 2 * t->last_not_close + BLOCK;
        if (2 * close >= size || (close > 0 && size > NTP__FEW_CLOSE)) {
            t->cells.has_close = 1;
        } else if (close > 0 && !t->cells.has_close) {
            ntp__rows_prepare(&t->cells);
            ntp__take_close8_of(&t->cells, p, size, channels);
        }
        t->not_close = t->last_not_close;
    } else {
        size = 0;
    }
    *next = n - size < t->not_close ? n - size : t->not_close;
    t->not_close -= *next;
    return size;
}

/* What is read or counted later, and would be waited for. */
static inline void fetch(const uint8_t *p, size_t ahead)
{
#ifdef __GNUC__
    __builtin_prefetch(p + ahead);
#else
    (void) p;
    (void) ahead;
#endif
}

static inline bool is_even(const uint8_t *p, int32_t channels)
{
    return channels == 3 ? is_even_rgb8(p) : is_even_rgba8(p);
}

/* Counts texels of one color, if they are to be counted. */
static inline void count_packed(ntp_tally *t, const packed_counts *c, const uint8_t *p,
                                int32_t channels, uint32_t count)
{
    if (channels == 3 || p[3] >= c->part.visible)
        t->narrow -= count_color(t, t->cells.row_of, t->cells.at.near, p, count);
}

static void look_up_packed(ntp_tally *t, packed_counts *c, const uint8_t *p, int32_t n,
                           int32_t channels, size_t ahead)
{
    const uint64_t far = t->cells.far_texels;
    int32_t i = 0;
    for (; n - i >= GROUP; i += GROUP, p += channels * GROUP) {
        if (are_far(t, far, i)) {
            const int32_t quick = count_groups(t, c, p, n - i, channels, ahead);
            if (quick > 0) {
                add_rest(t, c, p - channels * i, i, channels);
                p += channels * quick;
                n -= quick + i;
                i = 0;
                break;
            }
        }
        begin_look_ups(t);
        fetch(p, ahead);
        if (is_even(p, channels)) {
            count_packed(t, c, p, channels, GROUP);
            continue;
        }
        for (int32_t k = 0; k < GROUP; k++)
            count_packed(t, c, p + channels * k, channels, 1);
    }
    add_rest(t, c, p - channels * i, n, channels);
    if (i < n)
        begin_look_ups(t);
    for (; i < n; i++, p += channels)
        count_packed(t, c, p, channels, 1);
}

/* Far cells that are to be counted, many at once: neighbors are often alike, and would wait for each other. */
typedef struct far_waiting {
    uint32_t at[2 * 256];
    int32_t n;
} far_waiting;

static void end_far(ntp_tally *t, far_waiting *far)
{
#ifdef NTP_HAVE_AVX2
    ntp__count_each8(&t->cells.at, far->at, far->n); /* there are none without AVX2 */
#else
    (void) t;
#endif
    far->n = 0;
}

/* Counts texels that are left, but for what is put into `far`, which has room for 256: also colors with a near
 * cell, as which of them have one is as good as random. */
static void count_left(ntp_tally *t, far_waiting *far, ntp__close8_block *part, const uint8_t *p,
                       int32_t channels)
{
    t->cells.undefined |= part->others + part->colors > 0; /* only their numbers are known */
    for (int32_t i = 0; i < part->others; i++) {
        const int32_t at = part->left[i];
        part->color[part->colors++] = part->row[at] | (uint32_t) p[channels * at + 2] << 16;
    }
    for (int32_t i = 0; i < part->colors; i++) {
        const uint32_t row = part->color[i] & 65535, blue = part->color[i] >> 16;
        far->at[far->n++] = row * NTP__ROW_CELLS + blue;
        note_far(t, row, blue);
    }
}

/* Texels of a row; the colors of those that are unused for alpha 0 are not among the cells. */
static void count_packed8(ntp_tally *t, packed_counts *c, const uint8_t *p, int32_t n,
                          int32_t channels)
{
    far_waiting far;
    int32_t next;
    const size_t ahead = (size_t) channels * (size_t) n;
    far.n = 0;
    t->narrow += (uint64_t) n;
    while (n > 0) {
        const int32_t done = count_close(t, c, &next, p, n, channels, ahead);
        count_left(t, &far, &c->part, p, channels);
        if (done > 0)
            t->cells.mostly_far = 0;
        if (done > 0 && t->last_not_close > 0) /* what follows is likely to be like these */
            t->cells.mostly_far = 1;
        p += channels * done;
        if (next > 0)
            look_up_packed(t, c, p, next, channels, ahead);
        p += channels * next;
        n -= done + next;
        if (far.n > 256 || n == 0)
            end_far(t, &far);
    }
}
