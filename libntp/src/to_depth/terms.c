/* SPDX-License-Identifier: MIT */
/*
 * terms.c - from normals and a camera to springs and forces
 *
 * A point at depth Z that pixel (u, v) sees is Z ((u - cx)/fx, (v - cy)/fy, 1).  Its derivatives
 * along u and v are at right angles to the normal.  With d = z - x (u - cx)/fx + y (v - cy)/fy for
 * a normal (x, y, z) as stored, y up, that is fx d (log Z)_u = x and fy d (log Z)_v = -y.  Without
 * a camera it is z Z_u = x and z Z_v = -y.
 */
#include "to_depth/terms.h"

#include <math.h>

#include "texel/direction.h"
#include "texel/unused.h"
#include "to_depth/exponential.h"

/* Vectors shorter than this are no normals but the middle gray of an empty background. */
static const double SHORTEST = 0.25;

/* Of a spring, relative to that between two texels that face the viewer.  It keeps every texel tied
 * to its neighbors, and holds single slopes below 1 / (2 sqrt(LEAST)) = 500. */
static const double LEAST = 1e-6;

/* Normals this far apart, as points of the unit sphere, halve the trust in a pair of neighbors.  Anything
 * from half to 1.5 times as much does about as well on made scenes. */
static const double BEND = 0.07;

/* That holds where the surface is plain.  Where bends abound, as in the folds and patterns of cloth, a
 * bend tells no cliff.  So BEND is multiplied by 1 + (b/MANY)^2.  b is the share of bends among the
 * pairs of the tile and the eight around it; one of the size SHARP counts half. */
static const double MANY = 0.125, SHARP = 0.3;

enum { TILE = 8 }; /* texels along a side */

/* Slopes above 1 / GRAZING are taken for that. */
static const double GRAZING = 0.002;

/* The same of slopes in means of two: steeper ones are those of rims, which are seen on a few texels
 * and known badly.  Anything from half to twice as much does about as well on made scenes. */
static const double STEEP = 0.05;

enum { RUN = 256 }; /* nodes whose shares are found at once */

void ntp__terms_init(ntp__terms *t, int32_t nodes, ntp__scratch *memory)
{
    size_t n = (size_t) nodes;
    t->nodes = nodes;
    for (int32_t d = 0; d < 2; d++) {
        ntp__axis_terms *a = &t->axis[d];
        a->after = ntp__take(memory, n * sizeof *a->after);
        a->before = ntp__take(memory, n * sizeof *a->before);
        a->view = ntp__take(memory, n * sizeof *a->view);
        a->rise = ntp__take(memory, n * sizeof *a->rise);
        a->even = ntp__take(memory, n * sizeof *a->even);
        a->trust = ntp__take(memory, n * sizeof *a->trust);
        a->share = ntp__take(memory, n * sizeof *a->share);
        a->stiff = ntp__take(memory, n * sizeof *a->stiff);
        a->pull = ntp__take(memory, n * sizeof *a->pull);
    }
    t->z = ntp__take(memory, n * sizeof *t->z);
    t->force = ntp__take(memory, n * sizeof *t->force);
}

/* ------------------------------------------------------------------------------ reading */

typedef struct reader {
    ntp__terms *t;
    const ntp_const_image *src;
    const ntp_depth_options *how;
    ntp__term_counts *counts;
    int32_t m;
} reader;

static bool masked_out(const ntp_const_image *mask, int32_t x, int32_t y)
{
    const void *at = ntp__at(mask, x, y);
    return mask->type == NTP_TYPE_U8 ? *(const uint8_t *) at == 0 : *(const uint16_t *) at == 0;
}

/* The normal of texel i of the block; false: there is none. */
static bool read_normal(double normal[3], const ntp__block *block, int32_t i, const reader *r)
{
    int32_t v[3];
    uint32_t touch = r->how->touch_unused;
    if (r->src->encoding == NTP_ENCODING_VECTOR) /* of any length, so (2, 2, 2) is no padding */
        touch |= NTP_UNUSED_BLACK | NTP_UNUSED_WHITE;
    if (ntp__texel_unused(block, i, r->m, touch)) {
        r->counts->not_finite += block->any_broken && block->broken[i];
        return false;
    }
    ntp__texel_vector(v, block, i, r->m, r->src->encoding);
    double x = v[0], y = v[1], z = v[2], length = sqrt(x * x + y * y + z * z);
    if (length < SHORTEST * r->m)
        return false;
    normal[0] = x / length;
    normal[1] = (r->src->y == NTP_Y_UP ? y : -y) / length;
    normal[2] = z / length;
    return true;
}

