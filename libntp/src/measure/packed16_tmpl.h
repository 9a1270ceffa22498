/* SPDX-License-Identifier: MIT */
/*
 * packed16_tmpl.h - counts packed RGB and RGBA of 16 bit; included by measure.c, whose counts it uses
 *
 * Exact texels are counted first, a block at a time, unless the blocks before had none.  The others of all
 * rows fill blocks of their own.  Of RGBA, the colors of texels with any alpha become RGB first.
 */

/* Those that are not exact wait here for others, whatever row these are of. */
typedef struct waiting {
    ntp__block block;
    int32_t n;
    int32_t noise;                    /* blocks to come in which exact ones are not looked for */
    ntp__count_exact_fn *count_exact; /* NULL where planes are as fast */
    ntp__block hidden;                /* colors of alpha 0 */
    int32_t n_hidden;
    bool clear;           /* the block before had texels that no alpha shows */
    packed_counts narrow; /* also counts alpha, of 16 bit rounded to 8 */
} waiting;

enum {
    NOISE = 7,
    FEW_LEFT16 = 32,
    HIDDEN = NTP__BLOCK - FEW_LEFT16,
    RGBA_AT_ONCE = 4 * NTP__BLOCK
};

/* Returns how many stay, at the front: too few to be judged together, but for the `last` time. */
ONE_COPY static int32_t count_or_keep(ntp__sums *sums, ntp__close_counts *close,
                                      ntp__far_counts *far, ntp__block *block, int32_t n, bool last)
{
    n = ntp__take_close_block(sums, close, far, block, n);
    if (n < FEW_LEFT16 && !last)
        return n;
    ntp__add_block(sums, block, NULL, n, 65535, NTP_ENCODING_STANDARD);
    return 0;
}

/* Counts them; but for the `last` time some may stay. */
static void end_waiting(ntp_tally *t, waiting *w, bool last)
{
    ntp__survey survey;
    if (w->n == 0)
        return;
    ntp__kernels(NTP__CPU_ALL)->survey(&survey, w->block.c[0], w->block.c[1], w->block.c[2], w->n);
    if (survey.odd != 0) {
        count_opaque16(t, &w->narrow, &w->block, w->n);
    } else {
        t->is_wide = 1;
        w->n = count_or_keep(&t->wide, &t->close, &t->far, &w->block, w->n, last);
        return;
    }
    w->n = 0;
}

/* Those at these places wait. */
static void wait(ntp_tally *t, waiting *w, const uint16_t *p, const int32_t *at, int32_t n)
{
    for (int32_t some; n > 0; n -= some, at += some) {
        if (w->n == NTP__BLOCK)
            end_waiting(t, w, false);
        some = n < NTP__BLOCK - w->n ? n : NTP__BLOCK - w->n;
        int32_t *const r = w->block.c[0] + w->n, *const g = w->block.c[1] + w->n,
                       *const b = w->block.c[2] + w->n;
        for (int32_t i = 0; i < some; i++) {
            const uint16_t *const c = p + 3 * at[i];
            r[i] = c[0];
            g[i] = c[1];
            b[i] = c[2];
        }
        w->n += some;
    }
}

static ntp__count_exact_fn *exact_kernel(void)
{
#ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        return ntp__count_exact_avx512;
#endif
    return ntp__kernels(NTP__CPU_ALL)->count_exact;
}

/* Standard, as most textures of 16 bit are.  Returns how many of n are done. */
static int32_t count_rgb16(ntp_tally *t, waiting *w, const uint16_t *p, int32_t n)
{
    ntp__exact_block found;
    int32_t done = n;
    found.texels = 0;
    if (n < NTP__EXACT_GROUP) {
        for (int32_t i = 0; i < n; i++) {
            add_color(t, p[3 * i], p[3 * i + 1], p[3 * i + 2]);
            found.left[i] = i;
        }
    } else {
        done = w->count_exact(&found, &t->close, p, n);
        add_planes(t, &found.survey);
        ntp__add_exact(&t->wide, &found);
        t->is_wide |= found.texels > 0;
        if (found.texels == 0)
            w->noise = NOISE;
    }
    wait(t, w, p, found.left, done - found.texels);
    return done;
}

