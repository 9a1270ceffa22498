/* SPDX-License-Identifier: MIT */
/*
 * decode.c - what the levels of a texture mean, and whether its blue is to be trusted
 *
 * Normals have length 1, and levels are rounded.  If a texel is read by the rule it was written by,
 * its length is off by the rounding of three levels and no more.  By another rule it is off by
 * more, which a few thousand texels show.  A blue that was derived from red and green is exactly
 * what they give.  A blue that was rounded by itself often differs by a level where the normal is
 * tilted.  Normals never point below the surface, so a blue that says so shows how large the errors
 * of blue are.
 */
#include "to_height/decode.h"

#include "base/cpu.h"
#include "texel/level.h"
#include "to_height/evidence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_TEXELS = 500 }; /* that it takes to tell the rule */

/* The mean square of the error of the length: the square of an 8-bit level, over 12. */
static const double noise = 4.0 / (255.0 * 255.0 * 12.0);

/* In units of that: the most that passes as rounding, and how much worse than another rule UNORM
 * has to be.  least_score is the latter in standard errors. */
static const double most_noise = 1.5, least_gain = 0.03, least_score = 10;

/* Lengths that are off by more than three times the rounding: blue is something else, or the
 * texture is damaged. */
static const double most_error = 9;

/* Of normals whose blue is something else, x and y are as long as they were.  Damage makes some of
 * them too long.  Where they are nearly 1 long, a z that is derived from them is nearly 0, and the
 * slope has no limit. */
static const double damaged_share = 2e-5;

/* And z^2 does not follow 1 - x^2 - y^2 then.  Where blue is z, the slope of the line through both is
 * 1.  Errors of x and y lower it, of rough ground as far as to 0.29, errors of z do not; and the
 * slope of 1 - x^2 - y^2 over z^2 is at most 1 likewise.  A blue that is something else gives at most
 * 0.11.  One that is something else in parts gives more, but there most texels are either right,
 * within two standard errors of rounding, or far off: their share, times the root mean square of
 * the errors in standard errors, is above 14.  Errors of one kind make it 1.6, damaged bricks 8. */
static const double follows = 0.75, follows_loosely = 0.2, follows_back = 1.1, most_apart = 10;
static const double right = 4; /* the square of two standard errors */

/* Blue tells no z that is smaller than its errors.  A slope that is divided by such a z has no limit
 * either, so there n.z counts as so many times the error.  Few negative z tell little about it. */
static const double most_of_error = 2;
enum { FEW_NEGATIVE = 8 };

/* Damage makes some vectors longer than 1, with at least this share of the squares of all errors: 0.08
 * of a JPEG, 0.07 of noise.  Means of normals, as of a texture made smaller, are shorter, with 0.02
 * at most, and x/z is right then; so it is nearly of block compression, where texels lie between
 * two ends. */
static const double longer_share = 0.05;

/* Errors of neighbors are alike, which the prior does not know.  Of that it takes this part. */
static const double part_of_damage = 0.5;

/* Rounding puts 0 at 128.  Where flat ground has 127 instead, both levels were meant to be flat: red has
 * so many times the texels of 126 and 129 there, and 128 is rare beside it.  (In green a flip of Y
 * makes 127 of 128.)  Where it has 128, the plain rule gives more of the texels back: 0 is the edge of
 * the box of 128, so of the normals of heights that are flat to within errors half get 127.  Only if
 * nothing slopes along an axis the heights do not either, and it is 0; but where heights wrap along it,
 * they cannot lean, and the plain rule gives more texels back. */
enum { PILE = 3, ALONE = 10 };

/* A texel counts as tilted from 25 degrees on.  It takes so many of them, and this share of derived
 * blues among them. */
static const double tilted = 0.81;
enum { LEAST_TILTED = 64 };
static const double derived_share = 0.98;

/* Block compression stores the ends of a block in 5, 6 and 5 bits, so flat ground has 132 and 130
 * instead of 128, and would tilt.  It is known by a pile: one level of red and one of green that have
 * this share of all texels, and more than all others that near to zero.  If lengths are not damaged,
 * the level has to be 15 or 16 in 5 bits, or 31 or 32 in 6 bits. */
enum { NEAR = 5, NEAR_LEVELS = 2 * NEAR, FIRST_NEAR = 128 - NEAR };
static const double ground_share = 0.1;
static const int32_t coarse[2][2] = { { 123, 132 }, { 125, 130 } };

/* 0 rounds to 128, half a level above zero, so heights of flat ground lean.  Undamaged textures are to
 * come back texel by texel, and keep that.  Damaged ones do not come back anyway, so the lean is taken
 * out.  Flat ground is a pile of levels around zero, in red and green together, as wide as the damage.
 * Its texels are so many times as dense as those around it (slopes that are not flat: 1.6 times at
 * most).  It leans by the mean of its levels times its share of all texels, at most by half a level.
 * A pile whose mean is further off leans on purpose.  Less than a tenth of a level may be chance. */