/* The equations of node i, at texel (x, y). */
static void add_node(const reader *r, int32_t i, const double normal[3], int32_t x, int32_t y)
{
    const ntp_camera *camera = &r->how->camera;
    ntp__axis_terms *across = &r->t->axis[0], *down = &r->t->axis[1];
    double facing = normal[2];
    if (camera->fx > 0)
        facing += normal[1] * ((y - camera->cy) / camera->fy) -
                  normal[0] * ((x - camera->cx) / camera->fx);
    if (!(facing > 0)) {
        facing = 0;
        r->counts->turned_away++;
    }
    across->view[i] = (float) (across->focal * facing);
    down->view[i] = (float) (down->focal * facing);
    across->rise[i] = (float) normal[0];
    down->rise[i] = (float) -normal[1];
    across->after[i] = across->before[i] = down->after[i] = down->before[i] = -1;
    r->t->force[i] = normal[2]; /* until all is read */
}

/* Ties node i to the one before it. */
static void join(ntp__terms *t, int32_t d, int32_t before, int32_t i)
{
    ntp__axis_terms *a = &t->axis[d];
    if (before < 0)
        return;
    a->after[before] = i;
    a->before[i] = before;
    double x = (double) t->axis[0].rise[i] - (double) t->axis[0].rise[before];
    double y = (double) t->axis[1].rise[i] - (double) t->axis[1].rise[before];
    double z = t->force[i] - t->force[before];
    a->even[before] = (float) (x * x + y * y + z * z); /* until all is read */
}

/* The texels of a tile. */
typedef struct tile {
    int32_t left, top, right, bottom;
} tile;

static tile tile_at(int32_t across, int32_t down, int32_t width, int32_t height)
{
    tile at = { across * TILE, down * TILE, (across + 1) * TILE, (down + 1) * TILE };
    at.right = at.right < width ? at.right : width;
    at.bottom = at.bottom < height ? at.bottom : height;
    return at;
}

/* Where the squares of distances of a tile's pairs are; returns how many these are. */
static int32_t find_pairs(float *pairs[2 * TILE * TILE], const ntp__terms *t, const int32_t *node,
                          int32_t width, tile at)
{
    int32_t n = 0;
    for (int32_t y = at.top; y < at.bottom; y++) {
        for (int32_t x = at.left; x < at.right; x++) {
            int32_t i = node[(size_t) y * (size_t) width + (size_t) x];
            for (int32_t d = 0; d < 2; d++) {
                if (i >= 0 && t->axis[d].after[i] >= 0)
                    pairs[n++] = &t->axis[d].even[i];
            }
        }
    }
    return n;
}

/* Adds up the bends of a tile; returns how many pairs it has. */
static int32_t count_bends(double *bends, const ntp__terms *t, const int32_t *node, int32_t width,
                           tile at)
{
    float *pairs[2 * TILE * TILE];
    int32_t n = find_pairs(pairs, t, node, width, at);
    *bends = 0;
    for (int32_t i = 0; i < n; i++) {
        double square = (double) *pairs[i];
        *bends += square / (square + SHARP * SHARP);
    }
    return n;
}

/* From squares of distances to trust. */
static void trust_tile(const ntp__terms *t, const int32_t *node, int32_t width, tile at,
                       double share)
{
    double wide = BEND * (1 + share * share / (MANY * MANY));
    float *pairs[2 * TILE * TILE];
    int32_t n = find_pairs(pairs, t, node, width, at);
    for (int32_t i = 0; i < n; i++)
        *pairs[i] = (float) (1 / (1 + (double) *pairs[i] / (wide * wide)));
}

/* The same for all tiles.  z and pull are not yet in use. */
static void trust_normals(ntp__terms *t, const int32_t *node, int32_t width, int32_t height)
{
    int32_t across = (width + TILE - 1) / TILE, down = (height + TILE - 1) / TILE;
    double *bends = t->z;
    float *pairs = t->axis[0].pull;
    for (int32_t m = 0; m < across * down; m++)
        pairs[m] = (float) count_bends(&bends[m], t, node, width,
                                       tile_at(m % across, m / across, width, height));
    for (int32_t m = 0; m < across * down; m++) {
        double sum = 0, all = 1; /* so that it is never 0 */
        int32_t x0 = m % across, y0 = m / across;
        for (int32_t y = y0 > 0 ? y0 - 1 : 0; y <= y0 + 1 && y < down; y++) {
            for (int32_t x = x0 > 0 ? x0 - 1 : 0; x <= x0 + 1 && x < across; x++) {
                sum += bends[y * across + x];
                all += (double) pairs[y * across + x];
            }
        }
        trust_tile(t, node, width, tile_at(x0, y0, width, height), sum / all);
    }
}

