/* SPDX-License-Identifier: MIT */
/*
 * fft_lines_tmpl.h - transforms of a batch of rows in one precision; included with REAL and NAME(x)
 *
 * Row r lies in lane r of the cells: the real parts of 8 complex lines, then the imaginary parts.
 * The DCT-II is Makhoul's: even texels forwards, odd ones backwards, a Fourier transform, and a
 * turn of each pair of frequencies k, n - k.  The DCT-I is the Fourier transform of the row and its
 * mirror image.  Rows and cells change places in tiles, so that both are walked along.
 */
#include "to_height/shared/fft_butterflies_tmpl.h"

/* ------------------------------------------------------------------- pairs of frequencies */

/* Where element i of a row goes: evens forward, then odds backward, for the DCT-II. */
static ALWAYS_INLINE size_t NAME(place)(const ntp__fft *fft, size_t i)
{
    if (fft->kind != NTP__FFT_COSINE)
        return i;
    return i % 2 == 0 ? i / 2 : (size_t) fft->n - 1 - i / 2;
}

/* Turns the real and the imaginary part of a frequency into a pair of cosine coefficients.  It is a
 * reflection, so it undoes itself. */
static ALWAYS_INLINE void NAME(turn_pair)(REAL *restrict re, REAL *restrict im, const REAL w[2])
{
    REAL c = w[0], s = w[1];
    for (int32_t r = 0; r < CELL; r++) {
        REAL a = re[r], b = im[r];
        re[r] = c * a + s * b;
        im[r] = s * a - c * b;
    }
}

/* The coefficients of each row at k (re) and at n - k (im), from the cells at k and n - k. */
OF_A_PAIR void NAME(split)(const ntp__fft *fft, REAL re[CELL], REAL im[CELL], const REAL *z,
                           size_t k)
{
    const REAL half = (REAL) 0.5, *quarter = fft->quarter;
    size_t n = (size_t) fft->n;
    const REAL *u = z + CELL * k, *v = z + CELL * (k == 0 ? 0 : n - k);
    EACH_LANE
    {
        re[l] = half * (u[l] + v[l]);
        im[l] = half * (u[l + LANES] - v[l + LANES]);
        re[l + LANES] = half * (u[l + LANES] + v[l + LANES]);
        im[l + LANES] = half * (v[l] - u[l]);
    }
    if (fft->kind == NTP__FFT_COSINE)
        NAME(turn_pair)(re, im, quarter + 2 * k);
}

/* The other way round, times scale, with real and imaginary parts exchanged: then the forward
 * transform is the inverse one. */
OF_A_PAIR void NAME(join)(const ntp__fft *fft, REAL *z, REAL re[CELL], REAL im[CELL], size_t k,
                          REAL scale)
{
    const REAL *quarter = fft->quarter;
    size_t n = (size_t) fft->n;
    bool single = k == 0 || 2 * k == n;
    if (fft->kind == NTP__FFT_COSINE && k > 0) {
        if (single)
            memcpy(im, re, CELL * sizeof *im);
        NAME(turn_pair)(re, im, quarter + 2 * k);
    }
    if (single)
        memset(im, 0, CELL * sizeof *im);
    REAL *u = z + CELL * k, *v = z + CELL * (k == 0 ? 0 : n - k);
    EACH_LANE
    {
        REAL ar = re[l], ai = im[l], br = re[l + LANES], bi = im[l + LANES];
        v[l + LANES] = scale * (ar + bi);
        v[l] = scale * (br - ai);
        u[l + LANES] = scale * (ar - bi);
        u[l] = scale * (ai + br);
    }
}

/* Completes cells 0..n - 1 to a period with even symmetry. */
ONE_COPY static void NAME(reflect)(const ntp__fft *fft, REAL *z)
{
    size_t period = (size_t) fft->period;
    for (size_t i = 1; 2 * i < period; i++)
        memcpy(z + CELL * (period - i), z + CELL * i, CELL * sizeof *z);
}

/* -------------------------------------------------------------------------------- tiles */

