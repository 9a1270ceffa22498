/* SPDX-License-Identifier: MIT */
/*
 * flags_tmpl.h - the flags of ntp_validate for planes of levels; a part of kernels.c
 *
 * As in judge_standard and judge_zzero, but blue is not derived: whether it is the derived one, its
 * square tells.  With S = 4e + 3 the derived blue of the standard encoding is K + z where z*z <= e <
 * (z + 1)^2, and that of Z-zero is b where (2b - 1)^2 < 4S < (2b + 1)^2.
 */

static inline uint32_t unused_flag(int32_t r, int32_t g, int32_t b, int32_t a, int32_t m)
{
    return (uint32_t) (((r | g | b) == 0) | ((r & g & b) == m) | (a == 0)) * NTP_FLAG_UNUSED;
}

ONE_COPY static void flags_standard(int32_t *restrict flags, const int32_t *restrict r,
                                    const int32_t *restrict g, const int32_t *restrict b,
                                    const int32_t *restrict a, int32_t n,
                                    const ntp__validity *restrict how)
{
    n = whole_lanes(n);
    const int32_t m = how->m, k0 = (m + 1) / 2, e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    const int32_t am = k0 * (k0 - 1);
    const uint32_t kept = how->kept, others = how->others;
    const uint32_t mirrored = how->keep_negative_z ? NTP_FLAG_EXACT : 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t x = r[i] - k0, y = g[i] - k0, z = b[i] - k0, up = z < 0 ? ~z : z;
        int32_t ks = half_up(x) + half_up(y) + up + 1;
        /* z(z + 1) is up(up + 1); the squares less that of 1 have 31 bits and a sign */
        int32_t xy = x * (x + 1) + y * (y + 1), zz = z * (z + 1), e = e0 - xy, d = e - zz + up;
        int32_t off = (int32_t) ((uint32_t) (xy - am) + (uint32_t) zz);
        uint32_t neighbor = (uint32_t) ((off + 6 < 2 * ks) & (off >= -2 * ks));
        uint32_t rounded = (uint32_t) ((off + 3 <= ks) & (off > -ks));
        uint32_t exact = (uint32_t) ((d >= 0) & (d <= 2 * up));
        uint32_t f = neighbor * NTP_FLAG_NEIGHBOR | rounded * NTP_FLAG_ROUNDED |
                     exact * (z < 0 ? mirrored : NTP_FLAG_EXACT) |
                     (uint32_t) (e < 0) * NTP_FLAG_XY_TOO_LONG |
                     (uint32_t) (z < 0) * NTP_FLAG_Z_NEGATIVE;
        f &= kept;
        f |= f == 0 ? others : 0;
        flags[i] = (int32_t) (f | unused_flag(r[i], g[i], b[i], a[i], m));
    }
}

ONE_COPY static void flags_zzero(int32_t *restrict flags, const int32_t *restrict r,
                                 const int32_t *restrict g, const int32_t *restrict b,
                                 const int32_t *restrict a, int32_t n,
                                 const ntp__validity *restrict how)
{
    n = whole_lanes(n);
    const int32_t m = how->m, k0 = (m + 1) / 2, e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    for (int32_t i = 0; i < n; i++) {
        int32_t x = r[i] - k0, y = g[i] - k0, ks = half_up(x) + half_up(y);
        int32_t e = e0 - x * (x + 1) - y * (y + 1);
        /* (u - 1)^2 is 1, not 0, where u is 0: both are below 4 e_in + 3 */
        uint32_t u = (uint32_t) b[i], u2 = u * u;
        int32_t e_in = e + 2 * (ks - 2), e_out = e - 2 * ks;
        uint32_t neighbor = (e_in >= 0) & (u2 - 2 * u + 1 <= 4 * (uint32_t) e_in + 3);
        neighbor &= (e_out < 0) | (u2 + 2 * u >= 4 * (uint32_t) e_out + 2);
        int32_t q_in = e + 1 + (ks - 2), q_out = e + 1 - ks;
        uint32_t rounded = (q_in >= 0) & (u2 - u <= 4 * (uint32_t) q_in);
        rounded &= (q_out < 0) | (u2 + u >= 4 * (uint32_t) q_out + 1);
        uint32_t exact = (e >= 0) & (u2 - u <= 4 * (uint32_t) e + 2);
        exact &= u2 + u >= 4 * (uint32_t) e + 3;
        uint32_t f = neighbor * NTP_FLAG_NEIGHBOR | rounded * NTP_FLAG_ROUNDED |
                     exact * NTP_FLAG_EXACT | (uint32_t) (e < 0) * NTP_FLAG_XY_TOO_LONG;
        flags[i] = (int32_t) (f | unused_flag(r[i], g[i], b[i], a[i], m));
    }
}

/* Works on whole lanes; levels beyond n become 0.  Loops of one width of numbers are much smaller, so
 * the flags become bytes in the end. */
static void validate(uint8_t *flags, int32_t *const c[4], int32_t n, const ntp__validity *how)
{
    int32_t wide[256];
    const int32_t filled = whole_lanes(n + LANES - 1);
    for (int k = 0; k < 4; k++)
        memset(c[k] + n, 0, (size_t) (filled - n) * sizeof c[k][0]);
    if (how->zzero)
        flags_zzero(wide, c[0], c[1], c[2], c[3], filled, how);
    else
        flags_standard(wide, c[0], c[1], c[2], c[3], filled, how);
    for (int32_t i = 0; i < filled; i++)
        flags[i] = (uint8_t) wide[i];
}

#ifdef __AVX2__

