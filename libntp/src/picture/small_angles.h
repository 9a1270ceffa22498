/* SPDX-License-Identifier: MIT */
/*
 * small_angles.h - the numbers by which kernels find angles; compare_avx2.c says what they are
 */
#ifndef NTP_SMALL_ANGLES_H
#define NTP_SMALL_ANGLES_H

#define SMALL 0.2F /* the greatest tangent */
#define C0    0x1.b521d1c0fb3cfp+25
#define C1    -0x1.236bde79311b3p+24
#define C2    0x1.5db1b63ab2d35p+23
#define C3    -0x1.f24383c627d24p+22
#define C4    0x1.634d09f09f772p+22

/* With it the bits of a double are an angle + ROUND_BIN + 1/2 in units of 2^-PART_BITS micro-degrees, and one more of
 * these, with others above those of 180 degrees. */
#define TO_PARTS (0x1.8p39 + ROUND_BIN + 0.5 + 1.0 / (1 << PART_BITS))

/* Of tangents up to 1, in micro-degrees: factors of odd powers, the highest first. */
enum { NTP__ATAN_TERMS = 14 };
extern const double ntp__atan_terms[NTP__ATAN_TERMS];

enum {
    PART_BITS = 13,
    /* Of these places.  None is set in an angle in doubt, which TO_PARTS made one more of the last place. */
    SURE_BITS = (1 << PART_BITS) - 4,
    /* x / 1000 is x BY_1000 / 2^(32 + BY_BITS) for all of 32 bits. */
    BY_1000 = 274877907,
    BY_BITS = 6
};

#endif
