/* SPDX-License-Identifier: MIT */
/*
 * find_steps.c - do slopes come in steps, as those of heights with few levels do?
 *
 * If heights are whole numbers, each slope is a whole multiple of one step.  A texel tells its
 * slope up to rounding: an interval.  So the intervals of sampled texels are sorted, and steps are
 * tried: does nearly every interval hold a multiple, where few would by chance?  The multiples of a
 * step are called a comb, and each multiple a tooth.  Three things look alike and are told apart:
 * levels that are evenly spaced themselves (an image of fewer bits), domes whose slope grows by the
 * same amount at each texel, and planes with a few angles.
 */
#include "base/view.h"
#include "texel/angle.h"
#include "texel/level.h"

#include <string.h>

enum {
    SAMPLES = 4096,
    STRETCHES = SAMPLES / NTP__BLOCK * 4,
    EVERY = 4, /* one texel in so many is sampled: neighbors tell the same */
    FEW = 512, /* samples that steps are tried on first */
    LEAST_SAMPLES = 100,
    LEAST_TEETH = 4,      /* multiples that occur: beveled tiles have fewer angles */
    MANY_TEETH = 8,       /* planes do not have so many */
    LEAST_IN_A_TOOTH = 2, /* samples */
    LEAST_AT_A_PLACE = 2, /* samples that rounding does not tell apart; single ones are outliers */
    LEAST_MOVES = 100,
    ENCODERS = 4
};

/* The share of samples between the multiples: pasted parts, edges of masks. */
static const double OUTLIERS = 0.03, LEAST_SHARE = 0.95;
/* The sum of the logarithms of likelihood ratios, over places that differ.  Among thousands of
 * drawn textures without steps, those with enough teeth reached 5 on both axes at most. */
static const double LEAST_EVIDENCE = 15;
/* The share of it that evenly spaced levels may explain. */
static const double MOST_LEVEL_EVIDENCE = 0.25;
/* The finest step that is tried is the one that so many samples hit by chance. */
static const double MOST_CHANCE = 0.5;
static const double FINER = 0.99; /* from a step to the next that is tried */
/* The share of moves from tooth to tooth that differ from the move before.  It is 0.25 for domes
 * and waves of even curvature, and 0.6 and more for quantized surfaces. */
static const double LEAST_UNEVEN = 0.5;
static const double MOST_RUN = 4; /* texels in a row on one tooth other than 0, on average */
static const double SAME_STEP = 0.01;
static const double LEAST_REST = 0.04; /* z = 0.2: steeper texels tell little */

/* The values that |x|, or the slope that belongs to it, may have had before rounding. */
typedef struct sample {
    float low, high;
} sample;

/* How texels are read.  `along` is the channel that holds the component along the rows. */
typedef struct reader {
    const ntp_const_image *src;
    uint32_t touch;
    int32_t along;
    int32_t max;   /* of the levels, of one bit depth with the image */
    int32_t unit;  /* 257: 8 bit in a 16-bit image */
    int32_t zero;  /* x is (2 c - zero) / range */
    int32_t range; /* and may be off by half / range */
    double half;
    bool sine; /* samples are x itself, not the slope */
} reader;

/* How well multiples of a step fit. */
typedef struct comb {
    double step, share, expected, evidence;
    int32_t teeth;
} comb;

/* What is found along one axis. */
typedef struct axis_steps {
    comb comb;
    bool found;
} axis_steps;

/* ------------------------------------------------------------------------ reading */

static int32_t stretch_length(const ntp_const_image *src)
{
    return src->width < NTP__BLOCK ? src->width : NTP__BLOCK;
}

/* Narrow images have more stretches, with as many texels in all. */
static int32_t stretches_of(const ntp_const_image *src)
{
    int32_t most = STRETCHES * NTP__BLOCK / stretch_length(src);
    return most < src->height ? most : src->height;
}

/* Reads the stretch k of `count`; the golden section scatters where they begin. */
static void read_stretch(ntp__block *b, const ntp_const_image *src, int32_t k, int32_t count)
{
    int32_t n = stretch_length(src), room = src->width - n;
    int32_t x = (int32_t) ((int64_t) k * 40503 % 65536 * room / 65536);
    ntp__unpack(b, src, x, (int32_t) ((int64_t) k * src->height / count), n);
}

