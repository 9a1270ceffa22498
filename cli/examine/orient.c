/* SPDX-License-Identifier: MIT */
/*
 * orient.c - which way green points, measured while the rows of a file go by
 *
 * The measurement of a row needs its neighbors, and some of them may be in an earlier block.  So a
 * ring keeps the rows that are needed.
 */
#include <stdlib.h>
#include <string.h>

#include "examine/examine.h"

enum {
    BEFORE = 2, /* rows that ntp_orientation_add reads above the measured one */
    AFTER = 3,  /* and below */
    RING = BEFORE + 1 + AFTER
};

void orient_begin(source *s)
{
    if (s->orient == ORIENT_NOT)
        return;
    worker *w = s->w;
    if (w->orientation == NULL)
        w->orientation = need(calloc(1, ntp_orientation_size()));
    else
        ntp_orientation_clear(w->orientation);
    buffer_reserve(&w->band, RING * (size_t) s->view.row_stride);
}

static bool is_needed(int32_t height, int32_t every_row, int32_t y)
{
    bool any = false;
    for (int32_t k = y - AFTER; k <= y + BEFORE; k++)
        any |= ntp_orientation_row(height, every_row, k) != 0;
    return any;
}

ntp_status orient_rows(source *s, const ntp_rect *area, uint32_t touch)
{
    const int32_t height = s->view.height, every_row = s->orient == ORIENT_EVERY_ROW;
    if (s->orient == ORIENT_NOT || s->view.encoding == NTP_ENCODING_HEIGHT)
        return NTP_OK;
    const size_t row = (size_t) s->view.row_stride;
    const unsigned char *from = source_rows(s, area);
    ntp_const_image view = ntp_image_as_const(&s->view);
    view.data = s->w->band.data;
    view.ring_rows = RING;
    for (int32_t y = area->y0; y < area->y1; y++, from += row) {
        if (is_needed(height, every_row, y))
            memcpy(s->w->band.data + (size_t) (y % RING) * row, from, row);
        const ntp_rect measured = { 0, y - AFTER, s->view.width, y - AFTER + 1 };
        if (!ntp_orientation_row(height, every_row, y - AFTER))
            continue;
        const ntp_status status =
            ntp_orientation_add(s->w->orientation, &view, touch, every_row, &measured);
        if (status != NTP_OK)
            return status;
    }
    return NTP_OK;
}

/* The measurement needs x and y in tangent space, and has to know which is which. */
static bool can_tell(const facts *f)
{
    const bool any_order = f->info.channels < 3 && !f->forced; /* gray may be x or y */
    return facts_are_tangent(f) && !any_order;
}

void orient_end(const source *s, facts *f)
{
    f->orientation = (ntp_orientation_result) { 0 };
    if (s->orient != ORIENT_NOT && can_tell(f))
        ntp_orientation_summarize(&f->orientation, s->w->orientation);
}
