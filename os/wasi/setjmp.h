/* SPDX-License-Identifier: MIT */
/*
 * setjmp.h - the C library of WASI has none; jump.c says how these work
 */
#ifndef NTP_OS_SETJMP_H
#define NTP_OS_SETJMP_H

typedef unsigned long jmp_buf[1]; /* its number in the tables of labels */

int setjmp(jmp_buf buffer) __attribute__((returns_twice));
_Noreturn void longjmp(jmp_buf buffer, int value);

#endif
