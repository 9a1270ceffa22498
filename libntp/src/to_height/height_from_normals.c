/* SPDX-License-Identifier: MIT */
/*
 * height_from_normals.c - heights from normals: from the checks to the result
 *
 * This room makes a heightfield whose slopes are as near as possible to those of a texture.  This
 * file runs all steps.  The steps themselves are elsewhere:
 *   make_plan.c          checks the options once, and chooses the solver
 *   decode.c             finds out what the levels mean, and whether blue is to be trusted
 *   direct/direct.h      the usual solver: transforms and recursion, no iteration; telescoping
 *   weighted/weighted.h  the solver for masks, holes and steep textures: iteration
 *   shared/slopes.h      what both solvers read: slopes, their operator, transforms, plans
 *   round_trip.c         compares the normals of the heights with the texture: refinement, residual
 *   height_from_rows.c   runs the direct solver row by row, for pictures larger than memory
 * A solver makes heights of mean 0.  Refinement, detrending and measurement come after it, here.
 */
#include "base/finite.h"
#include "to_height/decode.h"
#include "to_height/direct/direct.h"
#include "to_height/make_plan.h"
#include "to_height/round_trip.h"
#include "to_height/weighted/weighted.h"

#include <math.h>
#include <string.h>

/* ------------------------------------------------------------------------------- checks */

static ntp_status check_views(const ntp_image *dst, const ntp_const_image *src)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image seen = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_view(&seen));
    if (dst->encoding != NTP_ENCODING_HEIGHT || dst->type != NTP_TYPE_F32 || dst->channels != 1)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&seen, src) || src->ring_rows != 0 || dst->ring_rows != 0 ||
        dst->pixel_stride != (ptrdiff_t) sizeof(float))
        return NTP_ERR_SHAPE;
    return NTP_OK;
}

