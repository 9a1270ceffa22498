/* SPDX-License-Identifier: MIT */
/*
 * decide_orientation.c - the verdict about green, from the sums of orientation.c
 *
 * The sums are weighed twice.  In the evidence of the whole, derivatives of more than three times
 * their root mean square count as that.  In the evidence inside islands, those of more than twice
 * to four times their median do: where charts of an atlas end at each other or at their ground,
 * derivatives are many times as large as inside, but few.  So each island speaks for itself, a
 * faint one as loud as its neighbor.  Where the two contradict each other there is no answer.
 * docs/orientation.md tells the rest.
 */
#include "detect/orientation.h"

#include <math.h>
#include <stdbool.h>

/* On labeled textures of public projects, answers begin to be wrong below these.  Where the
 * statistic is clear, which it never is for noise, a somewhat lower score is enough. */
static const double LEAST_STATISTIC = 0.1, LEAST_SCORE = 4;
static const double CLEAR_STATISTIC = 0.5, CLEAR_SCORE = 3.5;
/* Who looks twice finds more by chance, so the second look must show more. */
static const double INSIDE_STATISTIC = 0.15, INSIDE_SCORE = 5;
/* Where more than this share is too steep, what is left misleads. */
static const double MOST_STEEP = 0.2;
/* Where p and q meet in one texel less than this, the texture is a grid or a weave.  Isotropic
 * surfaces and noise have 0.64.  A JPEG of half the colors mixes red with green, so there they meet
 * more; but then the narrow filter says less than this part of what the wide one says. */
static const double GRID = 0.45, MIXED_GRID = 0.6, MIXED_BENDS = 0.7, MIXED_NARROW = 0.45;
/* Both filters say this only of surfaces: steps that a weave hides lie within few texels, so they
 * bring the narrow one to 0.81 at most.  Pyramids side by side are told from weaves by it. */
static const double SURFACE = 0.85;
/* From here on the answer is as sure as it gets. */
static const double SURE_STATISTIC = 0.5, SURE_SCORE = 10;
/* Blocks that contradict the others with more than half of this share leave it below 0.9. */
static const double MOST_AGAINST = 0.2;
/* Labeled textures contradict even a clear answer now and then. */
static const double CONFIDENCE_LEAST = 0.8, CONFIDENCE_MOST = 0.99;

typedef enum { OF_WHOLE, INSIDE_ISLANDS, OF_EDGES } evidence_of;

/* What the loops say if derivatives are limited in one of the two ways. */
typedef struct evidence {
    double blocks[SIDE * SIDE]; /* what each adds to `mean` */
    double filter[FILTERS];     /* the statistic of each */
    double mean, score;
} evidence;

/* What undoes the shift in add_loop. */
static double unit_of(int32_t size)
{
    return (double) ((int64_t) 1 << 2 * (size > BITS ? size - BITS : 0));
}

/* The largest size inside islands: one more than the median of the loops where anything varies. */
static int32_t largest_inside(const loop_sums *acc)
{
    uint64_t varied = 0, seen = 0;
    for (int32_t k = 1; k < SIZES; k++)
        varied += acc->loops[k];
    int32_t median = 0;
    while (median + 1 < SIZES && 2 * seen < varied)
        seen += acc->loops[++median];
    return median + 1;
}

/* Weights of the sizes; false: nothing varies.  Loops above the limit get so little weight that
 * they count as that. */
static bool weigh(double weight[SIZES], double *energy, const loop_sums *acc, evidence_of of)
{
    const int32_t inside = largest_inside(acc), first = of == OF_EDGES ? inside + 1 : 0;
    double total = 0, loops = 0, held = 0;
    for (int32_t k = 0; k < SIZES; k++) {
        weight[k] = k < first ? 0 : unit_of(k);
        total += (double) acc->energy[k] * weight[k];
        loops += k < first ? 0 : (double) acc->loops[k];
    }
    if (total <= 0)
        return false;
    double limit =
        of == INSIDE_ISLANDS ? (double) ((int64_t) 1 << 2 * inside) : 9 * (total / loops);
    for (int32_t k = first; k < SIZES; k++) {
        double own = (double) acc->energy[k] * weight[k], most = limit * (double) acc->loops[k];
        if (own > most)
            weight[k] *= most / own;
        held += (double) acc->energy[k] * weight[k];
    }
    *energy = held;
    return true;
}

/* Adds to each block its part of the statistic of one filter; returns that statistic. */
static double add_blocks(double blocks[SIDE * SIDE], const loop_sums *acc, evidence_of of)
{
    double weight[SIZES], energy, statistic = 0;
    if (!weigh(weight, &energy, acc, of))
        return 0;
    int32_t first = 0, end = SIZES;
    while (weight[first] * (double) acc->energy[first] <= 0)
        first++;
    while (acc->energy[end - 1] == 0)
        end--;
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        double cross = 0;
        for (int32_t k = first; k < end; k++)
            cross += (double) acc->cross[k][i] * weight[k];
        blocks[i] += 2 * cross / energy / FILTERS;
        statistic += 2 * cross / energy;
    }
    return statistic;
}