#ifdef NTP_HAVE_AVX512
/* Where nearly all texels are far from exact these are counted straight from the pixels.  Returns how many are. */
static int32_t count_noise16(ntp_tally *t, waiting *w, const uint16_t *p, int32_t n)
{
    enum { AT_ONCE = 16 };
    ntp__survey survey;
    ntp__block left;
    kinds16 kinds;
    if (t->far.first == 0 || t->far.skip > 0 || n < AT_ONCE || !ntp__cpu_has_avx512(NTP__CPU_ALL))
        return 0;
    const int32_t others = ntp__add_far_rgb_avx512(&t->wide, &t->far, &survey, &left, p, &n);
    add_planes(t, &survey);
    t->is_wide |= others < n;
    if (others > n / 4)
        w->noise = 0; /* exact ones may have come */
    if (w->n + others > NTP__BLOCK) {
        end_waiting(t, w, others > NTP__BLOCK - FEW_LEFT16);
        t->far.first = 1; /* those of others say little of what comes */
        t->far.skip = 0;
    }
    find_kinds(&kinds, &left, others, 0);
    t->gray += survey.gray - (uint32_t) kinds.gray; /* those of others are to be counted */
    for (int32_t k = 0; k < 3; k++)
        memcpy(w->block.c[k] + w->n, left.c[k], (size_t) others * sizeof left.c[k][0]);
    w->n += others;
    return n;
}
#else
static int32_t count_noise16(ntp_tally *t, waiting *w, const uint16_t *p, int32_t n)
{
    (void) t, (void) w, (void) p, (void) n;
    return 0;
}
#endif

/* So many levels, which are to be judged after others: while these are, processors fetch nothing by themselves. */
static inline void fetch_levels(const uint16_t *p, int32_t n)
{
    enum { LINE = 64 };
    for (size_t i = 0; i < (size_t) n * sizeof *p; i += LINE)
        fetch((const uint8_t *) p, i);
}

/* Packed RGB that no alpha makes unused. */
static void count_words(ntp_tally *t, waiting *w, const uint16_t *p, int32_t n)
{
    for (int32_t done; n > 0; n -= done, p += 3 * done) {
        if (w->noise == 0 || n < NTP__EXACT_GROUP) {
            done = count_rgb16(t, w, p, n);
            continue;
        }
        if ((done = count_noise16(t, w, p, n)) > 0)
            continue;
        ntp__block block;
        const ntp_const_image row = {
            .data = p,
            .pixel_stride = 3 * sizeof *p,
            .width = n,
            .height = 1,
            .channels = 3,
            .type = NTP_TYPE_U16,
            .encoding = NTP_ENCODING_STANDARD,
        };
        w->noise--;
        done = n < NTP__BLOCK ? n : NTP__BLOCK;
        fetch_levels(p + 3 * NTP__BLOCK, NTP__BLOCK * 3);
        ntp__unpack(&block, &row, 0, 0, done);
        count_planes(t, &w->narrow, &block, done, 65535, true);
    }
}

/* What is to be known of the alpha of a block; and how many texels are used. */
typedef struct alpha16 {
    int32_t used, clear;
    uint16_t every;
    uint64_t colors; /* the bits of any that is clear */
} alpha16;

/* The colors of texels, all of which are used if none is clear. */
static alpha16 take_all(uint16_t *rgb, const uint16_t *p, int32_t n)
{
    alpha16 found = { n, 0, 65535, 0 };
    for (int32_t i = 0; i < n; i++) {
        uint64_t texel;
        memcpy(&texel, p + 4 * i, sizeof texel);
        memcpy(rgb + 3 * i, &texel, sizeof texel);
        found.every &= p[4 * i + 3];
        found.clear += p[4 * i + 3] == 0;
    }
    return found;
}

/* Those of used ones.  Texels with and without alpha may take turns, so there is no branch for each. */
static alpha16 take_used(uint16_t *rgb, const uint16_t *p, int32_t n, int32_t touched)
{
    alpha16 found = { 0, 0, 65535, 0 };
    for (int32_t i = 0; i < n; i++) {
        const uint16_t *const from = p + 4 * i;
        uint64_t texel;
        memcpy(&texel, from, sizeof texel);
        memcpy(rgb + 3 * found.used, &texel, sizeof texel);
        const int32_t is_clear = from[3] == 0;
        found.colors |= texel & (0 - (uint64_t) is_clear);
        found.clear += is_clear;
        found.every &= (uint16_t) (from[3] - is_clear); /* 65535 for 0 */
        found.used += touched | (from[3] != 0);
    }
    return found;
}

ONE_COPY static void end_hidden(ntp_tally *t, waiting *w, bool last)
{
    t->hidden |= w->n_hidden > 0;
    w->n_hidden = count_or_keep(&t->transparent_wide, &t->close_hidden, &t->far_hidden, &w->hidden,
                                w->n_hidden, last);
}

