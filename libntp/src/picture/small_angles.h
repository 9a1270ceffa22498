/* SPDX-License-Identifier: MIT */
/*
 * small_angles.h - the numbers by which kernels find small angles; compare_avx2.c says what they are
 */
#ifndef NTP_SMALL_ANGLES_H
#define NTP_SMALL_ANGLES_H

#define SMALL 0.2F /* the greatest tangent */
#define C0    0x1.b521d1c0fb3cfp+25
#define C1    -0x1.236bde79311b3p+24
#define C2    0x1.5db1b63ab2d35p+23
#define C3    -0x1.f24383c627d24p+22
#define C4    0x1.634d09f09f772p+22

/* Of tangents up to 1, in micro-degrees: of odd and of even powers of the square in turn, highest first */
#define ATAN_TERMS \
    -0x1.a66f351242a8cp+13, 0x1.b565140a561e2p+16, -0x1.a9e3b031273a9p+18, 0x1.07445610b8cecp+20, \
    -0x1.db5647d014acap+20, 0x1.59d3927db7955p+21, -0x1.b96529c6dcc5ep+21, 0x1.098ad90ad6303p+22, \
    -0x1.3d3af1a59b439p+22, 0x1.84785c0f2d600p+22, -0x1.f3925dc7bdfadp+22, 0x1.5db49b6394bcep+23, \
    -0x1.236be1079ab1bp+24, 0x1.b521d1c18d4afp+25

enum {
    PART_BITS = 13,
    UNIT = 1 << (32 - PART_BITS),
    /* x / 1000 is x BY_1000 / 2^(32 + BY_BITS) for all of 32 bits. */
    BY_1000 = 274877907,
    BY_BITS = 6
};

#endif
