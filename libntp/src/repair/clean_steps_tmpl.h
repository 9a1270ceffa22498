/* SPDX-License-Identifier: MIT */
/*
 * clean_steps_tmpl.h - cleans whole steps of packed RGB; included by clean.c, whose job it does
 *
 * Kernels leave a list of pixels.  Unused ones of that stay as they are, and pairs that are too long are
 * pulled many at once.  The colors of RGBA are packed for that.
 */

/* The kernel for packed RGB, if there is one. */
static ntp__normalize_rgb_fn *length_kernel(const job *j)
{
    return j->src->type == NTP_TYPE_U8    ? j->kernels->normalize_rgb8
           : j->src->type == NTP_TYPE_U16 ? j->kernels->normalize_rgb16
                                          : NULL;
}

/* Takes those out of a list of packed pixels that are black or white, and unused for that.  Backgrounds are full
 * of these, and one after the other they would take long.  Notes red and green of the others. */
static inline int32_t leave_unused_of(const void *pixels, long_pairs *p, int32_t n, int32_t m,
                                      uint32_t touch_unused)
{
    const uint8_t *const narrow = pixels;
    const uint16_t *const wide = pixels;
    int32_t left = 0;
    for (int32_t i = 0; i < n; i++) {
        const int32_t at = p->at[i], k = 3 * at;
        const int32_t r = m == 255 ? narrow[k] : wide[k],
                      g = m == 255 ? narrow[k + 1] : wide[k + 1];
        if (r == g && ntp__unused(r, g, m == 255 ? narrow[k + 2] : wide[k + 2], m, m, touch_unused))
            continue;
        p->c[0][left] = r;
        p->c[1][left] = g;
        p->at[left++] = at;
    }
    return left;
}

static int32_t leave_unused(const job *j, const void *pixels, long_pairs *p, int32_t n)
{
    return j->m == 255 ? leave_unused_of(pixels, p, n, 255, j->how.touch_unused)
                       : leave_unused_of(pixels, p, n, 65535, j->how.touch_unused);
}

/* Cleans packed pixels of 16 bit whose pairs are too long; returns how many, p->at[0].., are left. */
static int32_t pull_rgb16(const job *j, uint16_t *d, int32_t count, long_pairs *p,
                          uint64_t *changed)
{
    int32_t left = 0;
    if (count < FEW)
        return count;
    pull_pairs(j, p, count);
    for (int32_t i = 0; i < count; i++) {
        uint16_t *to = d + 3 * p->at[i];
        if (p->doubt[i]) {
            p->at[left++] = p->at[i];
            continue;
        }
        to[0] = (uint16_t) p->c[0][i];
        to[1] = (uint16_t) p->c[1][i];
        to[2] = (uint16_t) p->c[2][i];
    }
    *changed += (uint64_t) (count - left);
    return left;
}

/* Whole steps of packed RGB.  The few texels that the kernels leave are as in the source. */
static void clean_steps(const job *j, int32_t x, int32_t y, int32_t n, uint64_t *changed)
{
    void *d = ntp__at_mut(j->dst, x, y);
    const void *s = ntp__at(j->src, x, y);
    const ntp_const_image target = ntp_image_as_const(j->dst);
    ntp__block one;
    long_pairs p;
    const bool derives = j->how.method == NTP_CLEAN_DERIVE,
               zzero = j->encoding == NTP_ENCODING_ZZERO;
    int32_t left = derives ? j->kernels->derive_rgb16(d, s, n, zzero, p.at, changed)
                           : length_kernel(j)(d, s, n, p.at, changed);
    left = leave_unused(j, d, &p, left);
    if (derives)
        left = pull_rgb16(j, d, left, &p, changed);
    for (int32_t i = 0; i < left; i++) {
        ntp__unpack(&one, &target, x + p.at[i], y, 1);
        *changed += clean_at(j, &one, 0);
        ntp__pack(j->dst, &one, x + p.at[i], y, 1, 3);
    }
}

/* Whole steps of packed RGBA.  Flat colors, which transparent pixels have meanwhile, do not change. */
static void clean_colors(const job *j, int32_t x, int32_t y, int32_t n, uint64_t *changed)
{
    uint16_t rgb[3 * (NTP__BLOCK + 1)];
    const ntp_image image = ntp_image_packed(rgb, NTP__BLOCK, 1, 3, j->src->type);
    const ntp_const_image view = ntp_image_as_const(&image);
    const void *s = ntp__at(j->src, x, y);
    job colors = *j;
    colors.dst = &image;
    colors.src = &view;
    j->kernels->move_colors((uint8_t *) rgb, NULL, s, n, j->m, j->how.touch_unused);
    clean_steps(&colors, 0, 0, n, changed);
    j->kernels->move_colors((uint8_t *) rgb, (uint8_t *) ntp__at_mut(j->dst, x, y), s, n, j->m,
                            j->how.touch_unused);
}
