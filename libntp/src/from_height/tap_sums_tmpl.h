/* SPDX-License-Identifier: MIT */
/*
 * tap_sums_tmpl.h - a part of gradient_kernels.c: tap sums of heights of type T
 *
 * NAME(x) is x with the ending of this type.
 */

/* The vertical sums of one term, then the horizontal ones.  One pass is enough where one of the two
 * is the identity. */
static void NAME(sum_term)(T *restrict sums, const T *const rows[NTP__MAX_TAPS],
                           const ntp__taps *taps, bool down, int32_t radius, int32_t groups)
{
    T summed[NTP__GRADIENT_ROW];
    const T *line = summed, *columns[NTP__MAX_TAPS];
    const ntp__tap_line vertical = down ? taps->along_line : taps->across_line;
    const ntp__tap_line horizontal = down ? taps->across_line : taps->along_line;
    if (horizontal == NTP__LINE_ONE) {
        NAME(sum)(sums, rows, NTP__MAX_RADIUS, taps, down, groups);
        return;
    }
    /* 2 radius sums more are wanted, which is no more than NTP__LANES. */
    const int32_t first = NTP__MAX_RADIUS - radius;
    if (vertical == NTP__LINE_ONE)
        line = rows[NTP__MAX_RADIUS];
    else
        NAME(sum)(summed + first, rows, first, taps, down, groups + 1);
    for (int32_t k = 0; k < NTP__MAX_TAPS; k++)
        columns[k] = line + k;
    NAME(sum)(sums, columns, 0, taps, !down, groups);
}

static void NAME(tap_sums)(T *sums, const T *const rows[NTP__MAX_TAPS], const ntp__kernel *kernel,
                           int32_t down, int32_t n)
{
    T second[NTP__BLOCK];
    const int32_t groups = (n + NTP__LANES - 1) / NTP__LANES;
    NAME(sum_term)(sums, rows, &kernel->term[0], down != 0, kernel->radius, groups);
    if (kernel->terms == 1)
        return;
    NAME(sum_term)(second, rows, &kernel->term[1], down != 0, kernel->radius, groups);
    for (int32_t i = 0; i < groups * NTP__LANES; i++)
        sums[i] += second[i];
}
