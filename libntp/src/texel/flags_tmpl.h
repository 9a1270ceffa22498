/* SPDX-License-Identifier: MIT */
/*
 * flags_tmpl.h - the flags of ntp_validate for planes of levels; a part of kernels.c
 * With AVX2, those of packed pixels too.
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

/*
 * Packed RGB.  With u = x where x >= 0, else ~x, the squares are 4u(u + 1) + 1.  q is the sum of
 * u(u + 1) of the three, t that of u, and s = q - (K(K - 1) - 1).  So half_up is u + 1, and the tests
 * above become
 *     exact: |s| <= u of z;  rounded: |s| <= t + 1;  neighbor: -2t - 5 <= s <= 2t.
 * At 8 bit, 16 bits with a sign hold s, and at 16 bit 32 do.  Black and white have the greatest t,
 * and three equal levels.
 */

/* Exact ones are rounded, and these neighbor, so two bits count what a texel is not. What is too long is not
 * exact: with that bit 0 of these is an unused one. */
enum { NOTHING = 3 /* of neighbor, rounded, exact */, TOO_LONG = 4, NEGATIVE = 8 };

static inline __m256i plus(__m256i v, __m256i w, bool deep)
{
    return deep ? _mm256_add_epi32(v, w) : _mm256_add_epi16(v, w);
}

static inline __m256i minus(__m256i v, __m256i w, bool deep)
{
    return deep ? _mm256_sub_epi32(v, w) : _mm256_sub_epi16(v, w);
}

static inline __m256i above(__m256i v, __m256i w, bool deep)
{
    return deep ? _mm256_cmpgt_epi32(v, w) : _mm256_cmpgt_epi16(v, w);
}

static inline __m256i same(__m256i v, __m256i w, bool deep)
{
    return deep ? _mm256_cmpeq_epi32(v, w) : _mm256_cmpeq_epi16(v, w);
}

/* The lowest bits of v in all lanes. */
static inline __m256i all(int64_t v, bool deep)
{
    return deep ? _mm256_set1_epi32((int32_t) (uint32_t) v) : _mm256_set1_epi16((short) v);
}

/* u of all halves: levels, or 0 with 0 for k and below. */
static inline __m256i folded(__m256i c, __m256i k, __m256i below, bool deep)
{
    const __m256i x = _mm256_xor_si256(c, k), y = _mm256_xor_si256(c, below);
    return deep ? _mm256_min_epu16(x, y) : _mm256_min_epu8(x, y);
}

/* The bits of 16 texels of 8 bit, in 16 bits each, or of 8 of 16 bit in 32: red and green as halves, and
 * blue. */
static inline __m256i test_pairs(__m256i rg, __m256i b, bool deep)
{
    const int32_t half = deep ? 16 : 8;
    const int64_t k = deep ? 32768 : 128, pair = 1 + (1 << half);
    const __m256i u = folded(rg, all(k * pair, deep), all((k - 1) * pair, deep), deep);
    const __m256i z = folded(b, all(k, deep), all(k - 1, deep), deep);
    const __m256i sum = deep ? _mm256_madd_epi16(u, _mm256_set1_epi16(1))
                             : _mm256_maddubs_epi16(u, _mm256_set1_epi8(1));
    const __m256i square = deep ? _mm256_madd_epi16(u, u) : _mm256_maddubs_epi16(u, u);
    const __m256i square_z = deep ? _mm256_madd_epi16(z, z) : _mm256_mullo_epi16(z, z);
    const __m256i xy = plus(square, sum, deep), most = all(k * (k - 1) - 1, deep);
    const __m256i s = plus(minus(xy, most, deep), plus(square_z, z, deep), deep);
    const __m256i t = plus(sum, z, deep), rest = minus(all(-5, deep), s, deep);
    const __m256i size = deep ? _mm256_abs_epi32(s) : _mm256_abs_epi16(s);
    const __m256i reach = deep ? _mm256_max_epi32(s, rest) : _mm256_max_epi16(s, rest);
    const __m256i missed =
        plus(plus(above(size, z, deep), above(reach, plus(t, t, deep), deep), deep),
             above(size, plus(t, all(1, deep), deep), deep), deep);
    const __m256i others =
        _mm256_or_si256(_mm256_and_si256(above(xy, most, deep), all(TOO_LONG, deep)),
                        _mm256_and_si256(above(all(k, deep), b, deep), all(NEGATIVE, deep)));
    const __m256i corner = same(t, all(3 * k - 3, deep), deep);
    __m256i bits = minus(others, missed, deep);
    if (!_mm256_testz_si256(corner, corner)) {
        const __m256i gray = deep ? _mm256_or_si256(b, _mm256_slli_epi32(b, half))
                                  : _mm256_or_si256(b, _mm256_slli_epi16(b, half));
        const __m256i unused = _mm256_and_si256(same(rg, gray, deep), corner);
        bits = _mm256_andnot_si256(_mm256_and_si256(unused, all(NOTHING, deep)), bits);
    }
    return bits;
}

