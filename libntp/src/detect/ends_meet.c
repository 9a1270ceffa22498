/* SPDX-License-Identifier: MIT */
/*
 * ends_meet.c - is wrap the better guess for a damaged texture?
 *
 * With a free border the errors of slopes add up: a lean of a quarter of a level becomes a ramp from
 * edge to edge.  With wrap they do not, but the step by which heights at the two ends differ bends
 * them instead.  So two losses are compared.  The slopes along line i add up to the step D[i].  The
 * slopes across the lines, along the last edge less along the first, add up to the same steps V[i],
 * but for a constant.  The errors of both have nothing to do with each other.  So the mean of D V is
 * the square of the true step, and what D^2 has beyond that is of errors.  Steps that change
 * along the edge within s lines bend heights as far as s / pi into the picture, so stretches of
 * lines are compared with their neighbors, at all lengths, and long ones count more.  What all lines
 * have in common shows in D alone: it is a lean, of the surface or of the errors.
 *
 * All of this is asked of the slopes that the solver takes: after BC1, flat ground that leans by four
 * levels is level there, and of steep texels stored and derived z differ.
 */
#include "detect/ends_meet.h"

#include "base/cpu.h"
#include "detect/line_loops_tmpl.h"
#include "to_height/decode.h"
#include "to_height/shared/slopes.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

enum {
    MOST_LINES = 512,
    MOST_TEXELS = 1 << 18, /* of all lines; of longer ones half, which tell more each */
    LONG = 512,
    MOST_ASKED = 1 << 17, /* texels that tell how the solver reads them */
    LEAST_LINES = 16,     /* and a power of 2 times that */
    ABREAST = 4,          /* lines that are summed at once */
    END = 4,              /* texels at an end of a line whose mean height counts */
    BLOCK = 4,            /* a side of what block compression stores as one, in so many colors */
    BLOCKS = 16,          /* are looked at along each side */
    LEAST_MIXED = 8       /* of these have three colors or four */
};

/* The square of an 8-bit level over 12, of lengths.  Levels that were cut off make four times that. */
static const double rounding = 4.0 / (255.0 * 255.0 * 12.0), most_error = 5;
/* Damage and decoding can be off by a part of a level.  A steeper lean is one of the surface, unless
 * the steps of lines are off by so much that their mean can be: its square is at most so many times
 * that of these errors.  A yet steeper one always is. */
static const double most_lean = 0.75 / 255, most_of_errors = 1.5 / 255, most_over_errors = 2;
/* Fractions that are cut off put ground off by half a level, and colors of blocks, which have five or six
 * bits, by up to four.  So a lean may be one of these, if it costs so many times what the steps do. */
static const double most_of_cut = 1.0 / 255, cut_ramp = 400;
static const double most_of_blocks = 2.5 / 255, block_ramp = 10;
/* The ramp that a free border makes, with this part of the errors of steps, must have so many times
 * the square of the true steps, and this part of what they can be by chance.  Steps count as far as D
 * and V agree on them: where they do, ends do not meet, and the surface may well lean, too.  The
 * numbers were chosen on half of the heights of public projects, each with 32 damaged maps. */
static const double of_errors = 0.2, over_steps = 9, by_chance = 0.2;
/* Where D and V are so much alike, ends differ.  Of damaged tiles they were 0.82 at most. */
static const double alike = 0.85;

typedef struct lines {
    ntp_const_image src, part; /* lines are rows of src */
    ntp__slopes slopes;
    float right[NTP__BLOCK], down[NTP__BLOCK];
    const float *along, *across;
    double lean; /* what is added to all slopes along lines */
} lines;

/* Slopes of n texels of line y. */
static void read(lines *l, int32_t x, int32_t y, int32_t n)
{
    l->part = l->src;
    l->part.data = ntp__at(&l->src, x, y);
    l->part.width = n;
    ntp__slopes_row_single(&l->slopes, l->right, l->down, 0, NULL);
}

/* Finds out how a solver with free borders reads src. */
static void find_reading(ntp__reading *r, const ntp_const_image *src, const ntp_height_options *how)
{
    ntp_const_image some = *src; /* rows */
    int32_t one_in = (int32_t) ((int64_t) src->height * src->width / MOST_ASKED);
    if (r->known)
        return;
    if (one_in > 1) {
        some.height = src->height > LEAST_LINES * one_in ? src->height / one_in : LEAST_LINES;
        some.row_stride *= src->height / some.height;
    }
    memset(r, 0, sizeof *r);
    r->known = true;
    r->plan.border_x = r->plan.border_y = NTP_BORDER_MIRROR;
    r->plan.neutral = 1;
    r->plan.decode = how->decode;
    r->plan.z = how->z;
    r->plan.touch_unused = how->touch_unused;
    ntp__decode_by_evidence(&r->plan, &some);
}

