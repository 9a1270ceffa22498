/* SPDX-License-Identifier: MIT */
/*
 * png_filter_neon_tmpl.h - texels and 16 bytes at once for filters, with NEON; a part of png_filter.c
 */
#include <arm_neon.h>

typedef uint8x8_t bytes; /* of a texel; what is beyond it is anything */
typedef uint8x16_t wide;
typedef uint64x2_t sums; /* two sums, whose sum counts */

/* In two parts at most, which stay in registers. */
static inline bytes load(const uint8_t *from, size_t texel)
{
    const size_t whole = texel >= 4 ? 4 : texel >= 2 ? 2 : 1, rest = texel - whole;
    uint32_t low = 0, high = 0;
    memcpy(&low, from, whole);
    memcpy(&high, from + whole, rest);
    return vcreate_u8(low | (uint64_t) high << 8 * whole);
}

static inline void store(uint8_t *to, bytes value, size_t texel)
{
    const size_t whole = texel >= 4 ? 4 : texel >= 2 ? 2 : 1, rest = texel - whole;
    const uint64_t all = vget_lane_u64(vreinterpret_u64_u8(value), 0);
    const uint64_t above = all >> 8 * whole;
    memcpy(to, &all, whole);
    memcpy(to + whole, &above, rest);
}

static inline bytes undo_sub(bytes value, bytes a)
{
    return vadd_u8(value, a);
}

static inline bytes undo_average(bytes value, bytes a, bytes b)
{
    return vadd_u8(value, vhadd_u8(a, b));
}

/* Of a, b and c the one that is nearest to a + b - c; of equals the first. */
static inline bytes paeth8(bytes a, bytes b, bytes c)
{
    const uint16x8_t to_a = vabdl_u8(b, c), to_b = vabdl_u8(a, c);
    const uint16x8_t to_c = vabdq_u16(vaddl_u8(a, b), vshll_n_u8(c, 1));
    const uint16x8_t is_a = vandq_u16(vcleq_u16(to_a, to_b), vcleq_u16(to_a, to_c));
    const bytes b_or_c = vbsl_u8(vmovn_u16(vcleq_u16(to_b, to_c)), b, c);
    return vbsl_u8(vmovn_u16(is_a), a, b_or_c);
}

static inline bytes undo_paeth(bytes value, bytes a, bytes b, bytes c)
{
    return vadd_u8(value, paeth8(a, b, c));
}

static inline bytes no_texel(void)
{
    return vdup_n_u8(0);
}

static inline wide load16(const uint8_t *from)
{
    return vld1q_u8(from);
}

static inline void store16(uint8_t *to, wide value)
{
    vst1q_u8(to, value);
}

static inline wide add16(wide a, wide b)
{
    return vaddq_u8(a, b);
}

static inline wide subtract16(wide a, wide b)
{
    return vsubq_u8(a, b);
}

static inline wide foretold16(wide a, wide b, wide c, int kind)
{
    if (kind == NONE || kind == SUB || kind == UP)
        return kind == NONE ? vdupq_n_u8(0) : kind == SUB ? a : b;
    if (kind == AVERAGE)
        return vhaddq_u8(a, b);
    return vcombine_u8(paeth8(vget_low_u8(a), vget_low_u8(b), vget_low_u8(c)),
                       paeth8(vget_high_u8(a), vget_high_u8(b), vget_high_u8(c)));
}

static inline sums no_sums(void)
{
    return vdupq_n_u64(0);
}

/* Adds the distance of each byte from 0 modulo 256. */
static inline sums add_distances(sums sum, wide value)
{
    const wide away = vminq_u8(value, vsubq_u8(vdupq_n_u8(0), value));
    return vpadalq_u32(sum, vpaddlq_u16(vpaddlq_u8(away)));
}

static inline uint64_t total(sums sum)
{
    return vaddvq_u64(sum);
}
