/* SPDX-License-Identifier: MIT */
/*
 * transform.c - flips, turns and strength
 *
 * A turned or flipped picture is the same memory with other strides, so the source is read through
 * such a view.  Then red and green are swapped or mirrored, which is exact.  (Turns by other angles
 * are in rotate.c.)  A strength S = n / 2^k makes (n x, n y, 2^k z), whose direction is rounded once.
 */
#include "base/cpu.h"
#include "base/inlining.h"
#include "base/rgb_avx2.h"
#include "reshape/mix_avx2.h"
#include "reshape/rotate.h"
#include "reshape/turn_floats.h"
#include "texel/unused.h"
#include "texel/level.h"

#include <string.h>
#ifdef NTP_HAVE_AVX2
#  include <emmintrin.h>
#endif

enum {
    LINE = 64,     /* bytes that come from memory together */
    AHEAD = 8,     /* rows of the source that are asked for before they are needed */
    COLUMNS = 128, /* of the result at a time, where these are rows of the source */
    WIDE = 8,      /* bytes that are copied of texels with as many or less, */
    LEAST = 2,     /* but not less than these */
    BEYOND = 8,    /* bytes after a row of a tile; a whole number of samples */
    /* Of such texels.  They fit into the first cache, and the caller's stack, and are 64 rows of RGB8
     * or 32 of RGB16, which are whole cells. */
    TILE_BYTES = 64 * (COLUMNS * 3 + BEYOND),
    LARGE = 1 << 23 /* bytes of a result that does not stay in the caches */
};

typedef struct job {
    const ntp_image *dst;
    ntp_const_image src; /* turned, so it has the size of dst */
    bool swap;           /* red of the result is green of the source, and the other way round */
    bool mirror_r, mirror_g;
    bool stronger; /* strength is neither 1 nor -1 */
    ntp__strength strength;
    int32_t m;
} job;

static ptrdiff_t texel_size(const job *j)
{
    return (ptrdiff_t) j->src.channels * ntp__sample_size(j->src.type);
}

static void flip_columns(ntp_const_image *v)
{
    v->data = (const char *) v->data + (ptrdiff_t) (v->width - 1) * v->pixel_stride;
    v->pixel_stride = -v->pixel_stride;
}

static void flip_rows(ntp_const_image *v)
{
    v->data = (const char *) v->data + (ptrdiff_t) (v->height - 1) * v->row_stride;
    v->row_stride = -v->row_stride;
}

/* Column x of the result is row x of the source, from the bottom up. */
static void turn_clockwise(ntp_const_image *v)
{
    flip_rows(v);
    ptrdiff_t stride = v->row_stride;
    v->row_stride = v->pixel_stride;
    v->pixel_stride = stride;
    int32_t width = v->width;
    v->width = v->height;
    v->height = width;
}

/* One clockwise turn takes (x, y) to (y, -x), y up; with y down to (-y, x). */
static void turn_vectors(job *j, ntp_y y)
{
    bool r = j->mirror_r, g = j->mirror_g;
    j->swap = !j->swap;
    j->mirror_r = y == NTP_Y_DOWN ? !g : g;
    j->mirror_g = y == NTP_Y_DOWN ? r : !r;
}

SELDOM static void move(job *j, const ntp_transform_options *how, int32_t quarter_turns)
{
    if (how->flip_x) {
        flip_columns(&j->src);
        j->mirror_r = true;
    }
    if (how->flip_y) {
        flip_rows(&j->src);
        j->mirror_g = true;
    }
    for (int32_t i = 0; i < quarter_turns; i++) {
        turn_clockwise(&j->src);
        turn_vectors(j, j->src.y);
    }
    if (j->strength.numerator < 0) {
        j->mirror_r = !j->mirror_r;
        j->mirror_g = !j->mirror_g;
        j->strength.numerator = -j->strength.numerator;
    }
    j->stronger = j->strength.numerator != 1 || j->strength.shift != 0;
}

