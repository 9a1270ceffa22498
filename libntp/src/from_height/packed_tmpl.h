/* SPDX-License-Identifier: MIT */
/*
 * packed_tmpl.h - a part of gradient.c: blocks that go from tap sums to packed RGB in one step
 */

/* May blocks be that?  Their slopes to the right and down have the same factor then. */
static bool can_pack(const walk *w)
{
    const ntp__gradient *g = &w->g;
    const double x = w->encode.cx, y = w->encode.cy;
    return g->loops->encode_packed != NULL && g->m > 0 && g->derived &&
           g->dst->encoding == NTP_ENCODING_STANDARD && g->dst->channels == 3 &&
           g->dst->pixel_stride == 3 * ntp__sample_size(g->dst->type) && !w->encode.use_shortened &&
           x != 0 && (x == y || x == -y);
}

/*
 * May they go there from three rows of heights?  Floats then leave no more in doubt where levels are those
 * of 8 bit.
 */
static bool can_be_quick(const walk *w)
{
    static const double most_exact = 0x1p24;
    const ntp__gradient *g = &w->g;
    const ntp__kernel *k = g->kernel;
    const bool possible = g->loops->take_heights != NULL;
    const bool symmetric = k->radius == 1 && k->term[0].along[NTP__MAX_RADIUS] == 0;
    const bool gray = g->reads == 1 && g->src->pixel_stride == ntp__sample_size(g->src->type);
    return possible && symmetric && gray && g->border_x != NTP_BORDER_EXTRAPOLATE &&
           g->border_y != NTP_BORDER_EXTRAPOLATE &&
           (w->floats ? g->m <= 255 : w->single && w->greatest < most_exact);
}

static void put_pixel(const walk *w, int32_t x, int32_t y, const int32_t c[3])
{
    void *d = ntp__at_mut(w->g.dst, x, y);
    for (int32_t k = 0; k < 3; k++) {
        if (w->g.m > 255)
            ((uint16_t *) d)[k] = (uint16_t) c[k];
        else
            ((uint8_t *) d)[k] = (uint8_t) c[k];
    }
}

/* Is v, off by less than 2^-48 of it, on the same side of whole numbers as what it stands for?  What is not
 * so by this is more than ntp__gradient_exact counts as wide. */
static bool is_apart(double v)
{
    const double over = v - (int32_t) (v + 0.5);
    return fabs(over) >= v * 0x1p-45;
}

/*
 * Does double decide a texel although it is close to a level?  Its loop takes whole units of 2^-15.
 * Slopes of nearly flat ground are nearly proportional to sums, so where M cx / 2 is a simple ratio
 * many of these are close to a level.
 */
static bool is_decided(const ntp__encode *e, double right, double down)
{
    const double x = right * e->cx, y = down * e->cy;
    const double factor = e->half / sqrt(1 + (x * x + y * y));
    return e->off <= 1 && is_apart(fabs(x) * factor) && is_apart(fabs(y) * factor);
}

/* Does texels once more in double, and exactly where that leaves a doubt. */
static void settle_packed(walk *w, const strip *s, const int32_t *at, int32_t found, int32_t x,
                          int32_t y)
{
    int32_t level[3][NTP__BLOCK], doubt[NTP__BLOCK];
    double sums[2][NTP__BLOCK];
    int32_t *const to[3] = { level[0], level[1], level[2] };
    sums_as_doubles(sums, w, s, at, found);
    encode_precisely(w, to, doubt, sums, found);
    for (int32_t i = 0; i < found; i++) {
        int32_t c[3] = { level[0][i], level[1][i], level[2][i] };
        const bool again = doubt[i] && !is_decided(&w->encode, sums[0][i], sums[1][i]);
        if (again) {
            ntp__normal normal;
            settle_exactly(w, s, &normal, x, y, at[i]);
            memcpy(c, normal.level, sizeof c);
        }
        if (again || c[2] < 0)
            c[2] = ntp__derive(&c[0], &c[1], w->g.m, false);
        put_pixel(w, x + at[i], y, c);
    }
}

