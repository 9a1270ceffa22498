/* SPDX-License-Identifier: MIT */
/*
 * horizon.c - the horizon of each sample of a line of heights
 *
 * What a sample sees highest lies on the upper hull of the samples in its window.  The line is cut
 * into blocks as long as the window, so that a window is the end of one block and the beginning of
 * the next.  The hull of the end of a block grows from right to left; the sample that joins it has
 * its own horizon next to it (Timonen and Westerholm 2010).  The hull of the beginning of the next
 * block grows from left to right with the window, and the horizon on it is found by bisection.
 * All comparisons are of integers, so the result does not depend on where blocks begin.
 */
#include "shape/horizon.h"

/* Is the slope from i to b at least that to a?  Both lie to the right of i. */
static int is_higher(const int32_t *v, int32_t i, int32_t b, int32_t a)
{
    return (int64_t) (v[b] - v[i]) * (a - i) >= (int64_t) (v[a] - v[i]) * (b - i);
}

/* The horizons within a block; all samples of it join the hull. */
static void within(int32_t *best, const int32_t *v, int32_t begin, int32_t end, int32_t last,
                   int32_t *hull)
{
    int32_t size = 0;
    for (int32_t i = end - 1; i >= begin; i--) {
        while (size >= 2 && is_higher(v, i, hull[size - 2], hull[size - 1]))
            size--;
        if (i < last)
            best[i] = size > 0 ? hull[size - 1] : -1;
        hull[size++] = i;
    }
}

/* Adds a sample on the right. */
static int32_t join(const int32_t *v, int32_t *hull, int32_t size, int32_t i)
{
    while (size >= 2 && is_higher(v, hull[size - 2], i, hull[size - 1]))
        size--;
    hull[size] = i;
    return size + 1;
}

/* The sample of a hull right of i with the greatest slope from i: slopes rise and then fall. */
static int32_t highest(const int32_t *v, const int32_t *hull, int32_t size, int32_t i)
{
    int32_t low = 0, high = size - 1;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (is_higher(v, i, hull[middle + 1], hull[middle]))
            low = middle + 1;
        else
            high = middle;
    }
    return hull[low];
}

void ntp__horizons(int32_t *best, const int32_t *v, int32_t n, ntp__some which, int32_t reach,
                   int32_t *stack)
{
    int32_t *const next = stack + n;
    int32_t wanted = which.first;
    for (int32_t begin = which.first; begin < which.last;) {
        const int32_t end = n - begin < reach ? n : begin + reach;
        within(best, v, begin, end, which.last, stack);
        int32_t size = 0;
        for (int32_t i = begin; i < end && i < which.last && end < n; i++) {
            if (n - i > reach)
                size = join(v, next, size, i + reach);
            if (i != wanted)
                continue;
            wanted += which.step;
            const int32_t other = highest(v, next, size, i);
            if (best[i] < 0 || is_higher(v, i, other, best[i]))
                best[i] = other;
        }
        begin = end;
    }
}