/* Makes a used texel stronger, exactly, and turns its vector; its alpha stays. */
SELDOM static void strengthen_texel(const job *j, ntp__block *block, int32_t i)
{
    int32_t c[3] = { 0, 0, block->c[2][i] }, v[3];
    ntp__i128 scaled[3];
    ntp__texel_vector(v, block, i, j->m, j->src.encoding);
    for (int32_t k = 0; k < 2; k++)
        scaled[k] = ntp__i128_multiply(ntp__i128_of(v[k]), j->strength.numerator);
    scaled[2] = ntp__i128_shift(ntp__i128_of(v[2]), j->strength.shift);
    /* The vector is turned before it is rounded: half up is not symmetric about 0. */
    ntp__i128 r = scaled[j->swap], g = scaled[!j->swap];
    scaled[0] = j->mirror_r ? ntp__i128_negate(r) : r;
    scaled[1] = j->mirror_g ? ntp__i128_negate(g) : g;
    ntp__direction_levels(c, scaled, j->m, j->src.encoding);
    for (int32_t k = 0; k < 3; k++)
        block->c[k][i] = c[k];
}

/* The vectors of a block, turned and stronger. */
static void stronger_vectors(const job *j, ntp__vectors *v, const ntp__block *block, int32_t n)
{
    const double factor = ntp__strength_value(&j->strength);
    const double by_r = j->mirror_r ? -factor : factor, by_g = j->mirror_g ? -factor : factor;
    if (j->src.encoding != NTP_ENCODING_XY) {
        ntp__kernels(NTP__CPU_ALL)
            ->numerators(v, block->c[j->swap], block->c[!j->swap], block->c[2], n, j->m,
                         j->src.encoding == NTP_ENCODING_ZZERO, by_r, by_g);
        return;
    }
    ntp__vectors was;
    ntp__block_vectors(&was, block, n, j->m, j->src.encoding);
    for (int32_t i = 0; i < n; i++) {
        v->c[0][i] = was.c[j->swap][i] * by_r;
        v->c[1][i] = was.c[!j->swap][i] * by_g;
        v->c[2][i] = was.c[2][i];
    }
}

/* Makes a block stronger, and turns its vectors. */
static void strengthen(const job *j, ntp__block *block, int32_t n)
{
    ntp__block was = *block;
    ntp__vectors v;
    int32_t doubt[NTP__BLOCK];
    stronger_vectors(j, &v, block, n);
    const bool any = ntp__block_directions(block, doubt, &v, n, j->m, j->src.encoding, true);
    const bool suspect = ntp__any_suspect(&was, n, j->m);
    for (int32_t i = 0; (any || suspect) && i < n; i++) {
        const bool unused = suspect && ntp__texel_unused(&was, i, j->m, 0);
        if (!unused && doubt[i] == 0)
            continue;
        for (int32_t k = 0; k < 3; k++)
            block->c[k][i] = was.c[k][i];
        if (!unused)
            strengthen_texel(j, block, i);
    }
}

/* Turns the vectors of a block, which is exact. */
static void turn_block(const job *j, ntp__block *block, int32_t n)
{
    int32_t turned[2][NTP__BLOCK];
    const int32_t *r = block->c[j->swap], *g = block->c[!j->swap];
    const int32_t flip_r = j->mirror_r ? j->m : 0,
                  flip_g = j->mirror_g ? j->m : 0; /* M - c = M ^ c */
    for (int32_t i = 0; i < n; i++) {
        turned[0][i] = r[i] ^ flip_r;
        turned[1][i] = g[i] ^ flip_g;
    }
    if (ntp__any_suspect(block, n, j->m)) {
        for (int32_t i = 0; i < n; i++) {
            for (int32_t k = 0; k < 2 && ntp__texel_unused(block, i, j->m, 0); k++)
                turned[k][i] = block->c[k][i];
        }
    }
    memcpy(block->c[0], turned[0], (size_t) n * sizeof turned[0][0]);
    memcpy(block->c[1], turned[1], (size_t) n * sizeof turned[1][0]);
}

SELDOM static void keep_unused_floats(const job *j, const ntp__block *block, int32_t x, int32_t y,
                                      int32_t n)
{
    const char *s = ntp__at(&j->src, x, y);
    char *d = ntp__at_mut(j->dst, x, y);
    const bool suspect = ntp__any_suspect(block, n, j->m);
    if (!suspect && j->src.channels == 3 && j->src.encoding != NTP_ENCODING_XY)
        return;
    for (int32_t i = 0; i < n; i++, s += j->src.pixel_stride, d += j->dst->pixel_stride) {
        const bool unused = suspect && ntp__texel_unused(block, i, j->m, 0);
        for (int32_t k = unused                               ? 0
                         : j->src.encoding == NTP_ENCODING_XY ? 2
                                                              : 3;
             k < j->src.channels; k++)
            memcpy(d + k * 4, s + k * 4, 4);
    }
}

