/* SPDX-License-Identifier: MIT */
/*
 * occlusion.c - ambient occlusion of a heightfield
 *
 * In the vertical plane of one direction let t be the slope of the surface and s >= t that of the
 * horizon.  Between the two the light
 *     z (s (s - t)/(1 + s s) - t (atan s - atan t))
 * is lost, z that of the normal; it is the integral of the cosine to the normal over these angles,
 * divided by that over a flat texel's.  The occlusion is 1 less the weighted sum over directions.
 *
 * Directions lead through texels: a steps along one axis and b along the other.  A line of samples,
 * one for each step along the first axis, passes through the middle of every a-th texel, and
 * between two texels elsewhere, where the height is interpolated.  Each texel is in the middle of
 * one line of each direction, so lines can be done at the same time.  Sums are of integers, so
 * their order does not matter, and a flipped or turned heightfield has the flipped or turned
 * result.
 */
#include "base/finite.h"
#include "base/parts.h"
#include "base/scratch.h"
#include "base/view.h"
#include "shape/horizon.h"
#include "texel/angle.h"

#include <math.h>

enum {
    STEPS = 1 << 24, /* heights are multiples of 1/STEPS of their range */
    WHOLE = 1 << 30, /* what stands for all light in the sums */
    LINES = 64,      /* of a direction, for each item of work */
    DIRECTIONS = 5,  /* of an eighth of the circle, both ends included */
    OCTANTS = 4      /* pairs of opposite eighths */
};

static const double MOST_UNIT = 0x1p100;

/* About 11 degrees apart.  The mean of the cosine of m times the angle, m < 20, over the 32
 * directions with these weights is exactly 0; the weights follow from that. */
static const struct direction {
    int32_t a, b;
    double weight;
} DIRECTION[DIRECTIONS] = { { 1, 0, 0.03307102186414931 },
                            { 5, 1, 0.02896638842217056 },
                            { 5, 2, 0.031209717006563376 },
                            { 3, 2, 0.033241967394742236 },
                            { 1, 1, 0.030092832488898352 } };

/* One axis of the picture, in the memory of heights. */
typedef struct axis {
    int32_t n;
    ptrdiff_t stride;
    bool wraps;
} axis;

/* The lines of a part. */
typedef struct lines {
    int32_t *v, *back; /* the samples, from both ends */
    int32_t *best, *stack;
} lines;

typedef struct job {
    const int32_t *heights; /* 0..STEPS */
    uint32_t *lost;         /* of WHOLE */
    lines *part;
    double unit; /* a step in texels */
    /* of the direction: */
    axis along, across;
    int32_t a, b, reach;
    int32_t first_line, line_count;
    double weight, length; /* length: of a + b, in texels */
} job;

/* ------------------------------------------------------------------------- one line */

/* A line: columns first..first + n - 1 along its axis; in column x it is at (at + b (x - first))/a
 * of the other axis. */
typedef struct line {
    int32_t first, n;
    int64_t at;
} line;

static int64_t divide_down(int64_t v, int64_t by)
{
    return v >= 0 ? v / by : -((-v + by - 1) / by);
}

/* The columns of a line that begins at `start`/a in column 0 and have texels on both sides. */
static line line_of(const job *j, int64_t start)
{
    int64_t low = j->along.wraps ? -(int64_t) j->reach : 0;
    int64_t high = j->along.n - 1 + (j->along.wraps ? (int64_t) j->reach : 0);
    const int64_t end = (int64_t) j->a * (j->across.n - 1);
    if (!j->across.wraps && j->b != 0) {
        const int64_t enters =
            j->b > 0 ? -divide_down(start, j->b) : -divide_down(end - start, -j->b);
        const int64_t leaves =
            j->b > 0 ? divide_down(end - start, j->b) : divide_down(start, -j->b);
        low = low > enters ? low : enters;
        high = high < leaves ? high : leaves;
    }
    const line l = { (int32_t) low, (int32_t) (high - low + 1), start + j->b * low };
    return l;
}

static int32_t modulo(int64_t i, int32_t n)
{
    const int64_t rest = i % n;
    return (int32_t) (rest < 0 ? rest + n : rest);
}

static int32_t one_on(int32_t i, int32_t n)
{
    return i + 1 == n ? 0 : i + 1;
}

