/* SPDX-License-Identifier: MIT */
/*
 * exchange.c - are x and y exchanged?
 *
 * On a surface the slope across, derived down, is the slope down, derived across: both are the
 * mixed derivative of the height.  So these two go together in a texture whose x and y are in their
 * places, with either sign of green.  Where x and y are exchanged, x derived across and y derived
 * down go together instead; in a sound texture these two are the pure derivatives, which have little
 * to do with each other.  The difference of the two correlations, each without its sign, is the mean of
 * four scales, each half as fine as the one before.  How sure it is comes from leaving out one
 * block of the picture at a time (jackknife).
 */
#include "surface/exchange.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "examine/middle_and_lines.h"
#include "examine/samples.h"

enum {
    SCALES = 4,
    GRID = 8, /* blocks a side */
    BLOCKS = GRID * GRID,
    LEAST = 17, /* a smaller picture has too few texels in a block */
    SUMS = 3
};

/* Slopes beyond this come of texels at the rim of the disc, where z is all rounding. */
static const double Z_LEAST = 0.05;

/* The difference, its deviations, and the least that a scale may say to the contrary.  Of 109 real
 * textures with x and y in their places none passes these; exchanged, three quarters of them do. */
static const double SURE_DIFFERENCE = 0.02, SURE_DEVIATIONS = 4, CONTRARY = -0.03;

typedef struct slopes {
    float *x, *y;
    int32_t width, height;
} slopes;

/* Products of a pair of derivatives, summed by block: a b, a a, b b. */
typedef struct pair_sums {
    double at[BLOCKS][SUMS];
} pair_sums;

static void take_slopes(slopes *s, const ntp_image *image)
{
    for (int32_t y = 0; y < s->height; y++) {
        const unsigned char *at =
            (const unsigned char *) image->data + (ptrdiff_t) y * image->row_stride;
        for (int32_t x = 0; x < s->width; x++, at += image->pixel_stride) {
            const size_t i = (size_t) y * (size_t) s->width + (size_t) x;
            const double nx = 2 * sample_value(image->type, at, 0) - 1,
                         ny = 2 * sample_value(image->type, at, 1) - 1;
            const double square = 1 - nx * nx - ny * ny;
            const double nz = square > Z_LEAST * Z_LEAST ? sqrt(square) : Z_LEAST;
            s->x[i] = (float) (nx / nz);
            s->y[i] = (float) (ny / nz);
        }
    }
}

/* Means of 2 x 2, in place. */
static void halve(slopes *s)
{
    const int32_t width = s->width / 2, height = s->height / 2;
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            const size_t row = (size_t) s->width, to = (size_t) y * (size_t) width + (size_t) x;
            const size_t from = 2 * (size_t) y * row + 2 * (size_t) x;
            s->x[to] = (s->x[from] + s->x[from + 1] + s->x[from + row] + s->x[from + row + 1]) / 4;
            s->y[to] = (s->y[from] + s->y[from + 1] + s->y[from + row] + s->y[from + row + 1]) / 4;
        }
    }
    s->width = width;
    s->height = height;
}

/* Derivatives between the four texels from i on: across, or down. */
static double across(const float *v, size_t i, size_t row)
{
    return (double) v[i + 1] + v[i + row + 1] - v[i] - v[i + row];
}

static double down(const float *v, size_t i, size_t row)
{
    return (double) v[i + row] + v[i + row + 1] - v[i] - v[i + 1];
}

static void derive(const slopes *s, size_t i, bool exchanged, double *a, double *b)
{
    const size_t row = (size_t) s->width;
    *a = exchanged ? across(s->x, i, row) : down(s->x, i, row);
    *b = exchanged ? down(s->y, i, row) : across(s->y, i, row);
}

/* A long pair is shortened to the mean length, so that single edges do not decide. */
static void sum_pairs(const slopes *s, bool exchanged, pair_sums *sums)
{
    const int32_t width = s->width - 1, height = s->height - 1;
    double mean = 0, a, b;
    memset(sums, 0, sizeof *sums);
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            derive(s, (size_t) y * (size_t) s->width + (size_t) x, exchanged, &a, &b);
            mean += sqrt(a * a + b * b);
        }
    }
    mean /= (double) width * height;
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            derive(s, (size_t) y * (size_t) s->width + (size_t) x, exchanged, &a, &b);
            const double length = sqrt(a * a + b * b);
            const double part = length > mean ? mean / length : 1;
            double *to = sums->at[y * GRID / height * GRID + x * GRID / width];
            to[0] += part * part * a * b;
            to[1] += part * part * a * a;
            to[2] += part * part * b * b;
        }
    }
}

/* Without its sign, of all blocks but one (-1: of all). */
static double correlation(const pair_sums *sums, int without)
{
    double total[SUMS] = { 0 };
    for (int i = 0; i < BLOCKS; i++) {
        for (int k = 0; k < SUMS && i != without; k++)
            total[k] += sums->at[i][k];
    }
    const double scale = sqrt(total[1] * total[2]);
    return scale > 0 ? fabs(total[0]) / scale : 0;
}

/* difference[0] is of the whole picture, the others leave one block out; *least: of one scale. */
static int add_scales(slopes *s, double *difference, double *least)
{
    pair_sums right, exchanged;
    int scales = 0;
    double before = 0;
    *least = 1;
    for (; scales < SCALES && s->width >= LEAST && s->height >= LEAST; scales++) {
        sum_pairs(s, false, &right);
        sum_pairs(s, true, &exchanged);
        for (int i = 0; i <= BLOCKS; i++)
            difference[i] += correlation(&exchanged, i - 1) - correlation(&right, i - 1);
        if (difference[0] - before < *least)
            *least = difference[0] - before;
        before = difference[0];
        halve(s);
    }
    return scales;
}

void exchange_look(source *s, facts *f)
{
    const ntp_image middle = middle_image(s);
    const size_t texels = (size_t) middle.width * (size_t) middle.height;
    double difference[BLOCKS + 1] = { 0 }, mean = 0, spread = 0, least;
    if (!facts_are_tangent(f) || f->type.type == NTP_CLASS_ONE_COLOR)
        return;
    slopes v = { .width = middle.width, .height = middle.height };
    v.x = need(malloc(2 * texels * sizeof *v.x));
    v.y = v.x + texels;
    take_slopes(&v, &middle);
    const int scales = add_scales(&v, difference, &least);
    free(v.x);
    if (scales == 0)
        return;
    for (int i = 1; i <= BLOCKS; i++)
        mean += difference[i] / BLOCKS;
    for (int i = 1; i <= BLOCKS; i++)
        spread += (difference[i] - mean) * (difference[i] - mean);
    const double error = sqrt(spread * (BLOCKS - 1) / BLOCKS) / scales;
    f->exchange.difference = difference[0] / scales;
    f->exchange.deviations = error > 0 ? f->exchange.difference / error : 0;
    f->exchange.sure = f->exchange.difference > SURE_DIFFERENCE &&
                       f->exchange.deviations > SURE_DEVIATIONS && least > CONTRARY;
}
