/* SPDX-License-Identifier: MIT */
/*
 * vectors_tmpl.h - tap sums to packed RGB of floats, in doubles; of 3 x 3 texels from their heights
 *
 * As encode_vectors of gradient_kernels.c, whose bound holds here too: less than 17u, where u = 2^-53.  Fused
 * products only make errors smaller, and the series adds less than u to those of a root and a quotient.
 * ntp__gradient_exact counts a texel as wide where a number that is off by less than 2^-48 is within 2^-46 of
 * a middle of two floats.  What is computed here is then within 2^-45, so all of these are in doubt.  Others
 * that are in doubt, which depends on the instruction set, change neither floats nor counts.
 *
 * There are two loops, because the long chain of one would leave few steps in flight.
 *
 * PD is a vector of doubles, PARTS as many as make eight; the file that includes this says what is done with
 * them.
 */
enum { STEP = 8, SAMPLES = 3 * STEP };

/* What is closer to the middle of two floats than this part of it is in doubt. */
#define NEARER 0x1p-45

/* (n + 1)/2 is off by no more than this besides. */
#define UNIT_ERROR 0x1p-49

/* The error of a tap sum of floats, as a part of the sum of magnitudes of its differences: each of these has three
 * roundings on its way. */
#define ROUGH 0x1p-51

typedef struct constants {
    PD cx, cy, shortened, side, middle;
    PD factor[2], more[2]; /* of x and y, of z; more is 1/2 where components are (n + 1)/2 */
    PD rough_x, rough_y;   /* the error of a component for what heights that are floats differ by */
    __m256 least;
    bool use_shortened, steep, plain;
} constants;

static ALWAYS_INLINE constants constants_of(const ntp__encode *e)
{
    const double rough = e->rough > 0 ? ROUGH : 0;
    const bool unit[2] = { e->unit, e->unit && !e->zzero };
    constants c = { .cx = SET(e->cx),
                    .cy = SET(e->cy),
                    .shortened = SET(e->shortened),
                    .side = SET((double) e->side),
                    .middle = SET((double) e->middle),
                    .rough_x = SET(fabs(e->cx) * rough),
                    .rough_y = SET(fabs(e->cy) * rough),
                    .least = _mm256_set1_ps((float) (unit[1] ? (e->min_z + 1) / 2 : e->min_z)),
                    .use_shortened = e->use_shortened,
                    .steep = e->steep,
                    .plain = e->plain };
    for (int32_t k = 0; k < 2; k++) {
        c.factor[k] = SET(unit[k] ? 0.5 : 1);
        c.more[k] = SET(unit[k] ? 0.5 : 0);
    }
    return c;
}

/* Eight tap sums to the right and down, and the error of a component that they cause. */
typedef struct pair {
    PD right[PARTS], down[PARTS], rough[PARTS];
} pair;

static inline __m256 difference(const float *a, const float *b)
{
    return _mm256_sub_ps(_mm256_loadu_ps(a), _mm256_loadu_ps(b));
}

static inline __m256 weighted(__m256 sides, __m256 middle, const ntp__encode *e)
{
    return _mm256_fmadd_ps(sides, _mm256_set1_ps(e->side),
                           _mm256_mul_ps(middle, _mm256_set1_ps(e->middle)));
}

/* Differences of heights in doubles. */
static ALWAYS_INLINE PD apart(const float *a, const float *b)
{
    return SUBTRACT(OF_SAMPLES(a), OF_SAMPLES(b));
}

/* What the sum of middle and corners would be without signs. */
static ALWAYS_INLINE PD size_of(PD corners, PD middle, const constants *c)
{
    return FUSED(corners, c->side, MULTIPLY(MAGNITUDE(middle), c->middle));
}