static void read_line(const job *j, const line *l, const lines *out)
{
    const int32_t a = j->a, rows = j->across.n;
    int32_t row = modulo(divide_down(l->at, a), rows), rest = modulo(l->at, a);
    int32_t column = modulo(l->first, j->along.n);
    for (int32_t i = 0; i < l->n; i++) {
        const int32_t *at = j->heights + column * j->along.stride;
        int32_t v = at[row * j->across.stride] * (a - rest);
        if (rest > 0)
            v += at[one_on(row, rows) * j->across.stride] * rest;
        out->v[i] = out->back[l->n - 1 - i] = v;
        column = one_on(column, j->along.n);
        rest += j->b;
        if (rest >= a) {
            rest -= a;
            row = one_on(row, rows);
        } else if (rest < 0) {
            rest += a;
            row = row > 0 ? row - 1 : rows - 1;
        }
    }
}

/* The light lost between a tangent of slope t and a horizon of slope s. */
static double lost_light(double s, double t, double z)
{
    const double flat = s * (s - t) / (1 + s * s);
    return z * (t == 0 ? flat : flat - t * ntp__radians(s - t, 1 + s * t));
}

/* The slope along an axis, by central differences, in the unit of heights. */
static double slope(const int32_t *at, int32_t i, const axis *x)
{
    const ptrdiff_t next = i + 1 < x->n ? x->stride : x->wraps ? -(x->n - 1) * x->stride : 0;
    const ptrdiff_t before = i > 0 ? -x->stride : x->wraps ? (x->n - 1) * x->stride : 0;
    const int32_t apart = x->wraps || (i > 0 && i + 1 < x->n) ? 2 : 1;
    return (double) (at[next] - at[before]) / apart;
}

/* Adds what is lost in both directions at a sample of a line, which is a texel. */
static void add_texel(const job *j, const line *l, const lines *p, int32_t i, int32_t far,
                      int32_t back)
{
    const int32_t x = l->first + i;
    const int32_t y = modulo(divide_down(l->at + (int64_t) j->b * i, j->a), j->across.n);
    const ptrdiff_t offset = x * j->along.stride + y * j->across.stride;
    const int32_t *at = j->heights + offset;
    const double px = slope(at, x, &j->along) * j->unit, py = slope(at, y, &j->across) * j->unit;
    const double t = (px * j->a + py * j->b) / j->length;
    const double z = 1 / sqrt(1 + (px * px + py * py)), unit = j->unit / j->length;
    double lost = 0;
    if (far >= 0) {
        const double s = (double) (p->v[far] - p->v[i]) / (far - i) * unit;
        lost = s > t ? lost_light(s, t, z) : 0;
    }
    if (back >= 0) {
        const int32_t from = l->n - 1 - i;
        const double s = (double) (p->back[back] - p->back[from]) / (back - from) * unit;
        lost += s > -t ? lost_light(s, -t, z) : 0;
    }
    j->lost[offset] += (uint32_t) (lost * j->weight * WHOLE + 0.5);
}

/* The samples of a line that are texels of the picture. */
static ntp__some texels_of(const job *j, const line *l)
{
    ntp__some some = { l->first < 0 ? -l->first : 0, l->n, j->a };
    if (l->first + l->n > j->along.n)
        some.last = j->along.n - l->first;
    while (some.first < some.last && modulo(l->at + (int64_t) j->b * some.first, j->a) != 0)
        some.first++;
    return some;
}

static void do_line(const job *j, lines *p, int64_t start)
{
    const line l = line_of(j, start);
    const ntp__some some = l.n > 1 ? texels_of(j, &l) : (ntp__some) { 0, 0, 1 };
    if (some.first >= some.last)
        return;
    read_line(j, &l, p);
    int32_t *const far = p->best, *const back = p->best + l.n;
    ntp__horizons(far, p->v, l.n, some, j->reach, p->stack);
    const int32_t final = some.first + (some.last - 1 - some.first) / some.step * some.step;
    const ntp__some turned = { l.n - 1 - final, l.n - some.first, some.step };
    ntp__horizons(back, p->back, l.n, turned, j->reach, p->stack);
    for (int32_t i = some.first; i < some.last; i += some.step)
        add_texel(j, &l, p, i, far[i], back[l.n - 1 - i]);
}

/* --------------------------------------------------------------------------- all lines */

