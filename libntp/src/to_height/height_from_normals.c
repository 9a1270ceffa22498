/* SPDX-License-Identifier: MIT */
/*
 * height_from_normals.c - heights from normals: from the checks to the result
 *
 * This room makes a heightfield whose slopes are as near as possible to those of a texture.  This
 * file runs all steps.  The steps themselves are elsewhere:
 *   make_plan.c          checks the options once, and chooses the solver
 *   decode.c             finds out what the levels mean, and whether blue is to be trusted
 *   evidence.c           asks the texels for that
 *   direct/direct.h      the usual solver: transforms and recursion, no iteration; telescoping
 *   weighted/weighted.h  the solver for masks, holes and steep textures: iteration
 *   shared/slopes.h      what both solvers read: slopes, their operator, transforms, plans
 *   round_trip.c         compares the normals of the heights with the texture: residual, excess
 *   refine.c             changes heights until their normals round to the texture
 *   height_from_rows.c   runs the direct solver row by row, for pictures larger than memory
 * A solver makes heights of mean 0.  Refinement, detrending and measurement come after it, here.
 */
#include "base/finite.h"
#include "to_height/decode.h"
#include "to_height/direct/direct.h"
#include "to_height/make_plan.h"
#include "to_height/refine.h"
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
    const ntp_const_image *src;
    const ntp_hooks *hooks;
    ntp__slopes slopes;
    ntp__crew crew;
    ntp__round_trip round_trip;
    void *rest;              /* the memory of the solver, and then of the refinement */
    bool refined;            /* dst holds heights, whatever happens */
    ntp_height_result *told; /* the caller's, for its progress; or NULL */
    double from, to; /* the solver reports progress between these shares of the whole work */
    ntp_height_result result;
} run;

/* With memory->base NULL it only measures. */
static void lay_out(run *t, ntp__scratch *memory)
{
    const ntp__height_plan *plan = &t->plan;
    int32_t parts = t->crew.parts;
    if (plan->residual_scope != NTP_RESIDUAL_NONE || plan->refine > 0)
        ntp__round_trip_init(&t->round_trip, &t->slopes, plan, t->crew, memory);
    size_t rest = plan->solver == NTP__SOLVER_WEIGHTED      ? ntp__weighted_scratch(plan, parts)
                  : plan->solver == NTP__SOLVER_TELESCOPING ? ntp__telescope_scratch(plan)
                                                            : ntp__direct_scratch(plan, parts);
    size_t after = plan->refine > 0 ? ntp__refine_scratch(plan, parts) : 0;
    t->rest = ntp__take(memory, rest > after ? rest : after);
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
    if (t->refined && t->told != NULL) {
        t->told->rounds = t->result.rounds;
        t->told->refine_left = t->result.refine_left;
    }
    return t->hooks->progress(t->hooks->user, t->from + (t->to - t->from) * share);
}

static void share_out(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    const run *t = user;
    t->hooks->parallel_for(t->hooks->user, count, task, work);
}

