/* SPDX-License-Identifier: MIT */
/* The exponential function and the logarithm of the library, beside those of libm. */
#include <math.h>
#include <stdio.h>

#include "to_depth/exponential.h"

static int faults;

static void check(const char *what, double x, double got, double want, double allowed)
{
    if (fabs(got - want) <= allowed)
        return;
    printf("%s(%a): %a, not %a\n", what, x, got, want);
    faults++;
}

int main(void)
{
    for (int i = -700000; i <= 700000; i += 7) {
        double x = i / 1000.0, want = exp(x);
        check("exp", x, ntp__exp(x), want, want * 0x1p-50);
        check("exp", x / 1e5, ntp__exp(x / 1e5), exp(x / 1e5), 0x1p-50);
    }
    check("exp", 0, ntp__exp(0), 1, 0);
    check("exp", INFINITY, ntp__exp(INFINITY), ntp__exp(700), 0);
    check("exp", -INFINITY, ntp__exp(-INFINITY), ntp__exp(-700), 0);
    check("exp", NAN, ntp__exp(NAN), ntp__exp(-700), 0);
    for (int i = -87000; i <= 87000; i++) {
        float x = (float) i / 1000;
        double want = exp((double) x);
        check("exp_float", (double) x, (double) ntp__exp_float(x), want, want * 0x1p-21);
    }
    check("exp_float", INFINITY, (double) ntp__exp_float(INFINITY), (double) ntp__exp_float(87), 0);
    check("exp_float", -INFINITY, (double) ntp__exp_float(-INFINITY), (double) ntp__exp_float(-87),
          0);
    for (int e = -1021; e < 1023; e++) {
        for (int i = 0; i < 64; i++) {
            double x = ldexp(1 + i / 64.0 + i * 1e-9, e), want = log(x);
            check("log", x, ntp__log(x), want, 0x1p-52 + fabs(want) * 0x1p-50);
        }
    }
    check("log", 1, ntp__log(1), 0, 0);
    if (faults == 0)
        puts("exp and log agree with libm");
    return faults != 0;
}