static void do_lines(void *work, int32_t part, int32_t item)
{
    const job *j = work;
    const int32_t begin = item * LINES;
    const int32_t end = j->line_count - begin < LINES ? j->line_count : begin + LINES;
    for (int32_t i = begin; i < end; i++)
        do_line(j, &j->part[part], (int64_t) j->first_line + i);
}

static int32_t reach_of(const ntp_occlusion_options *how, double step, int32_t longer)
{
    const double most = how->radius > 0 ? how->radius : longer;
    return most / step < longer ? (int32_t) (most / step) : longer;
}

/* A direction and the opposite one, mirrored and turned by `octant`. */
static void do_direction(job *j, const struct direction *d, int32_t octant, const axis axes[2],
                         const ntp_occlusion_options *how, const ntp__crew *crew)
{
    const bool turned = octant >= 2, mirrored = octant % 2 != 0;
    if ((d->b == 0 && mirrored) || (d->a == d->b && turned))
        return;
    const int32_t longer = axes[0].n > axes[1].n ? axes[0].n : axes[1].n;
    j->along = axes[turned ? 1 : 0];
    j->across = axes[turned ? 0 : 1];
    j->a = d->a;
    j->b = mirrored ? -d->b : d->b;
    j->length = sqrt((double) (d->a * d->a + d->b * d->b));
    j->weight = d->weight;
    j->reach = reach_of(how, j->length / d->a, longer);
    if (j->reach < 1)
        return;
    const int32_t lead = d->b * (j->along.n - 1);
    j->first_line = j->across.wraps || mirrored ? 0 : -lead;
    j->line_count =
        d->a * (j->across.n - (j->across.wraps ? 0 : 1)) + (j->across.wraps ? 0 : lead + 1);
    ntp__crew_each(crew, do_lines, j, (j->line_count + LINES - 1) / LINES);
}

/* ---------------------------------------------------------------------------- heights */

static double height_at(const ntp_const_image *src, int32_t x, int32_t y)
{
    const void *at = ntp__at(src, x, y);
    return src->type == NTP_TYPE_U8    ? *(const uint8_t *) at / 255.0
           : src->type == NTP_TYPE_U16 ? *(const uint16_t *) at / 65535.0
                                       : (double) *(const float *) at;
}

/* Rounds heights to steps of their range; returns what one step is. */
static double read_heights(int32_t *heights, const ntp_const_image *src, double scale)
{
    double low = 0, high = 1;
    bool any = src->type != NTP_TYPE_F32;
    for (int32_t y = 0; y < src->height && src->type == NTP_TYPE_F32; y++) {
        for (int32_t x = 0; x < src->width; x++) {
            const double h = height_at(src, x, y);
            if (!ntp__is_finite(h))
                continue;
            low = !any || h < low ? h : low;
            high = !any || h > high ? h : high;
            any = true;
        }
    }
    const double range = any && high > low ? high - low : 1;
    for (int32_t y = 0; y < src->height; y++) {
        for (int32_t x = 0; x < src->width; x++) {
            const double h = height_at(src, x, y);
            const double v = (ntp__is_finite(h) ? h - low : 0) / range;
            const int32_t step = (int32_t) (v * STEPS + 0.5);
            heights[(size_t) y * (size_t) src->width + (size_t) x] =
                scale < 0 ? STEPS - step : step;
        }
    }
    return range * (scale < 0 ? -scale : scale) / STEPS;
}

static void write_result(const ntp_image *dst, const uint32_t *lost)
{
    const double m = ntp__max(dst->type);
    for (int32_t y = 0; y < dst->height; y++) {
        for (int32_t x = 0; x < dst->width; x++) {
            const uint32_t dark = lost[(size_t) y * (size_t) dst->width + (size_t) x];
            const double v = dark < WHOLE ? 1 - (double) dark / WHOLE : 0;
            void *at = ntp__at_mut(dst, x, y);
            if (dst->type == NTP_TYPE_U8)
                *(uint8_t *) at = (uint8_t) (v * m + 0.5);
            else if (dst->type == NTP_TYPE_U16)
                *(uint16_t *) at = (uint16_t) (v * m + 0.5);
            else
                *(float *) at = (float) v;
        }
    }
}

/* ---------------------------------------------------------------------- the interface */