static ALWAYS_INLINE void take_floats(PD *right, PD *down, PD *rough, const void *const from[3],
                                      int32_t i, const constants *c)
{
    const float *above = (const float *) from[0] + i, *at = (const float *) from[1] + i,
                *below = (const float *) from[2] + i;
    const PD falling = apart(below + 2, above), rising = apart(below, above + 2);
    const PD across = apart(at + 2, at), along = apart(below + 1, above + 1);
    *right = FUSED(SUBTRACT(falling, rising), c->side, MULTIPLY(across, c->middle));
    *down = FUSED(ADD(falling, rising), c->side, MULTIPLY(along, c->middle));
    if (c->plain)
        return;
    const PD corners = ADD(MAGNITUDE(falling), MAGNITUDE(rising));
    *rough = FUSED(size_of(corners, across, c), c->rough_x,
                   MULTIPLY(size_of(corners, along, c), c->rough_y));
}

static ALWAYS_INLINE void take(pair *p, const void *const from[3], ntp__packed_from which,
                               int32_t i, const ntp__encode *e, const constants *c)
{
    UNROLLED
    for (int32_t k = 0; k < PARTS; k++)
        p->rough[k] = SET(e->rough);
    if (which == NTP__FROM_INTEGERS) {
        const float *above = (const float *) from[0] + i, *at = (const float *) from[1] + i,
                    *below = (const float *) from[2] + i;
        const __m256 falling = difference(below + 2, above), rising = difference(below, above + 2);
        const __m256 x = weighted(_mm256_sub_ps(falling, rising), difference(at + 2, at), e);
        const __m256 y =
            weighted(_mm256_add_ps(falling, rising), difference(below + 1, above + 1), e);
        UNROLLED
        for (int32_t k = 0; k < PARTS; k++) {
            p->right[k] = OF_FLOATS(x, k);
            p->down[k] = OF_FLOATS(y, k);
        }
    } else if (which == NTP__FROM_FLOATS) {
        UNROLLED
        for (int32_t k = 0; k < PARTS; k++)
            take_floats(&p->right[k], &p->down[k], &p->rough[k], from, i + k * STEP / PARTS, c);
    } else if (which == NTP__FROM_SUMS_I) {
        UNROLLED
        for (int32_t k = 0; k < PARTS; k++) {
            p->right[k] = OF_INTEGERS((const int32_t *) from[0] + i + k * STEP / PARTS);
            p->down[k] = OF_INTEGERS((const int32_t *) from[1] + i + k * STEP / PARTS);
        }
    } else {
        UNROLLED
        for (int32_t k = 0; k < PARTS; k++) {
            p->right[k] = LOAD((const double *) from[0] + i + k * STEP / PARTS);
            p->down[k] = LOAD((const double *) from[1] + i + k * STEP / PARTS);
        }
    }
}

/* Eight components as floats, and bits of those in doubt. */
static ALWAYS_INLINE __m256 rounded(const PD v[PARTS], const PD rough[PARTS], const constants *c,
                                    int32_t k, uint32_t *left)
{
    PD least[PARTS], most[PARTS];
    UNROLLED
    for (int32_t i = 0; i < PARTS; i++) {
        const PD t = FUSED(v[i], c->factor[k], c->more[k]);
        const PD error = FUSED(rough[i], c->factor[k], MULTIPLY(c->more[k], SET(2 * UNIT_ERROR)));
        const PD off = FUSED(MAGNITUDE(t), SET(NEARER), error);
        least[i] = SUBTRACT(t, off);
        most[i] = ADD(t, off);
    }
    const __m256 low = TO_FLOATS(least), high = TO_FLOATS(most);
    *left |= DIFFERING(low, high);
    return low;
}

/* 1/sqrt(v) for v up to 2^126.  The processor's r is off by less than 1.51 2^-12 of it, so h = 1 - v r^2 is
 * less than 2^-10.4, and what the series leaves out is less than 2^-54. */
static ALWAYS_INLINE PD over_root(PD v)
{
    const PD r = GUESS(v), h = REST(MULTIPLY(v, r), r, SET(1));
    PD s = FUSED(SET(35.0 / 128), h, SET(5.0 / 16));
    s = FUSED(s, h, SET(3.0 / 8));
    s = FUSED(s, h, SET(1.0 / 2));
    return FUSED(MULTIPLY(r, h), s, r);
}