static void bounds(double *low, double *high, const reader *r, int32_t level)
{
    int32_t twice = 2 * (level / r->unit) - r->zero;
    double v = twice < 0 ? -twice : twice;
    *low = v > r->half ? (v - r->half) / r->range : 0;
    *high = (v + r->half) / r->range;
}

/* False: the texel holds no normal, or a steep one. */
static bool take(sample *s, const reader *r, const ntp__block *b, int32_t i)
{
    int32_t red = b->c[0][i], green = b->c[1][i];
    double x0, x1, y0, y1;
    if ((b->any_broken && b->broken[i]) ||
        ntp__unused(red, green, b->c[2][i], b->c[3][i], r->max, r->touch))
        return false;
    bounds(&x0, &x1, r, r->along == 0 ? red : green);
    bounds(&y0, &y1, r, r->along == 0 ? green : red);
    double rest = 1 - x1 * x1 - y1 * y1;
    if (rest < LEAST_REST)
        return false;
    s->low = (float) (r->sine ? x0 : x0 / sqrt(1 - x0 * x0 - y0 * y0));
    s->high = (float) (r->sine ? x1 : x1 / sqrt(rest));
    return true;
}

static float middle2(const sample *s)
{
    return s->low + s->high;
}

/* Shell sort, by the middles of the intervals. */
static void sort(sample *s, int32_t n)
{
    static const int32_t GAPS[] = { 1750, 701, 301, 132, 57, 23, 10, 4, 1 };
    for (size_t g = 0; g < sizeof GAPS / sizeof GAPS[0]; g++) {
        int32_t gap = GAPS[g];
        for (int32_t i = gap; i < n; i++) {
            sample moved = s[i];
            int32_t k = i;
            for (; k >= gap && middle2(&s[k - gap]) > middle2(&moved); k -= gap)
                s[k] = s[k - gap];
            s[k] = moved;
        }
    }
}

/* Fills s and returns the number of samples. */
static int32_t gather(sample s[SAMPLES], const reader *r)
{
    ntp__block b;
    int32_t count = stretches_of(r->src), length = stretch_length(r->src), n = 0;
    for (int32_t k = 0; k < count; k++) {
        read_stretch(&b, r->src, k, count);
        for (int32_t i = k % EVERY; i < length && n < SAMPLES; i += EVERY)
            n += take(&s[n], r, &b, i);
    }
    return n;
}

/* --------------------------------------------------------------------------- combs */

static int32_t tooth_of(const sample *s, double step)
{
    return (int32_t) ((double) middle2(s) / (2 * step) + 0.5);
}

static bool holds(const sample *s, double v)
{
    return (double) s->low <= v && v <= (double) s->high;
}

/* ln x to 1e-4, x > 0.  What it decides lies far apart, so that is enough. */
static double logarithm(double x)
{
    static const double LN_2 = 0.693147180559945;
    double sum = 0;
    while (x > 1.5) {
        x /= 2;
        sum += LN_2;
    }
    while (x < 0.75) {
        x *= 2;
        sum -= LN_2;
    }
    double t = (x - 1) / (x + 1), t2 = t * t;
    return sum + 2 * t * (1 + t2 * (1 / 3.0 + t2 / 5));
}

/* The chance that an interval like this one holds a multiple. */
static double chance_of(const sample *s, double step)
{
    double width = (double) s->high - (double) s->low;
    double chance = (s->low > 0 ? width : 2 * width) / step; /* about 0 it is folded */
    return chance < 1 - OUTLIERS ? chance : 1 - OUTLIERS;
}

/* The step near `step` that agrees with nearly all samples, narrowed down by one after the other;
 * 0: there is none. */
static double refined(const sample *s, int32_t n, double step)
{
    double low = step * (1 + FINER) / 2, high = step * (3 - FINER) / 2;
    int32_t misses = 0, most = (int32_t) (2 * OUTLIERS * n);
    for (int32_t i = 0; i < n; i++) {
        int32_t tooth = tooth_of(&s[i], (low + high) / 2);
        if ((double) s[i].low > tooth * high || (double) s[i].high < tooth * low) {
            if (++misses > most)
                return 0;
        } else if (tooth > 0) {
            double least = (double) s[i].low / tooth, greatest = (double) s[i].high / tooth;
            low = least > low ? least : low;
            high = greatest < high ? greatest : high;
        }
    }
    return (low + high) / 2;
}

