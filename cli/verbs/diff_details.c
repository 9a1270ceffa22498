/* SPDX-License-Identifier: MIT */
/*
 * diff_details.c - what ntp diff says of a DDS or KTX2 besides: its mips, its worst blocks
 *
 * Blocks of 4 x 4 texels are ranked by the sum of the distances between the vectors; their angles
 * are those of ntp_diff.
 */
#include "verbs/diff_details.h"

#include <math.h>
#include <stdlib.h>

#include "cli.h"
#include "examine/hold_image.h"
#include "examine/samples.h"

enum { BLOCK = 4 };

/* ------------------------------------------------------------------------ blocks */

static void vector_at(double v[3], const ntp_const_image *image, int32_t x, int32_t y)
{
    const unsigned char *at = (const unsigned char *) image->data +
                              (ptrdiff_t) y * image->row_stride +
                              (ptrdiff_t) x * image->pixel_stride;
    v[0] = 2 * sample_value(image->type, at, 0) - 1;
    v[1] = 2 * sample_value(image->type, at, 1) - 1;
    if (image->y == NTP_Y_DOWN)
        v[1] = -v[1];
    const double rest = 1 - v[0] * v[0] - v[1] * v[1];
    v[2] = image->encoding == NTP_ENCODING_XY ? sqrt(rest > 0 ? rest : 0)
                                              : sample_value(image->type, at, 2);
    if (image->encoding == NTP_ENCODING_STANDARD)
        v[2] = 2 * v[2] - 1;
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3 && length > 0; i++)
        v[i] /= length;
}

static ntp_rect block_at(const ntp_const_image *image, int32_t x, int32_t y)
{
    return (ntp_rect) { x, y, x + BLOCK < image->width ? x + BLOCK : image->width,
                        y + BLOCK < image->height ? y + BLOCK : image->height };
}

static double distance_in(const ntp_const_image *a, const ntp_const_image *b, const ntp_rect *block)
{
    double sum = 0, u[3], v[3];
    for (int32_t y = block->y0; y < block->y1; y++) {
        for (int32_t x = block->x0; x < block->x1; x++) {
            vector_at(u, a, x, y);
            vector_at(v, b, x, y);
            sum += sqrt((u[0] - v[0]) * (u[0] - v[0]) + (u[1] - v[1]) * (u[1] - v[1]) +
                        (u[2] - v[2]) * (u[2] - v[2]));
        }
    }
    return sum;
}

/* Puts a block into the list of the worst, the worst first; equal ones keep their order. */
static void rank(diff_details *d, double *distance, double found, int32_t x, int32_t y)
{
    int at = d->blocks;
    while (at > 0 && distance[at - 1] < found)
        at--;
    if (at == WORST_BLOCKS || found <= 0)
        return;
    if (d->blocks < WORST_BLOCKS)
        d->blocks++;
    for (int i = d->blocks - 1; i > at; i--) {
        distance[i] = distance[i - 1];
        d->worst[i] = d->worst[i - 1];
    }
    distance[at] = found;
    d->worst[at] = (block_facts) { .x = x, .y = y };
}

static bool angles_in(ntp_angles *angles, worker *w, const ntp_const_image *a,
                      const ntp_const_image *b, const ntp_rect *area)
{
    ntp_diff_stats stats;
    ntp_diff *diff = worker_diff(w);
    if (ntp_diff_add(diff, NULL, a, b, area) != NTP_OK ||
        ntp_diff_summarize(&stats, diff) != NTP_OK)
        return false;
    *angles = stats.angles;
    return true;
}

static bool find_blocks(diff_details *d, worker *w, const ntp_const_image *a,
                        const ntp_const_image *b)
{
    double distance[WORST_BLOCKS] = { 0 };
    for (int32_t y = 0; y < a->height; y += BLOCK) {
        for (int32_t x = 0; x < a->width; x += BLOCK) {
            const ntp_rect block = block_at(a, x, y);
            rank(d, distance, distance_in(a, b, &block), x, y);
        }
    }
    for (int i = 0; i < d->blocks; i++) {
        const ntp_rect block = block_at(a, d->worst[i].x, d->worst[i].y);
        if (!angles_in(&d->worst[i].angles, w, a, b, &block))
            return false;
    }
    return true;
}

/* ------------------------------------------------------------------------ mips */

/* The right mip of a picture, in memory that the caller frees. */
static bool make_mip(ntp_image *made, const ntp_const_image *from, int32_t width, int32_t height)
{
    const ntp_resize_options how = { .filter = NTP_FILTER_BOX };
    const size_t size = ntp_resize_plan_size(&how, from->width, from->height, width, height);
    const size_t row = (size_t) from->pixel_stride * (size_t) width;
    void *memory = need_aligned(size), *scratch = NULL;
    ntp_resize_plan *plan;
    ntp_status status =
        ntp_resize_plan_init(&plan, memory, size, &how, from->width, from->height, width, height);
    *made = ntp_image_packed(need(malloc(row * (size_t) height)), width, height, from->channels,
                             from->type);
    made->encoding = from->encoding;
    made->y = from->y;
    if (status == NTP_OK) {
        const size_t working = ntp_resize_scratch_size(plan);
        scratch = need_aligned(working);
        status = ntp_resize(made, from, plan, scratch, working, NULL);
    }
    free_aligned(scratch);
    free_aligned(memory);
    return status == NTP_OK;
}

static bool compare_mip(mip_facts *m, const ntp_const_image *whole, const source *texture,
                        uint32_t mip, ntpio_error *error)
{
    ntpio_limits limits = *texture->limits;
    source s;
    ntp_image held, right = { 0 };
    void *data = NULL;
    limits.mip += mip;
    if (!source_open(&s, texture->w, texture->in, &limits, error))
        return false;
    source_view(&s, texture->view.encoding, texture->view.y, texture->mapped ? texture->map : NULL,
                texture->view.channels);
    bool ok = hold_all(&held, &data, &s, error);
    if (ok) {
        const ntp_const_image b = ntp_image_as_const(&held);
        *m = (mip_facts) { .width = held.width, .height = held.height };
        ok = make_mip(&right, whole, held.width, held.height);
        const ntp_const_image a = ntp_image_as_const(&right);
        ok = ok && angles_in(&m->angles, texture->w, &a, &b, NULL);
        if (!ok)
            library_error(&s, NTP_ERR_ARGUMENT, error);
    }
    free(right.data);
    free(data);
    source_close(&s);
    return ok;
}

bool diff_details_find(diff_details *d, source *plain, source *texture, ntpio_error *error)
{
    const uint32_t first = texture->limits->mip, count = texture->info->mips;
    ntp_image held_a, held_b;
    void *data_a = NULL, *data_b = NULL;
    bool ok =
        hold_all(&held_a, &data_a, plain, error) && hold_all(&held_b, &data_b, texture, error);
    if (ok) {
        const ntp_const_image a = ntp_image_as_const(&held_a), b = ntp_image_as_const(&held_b);
        ok = find_blocks(d, texture->w, &a, &b) || library_error(texture, NTP_ERR_ARGUMENT, error);
        for (uint32_t mip = 1; ok && first + mip < count && mip < MIPS_MAX; mip++) {
            ok = compare_mip(&d->mip[mip - 1], &a, texture, mip, error);
            d->mips += ok;
        }
    }
    free(data_a);
    free(data_b);
    d->known = ok;
    return ok;
}