#ifdef NTP_HAVE_AVX2
/* Are levels only moved and turned, to packed RGB or RGBA, with AVX2? */
static bool is_plain(const job *j)
{
    return !j->stronger && j->src.channels >= 3 && j->src.type != NTP_TYPE_F32 &&
           j->src.encoding != NTP_ENCODING_XY && j->dst->pixel_stride == texel_size(j) &&
           ntp__cpu_has_avx2(NTP__CPU_ALL);
}

/* Packed RGB or RGBA that is only turned; false: there is another way only. */
static bool turn_packed(const job *j, int32_t x, int32_t y, int32_t n)
{
    const bool deep = j->src.type == NTP_TYPE_U16, alpha = j->src.channels == 4;
    const void *const s = ntp__at(&j->src, x, y);
    void *const d = ntp__at_mut(j->dst, x, y);
    if (!is_plain(j) || !ntp__is_packed(&j->src) || (alpha && j->swap))
        return false;
    if (j->swap)
        ntp__turn_rgb_avx2(d, s, n, deep, true, j->mirror_r, j->mirror_g);
    else
        (alpha ? ntp__mirror_rgba_avx2 : ntp__mirror_rgb_avx2)(d, s, n, deep, j->mirror_r,
                                                               j->mirror_g);
    return true;
}

static void strengthen_left(const void *job_, ntp__block *block, ntp__block *detail, int32_t n)
{
    (void) detail;
    strengthen(job_, block, n);
}

/* The same of packed RGB that is made stronger, up to column x1. */
static bool strengthen_packed(const job *j, int32_t x0, int32_t x1, int32_t y)
{
    const ntp__mixing how = { .dst = j->dst,
                              .base = &j->src,
                              .strength = ntp__strength_value(&j->strength),
                              .swap = j->swap,
                              .mirror_x = j->mirror_r,
                              .mirror_y = j->mirror_g,
                              .settle = strengthen_left,
                              .job = j };
    if (j->stronger && ntp__can_mix(&j->src) && j->dst->pixel_stride == j->src.pixel_stride &&
        how.strength >= 0x1p-10 && how.strength <= 0x1p10 && ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__mix_row_avx2(&how, x0, x1, y);
        return true;
    }
    return false;
}
#else
#  define turn_packed(j, x, y, n)         false
#  define strengthen_packed(j, x0, x1, y) false
#endif

static void transform_run(const job *j, int32_t x, int32_t y, int32_t n);

/* Transforms a run from texels that lie packed elsewhere. */
static void transform_moved(const job *j, const void *texels, int32_t x, int32_t y, int32_t n)
{
    job moved = *j;
    ntp_image row = *j->dst;
    row.ring_rows = moved.src.ring_rows = 0;
    row.data = ntp__at_mut(j->dst, x, y);
    moved.dst = &row;
    moved.src.data = texels;
    moved.src.pixel_stride = texel_size(j);
    transform_run(&moved, 0, 0, n);
}

#ifdef NTP_HAVE_AVX2
/* The same of texels that lie packed in the other order; false: there is another way only. */
static bool transform_reversed(const job *j, int32_t x, int32_t y, int32_t n)
{
    enum { AFTER = 16 };
    const ptrdiff_t size = texel_size(j);
    uint32_t texels[(NTP__BLOCK * WIDE + AFTER) / 4];
    if (j->src.pixel_stride == -size && size > LEAST && size <= WIDE &&
        ntp__cpu_has_avx2(NTP__CPU_ALL)) {
        ntp__reverse_avx2(texels, ntp__at(&j->src, x + n - 1, y), n, (int32_t) size);
        transform_moved(j, texels, x, y, n);
        return true;
    }
    return false;
}
#else
#  define transform_reversed(j, x, y, n) false
#endif

