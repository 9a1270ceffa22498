/* SPDX-License-Identifier: MIT */
/*
 * survey8_tmpl.h - sums and extremes of packed texels of 8 bit; a part of kernels.c
 */

/* A group of texels at a time, in columns.  At the end these become channels. */
static int32_t survey8(ntp__survey8 *s, const uint8_t *p, int32_t n, int32_t channels)
{
    enum { GROUP = 16, MOST = 4 * GROUP, STEPS = 256 }; /* 256 bytes add up to less than 2^16 */
    uint8_t least[MOST], greatest[MOST];
    uint16_t sums[MOST];
    const int32_t step = channels * GROUP;
    int32_t done = 0;
    memset(s, 0, sizeof *s);
    memset(s->least, 255, sizeof s->least);
    memset(least, 255, sizeof least);
    memset(greatest, 0, sizeof greatest);
    while (done + GROUP <= n) {
        memset(sums, 0, sizeof sums);
        for (int32_t k = 0; k < STEPS && done + GROUP <= n; k++, done += GROUP, p += step) {
            for (int32_t i = 0; i < step; i++) {
                least[i] = p[i] < least[i] ? p[i] : least[i];
                greatest[i] = p[i] > greatest[i] ? p[i] : greatest[i];
                sums[i] = (uint16_t) (sums[i] + p[i]);
            }
        }
        for (int32_t i = 0; i < step; i++) {
            if (i % channels < 3)
                s->sum[i % channels] += sums[i];
        }
    }
    for (int32_t i = 0; i < step; i++) {
        const int32_t c = i % channels;
        if (c == 3)
            continue;
        s->least[c] = least[i] < s->least[c] ? least[i] : s->least[c];
        s->greatest[c] = greatest[i] > s->greatest[c] ? greatest[i] : s->greatest[c];
    }
    return done;
}
