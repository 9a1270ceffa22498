/* SPDX-License-Identifier: MIT */
/*
 * refine.c - changes heights until their normals round to the texture
 *
 * Each level stands for a box.  What is minimized is the squared excess of x and y (and of z where
 * blue tells more) beyond their boxes, in levels: it is 0 where the texture comes back.  A round
 * takes one solution by transforms; refine_steps.c has the method.
 */
#include "to_height/refine.h"

#include "base/finite.h"
#include "to_height/refinement.h"
#include "to_height/weighted/weighted.h"

#include <float.h>
#include <string.h>

enum {
    PATIENCE = 8,     /* rounds that help little, after which other texels are tied */
    HELP = 12,        /* to help is to lower the texels that differ by such a part */
    MOST_CHANGES = 12 /* of what is tied */
};

/* The share of each box that has no excess, from some round on.  A small one keeps slopes off the
 * edges of boxes, so that fewer leave them again, and brings heights nearer to the true ones.  But
 * the smaller boxes are, the fewer heights are in all of them: the last stages begin where nothing
 * helps any more. */
typedef struct stage {
    int32_t round, with_blue; /* from this round on; the second where blue has an excess too */
    double share;
} stage;
static const stage stages[] = { { 0, 0, 0.7 },
                                { 4, 4, 0.85 },
                                { 100, 30, 0.96 },
                                { INT32_MAX, INT32_MAX, 0.99 },
                                { INT32_MAX, INT32_MAX, 0.998 } };
enum { STAGES = sizeof stages / sizeof stages[0] };
/* Where floats hardly tell one level from the next. */
static const double least_share = 0.4;

/* Of the first step: a part of the texels has an excess, so the curvature is less than that of all
 * slopes. */
static const double first_length = 2;

/* ------------------------------------------------------------------------ working memory */

/* With memory->base NULL it only measures. */
static void lay_out(ntp__refinement *f, const ntp__height_plan *plan, ntp__scratch *memory)
{
    size_t texels = (size_t) plan->width * (size_t) plan->height, plane = texels * sizeof(float);
    f->plan = plan;
    ntp__inverse_init(&f->inverse, plan, f->crew, memory);
    ntp__ties_init(&f->ties, plan, memory);
    f->heights = ntp__take(memory, texels * sizeof(double));
    f->gradient = ntp__take(memory, texels * sizeof(double));
    f->trial = ntp__take(memory, plane);
    f->before = ntp__take(memory, plane);
    f->right = ntp__take(memory, plane);
    f->down = ntp__take(memory, plane);
    f->way = ntp__take(memory, plane);
    f->scale = ntp__take(memory, plane);
    f->answer = ntp__take(memory, plane);
    f->answer_before = ntp__take(memory, plane);
    for (int32_t i = 0; i < NTP__MEMORY; i++) {
        float *both = ntp__take(memory, 2 * plane);
        f->step[i] = both;
        f->answered[i] = both != NULL ? both + texels : NULL;
    }
    f->work = ntp__take(memory, (size_t) f->crew.parts * (size_t) plan->width * sizeof(double));
    f->sums = ntp__take(memory, (size_t) plan->height * NTP__MEMORY * NTP__DOTS * sizeof(double));
}

size_t ntp__refine_scratch(const ntp__height_plan *plan, int32_t parts)
{
    ntp__refinement f;
    ntp__scratch memory = { NULL, 0 };
    memset(&f, 0, sizeof f);
    f.crew.parts = parts;
    lay_out(&f, plan, &memory);
    return memory.used;
}

/* -------------------------------------------------------------------------------- rounds */

/* What rounding heights to floats can take from half a level. */
static double rounding_of(const ntp__refinement *f, const ntp_image *dst)
{
    double most = 0;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            double size = row[x] < 0 ? -(double) row[x] : (double) row[x];
            most = size > most ? size : most;
        }
    }
    return most * FLT_EPSILON / ntp__least_step(f->plan) * f->trip->slopes->range;
}

static void begin_stage(ntp__refinement *f, int32_t which)
{
    bool last = which + 1 == STAGES; /* most heights lose far less than the highest can */
    double share = stages[which].share, most = 1 - (last ? f->rounding / 4 : f->rounding);
    share = share < most ? share : most;
    f->trip->inside = share > least_share ? share : least_share;
    f->remembered = 0;
    f->stage = which;
}

static void begin(ntp__refinement *f, const ntp_image *dst, bool holes)
{
    double slope =
        2 * ntp__least_step(f->plan) / f->trip->slopes->range; /* about that of a level */
    size_t texels = (size_t) dst->width * (size_t) dst->height;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++)
            f->heights[ntp__refinement_row(f, y) + (size_t) x] = (double) row[x];
    }
    if (holes)
        ntp__round_trip_mark_holes(f->trip, f->heights, NULL);
    ntp__refinement_set_metric(f);
    memset(f->way, 0, texels * sizeof *f->way);
    f->length = first_length * slope * slope;
    f->rounding = rounding_of(f, dst);
    ntp__round_trip_see_blue(f->trip);
    ntp__ties_find(&f->ties, f->trip, f->plan, f->heights);
}

/* Their mean becomes 0, as the scale of the inverse moves it.  With holes it stays: they are NaN. */
static void round_heights(ntp__refinement *f)
{
    size_t texels = (size_t) f->plan->width * (size_t) f->plan->height;
    double sum = 0;
    for (size_t i = 0; i < texels; i++)
        sum += f->heights[i];
    double mean = ntp__is_nan(sum) ? 0 : sum / (double) texels;
    for (size_t i = 0; i < texels; i++)
        f->trial[i] = (float) (f->heights[i] - mean);
}

