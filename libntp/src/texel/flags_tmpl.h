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
    const int32_t m = how->m, k0 = (m + 1) / 2, e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    const uint32_t am = (uint32_t) k0 * (uint32_t) (k0 - 1), kept = how->kept, others = how->others;
    const uint32_t mirrored = how->keep_negative_z ? NTP_FLAG_EXACT : 0;
    for (int32_t i = 0; i < n; i++) {
        int32_t x = r[i] - k0, y = g[i] - k0, z = b[i] - k0, up = z < 0 ? ~z : z;
        uint32_t ks = (uint32_t) (half_up(x) + half_up(y) + half_up(z));
        int32_t xy = x * (x + 1) + y * (y + 1), e = e0 - xy, d = e - up * up;
        uint32_t q = (uint32_t) xy + (uint32_t) (z * (z + 1));
        uint32_t neighbor = (q + 6 < am + 2 * ks) & (q + 2 * ks >= am);
        uint32_t rounded = (q + 3 <= am + ks) & (q + ks > am);
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
    const int32_t m = how->m, k0 = (m + 1) / 2, e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    for (int32_t i = 0; i < n; i++) {
        int32_t x = r[i] - k0, y = g[i] - k0, ks = half_up(x) + half_up(y);
        int32_t e = e0 - x * (x + 1) - y * (y + 1);
        uint32_t u = (uint32_t) b[i], below = u - (u > 0);
        int32_t e_in = e + 2 * (ks - 2), e_out = e - 2 * ks;
        uint32_t neighbor = (e_in >= 0) & (below * below <= 4 * (uint32_t) e_in + 3);
        neighbor &= (e_out < 0) | (u * (u + 2) >= 4 * (uint32_t) e_out + 2);
        int32_t q_in = e + 1 + (ks - 2), q_out = e + 1 - ks;
        uint32_t rounded = (q_in >= 0) & (u * below <= 4 * (uint32_t) q_in);
        rounded &= (q_out < 0) | (u * (u + 1) >= 4 * (uint32_t) q_out + 1);
        uint32_t exact = (e >= 0) & (u * below <= 4 * (uint32_t) e + 2);
        exact &= u * (u + 1) >= 4 * (uint32_t) e + 3;
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
    const int32_t filled = (n + LANES - 1) / LANES * LANES;
    for (int k = 0; k < 4; k++)
        memset(c[k] + n, 0, (size_t) (filled - n) * sizeof c[k][0]);
    if (how->zzero)
        flags_zzero(wide, c[0], c[1], c[2], c[3], filled, how);
    else
        flags_standard(wide, c[0], c[1], c[2], c[3], filled, how);
    for (int32_t i = 0; i < filled; i++)
        flags[i] = (uint8_t) wide[i];
}
