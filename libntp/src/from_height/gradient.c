/* SPDX-License-Identifier: MIT */
/*
 * gradient.c - heightfield -> normals: the walk over the area
 *
 * The area is cut into bands, and these into strips of NTP__BLOCK columns.  A ring of as many rows
 * of heights as the kernel has (at most nine) moves down each strip, and reads each row once.  Tap
 * sums, encoding and packing follow row by row.  Texels whose rounding the encoding loop doubts are
 * done again, exactly.
 */
#include "from_height/gradient.h"

#include "base/inlining.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <math.h>
#include <string.h>

enum {
    GROUP = NTP__LANES, /* texels that are looked at together */
    /* Rows of a band.  A strip as high as the image would touch a memory page for each row; one of few
     * rows also reads more of them again: twice the radius of the kernel for each band. */
    BAND = 32,
    LINE = 64,         /* of a processor's cache */
    BAND_OF_RADIUS = 8 /* without dithering: so many for each 1 of the radius */
};

/* How a call is carried out. */
typedef struct walk {
    ntp__gradient g;
    bool ints;       /* heights are int32_t */
    bool floats;     /* samples are */
    bool blue;       /* blue is wanted */
    bool doubles;    /* the loops may compute in double; else every texel exactly */
    bool single;     /* also in float, but for texels in doubt */
    bool packed;     /* the latter, and floats, may go to packed pixels in one step */
    bool quick;      /* from 3 x 3 heights, too */
    double greatest; /* bound of the tap sums for heights of magnitude 1 */
    ntp__encode encode;
    ntp_normals_counts counts;
    int32_t first; /* first row of the area */
    ntp__encode_packed_fn *encode_rows;
    ntp__encode_vectors_fn *encode_vectors;
    ntp__wave_memory *wave;      /* dithering: of the scratch */
    ntp__dither_waves_fn *waves; /* dithering: of two waves; NULL: of one */
    double *errors;              /* dithering: carried down, one for each column; NULL: none */
    double along[BAND];          /* dithering: carried along each row of a band */
} walk;

typedef struct strip {
    ntp__height_row row[NTP__MAX_TAPS];
    union {
        int32_t i[2][NTP__BLOCK];
        double d[2][NTP__BLOCK];
    } sums;
    ntp__block out;
    int32_t doubt[NTP__BLOCK]; /* not 0: to be done exactly */
    uint8_t moved
        [NTP__BLOCK]; /* to be done exactly: repeat-slope takes a slope from outside the block */
    bool any_moved;
} strip;

/* ------------------------------------------------------------------------------ the plan */

#include "from_height/arithmetic_tmpl.h"

static ntp_status make_walk(walk *w, const ntp_image *dst, const ntp_const_image *src,
                            const ntp_normals_options *how)
{
    ntp__gradient *g = &w->g;
    memset(w, 0, sizeof *w);
    NTP__TRY(ntp__gradient_plan(g, dst, src, how));
    w->encode_rows = ntp__encode_rows_for(NTP__CPU_ALL);
    if (w->encode_rows == NULL)
        w->encode_rows = g->loops->encode_packed;
    w->encode_vectors = ntp__encode_vectors_for(NTP__CPU_ALL);
    w->ints = ntp__heights_are_int(g);
    w->floats = src->type == NTP_TYPE_F32;
    w->blue = g->derived || dst->encoding != NTP_ENCODING_XY;
    w->greatest = (double) g->kernel->gain * (double) g->range;
    /* What is shortened to nothing has no sign. */
    const double kept = g->shortened > 0 ? 1 : 0;
    w->encode.cx = g->cx * kept;
    w->encode.cy = g->cy * kept;
    w->encode.half = g->m / 2.0;
    w->encode.shortened = g->shortened;
    w->encode.use_shortened = g->min_z > 0;
    w->encode.side = (float) g->kernel->term[0].across[NTP__MAX_RADIUS - 1];
    w->encode.middle = (float) g->kernel->term[0].across[NTP__MAX_RADIUS];
    w->encode.zzero = dst->encoding == NTP_ENCODING_ZZERO;
    w->encode.unit = dst->encoding != NTP_ENCODING_VECTOR;
    w->encode.min_z = g->min_z;
    if (!w->floats) {
        set_arithmetic(w, w->greatest);
        if (w->greatest > 0x1p53)
            set_inexact(w, w->greatest);
        set_plain(w, 1, w->greatest);
    }
    return NTP_OK;
}

