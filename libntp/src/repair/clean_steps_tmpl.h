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

/* A job that cleans packed RGB in place.  The views have to outlive it. */
ONE_COPY static job job_in_place(const job *j, ntp_image *image, ntp_const_image *view, void *rgb)
{
    job there = *j;
    *image = ntp_image_packed(rgb, NTP__BLOCK, 1, 3, j->src->type);
    *view = ntp_image_as_const(image);
    there.dst = image;
    there.src = view;
    return there;
}

/* Less than a step of packed RGB, filled up with flat colors, which do not change. */
static void clean_last(const job *j, int32_t x, int32_t y, int32_t n, uint64_t *changed)
{
    /* 32768, 32768, 65535; and the bytes 128, 128, 255, twice: kernels are for little-endian processors */
    static const uint16_t FLAT[2][3] = { { 0x8000, 0x8000, 0xffff }, { 0x8080, 0x80ff, 0xff80 } };
    uint16_t rgb[3 * NTP__KERNEL_STEP];
    ntp_image image;
    ntp_const_image view;
    const job last = job_in_place(j, &image, &view, rgb);
    const size_t size = (size_t) (n * j->src->pixel_stride);
    for (int32_t i = 0; i < 3 * NTP__KERNEL_STEP; i++)
        rgb[i] = FLAT[j->m == 255][i % 3];
    memcpy(rgb, ntp__at(j->src, x, y), size);
    clean_steps(&last, 0, 0, NTP__KERNEL_STEP, changed);
    memcpy(ntp__at_mut(j->dst, x, y), rgb, size);
}

/* Whole steps of packed RGBA.  Flat colors, which transparent pixels have meanwhile, do not change. */
static void clean_colors(const job *j, int32_t x, int32_t y, int32_t n, uint64_t *changed)
{
    uint16_t rgb[3 * (NTP__BLOCK + 1)];
    ntp_image image;
    ntp_const_image view;
    const job colors = job_in_place(j, &image, &view, rgb);
    const void *s = ntp__at(j->src, x, y);
    j->kernels->move_colors((uint8_t *) rgb, NULL, s, n, j->m, j->how.touch_unused);
    clean_steps(&colors, 0, 0, n, changed);
    j->kernels->move_colors((uint8_t *) rgb, (uint8_t *) ntp__at_mut(j->dst, x, y), s, n, j->m,
                            j->how.touch_unused);
}