static void transform_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block block;
    if (transform_reversed(j, x, y, n) || turn_packed(j, x, y, n) ||
        strengthen_packed(j, x, x + n, y))
        return;
    const bool floats = j->src.type == NTP_TYPE_F32;
    if (floats && !j->stronger) {
        const ntp__turning how = { j->swap, j->mirror_r, j->mirror_g };
        ntp__turn_floats(j->dst, &j->src, &how, x, y, n);
        return;
    }
    ntp__unpack(&block, &j->src, x, y, n);
    ntp__block before;
    if (floats)
        before = block;
    (j->stronger ? strengthen : turn_block)(j, &block, n);
    ntp__store_levels(j->dst, &block, x, y, n);
    if (floats)
        keep_unused_floats(j, &before, x, y, n);
}

/* Copies texels of the turned source side by side, for which its own rows are read one by one.
 * `pitch` bytes lie between rows of the tile. */
static void turn_texels(char *tile, ptrdiff_t pitch, const ntp_const_image *src,
                        const ntp_rect *part, size_t size)
{
    enum { EDGE = (WIDE - 1) / LEAST };
    const ptrdiff_t step = src->row_stride;
    const int32_t height = part->y1 - part->y0;
    /* Texels that lie apart are not asked for. */
    const ptrdiff_t apart = step < 0 ? -step : step;
    const ptrdiff_t bytes = apart < LINE ? apart * height : 0;
    for (int32_t x = part->x0; x < part->x1; x++, tile += size) {
        const char *s = ntp__at(src, x, part->y0);
        const char *ahead = (step < 0 ? s + step * height : s) + AHEAD * src->pixel_stride;
        int32_t y = 0;
        for (ptrdiff_t k = 0; k < bytes; k += LINE)
            FETCH(ahead + k);
        for (; y < height && (y < EDGE || size > WIDE); y++)
            memcpy(tile + y * pitch, s + y * step, size);
        /* A constant size is a load and a store, which is quicker: what is too much belongs to a
         * neighbor, or is overwritten. */
        for (; y < height - EDGE; y++)
            memcpy(tile + y * pitch, s + y * step, WIDE);
        for (; y < height; y++)
            memcpy(tile + y * pitch, s + y * step, size);
    }
}

#ifdef NTP_HAVE_AVX2
/* Copies a row of a tile.  Whole lines go past the caches of a large result: rows of a tile lie far
 * apart, so no processor sees in time that it has not to read what they overwrite. */
static void put_row(char *d, const char *s, size_t n, bool large)
{
    enum { LANE = 16 };
    const size_t before = (size_t) (-(uintptr_t) d % LINE);
    size_t i = large && before < n ? before : n;
    memcpy(d, s, i);
    for (; i + LINE <= n; i += LINE) {
        for (size_t k = i; k < i + LINE; k += LANE)
            _mm_stream_si128((void *) (d + k), _mm_loadu_si128((const void *) (s + k)));
    }
    if (i < n)
        memcpy(d + i, s + i, n - i);
}

/* A part of packed RGB that is only turned; false: there is another way only. */
static bool turn_tile_packed(const job *j, const ntp_rect *part, char *tile, ptrdiff_t pitch)
{
    enum { CELL = 8 };
    const int32_t width = part->x1 - part->x0, height = part->y1 - part->y0;
    const ptrdiff_t size = 3 * ntp__sample_size(j->src.type), step = j->src.row_stride;
    if (!is_plain(j) || j->src.channels != 3 || (step != size && step != -size) || width < CELL ||
        height < CELL)
        return false;
    /* Where texels come from right to left, rows of the result are made from below. */
    const bool back = step < 0;
    ntp__turn_tile_avx2((uint8_t *) tile + (back ? (height - 1) * pitch : 0), back ? -pitch : pitch,
                        ntp__at(&j->src, part->x0, back ? part->y1 - 1 : part->y0),
                        j->src.pixel_stride, width, height, j->src.type == NTP_TYPE_U16,
                        j->mirror_r, j->mirror_g);
    const bool large = j->dst->ring_rows == 0 && size * j->dst->width >= LARGE / j->dst->height;
    for (int32_t y = part->y0; y < part->y1; y++, tile += pitch)
        put_row(ntp__at_mut(j->dst, part->x0, y), tile, (size_t) (size * width), large);
    _mm_sfence();
    return true;
}
#else
#  define turn_tile_packed(j, part, tile, pitch) false
#endif

