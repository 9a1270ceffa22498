/* SPDX-License-Identifier: MIT */
/*
 * integrate_columns.c - the stencils of an axis, and the recursion along columns
 *
 * Once rows are transformed, each column is a system of its own: lambda h plus second differences
 * of h.  Forward slopes couple neighbors; central ones couple rows two apart, which makes one or
 * two rings of rows (with mirrored ends the even rows go down and the odd ones up again).  In
 * the order of such a ring, or of a chain with free ends, the system is -1, 2 + mu, -1, and
 * with r + 1/r = 2 + mu it factors into h[i] = r (u[i] + h[i+1]), u[i] = f[i] + r u[i-1]:
 * one pass down and one up.  What enters at the ends follows from two sums of the first pass.
 */
#include "integrate.h"

#include <math.h>
#include <string.h>

/* Powers of r below this are 0: they no longer show in a float. */
static const double tiny = 0x1p-200;

/* --------------------------------------------------------------------------- stencils */

ntp_status ntp__grid_axis_init(ntp__grid_axis *axis, int32_t n, ntp_kernel kernel,
                               ntp_border border)
{
    if (kernel != NTP_KERNEL_CENTRAL && kernel != NTP_KERNEL_FORWARD)
        return NTP_ERR_FORMAT;
    axis->n = n;
    axis->central = kernel == NTP_KERNEL_CENTRAL;
    axis->wrap = border == NTP_BORDER_WRAP;
    axis->last = 0;
    axis->edge = 1;
    if (axis->central) {
        if (border == NTP_BORDER_MIRROR || border == NTP_BORDER_REPEAT_SLOPE)
            return NTP_ERR_FORMAT;
        /* h[1] - h[0] where clamping makes (h[1] - h[0])/2 */
        axis->edge = border == NTP_BORDER_EXTRAPOLATE ? 0.5 : 1;
    } else if (border == NTP_BORDER_MIRROR) {
        axis->last = -0.5;
    } else if (border == NTP_BORDER_EXTRAPOLATE || border == NTP_BORDER_REPEAT_SLOPE) {
        axis->last = 0.5;
    }
    return NTP_OK;
}

static void add_term(ntp__terms *terms, int32_t at, double weight)
{
    terms->at[terms->count] = at;
    terms->weight[terms->count] = weight;
    terms->count++;
}

/* The slope between i and i + 1. */
static void add_edge(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i, double weight)
{
    if (i != axis->n - 2 || axis->last == 0) {
        add_term(terms, i, weight);
        return;
    }
    add_term(terms, i, weight / 2);
    add_term(terms, i + 1, weight * axis->last);
}

void ntp__adjoint(ntp__terms *terms, const ntp__grid_axis *axis, int32_t i)
{
    int32_t n = axis->n, before = i > 0 ? i - 1 : n - 1, after = i < n - 1 ? i + 1 : 0;
    terms->count = 0;
    if (n == 1)
        return;
    if (axis->wrap) {
        add_term(terms, before, axis->central ? 0.5 : 1);
        add_term(terms, axis->central ? after : i, axis->central ? -0.5 : -1);
    } else if (!axis->central) {
        if (i > 0)
            add_edge(terms, axis, i - 1, 1);
        if (i < n - 1)
            add_edge(terms, axis, i, -1);
    } else {
        /* Beyond the ends the slopes of mirrored heights: the same, negated. */
        bool first = i == 0, last = i == n - 1;
        before = first ? 0 : before;
        after = last ? n - 1 : after;
        double b = before == 0 || before == n - 1 ? axis->edge : 1;
        double a = after == 0 || after == n - 1 ? axis->edge : 1;
        add_term(terms, before, (first ? -0.5 : 0.5) * b);
        add_term(terms, after, (last ? 0.5 : -0.5) * a);
    }
}