/* As flags_standard.  At 8 bit 16 bits hold all of it, and twice as many texels are done at once.
 * Whole lanes, of texels that are not transparent. */
ONE_COPY static void flags_rgb8(uint8_t *restrict flags, const uint8_t *restrict r,
                                const uint8_t *restrict g, const uint8_t *restrict b, int32_t n,
                                const ntp__validity *restrict how)
{
    enum { K0 = 128, AM = K0 * (K0 - 1), E0 = (255 * 255 - 5) / 4 };
    const uint16_t mirrored = how->keep_negative_z ? NTP_FLAG_EXACT : 0;
    const uint16_t kept = (uint16_t) how->kept, others = (uint16_t) how->others;
    n = whole_lanes(n);
    for (int32_t i = 0; i < n; i++) {
        const int16_t x = (int16_t) (r[i] - K0), y = (int16_t) (g[i] - K0);
        const int16_t z = (int16_t) (b[i] - K0), up = (int16_t) (z < 0 ? ~z : z);
        const int16_t kx = (int16_t) (x < 0 ? -x : x + 1), ky = (int16_t) (y < 0 ? -y : y + 1);
        const uint16_t ks = (uint16_t) (kx + ky + up + 1), twice = (uint16_t) (ks + ks);
        const int16_t xy = (int16_t) (x * (int16_t) (x + 1) + y * (int16_t) (y + 1));
        const int16_t e = (int16_t) (E0 - xy), d = (int16_t) (e - (int16_t) (up * up));
        const uint16_t q = (uint16_t) ((uint16_t) xy + (uint16_t) (up * (int16_t) (up + 1)));
        const bool neighbor = (q < (uint16_t) (AM - 6 + twice)) & ((uint16_t) (q + twice) >= AM);
        const bool rounded = (q <= (uint16_t) (AM - 3 + ks)) & ((uint16_t) (q + ks) > AM);
        const bool exact = (d >= 0) & (d <= (int16_t) (up + up));
        uint16_t f = neighbor ? NTP_FLAG_NEIGHBOR : 0;
        f |= (uint16_t) (rounded ? NTP_FLAG_ROUNDED : 0);
        f |= (uint16_t) (exact ? (z < 0 ? mirrored : NTP_FLAG_EXACT) : 0);
        f |= (uint16_t) (e < 0 ? NTP_FLAG_XY_TOO_LONG : 0);
        f |= (uint16_t) (z < 0 ? NTP_FLAG_Z_NEGATIVE : 0);
        f &= kept;
        f |= f == 0 ? others : 0;
        const uint8_t any = (uint8_t) (r[i] | g[i] | b[i]), all = (uint8_t) (r[i] & g[i] & b[i]);
        const bool unused = (any == 0) | (all == 255);
        flags[i] = (uint8_t) (f | (unused ? NTP_FLAG_UNUSED : 0));
    }
}

/* 16 texels in three times 16 bytes: which of each go where, for one channel. */
static inline __m128i one_channel(const __m128i v[3], __m128i from_0, __m128i from_1,
                                  __m128i from_2)
{
    return _mm_or_si128(
        _mm_or_si128(_mm_shuffle_epi8(v[0], from_0), _mm_shuffle_epi8(v[1], from_1)),
        _mm_shuffle_epi8(v[2], from_2));
}

static inline void split_16(uint8_t *r, uint8_t *g, uint8_t *b, const uint8_t *src)
{
    /* every third byte from 0, 1 or 2 on; the other two parts of a channel are these, shifted */
    const __m128i v[] = { _mm_loadu_si128((const __m128i *) (const void *) src),
                          _mm_loadu_si128((const __m128i *) (const void *) (src + 16)),
                          _mm_loadu_si128((const __m128i *) (const void *) (src + 32)) };
    _mm_storeu_si128(
        (__m128i *) (void *) r,
        one_channel(v, _mm_setr_epi8(0, 3, 6, 9, 12, 15, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1),
                    _mm_setr_epi8(-1, -1, -1, -1, -1, -1, 2, 5, 8, 11, 14, -1, -1, -1, -1, -1),
                    _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 1, 4, 7, 10, 13)));
    _mm_storeu_si128(
        (__m128i *) (void *) g,
        one_channel(v, _mm_setr_epi8(1, 4, 7, 10, 13, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1),
                    _mm_setr_epi8(-1, -1, -1, -1, -1, 0, 3, 6, 9, 12, 15, -1, -1, -1, -1, -1),
                    _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 2, 5, 8, 11, 14)));
    _mm_storeu_si128(
        (__m128i *) (void *) b,
        one_channel(v, _mm_setr_epi8(2, 5, 8, 11, 14, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1),
                    _mm_setr_epi8(-1, -1, -1, -1, -1, 1, 4, 7, 10, 13, -1, -1, -1, -1, -1, -1),
                    _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 0, 3, 6, 9, 12, 15)));
}

static void validate_rgb8(uint8_t *flags, const uint8_t *src, int32_t n, const ntp__validity *how)
{
    enum { STEP = 16 };
    uint8_t r[256], g[256], b[256], last[3 * STEP] = { 0 };
    int32_t i = 0;
    for (; i + STEP <= n; i += STEP)
        split_16(r + i, g + i, b + i, src + 3 * i);
    memcpy(last, src + 3 * i, 3 * (size_t) (n - i));
    for (; i < whole_lanes(n + LANES - 1); i += STEP)
        split_16(r + i, g + i, b + i, last); /* what lies beyond n does not matter */
    flags_rgb8(flags, r, g, b, n + LANES - 1, how);
}

#else
#  define validate_rgb8 NULL
#endif
