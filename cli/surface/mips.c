/* SPDX-License-Identifier: MIT */
/*
 * mips.c - were the mips of a DDS or KTX2 made of whole vectors?
 *
 * A texel of a mip is the mean of vectors, made a unit vector again.  A tool that knows nothing of
 * normals takes the means of x and of y.  Where only these two are stored, z is computed of them, and
 * the surface becomes flatter than it is.  So each texel m of a mip is compared with the right one r
 * and with the plain mean p.  The sum of (m - r)(p - r), divided by that of (p - r)(p - r), is 0 for
 * right mips and 1 for plain means, and what compression changed adds to both signs.
 */
#include "surface/mips.h"

#include <math.h>
#include <stdlib.h>

#include "cli.h"
#include "examine/hold_image.h"
#include "examine/samples.h"

enum {
    MIPS_LOOKED_AT = 5, /* further ones have few texels */
    LEAST_TEXELS = 256
};

/* What must lie between right and plain means on average to tell one from the other, a tenth of a
 * degree; and the middle between both. */
static const double LEAST_DISTANCE = 0.1 / 57.3, PLAIN = 0.5;

typedef struct vec {
    double x, y, z;
} vec;

typedef struct sums {
    double along, square, distance;
    uint64_t texels;
} sums;

static double component(const ntp_image *image, int32_t x, int32_t y, int channel)
{
    const unsigned char *at = (const unsigned char *) image->data +
                              (ptrdiff_t) y * image->row_stride +
                              (ptrdiff_t) x * image->pixel_stride;
    return 2 * sample_value(image->type, at, channel) - 1;
}

/* With z computed; too long x and y are shortened. */
static vec with_z(double x, double y)
{
    const double square = x * x + y * y;
    const double length = square > 1 ? sqrt(square) : 1;
    return (vec) { x / length, y / length, square < 1 ? sqrt(1 - square) : 0 };
}

/* Adds a mip to the sums: each of its texels covers side x side of the picture. */
static void add_mip(sums *t, const ntp_image *whole, const ntp_image *mip, int32_t side)
{
    const double count = (double) side * side;
    for (int32_t y = 0; y < mip->height; y++) {
        for (int32_t x = 0; x < mip->width; x++) {
            vec mean = { 0, 0, 0 };
            double px = 0, py = 0;
            for (int32_t i = 0; i < side * side; i++) {
                const int32_t u = x * side + i % side, v = y * side + i / side;
                const vec n = with_z(component(whole, u, v, 0), component(whole, u, v, 1));
                mean = (vec) { mean.x + n.x, mean.y + n.y, mean.z + n.z };
                px += n.x / count;
                py += n.y / count;
            }
            const double length = sqrt(mean.x * mean.x + mean.y * mean.y + mean.z * mean.z);
            if (length <= 0)
                continue;
            const double rx = mean.x / length, ry = mean.y / length;
            const vec is = with_z(component(mip, x, y, 0), component(mip, x, y, 1));
            const double dx = px - rx, dy = py - ry;
            t->along += (is.x - rx) * dx + (is.y - ry) * dy;
            t->square += dx * dx + dy * dy;
            t->distance += sqrt(dx * dx + dy * dy);
            t->texels++;
        }
    }
}

static bool look_at_mip(sums *t, const ntp_image *whole, const source *s, uint32_t mip,
                        ntpio_error *error)
{
    ntpio_limits limits = *s->limits;
    source of_mip;
    ntp_image held;
    void *data = NULL;
    limits.mip = mip;
    if (!source_open(&of_mip, s->w, s->in, &limits, error))
        return false;
    source_view(&of_mip, NTP_ENCODING_XY, NTP_Y_UP, NULL, 0);
    const bool ok = hold_all(&held, &data, &of_mip, error);
    if (ok)
        add_mip(t, whole, &held, 1 << mip);
    free(data);
    source_close(&of_mip);
    return ok;
}

bool mips_look(source *s, facts *f, ntpio_error *error)
{
    const ntpio_info *info = s->info; /* until the source is rewound: that makes another */
    const uint32_t mips = info->mips, sides = info->width | info->height;
    ntp_image whole;
    void *data = NULL;
    sums t = { 0 };
    if (!info->red_green || mips < 2 || s->limits->mip != 0 || info->sample_bytes > 2 ||
        f->encoding != NTP_ENCODING_XY || s->bytes != NULL || !hold_is_possible(s))
        return true;
    bool ok = source_rewind(s, error) && hold_all(&whole, &data, s, error);
    for (uint32_t mip = 1; ok && mip < mips && mip <= MIPS_LOOKED_AT; mip++) {
        if ((sides & ((1u << mip) - 1)) != 0)
            break; /* a mip whose texels do not cover whole ones */
        ok = look_at_mip(&t, &whole, s, mip, error);
    }
    free(data);
    if (ok && t.texels >= LEAST_TEXELS) {
        f->mips.degrees = t.distance / (double) t.texels * 57.295779513;
        f->mips.plain =
            t.distance > LEAST_DISTANCE * (double) t.texels && t.along > PLAIN * t.square;
    }
    return ok;
}
