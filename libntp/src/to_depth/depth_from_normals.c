/* SPDX-License-Identifier: MIT */
/*
 * depth_from_normals.c - depth from normals with cliffs and a camera: from checks to the result
 *
 * This room is for normals of objects, as photometric stereo measures them.  It does not assume
 * that a surface hangs together: at each texel it may be smooth to one side only (Cao, Santo, Shi,
 * Okura, Matsushita: Bilateral Normal Integration, ECCV 2022).
 *   terms.h        what the normals say: two one-sided equations an axis at each texel
 *   graph.h        solves them for fixed shares, by multigrid
 *   exponential.h  exp and log without libm
 * This file alternates the two until hardly anything changes, and finds out how sure the depth is.
 */
#include <math.h>
#include <string.h>

#include "base/finite.h"
#include "to_depth/exponential.h"
#include "to_depth/terms.h"

enum {
    ROUNDS = 33,      /* at most, by default: more gain little */
    WARY_ROUNDS = 10, /* until the first part may end */
    FAR_ROUNDS = 24,  /* until it ends at the latest */
    LAST_ROUNDS = 8,  /* of the second part, at least */
    PROBES = 8,       /* of the confidence */
    FRESH_ROUNDS = 6, /* with levels of their own; then levels are kept while they do */
    FRESH_EVERY = 8,
    MOST_ITERATIONS = 60
};
static const double USUAL_K = 2;
static const double FIRST_FAR = 3, NEARER = 0.7943282347242815; /* 0.1^(1/10) */
/* Until depth is about in its place: a sharper one cuts too much. */
static const double NEAR_FAR = 0.3;
static const double LAST_FAR = 0.03, LAST_NEARER = 0.7;
/* The change of the energy in a round, of itself, that ends a part. */
static const double STEADY = 3e-4;
static const double CARRY_ON = 0.75;  /* parts whose ties are weak move on for many rounds */
static const double OTHER_K = 3;      /* times k: how far depth moves then is a part of the doubt */
static const double DOUBT = 5;        /* times it: half of MOST_DOUBT for what is surely loose */
static const double ABOUT_HALF = 0.1; /* of the texels, to both sides of the median */
static const double MOST_DOUBT = 0.5; /* times the spread of all depths */
static const double FIRST_SHARE = 0.01, LATER_SHARE = 0.3; /* of the residual that a solve leaves */
static const double ONLY_SHARE = 1e-6;                     /* the same for plain least squares */

typedef struct work {
    ntp_depth_options how;
    const ntp_const_image *src;
    const ntp_hooks *hooks;
    double from, to; /* progress of the running rounds, as shares of the whole */
    int32_t *node;
    ntp__terms terms;
    ntp__springs springs;
    double *old;          /* depth before the last round */
    double *kept, *doubt; /* for the confidence */
    ntp_depth_result result;
} work;

/* ------------------------------------------------------------------------------- checks */

static ntp_status check_plane(const ntp_const_image *view, const ntp_const_image *src)
{
    NTP__TRY(ntp__check_view(view));
    if (view->encoding != NTP_ENCODING_HEIGHT || view->type != NTP_TYPE_F32 || view->channels != 1)
        return NTP_ERR_FORMAT;
    return ntp__same_size(view, src) && view->ring_rows == 0 ? NTP_OK : NTP_ERR_SHAPE;
}

static ntp_status check_output(const ntp_image *dst, const ntp_const_image *src)
{
    ntp_const_image seen = ntp_image_as_const(dst);
    return check_plane(&seen, src);
}

