/* SPDX-License-Identifier: MIT */
/*
 * resize_strip.c - resizes RGB strip by strip
 *
 * Each source row of a strip is read once and kept until no row of the result needs it: as floats,
 * or as int16_t if AVX2 makes them of 8 bit.  Its levels have 17 bits with their sign, so they are
 * exact.  Sums of rows are doubles, which are exact too (resize.c); sums of columns are doubles as
 * well.
 *
 * With AVX2 packed pixels are made of sums in floats where these are exact, as they mostly are for
 * sides of mip levels.  Those of 8 bit are so anyway; what cannot be decided is summed in doubles.  Where
 * the width is halved, all eight texels around it are summed exactly instead (resize_exact_avx2.c).
 *
 * How far such sums are off, where u = 2^-24: a weight and its product are rounded, and so is each
 * sum of terms.  With k terms for the rows and l for the columns, of which every other one is added
 * to another sum (resize_avx2.c), that is k + l/2 + 4 times u of the greatest sum there can be.  Rows
 * of int16_t are summed exactly and then rounded once, with weights that are off by less than u/8 of
 * their greatest sum.  So k/8 + 2 stands for k there.
 *
 * Where AVX2 halves the width, rows are runs of x, y and z of even and odd columns: no lane is spent
 * on the weights unless a texel is unused.  Both columns that have a weight are added first.  That is
 * one sum more before the product, and the last sum of the two halves less, so the bound stays.
 */
#include "base/cpu.h"
#include "base/inlining.h"
#include "reshape/resize_strip.h"

#include <math.h>
#include <string.h>

extern const ntp__resize_kernels ntp__resize_loops_base, ntp__resize_loops_avx2;

static const ntp__resize_kernels *loops(void)
{
    return NTP__CPU_PICK(NTP__CPU_ALL, ntp__resize_loops_base, ntp__resize_loops_avx2);
}

size_t ntp__strip_size(const ntp_resize_plan *plan)
{
    if (plan->x.stride > MOST_TAPS + 1 || plan->y.stride > MOST_TAPS + 1)
        return 0;
    return NTP__LINE + sizeof(ntp__strip) + (size_t) plan->y.stride * 4 * PADDED * sizeof(float);
}

static int32_t end_of(const ntp__axis *axis, int32_t x)
{
    return axis->span[x].first + axis->span[x].count;
}

static void choose_floats(const ntp__resize_job *j)
{
    ntp__strip *s = j->strip;
    const bool can = ntp__cpu_has_avx2(NTP__CPU_ALL);
    s->placed = can && ntp__is_packed(j->src) &&
                (j->src->type == NTP_TYPE_U8 || j->src->type == NTP_TYPE_U16);
    s->whole = s->placed && j->src->type == NTP_TYPE_U8;
    s->in_floats = can && j->most < 0x1p24;
    s->packed = can && j->dst->pixel_stride == 3 * ntp__sample_size(j->dst->type) &&
                (j->dst->type == NTP_TYPE_U8 || (j->dst->type == NTP_TYPE_U16 && s->in_floats));
#ifdef NTP_HAVE_AVX512
    s->wide = ntp__cpu_has_avx512(NTP__CPU_ALL);
#endif
    s->pause = 0;
}

/* Can the rows be runs?  Then the weights of all texels are the same ones, and symmetric. */
static bool can_be_halved(const ntp__resize_job *j)
{
    enum { MOST = 16 /* taps */, LEAST = 32 /* texels, as resize_kernels.h says */ };
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->x;
    const int32_t taps = s->taps_x;
    const size_t size = (size_t) taps * sizeof s->weight[0];
    bool can = s->packed && s->placed && s->n >= LEAST && axis->src == 2 * axis->dst &&
               taps <= MOST && taps == axis->span[s->x0].count;
    for (int32_t i = 1; can && i < s->n; i++)
        can = memcmp(s->weight, s->weight + i * taps, size) == 0;
    for (int32_t t = 0; can && t < taps / 2; t++)
        can = s->weight[t] == s->weight[taps - 1 - t];
    return can;
}