static void start(lines *l, const ntp_const_image *src, const ntp__height_plan *plan, bool down)
{
    l->src = l->part = down ? ntp__transposed(src) : *src;
    ntp__slopes_init(&l->slopes, &l->part, plan);
    l->along = down ? l->down : l->right;
    l->across = down ? l->right : l->down;
    l->lean = !down ? plan->lean[0] : src->y == NTP_Y_UP ? -plan->lean[1] : plan->lean[1];
}

/* The sums of the slopes along ABREAST of `of` lines, from the one of this index on.  One sum would wait for
 * itself. */
static void whole(double sum[ABREAST], lines *l, int32_t index, int32_t of)
{
    float along[ABREAST][NTP__BLOCK];
    for (int32_t k = 0; k < ABREAST; k++)
        sum[k] = 0;
    for (int32_t x = 0; x < l->src.width; x += NTP__BLOCK) {
        int32_t n = l->src.width - x < NTP__BLOCK ? l->src.width - x : NTP__BLOCK;
        for (int32_t k = 0; k < ABREAST; k++) {
            read(l, x, (int32_t) ((int64_t) (index + k) * l->src.height / of), n);
            memcpy(along[k], l->along, (size_t) n * sizeof along[k][0]);
        }
        double a = sum[0], b = sum[1], c = sum[2], d = sum[3];
        for (int32_t i = 0; i < n; i++) {
            a += (double) along[0][i];
            b += (double) along[1][i];
            c += (double) along[2][i];
            d += (double) along[3][i];
        }
        sum[0] = a;
        sum[1] = b;
        sum[2] = c;
        sum[3] = d;
    }
    for (int32_t k = 0; k < ABREAST; k++)
        sum[k] += l->lean * l->src.width;
}

/* sum[i] += v[i] */
static void add(double *sum, const float *v, int32_t n)
{
#ifdef NTP_HAVE_AVX2
    if (ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__add_floats_avx2(sum, v, n);
        return;
    }
#endif
    ntp__add_floats(sum, v, n);
}

/* The sums of the slopes along all lines, of which there are few; texel by texel, as each one is in a row
 * of the picture. */
static void all_whole(double *sum, lines *turned, const lines *l)
{
    for (int32_t i = 0; i < l->src.height; i++)
        sum[i] = 0;
    for (int32_t x = 0; x < l->src.width; x++) {
        for (int32_t y = 0; y < l->src.height; y += NTP__BLOCK) {
            int32_t n = l->src.height - y < NTP__BLOCK ? l->src.height - y : NTP__BLOCK;
            read(turned, y, x, n);
            add(sum + y, turned->across, n);
        }
    }
    for (int32_t i = 0; i < l->src.height; i++)
        sum[i] += l->lean * l->src.width;
}

/* Of lines y to y + n - 1 the slope across at the end less that at the beginning.  beyond: the step between the
 * middles of both ends, around the seam.  What is across the lines is along the turned ones. */
static void at_ends(double *across, double *beyond, lines *turned, int32_t y, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        across[i] = beyond[i] = 0;
    for (int32_t k = 0; k < 2 * END; k++) {
        read(turned, y, k < END ? k : turned->src.height - 2 * END + k, n);
        for (int32_t i = 0; i < n; i++) {
            const double here = (double) turned->along[i];
            across[i] += k < END ? -here : here;
            beyond[i] += (double) turned->across[i];
        }
    }
    for (int32_t i = 0; i < n; i++) {
        across[i] /= END;
        beyond[i] /= 2;
    }
}

/* The number of colors of a block; one more than BLOCK: more than these. */
static int32_t count_colors(const ntp_const_image *src, int32_t x, int32_t y)
{
    int32_t color[BLOCK][3], colors = 0;
    ntp__block row;
    for (int32_t i = 0; i < BLOCK; i++) {
        ntp__unpack(&row, src, x, y + i, BLOCK);
        for (int32_t at = 0; at < BLOCK; at++) {
            int32_t k = 0;
            while (k < colors && (color[k][0] != row.c[0][at] || color[k][1] != row.c[1][at] ||
                                  color[k][2] != row.c[2][at]))
                k++;
            if (k == BLOCK)
                return k + 1;
            for (int32_t c = 0; c < 3; c++)
                color[k][c] = row.c[c][at];
            colors = k == colors ? k + 1 : colors;
        }
    }
    return colors;
}

/* Do blocks all over the picture have four colors at most? */
static bool is_in_blocks(const ntp_const_image *src)
{
    const int32_t across = src->width / BLOCK, down = src->height / BLOCK;
    int32_t mixed = 0;
    for (int32_t k = 0; k < BLOCKS * BLOCKS; k++) {
        int32_t x = (int32_t) ((int64_t) (k % BLOCKS) * across / BLOCKS) * BLOCK;
        int32_t y = (int32_t) ((int64_t) (k / BLOCKS) * down / BLOCKS) * BLOCK;
        int32_t colors = count_colors(src, x, y);
        if (colors > BLOCK)
            return false;
        mixed += colors > 2;
    }
    return mixed >= LEAST_MIXED;
}

