/* SPDX-License-Identifier: MIT */
/*
 * middle_and_lines.c - what a check keeps of the rows that go by: the middle, and some lines
 *
 * The middle shows how well a surface fits.  Rows and columns from one edge to the other show
 * whether the edges fit together.  So memory does not grow with the image.  An image no larger than
 * the middle needs no lines.
 */
#include "examine/middle_and_lines.h"

#include <string.h>

enum {
    SIDE = 1024,           /* of the middle, at most */
    MOST_LINES = 128,      /* rows, and columns */
    LEAST_LINES = 16,      /* that ntp_find_seams asks for */
    LINE_TEXELS = 1 << 20, /* of all rows, and of all columns: there are fewer long lines */
};

static int32_t held_to(int32_t v, int32_t least, int32_t most)
{
    return v < least ? least : v > most ? most : v;
}

/* How many lines of this length are kept, out of `count`. */
static int32_t lines_of(int32_t length, int32_t count)
{
    return held_to(held_to(LINE_TEXELS / length, LEAST_LINES, MOST_LINES), 0, count);
}

static int32_t line_at(int32_t i, int32_t lines, int32_t count)
{
    return (int32_t) ((int64_t) i * count / lines);
}

ntp_rect middle_area(const source *s)
{
    const int32_t w = s->view.width, h = s->view.height;
    const int32_t wide = w < SIDE ? w : SIDE, high = h < SIDE ? h : SIDE;
    const int32_t x = (w - wide) / 2, y = (h - high) / 2;
    return (ntp_rect) { x, y, x + wide, y + high };
}

bool middle_is_whole(const source *s)
{
    return s->view.width <= SIDE && s->view.height <= SIDE;
}

/* Pixels of the view in a buffer. */
static ntp_image packed(const source *s, const buffer *b, int32_t width, int32_t height)
{
    ntp_image image = ntp_image_packed(b->data, width, height, s->view.channels, s->view.type);
    image.encoding = s->view.encoding;
    image.y = s->view.y;
    return image;
}

static ntp_image packed_rows(const source *s)
{
    const int32_t w = s->view.width, h = s->view.height;
    return packed(s, &s->w->across, w, lines_of(w, h));
}

static ntp_image packed_columns(const source *s)
{
    const int32_t w = s->view.width, h = s->view.height;
    return packed(s, &s->w->down, lines_of(h, w), h);
}

static void reserve(buffer *b, const ntp_image *image)
{
    buffer_reserve(b, (size_t) image->row_stride * (size_t) image->height);
}

ntp_image middle_image(const source *s)
{
    const ntp_rect area = middle_area(s);
    return packed(s, &s->w->middle, area.x1 - area.x0, area.y1 - area.y0);
}

void middle_begin(source *s)
{
    if (!s->keep_middle)
        return;
    const ntp_image middle = middle_image(s), rows = packed_rows(s), columns = packed_columns(s);
    reserve(&s->w->middle, &middle);
    if (middle_is_whole(s))
        return;
    reserve(&s->w->across, &rows);
    reserve(&s->w->down, &columns);
}

/* The row y, if it is one of those that are kept. */
static void keep_row(const source *s, const ntp_image *rows, const unsigned char *row, int32_t y)
{
    const int32_t h = s->view.height;
    /* the line at y, or the next one above */
    const int32_t i = (int32_t) (((int64_t) (y + 1) * rows->height - 1) / h);
    if (line_at(i, rows->height, h) == y)
        memcpy((unsigned char *) rows->data + (ptrdiff_t) i * rows->row_stride, row,
               (size_t) rows->row_stride);
}

static void keep_columns(const source *s, const ntp_image *columns, const unsigned char *row,
                         int32_t y)
{
    const size_t pixel = (size_t) s->view.pixel_stride;
    unsigned char *to = (unsigned char *) columns->data + (ptrdiff_t) y * columns->row_stride;
    for (int32_t i = 0; i < columns->width; i++, to += pixel) {
        const size_t x = (size_t) line_at(i, columns->width, s->view.width);
        memcpy(to, row + x * pixel, pixel);
    }
}

void middle_rows(source *s, const ntp_rect *area)
{
    if (!s->keep_middle || s->view.encoding == NTP_ENCODING_HEIGHT)
        return;
    const ntp_rect part = middle_area(s);
    const ntp_image middle = middle_image(s), rows = packed_rows(s), columns = packed_columns(s);
    const bool lines = !middle_is_whole(s);
    const unsigned char *from = source_rows(s, area);
    for (int32_t y = area->y0; y < area->y1; y++, from += s->view.row_stride) {
        if (y >= part.y0 && y < part.y1)
            memcpy((unsigned char *) middle.data + (ptrdiff_t) (y - part.y0) * middle.row_stride,
                   from + (ptrdiff_t) part.x0 * s->view.pixel_stride, (size_t) middle.row_stride);
        if (lines) {
            keep_row(s, &rows, from, y);
            keep_columns(s, &columns, from, y);
        }
    }
}

ntp_status middle_seams(const source *s, ntp_seam seam[2], uint32_t touch)
{
    const ntp_image middle = middle_image(s), rows = packed_rows(s), columns = packed_columns(s);
    const ntp_const_image all = ntp_image_as_const(&middle), across = ntp_image_as_const(&rows),
                          down = ntp_image_as_const(&columns);
    if (middle_is_whole(s))
        return ntp_find_seams(&seam[0], &seam[1], &all, touch);
    const ntp_status status = ntp_find_seams(&seam[0], NULL, &across, touch);
    return status == NTP_OK ? ntp_find_seams(NULL, &seam[1], &down, touch) : status;
}
