/* SPDX-License-Identifier: MIT */
/*
 * pixels.c - the pixel formats in which the operations read and write
 *
 * babl names formats by text: the letters of the model, each with the mark of its transfer curve
 * (none linear, ' that of the space, ~ that of sRGB), then the sample type: "R'G'B'A u16".
 */
#include "pixels.h"

enum { READ_AT_ONCE = 1 << 17 }; /* bytes of colors: they stay in the cache */

static const gint SAMPLE_BYTES[] = { [NTP_TYPE_U8] = 1, [NTP_TYPE_U16] = 2, [NTP_TYPE_F32] = 4 };
static const gchar *const SAMPLE_NAMES[] = {
    [NTP_TYPE_U8] = "u8", [NTP_TYPE_U16] = "u16", [NTP_TYPE_F32] = "float"
};

static BablModelFlag flags_of(const Babl *format)
{
    return babl_get_model_flags(babl_format_get_model(format));
}

/* CMYK, CIE Lab and similar models have no stored red, green and blue. */
static gboolean is_rgb_or_gray(const Babl *format)
{
    return (flags_of(format) & (BABL_MODEL_FLAG_RGB | BABL_MODEL_FLAG_GRAY)) != 0;
}

static const gchar *curve_of(const Babl *source)
{
    if (source == NULL || babl_format_is_palette(source) || !is_rgb_or_gray(source))
        return "'";
    const BablModelFlag flags = flags_of(source);
    return (flags & BABL_MODEL_FLAG_LINEAR) != 0       ? ""
           : (flags & BABL_MODEL_FLAG_PERCEPTUAL) != 0 ? "~"
                                                       : "'";
}

static ntp_type type_of(const Babl *source)
{
    if (source == NULL)
        return NTP_TYPE_F32;
    if (babl_format_is_palette(source))
        return NTP_TYPE_U8;
    if (!is_rgb_or_gray(source))
        return NTP_TYPE_F32;
    const gchar *name = babl_get_name(babl_format_get_type(source, 0));
    return g_strcmp0(name, "u8") == 0    ? NTP_TYPE_U8
           : g_strcmp0(name, "u16") == 0 ? NTP_TYPE_U16
                                         : NTP_TYPE_F32;
}

static pixels make(const Babl *source, gboolean gray, gboolean alpha)
{
    const gchar *curve = curve_of(source);
    const ntp_type type = type_of(source);
    gchar name[24];
    if (gray)
        g_snprintf(name, sizeof name, "Y%s%s %s", curve, alpha ? "A" : "", SAMPLE_NAMES[type]);
    else
        g_snprintf(name, sizeof name, "R%sG%sB%s%s %s", curve, curve, curve, alpha ? "A" : "",
                   SAMPLE_NAMES[type]);
    const gint channels = (gray ? 1 : 3) + (alpha ? 1 : 0);
    const Babl *space = source == NULL ? NULL : babl_format_get_space(source);
    const Babl *format = babl_format_with_space(name, space);
    return (pixels) { .format = format,
                      .stored = format,
                      .type = type,
                      .channels = channels,
                      .bytes = channels * SAMPLE_BYTES[type] };
}

pixels pixels_of(const Babl *source)
{
    if (source == NULL)
        return make(NULL, FALSE, TRUE);
    const gboolean gray =
        !babl_format_is_palette(source) && (flags_of(source) & BABL_MODEL_FLAG_GRAY) != 0;
    return make(source, gray, babl_format_has_alpha(source));
}

pixels pixels_luminance(const Babl *source)
{
    const pixels colors = pixels_of(source);
    const gboolean alpha = colors.channels == 4;
    const gint channels = alpha ? 2 : 1;
    return (pixels) { .format = babl_format_with_space(alpha ? "Y'A float" : "Y' float",
                                                       babl_format_get_space(colors.format)),
                      .stored = colors.format,
                      .luminance = luminance_of(colors.format),
                      .type = NTP_TYPE_F32,
                      .channels = channels,
                      .bytes = channels * SAMPLE_BYTES[NTP_TYPE_F32] };
}

pixels pixels_as_rgb(const Babl *source, gboolean alpha)
{
    return make(source, FALSE, alpha);
}

ntp_image pixels_view(const pixels *p, void *data, gint width, gint height)
{
    ntp_image view = ntp_image_packed(data, width, height, p->channels, p->type);
    view.encoding = NTP_ENCODING_HEIGHT;
    return view;
}

void pixels_read(GeglBuffer *input, const pixels *p, const GeglRectangle *part, void *data,
                 gint stride)
{
    if (p->luminance == NULL) {
        gegl_buffer_get(input, part, 1.0, p->format, data, stride, GEGL_ABYSS_NONE);
        return;
    }
    const gsize row = (gsize) part->width * (gsize) babl_format_get_bytes_per_pixel(p->stored);
    const gint most = (gint) CLAMP(READ_AT_ONCE / row, 1, (gsize) part->height);
    guchar *colors = g_malloc(row * (gsize) most), *to = data;
    for (gint y = 0; y < part->height; y += most) {
        const gint rows = MIN(most, part->height - y);
        const GeglRectangle some = { part->x, part->y + y, part->width, rows };
        gegl_buffer_get(input, &some, 1.0, p->stored, colors, GEGL_AUTO_ROWSTRIDE, GEGL_ABYSS_NONE);
        for (gint i = 0; i < rows; i++, to += stride)
            luminance_make(p->luminance, colors + row * (gsize) i, (gfloat *) (void *) to,
                           (gsize) part->width, p->channels == 2);
    }
    g_free(colors);
}

gdouble pixels_as_typed(gdouble value)
{
    const gfloat single = (gfloat) value;
    if ((gdouble) single != value)
        return value;
    for (gint digits = 6; digits <= 7; digits++) {
        gchar format[8], text[G_ASCII_DTOSTR_BUF_SIZE];
        g_snprintf(format, sizeof format, "%%.%dg", digits);
        const gdouble typed =
            g_ascii_strtod(g_ascii_formatd(text, sizeof text, format, value), NULL);
        if ((gfloat) typed == single)
            return typed;
    }
    return value;
}
