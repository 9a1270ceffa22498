/* SPDX-License-Identifier: MIT */
/*
 * view.c - views over the caller's pixels: checks, and conversion to planar levels and back
 */
#include "base/view.h"

#include "base/cpu.h"
#include "base/finite.h"
#include "base/inlining.h"
#ifdef NTP_HAVE_AVX2
#  include "base/rgb_avx2.h"
#endif

#include <string.h>

uint32_t ntp_version(void)
{
    return (uint32_t) NTP_VERSION_MAJOR << 16 | NTP_VERSION_MINOR << 8 | NTP_VERSION_PATCH;
}

const char *ntp_status_string(ntp_status status)
{
    switch (status) {
    case NTP_OK:
        return "no error";
    case NTP_ERR_ARGUMENT:
        return "an argument is NULL or outside its range";
    case NTP_ERR_SHAPE:
        return "a view is malformed, two views do not agree, or an area lies outside";
    case NTP_ERR_FORMAT:
        return "this type, encoding or number of channels is not supported here";
    case NTP_ERR_OVERLAP:
        return "source and destination overlap";
    case NTP_ERR_SCRATCH:
        return "working memory is missing, misaligned or too small";
    case NTP_ERR_CANCELLED:
        return "cancelled";
    case NTP_ERR_NOT_CONVERGED:
        return "the iteration did not reach its tolerance";
    }
    return "unknown status";
}

ntp_image ntp_image_packed(void *data, int32_t width, int32_t height, int32_t channels,
                           ntp_type type)
{
    ntp_image image;
    memset(&image, 0, sizeof image);
    image.data = data;
    image.pixel_stride = (ptrdiff_t) channels * ntp__sample_size(type);
    image.row_stride = (ptrdiff_t) width * image.pixel_stride;
    image.width = width;
    image.height = height;
    image.channels = channels;
    image.type = type;
    image.encoding = channels >= 3   ? NTP_ENCODING_STANDARD
                     : channels == 2 ? NTP_ENCODING_XY
                                     : NTP_ENCODING_HEIGHT;
    image.y = NTP_Y_UP;
    return image;
}

ntp_const_image ntp_image_as_const(const ntp_image *image)
{
    ntp_const_image view;
    view.data = image->data;
    view.row_stride = image->row_stride;
    view.pixel_stride = image->pixel_stride;
    view.width = image->width;
    view.height = image->height;
    view.channels = image->channels;
    view.ring_rows = image->ring_rows;
    view.type = image->type;
    view.encoding = image->encoding;
    view.y = image->y;
    return view;
}

static bool channels_fit(const ntp_const_image *v)
{
    switch (v->encoding) {
    case NTP_ENCODING_STANDARD:
    case NTP_ENCODING_ZZERO:
    case NTP_ENCODING_VECTOR:
        return v->channels == 3 || v->channels == 4;
    case NTP_ENCODING_XY:
        return v->channels >= 2 && v->channels <= 4;
    case NTP_ENCODING_HEIGHT:
        return v->channels >= 1 && v->channels <= 4;
    }
    return false;
}

ntp_status ntp__check_view(const ntp_const_image *v)
{
    if (v == NULL || v->data == NULL)
        return NTP_ERR_ARGUMENT;
    if ((int) v->type < NTP_TYPE_U8 || (int) v->type > NTP_TYPE_F32 ||
        (int) v->encoding < NTP_ENCODING_STANDARD || (int) v->encoding > NTP_ENCODING_HEIGHT ||
        (v->y != NTP_Y_UP && v->y != NTP_Y_DOWN))
        return NTP_ERR_ARGUMENT;
    if (v->width < 1 || v->height < 1 || v->width > NTP_MAX_SIDE || v->height > NTP_MAX_SIDE ||
        v->ring_rows < 0)
        return NTP_ERR_SHAPE;
    ptrdiff_t size = ntp__sample_size(v->type);
    if ((uintptr_t) v->data % (uintptr_t) size != 0 || v->row_stride % size != 0 ||
        v->pixel_stride % size != 0)
        return NTP_ERR_SHAPE;
    if (!channels_fit(v) || (v->encoding == NTP_ENCODING_VECTOR && v->type != NTP_TYPE_F32))
        return NTP_ERR_FORMAT;
    return NTP_OK;
}