/* A part of the result that is columns of the source. */
static void transform_tile(const job *j, const ntp_rect *part)
{
    uint32_t tile[TILE_BYTES / 4];
    char *bytes = (char *) tile;
    const int32_t width = part->x1 - part->x0;
    const ptrdiff_t size = texel_size(j), pitch = size * width + BEYOND;
    if (turn_tile_packed(j, part, bytes, pitch))
        return;
    turn_texels(bytes, pitch, &j->src, part, (size_t) size);
    for (int32_t y = part->y0; y < part->y1; y++, bytes += pitch)
        transform_moved(j, bytes, part->x0, y, width);
}

/* In the order of the columns of the source: what a processor reads ahead of a row is soon of use. */
static void transform_tiles(const job *j, const ntp_rect *rect)
{
    const ptrdiff_t size = texel_size(j);
    const int32_t rows = (int32_t) (TILE_BYTES / (COLUMNS * size + BEYOND));
    for (int32_t done = 0, height = rect->y1 - rect->y0; done < height; done += rows) {
        const int32_t n = height - done < rows ? height - done : rows;
        const int32_t y = j->src.row_stride < 0 ? rect->y1 - done - n : rect->y0 + done;
        for (int32_t x = rect->x0; x < rect->x1; x += COLUMNS) {
            const ntp_rect part = { x, y, rect->x1 - x < COLUMNS ? rect->x1 : x + COLUMNS, y + n };
            transform_tile(j, &part);
        }
    }
}

static bool angle_is_good(double angle)
{
    return angle >= -NTP_MAX_ANGLE && angle <= NTP_MAX_ANGLE;
}

int32_t ntp_quarter_turns(double angle)
{
    const int64_t ticks = angle_is_good(angle) ? ntp__ticks_of(angle, 0) : 1;
    return ticks % ntp__quarter() == 0 ? (int32_t) (ticks / ntp__quarter()) : -1;
}

static bool border_is_good(ntp_border border)
{
    return (int) border >= NTP_BORDER_WRAP && (int) border <= NTP_BORDER_MIRROR;
}

ntp_status ntp_transform(const ntp_image *dst, const ntp_const_image *src,
                         const ntp_transform_options *how, const ntp_rect *area)
{
    static const ntp_transform_options NOTHING;
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    if (how == NULL)
        how = &NOTHING;
    ntp_const_image target = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_normals(&target));
    job j = { .dst = dst, .src = *src, .m = ntp__max(src->type) };
    if (how->quarter_turns < 0 || how->quarter_turns > 3 || !angle_is_good(how->angle) ||
        !border_is_good(how->border_x) || !border_is_good(how->border_y) ||
        how->touch_unused > NTP_UNUSED_ALL ||
        !ntp__strength_of(&j.strength, how->use_strength ? how->strength : 1.0))
        return NTP_ERR_ARGUMENT;
    const int64_t ticks = ntp__ticks_of(how->angle, how->quarter_turns);
    const int32_t quarters = (int32_t) (ticks / ntp__quarter());
    const bool resamples = ticks % ntp__quarter() != 0;
    if (src->ring_rows > 0 && (how->flip_y || ticks != 0))
        return NTP_ERR_SHAPE;
    if (!resamples)
        move(&j, how, quarters);
    if (!ntp__same_size(&target, &j.src) && !(resamples && how->part != NULL))
        return NTP_ERR_SHAPE;
    if (dst->type != src->type || dst->encoding != src->encoding ||
        dst->channels != src->channels || dst->y != src->y)
        return NTP_ERR_FORMAT;
    if (dst->data == src->data)
        return NTP_ERR_OVERLAP;
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, &target, area));
    if (resamples) {
        ntp__rotate(dst, src, how, j.strength, ticks, &rect);
        return NTP_OK;
    }
    if (j.swap) {
        transform_tiles(&j, &rect);
        return NTP_OK;
    }
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        if (strengthen_packed(&j, rect.x0, rect.x1, y))
            continue;
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            const int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            /* Rows or texels in the other order are nothing that processors foresee. */
            const ptrdiff_t step = j.src.pixel_stride, bytes = (step < 0 ? -step : step) * n;
            const char *const s = ntp__at(&j.src, step < 0 ? x + n - 1 : x, y);
            for (ptrdiff_t k = 0; k < bytes; k += LINE)
                FETCH(s + j.src.row_stride + k);
            transform_run(&j, x, y, n);
        }
    }
    return NTP_OK;
}