#  define N -1

/* The same of pixels: 24 bytes from s on, and as many from `apart` bytes later. */
static inline __m256i test_pixels(const uint8_t *s, ptrdiff_t apart, bool deep)
{
    const __m128i from[2] = {
        deep ? _mm_setr_epi8(0, 1, 2, 3, 6, 7, 8, 9, 4, 5, N, N, 10, 11, N, N)
             : _mm_setr_epi8(0, 1, 3, 4, 6, 7, 9, 10, 2, N, 5, N, 8, N, 11, N),
        deep ? _mm_setr_epi8(4, 5, 6, 7, 10, 11, 12, 13, 8, 9, N, N, 14, 15, N, N)
             : _mm_setr_epi8(4, 5, 7, 8, 10, 11, 13, 14, 6, N, 9, N, 12, N, 15, N)
    };
    __m256i half[2];
    UNROLLED
    for (int k = 0; k < 2; k++) {
        half[k] =
            _mm256_shuffle_epi8(load_apart(s + 8 * k, apart), _mm256_broadcastsi128_si256(from[k]));
    }
    return test_pairs(_mm256_unpacklo_epi64(half[0], half[1]),
                      _mm256_unpackhi_epi64(half[0], half[1]), deep);
}

#  undef N

enum { PART = 24 /* bytes that one half of a vector is made of */ };

/* The same of two such parts at 16 bit; as quick as where it is inline. */
ONE_COPY static __m256i test_two_deep(const uint8_t *s)
{
    return _mm256_packs_epi32(test_pixels(s, 4 * PART, true),
                              test_pixels(s + PART, 4 * PART, true));
}

/* The bits of 32 pixels, as bytes. */
static inline __m256i test_32(const uint8_t *s, bool deep)
{
    if (deep)
        return _mm256_packs_epi16(test_two_deep(s), test_two_deep(s + 2 * PART));
    return _mm256_packs_epi16(test_pixels(s, 2 * PART, false),
                              test_pixels(s + PART, 2 * PART, false));
}

/* The flags that bits stand for. */
static void flags_of_bits(uint8_t flags[16], const ntp__validity *how)
{
    const uint32_t passed = NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED | NTP_FLAG_EXACT;
    const uint32_t mirrored = how->keep_negative_z ? 0 : NTP_FLAG_EXACT;
    for (uint32_t bits = 0; bits < 16; bits++) {
        const bool unused = (bits & (TOO_LONG | NOTHING)) == TOO_LONG;
        uint32_t f =
            (unused ? 0 : passed >> (bits & NOTHING)) | bits / TOO_LONG % 2 * NTP_FLAG_XY_TOO_LONG;
        if (bits >= NEGATIVE)
            f = (f & ~mirrored) | NTP_FLAG_Z_NEGATIVE;
        f &= how->kept;
        f |= f == 0 ? how->others : 0;
        flags[bits] = (uint8_t) (f | (unused ? NTP_FLAG_UNUSED : 0));
    }
}

static inline void flags_rgb(uint8_t *flags, const uint8_t *s, int32_t n, bool deep,
                             const uint8_t of_bits[16])
{
    enum { STEP = 32 };
    const int32_t size = deep ? 6 : 3;
    const __m256i table = _mm256_broadcastsi128_si256(_mm_loadu_si128((const void *) of_bits));
    for (int32_t i = 0; i < n; i += STEP, flags += STEP, s += STEP * size) {
        uint8_t few[6 * STEP];
        const bool whole = n - i >= STEP;
        if (!whole)
            memcpy(few, s, (size_t) size * (size_t) (n - i));
        const __m256i f = _mm256_shuffle_epi8(table, test_32(whole ? s : few, deep));
        _mm256_storeu_si256((__m256i *) (void *) (whole ? flags : few), f);
        if (!whole)
            memcpy(flags, few, (size_t) (n - i));
    }
}

static void validate_rgb(uint8_t *flags, const void *src, int32_t n, const ntp__validity *how)
{
    uint8_t of_bits[16];
    flags_of_bits(of_bits, how);
    if (how->m > 255)
        flags_rgb(flags, src, n, true, of_bits);
    else
        flags_rgb(flags, src, n, false, of_bits);
}

#else
#  define validate_rgb NULL
#endif
