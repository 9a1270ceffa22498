/* SPDX-License-Identifier: MIT */
/*
 * clean.c - repair of normals textures: derive z, or divide by the length
 *
 * This room judges, repairs and converts textures.  No texel of a result depends on another one.
 *   clean.c     ntp_clean: repair; clean_steps_tmpl.h is its part for packed RGB
 *   validate.c  ntp_validate: a byte of flags for each texel
 *   inspect.c   ntp_inspect: everything about one texel
 *   convert.c   ntp_convert: other encodings, depths and Y orientations; with convert.h,
 *               convert_runs.c, convert_avx2.c, convert_words_tmpl.h, convert_packed.c, packed_tmpl.h and to_vectors.c
 *
 * Three ways lead to the same bytes.  Rows of packed 8-bit pixels go through a table, the plan.
 * Pixels whose blue is only derived, or that are divided by their length, go through a kernel, and
 * the few that it leaves are done one by one.  All others are done one by one with the arithmetic of
 * level.h.
 */
#include "base/inlining.h"
#include "base/view.h"
#include "texel/kernels.h"
#include "texel/level.h"
#include "texel/unused.h"

#include <string.h>

struct ntp_clean_plan {
    ntp_encoding encoding;
    ntp_clean_options how;
    uint32_t kept;   /* bits of r | g << 8 | b << 16 that the table does not decide */
    uint32_t usable; /* 0: with these options blue decides too, and the plan is not used */
    uint32_t table[65536];
    uint8_t blue[65536]; /* of pairs that stay as they are, for standard Z; see kernels.h */
};

size_t ntp_clean_plan_size(void)
{
    return sizeof(ntp_clean_plan);
}

static ntp_status check_options(ntp_clean_options *out, const ntp_clean_options *how)
{
    memset(out, 0, sizeof *out);
    if (how == NULL)
        return NTP_OK;
    *out = *how;
    if ((int) how->method < NTP_CLEAN_DERIVE || (int) how->method > NTP_CLEAN_KEEP ||
        (int) how->verdict < NTP_VERDICT_NEIGHBOR || (int) how->verdict > NTP_VERDICT_EXACT ||
        how->touch_unused > NTP_UNUSED_ALL)
        return NTP_ERR_ARGUMENT;
    out->keep_negative_z = how->keep_negative_z != 0;
    out->only_failing = how->only_failing != 0;
    return NTP_OK;
}

/* Do red and green alone decide what a used texel becomes?  Then a table indexed by them is
 * enough. */
static bool table_suffices(ntp_encoding encoding, const ntp_clean_options *how)
{
    if (encoding == NTP_ENCODING_XY)
        return how->method != NTP_CLEAN_KEEP;
    return how->method == NTP_CLEAN_DERIVE && !how->only_failing &&
           !(encoding == NTP_ENCODING_STANDARD && how->keep_negative_z);
}

ntp_status ntp_clean_plan_init(ntp_clean_plan **plan, void *memory, size_t size,
                               ntp_encoding encoding, const ntp_clean_options *how)
{
    ntp_clean_options options;
    if (plan == NULL || (encoding != NTP_ENCODING_STANDARD && encoding != NTP_ENCODING_ZZERO &&
                         encoding != NTP_ENCODING_XY))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(check_options(&options, how));
    if (memory == NULL || (uintptr_t) memory % 16 != 0 || size < sizeof(ntp_clean_plan))
        return NTP_ERR_SCRATCH;

    ntp_clean_plan *p = (ntp_clean_plan *) memory;
    p->encoding = encoding;
    p->how = options;
    p->kept = encoding == NTP_ENCODING_XY ? 0xff0000 : 0;
    p->usable = table_suffices(encoding, &options);
    for (int32_t i = 0; p->usable && i < 65536; i++) {
        int32_t c[3] = { i & 255, i >> 8, 255 };
        ntp__clean(c, 255, encoding, options.method, false);
        bool maybe_unused = i == 0 || i == 65535;
        p->table[i] = (uint32_t) c[0] | (uint32_t) c[1] << 8 | (uint32_t) c[2] << 16 |
                      (maybe_unused ? 0x1000000u : 0);
        bool stays = c[0] == (i & 255) && c[1] == i >> 8 && !maybe_unused;
        p->blue[i] = (uint8_t) (stays ? c[2] : 0);
    }
    *plan = p;
    return NTP_OK;
}