/* --------------------------------------------------------------------------------- rows */

static const ntp__height_row *get_row(strip *s, const ntp__gradient *g, int32_t x, int32_t y,
                                      int32_t n)
{
    int32_t rows = 2 * g->kernel->radius + 1;
    ntp__height_row *row = &s->row[(y + rows) % rows];
    if (!row->filled || row->y != y || row->quick)
        ntp__height_row_fill(row, g, x, y, n);
    return row;
}

/* What is known about the heights under a row of stencils. */
typedef struct facts {
    bool finite;
    double least, most;
} facts;

static void add_facts(facts *f, const ntp__height_row *row)
{
    f->finite = f->finite && row->finite;
    f->least = row->least < f->least ? row->least : f->least;
    f->most = row->most > f->most ? row->most : f->most;
}

/* The tap sums of one slope for a block, from the row that repeat-slope takes for row y. */
static void tap_sums(walk *w, strip *s, facts *f, int32_t x, int32_t y, int32_t n, bool down)
{
    const ntp__gradient *g = &w->g;
    const int32_t *rows_i[NTP__MAX_TAPS] = { NULL };
    const double *rows_d[NTP__MAX_TAPS] = { NULL };
    int32_t radius = g->kernel->radius;
    y = ntp__clamp(y, down ? g->down_y : g->right_y);
    for (int32_t k = -radius; k <= radius; k++) {
        const ntp__height_row *row = get_row(s, g, x, y + k, n);
        rows_i[NTP__MAX_RADIUS + k] = row->h.i;
        rows_d[NTP__MAX_RADIUS + k] = row->h.d;
        add_facts(f, row);
    }
    if (w->ints)
        w->g.loops->tap_sums_i(s->sums.i[down], rows_i, g->kernel, down, n);
    else
        w->g.loops->tap_sums_d(s->sums.d[down], rows_d, g->kernel, down, n);
}

/* Position `at` of the block takes the slope of position `from`, if that is in the block. */
static void repeat_slope(const walk *w, strip *s, int32_t at, int32_t from, int32_t n, bool down)
{
    if (from < 0 || from >= n) {
        s->moved[at] = 1;
        s->any_moved = true;
    } else if (w->ints) {
        s->sums.i[down][at] = s->sums.i[down][from];
    } else {
        s->sums.d[down][at] = s->sums.d[down][from];
    }
}

/* Repeats the slopes of the first and last positions inside towards the edges. */
static void repeat_slopes(const walk *w, strip *s, int32_t x, int32_t n, bool down)
{
    ntp__span span = down ? w->g.down_x : w->g.right_x;
    for (int32_t i = 0; i < n && x + i < span.first; i++)
        repeat_slope(w, s, i, span.first - x, n, down);
    for (int32_t i = n - 1; i >= 0 && x + i > span.last; i--)
        repeat_slope(w, s, i, span.last - x, n, down);
}

/* ------------------------------------------------------------------------------ one block */

/* Prepares the encoding of a block of float heights; false: do every texel exactly. */
static bool trust_floats(walk *w, const facts *f)
{
    const ntp__gradient *g = &w->g;
    if (!f->finite)
        return false;
    double gain = w->greatest; /* with the weights of the source */
    set_arithmetic(w, gain * f->most);
    /* Sums are exact if all samples are multiples of a unit, and sums stay below 2^53 units.  A
     * float is a multiple of a unit that is at least 2^-24 of it. */
    bool one_product = g->source != NTP_HEIGHT_SOURCE_SCREEN;
    if (!one_product)
        set_inexact(w, gain * (f->most > 1 ? 8 * f->most * f->most * f->most : 8));
    else if (!(gain * f->most <= 0x1p28 * f->least))
        set_inexact(w, gain * f->most);
    w->single = w->single && one_product && f->least >= least_height;
    set_plain(w, f->least * 0x1p-24, gain * f->most);
    return w->doubles;
}

/* Derives blue where that is asked for; negative: red and green are too long.  Not 0: there are
 * such. */
