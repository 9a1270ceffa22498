/* SPDX-License-Identifier: MIT */
/*
 * surroundings.c - the texels from which an area is made, read beyond edges that wrap
 */
#include "surroundings.h"

typedef struct span {
    gint start, size;
} span;

static span spread(span at, span edges, gint reach, gboolean wrap)
{
    gint64 start = (gint64) at.start - reach;
    gint64 end = (gint64) at.start + at.size + reach;
    if (!wrap) {
        start = MAX(start, edges.start);
        end = MIN(end, (gint64) edges.start + edges.size);
    }
    return (span) { (gint) start, (gint) (end - start) };
}

static span within(span at, span edges)
{
    const gboolean beyond =
        at.start < edges.start || (gint64) at.start + at.size > (gint64) edges.start + edges.size;
    return beyond ? edges : at;
}

GeglRectangle surroundings_of(const GeglRectangle *area, const GeglRectangle *edges, gint reach,
                              gboolean wrap_x, gboolean wrap_y)
{
    const span x =
        spread((span) { area->x, area->width }, (span) { edges->x, edges->width }, reach, wrap_x);
    const span y =
        spread((span) { area->y, area->height }, (span) { edges->y, edges->height }, reach, wrap_y);
    return (GeglRectangle) { x.start, y.start, x.size, y.size };
}

GeglRectangle surroundings_wrapped(const GeglRectangle *area, const GeglRectangle *edges)
{
    const span x = within((span) { area->x, area->width }, (span) { edges->x, edges->width });
    const span y = within((span) { area->y, area->height }, (span) { edges->y, edges->height });
    return (GeglRectangle) { x.start, y.start, x.size, y.size };
}

/* The first piece of a span that does not cross an edge: where it is read, and how long it is. */
static span piece(span at, span edges)
{
    gint64 place = ((gint64) at.start - edges.start) % edges.size;
    if (place < 0)
        place += edges.size;
    return (span) { (gint) (edges.start + place), (gint) MIN(at.size, edges.size - place) };
}

void surroundings_read(GeglBuffer *input, const pixels *in, const GeglRectangle *edges,
                       const GeglRectangle *area, guchar *data)
{
    const gsize stride = (gsize) area->width * (gsize) in->bytes;
    span y = { area->y, area->height };
    while (y.size > 0) {
        const span rows = piece(y, (span) { edges->y, edges->height });
        guchar *to = data + (gsize) (y.start - area->y) * stride;
        span x = { area->x, area->width };
        while (x.size > 0) {
            const span columns = piece(x, (span) { edges->x, edges->width });
            const GeglRectangle part = { columns.start, rows.start, columns.size, rows.size };
            pixels_read(input, in, &part, to, (gint) stride);
            to += (gsize) columns.size * (gsize) in->bytes;
            x = (span) { x.start + columns.size, x.size - columns.size };
        }
        y = (span) { y.start + rows.size, y.size - rows.size };
    }
}
