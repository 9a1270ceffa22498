/* SPDX-License-Identifier: MIT */
/*
 * whole_image.c - for verbs whose rows depend on rows far away: the whole input in memory
 */
#include "write/whole_image.h"

#include "cli.h"
#include "examine/hold_image.h"

enum { BLOCK_ROWS = 64 };

bool whole_begin(production *p, ntpio_error *error)
{
    if (!hold_check(&p->s, error))
        return false;
    buffer_reserve(&p->w->extra, (size_t) p->s.view.row_stride * (size_t) p->s.view.height);
    return true;
}

bool whole_add(production *p, const ntp_rect *area)
{
    hold_rows(p->w->extra.data, &p->s, area);
    return area->y1 == p->s.view.height;
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