ntp_status ntp__check_normals(const ntp_const_image *v)
{
    NTP__TRY(ntp__check_view(v));
    return v->encoding == NTP_ENCODING_HEIGHT ? NTP_ERR_FORMAT : NTP_OK;
}

ntp_const_image ntp__transposed(const ntp_const_image *v)
{
    ntp_const_image turned = *v;
    turned.width = v->height;
    turned.height = v->width;
    turned.row_stride = v->pixel_stride;
    turned.pixel_stride = v->row_stride;
    return turned;
}

ntp_status ntp__check_picture(const ntp_const_image *v, int32_t min_channels, int32_t max_channels)
{
    NTP__TRY(ntp__check_view(v));
    if (v->type != NTP_TYPE_U8 || v->encoding != NTP_ENCODING_HEIGHT ||
        v->channels < min_channels || v->channels > max_channels)
        return NTP_ERR_FORMAT;
    return NTP_OK;
}

ntp_status ntp__check_area(ntp_rect *rect, const ntp_const_image *v, const ntp_rect *area)
{
    if (area == NULL) {
        rect->x0 = rect->y0 = 0;
        rect->x1 = v->width;
        rect->y1 = v->height;
        return NTP_OK;
    }
    if (area->x0 < 0 || area->y0 < 0 || area->x0 >= area->x1 || area->y0 >= area->y1 ||
        area->x1 > v->width || area->y1 > v->height)
        return NTP_ERR_SHAPE;
    *rect = *area;
    return NTP_OK;
}

/* A float has 24 bits and 65535 has 16, so the product and the sum are exact doubles wherever
 * the result is neither below 0 nor above M. */
int32_t ntp__level_of_unit(float v)
{
    double c = (double) v * 65535.0 + 0.5;
    c = c > 0 ? c : 0; /* of NaN, too; one instruction each, as noise would mislead branches */
    c = c < 65535.0 ? c : 65535.0;
    return (int32_t) c;
}

/* The levels of one channel; p: its first sample.  Two loops, as compilers make branches of one.
 *
 * Of components, floor((v + 1)/2 * M + 1/2) = (M + 1 + floor(M v)) / 2, as M + 1 is even.  M v is an exact double.
 * As M is odd, it is whole only where v is: at -1, for which -M - 1 gives level 0, too, and at 0 and 1.  Returns
 * whether all samples are finite. */
static bool levels_of_floats(int32_t *restrict to, const char *p, ptrdiff_t stride, int32_t n,
                             bool component)
{
    const float least = component ? -1 : 0;
    enum { EXPONENT = 0x7f800000, ONE = 0x00800000 };
    float within[NTP__BLOCK];
    uint32_t exponents = 0; /* and one more each */
    for (int32_t i = 0; i < n; i++, p += stride) {
        const float v = *(const float *) (const void *) p;
        const float some = v > least ? v : least; /* of NaN, too */
        within[i] = some < 1 ? some : 1;
        uint32_t bits;
        memcpy(&bits, &v, sizeof bits);
        exponents |= (bits & EXPONENT) + ONE;
    }
    const double half = component ? 0 : 0.5;
    for (int32_t i = 0; i < n; i++)
        to[i] = (int32_t) ((double) within[i] * 65535.0 + half);
    for (int32_t i = 0; component && i < n; i++)
        to[i] = (65536 + to[i] - (within[i] < 0)) >> 1;
    return exponents <= EXPONENT;
}

/* Marks texels that are not finite, of which the first `checked` samples say that, or float vectors of length 0. */
SELDOM static bool find_broken(ntp__block *block, const char *p, ptrdiff_t stride, int32_t n,
                               int32_t checked, const float *zero)
{
    bool any = false;
    for (int32_t i = 0; i < n; i++, p += stride) {
        const float *s = (const float *) (const void *) p;
        bool broken = zero != NULL && s[0] == zero[0] && s[1] == zero[1] && s[2] == zero[2];
        for (int32_t k = 0; k < checked && !broken; k++)
            broken = !ntp__is_finite((double) s[k]);
        block->broken[i] = broken;
        any = any || broken;
    }
    return any;
}

