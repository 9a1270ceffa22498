/* SPDX-License-Identifier: MIT */
/*
 * resize_read.c - the rows of a strip: reads each row of the source once
 *
 * With AVX2, packed pixels are read in one run.  Where columns lie outside, their pixels are copied
 * to one place first.
 */
#include "base/inlining.h"
#include "base/rgb_avx2.h"
#include "reshape/resize_strip.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

enum { BEYOND = 32 /* numbers that may be read after a row */ };

void ntp__strip_forget(ntp__strip *s)
{
    memset(s->sums, 0, sizeof s->sums);
    memset(s->sums_in_float, 0, sizeof s->sums_in_float);
    for (int32_t i = 0; i < s->rows; i++) {
        s->held[i] = NOWHERE;
        s->holes[i] = true; /* so that the run of the weights is filled */
    }
}

#ifdef NTP_HAVE_AVX2
/* Takes out the packed pixels that are unused, of a row without runs; returns whether one is. */
static bool leave_out(const ntp__resize_job *j, char *to, const void *src, int32_t n)
{
    const uint32_t touch = j->plan->how.touch_unused;
    const uint8_t *s = src;
    const bool deep = j->src->type == NTP_TYPE_U16;
    const size_t size = deep ? sizeof(float) : sizeof(int16_t);
    bool any = false;
    for (int32_t i = 0; i < n; i++) {
        uint16_t c[3] = { s[0], s[1], s[2] };
        if (deep)
            memcpy(c, s, sizeof c);
        s += deep ? 6 : 3;
        if ((c[0] != 0 && c[0] != j->m) || !ntp__unused(c[0], c[1], c[2], j->m, j->m, touch))
            continue;
        any = true;
        memset(to + 4 * size * (size_t) i, 0, 4 * size);
    }
    return any;
}

/* The pixels of a row, with those outside at their places. */
static const void *find_pixels(const ntp__resize_job *j, char *room, int32_t row)
{
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->x;
    const int32_t end = s->first + s->columns, last = end < axis->src ? end : axis->src;
    const int32_t inside = s->first > 0 ? s->first : 0;
    const size_t size = (size_t) j->src->pixel_stride;
    if (s->first >= 0 && end <= axis->src)
        return ntp__at(j->src, s->first, row);
    for (int32_t x = s->first; x < end; x++) {
        const int32_t n = x == inside && inside < last ? last - inside : 1;
        memcpy(room + size * (size_t) (x - s->first), ntp__at(j->src, ntp__axis_map(axis, x), row),
               size * (size_t) n);
        x += n - 1;
    }
    return room;
}

static void place_row(const ntp__resize_job *j, char *to, bool *negative, bool *holes, int32_t row)
{
    char room[6 * PADDED];
    const ntp__strip *s = j->strip;
    const int32_t n = s->columns;
    const bool deep = j->src->type == NTP_TYPE_U16, zzero = j->src->encoding == NTP_ENCODING_ZZERO;
    const void *from = find_pixels(j, room, row);
    bool plain;
    if (s->halved && *holes)
        ntp__fill_halves_avx2(to, deep);
    plain = s->halved ? ntp__place_halves_avx2(to, negative, from, n, deep, zzero)
                      : ntp__place_rgb_avx2(to, negative, from, n, deep, zzero);
    *holes = !plain &&
             (s->halved ? ntp__leave_out_halves_avx2(to, n, deep, zzero, j->plan->how.touch_unused)
                        : leave_out(j, to, from, n));
}
#endif

