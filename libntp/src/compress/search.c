/* SPDX-License-Identifier: MIT */
/*
 * search.c - the best ends of a block of one channel, by trying lines
 *
 * Lines of one length are tried sixteen at once.  What cannot be better than the best line until
 * now is left out, by two bounds that hold for any line:
 *   - Texels beyond an end are off by their distance from it.  So the low end has a highest place,
 *     and the high end a lowest.
 *   - Texels that take k different values have at least the error of the best k groups of them
 *     (neighbors in sorted order, each about its mean).  A long line has few values among the
 *     texels.
 * Sums are in float.  Lines that come near to the best are summed again in double, where sums for
 * plain levels are exact: sixteen squares of integers below 2^22.
 */
#include "compress/search.h"

#include <math.h>
#include <string.h>

enum {
    M16 = 65535,
    LEVEL = 257, /* a level of an end, in 16-bit levels */
    TOP = 255,
    NEAR = 2,                    /* lengths beside the range, of the first lines */
    FIRST_LINES = NTP__LANES / 2 /* places below the least texel */
};

/* Float sums of 16 squares, with rounding of each step, are off by less. */
static const double FLOAT_SLACK = 1 + 1.0 / 65536;

/* Errors are in 16-bit levels squared. */
typedef struct search {
    double value[NTP__TEXELS], weight[NTP__TEXELS]; /* sorted, equal ones together */
    int32_t count;
    float cost[NTP__TEXELS][NTP__TEXELS + 1]; /* of texels i..j-1 about their mean */
    double groups[NTP__VALUES + 1];           /* the error of the best so many groups */
    double cap[NTP__TEXELS];
    ntp__lines lines;
    ntp__try_lines_fn *try_lines;
    int32_t parts;
    double best;
    ntp__ends ends;
} search;

static double square(double x)
{
    return x * x;
}

static void sort(search *s, const ntp__wanted *wanted)
{
    int32_t n = 0;
    for (int i = 0; i < NTP__TEXELS; i++) {
        const double v = wanted->level[i], w = wanted->weight[i];
        int32_t at = n;
        if (w <= 0)
            continue;
        while (at > 0 && s->value[at - 1] > v)
            at--;
        if (at > 0 && s->value[at - 1] >= v) {
            s->weight[at - 1] += w;
            continue;
        }
        for (int32_t k = n; k > at; k--) {
            s->value[k] = s->value[k - 1];
            s->weight[k] = s->weight[k - 1];
        }
        s->value[at] = v;
        s->weight[at] = w;
        n++;
    }
    s->count = n;
}

/* The costs of all groups that end at the same texel at once. */
static void find_costs(search *s)
{
    double weight[NTP__TEXELS] = { 0 }, mean[NTP__TEXELS] = { 0 }, error[NTP__TEXELS] = { 0 };
    for (int32_t i = 0; i < NTP__TEXELS; i++)
        for (int32_t j = 0; j <= NTP__TEXELS; j++)
            s->cost[i][j] = INFINITY;
    for (int32_t j = 0; j < s->count; j++) {
        const double value = s->value[j], w = s->weight[j];
        for (int32_t i = 0; i <= j; i++) {
            const double d = value - mean[i];
            weight[i] += w;
            mean[i] += d * w / weight[i];
            error[i] += w * d * (value - mean[i]);
        }
        for (int32_t i = 0; i <= j; i++)
            s->cost[i][j + 1] = (float) error[i];
    }
}

/*
 * The least error of the texels in so many groups: the last group begins at each texel in turn.
 * Where the line is divided in fifths, the first texels may be at 0 and the last at 65535.
 */
