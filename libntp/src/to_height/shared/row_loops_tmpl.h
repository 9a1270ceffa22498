/* SPDX-License-Identifier: MIT */
/*
 * row_loops_tmpl.h - sums over rows in one precision; included with REAL and NAME(x)
 */

static void NAME(set_pair)(void *f, const void *a, double wa, const void *b, double wb, int32_t n)
{
    REAL *restrict to = f;
    const REAL *restrict first = a, *restrict second = b;
    REAL u = (REAL) wa, v = (REAL) wb;
    for (int32_t i = 0; i < n; i++)
        to[i] = u * first[i] + v * second[i];
}

static void NAME(add_pair)(void *f, const void *a, double wa, const void *b, double wb, int32_t n)
{
    REAL *restrict to = f;
    const REAL *restrict first = a, *restrict second = b;
    REAL u = (REAL) wa, v = (REAL) wb;
    for (int32_t i = 0; i < n; i++)
        to[i] += u * first[i] + v * second[i];
}

/* The sums of every eighth number, and then of these eight. */
static double NAME(sum)(const void *f, int32_t n)
{
    const REAL *row = f;
    double part[LANES] = { 0 }, sum = 0;
    int32_t whole = n - n % LANES;
    for (int32_t i = 0; i < whole; i += LANES) {
        for (int32_t l = 0; l < LANES; l++)
            part[l] += (double) row[i + l];
    }
    for (int32_t i = whole; i < n; i++)
        part[i - whole] += (double) row[i];
    for (int32_t l = 0; l < LANES; l++)
        sum += part[l];
    return sum;
}

static double NAME(sum_squares)(const void *f, int32_t n)
{
    const REAL *row = f;
    double part[LANES] = { 0 }, sum = 0;
    int32_t whole = n - n % LANES;
    for (int32_t i = 0; i < whole; i += LANES) {
        for (int32_t l = 0; l < LANES; l++)
            part[l] += (double) row[i + l] * (double) row[i + l];
    }
    for (int32_t i = whole; i < n; i++)
        part[i - whole] += (double) row[i] * (double) row[i];
    for (int32_t l = 0; l < LANES; l++)
        sum += part[l];
    return sum;
}