void ntp__terms_read(ntp__terms *t, int32_t *node, const ntp_const_image *src,
                     const ntp_depth_options *how, ntp__term_counts *counts)
{
    ntp__block block;
    reader r = { t, src, how, counts, ntp__max(src->type) };
    bool perspective = how->camera.fx > 0;
    int32_t n = 0;
    t->axis[0].focal = perspective ? how->camera.fx : 1;
    t->axis[1].focal = perspective ? how->camera.fy : 1;
    for (int32_t y = 0; y < src->height; y++) {
        int32_t *row = node + (size_t) y * (size_t) src->width;
        for (int32_t x = 0; x < src->width; x++) {
            double normal[3];
            int32_t left = src->width - x < NTP__BLOCK ? src->width - x : NTP__BLOCK;
            if (x % NTP__BLOCK == 0)
                ntp__unpack(&block, src, x, y, left);
            row[x] = -1;
            if ((how->mask != NULL && masked_out(how->mask, x, y)) ||
                !read_normal(normal, &block, x % NTP__BLOCK, &r)) {
                counts->holes++;
                continue;
            }
            row[x] = n;
            add_node(&r, n, normal, x, y);
            join(t, 0, x > 0 ? row[x - 1] : -1, n);
            join(t, 1, y > 0 ? row[x - src->width] : -1, n);
            n++;
        }
    }
    t->nodes = n;
    trust_normals(t, node, src->width, src->height);
}

/* --------------------------------------------------------------------- shares and springs */

void ntp__terms_even(ntp__terms *t)
{
    for (int32_t d = 0; d < 2; d++) {
        for (int32_t i = 0; i < t->nodes; i++) {
            t->axis[d].share[i] = 0.5F;
            t->axis[d].trust[i] = 1;
        }
    }
}

static double slope(const ntp__axis_terms *a, int32_t i, double grazing)
{
    double view = (double) a->view[i], least = grazing * a->focal;
    return (double) a->rise[i] / (view > least ? view : least);
}

/* How far depth is off both slopes of node i and j after it: by nothing if it is between the two. */
static double off_slopes(const ntp__axis_terms *a, const double *z, int32_t i, int32_t j)
{
    double step = z[j] - z[i], one = slope(a, i, GRAZING), other = slope(a, j, GRAZING);
    double low = one < other ? one : other, high = one < other ? other : one;
    double view = (double) (a->view[i] < a->view[j] ? a->view[i] : a->view[j]);
    double off = step > high ? step - high : step < low ? low - step : 0;
    return off * view * view / a->focal;
}

void ntp__terms_trust(ntp__terms *t, double far)
{
    for (int32_t d = 0; d < 2; d++) {
        ntp__axis_terms *a = &t->axis[d];
        for (int32_t i = 0; i < t->nodes; i++) {
            if (a->after[i] < 0)
                continue;
            double off = far > 0 ? off_slopes(a, t->z, i, a->after[i]) / far : 0;
            a->trust[i] = (float) ((double) a->even[i] / (1 + off * off));
        }
    }
}

/* 1 / (1 + 4 v) from 1 / (1 + v). */
void ntp__terms_sharpen(ntp__terms *t)
{
    for (int32_t d = 0; d < 2; d++) {
        for (int32_t i = 0; i < t->nodes; i++)
            t->axis[d].even[i] /= 4 - 3 * t->axis[d].even[i];
    }
}

/* The shares of nodes from..from + count - 1 along one axis. */
static void share_run(ntp__axis_terms *a, const double *z, double k, int32_t from, int32_t count)
{
    float power[RUN];
    for (int32_t m = 0; m < count; m++) {
        int32_t i = from + m, next = a->after[i], last = a->before[i];
        double view = (double) a->view[i];
        double after = next >= 0 ? view * (z[next] - z[i]) : 0;
        double before = last >= 0 ? view * (z[i] - z[last]) : 0;
        power[m] = (float) (k * (after * after - before * before));
    }
    for (int32_t m = 0; m < count; m++)
        a->share[from + m] = 1 / (1 + ntp__exp_float(power[m]));
}

void ntp__terms_share(ntp__terms *t, double k)
{
    for (int32_t i = 0; i < t->nodes; i += RUN) {
        int32_t count = t->nodes - i < RUN ? t->nodes - i : RUN;
        share_run(&t->axis[0], t->z, k, i, count);
        share_run(&t->axis[1], t->z, k, i, count);
    }
}