static void find_groups(search *s)
{
    float least[NTP__TEXELS + 1], next[NTP__TEXELS + 1], after[NTP__TEXELS + 1];
    const bool ends = s->parts == 5;
    const int32_t n = s->count;
    for (int32_t i = 0; i <= NTP__TEXELS; i++)
        least[i] = after[i] = INFINITY;
    least[0] = after[n] = 0;
    for (int32_t i = 0; i < n; i++)
        least[i + 1] = ends ? least[i] + (float) (s->weight[i] * square(s->value[i])) : INFINITY;
    for (int32_t i = n; i-- > 0;)
        after[i] =
            ends ? after[i + 1] + (float) (s->weight[i] * square(M16 - s->value[i])) : INFINITY;
    for (int32_t k = 1; k <= s->parts + 1; k++) {
        memcpy(next, least, sizeof next);
        for (int32_t i = 0; i < n; i++) {
            const float before = least[i];
            for (int32_t j = 1; j <= NTP__TEXELS; j++)
                next[j] = before + s->cost[i][j] < next[j] ? before + s->cost[i][j] : next[j];
        }
        memcpy(least, next, sizeof least);
        s->groups[k] = INFINITY;
        for (int32_t j = 0; j <= n; j++)
            s->groups[k] = least[j] + after[j] < s->groups[k] ? least[j] + after[j] : s->groups[k];
        s->groups[k] /= FLOAT_SLACK;
    }
}

/* Can a texel be at 0 or 65535 in a better block?  Otherwise the groups are as without these. */
static bool may_take_ends(const search *s)
{
    const int32_t last = s->count - 1;
    return s->weight[0] * square(s->value[0]) < s->best ||
           s->weight[last] * square(M16 - s->value[last]) < s->best;
}

/* The error of one line. */
static double error_of(const search *s, int32_t low, int32_t length)
{
    const double step = LEVEL * length, from = (double) s->parts * LEVEL * low;
    double sum = 0;
    for (int32_t i = 0; i < s->count; i++) {
        const double at = s->parts * s->value[i] - from;
        double k = at / step;
        k = k > 0 ? k : 0;
        k = k < s->parts ? k : s->parts;
        const double error = square(at - (int32_t) (k + 0.5) * step);
        sum += s->weight[i] * (error < s->cap[i] ? error : s->cap[i]);
    }
    return sum / (s->parts * s->parts);
}

static void set_best(search *s, double best)
{
    s->best = best;
    s->lines.enough = (float) (best * (s->parts * s->parts) * FLOAT_SLACK);
}

/* Tries the lines of one length from `low` on. */
static void try_from(search *s, int32_t low, int32_t length, int32_t count)
{
    float error[NTP__LANES];
    const float level = (float) (s->parts * LEVEL);
    if (s->try_lines(error, &s->lines, (float) low * level, level) >= s->lines.enough)
        return;
    for (int32_t l = 0; l < count && l < NTP__LANES; l++) {
        if (error[l] >= s->lines.enough)
            continue;
        const double exact = error_of(s, low + l, length);
        if (exact < s->best) {
            set_best(s, exact);
            s->ends = (ntp__ends) { low + l, low + l + length, s->parts };
        }
    }
}

static void set_length(search *s, int32_t length)
{
    s->lines.step = (float) (LEVEL * length);
}

static void set_parts(search *s, int32_t parts)
{
    s->parts = parts;
    s->lines.count = s->count;
    s->lines.last = (float) parts;
    for (int32_t i = 0; i < s->count; i++) {
        const double v = s->value[i], end = v < M16 - v ? v : M16 - v;
        s->cap[i] = parts == 5 ? square(parts * end) : 1e30;
        s->lines.value[i] = (float) (parts * v);
        s->lines.weight[i] = (float) s->weight[i];
        s->lines.cap[i] = (float) s->cap[i];
    }
    set_best(s, s->best);
}