/* What a run of texels needs to know. */
typedef struct job {
    const ntp_image *dst;
    const ntp_const_image *src;
    ntp_clean_options how;
    ntp_encoding encoding; /* NTP_ENCODING_VECTOR is repaired as standard, on the 16-bit grid */
    int32_t m;
    const ntp__kernels_table *kernels;
    bool count; /* whether the caller asks how many texels changed */
} job;

enum {
    FEW = 8,         /* too long pairs of a block: fewer are pulled one by one */
    PULLED = 1 << 16 /* red and green changed too */
};

static void clean_texel(const job *j, int32_t c[4])
{
    if (ntp__unused(c[0], c[1], c[2], c[3], j->m, j->how.touch_unused))
        return;
    if (j->how.only_failing) {
        static const uint32_t PASS[] = { NTP_FLAG_NEIGHBOR, NTP_FLAG_ROUNDED, NTP_FLAG_EXACT };
        bool keep = j->how.keep_negative_z;
        uint32_t flags = ntp__flags(c[0], c[1], c[2], j->m, j->encoding, keep);
        if ((flags & PASS[j->how.verdict]) && (keep || !(flags & NTP_FLAG_Z_NEGATIVE)))
            return;
    }
    ntp__clean(c, j->m, j->encoding, j->how.method, j->how.keep_negative_z);
}

/* One texel of a block; true: it changed. */
static bool clean_at(const job *j, ntp__block *block, int32_t i)
{
    int32_t c[4] = { block->c[0][i], block->c[1][i], block->c[2][i], block->c[3][i] };
    clean_texel(j, c);
    bool changed = c[0] != block->c[0][i] || c[1] != block->c[1][i] || c[2] != block->c[2][i];
    for (int32_t k = 0; k < 3; k++)
        block->c[k][i] = c[k];
    return changed;
}

/* Does the method change nothing in this block?  That of NTP_CLEAN_KEEP only mirrors negative z. */
static bool stays(const job *j, const ntp__block *block, int32_t n)
{
    if (j->how.method != NTP_CLEAN_KEEP)
        return false;
    if (j->how.keep_negative_z || j->encoding != NTP_ENCODING_STANDARD)
        return true;
    int32_t low = 0;
    for (int32_t i = 0; i < n; i++)
        low |= ntp__z_negative(block->c[2][i], j->m);
    return low == 0;
}

/* Texel by texel; returns how many changed.  Broken texels are left to store_floats. */
static uint64_t clean_slowly(const job *j, ntp__block *block, int32_t n)
{
    if (stays(j, block, n))
        return 0;
    uint64_t changed = 0;
    for (int32_t i = 0; i < n; i++) {
        if (!block->any_broken || !block->broken[i])
            changed += clean_at(j, block, i);
    }
    return changed;
}

/* Of XY only pairs that are too long change. */
static uint64_t clean_pairs(const job *j, ntp__block *block, int32_t n)
{
    if (j->how.method == NTP_CLEAN_KEEP)
        return 0;
    int32_t want[NTP__BLOCK];
    uint64_t changed = 0;
    j->kernels->derive(want, block->c[0], block->c[1], n, j->m, false);
    for (int32_t i = 0; i < n; i++) {
        if (want[i] < 0 && !(block->any_broken && block->broken[i]))
            changed += clean_at(j, block, i);
    }
    return changed;
}

/* Levels of pairs that are too long, and doubts about them. */
typedef struct long_pairs {
    int32_t at[NTP__BLOCK], c[3][NTP__BLOCK], doubt[NTP__BLOCK];
} long_pairs;

/* Pulls them, and derives their blues. */
static void pull_pairs(const job *j, long_pairs *p, int32_t count)
{
    for (int32_t i = count; i % NTP__KERNEL_LANES != 0; i++)
        p->c[0][i] = p->c[1][i] = 0;
    j->kernels->pull(p->c[0], p->c[1], p->doubt, count, j->m);
    j->kernels->derive(p->c[2], p->c[0], p->c[1], count, j->m, j->encoding == NTP_ENCODING_ZZERO);
}

/* Pulls used pairs of a block that are too long, and derives their blues.  Where want[i] is still
 * negative, the kernel is in doubt. */