static ntp_status check_mask(const ntp_const_image *mask, const ntp_const_image *src)
{
    NTP__TRY(ntp__check_view(mask));
    if (mask->encoding != NTP_ENCODING_HEIGHT || mask->type == NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    return ntp__same_size(mask, src) && mask->ring_rows == 0 ? NTP_OK : NTP_ERR_SHAPE;
}

/* Within these ranges springs are no greater than floats. */
static bool is_focal(double f)
{
    return f >= 0x1p-10 && f <= 0x1p20;
}

static bool is_place(double c)
{
    return fabs(c) <= 0x1p20;
}

static bool good_options(const ntp_depth_options *how)
{
    const ntp_camera *camera = &how->camera;
    bool orthographic = camera->fx == 0 && camera->fy == 0;
    return (orthographic || (is_focal(camera->fx) && is_focal(camera->fy))) &&
           is_place(camera->cx) && is_place(camera->cy) &&
           (how->k == 0 || (how->k >= 0x1p-20 && how->k <= 0x1p20)) && how->rounds >= 0 &&
           how->rounds <= NTP_MAX_ITERATIONS &&
           (how->touch_unused & ~(uint32_t) NTP_UNUSED_ALL) == 0;
}

static bool good_size(int32_t width, int32_t height)
{
    return width >= 1 && height >= 1 && width <= NTP_MAX_SIDE && height <= NTP_MAX_SIDE &&
           (int64_t) width * height <= NTP_MAX_DEPTH_TEXELS;
}

/* -------------------------------------------------------------------------------- memory */

/* With memory->base NULL it only measures. */
static void lay_out(work *w, int32_t width, int32_t height, ntp__scratch *memory)
{
    size_t texels = (size_t) width * (size_t) height;
    w->node = ntp__take(memory, texels * sizeof *w->node);
    ntp__terms_init(&w->terms, (int32_t) texels, memory);
    ntp__springs_init(&w->springs, (int32_t) texels, memory);
    w->old = ntp__take(memory, texels * sizeof *w->old);
    w->kept = ntp__take(memory, texels * sizeof *w->kept);
    w->doubt = ntp__take(memory, texels * sizeof *w->doubt);
}

size_t ntp_depth_scratch_size(int32_t width, int32_t height)
{
    work w;
    ntp__scratch memory = { NULL, 0 };
    if (!good_size(width, height))
        return 0;
    memset(&w, 0, sizeof w);
    lay_out(&w, width, height, &memory);
    return memory.used;
}

/* ------------------------------------------------------------------------------- rounds */

static bool go_on(const work *w, double share)
{
    return w->hooks == NULL || w->hooks->progress == NULL ||
           w->hooks->progress(w->hooks->user, w->from + (w->to - w->from) * share) == 0;
}

/* One solution with the shares as they are.  `usual`: iterations when levels were last new. */
static void solve(work *w, int32_t round, double share, int32_t *last, int32_t *usual)
{
    ntp__springs *s = &w->springs;
    ntp__terms_springs(&w->terms, &s->level[0]);
    bool fresh = round < FRESH_ROUNDS || round % FRESH_EVERY == 0 || *last > *usual + 2;
    if (fresh)
        ntp__springs_coarsen(s);
    else
        ntp__springs_keep_levels(s);
    *last = ntp__springs_solve(s, w->terms.z, w->terms.force, share, MOST_ITERATIONS);
    if (fresh)
        *usual = *last;
    w->result.iterations += *last;
}

/* Moves depth on by a part of how far the last round has moved it. */
static void carry_on(const work *w, int32_t round)
{
    double *z = w->terms.z, share = round < 2 ? 0 : CARRY_ON;
    for (int32_t i = 0; i < w->terms.nodes; i++) {
        double now = z[i];
        z[i] = now + share * (now - (round > 0 ? w->old[i] : now));
        w->old[i] = now;
    }
}

static double next_far(double far, bool at_last)
{
    double least = at_last ? LAST_FAR : NEAR_FAR;
    far *= at_last ? LAST_NEARER : NEARER;
    return far > least ? far : least;
}

/* Alternates shares and trust with solutions.  The first shares are even or, with a start, by its
 * depth.  At even shares a jump is spread widely, so at first trust falls only where depth is far
 * off.  In the second part, in which all is about in its place, what is off a little is off. */
static ntp_status run_rounds(work *w, double k, bool started)
{
    int32_t most = w->how.rounds > 0 ? w->how.rounds : ROUNDS, last = 0, usual = 0, least = 1;
    double before = 0, far = started ? LAST_FAR : FIRST_FAR;
    bool at_last = started;
    ntp__terms_even(&w->terms);
    w->terms.own = most == 1;
    w->result.rounds = 0;
    for (int32_t round = 0; round < most; round++) {
        bool first = round == 0;
        if (!go_on(w, round / (round + 8.0)))
            return NTP_ERR_CANCELLED;
        carry_on(w, round);
        if (!first || started)
            ntp__terms_share(&w->terms, k);
        if (most > 1)
            ntp__terms_trust(&w->terms, first && !started ? 0 : far);
        solve(w, round, most == 1 ? ONLY_SHARE : first ? FIRST_SHARE : LATER_SHARE, &last, &usual);
        w->result.rounds = round + 1;
        double energy = ntp__terms_energy(&w->terms), change = energy - before;
        bool steady = (change < 0 ? -change : change) <= STEADY * before;
        if (at_last && steady && round >= least)
            break;
        if (!at_last && ((steady && round >= WARY_ROUNDS) || round >= FAR_ROUNDS)) {
            at_last = true;
            least = round + LAST_ROUNDS;
        }
        far = next_far(far, at_last);
        before = energy;
    }
    return NTP_OK;
}

/* --------------------------------------------------------------------------- confidence */

/* The value below which so large a part of all is, to within 2^-40 of the range; half: the median.  What
 * hangs by little may be anywhere, so a mean says nothing of where most texels are. */
static double middle(const double *a, int32_t n, double part)
{
    double low = n > 0 ? a[0] : 0, high = low;
    for (int32_t i = 0; i < n; i++) {
        low = a[i] < low ? a[i] : low;
        high = a[i] > high ? a[i] : high;
    }
    for (int32_t pass = 0; pass < 40; pass++) {
        double half = (low + high) / 2;
        int32_t below = 0;
        for (int32_t i = 0; i < n; i++)
            below += a[i] < half;
        if (below <= part * n)
            low = half;
        else
            high = half;
    }
    return low;
}

/* What hangs by next to nothing moves by any amount, and how far says nothing: its depth is
 * unknown, but it is a part of the same object.  So doubt approaches a share of the spread of the
 * depths and never passes it, as if depth were known that well beforehand. */
static void limit_doubt(double *doubt, const double *z, int32_t n)
{
    double mean = 0, square = 0;
    for (int32_t i = 0; i < n; i++)
        mean += z[i] / n;
    for (int32_t i = 0; i < n; i++)
        square += (z[i] - mean) * (z[i] - mean) / n;
    square *= MOST_DOUBT * MOST_DOUBT;
    for (int32_t i = 0; i < n; i++) {
        double both = square + doubt[i] * doubt[i];
        doubt[i] = both > 0 ? doubt[i] * sqrt(square / both) : 0;
    }
}

/* doubt = how far depth moves under forces as large as what is left of the equations, with signs
 * by chance, all beside the median.  One iteration a probe: its cycle moves all that hangs together,
 * and more of them rank errors no better. */
static ntp_status find_moves(work *w)
{
    ntp__terms *t = &w->terms;
    int32_t n = t->nodes;
    uint64_t chance = 1;
    memset(w->doubt, 0, (size_t) n * sizeof *w->doubt);
    ntp__terms_springs(t, &w->springs.level[0]);
    ntp__springs_coarsen(&w->springs);
    double *moved = w->old;
    for (int32_t probe = 0; probe < PROBES; probe++) {
        if (!go_on(w, 1))
            return NTP_ERR_CANCELLED;
        ntp__terms_doubt(t, t->force, &chance);
        memset(moved, 0, (size_t) n * sizeof *moved);
        ntp__springs_solve(&w->springs, moved, t->force, 0, 1);
        double shift = middle(moved, n, 0.5);
        for (int32_t i = 0; i < n; i++)
            w->doubt[i] += fabs(moved[i] - shift) / PROBES;
    }
    return NTP_OK;
}

/* Joins that with how far depth is off if it is found again with a greater k, and bends tell cliffs
 * sooner.  That is taken from both sides of the median: where the largest of many loose parts has about
 * half of the texels, chance says whether one shift of the whole fits it or another.  Where both are
 * large, or one is by far, the depth is wrong most often. */
static ntp_status find_doubt(work *w, double k)
{
    ntp__terms *t = &w->terms;
    int32_t n = t->nodes;
    ntp_depth_result result = w->result;
    NTP__TRY(find_moves(w));
    memcpy(w->kept, t->z, (size_t) n * sizeof *w->kept);
    w->from = w->to;
    w->to = 1;
    memset(t->z, 0, (size_t) n * sizeof *t->z);
    ntp__terms_sharpen(t);
    NTP__TRY(run_rounds(w, k * OTHER_K, false));
    w->result = result;
    for (int32_t i = 0; i < n; i++)
        w->old[i] = t->z[i] - w->kept[i];
    double low = middle(w->old, n, 0.5 - ABOUT_HALF), high = middle(w->old, n, 0.5 + ABOUT_HALF);
    for (int32_t i = 0; i < n; i++) {
        double off = (fabs(w->old[i] - low) + fabs(w->old[i] - high)) / 2;
        w->doubt[i] = DOUBT * (w->doubt[i] + off + 2 * sqrt(w->doubt[i] * off));
        t->z[i] = w->kept[i];
    }
    limit_doubt(w->doubt, t->z, n);
    return NTP_OK;
}

/* ------------------------------------------------------------------------------- output */

static int32_t find_root(int32_t *root, int32_t i)
{
    while (root[i] != i) {
        root[i] = root[root[i]];
        i = root[i];
    }
    return i;
}

/* Subtracts its mean from each island. */
static void level_islands(work *w)
{
    const ntp__terms *t = &w->terms;
    int32_t *root = t->axis[0].before; /* which nothing reads any more */
    double *sum = t->force, *count = w->kept;
    for (int32_t i = 0; i < t->nodes; i++)
        root[i] = i;
    for (int32_t d = 0; d < 2; d++) {
        for (int32_t i = 0; i < t->nodes; i++) {
            if (t->axis[d].after[i] < 0)
                continue;
            int32_t a = find_root(root, i), b = find_root(root, t->axis[d].after[i]);
            root[a < b ? b : a] = a < b ? a : b;
        }
    }
    for (int32_t i = 0; i < t->nodes; i++)
        sum[i] = count[i] = 0;
    for (int32_t i = 0; i < t->nodes; i++) {
        int32_t own = find_root(root, i);
        w->result.islands += own == i;
        sum[own] += t->z[i];
        count[own] += 1;
    }
    for (int32_t i = 0; i < t->nodes; i++) {
        int32_t own = find_root(root, i);
        t->z[i] -= sum[own] / count[own];
    }
}

static void write_depth(work *w, const ntp_image *dst)
{
    bool perspective = w->how.camera.fx > 0, any = false;
    for (int32_t y = 0; y < dst->height; y++) {
        for (int32_t x = 0; x < dst->width; x++) {
            int32_t i = w->node[(size_t) y * (size_t) dst->width + (size_t) x];
            float *out = ntp__at_mut(dst, x, y);
            if (i < 0) {
                *out = NAN;
                continue;
            }
            /* Floats hold e^-87 to e^88. */
            double z = w->terms.z[i], most = 87;
            *out = (float) (perspective ? ntp__exp(z > most ? most : z < -most ? -most : z) : z);
            double depth = (double) *out;
            w->result.min = !any || depth < w->result.min ? depth : w->result.min;
            w->result.max = !any || depth > w->result.max ? depth : w->result.max;
            any = true;
        }
    }
}

/* With a camera the doubt is one of the logarithm of the depth, so depth itself moves by so much times
 * the depth. */
static void write_confidence(const work *w, const ntp_image *dst, const ntp_image *depth)
{
    double focal = w->terms.axis[0].focal;
    for (int32_t y = 0; y < dst->height; y++) {
        for (int32_t x = 0; x < dst->width; x++) {
            int32_t i = w->node[(size_t) y * (size_t) dst->width + (size_t) x];
            float *out = ntp__at_mut(dst, x, y), *z = ntp__at_mut(depth, x, y);
            double scale = w->how.camera.fx > 0 ? focal * (double) *z : 1;
            *out = i < 0 ? 0 : (float) (1 / (1 + w->doubt[i] * scale));
        }
    }
}

/* ------------------------------------------------------------------------------- public */

static void read_start(const work *w)
{
    const ntp_const_image *start = w->how.start;
    bool perspective = w->how.camera.fx > 0;
    for (int32_t y = 0; y < start->height; y++) {
        for (int32_t x = 0; x < start->width; x++) {
            int32_t i = w->node[(size_t) y * (size_t) start->width + (size_t) x];
            double v = (double) *(const float *) ntp__at(start, x, y);
            if (i < 0)
                continue;
            bool good = perspective ? v >= 0x1p-126 : true;
            w->terms.z[i] = !good || !ntp__is_finite(v) ? 0 : perspective ? ntp__log(v) : v;
        }
    }
}

static ntp_status check_all(const ntp_image *dst, const ntp_image *confidence,
                            const ntp_const_image *src, const ntp_depth_options *how)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    if (src->ring_rows != 0)
        return NTP_ERR_SHAPE;
    NTP__TRY(check_output(dst, src));
    if (confidence != NULL)
        NTP__TRY(check_output(confidence, src));
    if (how->mask != NULL)
        NTP__TRY(check_mask(how->mask, src));
    if (how->start != NULL)
        NTP__TRY(check_plane(how->start, src));
    if (!good_size(src->width, src->height))
        return NTP_ERR_SHAPE;
    return good_options(how) ? NTP_OK : NTP_ERR_ARGUMENT;
}

