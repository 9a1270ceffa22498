/* SPDX-License-Identifier: MIT */
/*
 * numbers.h - counts, shares and angles for people
 *
 * For the program and for the report of the GIMP plug-in.  Decimal points are those of the locale.
 */
#ifndef NTP_CLI_NUMBERS_H
#define NTP_CLI_NUMBERS_H

#include <stdint.h>

enum { NUMBER_SIZE = 48 };

typedef struct number_words {
    char separator; /* of thousands */
    const char *under, *over;
} number_words;

extern const number_words NUMBERS_ENGLISH;

/* 1234567 as 1,234,567. */
void number_count(char out[NUMBER_SIZE], uint64_t count, const number_words *words);

/* part of whole in percent: "12.3 %".  It has enough digits to differ from 0 and 100. */
void number_percent(char out[NUMBER_SIZE], uint64_t part, uint64_t whole,
                    const number_words *words);

/* An angle: 0.38, 6.7, 44. */
void number_degrees(char out[NUMBER_SIZE], double degrees, const number_words *words);

#endif
