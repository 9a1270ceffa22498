/* SPDX-License-Identifier: MIT */
/*
 * normals_area.c - normals of an area of a layer of heights, block by block
 */
#include "normals_area.h"

#include "../channels.h"
#include "../occlusion.h"
#include "lit.h"
#include "output.h"
#include "surroundings.h"

enum {
    BLOCK_WIDTH = 512, /* a block of RGBA heights and its normals fit into the second-level cache */
    BLOCK_HEIGHT = 64
};

gint normals_area_reach(const ntp_normals_options *how, const smoothing *forms)
{
    return ntp_normals_reach(how) + smoothing_reach(forms);
}

GeglRectangle normals_area_reads(const ntp_normals_options *how, const smoothing *forms,
                                 const GeglRectangle *area, const GeglRectangle *edges)
{
    return surroundings_of(area, edges, normals_area_reach(how, forms),
                           how->border_x == NTP_BORDER_WRAP, how->border_y == NTP_BORDER_WRAP);
}

/* The surroundings of a block, with the reach of a stencil. */
static GeglRectangle block_surroundings(const normals_area *j, const GeglRectangle *block)
{
    return surroundings_of(block, j->edges, ntp_normals_reach(&j->how),
                           j->recipe.how.border_x == NTP_BORDER_WRAP && j->errors == NULL,
                           j->recipe.how.border_y == NTP_BORDER_WRAP);
}

/* Reads and smooths all heights for an area. */
static gboolean smooth_area(normals_area *j, GeglBuffer *input, const GeglRectangle *area)
{
    if (!smoothing_acts(&j->forms))
        return TRUE;
    j->smoothed = normals_area_reads(&j->recipe.how, &j->forms, area, j->edges);
    const gsize texels = (gsize) j->smoothed.width * (gsize) j->smoothed.height;
    const gint channels = smoothing_channels(j->in.channels);
    guchar *data = g_try_malloc(texels * (gsize) j->in.bytes);
    gfloat *smooth = g_try_malloc(texels * (gsize) channels * sizeof *smooth);
    gboolean ok = data != NULL && smooth != NULL;
    j->smooth =
        ntp_image_packed(smooth, j->smoothed.width, j->smoothed.height, channels, NTP_TYPE_F32);
    j->smooth.encoding = NTP_ENCODING_HEIGHT;
    if (ok) {
        surroundings_read(input, &j->in, j->edges, &j->smoothed, data);
        const ntp_image read = pixels_view(&j->in, data, j->smoothed.width, j->smoothed.height);
        const ntp_const_image heights = ntp_image_as_const(&read);
        ok = smoothing_run(&j->forms, &j->smooth, &heights, &j->how) == NTP_OK;
        j->how.source = NTP_HEIGHT_SOURCE_RED;
    }
    g_free(data);
    return ok;
}

/* The heights around a block. */
static ntp_const_image heights_of(const normals_area *j, GeglBuffer *input,
                                  const GeglRectangle *around)
{
    ntp_image view = pixels_view(&j->in, j->heights, around->width, around->height);
    if (j->smooth.data == NULL) {
        surroundings_read(input, &j->in, j->edges, around, j->heights);
        return ntp_image_as_const(&view);
    }
    view = j->smooth;
    view.data = (guchar *) view.data + (around->y - j->smoothed.y) * view.row_stride +
                (around->x - j->smoothed.x) * view.pixel_stride;
    view.width = around->width;
    view.height = around->height;
    return ntp_image_as_const(&view);
}

static ntp_status make_normals(const normals_area *j, const ntp_image *dst,
                               const ntp_const_image *src, const ntp_rect *area)
{
    if (j->errors == NULL)
        return ntp_normals_from_height(dst, src, &j->how, NULL, area);
    return ntp_normals_dithered(dst, src, &j->how, j->errors,
                                ntp_normals_dithered_scratch_size(src->width), NULL, area);
}

static gboolean make_block(const normals_area *j, GeglBuffer *input, GeglBuffer *output,
                           const GeglRectangle *block, const GeglRectangle *wanted)
{
    const GeglRectangle around = block_surroundings(j, block);
    const ntp_const_image src = heights_of(j, input, &around);
    GeglRectangle part;

    /* Both views cover what was read; only the block of the normals is in memory. */
    ntp_rect area = { block->x - around.x, block->y - around.y, block->x - around.x + block->width,
                      block->y - around.y + block->height };
    ntp_image dst = pixels_view(&j->out, j->normals, around.width, around.height);
    dst.encoding = j->recipe.to;
    dst.y = j->recipe.y;
    if (make_normals(j, &dst, &src, &area) != NTP_OK)
        return FALSE;
    if (!gegl_rectangle_intersect(&part, block, wanted))
        return TRUE;
    area = (ntp_rect) { part.x - around.x, part.y - around.y, part.x - around.x + part.width,
                        part.y - around.y + part.height };
    if (j->light != NULL) {
        const ntp_image normals = dst;
        dst = pixels_view(&j->out, j->heights, around.width, around.height);
        if (!lit_paint(&j->out, &dst, &normals, j->light, &area, part.x - j->edges->x,
                       part.y - j->edges->y))
            return FALSE;
    } else {
        if (j->open != NULL)
            occlusion_put(&dst, &area, j->open, part.x - j->edges->x, part.y - j->edges->y);
        channels_arrange(&dst, (channel_order) j->recipe.channels, &area);
    }
    const guchar *first =
        (const guchar *) dst.data + area.y0 * dst.row_stride + area.x0 * dst.pixel_stride;
    output_write(output, j->format, &part, &j->out, first, (gint) dst.row_stride, j->blending);
    return TRUE;
}

/* Makes blocks of an area, the upper ones first, and outputs what is wanted of them. */
static gboolean make_blocks(normals_area *j, GeglBuffer *input, GeglBuffer *output,
                            const GeglRectangle *area, const GeglRectangle *wanted)
{
    const gint width = j->errors != NULL ? area->width : MIN(BLOCK_WIDTH, area->width);
    const gsize margin = 2 * (gsize) ntp_normals_reach(&j->how);
    const gsize most = ((gsize) width + margin) * (BLOCK_HEIGHT + margin);
    /* The lit picture takes the place of the heights. */
    j->heights = g_malloc(most * (gsize) MAX(j->in.bytes, j->out.bytes));
    j->normals = g_malloc(most * (gsize) j->out.bytes);
    gboolean ok = TRUE;
    for (gint y = 0; y < area->height && ok; y += BLOCK_HEIGHT) {
        for (gint x = 0; x < area->width && ok; x += width) {
            const GeglRectangle block = { area->x + x, area->y + y, MIN(width, area->width - x),
                                          MIN(BLOCK_HEIGHT, area->height - y) };
            ok = make_block(j, input, output, &block, wanted);
        }
    }
    g_free(j->heights);
    g_free(j->normals);
    return ok;
}

gboolean normals_area_make(normals_area *j, GeglBuffer *input, GeglBuffer *output,
                           const GeglRectangle *area, const GeglRectangle *wanted)
{
    const gboolean smooth = smooth_area(j, input, area);
    /* The stencils stay inside what was read, so nothing beyond it is needed. */
    if (j->how.border_x == NTP_BORDER_WRAP && j->errors == NULL)
        j->how.border_x = NTP_BORDER_CLAMP;
    if (j->how.border_y == NTP_BORDER_WRAP)
        j->how.border_y = NTP_BORDER_CLAMP;
    const gboolean ok = smooth && make_blocks(j, input, output, area, wanted);
    g_free(j->smooth.data);
    j->smooth.data = NULL;
    return ok;
}