enum { SIZES = 3 };
static const double pile_density = 4, least_lean = 0.1, purpose = 0.75;

typedef struct ground {
    int32_t level[2][NEAR_LEVELS]; /* of red, of green: texels at each level near zero */
    int32_t ring[RINGS];           /* texels with both so many levels from zero */
    int32_t ring_sum[2][RINGS];    /* of red, of green: their distances in half levels */
} ground;

/* What the pairs say about red and green alone, and about how far both are from zero. */
static void sum_ground(ground *g, const evidence *e)
{
    memset(g, 0, sizeof *g);
    const int32_t skipped = FIRST_NEAR - FIRST_AROUND;
    for (int32_t i = 0; i <= AROUND; i++) {
        for (int32_t j = 0; j <= AROUND; j++) {
            int32_t n = e->near[i][j], x = 2 * (i - RINGS) + 1, y = 2 * (j - RINGS) + 1;
            int32_t ring = (abs(x) > abs(y) ? abs(x) : abs(y)) / 2;
            if (i >= skipped && i < skipped + NEAR_LEVELS)
                g->level[0][i - skipped] += n;
            if (j >= skipped && j < skipped + NEAR_LEVELS)
                g->level[1][j - skipped] += n;
            if (i == AROUND || j == AROUND)
                continue;
            g->ring[ring] += n;
            g->ring_sum[0][ring] += n * x;
            g->ring_sum[1][ring] += n * y;
        }
    }
}

/* Was the texture written by this rule rather than by UNORM? */
static bool convinces(const evidence *e, const rule *r)
{
    return e->count >= LEAST_TEXELS && r->sum <= most_noise * noise * e->count &&
           r->gain >= least_gain * noise * e->count && r->gain >= least_score * sqrt(r->gain2);
}

static bool is_neutral(const evidence *e, const ntp__height_plan *plan)
{
    bool leans_x = plan->border_x != NTP_BORDER_WRAP, leans_y = plan->border_y != NTP_BORDER_WRAP;
    if (e->level == e->all)
        return leans_y;
    return (leans_x && e->pile[1] == e->all) ||
           (e->pile[0] > PILE * e->beside && e->pile[0] > ALONE * e->pile[1]);
}

/* The level of flat ground; 0: there is no such ground. */
static int32_t ground_of(const evidence *e, const ground *g, int32_t channel)
{
    int32_t sum = 0, best = 0;
    for (int32_t i = 0; i < NEAR_LEVELS; i++) {
        sum += g->level[channel][i];
        if (g->level[channel][i] > g->level[channel][best])
            best = i;
    }
    int32_t most = g->level[channel][best];
    bool piled = most > ground_share * e->asked && most > sum - most;
    return piled ? FIRST_NEAR + best : 0;
}

/* Where flat ground is damaged as a whole, it is flat still. */
static void level_ground(ntp__height_plan *plan, const evidence *e, const ground *g, bool damaged)
{
    int32_t most = 0;
    for (int32_t c = 0; c < 2; c++) {
        int32_t level = ground_of(e, g, c), off = abs(2 * level - 255);
        damaged |= level == coarse[c][0] || level == coarse[c][1];
        if (level == 0)
            return;
        most = off > most ? off : most;
    }
    if (damaged && most > 1) {
        plan->decode = NTP_DECODE_NEUTRAL;
        plan->neutral = most;
    }
}

/* How far the levels of red and green of a damaged texture lie above zero because flat ground does. */
static void find_lean(ntp__height_plan *plan, const evidence *e, const ground *g)
{
    double within[RINGS + 1] = { 0 }, best = ground_share;
    for (int32_t r = 0; r < RINGS; r++)
        within[r + 1] = within[r] + (double) g->ring[r] / e->asked;
    for (int32_t k = 0; k < SIZES; k++) {
        int32_t size = 1 << k, area = 4 * size * size;
        double around = (within[3 * size] - within[2 * size]) / (5 * area);
        double share = within[2 * size] - 4 * area * around;
        if (within[size] < pile_density * around * area || share <= best)
            continue;
        best = share;
        double lean[2] = { 0 };
        for (int32_t c = 0; c < 2; c++) {
            for (int32_t r = 0; r < 2 * size; r++)
                lean[c] += g->ring_sum[c][r] / (2.0 * e->asked);
        }
        bool on_purpose = fabs(lean[0]) > purpose * share || fabs(lean[1]) > purpose * share;
        for (int32_t c = 0; c < 2; c++) {
            double most = share / 2, v = lean[c] > most ? most : lean[c] < -most ? -most : lean[c];
            plan->lean[c] = on_purpose || fabs(v) < least_lean ? 0 : v * 2 / 255;
        }
    }
}

static void choose_decode(ntp__height_plan *plan, const ntp_const_image *src, const evidence *e)
{
    bool rules = src->encoding == NTP_ENCODING_STANDARD;
    if (rules && convinces(e, &e->trunc) && e->trunc.sum <= e->snorm.sum)
        plan->decode = NTP_DECODE_TRUNC;
    else if (rules && convinces(e, &e->snorm))
        plan->decode = NTP_DECODE_SNORM;
    else
        plan->decode = is_neutral(e, plan) ? NTP_DECODE_NEUTRAL : NTP_DECODE_UNORM;
}