int32_t ntp__strip_begin(const ntp__resize_job *j, int32_t x0, int32_t x1)
{
    ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->x;
    int32_t end = x0, k = 0;
    choose_floats(j);
    const double scale = axis->scale * (s->whole ? 0x1p-14 : 1); /* as sums of whole rows are */
    const int32_t most = NTP__BLOCK + (s->placed ? MORE : 0);
    s->taps_x = 0;
    for (; end < x1 && end - x0 < WIDEST && end_of(axis, end) - axis->span[x0].first <= most; end++)
        s->taps_x = axis->span[end].count > s->taps_x ? axis->span[end].count : s->taps_x;
    s->taps_x += s->taps_x % 2;
    s->x0 = x0;
    s->n = end - x0;
    s->first = axis->span[x0].first;
    s->columns = end_of(axis, end - 1) - s->first;
    s->rows = j->plan->y.stride;
    for (int32_t i = 0; i < s->n; i++) {
        const ntp__span_of_taps span = axis->span[x0 + i];
        const int32_t *from = axis->weight + (ptrdiff_t) (x0 + i) * axis->stride;
        s->at[i] = span.first - s->first;
        for (int32_t t = 0; t < s->taps_x; t++, k++) {
            s->weight[k] = t < span.count ? *from++ : 0;
            s->weight_in_float[k] = (float) (s->weight[k] * scale);
        }
    }
    s->halved = can_be_halved(j);
    ntp__strip_forget(s);
    return end;
}

/* So it is where the sides are halved. */
static bool is_symmetric(const int32_t *weight, int32_t taps)
{
    bool same = taps % 2 == 0;
    for (int32_t t = 0; same && t < taps / 2; t++)
        same = weight[t] == weight[taps - 1 - t];
    return same;
}

/* The rows that make one of the result, and their weights. */
typedef struct sources {
    const float *rows[MOST_TAPS + 2];
    int32_t weight[MOST_TAPS + 2];
    int32_t taps;
    ntp__strip_row any;
    bool symmetric;
} sources;

static void find_sources(const ntp__resize_job *j, sources *from, int32_t y)
{
    const ntp__axis *axis = &j->plan->y;
    const int32_t taps = axis->span[y].count;
    from->any = ntp__strip_rows(j, from->rows, y);
    memcpy(from->weight, axis->weight + (ptrdiff_t) y * axis->stride,
           (size_t) taps * sizeof from->weight[0]);
    from->weight[taps] = 0;
    from->rows[taps] = from->rows[0];
    from->taps = taps + taps % 2;
    from->symmetric = is_symmetric(from->weight, taps);
}

#ifdef NTP_HAVE_AVX2
#  ifdef NTP_HAVE_AVX512
#    define PICK(s, function) ((s)->wide ? function##_avx512 : function##_avx2)
#  else
#    define PICK(s, function) function##_avx2
#  endif

/* The weights of whole rows, times scale. */
static void split_weights(ntp__whole_weights *to, const sources *from, double scale)
{
    const int32_t end = from->symmetric ? from->taps / 2 : from->taps;
    to->n = end + end % 2;
    for (int32_t t = 0; t < to->n; t++) {
        const int32_t s = t < end ? t : 0, w = t < end ? (int32_t) (from->weight[s] * scale) : 0;
        to->row[t] = from->rows[s];
        to->other[t] = from->rows[from->symmetric ? from->taps - 1 - s : s];
        to->upper[t] = (int16_t) (w >> 15);
        to->lower[t] = (int16_t) (w & 32767);
    }
}
#endif

/* Sums of `count` numbers from `first` on, a multiple of 8. */
static void sum_in_doubles(ntp__strip *s, const sources *from, int32_t first, int32_t count)
{
    const float *rows[MOST_TAPS + 2];
#ifdef NTP_HAVE_AVX2
    if (s->whole) {
        ntp__whole_weights to;
        split_weights(&to, from, 1);
        ntp__add_whole_avx2(s->sums, &to, from->symmetric ? 1 : 0.5, first, count);
        return;
    }
#endif
    for (int32_t t = 0; t < from->taps; t++)
        rows[t] = from->rows[t] + first;
    (from->symmetric ? loops()->add_pairs : loops()->add_rows)(s->sums + first, rows, from->weight,
                                                               from->taps, count);
}

/* Is a negative z of texel i no z of a source?  Only Lanczos has weights below 0. */
static bool overshot(const ntp__resize_job *j, const sources *from, int32_t i, int32_t y)
{
    return j->plan->how.filter == NTP_FILTER_LANCZOS3 &&
           !(from->any.negative && ntp__strip_any_negative(j, from->rows, i, y));
}

/*
 * n vectors, of texels at[0].. (NULL: all), and what is to be done about them; returns how many are
 * inexact.  Of what is not known to be other than 0, the last 32 bits are all.
 *
 * How far a component in doubles is off: with 2k weights by k + 1 times 2^-53 of the greatest sum there can be, as a
 * product is rounded once, and then k times in sums.  That is less than 2^30.
 */