double ntp__eigenvalue(const ntp__grid_axis *axis, int32_t j)
{
    int64_t n = axis->n, k = axis->wrap && 2 * (int64_t) j > n ? n - j : j;
    double c, s;
    /* Wrap has the frequency 2 pi k/n, free ends pi k/n; forward slopes see half of it. */
    int64_t whole = (axis->wrap ? 1 : 2) * (axis->central ? 1 : 2) * n;
    ntp__turn(&c, &s, k, whole);
    return axis->central ? s * s : 4 * s * s;
}

/* ------------------------------------------------------------------------------ chains */

/* Rows in the order in which they are coupled. */
typedef struct chain {
    const ntp__grid_axis *axis;
    int32_t length, first;
    bool ring;
} chain;

static int32_t row_of(const chain *c, int32_t i)
{
    int32_t n = c->axis->n, evens = (n + 1) / 2;
    if (!c->axis->central)
        return i;
    if (c->axis->wrap)
        return (int32_t) ((c->first + 2 * (int64_t) i) % n);
    return i < evens ? 2 * i : 2 * (n - 1 - i) + 1;
}

/* Fills both; returns how many there are. */
static int32_t make_chains(chain chains[2], const ntp__grid_axis *axis)
{
    bool two = axis->central && axis->wrap && axis->n % 2 == 0;
    for (int32_t i = 0; i < 2; i++) {
        chains[i].axis = axis;
        chains[i].length = two ? axis->n / 2 : axis->n;
        chains[i].first = i;
        chains[i].ring = axis->central || axis->wrap;
    }
    return two ? 2 : 1;
}

/* ---------------------------------------------------------------------- the recursion */

/* The state of up to NTP__COLUMNS columns. */
typedef struct columns {
    double r[NTP__COLUMNS];       /* 0: lambda is 0, the column is done apart */
    double inverse[NTP__COLUMNS]; /* 1/r */
    double state[NTP__COLUMNS];   /* u, then h */
    double power[NTP__COLUMNS];   /* r^i */
    double sum[NTP__COLUMNS];     /* of r^i f[i] */
    double entry[NTP__COLUMNS];   /* r^(i+1) times what enters u at the first row */
    double start[NTP__COLUMNS];   /* entry at `begin` - 1 */
    double begin[NTP__COLUMNS];   /* the greatest i with r^i not below `tiny` */
} columns;

/* r^e for the greatest e <= limit for which it is not tiny. */
static double greatest_power(double r, int32_t limit, int32_t *e)
{
    double square[17], product = 1;
    square[0] = r;
    for (int32_t b = 1; b < 17; b++)
        square[b] = square[b - 1] * square[b - 1];
    *e = 0;
    for (int32_t b = 16; b >= 0; b--) {
        if (*e + (1 << b) <= limit && product * square[b] >= tiny) {
            product *= square[b];
            *e += 1 << b;
        }
    }
    return product;
}

static void init_columns(columns *s, const ntp__grid_axis *along, double scale, int32_t x0,
                         int32_t n)
{
    for (int32_t i = 0; i < n; i++) {
        double mu = scale * ntp__eigenvalue(along, x0 + i);
        double half = mu / 2, root = sqrt(mu + half * half);
        s->r[i] = mu > 0 ? 1 / (1 + half + root) : 0;
        s->inverse[i] = mu > 0 ? 1 + half + root : 0;
    }
}

static float *row_at(const ntp_image *dst, const chain *c, int32_t i, int32_t x0)
{
    return ntp__at_mut(dst, x0, row_of(c, i));
}

static void pass_down(columns *s, const ntp_image *dst, const chain *c, double scale, int32_t x0,
                      int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        s->state[k] = s->sum[k] = 0;
        s->power[k] = 1;
    }
    for (int32_t i = 0; i < c->length; i++) {
        float *row = row_at(dst, c, i, x0);
        for (int32_t k = 0; k < n; k++) {
            double f = scale * (double) row[k];
            s->state[k] = f + s->r[k] * s->state[k];
            s->sum[k] += s->power[k] * f;
            s->power[k] = s->power[k] > tiny ? s->power[k] * s->r[k] : 0;
            row[k] = s->r[k] > 0 ? (float) s->state[k] : row[k];
        }
    }
}