static int32_t derive(const walk *w, int32_t *const level[3], int32_t n)
{
    int32_t all = 0;
    if (!w->g.derived)
        return 0;
    ntp__kernels(NTP__CPU_ALL)->derive(level[2], level[0], level[1], n, w->g.m, w->encode.zzero);
    for (int32_t i = 0; i < n; i++)
        all |= level[2][i];
    return all < 0;
}

/* n texels in double, from their tap sums in double. */
static int32_t encode_precisely(const walk *w, int32_t *const level[3], int32_t *doubt,
                                double sums[2][NTP__BLOCK], int32_t n)
{
    int32_t *nearest = w->blue && !w->g.derived ? level[2] : NULL;
    for (int32_t i = n; i % NTP__LANES != 0; i++)
        sums[0][i] = sums[1][i] = 0; /* whole groups are encoded */
    const int32_t any = w->g.loops->encode_precisely(level[0], level[1], nearest, doubt, sums[0],
                                                     sums[1], n, &w->encode);
    return any | derive(w, level, n);
}

/* The tap sums of n texels: of all, or of those in `at`. */
static void sums_as_doubles(double sums[2][NTP__BLOCK], const walk *w, const strip *s,
                            const int32_t *at, int32_t n)
{
    for (int32_t k = 0; k < 2; k++) {
        for (int32_t i = 0; i < n; i++) {
            const int32_t from = at != NULL ? at[i] : i;
            sums[k][i] = w->ints ? (double) s->sums.i[k][from] : s->sums.d[k][from];
        }
    }
}

/* Does texels in doubt after float again in double.  Returns not 0 where that does not settle all. */
static int32_t settle_in_double(const walk *w, strip *s, int32_t n)
{
    int32_t at[NTP__BLOCK], level[3][NTP__BLOCK], doubt[NTP__BLOCK], found = 0;
    double sums[2][NTP__BLOCK];
    for (int32_t first = 0; first < n; first += GROUP) {
        int32_t any = 0;
        for (int32_t i = 0; i < GROUP; i++)
            any |= s->doubt[first + i];
        for (int32_t i = first; any != 0 && i < first + GROUP && i < n; i++) {
            at[found] = i;
            found += s->doubt[i];
        }
    }
    sums_as_doubles(sums, w, s, at, found);
    int32_t *const to[3] = { level[0], level[1], level[2] };
    const int32_t left = encode_precisely(w, to, doubt, sums, found);
    for (int32_t i = 0; i < found; i++) {
        for (int32_t k = 0; k < 3; k++)
            s->out.c[k][at[i]] = level[k][i];
        s->doubt[at[i]] = doubt[i];
    }
    return left;
}

/* Makes levels by the loops and fills s->doubt.  Returns whether any texel has a flag there. */
static bool encode(walk *w, strip *s, const facts *f, int32_t n)
{
    const ntp__gradient *g = &w->g;
    int32_t *const level[3] = { s->out.c[0], s->out.c[1], s->out.c[2] };
    int32_t *nearest = w->blue && !g->derived ? level[2] : NULL, any;
    if (w->floats ? !trust_floats(w, f) : !w->doubles) {
        w->single = false;
        for (int32_t i = 0; i < n; i++)
            s->doubt[i] = 1;
        return true;
    }
    if (!w->single) {
        double sums[2][NTP__BLOCK];
        sums_as_doubles(sums, w, s, NULL, n);
        return encode_precisely(w, level, s->doubt, sums, n) != 0;
    }
    if (w->ints)
        any = g->loops->encode_i(level[0], level[1], nearest, s->doubt, s->sums.i[0], s->sums.i[1],
                                 n, &w->encode);
    else
        any = g->loops->encode_d(level[0], level[1], nearest, s->doubt, s->sums.d[0], s->sums.d[1],
                                 n, &w->encode);
    const int32_t too_long = derive(w, level, n);
    return ((any ? settle_in_double(w, s, n) : 0) | too_long) != 0;
}

