/* SPDX-License-Identifier: MIT */
/*
 * most_used_square.c - the square of a texture that has the most used texels
 *
 * Used texels are counted in cells of 16 x 16.  Of all squares of whole cells, the one with the
 * most used texels is taken; of equal ones, the one nearest to the middle.
 */
#include "surface/most_used_square.h"

#include <stdlib.h>

#include "cli.h"

enum { CELL = 16 };

/* At each corner of a cell, the count of all cells to the left and above. */
typedef struct grid {
    int32_t columns, rows; /* whole cells */
    uint32_t *sum;         /* (columns + 1) * (rows + 1) */
} grid;

static uint32_t *corner(const grid *g, int32_t column, int32_t row)
{
    return g->sum + (size_t) row * (size_t) (g->columns + 1) + (size_t) column;
}

/* Adds the used texels of a row to its cells. */
static void add_row(uint32_t *cells, int32_t columns, const uint8_t *flags)
{
    for (int32_t c = 0; c < columns; c++) {
        for (int32_t i = 0; i < CELL; i++)
            cells[c] += (flags[c * CELL + i] & NTP_FLAG_UNUSED) == 0;
    }
}

static void count_cells(const grid *g, const uint8_t *flags, int32_t width)
{
    for (int32_t row = 0; row < g->rows; row++) {
        uint32_t *below = corner(g, 1, row + 1), sum = 0;
        for (int32_t i = 0; i < CELL; i++)
            add_row(below, g->columns, flags + ((ptrdiff_t) row * CELL + i) * width);
        for (int32_t column = 0; column < g->columns; column++) {
            sum += below[column];
            below[column] = sum + *corner(g, column + 1, row);
        }
    }
}

static int32_t from_middle(const grid *g, int32_t column, int32_t row, int32_t side)
{
    const int32_t x = 2 * column + side - g->columns, y = 2 * row + side - g->rows;
    return x * x + y * y;
}

uint32_t most_used_square(ntp_rect *square, const uint8_t *flags, int32_t width, int32_t height,
                          int32_t side)
{
    grid g = { width / CELL, height / CELL, NULL };
    const int32_t cells = side / CELL;
    uint32_t most = 0;
    int32_t nearest = INT32_MAX;
    if (g.columns < cells || g.rows < cells)
        return 0;
    g.sum = need(calloc((size_t) (g.columns + 1) * (size_t) (g.rows + 1), sizeof *g.sum));
    count_cells(&g, flags, width);
    for (int32_t y = 0; y + cells <= g.rows; y++) {
        for (int32_t x = 0; x + cells <= g.columns; x++) {
            const uint32_t used = *corner(&g, x + cells, y + cells) - *corner(&g, x, y + cells) -
                                  *corner(&g, x + cells, y) + *corner(&g, x, y);
            const int32_t off = from_middle(&g, x, y, cells);
            if (used < most || (used == most && off >= nearest))
                continue;
            most = used;
            nearest = off;
            *square = (ntp_rect) { x * CELL, y * CELL, x * CELL + side, y * CELL + side };
        }
    }
    free(g.sum);
    return most;
}