/* Reads n texels of a row from column x on; whether one has a negative z. */
static bool read_run(const ntp__resize_job *j, float *to, int32_t x, int32_t row, int32_t n)
{
    ntp__block block;
    const bool zzero = j->src->encoding == NTP_ENCODING_ZZERO;
    bool negative = false;
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
static void read_row(const ntp__resize_job *j, float *to, bool *negative, int32_t row)
{
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->x;
    const int32_t end = s->first + s->columns, last = end < axis->src ? end : axis->src;
    const int32_t inside = s->first > 0 ? s->first : 0;
    *negative = false;
    if (inside < last)
        *negative = read_run(j, to + 4 * (inside - s->first), inside, row, last - inside);
    for (int32_t x = s->first; x < end; x++) {
        float one[4 * NTP__KERNEL_LANES];
        if (x == inside && inside < last)
            x = last;
        if (x >= end)
            break;
        *negative = read_run(j, one, ntp__axis_map(axis, x), row, 1) || *negative;
        memcpy(to + 4 * (x - s->first), one, 4 * sizeof one[0]);
    }
}

/* The rows of a strip are far apart in memory, so processors do not fetch them ahead of time. */
static void fetch_ahead(const ntp__resize_job *j, int32_t y)
{
#if defined(__GNUC__)
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->y;
    const int32_t x = s->first > 0 ? s->first : 0;
    const ptrdiff_t bytes = (s->first + s->columns - x) * j->src->pixel_stride;
    if (y + 1 >= axis->dst)
        return;
    for (int32_t row = axis->span[y].first + axis->span[y].count;
         row < axis->span[y + 1].first + axis->span[y + 1].count && row < axis->src; row++) {
        const char *from = row < 0 ? NULL : ntp__at(j->src, x, row);
        for (ptrdiff_t i = 0; from != NULL && i < bytes; i += NTP__LINE)
            __builtin_prefetch(from + i, 0);
    }
#else
    (void) j, (void) y;
#endif
}

ntp__strip_row ntp__strip_rows(const ntp__resize_job *j, const float **rows, int32_t y)
{
    ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->y;
    ntp__strip_row any = { false, false };
    int32_t row = axis->span[y].first, k = (row % s->rows + s->rows) % s->rows;
    for (int32_t t = 0; t < axis->span[y].count; t++, row++) {
        float *to = s->row + (ptrdiff_t) k * 4 * PADDED;
        if (s->held[k] != row) {
            const int32_t from = ntp__axis_map(axis, row);
#ifdef NTP_HAVE_AVX2
            if (s->placed)
                place_row(j, (char *) to, &s->negative[k], &s->holes[k], from);
#endif
            if (!s->placed)
                read_row(j, to, &s->negative[k], from);
            if (!s->halved) /* so that none is a NaN */
                memset((char *) to + (size_t) (s->whole ? 8 : 16) * (size_t) s->columns, 0,
                       BEYOND * sizeof *to);
        }
        s->held[k] = row;
        rows[t] = to;
        any.negative = any.negative || s->negative[k];
        any.holes = any.holes || s->holes[k];
        k = k + 1 < s->rows ? k + 1 : 0;
    }
    fetch_ahead(j, y);
    return any;
}

/* 1: the z of a column is negative. */
static inline int32_t is_below(const ntp__strip *s, const float *row, int32_t column)
{
    const int32_t half = (4 + column % 2) * NTP__RUN + column / 2;
    const int32_t z = s->halved ? half : 4 * column + 2;
    return s->whole ? ((const int16_t *) (const void *) row)[z] < 0 : row[z] < 0;
}

/* The same of four texels in the middle, one of which mostly is where z of the result is: a search would end
 * somewhere, which no processor foresees. */
static inline bool is_middle_below(const ntp__strip *s, const float *const *rows,
                                   const int32_t *weight, int32_t taps, int32_t i, int32_t columns)
{
    const int32_t t = taps / 2, k = columns / 2;
    if (t == 0 || k == 0 || weight[t - 1] == 0 || weight[t] == 0)
        return false;
    const int32_t column = s->at[i] + k;
    return is_below(s, rows[t - 1], column - 1) | is_below(s, rows[t - 1], column) |
           is_below(s, rows[t], column - 1) | is_below(s, rows[t], column);
}

SELDOM bool ntp__strip_any_negative(const ntp__resize_job *j, const float *const *rows, int32_t i,
                                    int32_t y)
{
    const ntp__strip *s = j->strip;
    const ntp__axis *axis = &j->plan->y;
    const int32_t *weight = axis->weight + (ptrdiff_t) y * axis->stride;
    const int32_t columns = j->plan->x.span[s->x0 + i].count, taps = axis->span[y].count;
    if (is_middle_below(s, rows, weight, taps, i, columns))
        return true;
    for (int32_t t = 0; t < taps; t++) {
        for (int32_t k = 0; weight[t] != 0 && k < columns; k++) {
            if (is_below(s, rows[t], s->at[i] + k))
                return true;
        }
    }
    return false;
}
