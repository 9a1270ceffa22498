/* SPDX-License-Identifier: MIT */
/*
 * exchange.c - are x and y exchanged?
 *
 * A surface varies across where it slopes across, and down where it slopes down: x derived across and y
 * derived down (the pure derivatives) have more energy than x derived down and y derived across (the
 * mixed ones).  For a wave of heights with frequencies u across and v down these energies are
 * u^4 + v^4 and 2 u^2 v^2; the difference (u^2 - v^2)^2 is never negative, and for all directions alike
 * the ratio is 3 to 1.  This holds with either sign of green.  Exchanging x and y exchanges the two.  Of
 * noise both have as much, so nothing is said.  The share of the difference is the mean of four scales,
 * each half as fine as the one before.  How sure it is comes from leaving out one block of the picture
 * at a time (jackknife).
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
    SUMS = 2
};

/* Slopes beyond this come of texels at the rim of the disc, where z is all rounding. */
static const double Z_LEAST = 0.05;

/* The difference, its deviations, and the least that a scale may say to the contrary.  These were chosen
 * on 404 real textures; docs/gpu-textures.md says how many of them are told. */
static const double SURE_DIFFERENCE = 0.05, SURE_DEVIATIONS = 5, CONTRARY = -0.03;

typedef struct slopes {
    float *x, *y;
    int32_t width, height;
} slopes;

/* Energies of the derivatives by block: mixed and pure. */
typedef struct energies {
    double at[BLOCKS][SUMS];
} energies;

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

static void derive(const slopes *s, int32_t x, int32_t y, double energy[SUMS])
{
    const size_t row = (size_t) s->width, i = (size_t) y * row + (size_t) x;
    const double xy = down(s->x, i, row), yx = across(s->y, i, row);
    const double xx = across(s->x, i, row), yy = down(s->y, i, row);
    energy[0] = xy * xy + yx * yx;
    energy[1] = xx * xx + yy * yy;
}

/* What is longer than the mean is shortened to it, so that single edges do not decide. */
static void sum_energies(const slopes *s, energies *sums)
{
    const int32_t width = s->width - 1, height = s->height - 1;
    double mean = 0, energy[SUMS];
    memset(sums, 0, sizeof *sums);
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            derive(s, x, y, energy);
            mean += sqrt(energy[0] + energy[1]);
        }
    }
    mean /= (double) width * height;
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            derive(s, x, y, energy);
            const double whole = energy[0] + energy[1], most = mean * mean;
            const double part = whole > most ? most / whole : 1;
            double *to = sums->at[y * GRID / height * GRID + x * GRID / width];
            for (int k = 0; k < SUMS; k++)
                to[k] += part * energy[k];
        }
    }
}

/* By how much of all the mixed energy is more than the pure one, of all blocks but one (-1: of all). */
static double difference_of(const energies *sums, int without)
{
    double total[SUMS] = { 0 };
    for (int i = 0; i < BLOCKS; i++) {
        for (int k = 0; k < SUMS && i != without; k++)
            total[k] += sums->at[i][k];
    }
    const double whole = total[0] + total[1];
    return whole > 0 ? (total[0] - total[1]) / whole : 0;
}

/* difference[0] is of the whole picture, the others leave one block out; *least: of one scale. */
static int add_scales(slopes *s, double *difference, double *least)
{
    energies sums;
    int scales = 0;
    double before = 0;
    *least = 1;
    for (; scales < SCALES && s->width >= LEAST && s->height >= LEAST; scales++) {
        sum_energies(s, &sums);
        for (int i = 0; i <= BLOCKS; i++)
            difference[i] += difference_of(&sums, i - 1);
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
