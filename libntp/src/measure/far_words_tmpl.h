/* SPDX-License-Identifier: MIT */
/*
 * far_words_tmpl.h - where the counts of texels far from exact are; for far_avx2.c and far_avx512.c
 */
#ifndef NTP_FAR_WORDS_TMPL_H
#define NTP_FAR_WORDS_TMPL_H

#include "measure/far_texels.h"

#include <stddef.h>

enum {
    M = 65535,
    K = 32768,
/* Where counts are in ntp__sums. */
#define WORD(member) (int32_t) (offsetof(ntp__sums, member) / sizeof(uint32_t))
    LEVELS = WORD(fit[0].levels_off),
    LEVELS_ZZ = WORD(fit[1].levels_off),
    ANGLES = WORD(angles.bins),
    HARM = WORD(harm[0].bins),
#undef WORD
    ONE_HARM = sizeof(ntp__harm_sums) / sizeof(uint32_t),
    LENGTH_BIN = 9 /* 2^9 of the length */
};

#endif