static void unpack_f32(ntp__block *block, const ntp_const_image *v, int32_t x, int32_t y, int32_t n,
                       int32_t channels)
{
    enum { MIDDLE = 32768 }; /* the level of 0, or 1/2 */
    const bool vector = v->encoding == NTP_ENCODING_VECTOR, xy = v->encoding == NTP_ENCODING_XY,
               zzero = v->encoding == NTP_ENCODING_ZZERO;
    const bool has_zero = channels >= 3 && v->encoding <= NTP_ENCODING_VECTOR && !xy;
    const float zero = vector ? 0.0f : 0.5f, zeros[3] = { zero, zero, zzero ? 0.0f : zero };
    const int32_t zero_z = zzero ? 0 : MIDDLE;
    const char *p = ntp__at(v, x, y);
    int32_t suspect = 0;
    for (int32_t k = 0; k < channels; k++)
        suspect |= !levels_of_floats(block->c[k], p + k * (ptrdiff_t) sizeof(float),
                                     v->pixel_stride, n, vector && k < 3);
    for (int32_t i = 0; has_zero && i < n; i++)
        suspect |=
            (block->c[0][i] == MIDDLE) & (block->c[1][i] == MIDDLE) & (block->c[2][i] == zero_z);
    if (suspect)
        block->any_broken = find_broken(block, p, v->pixel_stride, n,
                                        xy             ? 2
                                        : channels > 3 ? 3
                                                       : channels,
                                        has_zero ? zeros : NULL);
}

static void fill(int32_t *plane, int32_t value, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        plane[i] = value;
}

/* Packed pixels of 2 to 4 channels have their own loops, so that the compiler sees constants. */
#define UNPACK_PACKED(T, CHANNELS)                                                                 \
    do {                                                                                           \
        const T *s = (const T *) ntp__at(v, x, y);                                                 \
        for (int32_t i = 0; i < n; i++) {                                                          \
            block->c[0][i] = s[(ptrdiff_t) i * CHANNELS];                                          \
            block->c[1][i] = s[(ptrdiff_t) i * CHANNELS + 1];                                      \
            if (CHANNELS > 2)                                                                      \
                block->c[2][i] = s[(ptrdiff_t) i * CHANNELS + 2];                                  \
            if (CHANNELS > 3)                                                                      \
                block->c[3][i] = s[(ptrdiff_t) i * CHANNELS + 3];                                  \
        }                                                                                          \
    } while (0)

#define UNPACK_STRIDED(T)                                                                          \
    do {                                                                                           \
        const char *p = ntp__at(v, x, y);                                                          \
        for (int32_t i = 0; i < n; i++, p += v->pixel_stride) {                                    \
            for (int32_t k = 0; k < v->channels; k++)                                              \
                block->c[k][i] = ((const T *) (const void *) p)[k];                                \
        }                                                                                          \
    } while (0)

/* With AVX2: reads packed RGB; false: there is another way only. */
static bool unpack_rgb(ntp__block *block, const ntp_const_image *v, int32_t x, int32_t y, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (v->channels == 3 && v->type != NTP_TYPE_F32 && ntp__is_packed(v) &&
        ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__unpack_rgb_avx2(block, ntp__at(v, x, y), n, v->type == NTP_TYPE_U16);
        return true;
    }
#else
    (void) block, (void) v, (void) x, (void) y, (void) n;
#endif
    return false;
}

/* The other way round. */
static bool pack_rgb(const ntp_image *v, const ntp__block *block, int32_t x, int32_t y, int32_t n,
                     int32_t channels)
{
#ifdef NTP_HAVE_AVX2
    if (channels == 3 && v->pixel_stride == 3 * ntp__sample_size(v->type) &&
        ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__pack_rgb_avx2(ntp__at_mut(v, x, y), block, n, v->type == NTP_TYPE_U16);
        return true;
    }
#else
    (void) v, (void) block, (void) x, (void) y, (void) n, (void) channels;
#endif
    return false;
}