/* What enters u at the first row, and h at the last: the sums over all the periods of the ring,
 * or of the chain continued by its mirror images. */
static void set_entries(columns *s, const chain *c, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        double r = s->r[k], u = s->state[k], f = s->sum[k], into;
        int32_t e = 0;
        s->start[k] = s->entry[k] = 0;
        s->begin[k] = -1;
        if (!(r > 0))
            continue;
        double power = greatest_power(r, c->length, &e);
        double all = e == c->length ? power : 0; /* r^length */
        if (c->ring) {
            into = u / (1 - all);
            s->state[k] = r / ((1 - r) * (1 + r)) * (f + r * u) / (1 - all);
        } else {
            into = (f + all * u) / (1 - all * all);
            s->state[k] = r * (u + into * all) / (1 - r);
        }
        s->start[k] = into * power;
        s->begin[k] = e;
    }
}

static void pass_up(columns *s, const ntp_image *dst, const chain *c, int32_t x0, int32_t n)
{
    for (int32_t i = c->length - 1; i >= 0; i--) {
        float *row = row_at(dst, c, i, x0);
        double at = i + 1;
        for (int32_t k = 0; k < n; k++) {
            double kept = s->entry[k] * s->inverse[k];
            s->entry[k] = s->begin[k] == at ? s->start[k] : kept;
            s->state[k] = s->r[k] * ((double) row[k] + s->entry[k] + s->state[k]);
            row[k] = s->begin[k] < 0 ? row[k] : (float) s->state[k];
        }
    }
}

/* ------------------------------------------------------------------- columns of lambda 0 */

static void subtract_mean(double *h, const chain *c)
{
    double sum = 0;
    for (int32_t i = 0; i < c->length; i++)
        sum += h[row_of(c, i)];
    double mean = sum / c->length;
    for (int32_t i = 0; i < c->length; i++)
        h[row_of(c, i)] -= mean;
}

/* Second differences of h are -scale f: two sums.  On a ring the first one goes round to 0 and
 * has mean 0, as it is a slope of h. */
static void solve_null(double *h, const chain *c, double scale)
{
    double flow = 0, height = 0;
    subtract_mean(h, c);
    for (int32_t i = 0; i < c->length; i++) {
        flow += scale * h[row_of(c, i)];
        h[row_of(c, i)] = flow;
    }
    if (c->ring)
        subtract_mean(h, c);
    for (int32_t i = 0; i < c->length; i++) {
        double step = h[row_of(c, i)];
        h[row_of(c, i)] = height;
        height -= step;
    }
    subtract_mean(h, c);
}

/* Takes column x out of the image, and puts its solution back. */
static void solve_null_column(const ntp_image *dst, const chain chains[2], int32_t count,
                              const double *sums, double *column, double scale, int32_t x)
{
    for (int32_t y = 0; y < dst->height; y++)
        column[y] = x == 0 ? sums[y] : *(const float *) ntp__at_mut(dst, x, y);
    for (int32_t i = 0; i < count; i++)
        solve_null(column, &chains[i], scale);
    for (int32_t y = 0; y < dst->height; y++)
        *(float *) ntp__at_mut(dst, x, y) = (float) column[y];
}

void ntp__solve_columns(const ntp_image *dst, const ntp__grid_axis *along,
                        const ntp__grid_axis *down, const double *sums, double *column, int32_t x0,
                        int32_t x1)
{
    chain chains[2];
    columns s;
    int32_t count = make_chains(chains, down), n = x1 - x0;
    /* The differences of central slopes are a quarter of -1, 2, -1. */
    double scale = down->central ? 4 : 1;
    init_columns(&s, along, scale, x0, n);
    for (int32_t k = 0; k < n; k++) {
        if (!(s.r[k] > 0))
            solve_null_column(dst, chains, count, sums, column, scale, x0 + k);
    }
    for (int32_t i = 0; i < count; i++) {
        pass_down(&s, dst, &chains[i], scale, x0, n);
        set_entries(&s, &chains[i], n);
        pass_up(&s, dst, &chains[i], x0, n);
    }
}