static void pull_long(const job *j, ntp__block *block, int32_t *want, int32_t n, bool suspect)
{
    long_pairs p;
    const int32_t count = j->kernels->find(p.at, want, INT32_MIN, n);
    for (int32_t i = 0; i < count; i++) {
        p.c[0][i] = block->c[0][p.at[i]];
        p.c[1][i] = block->c[1][p.at[i]];
    }
    pull_pairs(j, &p, count);
    for (int32_t i = 0; i < count; i++) {
        const int32_t at = p.at[i];
        if (p.doubt[i] || (suspect && ntp__texel_unused(block, at, j->m, j->how.touch_unused)))
            continue;
        block->c[0][at] = p.c[0][i];
        block->c[1][at] = p.c[1][i];
        want[at] = p.c[2][i] | PULLED;
    }
}

/* Texel i of a block gets the derived blue; true: it changed. */
static inline bool set_blue(ntp__block *block, int32_t i, int32_t want, int32_t m, int32_t low)
{
    const int32_t to = want & ~PULLED, b = block->c[2][i], blue = b <= low ? m - to : to;
    block->c[2][i] = blue;
    return (blue != b) | (want >= PULLED);
}

/* Derives blue with a kernel.  Where few texels are too long, these go one by one, as do those that
 * may be unused. */
static uint64_t clean_by_derivation(const job *j, ntp__block *block, int32_t n)
{
    const bool keep = j->how.keep_negative_z && j->encoding == NTP_ENCODING_STANDARD;
    const int32_t low = keep ? (j->m - 1) / 2 : -1;
    int32_t want[NTP__BLOCK], negative = 0, changed = 0;
    j->kernels->derive(want, block->c[0], block->c[1], n, j->m, j->encoding == NTP_ENCODING_ZZERO);
    for (int32_t i = 0; i < n; i++)
        negative += want[i] < 0;
    /* The pairs of black and white are too long, so unused texels of these colors are among them. */
    const bool suspect = ntp__any_suspect(block, n, j->m);
    if (negative >= FEW) {
        pull_long(j, block, want, n, suspect);
        negative = 0;
        for (int32_t i = 0; i < n; i++)
            negative |= want[i] < 0;
    }
    if (negative == 0 && !suspect) {
        for (int32_t i = 0; i < n; i++)
            changed += set_blue(block, i, want[i], j->m, low);
        return (uint64_t) changed;
    }
    for (int32_t i = 0; i < n; i++) {
        const bool known = want[i] >= (block->c[3][i] == 0 ? PULLED : 0); /* and used */
        changed += known ? set_blue(block, i, want[i], j->m, low) : clean_at(j, block, i);
    }
    return (uint64_t) changed;
}

static int32_t differs(const ntp__block *a, const ntp__block *b, int32_t i)
{
    return (a->c[0][i] != b->c[0][i]) | (a->c[1][i] != b->c[1][i]) | (a->c[2][i] != b->c[2][i]);
}

/* Divides by the length with a kernel, of the standard encoding.  Only texels near a boundary and
 * those that may be unused go one by one. */
static uint64_t clean_by_length(const job *j, ntp__block *out, ntp__block *block, int32_t n)
{
    const int32_t m = j->m, low = j->how.keep_negative_z ? -1 : (m - 1) / 2;
    int32_t changed = 0, doubt[NTP__BLOCK];
    for (int32_t i = n; i % NTP__KERNEL_LANES != 0; i++) { /* flat: these do not change */
        block->c[0][i] = block->c[1][i] = (m + 1) / 2;
        block->c[2][i] = m;
    }
    int32_t any = j->kernels->normalize((int32_t *[]) { out->c[0], out->c[1], out->c[2] }, doubt,
                                        (int32_t *[]) { block->c[0], block->c[1], block->c[2] }, n,
                                        m, low, &changed);
    if (ntp__any_suspect(block, n, m)) {
        for (int32_t i = 0; i < n; i++) {
            if (ntp__texel_unused(block, i, m, j->how.touch_unused))
                any = doubt[i] = 1;
        }
    }
    for (int32_t i = 0; any && i < n; i++) {
        if (!doubt[i])
            continue;
        int32_t c[4] = { block->c[0][i], block->c[1][i], block->c[2][i], block->c[3][i] };
        clean_texel(j, c);
        changed -= differs(out, block, i);
        for (int32_t k = 0; k < 3; k++)
            out->c[k][i] = c[k];
        changed += differs(out, block, i);
    }
    return (uint64_t) changed;
}

#include "repair/clean_steps_tmpl.h"

static bool blue_is_written(const job *j)
{
    return j->encoding != NTP_ENCODING_XY;
}