static int32_t judge_vectors(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact,
                             double *total, const sources *from, const int32_t *at, int32_t n,
                             int32_t row)
{
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->x;
    const double error = j->most < 0x1p53 ? 0 : j->most * (s->taps_x + 1) * 0x1p-53;
    /* A component over the length is off by 2^-33, as kernels.h says. */
    const double least = error * error * 0x1p66;
    double *const c[4] = { v->c[0], v->c[1], v->c[2], total };
    int32_t low[4][NTP__BLOCK], found = 0;
    bool small = false;
    for (int32_t q = 0; error > 0 && q < 4; q++) {
        for (int32_t k = 0; !small && k < n; k++)
            small = fabs(c[q][k]) <= error;
    }
    for (int32_t k = 0, end = at == NULL ? 1 : n; small && k < end; k++) {
        const int32_t i = at == NULL ? 0 : at[k];
        loops()->add_low_bits(&low[0][k], s->sums, &s->at[i], axis->span + s->x0 + i,
                              axis->weight + (ptrdiff_t) (s->x0 + i) * axis->stride, axis->stride,
                              at == NULL ? n : 1);
    }
    for (int32_t q = 0; small && q < 4; q++) {
        for (int32_t k = 0; k < n; k++) {
            if (fabs(c[q][k]) <= error)
                c[q][k] = low[q][k];
        }
    }
    for (int32_t k = 0; k < n; k++) {
        const double x = c[0][k], y = c[1][k], z = c[2][k], square = x * x + y * y + z * z;
        inexact[k] = total[k] > 0 && square > error * error && square <= least;
        /* Negative weights of Lanczos can outweigh the others where many texels are unused. */
        if (total[k] <= 0)
            v->c[0][k] = v->c[1][k] = v->c[2][k] = 0;
        else if (z < 0 && overshot(j, from, at == NULL ? k : at[k], row))
            v->c[2][k] = 0;
        found += inexact[k];
    }
    return found;
}

#ifdef NTP_HAVE_AVX2
/* Packed pixels of vectors first.. to n - 1 (resize_kernels.h). */
static int32_t pack_directions(const ntp__resize_job *j, int32_t *at, const ntp__planes *p,
                               int32_t y, int32_t first, int32_t n, float error)
{
    void *d = ntp__at_mut(j->dst, j->strip->x0, y);
    const bool zzero = j->dst->encoding == NTP_ENCODING_ZZERO;
#  ifdef NTP_HAVE_AVX512
    if (j->strip->wide && j->m == 255 && !zzero)
        return ntp__pack_directions_avx512(d, at, p, first, n, error);
#  endif
    return ntp__pack_directions_avx2(d, at, p, first, n, error, j->m > 255, zzero);
}

/* Sums in floats; returns how far a component may be off. */
static float sum_in_floats(const ntp__resize_job *j, ntp__planes *p, float least[4],
                           const sources *from)
{
    ntp__strip *s = j->strip;
    const ntp__axis *x = &j->plan->x, *y = &j->plan->y;
    const double u = 0x1p-24;
    const int32_t k = from->symmetric ? from->taps / 2 : from->taps;
    const int32_t terms = (s->whole ? k / 8 + 2 : k) + s->taps_x / 2 + 4;
    const int32_t planes = from->any.holes ? 4 : 3;
    const int32_t count = s->halved ? 2 * planes * NTP__RUN : 4 * s->columns;
    if (s->whole) {
        ntp__whole_weights to;
        split_weights(&to, from, y->scale * (from->symmetric ? 0x1p29 : 0x1p28));
        PICK(s, ntp__sum_whole)(s->sums_in_float, &to, count);
    } else
        ntp__sum_rows_avx2(s->sums_in_float, from->rows, from->weight, (float) y->scale, from->taps,
                           from->symmetric, count);
    least[3] = INFINITY;
    if (s->halved)
        ntp__sum_halves_avx2(p, least, s->sums_in_float, s->weight_in_float, s->taps_x, s->n,
                             planes);
    else
        ntp__sum_columns_avx2(p, least, s->sums_in_float, s->at, s->weight_in_float, s->taps_x,
                              s->n);
    return s->in_floats ? 0 : (float) (terms * u * (j->most * x->scale * y->scale));
}

/* Which texels there may be. */
typedef struct judged {
    bool below, holes;
} judged;

