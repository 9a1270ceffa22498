/* SPDX-License-Identifier: MIT */
/*
 * height_rows.c - heights from pixels, and what lies beyond the borders
 *
 * Integer heights are numerators over g->range.  A numerator is the sample itself, the greatest or
 * least of three, a weighted sum, or that of 1 - (1-r)(1-g)(1-b) over M^3.
 */
#include "from_height/gradient.h"

#include "base/finite.h"

#include <string.h>

static int64_t combine_integers(const ntp__gradient *g, const int64_t s[NTP__MAX_READS])
{
    int64_t m = ntp__max(g->src->type);
    switch (g->source) {
    case NTP_HEIGHT_SOURCE_MAX: {
        int64_t v = s[0] > s[1] ? s[0] : s[1];
        return v > s[2] ? v : s[2];
    }
    case NTP_HEIGHT_SOURCE_MIN: {
        int64_t v = s[0] < s[1] ? s[0] : s[1];
        return v < s[2] ? v : s[2];
    }
    case NTP_HEIGHT_SOURCE_SCREEN:
        return m * m * m - (m - s[0]) * (m - s[1]) * (m - s[2]);
    default: {
        int64_t sum = 0;
        for (int32_t k = 0; k < g->reads; k++)
            sum += g->weight[k] * s[k];
        return sum;
    }
    }
}

int64_t ntp__height_integer(const ntp__gradient *g, int32_t x, int32_t y)
{
    const void *p = ntp__at(g->src, x, y);
    int64_t s[NTP__MAX_READS] = { 0 };
    for (int32_t k = 0; k < g->reads; k++)
        s[k] = g->src->type == NTP_TYPE_U8 ? ((const uint8_t *) p)[g->read[k]]
                                           : ((const uint16_t *) p)[g->read[k]];
    return combine_integers(g, s);
}

/* The height times g->range, as a double.  It is exact for one sample, max and min. */
static double combine_floats(const ntp__gradient *g, const float *s)
{
    double a = (double) s[g->read[0]];
    if (g->reads == 1)
        return g->weight[0] * a;
    double b = (double) s[g->read[1]], c = (double) s[g->read[2]];
    switch (g->source) {
    case NTP_HEIGHT_SOURCE_MAX:
        a = a > b ? a : b;
        return a > c ? a : c;
    case NTP_HEIGHT_SOURCE_MIN:
        a = a < b ? a : b;
        return a < c ? a : c;
    case NTP_HEIGHT_SOURCE_SCREEN:
        return 1 - (1 - a) * (1 - b) * (1 - c);
    default:
        return g->weight[0] * a + g->weight[1] * b + g->weight[2] * c;
    }
}

double ntp__height_value(const ntp__gradient *g, int32_t x, int32_t y)
{
    if (g->src->type != NTP_TYPE_F32)
        return (double) ntp__height_integer(g, x, y) / (double) g->range;
    const float *s = ntp__at(g->src, x, y);
    double h = combine_floats(g, s);
    return g->range == 1 ? h : h / (double) g->range;
}

int32_t ntp__share_level(double v, bool inverse, int32_t m)
{
    /* floor(M v + 1/2), or M minus the least integer that is at least M v - 1/2 */
    double c = v * m + (inverse ? -0.5 : 0.5);
    int32_t below = c > 0 ? c < m ? (int32_t) c : m : 0;
    return inverse ? m - below - (below < m && c > below) : below;
}

int32_t ntp__height_level(const ntp__gradient *g, int32_t x, int32_t y, bool inverse, int32_t m)
{
    if (g->src->type == NTP_TYPE_F32)
        return ntp__share_level(ntp__height_value(g, x, y), inverse, m);
    /* floor(h m / range + 1/2).  Where m divides range it is divided out, so that 64 bits are
     * enough. */
    int64_t h = ntp__height_integer(g, x, y), range = g->range, factor = m;
    h = inverse ? range - h : h;
    if (range % factor == 0) {
        range /= factor;
        factor = 1;
    }
    return (int32_t) ((2 * h * factor + range) / (2 * range));
}

bool ntp__heights_are_int(const ntp__gradient *g)
{
    return g->src->type != NTP_TYPE_F32 && g->kernel->gain * g->range < INT32_MAX;
}