/* May a lean of all lines come from errors of this square?  times: what it costs over what steps do. */
static bool may_be_error(double lean, double errors, double times, const ntp_const_image *src)
{
    double most = lean * lean <= most_over_errors * errors ? most_of_errors : most_lean;
    double size = fabs(lean) / src->width;
    return size <= most || (size <= most_of_cut && times > cut_ramp) ||
           (size <= most_of_blocks && times > block_ramp && is_in_blocks(src));
}

/* Which loss is less?  seen: the steps of n lines as slopes across them show them.  Both are used up. */
static ntp__ends weigh(double *step, double *seen, int32_t n, const ntp_const_image *src)
{
    double steps = 0;              /* squares of the true ones, */
    double summed = 0, looked = 0; /* and of each with its errors */
    for (int32_t half = n / 2; half > 0; half /= 2) {
        double weight = 1.0 / half / half; /* the mean of pairs, in proportion to their length */
        for (int32_t i = 0; i < half; i++) {
            double d = (step[2 * i] - step[2 * i + 1]) / 2, v = (seen[2 * i] - seen[2 * i + 1]) / 2;
            step[i] = step[2 * i] - d;
            seen[i] = seen[2 * i] - v;
            steps += weight * d * v;
            summed += weight * d * d;
            looked += weight * v * v;
        }
    }
    double chance = sqrt(summed * looked), least = summed < looked ? summed : looked;
    steps = steps < 0 ? 0 : steps > chance ? chance : steps;
    least = steps < least ? steps : least;
    double agreed = chance > 0 ? least * steps / chance : 0, errors = summed - least;
    double ramp = step[0] * step[0] * 8 / 12 * src->width / src->height;
    double gain = ramp + of_errors * errors, cost = over_steps * agreed + by_chance * chance;
    if (gain > cost && may_be_error(step[0], errors, cost > 0 ? gain / cost : HUGE_VAL, src))
        return NTP__ENDS_MEET;
    return steps > alike * chance ? NTP__ENDS_DIFFER : NTP__ENDS_UNTOLD;
}

/* Do the lengths of some rows show damage? */
static bool is_damaged(const ntp_const_image *src)
{
    ntp__block block;
    double level = 2.0 / ntp__max(src->type), errors2 = 0;
    for (int32_t k = 0; k < LEAST_LINES; k++) {
        /* not all at the same place of a brick or a plank */
        int32_t place = k * LEAST_LINES + k * 7 % LEAST_LINES;
        int32_t y = (int32_t) ((int64_t) place * src->height / (LEAST_LINES * LEAST_LINES));
        for (int32_t x = 0; x < src->width; x += NTP__BLOCK) {
            int32_t n = src->width - x < NTP__BLOCK ? src->width - x : NTP__BLOCK;
            ntp__unpack(&block, src, x, y, n);
            for (int32_t i = 0; i < n; i++) {
                double off = -1; /* twice the error of the length */
                for (int32_t c = 0; c < 3; c++) {
                    double v = block.c[c][i] * level - 1;
                    off += v * v;
                }
                errors2 += off * off;
            }
        }
    }
    return errors2 > 4 * most_error * rounding * LEAST_LINES * src->width;
}

ntp__ends ntp__find_ends(ntp__reading *reading, const ntp_const_image *src,
                         const ntp_height_options *how, bool down)
{
    double step[MOST_LINES], seen[MOST_LINES], sum = 0, over[NTP__BLOCK], beyond[NTP__BLOCK];
    double all[2 * MOST_LINES];
    lines l, turned;
    int32_t n = LEAST_LINES, next = 0;
    if (src->encoding != NTP_ENCODING_STANDARD || !is_damaged(src))
        return NTP__ENDS_UNTOLD;
    find_reading(reading, src, how);
    if (reading->plan.z == NTP_Z_DERIVED)
        return NTP__ENDS_UNTOLD;
    start(&l, src, &reading->plan, down);
    start(&turned, src, &reading->plan, !down);
    const int32_t most = l.src.width > LONG ? MOST_TEXELS / 2 : MOST_TEXELS;
    while (2 * n <= l.src.height && n < MOST_LINES && 2 * n <= most / l.src.width)
        n *= 2;
    const bool dense = down && l.src.height <= 2 * n;
    if (dense)
        all_whole(all, &turned, &l);
    for (int32_t k = 0; k < n && !dense; k += ABREAST)
        whole(&step[k], &l, k, n);
    for (int32_t y = 0; next < n; y++) {
        const int32_t at = y % NTP__BLOCK, left = l.src.height - y;
        if (at == 0)
            at_ends(over, beyond, &turned, y, left < NTP__BLOCK ? left : NTP__BLOCK);
        double here = over[at] / 2;
        sum += here;
        if (y == (int32_t) ((int64_t) next * l.src.height / n)) {
            step[next] = dense ? all[y] : step[next];
            seen[next++] = sum + beyond[at];
        }
        sum += here;
    }
    return weigh(step, seen, n, &l.src);
}