static void settle_exactly(walk *w, const strip *s, ntp__normal *normal, int32_t x, int32_t y,
                           int32_t i)
{
    const bool known = w->ints && !s->moved[i];
    const int64_t sums[2] = { known ? s->sums.i[0][i] : 0, known ? s->sums.i[1][i] : 0 };
    ntp__gradient_exact(normal, &w->g, x + i, y, known ? sums : NULL);
    w->counts.not_finite += !normal->finite;
    w->counts.exact += normal->wide;
}

/* Does texels in doubt again, and pulls pairs that are too long onto the disc.  They are few. */
static void settle(walk *w, strip *s, int32_t x, int32_t y, int32_t n)
{
    const int32_t sign = w->g.derived ? INT32_MIN : 0;
    int32_t(*c)[NTP__BLOCK] = s->out.c;
    for (int32_t first = 0; first < n; first += GROUP) {
        int32_t any = s->any_moved;
        for (int32_t i = 0; i < GROUP; i++)
            any |= s->doubt[first + i] | (c[2][first + i] & sign);
        for (int32_t i = first; any != 0 && i < first + GROUP && i < n; i++) {
            const bool again = s->doubt[i] != 0 || s->moved[i];
            int32_t to[3] = { c[0][i], c[1][i], c[2][i] };
            if (again) {
                ntp__normal normal;
                settle_exactly(w, s, &normal, x, y, i);
                memcpy(to, normal.level, sizeof to);
            }
            if (w->g.derived && (again || to[2] < 0))
                to[2] = ntp__derive(&to[0], &to[1], w->g.m, w->encode.zzero);
            for (int32_t k = 0; k < 3; k++)
                c[k][i] = to[k];
        }
    }
}

/* min_z also holds for a blue that is not derived. */
static void raise_blue(const walk *w, strip *s, int32_t n)
{
    int32_t *b = s->out.c[2], least = w->g.min_z_level;
    for (int32_t i = 0; i < n; i++)
        b[i] = b[i] > least ? b[i] : least;
}

static facts all_tap_sums(walk *w, strip *s, int32_t x, int32_t y, int32_t n)
{
    facts f = { true, 0x1p1000, 0 };
    for (int32_t down = 0; down < 2; down++) {
        tap_sums(w, s, &f, x, y, n, down);
        repeat_slopes(w, s, x, n, down);
    }
    return f;
}

#include "from_height/packed_tmpl.h"
#include "from_height/float_rows_tmpl.h"

static void do_block(walk *w, strip *s, int32_t x, int32_t y, int32_t n)
{
    if (w->g.dst->type == NTP_TYPE_F32) {
        do_float_block(w, s, x, y, n);
        return;
    }
    if (w->quick && encode_rows(w, s, x, y, n))
        return;
    facts f = all_tap_sums(w, s, x, y, n);
    if (encode_packed(w, s, &f, x, y, n))
        return;
    if (encode(w, s, &f, n) || s->any_moved)
        settle(w, s, x, y, n);
    if (!w->g.derived)
        raise_blue(w, s, n);
    ntp__gradient_pack(&w->g, &s->out, x, y, n);
}

/* The rows of a strip are far apart in memory, so processors do not fetch them ahead of time. */
static void fetch_ahead(const walk *w, int32_t x, int32_t y, int32_t n)
{
#if defined(__GNUC__)
    enum { ROWS = 2 };
    const ntp__gradient *g = &w->g;
    int32_t from = y + g->kernel->radius + ROWS, to = y + ROWS;
    if (from >= g->src->height)
        return;
    const char *s = ntp__at(g->src, x, from), *d = ntp__at_mut(g->dst, x, to);
    for (ptrdiff_t i = 0; i < n * g->src->pixel_stride; i += LINE)
        __builtin_prefetch(s + i, 0);
    const bool later = w->packed && g->m == 0; /* by the loop */
    for (ptrdiff_t i = 0; !later && i < n * g->dst->pixel_stride; i += LINE)
        __builtin_prefetch(d + i, 1);
#else
    (void) w, (void) x, (void) y, (void) n;
#endif
}

#include "from_height/dither_rows_tmpl.h"

/* What is written after a block: the row below, or the next strip. */
static void set_ahead(walk *w, const ntp_rect *band, int32_t x, int32_t y, int32_t n)
{
    if (y + 1 < band->y1)
        w->encode.ahead = ntp__at_mut(w->g.dst, x, y + 1);
    else
        w->encode.ahead = ntp__at_mut(w->g.dst, x + n < band->x1 ? x + n : x, band->y0);
}

