/* SPDX-License-Identifier: MIT */
/*
 * height_from_normals.c - normals -> heightfield: checks, the choice of the method, and what comes after
 *
 * A solver (direct/solve.c, weighted/solve.c) makes heights of mean 0.  What else is wanted works on these:
 * the plane is taken out, and the result described.
 */
#include "base/finite.h"
#include "to_height/decode.h"
#include "to_height/direct/direct.h"
#include "to_height/round_trip.h"
#include "to_height/weighted/weighted.h"

#include <math.h>
#include <string.h>

/* ------------------------------------------------------------------------------- checks */

static bool in_range(int value, int last)
{
    return value >= 0 && value <= last;
}

static ntp_status check_seeds(const ntp_height_options *how)
{
    for (int32_t i = 0; how->use_seeds && i < 4; i++) {
        if (!ntp__is_finite(how->seeds[i]))
            return NTP_ERR_ARGUMENT;
    }
    return how->use_seeds && how->method != NTP_HEIGHT_TELESCOPING ? NTP_ERR_ARGUMENT : NTP_OK;
}

/* Makes the defaults explicit. */
static ntp_status resolve(ntp_height_options *resolved, const ntp_height_options *how,
                          int32_t width, int32_t height)
{
    memset(resolved, 0, sizeof *resolved);
    if (how != NULL)
        *resolved = *how;
    how = resolved;
    if (!in_range((int) how->method, NTP_HEIGHT_WEIGHTED) ||
        !in_range((int) how->decode, NTP_DECODE_SNORM) || !in_range((int) how->z, NTP_Z_DERIVED) ||
        !in_range((int) how->border_x, NTP_BORDER_REPEAT_SLOPE) ||
        !in_range((int) how->border_y, NTP_BORDER_REPEAT_SLOPE) ||
        !in_range((int) how->kernel, NTP_KERNEL_BAKED) ||
        !in_range((int) how->residual_scope, NTP_RESIDUAL_INSIDE) ||
        !in_range(how->refine, NTP_MAX_ITERATIONS) ||
        !in_range(how->max_iterations, NTP_MAX_ITERATIONS) || !(how->tolerance >= 0) ||
        !(how->tolerance < 1))
        return NTP_ERR_ARGUMENT;
    if (!(how->dx >= 0) || !ntp__is_finite(how->dx) || !(how->dy >= 0) ||
        !ntp__is_finite(how->dy) || !in_range((int) how->prior, NTP_PRIOR_ROUGHNESS))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(check_seeds(how));
    bool wrap = how->border_x == NTP_BORDER_WRAP && how->border_y == NTP_BORDER_WRAP;
    if (how->method == NTP_HEIGHT_AUTO && how->mask != NULL)
        resolved->method = NTP_HEIGHT_WEIGHTED;
    else if (how->method == NTP_HEIGHT_AUTO && wrap)
        resolved->method = NTP_HEIGHT_FRANKOT_CHELLAPPA;
    else if (how->method == NTP_HEIGHT_AUTO && how->border_x != NTP_BORDER_WRAP &&
             how->border_y != NTP_BORDER_WRAP)
        resolved->method = NTP_HEIGHT_POISSON_DCT;
    if (how->mask != NULL && resolved->method != NTP_HEIGHT_WEIGHTED)
        return NTP_ERR_ARGUMENT;
    bool again = how->refine > 0 && how->detrend && how->method == NTP_HEIGHT_WEIGHTED;
    if (again || (how->refine > 0 && how->method == NTP_HEIGHT_TELESCOPING))
        return NTP_ERR_ARGUMENT;
    if (how->refine > 0 && how->kernel == NTP_KERNEL_BAKED)
        return NTP_ERR_FORMAT;
    /* Where one axis wraps, the solver goes by neither name; it is told "auto". */
    return how->method == NTP_HEIGHT_WEIGHTED ? NTP_OK : ntp__integrate_check(how, width, height);
}

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

