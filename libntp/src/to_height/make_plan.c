/* SPDX-License-Identifier: MIT */
/*
 * make_plan.c - turns the options of the caller into a plan: checks, defaults, the solver
 */
#include "to_height/make_plan.h"

#include "base/finite.h"
#include "base/view.h"
#include "to_height/direct/direct.h"

#include <string.h>

static const double default_tolerance = 1e-6;
enum { DEFAULT_ITERATIONS = 1000 };

/* ------------------------------------------------------------------------------- checks */

static bool in_range(int value, int last)
{
    return value >= 0 && value <= last;
}

static bool enums_good(const ntp_height_options *how)
{
    return in_range((int) how->method, NTP_HEIGHT_WEIGHTED) &&
           in_range((int) how->decode, NTP_DECODE_SNORM) && in_range((int) how->z, NTP_Z_DERIVED) &&
           in_range((int) how->border_x, NTP_BORDER_REPEAT_SLOPE) &&
           in_range((int) how->border_y, NTP_BORDER_REPEAT_SLOPE) &&
           in_range((int) how->kernel, NTP_KERNEL_BAKED) &&
           in_range((int) how->residual_scope, NTP_RESIDUAL_INSIDE_Y) &&
           in_range((int) how->prior, NTP_PRIOR_ROUGHNESS) && how->touch_unused <= NTP_UNUSED_ALL;
}

static double step_of(double d)
{
    return d == 0 ? 1 : d;
}

/* Squares of what lies within these limits, and their products with slopes, stay finite. */
static bool spacing_good(double dx, double dy)
{
    static const double most = 0x1p100, most_ratio = 0x1p50;
    return dx > 1 / most && dx < most && dy > 1 / most && dy < most && dy / dx > 1 / most_ratio &&
           dy / dx < most_ratio;
}

static bool numbers_good(const ntp_height_options *how)
{
    for (int32_t i = 0; how->use_seeds && i < 4; i++) {
        if (!ntp__is_finite(how->seeds[i]))
            return false;
    }
    return in_range(how->refine, NTP_MAX_ITERATIONS) &&
           in_range(how->max_iterations, NTP_MAX_ITERATIONS) && how->tolerance >= 0 &&
           how->tolerance < 1 && spacing_good(step_of(how->dx), step_of(how->dy));
}

/* ----------------------------------------------------------------------------- the plan */

static void fill_in(ntp__height_plan *plan, const ntp_height_options *how)
{
    plan->kernel = how->kernel;
    plan->border_x = how->border_x;
    plan->border_y = how->border_y;
    plan->wrap_x = how->border_x == NTP_BORDER_WRAP;
    plan->wrap_y = how->border_y == NTP_BORDER_WRAP;
    plan->dx = step_of(how->dx);
    plan->dy = step_of(how->dy);
    plan->prior = how->prior;
    plan->decode = how->decode;
    plan->neutral = 1;
    plan->z = how->z;
    plan->touch_unused = how->touch_unused;
    plan->mask = how->mask;
    plan->tolerance = how->tolerance > 0 ? how->tolerance : default_tolerance;
    plan->max_iterations = how->max_iterations > 0 ? how->max_iterations : DEFAULT_ITERATIONS;
    plan->use_seeds = how->use_seeds != 0;
    plan->equalize = how->equalize != 0;
    memcpy(plan->seeds, how->seeds, sizeof plan->seeds);
    plan->residual_scope = how->residual_scope;
    plan->detrend = how->detrend != 0;
    plan->refine = how->refine;
}

/* Chooses the solver, and the name of the method; false: the borders do not fit the method. */
static bool choose_solver(ntp__height_plan *plan, ntp_height_method asked)
{
    bool all_wrap = plan->wrap_x && plan->wrap_y, none_wraps = !plan->wrap_x && !plan->wrap_y;
    if (asked == NTP_HEIGHT_AUTO && plan->mask != NULL)
        asked = NTP_HEIGHT_WEIGHTED;
    plan->solver = asked == NTP_HEIGHT_TELESCOPING ? NTP__SOLVER_TELESCOPING
                   : asked == NTP_HEIGHT_WEIGHTED  ? NTP__SOLVER_WEIGHTED
                                                   : NTP__SOLVER_DIRECT;
    plan->method = asked;
    if (asked == NTP_HEIGHT_AUTO)
        /* If only one axis wraps, the method bears the name for free borders. */
        plan->method = all_wrap ? NTP_HEIGHT_FRANKOT_CHELLAPPA : NTP_HEIGHT_POISSON_DCT;
    return !(asked == NTP_HEIGHT_FRANKOT_CHELLAPPA && !all_wrap) &&
           !(asked == NTP_HEIGHT_POISSON_DCT && !none_wraps);
}

/* Do the options belong to this solver? */
static ntp_status check_extras(const ntp__height_plan *plan)
{
    bool weighted = plan->solver == NTP__SOLVER_WEIGHTED;
    bool telescoping = plan->solver == NTP__SOLVER_TELESCOPING;
    bool refined = plan->refine > 0;
    if ((plan->use_seeds && !telescoping) || (plan->mask != NULL && !weighted) ||
        (refined && (telescoping || (weighted && plan->detrend))))
        return NTP_ERR_ARGUMENT;
    return NTP_OK;
}

ntp_status ntp__make_plan(ntp__height_plan *plan, const ntp_height_options *how, int32_t width,
                          int32_t height)
{
    static const ntp_height_options defaults;
    how = how != NULL ? how : &defaults;
    memset(plan, 0, sizeof *plan);
    plan->width = width;
    plan->height = height;
    if (!enums_good(how) || !numbers_good(how))
        return NTP_ERR_ARGUMENT;
    fill_in(plan, how);
    bool fits = choose_solver(plan, how->method);
    NTP__TRY(check_extras(plan));
    if (!fits)
        return NTP_ERR_ARGUMENT;
    return plan->solver == NTP__SOLVER_WEIGHTED ? NTP_OK : ntp__direct_check(plan);
}

ntp_status ntp__make_rows_plan(ntp__height_plan *plan, const ntp_height_options *how, int32_t width,
                               int32_t height)
{
    if (how != NULL &&
        (how->method == NTP_HEIGHT_TELESCOPING || how->method == NTP_HEIGHT_WEIGHTED ||
         how->mask != NULL || how->residual_scope != NTP_RESIDUAL_NONE || how->detrend != 0 ||
         how->refine != 0))
        return NTP_ERR_FORMAT;
    NTP__TRY(ntp__make_plan(plan, how, width, height));
    if (plan->decode == NTP_DECODE_AUTO)
        plan->decode = NTP_DECODE_UNORM;
    if (plan->z == NTP_Z_AUTO)
        plan->z = NTP_Z_STORED;
    return NTP_OK;
}
