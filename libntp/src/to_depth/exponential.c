/* SPDX-License-Identifier: MIT */
/*
 * exponential.c - the logarithm as a series
 */
#include "to_depth/exponential.h"

double ntp__log(double x)
{
    enum { LAST = 21 }; /* of the series in s = (m - 1)/(m + 1), |s| < 0.172: s^23 / 23 < 2^-62 */
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    int32_t k = (int32_t) (bits >> 52) - 1023;
    bits = (bits & 0xfffffffffffffU) | (uint64_t) 1023 << 52;
    double m;
    memcpy(&m, &bits, sizeof m);
    if (m > 0x1.6a09e667f3bcdp+0) {
        m /= 2;
        k++;
    }
    double s = (m - 1) / (m + 1), square = s * s, sum = 0;
    for (int32_t i = LAST; i > 0; i -= 2)
        sum = sum * square + 2.0 / i;
    return k * NTP__LN2_HIGH + (k * NTP__LN2_LOW + sum * s);
}