/* A reconstruction on its way. */
typedef struct run {
    ntp_height_options how;
    const ntp_image *dst;
    const ntp_hooks *hooks;
    int32_t width, height;
    ntp__slopes slopes;
    ntp__crew crew;
    ntp__rederive rederive;
    double *heights;     /* packed; of refine */
    float *right, *down; /* the same */
    void *rest;          /* of the solver */
    double from, to;     /* shares of the whole work that the solver is to report */
    ntp_height_result result;
} run;

/* Also with memory->base NULL, to measure. */
static void lay_out(run *t, ntp__scratch *memory)
{
    const ntp_height_options *how = &t->how;
    size_t texels = (size_t) t->width * (size_t) t->height;
    if (how->residual_scope != NTP_RESIDUAL_NONE || how->refine > 0)
        ntp__rederive_init(&t->rederive, &t->slopes, how, t->width, t->height, t->crew, memory);
    if (how->refine > 0) {
        t->heights = ntp__take(memory, texels * sizeof *t->heights);
        t->right = ntp__take(memory, texels * sizeof *t->right);
        t->down = ntp__take(memory, texels * sizeof *t->down);
    }
    size_t rest = how->method == NTP_HEIGHT_WEIGHTED
                      ? ntp__weighted_scratch(how, t->width, t->height, t->crew.parts)
                      : ntp__integrate_scratch(how, t->width, t->height, t->crew.parts);
    t->rest = ntp__take(memory, rest);
}

