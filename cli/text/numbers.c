/* SPDX-License-Identifier: MIT */
/*
 * numbers.c - counts, shares and angles for people
 */
#include "text/numbers.h"

#include <stdio.h>

const number_words NUMBERS_ENGLISH = { ',', "under", "over" };

void number_count(char out[NUMBER_SIZE], uint64_t count, const number_words *words)
{
    char digits[32];
    const int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long) count);
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0)
            *out++ = words->separator;
        *out++ = digits[i];
    }
    *out = 0;
}

void number_percent(char out[NUMBER_SIZE], uint64_t part, uint64_t whole, const number_words *words)
{
    const double percent = whole == 0 ? 0 : 100.0 * (double) part / (double) whole;
    if (part == 0 || part == whole)
        snprintf(out, NUMBER_SIZE, "%.0f %%", percent);
    else if (percent < 0.01)
        snprintf(out, NUMBER_SIZE, "%s %.2f %%", words->under, 0.01);
    else if (percent >= 99.99)
        snprintf(out, NUMBER_SIZE, "%s %.2f %%", words->over, 99.99);
    else
        snprintf(out, NUMBER_SIZE, "%.*f %%", percent < 1 || percent > 99 ? 2 : 1, percent);
}

void number_degrees(char out[NUMBER_SIZE], double degrees, const number_words *words)
{
    if (degrees > 0 && degrees < 0.001)
        snprintf(out, NUMBER_SIZE, "%s %.3f", words->under, 0.001);
    else if (degrees < 1)
        snprintf(out, NUMBER_SIZE, "%.2g", degrees);
    else
        snprintf(out, NUMBER_SIZE, degrees < 10 ? "%.1f" : "%.0f", degrees);
}
