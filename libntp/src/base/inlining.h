/* SPDX-License-Identifier: MIT */
/*
 * inlining.h - what compilers are told about copies of code
 *
 * They change no result, so that a compiler without them does as it likes.
 */
#ifndef NTP_INLINING_H
#define NTP_INLINING_H

/* ALWAYS_INLINE: a part of its caller, whose arguments may be constants there (which of two depths it is,
 * say), or vectors, which have to stay in registers; also where the compiler saves code.
 * ONE_COPY: a loop of its own, which gains nothing from a copy for each caller, or for constants.
 * SELDOM: what few textures have, or few texels: one copy, and small.
 * UNROLLED: before a loop of a few steps over registers, also where the compiler saves code.
 * FETCH: asks for memory.  (In a function of its own, compilers take it for something without effect.) */
#ifdef __GNUC__
#  define ALWAYS_INLINE  inline __attribute__((always_inline))
#  define SELDOM         __attribute__((noinline, cold))
#  define UNROLLED       _Pragma("GCC unroll 8")
#  define FETCH(address) __builtin_prefetch(address)
#else
#  define ALWAYS_INLINE inline
#  define SELDOM
#  define UNROLLED
#  define FETCH(address) ((void) (address))
#endif

#if defined(__clang__)
#  define ONE_COPY __attribute__((noinline))
#elif defined(__GNUC__)
#  define ONE_COPY __attribute__((noinline, noclone))
#else
#  define ONE_COPY
#endif

#endif