size_t ntp_height_scratch_size(const ntp_height_options *how, int32_t width, int32_t height,
                               int32_t parts)
{
    run t;
    ntp__scratch memory = { NULL, 0 };
    memset(&t, 0, sizeof t);
    if (width < 1 || height < 1 || width > NTP_MAX_SIDE || height > NTP_MAX_SIDE || parts < 0 ||
        parts > NTP_MAX_PARTS || resolve(&t.how, how, width, height) != NTP_OK)
        return 0;
    t.width = width;
    t.height = height;
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

static const double coarse_tolerance = 1e-3; /* of a round of refinement */

/* dst = heights for these slopes. */
static ntp_status solve(run *t, const ntp__slopes *slopes)
{
    ntp__slope_counts counts = { 0, 0, 0, 0, { 0, 0 } };
    ntp_hooks hooks = { t, NULL, NULL, t->crew.parts };
    if (t->hooks != NULL && t->hooks->progress != NULL)
        hooks.progress = report;
    if (t->hooks != NULL && t->hooks->parallel_for != NULL)
        hooks.parallel_for = share_out;
    if (t->how.method == NTP_HEIGHT_WEIGHTED) {
        /* On the way to boxes weights would be in the way, and a few digits are enough. */
        ntp_height_options how = t->how;
        bool again = slopes != &t->slopes;
        how.tolerance = again ? coarse_tolerance : how.tolerance;
        return ntp__weighted_solve(t->dst, slopes, again, &how, t->rest, &hooks, &t->result);
    }
    NTP__TRY(ntp__integrate(t->dst, slopes, &t->how, t->rest, &hooks, &counts));
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
    for (int32_t y = 0; y < t->height; y++) {
        const float *row = ntp__at_mut(t->dst, 0, y);
        double *to = t->heights + (size_t) y * (size_t) t->width;
        for (int32_t x = 0; x < t->width; x++)
            to[x] = add ? to[x] + factor * (double) row[x] : (double) row[x];
    }
}

/* dst = heights, which become what dst holds; 0 for NaN, which stays. */
static void put_back(run *t)
{
    for (int32_t y = 0; y < t->height; y++) {
        float *row = ntp__at_mut(t->dst, 0, y);
        double *from = t->heights + (size_t) y * (size_t) t->width;
        for (int32_t x = 0; x < t->width; x++) {
            bool hole = ntp__is_nan(from[x]);
            row[x] = hole ? 0 : (float) from[x];
            from[x] = hole ? from[x] : (double) row[x];
        }
    }
}

static void scale_planes(run *t, double scale)
{
    size_t texels = (size_t) t->width * (size_t) t->height;
    for (size_t i = 0; i < texels; i++) {
        t->right[i] = (float) (scale * (double) t->right[i]);
        t->down[i] = (float) (scale * (double) t->down[i]);
    }
}

/*
 * Projections onto convex sets, in turn: the slopes that round to the texture, and those that belong
 * to heights.  The second is least squares; a solution is linear in the slopes, so what is
 * solved for is the way from these heights to the projected slopes, and some more of it is gone.
 * It is scaled as slopes are, so that the prior of the solver does not take it for noise.
 */
static ntp_status refine(run *t)
{
    static const double relaxation = 1.7;
    ntp__plane heights = { t->heights, NULL, t->width };
    int32_t rounds = t->how.refine;
    ntp_status status = NTP_OK;
    bool holes = t->how.method == NTP_HEIGHT_WEIGHTED;
    gather(t, 1, false);
    if (holes)
        ntp__rederive_mark_holes(&t->rederive, t->heights, NULL);
    for (int32_t i = 0; i < rounds && status == NTP_OK; i++) {
        double mean_square;
        ntp__slopes way = t->slopes;
        if (ntp__rederive_project(&t->rederive, &heights, t->right, t->down, &mean_square) == 0)
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
    t->result.refine_left = ntp__rederive_project(&t->rederive, &heights, NULL, NULL, NULL);
    return status;
}

/* ------------------------------------------------------------------------------- result */

/* Takes the best plane out of heights of mean 0, along the axes that do not wrap.  The columns, and
 * the rows, of a rectangle are orthogonal: two fits, each of one slope. */
static void detrend(const ntp_image *dst, const ntp_height_options *how, ntp_height_result *result)
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
    if (how->border_x != NTP_BORDER_WRAP && dst->width > 1)
        result->trend_x = 12 * along / (h * w * (w * w - 1));
    if (how->border_y != NTP_BORDER_WRAP && dst->height > 1)
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
    bool holes = t->how.method == NTP_HEIGHT_WEIGHTED;
    ntp__plane heights = { NULL, t->dst->data, t->dst->row_stride / (ptrdiff_t) sizeof(float) };
    if (holes)
        ntp__rederive_mark_holes(&t->rederive, NULL, t->dst);
    t->result.residual = ntp__rederive_residual(&t->rederive, &heights);
    for (int32_t y = 0; holes && y < t->height; y++) {
        float *row = ntp__at_mut(t->dst, 0, y);
        for (int32_t x = 0; x < t->width; x++)
            row[x] = ntp__is_nan((double) row[x]) ? 0 : row[x];
    }
}

static ntp_status work(run *t)
{
    bool weighted = t->how.method == NTP_HEIGHT_WEIGHTED;
    t->to = 1 / (t->how.refine + 1.0);
    ntp_status status = solve(t, &t->slopes);
    if (status == NTP_OK && t->how.refine > 0)
        status = refine(t);
    if (status != NTP_OK && status != NTP_ERR_NOT_CONVERGED)
        return status;
    if (t->how.residual_scope != NTP_RESIDUAL_NONE)
        measure(t);
    if (t->how.detrend && !weighted)
        detrend(t->dst, &t->how, &t->result);
    /* The direct solver has found the range as it wrote. */
    if (weighted || t->how.method == NTP_HEIGHT_TELESCOPING || t->how.refine > 0 || t->how.detrend)
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
    NTP__TRY(resolve(&t.how, how, src->width, src->height));
    NTP__TRY(check_mask(t.how.mask, src));
    if (t.how.refine > 0 && src->type == NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    t.crew = ntp__crew_of(hooks);
    if (t.crew.parts < 1 || t.crew.parts > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 ||
        scratch_size < ntp_height_scratch_size(how, src->width, src->height, t.crew.parts))
        return NTP_ERR_SCRATCH;
    t.dst = dst;
    t.hooks = hooks;
    t.width = src->width;
    t.height = src->height;
    if (hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, 0) != 0)
        return NTP_ERR_CANCELLED;
    ntp__decode_by_evidence(&t.how, src);
    ntp__slopes_init(&t.slopes, src, &t.how);
    lay_out(&t, &memory);
    t.result.islands = 1;
    t.result.residual = -1;
    ntp_status status = work(&t);
    /* Where one axis wraps the least squares go by the name of the free one. */
    t.result.method = t.how.method != NTP_HEIGHT_AUTO ? t.how.method : NTP_HEIGHT_POISSON_DCT;
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