/* How well multiples of the step fit.  Samples that rounding does not tell apart are of one place,
 * and a place counts once. */
static comb fit_of(const sample *s, int32_t n, double step)
{
    comb c = { .step = step };
    int32_t hits = 0, last = -1, in_tooth = 0;
    for (int32_t i = 0; i < n;) {
        int32_t first = i;
        float end = middle2(&s[i]) + (s[i].high - s[i].low);
        double sum = 0;
        for (; i < n && middle2(&s[i]) <= end; i++) {
            int32_t tooth = tooth_of(&s[i], step);
            double chance = chance_of(&s[i], step);
            bool hit = holds(&s[i], tooth * step);
            c.expected += chance;
            sum += hit ? logarithm((1 - OUTLIERS) / chance) : logarithm(OUTLIERS / (1 - chance));
            if (!hit)
                continue;
            hits++;
            in_tooth = tooth == last ? in_tooth + 1 : 1;
            last = tooth;
            c.teeth += tooth > 0 && in_tooth == LEAST_IN_A_TOOTH;
        }
        if (i - first >= LEAST_AT_A_PLACE)
            c.evidence += sum / (i - first);
    }
    c.share = (double) hits / n;
    c.expected /= n;
    return c;
}

/* The best comb with a step of least..most.  All samples are sorted only if a comb fits a few. */
static comb best_comb(sample *s, int32_t n, double least, double most)
{
    sample few[FEW];
    comb best = { 0 };
    int32_t m = 0;
    for (int32_t i = 0; i < FEW && i < n; i++)
        few[m++] = s[n <= FEW ? i : (int32_t) ((int64_t) i * n / FEW)];
    sort(few, m);
    double step = most;
    while (step >= least) {
        double exact = refined(few, m, step);
        step *= FINER;
        if (exact == 0)
            continue;
        comb c = fit_of(few, m, exact);
        if (c.evidence > best.evidence)
            best = c;
    }
    if (best.step == 0)
        return best;
    sort(s, n);
    return fit_of(s, n, best.step);
}

/* ------------------------------------------------------------------------ how they lie */

/* How slopes move from tooth to tooth along the stretches. */
typedef struct moves {
    int64_t pairs, uneven; /* moves that follow another; those of them that differ from it */
    int64_t runs, texels;  /* runs of texels on one tooth that is not 0, and their texels */
} moves;

static void add_moves(moves *m, const reader *r, const ntp__block *b, double step)
{
    int32_t n = stretch_length(r->src), last = 0, before = 0;
    bool known = false;
    for (int32_t i = 0; i < n; i++) {
        sample s;
        bool taken = take(&s, r, b, i);
        int32_t tooth = taken ? tooth_of(&s, step) : 0;
        if (!taken || !holds(&s, tooth * step)) {
            known = false;
            before = 0;
            continue;
        }
        if (2 * (b->c[r->along][i] / r->unit) < r->zero)
            tooth = -tooth;
        int32_t move = known ? tooth - last : 0;
        m->texels += tooth != 0;
        m->runs += tooth != 0 && (!known || move != 0);
        if (move != 0) {
            m->pairs += before != 0;
            m->uneven += before != 0 && move != before;
            before = move;
        }
        last = tooth;
        known = true;
    }
}

static bool lie_as_rounded(const reader *r, const comb *c)
{
    ntp__block b;
    moves m = { 0 };
    int32_t count = stretches_of(r->src);
    for (int32_t k = 0; k < count; k++) {
        read_stretch(&b, r->src, k, count);
        add_moves(&m, r, &b, c->step);
    }
    return m.pairs >= LEAST_MOVES && (double) m.uneven >= LEAST_UNEVEN * (double) m.pairs &&
           (c->teeth >= MANY_TEETH || (double) m.texels <= MOST_RUN * (double) m.runs);
}

/* ----------------------------------------------------------------------------- judging */

