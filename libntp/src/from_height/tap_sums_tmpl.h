/* SPDX-License-Identifier: MIT */
/*
 * tap_sums_tmpl.h - a part of gradient_kernels.c: tap sums of heights of type T
 *
 * NAME(x) is x with the ending of this type.
 */

/* The vertical sums of one term, then the horizontal ones.  One pass is enough where one of the two
 * is the identity. */
static ALWAYS_INLINE void NAME(add_term)(T *restrict sums, const T *const rows[NTP__MAX_TAPS],
                                         const int32_t *vertical, const int32_t *horizontal,
                                         int32_t radius, bool add, int32_t n)
{
    T summed[NTP__GRADIENT_ROW];
    const T *line = summed;
    if (!add && IS_IDENTITY(horizontal)) {
        for (int32_t i = 0; i < n; i++)
            sums[i] = NINE(vertical, ROW);
        return;
    }
    if (IS_IDENTITY(vertical)) {
        line = rows[NTP__MAX_RADIUS];
    } else {
        /* n + 2 radius sums are wanted; NTP__LANES is at least 2 radius. */
        for (int32_t i = -radius; i < n + NTP__LANES - radius; i++)
            summed[NTP__MAX_RADIUS + i] = NINE(vertical, ROW);
    }
    if (add) {
        for (int32_t i = 0; i < n; i++)
            sums[i] += NINE(horizontal, COLUMN);
    } else {
        for (int32_t i = 0; i < n; i++)
            sums[i] = NINE(horizontal, COLUMN);
    }
}

static ALWAYS_INLINE void NAME(sum_kernel)(T *restrict sums, const T *const rows[NTP__MAX_TAPS],
                                           const ntp__kernel *k, bool down, int32_t n)
{
    const ntp__taps *a = &k->term[0], *b = &k->term[1];
    const int32_t *vertical = down ? a->along : a->across,
                  *horizontal = down ? a->across : a->along;
    NAME(add_term)(sums, rows, vertical, horizontal, k->radius, false, n);
    if (k->terms > 1) {
        vertical = down ? b->along : b->across;
        horizontal = down ? b->across : b->along;
        NAME(add_term)(sums, rows, vertical, horizontal, k->radius, true, n);
    }
}

#define CASE(KERNEL)                                                                               \
    case KERNEL:                                                                                   \
        if (down)                                                                                  \
            NAME(sum_kernel)(sums, rows, &ntp__kernel_table[KERNEL], true, n);                     \
        else                                                                                       \
            NAME(sum_kernel)(sums, rows, &ntp__kernel_table[KERNEL], false, n);                    \
        break;

static void NAME(tap_sums)(T *sums, const T *const rows[NTP__MAX_TAPS], ntp_kernel kernel,
                           int32_t down, int32_t n)
{
    n = (n + NTP__LANES - 1) / NTP__LANES * NTP__LANES;
    switch (kernel) {
        CASE(NTP_KERNEL_CENTRAL)
        CASE(NTP_KERNEL_FORWARD)
        CASE(NTP_KERNEL_PREWITT3)
        CASE(NTP_KERNEL_SOBEL3)
        CASE(NTP_KERNEL_SCHARR3)
        CASE(NTP_KERNEL_PREWITT5)
        CASE(NTP_KERNEL_SOBEL5)
        CASE(NTP_KERNEL_GIMP5)
        CASE(NTP_KERNEL_GIMP7)
        CASE(NTP_KERNEL_GIMP9)
    case NTP_KERNEL_BAKED: /* has no taps */
        break;
    }
}

#undef CASE