/* Of texels first.. to n - 1: those that are made of unused ones, or whose z is negative; makes red of the uncertain a
 * NaN.  `marks` are there where `any` is given. */
ONE_COPY static void judge_planes(const ntp__resize_job *j, ntp__planes *p,
                                  const ntp__plane_marks *marks, const judged *any, float error,
                                  int32_t first, int32_t n)
{
    if (any->below || any->holes)
        ntp__judge_planes_avx2(p, marks, (float) j->m, error, any->holes, first, n);
}

static judged mark_texels(const ntp__resize_job *j, ntp__plane_marks *marks, const ntp__planes *p,
                          const float least[4], float error, const sources *from, int32_t y)
{
    enum { Z = 4, WEIGHT = 6 /* where runs begin */ };
    const ntp__strip *s = j->strip;
    const bool overshoots = j->plan->how.filter == NTP_FILTER_LANCZOS3;
    const bool runs = s->whole && s->halved;
    const judged any = { least[2] <= error && (error > 0 || overshoots), least[3] <= error };
    const size_t size = sizeof marks->below;
    if (!any.below && !any.holes)
        return any;
    memset(marks->used, 1, size);
    memset(marks->below, overshoots ? 0 : -1, size);
    if (runs && any.holes && error > 0)
        ntp__any_of_halves_avx2(marks->used, from->rows, from->weight, from->taps, s->taps_x / 2,
                                WEIGHT, s->n);
    if (!any.below || !overshoots || !from->any.negative)
        return any;
    if (runs)
        ntp__any_of_halves_avx2(marks->below, from->rows, from->weight, from->taps, s->taps_x / 2,
                                Z, s->n);
    for (int32_t i = 0; !runs && i < s->n; i++)
        marks->below[i] = p->c[2][i] < 0 && ntp__strip_any_negative(j, from->rows, i, y) ? -1 : 0;
    return any;
}

/* Texel i as it is exactly, where the floats of exact sums do not decide it. */
static void put_exactly(const ntp__resize_job *j, const ntp__whole_sums *exact,
                        const ntp__planes *p, int32_t i, int32_t y)
{
    uint8_t *d = ntp__at_mut(j->dst, j->strip->x0 + i, y);
    int32_t levels[3];
    ntp__i128 sum[3];
    for (int32_t k = 0; k < 3; k++)
        sum[k] = ntp__i128_add(
            ntp__i128_shift(ntp__i128_of((int64_t) (exact->high[k][i] * 0x1p-20)), 20),
            ntp__i128_of((int64_t) exact->low[k][i]));
    if (p->c[2][i] == 0) /* or overshot */
        sum[2] = ntp__i128_of(0);
    ntp__direction_levels(levels, sum, j->m, j->src->encoding);
    for (int32_t k = 0; k < 3; k++)
        d[k] = (uint8_t) levels[k];
}

/* The texels in doubt, at[0].., of whole rows that are runs, with all others of the same eight; returns how many are
 * done.  Where pairs of rows are the same one, sums are twice as great, which changes no direction. */
static int32_t settle_halves(const ntp__resize_job *j, ntp__planes *p,
                             const ntp__plane_marks *marks, const judged *any, const sources *from,
                             const int32_t *at, int32_t found, int32_t y)
{
    enum { EIGHT = 8 };
    ntp__strip *s = j->strip;
    const int32_t planes = any->holes ? 4 : 3;
    ntp__whole_weights weights;
    ntp__whole_sums exact;
    int32_t done = 0;
    split_weights(&weights, from, 1);
    for (int32_t k = 0; k < found;) {
        const int32_t first = at[k] & -EIGHT;
        int32_t end = first + EIGHT, left[WIDEST];
        for (; k < found && at[k] < end + EIGHT; k++)
            end = (at[k] & -EIGHT) + EIGHT;
        end = end < s->n ? end : s->n;
        for (int32_t run = 0; run < 2 * planes; run++)
            ntp__add_whole_avx2(s->sums, &weights, 1, run * NTP__RUN + first,
                                end - first + s->taps_x / 2);
        PICK(s, ntp__sum_exactly)
        (&exact, p, s->sums, s->weight, s->taps_x, first, end, planes);
        judge_planes(j, p, marks, any, 0, first, end);
        const int32_t n = pack_directions(j, left, p, y, first, end, 0);
        for (int32_t i = 0; i < n; i++)
            put_exactly(j, &exact, p, left[i], y);
        done += end - first;
    }
    return done;
}