/* Would levels that are evenly spaced themselves explain the comb? */
static bool levels_explain(sample s[SAMPLES], const reader *r, const comb *c)
{
    reader plain = *r;
    plain.sine = true;
    int32_t n = gather(s, &plain);
    comb levels = best_comb(s, n, 0.7 * c->step, 1.05 * c->step);
    return levels.evidence > MOST_LEVEL_EVIDENCE * c->evidence;
}

static axis_steps find_axis(const reader *r)
{
    sample s[SAMPLES];
    axis_steps axis = { 0 };
    double width = 0, farthest = 0;
    int32_t n = gather(s, r);
    if (n < LEAST_SAMPLES)
        return axis;
    for (int32_t i = 0; i < n; i++) {
        width += (double) s[i].high - (double) s[i].low;
        farthest = (double) s[i].high > farthest ? (double) s[i].high : farthest;
    }
    axis.comb = best_comb(s, n, width / n / MOST_CHANCE, farthest / LEAST_TEETH);
    const comb *c = &axis.comb;
    axis.found = c->teeth >= LEAST_TEETH && c->share >= LEAST_SHARE &&
                 c->evidence >= LEAST_EVIDENCE && !levels_explain(s, r, c) && lie_as_rounded(r, c);
    return axis;
}

/* Is every level one of 8 bit? */
static bool is_of_8_bits(const ntp_const_image *src)
{
    ntp__block b;
    int32_t count = stretches_of(src), n = stretch_length(src), rest = 0;
    for (int32_t k = 0; k < count && rest == 0; k++) {
        read_stretch(&b, src, k, count);
        for (int32_t i = 0; i < n; i++)
            rest |= b.c[0][i] % 257 | b.c[1][i] % 257;
    }
    return rest == 0;
}

/* The encoders of 8 bit: one rounds, one cuts off, and two have 128 or 127 for 0.  At 16 bit such
 * differences are small, and wider intervals allow for all. */
static void set_encoder(reader *r, int32_t encoder, bool of_8_bits)
{
    int32_t m = of_8_bits ? 255 : r->max;
    r->unit = of_8_bits ? r->max / 255 : 1;
    r->zero = m + (encoder == 2) - (encoder == 1 || encoder == 3);
    r->range = m - (encoder >= 2);
    r->half = of_8_bits ? 1 : 3;
}

static double degrees_of(double slope)
{
    const double unit = 1 << 17;
    return ntp__angle(0, 0, 1, (int64_t) (slope / (1 + slope) * unit), 0,
                      (int64_t) (unit / (1 + slope))) *
           1e-6;
}

static bool find_both(ntp_steps *steps, reader r, const ntp_const_image *src,
                      const ntp_const_image *turned)
{
    r.src = src;
    r.along = 0;
    axis_steps x = find_axis(&r);
    if (!x.found)
        return false;
    r.src = turned;
    r.along = 1;
    axis_steps y = find_axis(&r);
    double apart = x.comb.step - y.comb.step;
    if (!y.found || (apart < 0 ? -apart : apart) > SAME_STEP * x.comb.step)
        return false;
    steps->decided = 1;
    steps->teeth = x.comb.teeth < y.comb.teeth ? x.comb.teeth : y.comb.teeth;
    steps->slope = (x.comb.step + y.comb.step) / 2;
    steps->degrees = degrees_of(steps->slope);
    steps->share = x.comb.share < y.comb.share ? x.comb.share : y.comb.share;
    steps->expected = x.comb.expected > y.comb.expected ? x.comb.expected : y.comb.expected;
    return true;
}

ntp_status ntp_find_steps(ntp_steps *steps, const ntp_const_image *src, uint32_t touch_unused)
{
    if (steps == NULL || touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    if (src->ring_rows != 0)
        return NTP_ERR_SHAPE;
    const ntp_const_image turned = ntp__transposed(src);
    memset(steps, 0, sizeof *steps);
    reader r = { .touch = touch_unused, .max = ntp__max(src->type) };
    bool of_8_bits = src->type == NTP_TYPE_U8 || is_of_8_bits(src);
    for (int32_t encoder = 0; encoder < (of_8_bits ? ENCODERS : 1); encoder++) {
        set_encoder(&r, encoder, of_8_bits);
        if (find_both(steps, r, src, &turned))
            break;
    }
    return NTP_OK;
}