/* Slopes, z of their normals, and the error of a component. */
typedef struct planes {
    _Alignas(64) double x[NTP__BLOCK], y[NTP__BLOCK], z[NTP__BLOCK], rough[NTP__BLOCK];
} planes;

static ALWAYS_INLINE void put_slopes(planes *p, int32_t i, const pair *s, const constants *c)
{
    UNROLLED
    for (int32_t k = 0; k < PARTS; k++) {
        const PD x = MULTIPLY(s->right[k], c->cx), y = MULTIPLY(s->down[k], c->cy);
        const PD square = FUSED(x, x, FUSED(y, y, SET(1)));
        if (!c->plain)
            STORE(p->rough + i + k * STEP / PARTS, s->rough[k]);
        STORE(p->x + i + k * STEP / PARTS, x);
        STORE(p->y + i + k * STEP / PARTS, y);
        STORE(p->z + i + k * STEP / PARTS,
              c->steep ? DIVIDE(SET(1), ROOT(square)) : over_root(square));
    }
}

/* Eight texels; returns bits of those in doubt. */
static ALWAYS_INLINE uint32_t encode_step(float *d, const planes *p, int32_t i, const constants *c)
{
    const __m256 none = _mm256_setzero_ps();
    __m256 f[3];
    PD n[3][PARTS], rough[PARTS];
    uint32_t left = 0;
    UNROLLED
    for (int32_t k = 0; k < PARTS; k++) {
        const PD x = LOAD(p->x + i + k * STEP / PARTS), y = LOAD(p->y + i + k * STEP / PARTS);
        PD factor = LOAD(p->z + i + k * STEP / PARTS);
        n[2][k] = factor;
        if (c->use_shortened)
            factor = LESSER(DIVIDE(c->shortened, ROOT(FUSED(x, x, MULTIPLY(y, y)))), factor);
        n[0][k] = MULTIPLY(x, factor);
        n[1][k] = MULTIPLY(y, factor);
    }
    if (c->plain) {
        left = near_middle(n);
        UNROLLED
        for (int32_t k = 0; k < 3; k++)
            f[k] = TO_FLOATS(n[k]);
    } else {
        UNROLLED
        for (int32_t k = 0; k < PARTS; k++)
            rough[k] = LOAD(p->rough + i + k * STEP / PARTS);
        UNROLLED
        for (int32_t k = 0; k < 3; k++)
            f[k] = rounded(n[k], rough, c, k / 2, &left);
    }
    put_floats(d, _mm256_add_ps(f[0], none), _mm256_add_ps(f[1], none), /* never -0 */
               _mm256_max_ps(f[2], c->least));
    return left;
}

int32_t NAME(float *d, int32_t *at, const void *const from[3], ntp__packed_from which, int32_t n,
             const ntp__encode *e)
{
    const constants c = constants_of(e);
    int32_t found = 0;
    planes p;
    for (int32_t i = 0; i < n; i += STEP) {
        pair sums;
        FETCH(e->ahead + 3 * sizeof *d * (size_t) i);
        take(&sums, from, which, i, e, &c);
        put_slopes(&p, i, &sums, &c);
    }
    for (int32_t i = 0; i < n; i += STEP) {
        float last[SAMPLES];
        const bool whole = n - i >= STEP;
        FETCH(e->ahead + 3 * sizeof *d * (size_t) i + 64);
        uint32_t left = encode_step(whole ? d + 3 * i : last, &p, i, &c);
        if (!whole) {
            memcpy(d + 3 * i, last, sizeof *d * 3 * (size_t) (n - i));
            left &= (1U << (n - i)) - 1;
        }
        for (; left != 0; left &= left - 1)
            at[found++] = i + __builtin_ctz(left);
    }
    end_lanes();
    return found;
}
