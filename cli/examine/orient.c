/* SPDX-License-Identifier: MIT */
/*
 * orient.c - which way green points, and whether that makes a difference, while rows go by
 *
 * The measurement of a row needs its neighbors.  Where some of them are in an earlier block, a band
 * keeps them.  Photographs and masks need no orientation.  So rows that look like these are put aside
 * until the class is known.
 */
#include <stdlib.h>
#include <string.h>

#include "examine/examine.h"
#include "os/memory.h"

enum {
    BEFORE = 2, /* rows that ntp_orientation_add reads above the measured one */
    AFTER = 3,  /* and below */
    RING = BEFORE + 1 + AFTER,
    LAST = 1 << (RING - 1), /* the bit of the row that is measured when all of these are there */
    ASIDE = 4 << 20         /* bytes of rows that are put aside, at most */
};

/* ------------------------------------------------------------------------- slopes */

/* V = 2c - M of a sample; a float is judged after rounding to 16 bit. */
static int32_t numerator(const ntp_const_image *view, const unsigned char *at, int channel)
{
    float v;
    uint16_t word;
    switch (view->type) {
    case NTP_TYPE_U8:
        return 2 * at[channel] - 255;
    case NTP_TYPE_U16:
        memcpy(&word, at + channel * (ptrdiff_t) sizeof word, sizeof word);
        return 2 * word - 65535;
    default:
        memcpy(&v, at + channel * (ptrdiff_t) sizeof v, sizeof v);
        return v > 0 ? 2 * (int32_t) ((v < 1 ? v : 1) * 65535 + 0.5F) - 65535 : -65535;
    }
}

static bool is_unused(const ntp_const_image *view, const unsigned char *at, uint32_t touch)
{
    const int32_t m = view->type == NTP_TYPE_U8 ? 255 : 65535;
    const int32_t r = numerator(view, at, 0);
    const bool end = view->channels >= 3 && (r == m || r == -m) && numerator(view, at, 1) == r &&
                     numerator(view, at, 2) == r;
    const bool clear = view->channels == 4 && numerator(view, at, 3) == -m;
    return end || (clear && (touch & NTP_UNUSED_TRANSPARENT) == 0);
}

void slopes_add(steepest *most, const ntp_const_image *view, const void *row, uint32_t touch)
{
    /* the most that may count as 0; see slopes_are_flat */
    const int32_t neutral = view->type == NTP_TYPE_U8 ? 1 : 257;
    const unsigned char *at = row;
    for (int32_t x = 0; x < view->width && (most->x <= neutral || most->y <= neutral);
         x++, at += view->pixel_stride) {
        if (is_unused(view, at, touch))
            continue;
        const int32_t r = abs(numerator(view, at, 0)), g = abs(numerator(view, at, 1));
        most->x = r > most->x ? r : most->x;
        most->y = g > most->y ? g : most->y;
    }
}

bool slopes_are_flat(int32_t most, const ntp_stats *stats)
{
    return most <= (stats->stored_max == 65535 && stats->max == 255 ? 257 : 1);
}

/* -------------------------------------------------------------------- orientation */

void orient_begin(source *s)
{
    s->most = (steepest) { 0, 0 };
    if (s->orient == ORIENT_NOT)
        return;
    worker *w = s->w;
    if (w->orientation == NULL)
        w->orientation = need(os_alloc_zeros(ntp_orientation_size()));
    else
        ntp_orientation_clear(w->orientation);
    buffer_reserve(&w->band, RING * (size_t) s->view.row_stride);
    w->aside_rows = 0;
}

/* Have half of a row's texels about unit length?  One in some is looked at. */
static bool looks_like_normals(const ntp_const_image *view, const unsigned char *row)
{
    enum { TEXELS = 64, UNIT = 255 * 255 };
    const int32_t step = view->width / TEXELS + 1;
    int32_t n = 0, near = 0;
    for (int32_t x = step / 2; x < view->width; x += step, n++) {
        const unsigned char *at = row + x * view->pixel_stride;
        int32_t square = 0;
        for (int k = 0; k < 3; k++)
            square += (2 * at[k] - 255) * (2 * at[k] - 255);
        near += square > UNIT / 4 * 3 && square < UNIT / 4 * 5;
    }
    return 2 * near >= n;
}

static const unsigned char *row_of(const ntp_const_image *view, int32_t y)
{
    return (const unsigned char *) view->data +
           (ptrdiff_t) (y % view->ring_rows) * view->row_stride;
}