/* Puts the heights into dst, rounded, if fewer texels differ than with those in it. */
static void keep_better(ntp__refinement *f, const ntp_image *dst, uint64_t *least)
{
    ntp__plane trial = { NULL, f->trial, f->plan->width };
    uint64_t off;
    round_heights(f);
    ntp__round_trip_excess(f->trip, &trial, NULL, NULL, &off);
    if (off >= *least)
        return;
    *least = off;
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        const float *from = f->trial + ntp__refinement_row(f, y);
        for (int32_t x = 0; x < dst->width; x++)
            row[x] = ntp__is_nan((double) from[x]) ? 0 : from[x];
    }
}

/* The mean of each island becomes 0 again, as corrections spread across holes. */
static void level_islands(ntp__refinement *f, const ntp_image *dst, uint64_t *off)
{
    ntp__weighted w = { .plan = f->plan, .width = dst->width, .height = dst->height };
    ntp__plane trial = { NULL, f->trial, dst->width };
    w.right = f->right;
    w.x = f->gradient;
    w.r = (double *) (void *) f->step[0];
    w.d = (double *) (void *) f->step[1];
    w.a = (double *) (void *) f->step[2];
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            size_t at = ntp__refinement_row(f, y) + (size_t) x;
            w.right[at] = ntp__is_nan(f->heights[at]) ? 0 : 1;
            w.x[at] = (double) row[x];
        }
    }
    ntp__islands_level(&w, NULL);
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            size_t at = ntp__refinement_row(f, y) + (size_t) x;
            row[x] = (float) w.x[at];
            f->trial[at] = ntp__is_nan(f->heights[at]) ? (float) f->heights[at] : row[x];
        }
    }
    ntp__round_trip_excess(f->trip, &trial, NULL, NULL, off);
}

static bool is_over(const ntp__refinement *f, int32_t rounds)
{
    const stage *next = &stages[f->stage + 1];
    return f->stage + 1 < STAGES && rounds >= (f->trip->blue ? next->with_blue : next->round);
}

/* What comes next where nothing helps any more; false: nothing does. */
static bool go_on(ntp__refinement *f, int32_t *changes)
{
    if (f->ties.any && ++*changes <= MOST_CHANGES &&
        ntp__ties_change(&f->ties, f->trip, f->plan, f->heights)) {
        ntp__ties_level(&f->ties, f->heights);
        begin_stage(f, f->stage);
    } else if (f->stage + 1 < STAGES) {
        begin_stage(f, f->stage + 1);
    } else if (f->ties.any && !f->ties.sure) {
        f->ties.any = false;
        begin_stage(f, f->stage);
    } else {
        return false;
    }
    return true;
}

/* The rounds; *least is the number of texels that differ with the heights in dst. */
static ntp_status iterate(ntp__refinement *f, const ntp_image *dst, int32_t *rounds,
                          uint64_t *least)
{
    const ntp_hooks *hooks = f->crew.hooks;
    bool stepped = false;
    int32_t best = 0, changes = 0; /* the last round that helped */
    uint64_t off, mark = UINT64_MAX;
    double value = ntp__refinement_value(f, 0, least);
    if (f->plan->refine > 0 && *least > 0 && f->ties.any) {
        ntp__ties_level(&f->ties, f->heights);
        keep_better(f, dst, least);
    }
    while (*rounds < f->plan->refine && *least > 0) {
        if (hooks != NULL && hooks->progress != NULL &&
            hooks->progress(hooks->user, (double) *rounds / f->plan->refine) != 0)
            return NTP_ERR_CANCELLED;
        bool over = is_over(f, *rounds), stalls = f->ties.any && *rounds - best > PATIENCE;
        if (stalls)
            stalls = go_on(f, &changes);
        else if (over || *rounds == 0)
            begin_stage(f, f->stage + over);
        if (stalls || over || *rounds == 0) {
            value = ntp__refinement_value(f, f->moved, &off);
            stepped = false;
            best = *rounds;
            mark = UINT64_MAX;
        }
        ++*rounds;
        if (!ntp__refinement_advance(f, stepped, &value, &off)) {
            if (!go_on(f, &changes))
                break;
            value = ntp__refinement_value(f, f->moved, &off);
            stepped = false;
            best = *rounds;
            mark = UINT64_MAX;
            continue;
        }
        stepped = true;
        if (off < *least)
            keep_better(f, dst, least);
        if (off < mark - mark / HELP) {
            mark = off;
            best = *rounds;
        }
    }
    return NTP_OK;
}

ntp_status ntp__refine(const ntp_image *dst, ntp__round_trip *trip, const ntp__height_plan *plan,
                       bool holes, void *scratch, const ntp_hooks *hooks, ntp_height_result *result)
{
    ntp__refinement f;
    ntp__scratch memory = { scratch, 0 };
    memset(&f, 0, sizeof f);
    f.trip = trip;
    f.crew = ntp__crew_of(hooks);
    lay_out(&f, plan, &memory);
    begin(&f, dst, holes);
    ntp_status status = iterate(&f, dst, &result->rounds, &result->refine_left);
    if (holes && result->rounds > 0)
        level_islands(&f, dst, &result->refine_left);
    return status;
}
