/* SPDX-License-Identifier: MIT */
/*
 * fft_butterflies_tmpl.h - complex Fourier transform of interleaved lines, for fft_lines_tmpl.h
 *
 * Stockham's algorithm (no bit reversal) with radices 4, 2, 3 and 5.  NAME(x) and REAL are those of
 * the precision.  A cell is one complex element of all lines: LANES real parts, then LANES
 * imaginary ones.
 */

#define EACH_LANE for (int32_t l = 0; l < LANES; l++)

/* out = (re + i im) times (w[0] + i w[1]) */
static ALWAYS_INLINE void NAME(store_turned)(REAL *restrict out, const REAL *restrict re,
                                             const REAL *restrict im, const REAL w[2])
{
    REAL c = w[0], s = w[1];
    EACH_LANE
    {
        out[l] = re[l] * c - im[l] * s;
        out[l + LANES] = re[l] * s + im[l] * c;
    }
}

static ALWAYS_INLINE void NAME(radix2)(REAL *restrict y, const REAL *restrict x, size_t in,
                                       size_t out, const REAL w[][2])
{
    REAL re[LANES], im[LANES];
    EACH_LANE
    {
        const REAL *b = x + in + l;
        REAL ar = x[l], ai = x[l + LANES], br = b[0], bi = b[LANES];
        y[l] = ar + br;
        y[l + LANES] = ai + bi;
        re[l] = ar - br;
        im[l] = ai - bi;
    }
    NAME(store_turned)(y + out, re, im, w[1]);
}

static ALWAYS_INLINE void NAME(radix3)(REAL *restrict y, const REAL *restrict x, size_t in,
                                       size_t out, const REAL w[][2])
{
    const REAL half = (REAL) 0.5, half_root3 = (REAL) 0.86602540378443864676;
    REAL re[2][LANES], im[2][LANES];
    EACH_LANE
    {
        const REAL *b = x + in + l, *c = x + 2 * in + l;
        REAL ar = x[l], ai = x[l + LANES];
        REAL sr = b[0] + c[0], si = b[LANES] + c[LANES];
        REAL dr = (b[0] - c[0]) * half_root3, di = (b[LANES] - c[LANES]) * half_root3;
        REAL mr = ar - half * sr, mi = ai - half * si;
        y[l] = ar + sr;
        y[l + LANES] = ai + si;
        re[0][l] = mr + di;
        im[0][l] = mi - dr;
        re[1][l] = mr - di;
        im[1][l] = mi + dr;
    }
    NAME(store_turned)(y + out, re[0], im[0], w[1]);
    NAME(store_turned)(y + 2 * out, re[1], im[1], w[2]);
}

static ALWAYS_INLINE void NAME(radix4)(REAL *restrict y, const REAL *restrict x, size_t in,
                                       size_t out, const REAL w[][2])
{
    REAL re[3][LANES], im[3][LANES];
    EACH_LANE
    {
        const REAL *b = x + in + l, *c = x + 2 * in + l, *d = x + 3 * in + l;
        REAL acr = x[l] + c[0], aci = x[l + LANES] + c[LANES];
        REAL amr = x[l] - c[0], ami = x[l + LANES] - c[LANES];
        REAL bdr = b[0] + d[0], bdi = b[LANES] + d[LANES];
        REAL bmr = b[0] - d[0], bmi = b[LANES] - d[LANES];
        y[l] = acr + bdr;
        y[l + LANES] = aci + bdi;
        re[0][l] = amr + bmi;
        im[0][l] = ami - bmr;
        re[1][l] = acr - bdr;
        im[1][l] = aci - bdi;
        re[2][l] = amr - bmi;
        im[2][l] = ami + bmr;
    }
    NAME(store_turned)(y + out, re[0], im[0], w[1]);
    NAME(store_turned)(y + 2 * out, re[1], im[1], w[2]);
    NAME(store_turned)(y + 3 * out, re[2], im[2], w[3]);
}

static ALWAYS_INLINE void NAME(radix5)(REAL *restrict y, const REAL *restrict x, size_t in,
                                       size_t out, const REAL w[][2])
{
    const REAL c1 = (REAL) 0.30901699437494742410, c2 = (REAL) -0.80901699437494742410;
    const REAL s1 = (REAL) 0.95105651629515357212, s2 = (REAL) 0.58778525229247312917;
    REAL re[4][LANES], im[4][LANES];
    EACH_LANE
    {
        const REAL *b = x + in + l, *c = x + 2 * in + l, *d = x + 3 * in + l, *e = x + 4 * in + l;
        REAL ar = x[l], ai = x[l + LANES];
        REAL ber = b[0] + e[0], bei = b[LANES] + e[LANES];
        REAL cdr = c[0] + d[0], cdi = c[LANES] + d[LANES];
        REAL bmr = b[0] - e[0], bmi = b[LANES] - e[LANES];
        REAL cmr = c[0] - d[0], cmi = c[LANES] - d[LANES];
        REAL m1r = ar + c1 * ber + c2 * cdr, m1i = ai + c1 * bei + c2 * cdi;
        REAL m2r = ar + c2 * ber + c1 * cdr, m2i = ai + c2 * bei + c1 * cdi;
        REAL n1r = s1 * bmr + s2 * cmr, n1i = s1 * bmi + s2 * cmi;
        REAL n2r = s2 * bmr - s1 * cmr, n2i = s2 * bmi - s1 * cmi;
        y[l] = ar + ber + cdr;
        y[l + LANES] = ai + bei + cdi;
        re[0][l] = m1r + n1i;
        im[0][l] = m1i - n1r;
        re[1][l] = m2r + n2i;
        im[1][l] = m2i - n2r;
        re[2][l] = m2r - n2i;
        im[2][l] = m2i + n2r;
        re[3][l] = m1r - n1i;
        im[3][l] = m1i + n1r;
    }
    for (size_t k = 0; k < 4; k++)
        NAME(store_turned)(y + (k + 1) * out, re[k], im[k], w[k + 1]);
}