/* From lines behind the first array to cells in it. */
static void NAME(gather)(const ntp__fft *fft, REAL *a)
{
    size_t n = (size_t) fft->n;
    const REAL *lines = a + CELL * (size_t) fft->m;
    for (size_t i = 0; i < n; i += TILE) {
        REAL tile[TILE][CELL];
        size_t count = n - i < TILE ? n - i : TILE;
        for (size_t r = 0; r < CELL; r++) {
            for (size_t j = 0; j < count; j++)
                tile[j][r] = lines[r * n + i + j];
        }
        for (size_t j = 0; j < count; j++)
            memcpy(a + CELL * NAME(place)(fft, i + j), tile[j], sizeof tile[j]);
    }
}

ONE_COPY static void NAME(tile_to_rows)(float *const rows[CELL], size_t at,
                                        const REAL tile[TILE][CELL], size_t count)
{
    for (size_t r = 0; r < CELL; r++) {
        for (size_t j = 0; j < count; j++)
            rows[r][at + j] = (float) tile[j][r];
    }
}

ONE_COPY static void NAME(rows_to_tile)(REAL tile[TILE][CELL], float *const rows[CELL], size_t at,
                                        size_t count)
{
    for (size_t r = 0; r < CELL; r++) {
        for (size_t j = 0; j < count; j++)
            tile[j][r] = rows[r][at + j];
    }
}

/* ------------------------------------------------------------------------------ transforms */

/* Tiles of coefficients at k and, reversed, at n - k. */
static void NAME(write_pairs)(const ntp__fft *fft, float *const rows[CELL], const REAL *z)
{
    size_t n = (size_t) fft->n, pairs = n / 2 + 1;
    for (size_t k = 0; k < pairs; k += TILE) {
        REAL re[TILE][CELL], im[TILE][CELL];
        size_t count = pairs - k < TILE ? pairs - k : TILE;
        for (size_t j = 0; j < count; j++)
            NAME(split)(fft, re[j], im[TILE - 1 - j], z, k + j);
        NAME(tile_to_rows)(rows, k, (const REAL(*)[CELL]) re, count);
        /* im[TILE - 1 - j] is at n - k - j: none for the first and a middle one. */
        size_t first = k == 0, last = 2 * (k + count - 1) == n ? count - 1 : count;
        if (last > first)
            NAME(tile_to_rows)
        (rows, n - k - (last - 1), (const REAL(*)[CELL]) im + (TILE - last), last - first);
    }
}

static void NAME(read_pairs)(const ntp__fft *fft, REAL *z, float *const rows[CELL])
{
    size_t n = (size_t) fft->n, pairs = n / 2 + 1;
    REAL scale = 1 / (REAL) fft->n;
    for (size_t k = 0; k < pairs; k += TILE) {
        REAL re[TILE][CELL], im[TILE][CELL];
        size_t count = pairs - k < TILE ? pairs - k : TILE;
        size_t first = k == 0, last = 2 * (k + count - 1) == n ? count - 1 : count;
        NAME(rows_to_tile)(re, rows, k, count);
        if (last > first)
            NAME(rows_to_tile)(im + (TILE - last), rows, n - k - (last - 1), last - first);
        for (size_t j = 0; j < count; j++)
            NAME(join)(fft, z, re[j], im[TILE - 1 - j], k + j, scale);
    }
}

static void NAME(forward)(const ntp__fft *fft, float *const rows[CELL], void *work)
{
    REAL *a = work, *b = a + CELL * (size_t) fft->m;
    size_t n = (size_t) fft->n;
    NAME(gather)(fft, a);
    if (fft->kind != NTP__FFT_MIRROR) {
        NAME(write_pairs)(fft, rows, NAME(transform_any)(fft, a, b));
        return;
    }
    NAME(reflect)(fft, a);
    REAL *z = NAME(transform_any)(fft, a, b);
    for (size_t k = 0; k < n; k += TILE)
        NAME(tile_to_rows)
    (rows, k, (const REAL(*)[CELL])(z + CELL * k), n - k < TILE ? n - k : TILE);
}