void ntp__unpack(ntp__block *block, const ntp_const_image *v, int32_t x, int32_t y, int32_t n)
{
    int32_t m = ntp__max(v->type);
    bool packed = ntp__is_packed(v);
    block->any_broken = false;
    const bool done = unpack_rgb(block, v, x, y, n);
    if (!done && v->type == NTP_TYPE_F32)
        unpack_f32(block, v, x, y, n, v->channels);
    else if (!done && v->type == NTP_TYPE_U8 && packed && v->channels == 2)
        UNPACK_PACKED(uint8_t, 2);
    else if (!done && v->type == NTP_TYPE_U8 && packed && v->channels == 3)
        UNPACK_PACKED(uint8_t, 3);
    else if (!done && v->type == NTP_TYPE_U8 && packed && v->channels == 4)
        UNPACK_PACKED(uint8_t, 4);
    else if (!done && v->type == NTP_TYPE_U16 && packed && v->channels == 2)
        UNPACK_PACKED(uint16_t, 2);
    else if (!done && v->type == NTP_TYPE_U16 && packed && v->channels == 3)
        UNPACK_PACKED(uint16_t, 3);
    else if (!done && v->type == NTP_TYPE_U16 && packed && v->channels == 4)
        UNPACK_PACKED(uint16_t, 4);
    else if (!done && v->type == NTP_TYPE_U8)
        UNPACK_STRIDED(uint8_t);
    else if (!done)
        UNPACK_STRIDED(uint16_t);

    size_t bytes = (size_t) n * sizeof block->c[0][0];
    if (v->encoding == NTP_ENCODING_HEIGHT && v->channels <= 2) {
        if (v->channels == 2)
            memcpy(block->c[3], block->c[1], bytes);
        memcpy(block->c[1], block->c[0], bytes);
        memcpy(block->c[2], block->c[0], bytes);
        if (v->channels == 2)
            return;
    } else if (v->channels == 2) {
        /* Black stays black, so that it still counts as unused. */
        for (int32_t i = 0; i < n; i++)
            block->c[2][i] = block->c[0][i] | block->c[1][i] ? m : 0;
    }
    if (v->channels < 4)
        fill(block->c[3], m, n);
}

#define PACK(T)                                                                                    \
    do {                                                                                           \
        char *p = ntp__at_mut(v, x, y);                                                            \
        if (channels == 2 && v->pixel_stride == 2 * (ptrdiff_t) sizeof(T)) {                       \
            T *d = (T *) (void *) p;                                                               \
            for (int32_t i = 0; i < n; i++) {                                                      \
                d[(ptrdiff_t) i * 2] = (T) block->c[0][i];                                         \
                d[(ptrdiff_t) i * 2 + 1] = (T) block->c[1][i];                                     \
            }                                                                                      \
        } else if (channels == 3 && v->pixel_stride == 3 * (ptrdiff_t) sizeof(T)) {                \
            T *d = (T *) (void *) p;                                                               \
            for (int32_t i = 0; i < n; i++) {                                                      \
                d[(ptrdiff_t) i * 3] = (T) block->c[0][i];                                         \
                d[(ptrdiff_t) i * 3 + 1] = (T) block->c[1][i];                                     \
                d[(ptrdiff_t) i * 3 + 2] = (T) block->c[2][i];                                     \
            }                                                                                      \
        } else {                                                                                   \
            for (int32_t i = 0; i < n; i++, p += v->pixel_stride) {                                \
                for (int32_t k = 0; k < channels; k++)                                             \
                    ((T *) (void *) p)[k] = (T) block->c[k][i];                                    \
            }                                                                                      \
        }                                                                                          \
    } while (0)

void ntp__pack(const ntp_image *v, const ntp__block *block, int32_t x, int32_t y, int32_t n,
               int32_t channels)
{
    if (pack_rgb(v, block, x, y, n, channels))
        return;
    if (v->type == NTP_TYPE_U8)
        PACK(uint8_t);
    else
        PACK(uint16_t);
}

/* v = c*times - less is exact, and v + v/M the quotient rounded once: see ntp__decode. */
void ntp__floats_of_levels(float *restrict to, const int32_t *restrict level, int32_t n, int32_t m,
                           bool component)
{
    const float unit = m > 255 ? 0x1p-16F : 0x1p-8F, over = 1 / (float) m;
    const float times = component ? 2 * unit : unit, less = component ? unit * (float) m : 0;
    for (int32_t i = 0; i < n; i++) {
        const float v = (float) level[i] * times - less;
        to[i] = v + v * over;
    }
}

void ntp__pack_floats(const ntp_image *v, ntp__float_planes planes, int32_t x, int32_t y, int32_t n)
{
    const int32_t channels = v->channels;
    char *p = ntp__at_mut(v, x, y);
    for (int32_t i = 0; i < n; i++, p += v->pixel_stride) {
        float *d = (float *) (void *) p;
        d[0] = planes[0][i];
        if (channels > 1)
            d[1] = planes[1][i];
        if (channels > 2)
            d[2] = planes[2][i];
        if (channels > 3)
            d[3] = planes[3][i];
    }
}