/* Those that are not of 8 bit wait for others; the rest goes to the front.  Returns how many these are. */
static int32_t wait_hidden(ntp_tally *t, waiting *w, ntp__block *block, int32_t n)
{
    int32_t at, left = 0;
    if (w->n_hidden + n > NTP__BLOCK)
        end_hidden(t, w, false);
    at = w->n_hidden;
    for (int32_t i = 0; i < n; i++) {
        const int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i];
        const int32_t is_wide = apart_from_narrow(r, g, b) != 0;
        w->hidden.c[0][at] = block->c[0][left] = r;
        w->hidden.c[1][at] = block->c[1][left] = g;
        w->hidden.c[2][at] = block->c[2][left] = b;
        at += is_wide;
        left += 1 - is_wide;
    }
    t->is_wide |= left < n;
    t->transparent += (uint32_t) (n - left);
    w->n_hidden = at;
    return left;
}

/* Alpha that is not only 0 and M.  Unused texels are not on the disc: they have an alpha of 0, or a green of 0 or M. */
static void count_alpha16(ntp_tally *t, waiting *w, const uint16_t *p, int32_t n)
{
    uint8_t narrow[4 * RGBA_AT_ONCE];
    uint32_t sum = 0, least = 65535, greatest = 0, wide = 0, full = 0;
    /* ntp__narrow in words: no difference or sum leaves them */
    for (int32_t i = 0; i < 4 * n; i++)
        narrow[i] = (uint8_t) ((uint16_t) (p[i] - (p[i] >> 8) + (p[i] >> 15) + 127) >> 8);
    for (int32_t i = 0; i < n; i++) {
        const uint32_t a = p[4 * i + 3];
        sum += a; /* below 2^26 */
        least = a < least ? a : least;
        greatest = a > greatest ? a : greatest;
        wide |= a >> 8 ^ a;
        full += a == 65535;
    }
    t->wide_alpha_ends[1] += full;
    count_alphas(t, &w->narrow.alpha, narrow, n);
    t->is_wide |= (wide & 255) != 0;
    t->alpha_levels.sum += sum;
    ntp__merge_max(&t->alpha_levels.max, greatest);
    ntp__merge_max(&t->alpha_levels.inverted_min, ~least);
}

/* Those of up to HIDDEN texels that are unused for an alpha of 0. */
static void count_hidden(ntp_tally *t, waiting *w, const uint16_t *p, int32_t n)
{
    ntp__block block;
    ntp__survey survey;
    int32_t hidden = 0;
    for (int32_t i = 0; i < n; i++, p += 4) {
        for (int32_t k = 0; k < 3; k++)
            block.c[k][hidden] = p[k];
        hidden += p[3] == 0;
    }
    if (hidden == 0)
        return;
    ntp__kernels(NTP__CPU_ALL)->survey(&survey, block.c[0], block.c[1], block.c[2], hidden);
    add_planes(t, &survey);
    const int32_t left = wait_hidden(t, w, &block, hidden);
    if (left == 0)
        return;
    memset(block.c[3], 0, sizeof block.c[3]);
    block.any_broken = false;
    count_each(t, &w->narrow, &block, left, 65535);
}

static void count_rgba16(ntp_tally *t, waiting *w, const ntp_const_image *src, int32_t x, int32_t y,
                         int32_t n)
{
    enum { M = 65535 };
    const uint16_t *const p = ntp__at(src, x, y);
    const int32_t touched = (t->touched & NTP_UNUSED_TRANSPARENT) != 0;
    uint16_t rgb[3 * RGBA_AT_ONCE + 1];
    alpha16 found = { 0 };
    if (!w->clear)
        found = take_all(rgb, p, n);
    if (w->clear || found.clear > 0)
        found = take_used(rgb, p, n, touched);
    fetch_levels(p + 4 * (size_t) n, 4 * n);
    w->clear = found.clear > 0;
    t->wide_alpha_ends[0] += (uint32_t) found.clear;
    if (found.every == M) {
        const int32_t opaque = n - found.clear;
        t->alpha[255] += (uint32_t) opaque;
        t->alpha[0] += (uint32_t) found.clear;
        t->wide_alpha_ends[1] += (uint32_t) opaque;
        t->alpha_levels.sum += (uint64_t) (uint32_t) opaque * M;
        ntp__merge_max(&t->alpha_levels.max, opaque > 0 ? M : 0);
        ntp__merge_max(&t->alpha_levels.inverted_min, ~(found.clear > 0 ? 0U : M));
    } else {
        count_alpha16(t, w, p, n);
    }
    count_words(t, w, rgb, found.used);
    if (found.used == n)
        return;
    if (found.colors == 0 && !(t->touched & NTP_UNUSED_BLACK)) {
        for (int32_t k = 0; k < 3; k++)
            add_levels(&t->channel[k], 0);
        t->gray += (uint32_t) found.clear;
        t->black += (uint32_t) found.clear;
        return;
    }
    for (int32_t i = 0; i < n; i += HIDDEN)
        count_hidden(t, w, p + 4 * i, n - i < HIDDEN ? n - i : HIDDEN);
}