static void do_strip(walk *w, strip *s, const ntp_rect *r, int32_t x, int32_t n)
{
    for (int32_t k = 0; k < NTP__MAX_TAPS; k++)
        s->row[k].filled = false;
    memset(s->moved, 0, sizeof s->moved);
    s->any_moved = false;
    const int32_t most = w->waves != NULL ? NTP__WAVES * NTP__WAVE : NTP__WAVE;
    for (int32_t y = r->y0; w->errors != NULL && y < r->y1; y += most)
        dither_rows(w, s, x, y, r->y1 - y < most ? r->y1 - y : most, n);
    for (int32_t y = r->y0; w->errors == NULL && y < r->y1; y++) {
        fetch_ahead(w, x, y, n);
        if (w->g.m == 0)
            set_ahead(w, r, x, y, n);
        do_block(w, s, x, y, n);
    }
}

static void do_bands(walk *w, ntp_rect r)
{
    strip s;
    w->first = r.y0;
    for (ntp_rect band = r; band.y0 < r.y1; band.y0 = band.y1) {
        const int32_t rows = w->errors != NULL ? BAND : BAND_OF_RADIUS * w->g.kernel->radius;
        band.y1 = r.y1 - band.y0 < rows ? r.y1 : band.y0 + rows;
        memset(w->along, 0, sizeof w->along);
        for (int32_t x = r.x0; x < r.x1; x += NTP__BLOCK)
            do_strip(w, &s, &band, x, r.x1 - x < NTP__BLOCK ? r.x1 - x : NTP__BLOCK);
    }
}

/* ------------------------------------------------------------------------------- public */

static void add_counts(ntp_normals_counts *counts, const walk *w)
{
    if (counts == NULL)
        return;
    counts->not_finite += w->counts.not_finite;
    counts->exact += w->counts.exact;
}

ntp_status ntp_normals_from_height(const ntp_image *dst, const ntp_const_image *src,
                                   const ntp_normals_options *how, ntp_normals_counts *counts,
                                   const ntp_rect *area)
{
    walk w;
    ntp_rect r;
    NTP__TRY(make_walk(&w, dst, src, how));
    NTP__TRY(ntp__check_area(&r, src, area));
    const bool vectors = dst->type == NTP_TYPE_F32;
    w.packed = vectors ? can_pack_floats(&w) : can_pack(&w);
    w.quick = (vectors || w.packed) && can_be_quick(&w);
    do_bands(&w, r);
    add_counts(counts, &w);
    return NTP_OK;
}

size_t ntp_normals_dithered_scratch_size(int32_t width)
{
    return width > 0 && width <= NTP_MAX_SIDE
               ? sizeof(ntp__wave_memory) + LINE + (size_t) width * sizeof(double)
               : 0;
}

ntp_status ntp_normals_dithered(const ntp_image *dst, const ntp_const_image *src,
                                const ntp_normals_options *how, void *scratch, size_t scratch_size,
                                ntp_normals_counts *counts, const ntp_rect *area)
{
    walk w;
    ntp_rect r;
    NTP__TRY(make_walk(&w, dst, src, how));
    NTP__TRY(ntp__check_area(&r, src, area));
    if (dst->type == NTP_TYPE_F32)
        return NTP_ERR_FORMAT;
    if (r.x0 != 0 || r.x1 != src->width)
        return NTP_ERR_SHAPE;
    if (scratch == NULL || (uintptr_t) scratch % 16 != 0 ||
        scratch_size < ntp_normals_dithered_scratch_size(src->width))
        return NTP_ERR_SCRATCH;
    w.waves = w.g.m == 255 && w.g.min_z == 0 ? ntp__dither_waves(NTP__CPU_ALL) : NULL;
    /* Errors stay where they are for the next call, wherever a line begins there. */
    w.errors = scratch;
    char *rest = (char *) (w.errors + src->width);
    w.wave = (void *) (rest + (LINE - (uintptr_t) rest % LINE) % LINE);
    w.g.derived = true;
    do_bands(&w, r);
    add_counts(counts, &w);
    return NTP_OK;
}