/* Are the loops in float within their limits? */
static bool trust_packed(walk *w, const facts *f)
{
    static const double most = 0x1p60; /* of what the kernel takes */
    return w->floats ? w->greatest * f->most <= most && trust_floats(w, f) && w->single : w->single;
}

/* The tap sums of some texels of a block, to where the others of all would be. */
static void sums_of_places(const walk *w, strip *s, const float *const rows[3], const int32_t *at,
                           int32_t found)
{
    const double side = (double) w->encode.side, middle = (double) w->encode.middle;
    for (int32_t i = 0; i < found; i++) {
        const float *above = rows[0] + at[i], *same = rows[1] + at[i], *below = rows[2] + at[i];
        const double left = (double) below[0] - (double) above[0],
                     right = (double) below[2] - (double) above[2],
                     top = (double) above[2] - (double) above[0],
                     bottom = (double) below[2] - (double) below[0];
        const double x = side * (top + bottom) + middle * ((double) same[2] - (double) same[0]);
        const double y = side * (left + right) + middle * ((double) below[1] - (double) above[1]);
        if (w->ints) {
            s->sums.i[0][at[i]] = (int32_t) x;
            s->sums.i[1][at[i]] = (int32_t) y;
        } else {
            s->sums.d[0][at[i]] = x;
            s->sums.d[1][at[i]] = y;
        }
    }
}

/* The heights of a block. */
static facts rows_of_heights(walk *w, strip *s, const float *rows[3], int32_t x, int32_t y,
                             int32_t n)
{
    facts f = { true, 0x1p1000, 0 };
    float low = 0x1p127F, high = -0x1p127F;
    for (int32_t k = 0; k < 3; k++) {
        ntp__height_row *row = &s->row[(y + k) % 3];
        if (!row->filled || row->y != y + k - 1 || !row->quick)
            ntp__height_row_floats(row, &w->g, x, y + k - 1, n);
        rows[k] = row->h.f + NTP__MAX_RADIUS - 1;
        add_facts(&f, row);
        low = row->low < low ? row->low : low;
        high = row->high > high ? row->high : high;
    }
    w->encode.spread = (double) high - (double) low;
    return f;
}

/* A block from its heights; false: it has to be done the other way. */
static bool encode_rows(walk *w, strip *s, int32_t x, int32_t y, int32_t n)
{
    const float *rows[3];
    int32_t at[NTP__BLOCK];
    const facts f = rows_of_heights(w, s, rows, x, y, n);
    if (!trust_packed(w, &f))
        return false;
    const void *const from[3] = { rows[0], rows[1], rows[2] };
    const int32_t found = w->encode_rows(ntp__at_mut(w->g.dst, x, y), at, from,
                                         w->ints ? NTP__FROM_INTEGERS : NTP__FROM_FLOATS, n,
                                         &w->encode, w->g.m > 255);
    if (found > 0) {
        sums_of_places(w, s, rows, at, found);
        settle_packed(w, s, at, found, x, y);
    }
    return found >= 0;
}

/* A block from its tap sums; false: it has to be done the other way. */
static bool encode_packed(walk *w, const strip *s, const facts *f, int32_t x, int32_t y, int32_t n)
{
    const void *const sums[3] = { w->ints ? (const void *) s->sums.i[0] : s->sums.d[0],
                                  w->ints ? (const void *) s->sums.i[1] : s->sums.d[1] };
    int32_t at[NTP__BLOCK];
    if (!w->packed || s->any_moved || !trust_packed(w, f))
        return false;
    const int32_t found = w->g.loops->encode_packed(ntp__at_mut(w->g.dst, x, y), at, sums,
                                                    w->ints ? NTP__FROM_SUMS_I : NTP__FROM_SUMS_D,
                                                    n, &w->encode, w->g.m > 255);
    if (found > 0)
        settle_packed(w, s, at, found, x, y);
    return true;
}