/* The samples of the texels x..x+n-1 of a row inside the image. */
static void read_integers(ntp__height_row *row, int32_t at, const ntp__gradient *g, int32_t x,
                          int32_t y, int32_t n)
{
    const ntp_const_image *v = g->src;
    bool single = g->reads == 1 && g->weight[0] == 1 && ntp__heights_are_int(g);
    const char *p = (const char *) ntp__at(v, x, y) + g->read[0] * ntp__sample_size(v->type);
    if (single && v->type == NTP_TYPE_U8 && v->pixel_stride == 1) {
        const uint8_t *s = (const uint8_t *) p;
        for (int32_t i = 0; i < n; i++)
            row->h.i[at + i] = s[i];
    } else if (single && v->type == NTP_TYPE_U16 && v->pixel_stride == 2) {
        const uint16_t *s = (const uint16_t *) (const void *) p;
        for (int32_t i = 0; i < n; i++)
            row->h.i[at + i] = s[i];
    } else if (single) {
        for (int32_t i = 0; i < n; i++, p += v->pixel_stride)
            row->h.i[at + i] = v->type == NTP_TYPE_U8 ? *(const uint8_t *) p
                                                      : *(const uint16_t *) (const void *) p;
    } else if (ntp__heights_are_int(g)) {
        for (int32_t i = 0; i < n; i++)
            row->h.i[at + i] = (int32_t) ntp__height_integer(g, x + i, y);
    } else {
        for (int32_t i = 0; i < n; i++)
            row->h.d[at + i] = (double) ntp__height_integer(g, x + i, y);
    }
}

static double magnitude_of(int32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof v);
    return (double) v;
}

static void widen_range(ntp__height_row *row, const ntp__magnitudes *m)
{
    const double most = magnitude_of(m->most);
    row->finite = row->finite && ntp__is_finite(most);
    row->most = most > row->most ? most : row->most;
    if (m->least < INT32_MAX && magnitude_of(m->least + 1) < row->least)
        row->least = magnitude_of(m->least + 1);
}

/* One sample of each texel, or its alpha. */
static void read_samples(ntp__height_row *row, int32_t at, const ntp__gradient *g, const char *p,
                         int32_t n)
{
    ntp__magnitudes m = { INT32_MAX, 0, 0, 0 };
    float line[NTP__GRADIENT_ROW];
    const float *s = (const float *) (const void *) (p + g->read[0] * (ptrdiff_t) sizeof(float));
    if (g->src->pixel_stride != (ptrdiff_t) sizeof(float)) {
        for (int32_t i = 0; i < n; i++, p += g->src->pixel_stride)
            line[i] = ((const float *) (const void *) p)[g->read[0]];
        s = line;
    }
    g->loops->take_floats(&row->h.d[at], s, n, &m);
    widen_range(row, &m);
}

static void read_floats(ntp__height_row *row, int32_t at, const ntp__gradient *g, int32_t x,
                        int32_t y, int32_t n)
{
    const char *p = ntp__at(g->src, x, y);
    if (g->reads == 1) {
        read_samples(row, at, g, p, n);
        return;
    }
    for (int32_t i = 0; i < n; i++, p += g->src->pixel_stride) {
        const float *s = (const float *) (const void *) p;
        double h = combine_floats(g, s);
        for (int32_t k = 0; k < g->reads; k++) {
            double size = (double) s[g->read[k]];
            size = size < 0 ? -size : size;
            row->finite = row->finite && ntp__is_finite(size);
            row->most = size > row->most ? size : row->most;
            row->least = size > 0 && size < row->least ? size : row->least;
        }
        row->h.d[at + i] = h;
    }
}

static void read_texels(ntp__height_row *row, int32_t at, const ntp__gradient *g, int32_t x,
                        int32_t y, int32_t n)
{
    if (g->src->type == NTP_TYPE_F32)
        read_floats(row, at, g, x, y, n);
    else
        read_integers(row, at, g, x, y, n);
}