/* Is blue z with errors? */
static bool blue_follows(const evidence *e, double mean_error)
{
    double both = e->both * e->all - e->rest * e->z2;
    double rest = e->rest2 * e->all - e->rest * e->rest, z2 = e->z4 * e->all - e->z2 * e->z2;
    bool apart = e->right * sqrt(mean_error / noise) > most_apart * e->all;
    return both >= follows * rest ||
           (both >= follows_loosely * rest && both <= follows_back * z2 && !apart);
}

/* The mean square of the errors of x, y and z, if there are any but rounding.  They make vectors
 * longer as often as shorter; means of normals are shorter, and as good as before.  And they put the
 * points (1 - x^2 - y^2, z^2) off their line: by the lesser eigenvalue of the covariance.  Vectors
 * that are all too long, or z on another scale, have another line, but lie on it. */
static double damage_of(const evidence *e, double unit)
{
    double n = e->all, u = e->rest / n, v = e->z2 / n;
    double uu = e->rest2 / n - u * u, vv = e->z4 / n - v * v, uv = e->both / n - u * v;
    double off_line = (uu + vv - sqrt((uu - vv) * (uu - vv) + 4 * uv * uv)) / 2;
    double longer = 2 * e->longer / (unit * unit * n), across = off_line > 0 ? off_line / 2 : 0;
    return longer < across ? longer : across;
}

static void choose_z(ntp__height_plan *plan, const ntp_const_image *src, const evidence *e)
{
    double m = ntp__max(src->type), unit = 2 * m * m;
    double lengths = e->lengths / (unit * unit), all = e->all;
    if (e->count > 0 && (plan->decode == NTP_DECODE_TRUNC || plan->decode == NTP_DECODE_SNORM)) {
        lengths = plan->decode == NTP_DECODE_TRUNC ? e->trunc.sum : e->snorm.sum;
        all = e->count;
    }
    bool made = src->type != NTP_TYPE_F32 && e->tilted >= LEAST_TILTED &&
                e->derived >= derived_share * e->tilted;
    bool other = lengths > most_error * noise * all && e->too_long <= damaged_share * e->all &&
                 !blue_follows(e, lengths / all);
    plan->z = made || other ? NTP_Z_DERIVED : NTP_Z_STORED;
    bool damaged = lengths > most_error * noise * all;
    plan->mix_z = damaged && e->longer > longer_share * e->lengths;
    plan->error =
        damaged && plan->z == NTP_Z_STORED ? sqrt(part_of_damage * damage_of(e, unit)) : 0;
    plan->least_z = most_of_error * sqrt(e->negative2 / (e->negative + FEW_NEGATIVE));
}

void ntp__decode_by_evidence(ntp__height_plan *plan, const ntp_const_image *src)
{
    evidence e;
    ground g;
    double m = ntp__max(src->type);
    bool decode = plan->decode == NTP_DECODE_AUTO && src->type == NTP_TYPE_U8;
    memset(&e, 0, sizeof e);
    e.unorm = (rule) { .zero = 255, .unit = 1 / 255.0 };
    e.trunc = (rule) { .zero = 254, .unit = 1 / 255.0 };
    e.snorm = (rule) { .zero = 256, .unit = 1 / 254.0 };
    if (plan->decode == NTP_DECODE_AUTO && !decode)
        plan->decode = NTP_DECODE_UNORM;
    if (plan->z == NTP_Z_AUTO && src->encoding == NTP_ENCODING_XY)
        plan->z = NTP_Z_DERIVED;
    if (plan->z == NTP_Z_AUTO &&
        src->encoding == NTP_ENCODING_VECTOR) /* which may have any length */
        plan->z = NTP_Z_STORED;
    if (!decode && plan->z != NTP_Z_AUTO)
        return;
    e.most_rest = tilted * m * m;
    e.most_off = right * noise * 4 * (m * m) * (m * m);
    bool plain = plan->decode == NTP_DECODE_UNORM || plan->decode == NTP_DECODE_NEUTRAL;
    (*NTP__CPU_PICK(NTP__CPU_ALL, ntp__gather_evidence_base, ntp__gather_evidence_avx2))(
        &e, src, plan->touch_unused, src->type == NTP_TYPE_U8 && !plain);
    if (decode)
        choose_decode(plan, src, &e);
    sum_ground(&g, &e);
    bool damaged = e.lengths > most_error * noise * 4 * m * m * m * m * e.all;
    if (decode)
        level_ground(plan, &e, &g, damaged);
    if (plan->z == NTP_Z_AUTO)
        choose_z(plan, src, &e);
    if (decode && damaged && plan->decode == NTP_DECODE_UNORM && plan->z == NTP_Z_STORED &&
        src->encoding == NTP_ENCODING_STANDARD)
        find_lean(plan, &e, &g);
}