static bool options_good(const ntp_occlusion_options *how)
{
    const ntp_border borders[2] = { how->border_x, how->border_y };
    for (int i = 0; i < 2; i++)
        if (borders[i] != NTP_BORDER_WRAP && borders[i] != NTP_BORDER_CLAMP)
            return false;
    return ntp__is_finite(how->scale) && how->radius >= 0;
}

/* What the caller's memory holds. */
static void lay_out(ntp__scratch *s, job *j, lines *parts, int32_t count,
                    const ntp_occlusion_options *how, int32_t width, int32_t height)
{
    const size_t texels = (size_t) width * (size_t) height;
    const int32_t longer = width > height ? width : height;
    const size_t most = (size_t) longer + 2 * (size_t) reach_of(how, 1, longer);
    j->heights = ntp__take(s, texels * sizeof *j->heights);
    j->lost = ntp__take(s, texels * sizeof *j->lost);
    for (int32_t i = 0; i < count; i++) {
        parts[i].v = ntp__take(s, most * sizeof(int32_t));
        parts[i].back = ntp__take(s, most * sizeof(int32_t));
        parts[i].best = ntp__take(s, 2 * most * sizeof(int32_t));
        parts[i].stack = ntp__take(s, 2 * most * sizeof(int32_t));
    }
}

static const ntp_occlusion_options DEFAULTS;

size_t ntp_occlusion_scratch_size(const ntp_occlusion_options *how, int32_t width, int32_t height,
                                  int32_t parts)
{
    ntp__scratch s = { NULL, 0 };
    lines unused[NTP_MAX_PARTS];
    job j;
    how = how != NULL ? how : &DEFAULTS;
    if (!options_good(how) || width < 1 || height < 1 || width > NTP_MAX_SIDE ||
        height > NTP_MAX_SIDE || parts < 0 || parts > NTP_MAX_PARTS)
        return 0;
    lay_out(&s, &j, unused, parts > 0 ? parts : 1, how, width, height);
    return s.used;
}

static ntp_status check(const ntp_image *dst, const ntp_const_image *src,
                        const ntp_occlusion_options *how, const void *scratch, size_t scratch_size,
                        int32_t parts)
{
    if (dst == NULL || !options_good(how) || parts < 1 || parts > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    const ntp_const_image view = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_view(&view));
    NTP__TRY(ntp__check_view(src));
    if (src->encoding != NTP_ENCODING_HEIGHT || dst->encoding != NTP_ENCODING_HEIGHT)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&view, src) || src->ring_rows != 0 || dst->ring_rows != 0)
        return NTP_ERR_SHAPE;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 ||
        scratch_size < ntp_occlusion_scratch_size(how, src->width, src->height, parts))
        return NTP_ERR_SCRATCH;
    return NTP_OK;
}

ntp_status ntp_occlusion(const ntp_image *dst, const ntp_const_image *src,
                         const ntp_occlusion_options *how, void *scratch, size_t scratch_size,
                         const ntp_hooks *hooks)
{
    const ntp__crew crew = ntp__crew_of(hooks);
    ntp__scratch s = { scratch, 0 };
    lines parts[NTP_MAX_PARTS];
    job j = { .part = parts };
    how = how != NULL ? how : &DEFAULTS;
    NTP__TRY(check(dst, src, how, scratch, scratch_size, crew.parts));
    lay_out(&s, &j, parts, crew.parts, how, src->width, src->height);
    j.unit = read_heights((int32_t *) (uintptr_t) j.heights, src, how->scale != 0 ? how->scale : 1);
    if (!(j.unit < MOST_UNIT)) /* squares of slopes stay finite */
        j.unit = MOST_UNIT;
    for (size_t i = 0; i < (size_t) src->width * (size_t) src->height; i++)
        j.lost[i] = 0;
    const axis axes[2] = { { src->width, 1, how->border_x == NTP_BORDER_WRAP },
                           { src->height, src->width, how->border_y == NTP_BORDER_WRAP } };
    for (int32_t i = 0; i < DIRECTIONS * OCTANTS; i++) {
        const double share = (double) i / (DIRECTIONS * OCTANTS);
        if (hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, share) != 0)
            return NTP_ERR_CANCELLED;
        do_direction(&j, &DIRECTION[i / OCTANTS], i % OCTANTS, axes, how, &crew);
    }
    write_result(dst, j.lost);
    return NTP_OK;
}
