/* SPDX-License-Identifier: MIT */
/*
 * dither_tmpl.h - a part of gradient_kernels.c: rounding that keeps the sum of slopes, without AVX2
 *
 * The difference in height of two texels is a sum of slopes, so rounding errors add up along a row.
 * Here each texel leaves the error of its slope, as a reader of the texture will see it, to the
 * next texel, which takes as much of it as a level there can hold.  So on gentle ground a sum is
 * never off by more than the error of one texel.
 *
 * A texel waits for the one before it, through two roots and two quotients.  So the texels of a step
 * of several rows are done together (gradient.h).
 */

static inline double between(double v, double most)
{
    return v > most ? most : v < -most ? -most : v;
}

/* What a step needs of the slopes, with the errors that came. */
typedef struct dithered {
    double slope[2][NTP__WAVE], xy[2][NTP__WAVE], factor[NTP__WAVE], rest[NTP__WAVE];
} dithered;

/*
 * How much of the errors slopes can take: the step between levels there, (1 + w^2)^(3/2) / (M/2).
 * More, as a cliff leaves it, would turn the flat texel beside it over.  Where w is so steep that a
 * step is most of it, a tenth of its length: the normal turns by some degrees.
 */
static ALWAYS_INLINE void add_errors(dithered *restrict v, const ntp__wave_step *restrict step,
                                     const double *restrict along, const double *restrict down,
                                     double half)
{
    for (int32_t k = 0; k < NTP__WAVE; k++) {
        double x = between(step->slope[0][k], STEEPEST), y = between(step->slope[1][k], STEEPEST);
        double length2 = 1 + x * x + y * y, length = sqrt(length2);
        double one = length2 * length / half, tenth = length / 10, most = one < tenth ? one : tenth;
        v->slope[0][k] = x + between(along[k], most);
        v->slope[1][k] = y + between(down[k], most);
    }
}

/* floor((M + 1 + M n) / 2) for n in [-1, 1].  A double is precise enough here. */
static ALWAYS_INLINE int32_t level_of(double n, int32_t m)
{
    int32_t k = (int32_t) ((n + 1) / 2 * m + 0.5);
    return k < m ? k : m;
}

/* The levels of red and green, and what they leave for blue. */
static ALWAYS_INLINE void round_step(dithered *restrict v, ntp__wave_step *restrict step,
                                     const ntp__dithering *how, bool shorten)
{
    const int32_t m = how->m;
    const double min_z = how->min_z, shortened = how->shortened, m2 = (double) m * m;
    for (int32_t k = 0; k < NTP__WAVE; k++) {
        double x = v->slope[0][k], y = v->slope[1][k], factor = 1 / sqrt(1 + x * x + y * y);
        if (shorten) {
            double other = shortened / sqrt(x * x + y * y);
            factor = factor < min_z ? other : factor;
        }
        int32_t r = level_of(x * factor, m), g = level_of(y * factor, m);
        double p = 2 * r - m, q = 2 * g - m;
        step->level[0][k] = r;
        step->level[1][k] = g;
        v->xy[0][k] = p;
        v->xy[1][k] = q;
        v->rest[k] = m2 - p * p - q * q;
    }
}

/* Pulls the pairs that are too long. */
static void pull_step(dithered *v, ntp__wave_step *step, int32_t m)
{
    for (int32_t k = 0; k < NTP__WAVE; k++) {
        if (v->rest[k] > 0)
            continue;
        ntp__pull(&step->level[0][k], &step->level[1][k], m);
        v->xy[0][k] = ntp__num(step->level[0][k], m);
        v->xy[1][k] = ntp__num(step->level[1][k], m);
        v->rest[k] = (double) ntp__rest(step->level[0][k], step->level[1][k], m);
    }
}

/* Blue from the root of what is left, which is never a square (level.h); and the errors. */
static ALWAYS_INLINE void leave_errors(double *restrict along, double *restrict down,
                                       ntp__wave_step *restrict step, const dithered *restrict v,
                                       int32_t m, bool zzero)
{
    const double twice = zzero ? 2 : 1;
    const int32_t more = zzero ? 1 : m + 1;
    for (int32_t k = 0; k < NTP__WAVE; k++) {
        double z = sqrt(v->rest[k]);
        step->level[2][k] = ((int32_t) (twice * z) + more) / 2;
        along[k] = v->slope[0][k] - v->xy[0][k] / z;
        down[k] = v->slope[1][k] - v->xy[1][k] / z;
    }
}

static void dither(ntp__wave_step *steps, double *along, double *down, int32_t rows, int32_t n,
                   const ntp__dithering *how)
{
    const int32_t m = how->m;
    double before[NTP__WAVE] = { 0 }, above[NTP__WAVE + 1] = { 0 };
    dithered v;
    for (int32_t t = 0; t < n + rows - 1; t++) {
        double least = 1;
        if (t < rows)
            before[t] = along[t];
        above[0] = t < n ? down[t] : 0;
        add_errors(&v, &steps[t], before, above, m / 2.0);
        if (how->min_z > 0)
            round_step(&v, &steps[t], how, true);
        else
            round_step(&v, &steps[t], how, false);
        for (int32_t k = 0; k < NTP__WAVE; k++)
            least = v.rest[k] < least ? v.rest[k] : least;
        if (least < 0)
            pull_step(&v, &steps[t], m);
        leave_errors(before, above + 1, &steps[t], &v, m, how->zzero);
        if (t >= n - 1)
            along[t - (n - 1)] = before[t - (n - 1)];
        if (t >= rows - 1)
            down[t - (rows - 1)] = above[rows];
    }
}

static void put_slopes(ntp__wave_step *steps, const ntp__wave_rows *from, int32_t first, int32_t n)
{
    for (int32_t t = 0; t < n; t++) {
        for (int32_t k = 0; k < NTP__WAVE_PART; k++) {
            const int32_t row = first + k, i = NTP__WAVE + t - row;
            steps[t].slope[0][row] = from->slope[k][0][i];
            steps[t].slope[1][row] = from->slope[k][1][i];
        }
    }
}

static void take_levels(ntp__wave_rows *to, const ntp__wave_step *steps, int32_t first, int32_t n)
{
    for (int32_t t = 0; t < n; t++) {
        for (int32_t k = 0; k < NTP__WAVE_PART; k++) {
            for (int32_t c = 0; c < 3; c++)
                to->level[k][c][NTP__WAVE + t - first - k] = steps[t].level[c][first + k];
        }
    }
}