/* A stage: `left` is the length still to be transformed, `stride` the product of radices done. */
#define STAGE(RADIX)                                                                               \
    static void NAME(stage##RADIX)(REAL *restrict y, const REAL *restrict x, const REAL *turns,    \
                                   size_t left, size_t stride)                                     \
    {                                                                                              \
        size_t m = left / (RADIX);                                                                 \
        for (size_t p = 0; p < m; p++) {                                                           \
            REAL w[RADIX][2];                                                                      \
            for (size_t k = 1; k < (RADIX); k++) {                                                 \
                w[k][0] = turns[2 * p * k * stride];                                               \
                w[k][1] = turns[2 * p * k * stride + 1];                                           \
            }                                                                                      \
            const REAL *from = x + CELL * stride * p;                                              \
            REAL *to = y + CELL * stride * (RADIX) * p;                                            \
            for (size_t q = 0; q < stride; q++, from += CELL, to += CELL)                          \
                NAME(radix##RADIX)                                                                 \
            (to, from, CELL * stride * m, CELL * stride, (const REAL(*)[2]) w);                    \
        }                                                                                          \
    }

STAGE(2)
STAGE(3)
STAGE(4)
STAGE(5)
#undef STAGE

/* Transforms a, with b as working memory; returns the one that holds the result. */
static REAL *NAME(transform)(const ntp__fft *fft, REAL *a, REAL *b)
{
    size_t left = (size_t) fft->m, stride = 1;
    for (int32_t i = 0; i < fft->stages; i++) {
        size_t radix = (size_t) fft->radix[i];
        if (radix == 4)
            NAME(stage4)(b, a, fft->turns, left, stride);
        else if (radix == 2)
            NAME(stage2)(b, a, fft->turns, left, stride);
        else if (radix == 3)
            NAME(stage3)(b, a, fft->turns, left, stride);
        else
            NAME(stage5)(b, a, fft->turns, left, stride);
        left /= radix;
        stride *= radix;
        REAL *swap = a;
        a = b;
        b = swap;
    }
    return a;
}

/* a times (w[0] + i w[1]) */
static ALWAYS_INLINE void NAME(turn)(REAL *a, const REAL w[2])
{
    REAL c = w[0], s = w[1];
    EACH_LANE
    {
        REAL re = a[l], im = a[l + LANES];
        a[l] = re * c - im * s;
        a[l + LANES] = re * s + im * c;
    }
}

static void NAME(exchange_parts)(REAL *a, size_t n)
{
    for (size_t i = 0; i < n; i++, a += CELL) {
        EACH_LANE
        {
            REAL re = a[l];
            a[l] = a[l + LANES];
            a[l + LANES] = re;
        }
    }
}

/* The transform over fft->period, by Bluestein's way if needed: k i = (k*k + i*i - (k - i)^2)/2. */
static REAL *NAME(transform_any)(const ntp__fft *fft, REAL *a, REAL *b)
{
    if (fft->chirp == NULL)
        return NAME(transform)(fft, a, b);
    size_t n = (size_t) fft->period, m = (size_t) fft->m;
    const REAL *chirp = fft->chirp, *response = fft->response;
    for (size_t i = 0; i < n; i++)
        NAME(turn)(a + CELL * i, chirp + 2 * i);
    memset(a + CELL * n, 0, (m - n) * CELL * sizeof *a);
    REAL *c = NAME(transform)(fft, a, b);
    for (size_t i = 0; i < m; i++)
        NAME(turn)(c + CELL * i, response + 2 * i);
    /* The inverse is the transform with real and imaginary parts exchanged. */
    NAME(exchange_parts)(c, m);
    c = NAME(transform)(fft, c, c == a ? b : a);
    NAME(exchange_parts)(c, n);
    for (size_t i = 0; i < n; i++)
        NAME(turn)(c + CELL * i, chirp + 2 * i);
    return c;
}

/* The transform of the conjugate chirp, continued to negative indices. */
SELDOM static void NAME(respond)(const ntp__fft *fft, void *work)
{
    size_t n = (size_t) fft->period, m = (size_t) fft->m;
    REAL *a = work, *response = fft->response;
    const REAL *chirp = fft->chirp;
    memset(a, 0, m * CELL * sizeof *a);
    for (size_t i = 0; i < n; i++) {
        a[CELL * i] = a[CELL * ((m - i) % m)] = chirp[2 * i];
        a[CELL * i + LANES] = a[CELL * ((m - i) % m) + LANES] = -chirp[2 * i + 1];
    }
    const REAL *z = NAME(transform)(fft, a, a + CELL * m);
    for (size_t i = 0; i < m; i++) {
        response[2 * i] = z[CELL * i] / (REAL) m;
        response[2 * i + 1] = z[CELL * i + LANES] / (REAL) m;
    }
}
