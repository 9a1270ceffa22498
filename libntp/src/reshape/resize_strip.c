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
 * sides of mip levels.  Those of 8 bit are so anyway; what cannot be decided is summed in doubles.
 *
 * How far such sums are off, where u = 2^-24: a weight and its product are rounded, and so is each
 * sum of terms.  With k terms for the rows and l for the columns, of which every other one is added
 * to another sum (resize_avx2.c), that is k + l/2 + 4 times u of the greatest sum there can be.  Rows
 * of int16_t are summed exactly and then rounded once, with weights that are off by less than u/8 of
 * their greatest sum.  So k/8 + 2 stands for k there.
 */
#include "base/cpu.h"
#include "base/rgb_avx2.h"
#include "reshape/resize_job.h"
#include "reshape/resize_kernels.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <math.h>
#include <string.h>

enum {
    MOST_TAPS = 32,
    WIDEST = NTP__MOST_COLUMNS,
    PADDED = NTP__BLOCK + MOST_TAPS + 16, /* weights of 0 may follow the last column */
    BEYOND = 32,                          /* numbers that may be read after a row */
    NOWHERE = -(1 << 30)                  /* is no row */
};

struct ntp__strip {
    int32_t x0, n;          /* columns of the result */
    int32_t first, columns; /* of the source; they may lie outside */
    int32_t taps_x, rows;
    int32_t at[WIDEST]; /* where the columns of a texel begin */
    bool in_floats;     /* they are exact */
    bool packed;        /* rows are made of floats, as packed pixels */
    bool whole;         /* rows of the source are int16_t */
    bool same;          /* weights of columns, for all texels */
    int32_t pause;      /* rows for which that is not tried */
    double weight[WIDEST * (MOST_TAPS + 2)];
    float weight_in_float[WIDEST * (MOST_TAPS + 2)];
    double sums[4 * PADDED];
    float sums_in_float[4 * PADDED];
    int32_t held[MOST_TAPS + 1]; /* rows, which may lie outside */
    bool negative[MOST_TAPS + 1];
    float row[]; /* 4 PADDED numbers for each */
};

extern const ntp__resize_kernels ntp__resize_loops_base, ntp__resize_loops_avx2;

static const ntp__resize_kernels *loops(void)
{
    return NTP__CPU_PICK(NTP__CPU_ALL, ntp__resize_loops_base, ntp__resize_loops_avx2);
}

size_t ntp__strip_size(const ntp_resize_plan *plan)
{
    if (plan->x.stride > MOST_TAPS + 1 || plan->y.stride > MOST_TAPS + 1)
        return 0;
    return sizeof(ntp__strip) + (size_t) plan->y.stride * 4 * PADDED * sizeof(float);
}

static int32_t texel_size(const ntp__strip *s)
{
    return s->whole ? 4 * sizeof(int16_t) : 4 * sizeof(float);
}

static int32_t end_of(const ntp__axis *axis, int32_t x)
{
    return axis->span[x].first + axis->span[x].count;
}

static void choose_floats(const ntp__resize_job *j)
{
    ntp__strip *s = j->strip;
    const bool can = ntp__cpu_has_avx2(NTP__CPU_ALL);
    s->whole = can && j->src->type == NTP_TYPE_U8 && ntp__is_packed(j->src);
    s->in_floats = can && j->most < 0x1p24;
    s->packed = can && j->dst->pixel_stride == 3 * ntp__sample_size(j->dst->type) &&
                (j->dst->type == NTP_TYPE_U8 || (j->dst->type == NTP_TYPE_U16 && s->in_floats));
    s->pause = 0;
}

int32_t ntp__strip_begin(const ntp__resize_job *j, int32_t x0, int32_t x1)
{
    ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->x;
    int32_t end = x0, k = 0;
    s->taps_x = 0;
    for (; end < x1 && end - x0 < WIDEST && end_of(axis, end) - axis->span[x0].first <= NTP__BLOCK;
         end++)
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
            s->weight_in_float[k] = (float) (s->weight[k] * axis->scale);
        }
    }
    const size_t size = (size_t) s->taps_x * sizeof s->weight[0];
    s->same = true;
    for (int32_t i = 1; i < s->n; i++)
        s->same = s->same && memcmp(s->weight, s->weight + i * s->taps_x, size) == 0;
    choose_floats(j);
    memset(s->sums, 0, sizeof s->sums);
    memset(s->sums_in_float, 0, sizeof s->sums_in_float);
    for (int32_t i = 0; i < s->rows; i++)
        s->held[i] = NOWHERE;
    return end;
}

