/* SPDX-License-Identifier: MIT */
/*
 * clean_steps_tmpl.h - cleans whole steps of packed RGB; included by clean.c, whose job it does
 *
 * Kernels leave a list of pixels in doubt, which are done one by one.  The colors of RGBA are packed for that.
 */

/* The kernel for packed RGB, if there is one. */
static ntp__normalize_rgb_fn *length_kernel(const job *j)
{
    return j->src->type == NTP_TYPE_U8    ? j->kernels->normalize_rgb8
           : j->src->type == NTP_TYPE_U16 ? j->kernels->normalize_rgb16
                                          : NULL;
}

/* Whole steps of packed RGB.  The few texels that the kernels leave are as in the source. */
static void clean_steps(const job *j, int32_t x, int32_t y, int32_t n, uint64_t *changed)
{
    void *d = ntp__at_mut(j->dst, x, y);
    const void *s = ntp__at(j->src, x, y);
    const ntp_const_image target = ntp_image_as_const(j->dst);
    ntp__block one;
    int32_t at[NTP__BLOCK];
    const uint32_t touch = j->how.touch_unused;
    const bool zzero = j->encoding == NTP_ENCODING_ZZERO;
    const int32_t left = j->how.method == NTP_CLEAN_DERIVE
                             ? j->kernels->derive_rgb16(d, s, n, zzero, touch, at, changed)
                             : length_kernel(j)(d, s, n, touch, at, changed);
    for (int32_t i = 0; i < left; i++) {
        ntp__unpack(&one, &target, x + at[i], y, 1);
        *changed += clean_at(j, &one, 0);
        ntp__pack(j->dst, &one, x + at[i], y, 1, 3);
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