/* The caller's hooks; progress goes through `report`. */
static ntp_hooks inner_hooks(run *t)
{
    ntp_hooks hooks = { t, NULL, NULL, t->crew.parts };
    if (t->hooks != NULL && t->hooks->progress != NULL)
        hooks.progress = report;
    if (t->hooks != NULL && t->hooks->parallel_for != NULL)
        hooks.parallel_for = share_out;
    return hooks;
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

/* Are all rows of the texture the same, or, unless `down`, all columns? */
static bool repeats(const ntp_const_image *src, bool down)
{
    size_t texel = (size_t) (src->channels * ntp__sample_size(src->type));
    for (int32_t y = 0; y < src->height; y++) {
        for (int32_t x = 0; x < src->width; x++) {
            if (memcmp(ntp__at(src, x, y), ntp__at(src, down ? x : 0, down ? 0 : y), texel) != 0)
                return false;
        }
    }
    return true;
}

/* Heights of a texture that repeats along an axis do so too, where they wrap.  Transforms leave
 * rounding errors there, and slopes that are a little below 0 round to another level than 0 does. */
static void level_out(run *t)
{
    const ntp__height_plan *plan = &t->plan;
    bool rows = plan->wrap_y && repeats(t->src, true);
    if (!rows && !(plan->wrap_x && repeats(t->src, false)))
        return;
    for (int32_t y = 0; y < plan->height; y++) {
        float *row = ntp__at_mut(t->dst, 0, y);
        const float *first = ntp__at_mut(t->dst, 0, 0);
        for (int32_t x = 0; x < plan->width; x++)
            row[x] = rows ? first[x] : row[0];
    }
    find_range(t->dst, &t->result);
}

static ntp_status solve(run *t)
{
    ntp__slope_counts counts = { 0, 0, 0, 0, { 0, 0 } };
    ntp_hooks hooks = inner_hooks(t);
    t->to = 1 / (t->plan.refine + 1.0);
    if (t->plan.solver == NTP__SOLVER_WEIGHTED)
        return ntp__weighted_solve(t->dst, &t->slopes, &t->plan, t->rest, &hooks, &t->result);
    if (t->plan.solver == NTP__SOLVER_TELESCOPING) {
        if (hooks.progress != NULL && hooks.progress(t, 0) != 0)
            return NTP_ERR_CANCELLED;
        ntp__telescope(t->dst, &t->slopes, &t->plan, t->rest, &counts);
    } else {
        NTP__TRY(ntp__direct_solve(t->dst, &t->slopes, &t->plan, t->rest, &hooks, &counts));
    }
    t->result.unused = counts.unused;
    t->result.not_finite = counts.not_finite;
    t->result.consistency = counts.consistency;
    t->result.consistency_max = counts.consistency_max;
    t->result.min = (double) counts.range[0];
    t->result.max = (double) counts.range[1];
    if (t->plan.solver == NTP__SOLVER_DIRECT)
        level_out(t);
    return NTP_OK;
}

static ntp_status refine(run *t)
{
    ntp_hooks hooks = inner_hooks(t);
    t->from = t->to;
    t->to = 1;
    t->refined = true;
    return ntp__refine(t->dst, &t->round_trip, &t->plan, t->plan.solver == NTP__SOLVER_WEIGHTED,
                       t->rest, &hooks, &t->result);
}

/* ------------------------------------------------------------------------------- result */

/* Adds a plane of mean 0 with these steps from texel to texel. */
static void tilt(const ntp_image *dst, double step_x, double step_y)
{
    double middle_x = (dst->width - 1) / 2.0, middle_y = (dst->height - 1) / 2.0;
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        double shift = (y - middle_y) * step_y;
        for (int32_t x = 0; x < dst->width; x++)
            row[x] = (float) ((double) row[x] + shift + (x - middle_x) * step_x);
    }
}

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
    tilt(dst, -result->trend_x, -result->trend_y);
}

/* Levels flat ground of a damaged texture, whose levels add a constant to all slopes.  That is a
 * plane along the axes that do not wrap; false: there is none. */
static bool level_lean(const run *t)
{
    const ntp__height_plan *plan = &t->plan;
    double sign = t->src->y == NTP_Y_UP ? 1 : -1;
    double x = plan->wrap_x ? 0 : plan->lean[0] * plan->dx;
    double y = plan->wrap_y ? 0 : plan->lean[1] * plan->dy * -sign;
    if (plan->solver != NTP__SOLVER_DIRECT || plan->refine > 0 || plan->detrend ||
        (x == 0 && y == 0))
        return false;
    tilt(t->dst, x, y);
    return true;
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
    ntp_status status = solve(t);
    if (status == NTP_OK && t->plan.refine > 0)
        status = refine(t);
    if (status != NTP_OK && status != NTP_ERR_NOT_CONVERGED && !t->refined)
        return status;
    if (t->plan.residual_scope != NTP_RESIDUAL_NONE)
        measure(t);
    if (t->plan.detrend && !weighted)
        detrend(t->dst, &t->plan, &t->result);
    /* The direct solver has found the range while it wrote. */
    if (level_lean(t) || weighted || t->plan.solver == NTP__SOLVER_TELESCOPING ||
        t->plan.refine > 0 || t->plan.detrend)
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
    t.src = src;
    t.hooks = hooks;
    t.told = result;
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
    if (result != NULL && (status == NTP_OK || status == NTP_ERR_NOT_CONVERGED || t.refined))
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