#ifdef NTP_HAVE_AVX2
/* Takes out the packed pixels that are unused. */
static void leave_out(const ntp__resize_job *j, char *to, const void *src, int32_t n)
{
    const uint32_t touch = j->plan->how.touch_unused;
    const uint8_t *s = src;
    const bool deep = j->src->type == NTP_TYPE_U16;
    for (int32_t i = 0; i < n; i++, to += texel_size(j->strip)) {
        uint16_t c[3] = { s[0], s[1], s[2] };
        if (deep)
            memcpy(c, s, sizeof c);
        s += deep ? 6 : 3;
        if ((c[0] == 0 || c[0] == j->m) && ntp__unused(c[0], c[1], c[2], j->m, j->m, touch))
            memset(to, 0, (size_t) texel_size(j->strip));
    }
}
#endif

/* With AVX2: packed pixels; false: there is another way only. */
static bool place_packed(const ntp__resize_job *j, void *to, bool *negative, int32_t x, int32_t row,
                         int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (!j->strip->whole && (j->src->type != NTP_TYPE_U16 || !ntp__is_packed(j->src) ||
                             !ntp__cpu_has_avx2(NTP__CPU_ALL)))
        return false;
    const void *from = ntp__at(j->src, x, row);
    if (!ntp__place_rgb_avx2(to, negative, from, n, j->src->type == NTP_TYPE_U16,
                             j->src->encoding == NTP_ENCODING_ZZERO))
        leave_out(j, to, from, n);
    return true;
#else
    (void) j, (void) to, (void) negative, (void) x, (void) row, (void) n;
    return false;
#endif
}

/* Reads n texels of a row from column x on; whether one has a negative z. */
static bool read_run(const ntp__resize_job *j, void *place, int32_t x, int32_t row, int32_t n)
{
    ntp__block block;
    float *to = place;
    const bool zzero = j->src->encoding == NTP_ENCODING_ZZERO;
    bool negative = false;
    if (place_packed(j, to, &negative, x, row, n))
        return negative;
    ntp__unpack(&block, j->src, x, row, n);
    const bool suspect = ntp__any_suspect(&block, n, j->m);
    for (int32_t i = 0; i < n; i++, to += 4) {
        const int32_t b = block.c[2][i];
        to[0] = (float) ntp__num(block.c[0][i], j->m);
        to[1] = (float) ntp__num(block.c[1][i], j->m);
        to[2] = (float) (zzero ? b : ntp__num(b, j->m));
        to[3] = 1;
        if (suspect && ntp__texel_unused(&block, i, j->m, j->plan->how.touch_unused))
            memset(to, 0, 4 * sizeof to[0]);
        negative = negative || to[2] < 0;
    }
    return negative;
}

/* Reads a row; columns beyond an edge one by one. */
static void read_row(const ntp__resize_job *j, char *to, bool *negative, int32_t row)
{
    const ntp__strip *s = j->strip;
    const ptrdiff_t size = texel_size(s);
    const ntp__axis *axis = &j->plan->x;
    const int32_t end = s->first + s->columns, last = end < axis->src ? end : axis->src;
    const int32_t inside = s->first > 0 ? s->first : 0;
    *negative = false;
    if (inside < last)
        *negative = read_run(j, to + size * (inside - s->first), inside, row, last - inside);
    for (int32_t x = s->first; x < end; x++) {
        float one[4 * NTP__KERNEL_LANES];
        if (x == inside && inside < last)
            x = last;
        if (x >= end)
            break;
        *negative = read_run(j, one, ntp__axis_map(axis, x), row, 1) || *negative;
        memcpy(to + size * (x - s->first), one, (size_t) size);
    }
    memset(to + size * s->columns, 0, (size_t) size * BEYOND / 4); /* so that none is a NaN */
}

/* The rows of row y of the result; whether one of them has a negative z. */
static bool get_rows(const ntp__resize_job *j, const float **rows, int32_t y)
{
    ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->y;
    bool negative = false;
    for (int32_t t = 0; t < axis->span[y].count; t++) {
        const int32_t row = axis->span[y].first + t, k = (row % s->rows + s->rows) % s->rows;
        float *to = s->row + (ptrdiff_t) k * 4 * PADDED;
        if (s->held[k] != row)
            read_row(j, (char *) to, &s->negative[k], ntp__axis_map(axis, row));
        s->held[k] = row;
        rows[t] = to;
        negative = negative || s->negative[k];
    }
    return negative;
}