/* Fills a row that lies in the image. */
static void fill_inside(ntp__height_row *row, const ntp__gradient *g, int32_t x, int32_t y,
                        int32_t n)
{
    int32_t width = g->src->width, radius = g->kernel->radius;
    int32_t first = x - radius, last = x + n + radius; /* those wanted */
    int32_t inside_first = first < 0 ? 0 : first, inside_last = last > width ? width : last;
    int32_t base = x - NTP__MAX_RADIUS;
    bool ints = ntp__heights_are_int(g);
    read_texels(row, inside_first - base, g, inside_first, y, inside_last - inside_first);
    for (int32_t i = first; i < last; i++) {
        if (i == inside_first)
            i = inside_last; /* the texels between are there */
        if (i >= last)
            break;
        ntp__mapped map = ntp__border_map(g->border_x, i, width);
        int32_t at = i - base;
        /* Each mapped texel is read by itself, because it may lie far from the block. */
        int32_t sum_i = 0;
        double sum_d = 0;
        for (int32_t k = 0; k < map.count; k++) {
            read_texels(row, at, g, map.index[k], y, 1);
            if (ints)
                sum_i += map.weight[k] * row->h.i[at];
            else
                sum_d += map.weight[k] * row->h.d[at];
        }
        if (ints)
            row->h.i[at] = sum_i;
        else
            row->h.d[at] = sum_d;
    }
    for (int32_t i = last - base; i < last - base + 2 * NTP__LANES && i < NTP__GRADIENT_ROW; i++) {
        if (ints)
            row->h.i[i] = 0;
        else
            row->h.d[i] = 0;
    }
}

static void empty_row(ntp__height_row *row, int32_t y, bool quick)
{
    row->y = y;
    row->filled = true;
    row->finite = true;
    row->quick = quick;
    row->least = 0x1p1000;
    row->most = 0;
}

/* As ntp__take_heights_fn, of one sample. */
static float take_one(const void *s, ntp_type type, ntp__magnitudes *m)
{
    if (type == NTP_TYPE_U8)
        return (float) *(const uint8_t *) s;
    if (type == NTP_TYPE_U16)
        return (float) *(const uint16_t *) s;
    const float v = *(const float *) s;
    int32_t bits;
    memcpy(&bits, &v, sizeof bits);
    const int32_t size = bits & INT32_MAX, below = (size - 1) & INT32_MAX;
    m->most = size > m->most ? size : m->most;
    m->least = below < m->least ? below : m->least;
    m->low = v < m->low ? v : m->low;
    m->high = v > m->high ? v : m->high;
    return v;
}

void ntp__height_row_floats(ntp__height_row *row, const ntp__gradient *g, int32_t x, int32_t y,
                            int32_t n)
{
    const ntp_const_image *v = g->src;
    const int32_t from_y = ntp__border_map(g->border_y, y, v->height).index[0];
    const int32_t first = x > 0 ? x - 1 : 0, last = x + n < v->width ? x + n + 1 : v->width;
    /* The column before a row, those inside, and the one after it. */
    const int32_t at[4] = { x - 1, first, last, x + n + 1 };
    ntp__magnitudes m = { INT32_MAX, 0, 0x1p127F, -0x1p127F };
    empty_row(row, y, true);
    for (int32_t k = 0; k < 3; k++) {
        const int32_t count = at[k + 1] - at[k];
        const int32_t from = ntp__border_map(g->border_x, at[k], v->width).index[0];
        float *const to = &row->h.f[NTP__MAX_RADIUS + at[k] - x];
        if (count >= NTP__LANES)
            g->loops->take_heights(to, ntp__at(v, from, from_y), v->type, count, &m);
        for (int32_t i = 0; i < count && count < NTP__LANES; i++)
            to[i] = take_one(ntp__at(v, from + i, from_y), v->type, &m);
    }
    memset(&row->h.f[NTP__MAX_RADIUS + n + 1], 0, NTP__LANES * sizeof(float));
    widen_range(row, &m);
    row->low = m.low;
    row->high = m.high;
}

void ntp__height_row_fill(ntp__height_row *row, const ntp__gradient *g, int32_t x, int32_t y,
                          int32_t n)
{
    ntp__mapped map = ntp__border_map(g->border_y, y, g->src->height);
    empty_row(row, y, false);
    fill_inside(row, g, x, map.index[0], n);
    if (map.count == 1)
        return;
    ntp__height_row other;
    other.finite = true;
    other.least = row->least;
    other.most = row->most;
    fill_inside(&other, g, x, map.index[1], n);
    row->finite = row->finite && other.finite;
    row->least = other.least < row->least ? other.least : row->least;
    row->most = other.most > row->most ? other.most : row->most;
    int32_t first = NTP__MAX_RADIUS - g->kernel->radius;
    int32_t last = NTP__MAX_RADIUS + n + g->kernel->radius;
    for (int32_t i = first; i < last; i++) {
        if (ntp__heights_are_int(g))
            row->h.i[i] = map.weight[0] * row->h.i[i] + map.weight[1] * other.h.i[i];
        else
            row->h.d[i] = map.weight[0] * row->h.d[i] + map.weight[1] * other.h.d[i];
    }
}
