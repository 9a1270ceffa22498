/* SPDX-License-Identifier: MIT */
/*
 * hold_image.c - a file held whole in memory
 */
#include "examine/hold_image.h"

#include <stdlib.h>
#include <string.h>

#include "text/text.h"

/* As many as ntpio holds of an image that does not stream. */
static const uint64_t MOST_BYTES = (uint64_t) 4 << 30;

bool hold_is_possible(const source *s)
{
    return (uint64_t) s->view.row_stride * (uint64_t) s->view.height <= MOST_BYTES;
}

bool hold_check(const source *s, ntpio_error *error)
{
    return hold_is_possible(s) ||
           file_error(error, NTPIO_ERR_LIMIT, s->in->path, "too large to be held in memory");
}

void hold_rows(unsigned char *held, const source *s, const ntp_rect *area)
{
    const size_t row = (size_t) s->view.row_stride;
    memcpy(held + (size_t) area->y0 * row, source_rows(s, area),
           row * (size_t) (area->y1 - area->y0));
}

bool hold_all(ntp_image *image, void **data, source *s, ntpio_error *error)
{
    ntp_rect area;
    int more;
    *data = NULL;
    if (!hold_check(s, error))
        return false;
    *data = need(malloc((size_t) s->view.row_stride * (size_t) s->view.height));
    while ((more = source_next(s, &area, error)) > 0)
        hold_rows(*data, s, &area);
    *image = s->view;
    image->data = *data;
    image->ring_rows = 0;
    return more == 0;
}