ntp_status ntp_depth_from_normals(const ntp_image *dst, const ntp_image *confidence,
                                  const ntp_const_image *src, const ntp_depth_options *how,
                                  void *scratch, size_t scratch_size, const ntp_hooks *hooks,
                                  ntp_depth_result *result)
{
    work w;
    ntp__scratch memory = { scratch, 0 };
    ntp__term_counts counts = { 0, 0, 0 };
    memset(&w, 0, sizeof w);
    if (how != NULL)
        w.how = *how;
    NTP__TRY(check_all(dst, confidence, src, &w.how));
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 ||
        scratch_size < ntp_depth_scratch_size(src->width, src->height))
        return NTP_ERR_SCRATCH;
    w.src = src;
    w.hooks = hooks;
    w.to = confidence != NULL ? 0.5 : 1;
    lay_out(&w, src->width, src->height, &memory);
    ntp__terms_read(&w.terms, w.node, src, &w.how, &counts);
    memset(w.terms.z, 0, (size_t) w.terms.nodes * sizeof *w.terms.z);
    if (w.how.start != NULL)
        read_start(&w);
    double k = w.how.k > 0 ? w.how.k : USUAL_K;
    NTP__TRY(run_rounds(&w, k, w.how.start != NULL));
    if (confidence != NULL)
        NTP__TRY(find_doubt(&w, k));
    level_islands(&w);
    w.result.holes = counts.holes;
    w.result.not_finite = counts.not_finite;
    w.result.turned_away = counts.turned_away;
    write_depth(&w, dst);
    if (confidence != NULL)
        write_confidence(&w, confidence, dst);
    if (result != NULL)
        *result = w.result;
    return NTP_OK;
}