static ntp_status check_mask(const ntp_const_image *mask, const ntp_const_image *src)
{
    if (mask == NULL)
        return NTP_OK;
    NTP__TRY(ntp__check_view(mask));
    if (mask->encoding != NTP_ENCODING_HEIGHT || mask->type == NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    return ntp__same_size(mask, src) && mask->ring_rows == 0 ? NTP_OK : NTP_ERR_SHAPE;
}

/* ------------------------------------------------------------------------ working memory */

/* One reconstruction, from the plan to the result. */
typedef struct run {
    ntp__height_plan plan;
    const ntp_image *dst;
    const ntp_hooks *hooks;
    ntp__slopes slopes;
    ntp__crew crew;
    ntp__round_trip round_trip;
    double *heights;     /* packed; for refine */
    float *right, *down; /* the same */
    void *rest;          /* the memory of the solver */
    double from, to;     /* the solver reports progress between these shares of the whole work */
    ntp_height_result result;
} run;

/* With memory->base NULL it only measures. */
static void lay_out(run *t, ntp__scratch *memory)
{
    const ntp__height_plan *plan = &t->plan;
    size_t texels = (size_t) plan->width * (size_t) plan->height;
    int32_t parts = t->crew.parts;
    if (plan->residual_scope != NTP_RESIDUAL_NONE || plan->refine > 0)
        ntp__round_trip_init(&t->round_trip, &t->slopes, plan, t->crew, memory);
    if (plan->refine > 0) {
        t->heights = ntp__take(memory, texels * sizeof *t->heights);
        t->right = ntp__take(memory, texels * sizeof *t->right);
        t->down = ntp__take(memory, texels * sizeof *t->down);
    }
    size_t rest = plan->solver == NTP__SOLVER_WEIGHTED      ? ntp__weighted_scratch(plan, parts)
                  : plan->solver == NTP__SOLVER_TELESCOPING ? ntp__telescope_scratch(plan)
                                                            : ntp__direct_scratch(plan, parts);
    t->rest = ntp__take(memory, rest);
}

size_t ntp_height_scratch_size(const ntp_height_options *how, int32_t width, int32_t height,
                               int32_t parts)
{
    run t;
    ntp__scratch memory = { NULL, 0 };
    memset(&t, 0, sizeof t);
    if (width < 1 || height < 1 || width > NTP_MAX_SIDE || height > NTP_MAX_SIDE || parts < 0 ||
        parts > NTP_MAX_PARTS || ntp__make_plan(&t.plan, how, width, height) != NTP_OK)
        return 0;
    t.crew.parts = parts > 0 ? parts : 1;
    lay_out(&t, &memory);
    return memory.used;
}

/* ------------------------------------------------------------------------------- solving */

static int32_t report(void *user, double share)
{
    const run *t = user;
    return t->hooks->progress(t->hooks->user, t->from + (t->to - t->from) * share);
}

static void share_out(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    const run *t = user;
    t->hooks->parallel_for(t->hooks->user, count, task, work);
}

static const double coarse_tolerance = 1e-3; /* for a round of refinement */

/* dst = heights for these slopes. */
static ntp_status solve(run *t, const ntp__slopes *slopes)
{
    ntp__slope_counts counts = { 0, 0, 0, 0, { 0, 0 } };
    ntp_hooks hooks = { t, NULL, NULL, t->crew.parts };
    if (t->hooks != NULL && t->hooks->progress != NULL)
        hooks.progress = report;
    if (t->hooks != NULL && t->hooks->parallel_for != NULL)
        hooks.parallel_for = share_out;
    if (t->plan.solver == NTP__SOLVER_WEIGHTED) {
        /* Rounds of refinement use equal weights, and a few digits are enough for them. */
        ntp__height_plan plan = t->plan;
        bool again = slopes != &t->slopes;
        plan.tolerance = again ? coarse_tolerance : plan.tolerance;
        return ntp__weighted_solve(t->dst, slopes, again, &plan, t->rest, &hooks, &t->result);
    }
    if (t->plan.solver == NTP__SOLVER_TELESCOPING) {
        if (hooks.progress != NULL && hooks.progress(t, 0) != 0)
            return NTP_ERR_CANCELLED;
        ntp__telescope(t->dst, slopes, &t->plan, t->rest, &counts);
    } else {
        NTP__TRY(ntp__direct_solve(t->dst, slopes, &t->plan, t->rest, &hooks, &counts));
    }
    if (slopes == &t->slopes) {
        t->result.unused = counts.unused;
        t->result.not_finite = counts.not_finite;
        t->result.consistency = counts.consistency;
        t->result.consistency_max = counts.consistency_max;
        t->result.min = (double) counts.range[0];
        t->result.max = (double) counts.range[1];
    }
    return NTP_OK;
}

/* heights += factor * dst, or = dst */
static void gather(run *t, double factor, bool add)
{
    for (int32_t y = 0; y < t->plan.height; y++) {
        const float *row = ntp__at_mut(t->dst, 0, y);
        double *to = t->heights + (size_t) y * (size_t) t->plan.width;
        for (int32_t x = 0; x < t->plan.width; x++)
            to[x] = add ? to[x] + factor * (double) row[x] : (double) row[x];
    }
}

/* dst = heights, rounded to float; heights become the rounded ones.  NaN is 0 in dst and stays in
 * heights. */
static void put_back(run *t)
{
    for (int32_t y = 0; y < t->plan.height; y++) {
        float *row = ntp__at_mut(t->dst, 0, y);
        double *from = t->heights + (size_t) y * (size_t) t->plan.width;
        for (int32_t x = 0; x < t->plan.width; x++) {
            bool hole = ntp__is_nan(from[x]);
            row[x] = hole ? 0 : (float) from[x];
            from[x] = hole ? from[x] : (double) row[x];
        }
    }
}

static void scale_planes(run *t, double scale)
{
    size_t texels = (size_t) t->plan.width * (size_t) t->plan.height;
    for (size_t i = 0; i < texels; i++) {
        t->right[i] = (float) (scale * (double) t->right[i]);
        t->down[i] = (float) (scale * (double) t->down[i]);
    }
}

/*
 * Two projections take turns: onto the slopes that round to the texture, and onto the slopes that
 * belong to heights.  The second one is least squares.  Its solution is linear in the slopes, so it
 * is applied to the difference between the projected slopes and those of the heights.  The heights
 * move by more than the result (relaxation), which takes fewer rounds.  The difference is scaled to
 * the size of slopes, so that the prior of the solver does not take it for noise.
 */
static ntp_status refine(run *t)
{
    static const double relaxation = 1.7;
    ntp__plane heights = { t->heights, NULL, t->plan.width };
    int32_t rounds = t->plan.refine;
    ntp_status status = NTP_OK;
    bool holes = t->plan.solver == NTP__SOLVER_WEIGHTED;
    gather(t, 1, false);
    if (holes)
        ntp__round_trip_mark_holes(&t->round_trip, t->heights, NULL);
    for (int32_t i = 0; i < rounds && status == NTP_OK; i++) {
        double mean_square;
        ntp__slopes way = t->slopes;
        if (ntp__round_trip_project(&t->round_trip, &heights, t->right, t->down, &mean_square) == 0)
            break;
        double scale = mean_square > 0 ? 1 / sqrt(mean_square) : 1;
        scale_planes(t, scale);
        way.right = t->right;
        way.down = t->down;
        t->from = (i + 1) / (rounds + 1.0);
        t->to = (i + 2) / (rounds + 1.0);
        status = solve(t, &way);
        if (status != NTP_OK && status != NTP_ERR_NOT_CONVERGED)
            return status;
        gather(t, relaxation / scale, true);
        t->result.rounds++;
    }
    put_back(t);
    t->result.refine_left = ntp__round_trip_project(&t->round_trip, &heights, NULL, NULL, NULL);
    return status;
}

/* ------------------------------------------------------------------------------- result */

/* Subtracts the best plane from heights of mean 0, along the axes that do not wrap.  On a rectangle
 * the columns and the rows are orthogonal, so each slope is fitted by itself. */
static void detrend(const ntp_image *dst, const ntp__height_plan *plan, ntp_height_result *result)
{
    double along = 0, down = 0, w = dst->width, h = dst->height;
    double middle_x = (w - 1) / 2, middle_y = (h - 1) / 2;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        double sum = 0, moment = 0;
        for (int32_t x = 0; x < dst->width; x++) {
            sum += (double) row[x];
            moment += (double) row[x] * (x - middle_x);
        }
        along += moment;
        down += sum * (y - middle_y);
    }
    /* The sum of (i - middle)^2 over n places is n (n^2 - 1)/12. */
    if (!plan->wrap_x && dst->width > 1)
        result->trend_x = 12 * along / (h * w * (w * w - 1));
    if (!plan->wrap_y && dst->height > 1)
        result->trend_y = 12 * down / (w * h * (h * h - 1));
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        double shift = (y - middle_y) * result->trend_y;
        for (int32_t x = 0; x < dst->width; x++)
            row[x] = (float) ((double) row[x] - shift - (x - middle_x) * result->trend_x);
    }
}