/* Puts the rows around row y aside; false: they are to be measured now. */
static bool put_aside(worker *w, const ntp_const_image *view, int32_t y)
{
    const size_t row = (size_t) view->row_stride, size = RING * row;
    if (view->type != NTP_TYPE_U8 || view->channels < 3 || w->aside_rows == ASIDE_ROWS ||
        (w->aside_rows + 1) * size > ASIDE || looks_like_normals(view, row_of(view, y)))
        return false;
    unsigned char *to = buffer_reserve(&w->aside, ASIDE) + w->aside_rows * size;
    for (int32_t k = y - BEFORE; k <= y + AFTER; k++)
        memcpy(to + (size_t) (k % RING) * row, row_of(view, k), row);
    w->aside_row[w->aside_rows++] = y;
    return true;
}

/* Bit i of `near` is that of row y + BEFORE - i.  Is one of these measured in the band, as not all rows around
 * it are in the area? */
static bool is_in_band(uint32_t near, const ntp_rect *area, int32_t y)
{
    bool any = false;
    for (int32_t i = 0; i < RING; i++)
        any |= (near >> i & 1) != 0 && (y - i < area->y0 || y - i + RING > area->y1);
    return any;
}

ntp_status orient_rows(source *s, const ntp_rect *area, uint32_t touch)
{
    const int32_t height = s->view.height, every_row = s->orient == ORIENT_EVERY_ROW;
    worker *const w = s->w;
    if (s->orient == ORIENT_NOT || s->view.encoding == NTP_ENCODING_HEIGHT)
        return NTP_OK;
    const size_t row = (size_t) s->view.row_stride;
    const unsigned char *from = source_rows(s, area);
    const ntp_const_image view = ntp_image_as_const(&s->view);
    ntp_const_image band = view;
    band.data = w->band.data;
    band.ring_rows = RING;
    const unsigned char *seen = from;
    for (int32_t y = area->y0; s->find_slopes && y < area->y1; y++, seen += row)
        slopes_add(&s->most, &view, seen, touch);
    uint32_t near = 0;
    for (int32_t y = area->y0 - AFTER; y < area->y0 + BEFORE; y++)
        near = near << 1 | (ntp_orientation_row(height, every_row, y) != 0);
    for (int32_t y = area->y0; y < area->y1; y++, from += row) {
        near = (near << 1 | (ntp_orientation_row(height, every_row, y + BEFORE) != 0)) &
               (LAST * 2 - 1);
        if (is_in_band(near, area, y))
            memcpy(w->band.data + (size_t) (y % RING) * row, from, row);
        const int32_t at = y - AFTER;
        const ntp_const_image *const around = at - BEFORE < area->y0 ? &band : &view;
        if (!(near & LAST) || (!every_row && put_aside(w, around, at)))
            continue;
        const ntp_rect measured = { 0, at, s->view.width, at + 1 };
        const ntp_status status =
            ntp_orientation_add(w->orientation, around, touch, every_row, &measured);
        if (status != NTP_OK)
            return status;
    }
    w->aside_touch = touch;
    return NTP_OK;
}

/* Measures the rows that were put aside. */
static void measure_aside(const source *s)
{
    worker *const w = s->w;
    ntp_const_image view = ntp_image_as_const(&s->view);
    view.ring_rows = RING;
    for (size_t i = 0; i < w->aside_rows; i++) {
        const int32_t y = w->aside_row[i];
        const ntp_rect measured = { 0, y, view.width, y + 1 };
        view.data = w->aside.data + i * RING * (size_t) view.row_stride;
        ntp_orientation_add(w->orientation, &view, w->aside_touch, 0, &measured);
    }
    w->aside_rows = 0;
}

/* The measurement needs x and y in tangent space, and has to know which is which. */
static bool can_tell(const facts *f)
{
    const bool any_order = f->info.channels < 3 && !f->forced; /* gray may be x or y */
    return facts_are_tangent(f) && !any_order;
}

void orient_end(const source *s, facts *f)
{
    const ntp_channel *gray = &f->stats.channel[0];
    const int32_t m = (int32_t) f->stats.max;
    const bool heights = s->view.encoding == NTP_ENCODING_HEIGHT;
    f->most =
        heights ? (steepest) { 2 * (int32_t) gray->max - m, m - 2 * (int32_t) gray->min } : s->most;
    f->orientation = (ntp_orientation_result) { 0 };
    if (s->orient != ORIENT_NOT && can_tell(f)) {
        measure_aside(s);
        ntp_orientation_summarize(&f->orientation, s->w->orientation);
    }
}
