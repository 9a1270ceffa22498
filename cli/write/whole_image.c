/* SPDX-License-Identifier: MIT */
/*
 * whole_image.c - for verbs whose rows depend on rows far away: the input held whole in memory
 */
#include "write/whole_image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK_ROWS = 64 };

/* As many as ntpio holds of an image that does not stream. */
static const uint64_t WHOLE_BYTES = (uint64_t) 4 << 30;

bool wrong_use(const production *p, const char *what, ntpio_error *error)
{
    text t = { 0 };
    text_name(&t, p->in->path);
    error->status = NTPIO_ERR_USAGE;
    snprintf(error->message, sizeof error->message, "%.380s: %s", text_string(&t), what);
    text_free(&t);
    return false;
}

bool whole_fits(const source *s)
{
    return (uint64_t) s->view.row_stride * (uint64_t) s->view.height <= WHOLE_BYTES;
}

static bool fits(const source *s, ntpio_error *error)
{
    if (whole_fits(s))
        return true;
    text t = { 0 };
    text_name(&t, s->in->path);
    error->status = NTPIO_ERR_LIMIT;
    snprintf(error->message, sizeof error->message, "%.380s: too large to be held in memory",
             text_string(&t));
    text_free(&t);
    return false;
}

bool whole_begin(production *p, ntpio_error *error)
{
    if (!fits(&p->s, error))
        return false;
    buffer_reserve(&p->w->extra, (size_t) p->s.view.row_stride * (size_t) p->s.view.height);
    return true;
}

static void keep_rows(const source *s, const ntp_rect *area, unsigned char *data)
{
    const size_t row = (size_t) s->view.row_stride;
    memcpy(data + (size_t) area->y0 * row, source_rows(s, area),
           row * (size_t) (area->y1 - area->y0));
}

bool whole_add(production *p, const ntp_rect *area)
{
    keep_rows(&p->s, area, p->w->extra.data);
    return area->y1 == p->s.view.height;
}

bool whole_read(source *s, ntp_image *whole, void **data, ntpio_error *error)
{
    ntp_rect area;
    int more;
    *data = NULL;
    if (!fits(s, error))
        return false;
    *data = need(malloc((size_t) s->view.row_stride * (size_t) s->view.height));
    while ((more = source_next(s, &area, error)) > 0)
        keep_rows(s, &area, *data);
    *whole = s->view;
    whole->data = *data;
    whole->ring_rows = 0;
    return more == 0;
}

bool whole_write(production *p, ntpio_writer *writer, int32_t width, int32_t height,
                 make_rows *make, void *context, ntpio_error *error)
{
    const ntp_image *view = &p->s.view;
    ntp_const_image src = ntp_image_as_const(view);
    src.data = p->w->extra.data;
    src.ring_rows = 0;
    ntp_image dst = ntp_image_packed(NULL, width, height, view->channels, view->type);
    dst.encoding = view->encoding;
    dst.y = view->y;
    dst.ring_rows = height < BLOCK_ROWS ? height : BLOCK_ROWS;
    dst.data = buffer_reserve(&p->w->extra2, (size_t) dst.row_stride * (size_t) dst.ring_rows);
    for (int32_t y = 0; y < height; y += dst.ring_rows) {
        const int32_t end = height - y < dst.ring_rows ? height : y + dst.ring_rows;
        const ntp_rect area = { 0, y, width, end };
        const ntp_status status = make(context, &dst, &src, &area);
        if (status != NTP_OK)
            return library_error(&p->s, status, error);
        if (interrupted_by != 0)
            return false;
        if (writer != NULL &&
            !ntpio_write_rows(writer, dst.data, dst.row_stride, (uint32_t) (end - y), error))
            return false;
    }
    return true;
}