static void copy_alpha(const job *j, int32_t x, int32_t y, int32_t n)
{
    ptrdiff_t size = ntp__sample_size(j->src->type);
    int32_t first = blue_is_written(j) ? 3 : 2;
    if (j->dst->data == j->src->data || j->src->channels <= first)
        return;
    size_t bytes = (size_t) ((j->src->channels - first) * size);
    const char *s = (const char *) ntp__at(j->src, x, y) + first * size;
    char *d = (char *) ntp__at_mut(j->dst, x, y) + first * size;
    for (int32_t i = 0; i < n; i++, s += j->src->pixel_stride, d += j->dst->pixel_stride)
        memcpy(d, s, bytes);
}

/* Floats: samples whose 16-bit level did not change are copied bit by bit. */
static void store_floats(const job *j, const ntp__block *before, const ntp__block *after, int32_t x,
                         int32_t y, int32_t n, ntp_clean_counts *counts)
{
    bool vector = j->src->encoding == NTP_ENCODING_VECTOR;
    const char *s = ntp__at(j->src, x, y);
    char *d = ntp__at_mut(j->dst, x, y);
    int32_t channels = blue_is_written(j) ? 3 : 2;
    for (int32_t i = 0; i < n; i++, s += j->src->pixel_stride, d += j->dst->pixel_stride) {
        float *out = (float *) (void *) d;
        if (before->any_broken && before->broken[i]) {
            float zero = vector ? 0.0f : 0.5f;
            out[0] = out[1] = zero;
            if (channels == 3)
                out[2] = 1.0f;
            counts->not_finite++;
            counts->changed++;
            continue;
        }
        for (int32_t k = 0; k < channels; k++) {
            int32_t level = after->c[k][i];
            if (level == before->c[k][i])
                memcpy(&out[k], s + k * 4, 4);
            else if (vector)
                out[k] = (float) ((double) (2 * level - 65535) / 65535.0);
            else
                out[k] = (float) ((double) level / 65535.0);
        }
    }
}

/* Up to a block of texels of any kind. */
static void clean_block(const job *j, int32_t x, int32_t y, int32_t n, ntp_clean_counts *counts)
{
    ntp__block block, other, *result = &block;
    ntp__unpack(&block, j->src, x, y, n);
    const bool floats = j->src->type == NTP_TYPE_F32;
    const bool all = !j->how.only_failing && !block.any_broken;
    const bool by_length =
        all && j->how.method == NTP_CLEAN_NORMALIZE && j->encoding == NTP_ENCODING_STANDARD;
    if (floats && !by_length)
        other = block;
    if (!blue_is_written(j))
        counts->changed += clean_pairs(j, &block, n);
    else if (all && j->how.method == NTP_CLEAN_DERIVE)
        counts->changed += clean_by_derivation(j, &block, n);
    else if (by_length)
        counts->changed += clean_by_length(j, result = &other, &block, n);
    else
        counts->changed += clean_slowly(j, &block, n);
    if (floats)
        store_floats(j, by_length ? &block : &other, result, x, y, n, counts);
    else
        ntp__pack(j->dst, result, x, y, n, blue_is_written(j) ? 3 : 2);
    copy_alpha(j, x, y, n);
}

/* Packed colors, for which there may be kernels. */
static bool is_plain(const job *j)
{
    return j->src->channels >= 3 && blue_is_written(j) && !j->how.only_failing &&
           !j->how.keep_negative_z && ntp__is_packed(j->src) &&
           j->dst->pixel_stride == j->src->pixel_stride;
}

/* Packed RGB by a kernel, which stops where a pair is too long.  Returns how many it did. */
static int32_t clean_rgb(const job *j, int32_t x, int32_t n, int32_t y, uint64_t *changed)
{
    void *dst = ntp__at_mut(j->dst, x, y);
    const void *src = ntp__at(j->src, x, y);
    if (j->src->type == NTP_TYPE_U16)
        return j->kernels->clean_rgb16(dst, src, n, j->encoding == NTP_ENCODING_ZZERO, changed);
    return j->kernels->derive_rgb8(dst, src, n, changed);
}

static bool has_kernel(const job *j)
{
    return j->how.method == NTP_CLEAN_DERIVE &&
           (j->src->type == NTP_TYPE_U16 ||
            (j->src->type == NTP_TYPE_U8 && j->encoding == NTP_ENCODING_STANDARD &&
             j->kernels->derive_rgb8 != NULL));
}

static bool has_length_kernel(const job *j)
{
    return j->how.method == NTP_CLEAN_NORMALIZE && j->encoding == NTP_ENCODING_STANDARD &&
           length_kernel(j) != NULL;
}