/* From cells back to rows; `turned`: real and imaginary parts are exchanged. */
ONE_COPY static void NAME(scatter)(const ntp__fft *fft, float *const rows[CELL], const REAL *z,
                                   bool turned)
{
    size_t n = (size_t) fft->n;
    for (size_t i = 0; i < n; i += TILE) {
        REAL tile[TILE][CELL];
        size_t count = n - i < TILE ? n - i : TILE;
        for (size_t j = 0; j < count; j++) {
            const REAL *cell = z + CELL * NAME(place)(fft, i + j);
            EACH_LANE
            {
                tile[j][l] = turned ? cell[l + LANES] : cell[l];
                tile[j][l + LANES] = turned ? cell[l] : cell[l + LANES];
            }
        }
        NAME(tile_to_rows)(rows, i, (const REAL(*)[CELL]) tile, count);
    }
}

static void NAME(inverse)(const ntp__fft *fft, float *const rows[CELL], void *work)
{
    REAL *a = work, *b = a + CELL * (size_t) fft->m;
    size_t n = (size_t) fft->n;
    if (fft->kind != NTP__FFT_MIRROR) {
        NAME(read_pairs)(fft, a, rows);
        NAME(scatter)(fft, rows, NAME(transform_any)(fft, a, b), true);
        return;
    }
    REAL scale = 1 / (REAL) fft->period;
    for (size_t k = 0; k < n; k += TILE)
        NAME(rows_to_tile)
    ((REAL(*)[CELL])(a + CELL * k), rows, k, n - k < TILE ? n - k : TILE);
    for (size_t i = 0; i < CELL * n; i++)
        a[i] *= scale;
    NAME(reflect)(fft, a);
    NAME(scatter)(fft, rows, NAME(transform_any)(fft, a, b), false);
}

/* ----------------------------------------------------------------------------- columns */

static ALWAYS_INLINE void NAME(multiply)(REAL a[CELL], const double factor[CELL])
{
    for (int32_t r = 0; r < CELL; r++)
        a[r] = (REAL) ((double) a[r] * factor[r]);
}

/* Multiplies each frequency and gets ready for the transform back, in place. */
static void NAME(multiply_all)(const ntp__fft *fft, REAL *z, ntp__fft_factors_fn *factors,
                               const void *user)
{
    size_t n = (size_t) fft->n;
    double factor[CELL];
    REAL scale = 1 / (REAL) fft->period;
    if (fft->kind == NTP__FFT_MIRROR) {
        for (size_t k = 0; k < n; k++) {
            factors(user, (int32_t) k, factor);
            for (size_t r = 0; r < CELL; r++)
                z[CELL * k + r] *= scale;
            NAME(multiply)(z + CELL * k, factor);
        }
        NAME(reflect)(fft, z);
        return;
    }
    for (size_t k = 0; 2 * k <= n; k++) {
        REAL re[CELL], im[CELL];
        NAME(split)(fft, re, im, z, k);
        factors(user, (int32_t) k, factor);
        NAME(multiply)(re, factor);
        if (fft->kind == NTP__FFT_COSINE && k > 0)
            factors(user, (int32_t) (n - k), factor);
        NAME(multiply)(im, factor);
        NAME(join)(fft, z, re, im, k, scale);
    }
}

static void NAME(filter)(const ntp__fft *fft, float *first, ptrdiff_t stride, int32_t columns,
                         ntp__fft_factors_fn *factors, const void *user, void *work)
{
    REAL *a = work, *b = a + CELL * (size_t) fft->m;
    size_t n = (size_t) fft->n, count = (size_t) columns;
    bool mirror = fft->kind == NTP__FFT_MIRROR;
    memset(a, 0, CELL * n * sizeof *a);
    for (size_t i = 0; i < n; i++) {
        REAL *cell = a + CELL * NAME(place)(fft, i);
        for (size_t r = 0; r < count; r++)
            cell[r] = first[(ptrdiff_t) i * stride + (ptrdiff_t) r];
    }
    if (mirror)
        NAME(reflect)(fft, a);
    REAL *z = NAME(transform_any)(fft, a, b);
    NAME(multiply_all)(fft, z, factors, user);
    z = NAME(transform_any)(fft, z, z == a ? b : a);
    for (size_t i = 0; i < n; i++) {
        const REAL *cell = z + CELL * NAME(place)(fft, i);
        for (size_t r = 0; r < count; r++)
            first[(ptrdiff_t) i * stride + (ptrdiff_t) r] =
                (float) cell[mirror ? r : (r + LANES) % CELL];
    }
}

#undef EACH_LANE