static void find_range(const ntp_image *dst, ntp_height_result *result)
{
    float min = *(const float *) dst->data, max = min;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            min = row[x] < min ? row[x] : min;
            max = row[x] > max ? row[x] : max;
        }
    }
    result->min = min;
    result->max = max;
}

/* ------------------------------------------------------------------------------- public */

static void measure(run *t)
{
    bool holes = t->plan.solver == NTP__SOLVER_WEIGHTED;
    ntp__plane heights = { NULL, t->dst->data, t->dst->row_stride / (ptrdiff_t) sizeof(float) };
    if (holes)
        ntp__round_trip_mark_holes(&t->round_trip, NULL, t->dst);
    t->result.residual = ntp__round_trip_residual(&t->round_trip, &heights);
    for (int32_t y = 0; holes && y < t->plan.height; y++) {
        float *row = ntp__at_mut(t->dst, 0, y);
        for (int32_t x = 0; x < t->plan.width; x++)
            row[x] = ntp__is_nan((double) row[x]) ? 0 : row[x];
    }
}

static ntp_status work(run *t)
{
    bool weighted = t->plan.solver == NTP__SOLVER_WEIGHTED;
    t->to = 1 / (t->plan.refine + 1.0);
    ntp_status status = solve(t, &t->slopes);
    if (status == NTP_OK && t->plan.refine > 0)
        status = refine(t);
    if (status != NTP_OK && status != NTP_ERR_NOT_CONVERGED)
        return status;
    if (t->plan.residual_scope != NTP_RESIDUAL_NONE)
        measure(t);
    if (t->plan.detrend && !weighted)
        detrend(t->dst, &t->plan, &t->result);
    /* The direct solver has found the range while it wrote. */
    if (weighted || t->plan.solver == NTP__SOLVER_TELESCOPING || t->plan.refine > 0 ||
        t->plan.detrend)
        find_range(t->dst, &t->result);
    return status;
}

ntp_status ntp_height_from_normals(const ntp_image *dst, const ntp_const_image *src,
                                   const ntp_height_options *how, void *scratch,
                                   size_t scratch_size, const ntp_hooks *hooks,
                                   ntp_height_result *result)
{
    run t;
    ntp__scratch memory = { scratch, 0 };
    memset(&t, 0, sizeof t);
    NTP__TRY(check_views(dst, src));
    NTP__TRY(ntp__make_plan(&t.plan, how, src->width, src->height));
    NTP__TRY(check_mask(t.plan.mask, src));
    if (t.plan.refine > 0 && src->type == NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    t.crew = ntp__crew_of(hooks);
    if (t.crew.parts < 1 || t.crew.parts > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 ||
        scratch_size < ntp_height_scratch_size(how, src->width, src->height, t.crew.parts))
        return NTP_ERR_SCRATCH;
    t.dst = dst;
    t.hooks = hooks;
    if (hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, 0) != 0)
        return NTP_ERR_CANCELLED;
    ntp__decode_by_evidence(&t.plan, src);
    ntp__slopes_init(&t.slopes, src, &t.plan);
    lay_out(&t, &memory);
    t.result.islands = 1;
    t.result.residual = -1;
    ntp_status status = work(&t);
    t.result.method = t.plan.method;
    t.result.decode = t.slopes.decode;
    t.result.z = t.slopes.derived ? NTP_Z_DERIVED : NTP_Z_STORED;
    if (result != NULL && (status == NTP_OK || status == NTP_ERR_NOT_CONVERGED))
        *result = t.result;
    return status;
}

const char *ntp_height_method_name(ntp_height_method method)
{
    switch (method) {
    case NTP_HEIGHT_AUTO:
        return "auto";
    case NTP_HEIGHT_TELESCOPING:
        return "telescoping";
    case NTP_HEIGHT_FRANKOT_CHELLAPPA:
        return "frankot-chellappa";
    case NTP_HEIGHT_POISSON_DCT:
        return "poisson-dct";
    case NTP_HEIGHT_WEIGHTED:
        return "weighted";
    }
    return "unknown";
}