/* The rows of a strip are far apart in memory, so processors do not fetch them ahead of time. */
static void fetch_ahead(const ntp__resize_job *j, int32_t y)
{
#if defined(__GNUC__)
    enum { LINE = 64 };
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->y;
    const int32_t x = s->first > 0 ? s->first : 0;
    const ptrdiff_t bytes = (s->first + s->columns - x) * j->src->pixel_stride;
    if (y + 1 >= axis->dst)
        return;
    for (int32_t row = axis->span[y].first + axis->span[y].count;
         row < axis->span[y + 1].first + axis->span[y + 1].count && row < axis->src; row++) {
        const char *from = row < 0 ? NULL : ntp__at(j->src, x, row);
        for (ptrdiff_t i = 0; from != NULL && i < bytes; i += LINE)
            __builtin_prefetch(from + i, 0);
    }
#else
    (void) j, (void) y;
#endif
}

/* Does a texel that texel i of row y is made of have a negative z? */
static bool any_negative(const ntp__resize_job *j, const float *const *rows, int32_t i, int32_t y)
{
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->y;
    const int32_t *weight = axis->weight + (ptrdiff_t) y * axis->stride;
    const int32_t columns = j->plan->x.span[s->x0 + i].count;
    for (int32_t t = 0; t < axis->span[y].count; t++) {
        const int32_t z = 4 * s->at[i] + 2;
        const int16_t *whole = (const int16_t *) (const void *) rows[t];
        for (int32_t k = 0; weight[t] != 0 && k < columns; k++) {
            if (s->whole ? whole[z + 4 * k] < 0 : rows[t][z + 4 * k] < 0)
                return true;
        }
    }
    return false;
}

/* Is a texel made of unused ones only? */
static bool is_empty(const ntp__resize_job *j, int32_t i)
{
    const ntp__strip *s = j->strip;
    const double *weight = s->sums + 4 * s->at[i] + 3;
    for (int32_t k = 0; k < j->plan->x.span[s->x0 + i].count; k++, weight += 4) {
        if (*weight != 0)
            return false;
    }
    return true;
}

/* So it is where the sides are halved. */
static bool is_symmetric(const int32_t *weight, int32_t taps)
{
    bool same = taps % 2 == 0;
    for (int32_t t = 0; same && t < taps / 2; t++)
        same = weight[t] == weight[taps - 1 - t];
    return same;
}

/* What is to be done about vector k, of texel i, whose sums are not plain; returns whether it is
 * inexact. */
static bool judge_sums(const ntp__resize_job *j, ntp__vectors *v, double total, int32_t k,
                       int32_t i)
{
    const double x = v->c[0][k], y = v->c[1][k], z = v->c[2][k];
    const double error = j->most < 0x1p53 ? -1 : j->most * j->strip->taps_x * 0x1p-52;
    const bool small = x * x + y * y + z * z <= error * error * 0x1p80;
    /* Negative weights of Lanczos can outweigh the others where many texels are unused. */
    if (total <= 0)
        v->c[0][k] = v->c[1][k] = v->c[2][k] = 0;
    return error > 0 && (total <= error || fabs(z) <= error || small) && !is_empty(j, i);
}

/* The rows that make one of the result, and their weights. */
typedef struct sources {
    const float *rows[MOST_TAPS + 2];
    int32_t weight[MOST_TAPS + 2];
    int32_t taps;
    bool symmetric, negative;
} sources;

static void find_sources(const ntp__resize_job *j, sources *from, int32_t y)
{
    const ntp__axis *axis = &j->plan->y;
    const int32_t taps = axis->span[y].count;
    from->negative = get_rows(j, from->rows, y);
    memcpy(from->weight, axis->weight + (ptrdiff_t) y * axis->stride,
           (size_t) taps * sizeof from->weight[0]);
    from->weight[taps] = 0;
    from->rows[taps] = from->rows[0];
    from->taps = taps + taps % 2;
    from->symmetric = is_symmetric(from->weight, taps);
    fetch_ahead(j, y);
}