static void gather(evidence *e, const ntp_orientation *acc, evidence_of of)
{
    *e = (evidence) { 0 };
    double squares = 0;
    for (int32_t f = 0; f < FILTERS; f++)
        e->filter[f] = add_blocks(e->blocks, &acc->sums[f], of);
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        e->mean += e->blocks[i];
        squares += e->blocks[i] * e->blocks[i];
    }
    e->score = squares > 0 ? e->mean / sqrt(squares) : 0;
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

/* A surface whose p and q hardly meet in one texel hardly changes p along y or q along x either:
 * those changes stand where the two meet.  Threads of a weave end at each other, so they do. */
static bool is_weave(const ntp_orientation *acc, const evidence *e)
{
    double across = 0, along = (double) acc->along * (ALONG_UNIT * ALONG_UNIT);
    for (int32_t k = 0; k < SIZES; k++)
        across += (double) acc->sums[WIDE].energy[k] * unit_of(k);
    double both = (double) acc->both, either = (double) acc->either;
    double bends = across * either, meets = along * both;
    double wide = e->filter[WIDE], narrow = e->filter[NARROW];
    if (least(wide, narrow) >= SURFACE || least(-wide, -narrow) >= SURFACE)
        return false;
    bool mixed = both < MIXED_GRID * either &&
                 (wide < 0 ? -narrow : narrow) < MIXED_NARROW * (wide < 0 ? -wide : wide);
    return (both < GRID * either && bends > meets) || (mixed && bends > MIXED_BENDS * meets);
}

static double sign_of(const evidence *e)
{
    return e->mean < 0 ? -1 : 1;
}

/* What the clearer filter says for the sign. */
static double clearer(const evidence *e)
{
    double sign = sign_of(e);
    return -least(-sign * e->filter[WIDE], -sign * e->filter[NARROW]);
}

static bool is_enough(const evidence *e, evidence_of of)
{
    double steady = sign_of(e) * e->score, clear = clearer(e);
    if (of == INSIDE_ISLANDS)
        return clear >= INSIDE_STATISTIC && steady >= INSIDE_SCORE;
    return (clear >= LEAST_STATISTIC && steady >= LEAST_SCORE) ||
           (clear >= CLEAR_STATISTIC && steady >= CLEAR_SCORE);
}

/* How sure a verdict is.  What the narrow filter says as a part of what the clearer one says counts
 * too: noise lowers it somewhat, hidden steps lower it much. */
static double confidence_of(const evidence *e)
{
    double against = 0, sign = sign_of(e), mean = sign * e->mean;
    for (int32_t i = 0; i < SIDE * SIDE; i++)
        against += sign * e->blocks[i] < 0 ? -sign * e->blocks[i] : 0;
    double sure = least(mean / SURE_STATISTIC, sign * e->score / SURE_SCORE);
    sure = least(sure, sign * e->filter[NARROW] / clearer(e));
    sure = least(sure, 1 - against / (mean + 2 * against) / MOST_AGAINST);
    sure = sure < 0 ? 0 : least(sure, 1);
    return CONFIDENCE_LEAST + (CONFIDENCE_MOST - CONFIDENCE_LEAST) * sure;
}

ntp_status ntp_orientation_summarize(ntp_orientation_result *result,
                                     const ntp_orientation *orientation)
{
    if (result == NULL || orientation == NULL)
        return NTP_ERR_ARGUMENT;
    evidence whole, inside, edges;
    gather(&whole, orientation, OF_WHOLE);
    gather(&inside, orientation, INSIDE_ISLANDS);
    bool enough = is_enough(&whole, OF_WHOLE),
         by_inside = !enough && is_enough(&inside, INSIDE_ISLANDS);
    if (by_inside)
        gather(&edges, orientation, OF_EDGES);
    const evidence *told = by_inside ? &inside : &whole, *other = by_inside ? &edges : &inside;
    bool contradicted = sign_of(told) * other->mean < -LEAST_STATISTIC;
    ntp_orientation_result r = { 0, NTP_Y_UP, 0, told->mean, told->score, 0 };
    for (int32_t k = 0; k < SIZES; k++)
        r.loops += orientation->sums[WIDE].loops[k];
    double all = (double) r.loops + (double) orientation->steep;
    bool steep = (double) orientation->steep > MOST_STEEP * all;
    r.y = told->mean < 0 ? NTP_Y_DOWN : NTP_Y_UP;
    r.decided =
        (enough || (by_inside && !contradicted)) && !steep && !is_weave(orientation, &whole);
    if (r.decided)
        r.confidence = contradicted ? CONFIDENCE_LEAST : confidence_of(told);
    *result = r;
    return NTP_OK;
}