static void clean_row(const job *j, int32_t x0, int32_t x1, int32_t y, ntp_clean_counts *counts)
{
    const bool rgb = j->src->channels == 3, any = is_plain(j) && (rgb || j->kernels->move_colors);
    const bool by_length = any && has_length_kernel(j), derives = any && has_kernel(j);
    const bool deep = derives && j->src->type == NTP_TYPE_U16 && j->kernels->derive_rgb16 != NULL;
    const bool plain = rgb && derives && !deep, stepped = by_length || deep;
    /* Blocks with pairs that are too long.  Where these come closely, larger ones are done without the
     * kernel. */
    const int32_t least = plain ? NTP__KERNEL_STEP : NTP__BLOCK;
    int32_t most = least;
    for (int32_t x = x0; x < x1;) {
        if (plain) {
            const int32_t done = clean_rgb(j, x, x1 - x, y, j->count ? &counts->changed : NULL);
            x += done;
            most = done >= NTP__KERNEL_STEP ? least : most < NTP__BLOCK ? 2 * most : most;
        }
        int32_t n = x1 - x < most ? x1 - x : most;
        const int32_t steps = stepped ? n / NTP__KERNEL_STEP * NTP__KERNEL_STEP : 0;
        if (steps > 0 && !rgb)
            clean_colors(j, x, y, n = steps, &counts->changed);
        else if (steps > 0)
            clean_steps(j, x, y, n = steps, &counts->changed);
        else if (stepped && rgb)
            clean_last(j, x, y, n, &counts->changed);
        else
            clean_block(j, x, y, n, counts);
        x += n;
    }
}

/* Rows of packed 8-bit pixels through the table. */
static bool clean_by_table(const job *j, const ntp_clean_plan *plan, const ntp_rect *rect,
                           ntp_clean_counts *counts)
{
    if (plan == NULL || !plan->usable || j->src->type != NTP_TYPE_U8 || j->src->channels < 3 ||
        !ntp__is_packed(j->src) || j->dst->pixel_stride != j->src->pixel_stride)
        return false;
    ntp__clean8_fn *clean8 = j->src->channels == 4 ? j->kernels->clean_rgba8
                             : counts != NULL      ? j->kernels->clean_rgb8
                                                   : j->kernels->clean_rgb8_blindly;
    uint64_t changed = 0;
    for (int32_t y = rect->y0; y < rect->y1; y++)
        changed += clean8(ntp__at_mut(j->dst, rect->x0, y), ntp__at(j->src, rect->x0, y),
                          (size_t) (rect->x1 - rect->x0), plan->table,
                          plan->encoding == NTP_ENCODING_STANDARD ? plan->blue : NULL, plan->kept,
                          j->how.touch_unused);
    if (counts != NULL)
        counts->changed += changed;
    return true;
}

static bool same_options(const ntp_clean_options *a, const ntp_clean_options *b)
{
    return a->method == b->method && a->keep_negative_z == b->keep_negative_z &&
           a->only_failing == b->only_failing && a->verdict == b->verdict &&
           a->touch_unused == b->touch_unused;
}

ntp_status ntp_clean(const ntp_image *dst, const ntp_const_image *src, const ntp_clean_options *how,
                     const ntp_clean_plan *plan, ntp_clean_counts *counts, const ntp_rect *area)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image target = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_normals(&target));
    if (!ntp__same_size(&target, src))
        return NTP_ERR_SHAPE;
    if (target.type != src->type || target.encoding != src->encoding ||
        target.channels != src->channels || target.y != src->y)
        return NTP_ERR_FORMAT;
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));

    ntp__kernels_table kernels;
    job j = { .dst = dst, .src = src, .m = ntp__max(src->type), .kernels = &kernels };
    ntp__pick_kernels(&kernels, NTP__CPU_ALL);
    NTP__TRY(check_options(&j.how, how));
    j.count = counts != NULL;
    j.encoding = src->encoding == NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : src->encoding;
    if (plan != NULL && (plan->encoding != j.encoding || !same_options(&plan->how, &j.how)))
        return NTP_ERR_ARGUMENT;

    ntp_clean_counts local = { 0, 0 };
    if (!clean_by_table(&j, plan, &rect, counts)) {
        for (int32_t y = rect.y0; y < rect.y1; y++)
            clean_row(&j, rect.x0, rect.x1, y, &local);
    }
    if (counts != NULL) {
        counts->changed += local.changed;
        counts->not_finite += local.not_finite;
    }
    return NTP_OK;
}