/* The sums of some texels in doubles. */
static void sum_again(const ntp__resize_job *j, ntp__vectors *v, double *total, const sources *from,
                      const int32_t *at, int32_t n)
{
    ntp__strip *s = j->strip;
    for (int32_t k = 0; k < n; k++) {
        const int32_t i = at[k], columns = j->plan->x.span[s->x0 + i].count;
        ntp__vectors one;
        sum_in_doubles(s, from, 4 * s->at[i], (4 * columns + 7) / 8 * 8);
        loops()->add_columns(&one, &total[k], s->sums, &s->at[i], s->weight + i * s->taps_x,
                             s->taps_x, 1);
        for (int32_t c = 0; c < 3; c++)
            v->c[c][k] = one.c[c][0];
    }
}

int32_t ntp__strip_packed(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact, int32_t *at,
                          int32_t y)
{
    enum { PAUSE = 8, MANY = 4 };
    ntp__strip *s = j->strip;
    double total[NTP__BLOCK];
    float least[4];
    ntp__planes p;
    ntp__plane_marks marks;
    sources from;
    const bool exactly = s->halved && !s->in_floats, pauses = s->packed && s->pause-- > 0;
    if (!s->packed || (pauses && !exactly))
        return -1;
    find_sources(j, &from, y);
    if (pauses) {
        least[2] = -INFINITY;
        least[3] = from.any.holes ? -INFINITY : INFINITY;
        const judged any = mark_texels(j, &marks, &p, least, 1, &from, y);
        for (int32_t i = 0; i < s->n; i++)
            at[i] = i;
        settle_halves(j, &p, &marks, &any, &from, at, s->n, y);
        return 0;
    }
    s->pause = 0;
    const float error = sum_in_floats(j, &p, least, &from);
    const judged any = mark_texels(j, &marks, &p, least, error, &from, y);
    judge_planes(j, &p, &marks, &any, error, 0, s->n);
    const int32_t found = pack_directions(j, at, &p, y, 0, s->n, error);
    if (exactly) {
        if (settle_halves(j, &p, &marks, &any, &from, at, found, y) > s->n / 2)
            s->pause = PAUSE;
        return 0;
    }
    /* What floats hold is not summed again, however much of it is left. */
    if (found > s->n / MANY && !s->in_floats) {
        s->pause = PAUSE;
        return -1;
    }
    if (s->in_floats) {
        const double unit = 1 / (j->plan->x.scale * j->plan->y.scale);
        for (int32_t k = 0; k < found; k++) {
            inexact[k] = 0;
            for (int32_t c = 0; c < 3; c++)
                v->c[c][k] = p.c[c][at[k]] * unit;
        }
        return found;
    }
    sum_again(j, v, total, &from, at, found);
    judge_vectors(j, v, inexact, total, &from, at, found, y);
    return found;
}
#else
int32_t ntp__strip_packed(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact, int32_t *at,
                          int32_t y)
{
    (void) j, (void) v, (void) inexact, (void) at, (void) y;
    return -1;
}
#endif

int32_t ntp__strip_vectors(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact, int32_t y)
{
    ntp__strip *s = j->strip;
    sources from;
    double total[NTP__BLOCK];
    find_sources(j, &from, y);
    sum_in_doubles(s, &from, 0, (4 * s->columns + 7) / 8 * 8);
    loops()->add_columns(v, total, s->sums, s->at, s->weight, s->taps_x, s->n);
    return judge_vectors(j, v, inexact, total, &from, NULL, s->n, y);
}

void ntp__strip_exactly(const ntp__resize_job *j, ntp__i128 sum[3], const ntp__vectors *v,
                        int32_t k, int32_t i)
{
    enum { LIFT = 65536 }; /* makes the upper half positive, so that a cast is a floor */
    const ntp__strip *s = j->strip;
    const double *weight = s->weight + i * s->taps_x;
    for (int32_t c = 0; c < 3; c++) {
        const double *column = s->sums + 4 * s->at[i] + c;
        uint64_t low = 0;
        for (int32_t t = 0; t < s->taps_x; t++, column += 4)
            low += (uint64_t) (int64_t) weight[t] * (uint64_t) (int64_t) *column;
        /* The vector is off by much less than half of 2^64. */
        const double high = (v->c[c][k] - (double) low) * 0x1p-64;
        sum[c].lo = low;
        sum[c].hi = (uint64_t) ((int64_t) (high + LIFT + 0.5) - LIFT);
        if (v->c[c][k] == 0) /* or overshot */
            sum[c] = ntp__i128_of(0);
    }
}
