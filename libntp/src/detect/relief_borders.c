/* SPDX-License-Identifier: MIT */
/*
 * relief_borders.c - may a map of this surface look across its edges?
 *
 * The step from the last column to the first tells it: in a texture that tiles it is like those
 * inside.  Sums over rows tell it from details: what stands out in one row does not in all.  A line
 * that goes through all rows, such as the edge of a plank, may lie at the border of the picture; but
 * then there are others inside.  Of normals find_seams.c knows more; where it is undecided the
 * heights at both ends must differ, too: the bevels of a panel are a step, but they cancel out.
 */
#include "base/finite.h"
#include "base/view.h"
#include "texel/sample.h"

enum {
    MOST_LINES = 128,
    LEAST_TEXELS = 16 /* of a line; and the least number of lines */
};

/* Of heights smoothed over 8 texels, seams of parts that were cut out are 2 to 6 times as high as
 * the highest step inside, and those of all that tile at most 0.9 times. */
static const double SEAM = 1.5;

/* Of normals that it is undecided about: ntp_seam.closure, as find_seams.c has it for a seam. */
static const double LEAST_CLOSURE = 0.3;

/* The sum of squares of the steps from column `from` to column `to`. */
static double step(const ntp_const_image *v, int32_t from, int32_t to, int32_t lines)
{
    const int32_t channels = v->encoding == NTP_ENCODING_HEIGHT ? 1 : 2; /* or x and y */
    double sum = 0;
    for (int32_t i = 0; i < lines; i++) {
        const int32_t y = (int32_t) ((int64_t) i * v->height / lines);
        for (int32_t c = 0; c < channels; c++) {
            const double by = ntp__sample(v, to, y, c) - ntp__sample(v, from, y, c);
            sum += ntp__is_finite(by) ? by * by : 0;
        }
    }
    return sum;
}

static bool has_seam(const ntp_const_image *v)
{
    const int32_t lines = v->height < MOST_LINES ? v->height : MOST_LINES;
    if (v->width < LEAST_TEXELS || lines < LEAST_TEXELS)
        return false;
    const double most = step(v, v->width - 1, 0, lines) / (SEAM * SEAM);
    bool higher = most > 0;
    for (int32_t x = 1; x < v->width && higher; x++)
        higher = step(v, x - 1, x, lines) < most;
    return higher;
}

static ntp_border border_of(const ntp_const_image *v, const ntp_seam *normals)
{
    const bool told = normals != NULL && normals->decided;
    const bool ends_meet = normals != NULL && normals->closure < LEAST_CLOSURE;
    const bool seam = told ? !normals->tiles : !ends_meet && has_seam(v);
    return seam ? NTP_BORDER_CLAMP : NTP_BORDER_WRAP;
}

ntp_status ntp_relief_borders(ntp_border *x, ntp_border *y, const ntp_const_image *src)
{
    ntp_seam across, down;
    if (x == NULL || y == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_view(src));
    if (src->ring_rows != 0)
        return NTP_ERR_SHAPE;
    const ntp_const_image turned = ntp__transposed(src);
    const bool heights = src->encoding == NTP_ENCODING_HEIGHT;
    if (!heights)
        NTP__TRY(ntp_find_seams(&across, &down, src, 0));
    *x = border_of(src, heights ? NULL : &across);
    *y = border_of(&turned, heights ? NULL : &down);
    return NTP_OK;
}