static int32_t clamped(int32_t v, int32_t most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

/* Lines about as long as the range of the texels. */
static void try_near(search *s)
{
    const int32_t low = (int32_t) (s->value[0] / LEVEL);
    const int32_t high = (int32_t) ((s->value[s->count - 1] + LEVEL - 1) / LEVEL);
    for (int32_t length = high - low - NEAR; length <= high - low + NEAR; length++) {
        if (length < 1 || length > TOP)
            continue;
        const int32_t from = clamped(low - FIRST_LINES, TOP - length);
        set_length(s, length);
        try_from(s, from, length, TOP - length - from + 1);
    }
}

/* The error of a texel that lies by `beyond` outside the line. */
static double outside(const search *s, int32_t i, double beyond)
{
    const double error = square(beyond), cap = s->cap[i] / (s->parts * s->parts);
    return s->weight[i] * (error < cap ? error : cap);
}

/* Is the error of the texels below `low`, or above `high`, already too much? */
static bool leaves_out(const search *s, int32_t low, int32_t high)
{
    double error = 0;
    for (int32_t i = 0; i < s->count && s->value[i] < LEVEL * low; i++)
        error += outside(s, i, LEVEL * low - s->value[i]);
    for (int32_t i = s->count; i-- > 0 && s->value[i] > LEVEL * high;)
        error += outside(s, i, s->value[i] - LEVEL * high);
    return error >= s->best;
}

/* The highest low end, and the lowest high end, that can be better than the best line. */
static void find_bounds(const search *s, int32_t *low_most, int32_t *high_least)
{
    int32_t low = (int32_t) (s->value[0] / LEVEL);
    int32_t high = (int32_t) (s->value[s->count - 1] / LEVEL) + 1;
    low = clamped(low, TOP - 1);
    high = clamped(high, TOP);
    while (low < TOP - 1 && !leaves_out(s, low + 1, TOP))
        low++;
    while (high > 1 && !leaves_out(s, 0, high - 1))
        high--;
    *low_most = low;
    *high_least = high;
}

/* Can any line of this length or longer be better? */
static bool may_be_better(const search *s, int32_t length)
{
    const double range = s->value[s->count - 1] - s->value[0];
    const int32_t values = (int32_t) (range * s->parts / (LEVEL * length)) + 2;
    return s->groups[values <= s->parts ? values : s->parts + 1] < s->best;
}

static void try_all(search *s)
{
    int32_t low_most = TOP - 1, high_least = 1;
    double known = -1;
    for (int32_t length = 1; length <= TOP; length++) {
        if (known != s->best)
            find_bounds(s, &low_most, &high_least);
        known = s->best;
        if (high_least - low_most > length)
            length = high_least - low_most;
        if (!may_be_better(s, length))
            return;
        int32_t from = high_least - length;
        from = from < 0 ? 0 : from;
        const int32_t most = low_most < TOP - length ? low_most : TOP - length;
        set_length(s, length);
        for (; from <= most; from += NTP__LANES)
            try_from(s, from, length, most - from + 1);
    }
}

ntp__ends ntp__search_ends(const ntp__wanted *wanted, bool all)
{
    search s;
    s.try_lines = ntp__try_lines_for(NTP__CPU_ALL);
    s.best = 1e30;
    s.ends = (ntp__ends) { 0, 1, 7 };
    sort(&s, wanted);
    if (s.count == 0)
        return s.ends;
    for (int32_t parts = 7; parts >= 5; parts -= 2) {
        set_parts(&s, parts);
        try_near(&s);
    }
    if (!all || s.best <= 0)
        return s.ends;
    find_costs(&s);
    for (int32_t parts = 7; parts >= 5; parts -= 2) {
        set_parts(&s, parts);
        if (parts == 7 || may_take_ends(&s))
            find_groups(&s);
        try_all(&s);
    }
    return s.ends;
}

void ntp__palette(int32_t palette[NTP__VALUES], const ntp__ends *ends)
{
    const int32_t part = NTP__PARTS / ends->parts * LEVEL;
    for (int32_t k = 0; k <= ends->parts; k++)
        palette[k] = part * ((ends->parts - k) * ends->low + k * ends->high);
    if (ends->parts == 5) {
        palette[6] = 0;
        palette[7] = NTP__PARTS * M16;
    }
}