/* How much the equations of both its ends weigh in the pair of i and j after it, but for trust. */
static double weight(const ntp__axis_terms *a, int32_t i, int32_t j)
{
    double view = (double) a->view[i], other = (double) a->view[j];
    return (double) a->share[i] * view * view + (1 - (double) a->share[j]) * other * other;
}

/* By how much depth changes from i to j after it: the mean of both slopes.  Where a surface is folded
 * between them, it has one slope up to the fold and the other beyond.  With its own slope in each
 * equation the gentler one wins, as it weighs more, and all folds and bends are flattened. */
static double change(const ntp__axis_terms *a, int32_t i, int32_t j)
{
    return (slope(a, i, STEEP) + slope(a, j, STEEP)) / 2;
}

/* The force of the same pair if each equation has its own slope. */
static double own_pull(const ntp__axis_terms *a, int32_t i, int32_t j)
{
    return (double) a->share[i] * (double) a->view[i] * (double) a->rise[i] +
           (1 - (double) a->share[j]) * (double) a->view[j] * (double) a->rise[j];
}

static void set_springs(ntp__axis_terms *a, int32_t nodes, bool own)
{
    double least = LEAST * a->focal * a->focal;
    for (int32_t i = 0; i < nodes; i++) {
        int32_t j = a->after[i];
        if (j < 0)
            continue;
        double trust = (double) a->trust[i], stiff = trust * weight(a, i, j);
        a->stiff[i] = (float) (stiff + least);
        a->pull[i] = (float) (own ? trust * own_pull(a, i, j) : stiff * change(a, i, j));
    }
}

void ntp__terms_springs(ntp__terms *t, ntp__graph *graph)
{
    const ntp__axis_terms *across = &t->axis[0], *down = &t->axis[1];
    set_springs(&t->axis[0], t->nodes, t->own);
    set_springs(&t->axis[1], t->nodes, t->own);
    int32_t count = 0;
    for (int32_t i = 0; i < t->nodes; i++) {
        const ntp__axis_terms *axis[4] = { down, across, across, down };
        const int32_t to[4] = { down->before[i], across->before[i], across->after[i],
                                down->after[i] };
        double force = 0;
        graph->first[i] = count;
        for (int32_t e = 0; e < 4; e++) {
            if (to[e] < 0)
                continue;
            int32_t owner = e < 2 ? to[e] : i;
            force += (double) (e < 2 ? axis[e]->pull[owner] : -axis[e]->pull[owner]);
            graph->spring[count++] = (ntp__spring) { to[e], axis[e]->stiff[owner] };
        }
        t->force[i] = force;
    }
    graph->first[t->nodes] = count;
    graph->nodes = t->nodes;
}

double ntp__terms_energy(const ntp__terms *t)
{
    double sum = 0;
    for (int32_t d = 0; d < 2; d++) {
        const ntp__axis_terms *a = &t->axis[d];
        for (int32_t i = 0; i < t->nodes; i++) {
            int32_t j = a->after[i];
            if (j < 0)
                continue;
            double left = t->z[j] - t->z[i] - change(a, i, j);
            sum += weight(a, i, j) * left * left;
        }
    }
    return sum;
}

/* What is left of the equations of the spring from i to j, as a force.  The tie of LEAST is an equation
 * too: that both are as deep.  Where a piece hangs by nothing else, its depth is a guess. */
static double left_over(const ntp__axis_terms *a, const double *z, int32_t i, int32_t j)
{
    double difference = z[j] - z[i], mine = (double) a->view[i], other = (double) a->view[j];
    double left = mine * difference - (double) a->rise[i];
    double right = other * difference - (double) a->rise[j];
    double tie = a->focal * a->focal * difference;
    return sqrt(LEAST * tie * tie +
                (double) a->trust[i] *
                    ((double) a->share[i] * left * left * mine * mine +
                     (1 - (double) a->share[j]) * right * right * other * other));
}

void ntp__terms_doubt(const ntp__terms *t, double *force, uint64_t *chance)
{
    for (int32_t i = 0; i < t->nodes; i++)
        force[i] = 0;
    for (int32_t d = 0; d < 2; d++) {
        const ntp__axis_terms *a = &t->axis[d];
        for (int32_t i = 0; i < t->nodes; i++) {
            int32_t j = a->after[i];
            if (j < 0)
                continue;
            *chance = *chance * 6364136223846793005U + 1442695040888963407U;
            double left = left_over(a, t->z, i, j);
            left = *chance >> 63 != 0 ? left : -left;
            force[i] -= left;
            force[j] += left;
        }
    }
}