/* Sums of `count` numbers from `first` on, a multiple of 8. */
static void sum_in_doubles(ntp__strip *s, const sources *from, int32_t first, int32_t count)
{
    enum { PART = 64 };
#ifdef NTP_HAVE_AVX2
    float part[MOST_TAPS + 2][PART];
#endif
    const float *rows[MOST_TAPS + 2];
    for (int32_t n, i = first, end = first + count; i < end; i += n) {
        n = s->whole && end - i > PART ? PART : end - i;
        for (int32_t t = 0; t < from->taps; t++) {
            rows[t] = from->rows[t] + i;
#ifdef NTP_HAVE_AVX2
            if (s->whole) {
                ntp__widen_avx2(part[t], (const int16_t *) (const void *) from->rows[t] + i, n);
                rows[t] = part[t];
            }
#endif
        }
        (from->symmetric ? loops()->add_pairs : loops()->add_rows)(s->sums + i, rows, from->weight,
                                                                   from->taps, n);
    }
}

/* Is a negative z of texel i no z of a source?  Only Lanczos has weights below 0. */
static bool overshot(const ntp__resize_job *j, const sources *from, int32_t i, int32_t y)
{
    return j->plan->how.filter == NTP_FILTER_LANCZOS3 &&
           !(from->negative && any_negative(j, from->rows, i, y));
}

/* n vectors, of texels at[0].. (NULL: all), and what is to be done about them; returns how many are
 * inexact. */
static int32_t judge_vectors(const ntp__resize_job *j, ntp__vectors *v, int32_t *inexact,
                             const double *total, const sources *from, const int32_t *at, int32_t n,
                             int32_t y)
{
    const bool exact = j->most < 0x1p53;
    int32_t found = 0;
    for (int32_t k = 0; k < n; k++) {
        const double z = v->c[2][k];
        const int32_t i = at == NULL ? k : at[k];
        inexact[k] = 0;
        if (!exact || total[k] <= 0)
            inexact[k] = judge_sums(j, v, total[k], k, i);
        if (z < 0 && overshot(j, from, i, y))
            v->c[2][k] = 0;
        found += inexact[k];
    }
    return found;
}

#ifdef NTP_HAVE_AVX2
static void sum_whole(float *sums, const sources *from, double scale, int32_t count)
{
    const int32_t end = from->symmetric ? from->taps / 2 : from->taps;
    ntp__whole_weights to;
    scale *= from->symmetric ? 0x1p29 : 0x1p28;
    to.n = end + end % 2;
    for (int32_t t = 0; t < to.n; t++) {
        const int32_t s = t < end ? t : 0, w = t < end ? (int32_t) (from->weight[s] * scale) : 0;
        to.row[t] = from->rows[s];
        to.other[t] = from->rows[from->symmetric ? from->taps - 1 - s : s];
        to.upper[t] = (int16_t) (w >> 15);
        to.lower[t] = (int16_t) (w & 32767);
    }
    ntp__sum_whole_avx2(sums, &to, count);
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
    if (s->whole)
        sum_whole(s->sums_in_float, from, y->scale, 4 * s->columns);
    else
        ntp__sum_rows_avx2(s->sums_in_float, from->rows, from->weight, (float) y->scale, from->taps,
                           from->symmetric, 4 * s->columns);
    ntp__sum_columns_avx2(p, least, s->sums_in_float, s->at, s->weight_in_float, s->taps_x, s->n,
                          s->same);
    return s->in_floats ? 0 : (float) (terms * u * (j->most * x->scale * y->scale));
}

/* Texels that are made of unused ones, or whose z is negative; makes red of the uncertain a NaN. */
static void judge_planes(const ntp__resize_job *j, ntp__planes *p, const float least[4],
                         float error, const sources *from, int32_t y)
{
    const bool any_below =
        least[2] <= error && (error > 0 || j->plan->how.filter == NTP_FILTER_LANCZOS3);
    if (!any_below && least[3] > error)
        return;
    for (int32_t i = 0; i < j->strip->n; i++) {
        const float z = p->c[2][i];
        const bool empty = p->c[3][i] <= error;
        if (error > 0 && (empty || fabsf(z) <= error))
            p->c[0][i] = NAN;
        else if (empty)
            p->c[0][i] = p->c[1][i] = p->c[2][i] = 0;
        else if (z < 0 && overshot(j, from, i, y))
            p->c[2][i] = 0;
    }
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
    sources from;
    if (!s->packed || s->pause-- > 0)
        return -1;
    s->pause = 0;
    find_sources(j, &from, y);
    const float error = sum_in_floats(j, &p, least, &from);
    judge_planes(j, &p, least, error, &from, y);
    const int32_t found =
        ntp__pack_directions_avx2(ntp__at_mut(j->dst, s->x0, y), at, &p, s->n, error, j->m > 255,
                                  j->dst->encoding == NTP_ENCODING_ZZERO);
    if (found > s->n / MANY) {
        s->pause = PAUSE;
        return -1;
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
