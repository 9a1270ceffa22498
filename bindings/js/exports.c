// SPDX-License-Identifier: MIT
/*
 * exports.c - what the WebAssembly module exports: libntp with plain numbers as arguments
 *
 * JavaScript sees no struct.  A picture is an address, its size, its channels and its type, packed;
 * numbers that come back are written into arrays of double, in the order that ntp_js_fact_names gives.
 * Every function returns an ntp_status unless it says otherwise.  The module has no state but its
 * heap, and imports nothing.
 */
#include "exports.h"

enum {
    ALIGNMENT = 64,
    LEAST_GREEN = 6 /* texels of a side; below, no texel says which way green points */
};

/* ---------------------------------------------------------------------------- memory */

/* Zero-filled memory; 0 where there is none left. */
EXPORT(allocate) void *ntp_js_allocate(size_t size)
{
    const size_t rounded = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    void *memory = rounded < size ? NULL : aligned_alloc(ALIGNMENT, rounded + ALIGNMENT);

    if (memory != NULL)
        memset(memory, 0, rounded);
    return memory;
}

EXPORT(release) void ntp_js_release(void *memory)
{
    free(memory);
}

EXPORT(version) uint32_t ntp_js_version(void)
{
    return ntp_version();
}

EXPORT(statusText) const char *ntp_js_status_text(int32_t status)
{
    return ntp_status_string((ntp_status) status);
}

/* ------------------------------------------------------------------- what a texture is */

static uint64_t used_xy_too_long(const ntp_stats *stats)
{
    return stats->xy_too_long - stats->unused_xy_too_long - stats->padding;
}

/* Used texels but padding that do not pass, as `ntp check` counts them. */
static double failing(const ntp_stats *stats, uint64_t pass, uint64_t unused_pass,
                      ntp_encoding encoding)
{
    const uint64_t all = stats->texels - pass;
    const uint64_t left_out = stats->unused - unused_pass + stats->padding;

    if (encoding == NTP_ENCODING_XY)
        return (double) used_xy_too_long(stats);
    return all > left_out ? (double) (all - left_out) : 0;
}

/* The numbers of `check`: name in JavaScript, value. */
#define FACTS(FACT)                                                                                \
    FACT(type, (double) found.type)                                                                \
    FACT(confidence, found.confidence)                                                             \
    FACT(accidents, (double) found.accidents)                                                      \
    FACT(reasonCount, (double) found.reason_count)                                                 \
    FACT(method, (double) method)                                                                  \
    FACT(encoding, (double) encoding)                                                              \
    FACT(texels, (double) stats.texels)                                                            \
    FACT(unused, (double) stats.unused)                                                            \
    FACT(black, (double) stats.black)                                                              \
    FACT(white, (double) stats.white)                                                              \
    FACT(transparent, (double) stats.transparent)                                                  \
    FACT(padding, (double) stats.padding)                                                          \
    FACT(notFinite, (double) stats.not_finite)                                                     \
    FACT(max, (double) stats.max)                                                                  \
    FACT(xyTooLong, (double) used_xy_too_long(&stats))                                             \
    FACT(zNegative,                                                                                \
         (double) (stats.z_negative - stats.unused_z_negative - stats.padding_z_negative))         \
    FACT(failNeighbor, failing(&stats, fit->neighbor, fit->unused_neighbor, encoding))             \
    FACT(failRounded, failing(&stats, fit->rounded, fit->unused_rounded, encoding))                \
    FACT(failExact, failing(&stats, fit->exact, fit->unused_exact, encoding))                      \
    FACT(lengthMin, fit->length_min)                                                               \
    FACT(lengthMean, fit->length_mean)                                                             \
    FACT(lengthMax, fit->length_max)                                                               \
    FACT(angleMean, stats.angles.mean)                                                             \
    FACT(angleP99, stats.angles.p99)                                                               \
    FACT(angleMax, stats.angles.max)                                                               \
    FACT(harmTexels, (double) harm.texels)                                                         \
    FACT(harmMean, harm.mean)                                                                      \
    FACT(harmP99, harm.p99)                                                                        \
    FACT(harmMax, harm.max)                                                                        \
    FACT(greenDecided, (double) green.decided)                                                     \
    FACT(greenY, (double) green.y)                                                                 \
    FACT(greenConfidence, green.confidence)

#define NAME(name, value) #name " "

/* The names of the numbers that `check` writes, in order, each followed by a space. */
EXPORT(factNames) const char *ntp_js_fact_names(void)
{
    return FACTS(NAME);
}

/* How a class is read; those that are no normals as standard. */
static ntp_encoding encoding_of(ntp_class type)
{
    if (type == NTP_CLASS_ZZERO)
        return NTP_ENCODING_ZZERO;
    return type == NTP_CLASS_XY ? NTP_ENCODING_XY : NTP_ENCODING_STANDARD;
}

static int32_t least_side(const picture *p)
{
    return p->width < p->height ? p->width : p->height;
}

static ntp_status find_green(ntp_orientation_result *green, const ntp_const_image *view,
                             uint32_t touch_unused)
{
    ntp_orientation *sums = ntp_js_allocate(ntp_orientation_size());
    ntp_status status = NTP_ERR_SCRATCH;

    if (sums != NULL)
        status = ntp_orientation_add(sums, view, touch_unused, 0, NULL);
    if (status == NTP_OK)
        status = ntp_orientation_summarize(green, sums);
    free(sums);
    return status;
}

/* Counts a picture again where its encoding decides its angles. */
static ntp_status count(ntp_tally *tally, ntp_const_image *view, ntp_encoding encoding,
                        uint32_t touch_unused)
{
    const ntp_status status = ntp_tally_clear(tally);

    view->encoding = encoding;
    return status == NTP_OK ? ntp_tally_add(tally, view, touch_unused, NULL) : status;
}

/*
 * Measures p.  p->encoding AUTO: as the texels tell.  Writes the numbers of ntp_js_fact_names to
 * `facts`, and the reasons, each ended by a line feed, to `text` of `size` bytes: first those of the
 * class, then that of the method.
 */
EXPORT(check)
ntp_status ntp_js_check(double *facts, char *text, size_t size, const picture *p,
                        uint32_t touch_unused, int32_t lossy)
{
    const int colors = p->channels >= 3;
    ntp_tally *tally = ntp_js_allocate(ntp_tally_size());
    ntp_const_image view = const_view_of(p);
    ntp_classification found = { 0 };
    ntp_clean_method method = NTP_CLEAN_DERIVE;
    ntp_encoding encoding = (ntp_encoding) p->encoding;
    ntp_orientation_result green = { 0 };
    ntp_reason why = { 0 };
    ntp_stats stats = { 0 };
    ntp_harm harm = { 0 };
    const ntp_fit *fit = &stats.standard;
    ntp_status status = tally == NULL ? NTP_ERR_SCRATCH : NTP_OK;

    if (status == NTP_OK)
        status =
            count(tally, &view, colors ? NTP_ENCODING_STANDARD : NTP_ENCODING_HEIGHT, touch_unused);
    if (status == NTP_OK)
        status = ntp_classify(&found, tally);
    if (p->encoding == AUTO)
        encoding = encoding_of(found.type);
    if (status == NTP_OK && encoding != view.encoding && p->channels >= 2)
        status = count(tally, &view, encoding, touch_unused);
    if (encoding == NTP_ENCODING_VECTOR)
        encoding = NTP_ENCODING_STANDARD;
    if (status == NTP_OK)
        status = ntp_tally_summarize(&stats, tally, encoding);
    if (status == NTP_OK)
        status = ntp_tally_harm(&harm, tally, encoding,
                                encoding == NTP_ENCODING_XY ? NTP_HARM_XY : NTP_HARM_ALL, 0);
    if (status == NTP_OK)
        status = ntp_choose_method(&method, &why, tally, encoding, lossy);
    if (status == NTP_OK && p->channels >= 2 && least_side(p) >= LEAST_GREEN)
        status = find_green(&green, &view, touch_unused);
    free(tally);
    if (status != NTP_OK)
        return status;
    if (encoding == NTP_ENCODING_ZZERO)
        fit = &stats.zzero;
    for (int i = 0; i <= found.reason_count; i++) {
        const ntp_reason *reason = i < found.reason_count ? &found.reasons[i] : &why;
        const size_t length = ntp_reason_text(text, size, reason);

        if (length + 1 >= size)
            return NTP_ERR_SCRATCH;
        text[length] = '\n';
        text[length + 1] = '\0';
        text += length + 1;
        size -= length + 1;
    }
#define WRITE(name, value) *facts++ = (value);
    FACTS(WRITE)
    return NTP_OK;
}

EXPORT(validate)
ntp_status ntp_js_validate(uint8_t *flags, const picture *p, int32_t keep_negative_z)
{
    const ntp_const_image src = const_view_of(p);
    const ntp_image mask = ntp_image_packed(flags, p->width, p->height, 1, NTP_TYPE_U8);

    return ntp_validate(&mask, &src, keep_negative_z, NULL);
}

/* ----------------------------------------------------------------------------- repairs */

/* counts: changed, not finite. */
EXPORT(clean)
ntp_status ntp_js_clean(double *counts, const picture *to, const picture *p, int32_t method,
                        int32_t verdict, int32_t only_failing, int32_t keep_negative_z,
                        uint32_t touch_unused)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);
    const ntp_clean_options how = { .method = (ntp_clean_method) method,
                                    .keep_negative_z = keep_negative_z,
                                    .only_failing = only_failing,
                                    .verdict = (ntp_verdict) verdict,
                                    .touch_unused = touch_unused };
    ntp_clean_counts done = { 0 };
    ntp_clean_plan *plan = NULL;
    void *memory = NULL;
    ntp_status status = NTP_OK;

    if (src.type == NTP_TYPE_U8) {
        memory = ntp_js_allocate(ntp_clean_plan_size());
        status = ntp_clean_plan_init(&plan, memory, ntp_clean_plan_size(), src.encoding, &how);
    }
    if (status == NTP_OK)
        status = ntp_clean(&dst, &src, &how, plan, &done, NULL);
    free(memory);
    counts[0] = (double) done.changed;
    counts[1] = (double) done.not_finite;
    return status;
}

/* counts: z negative, not finite, pulled. */
EXPORT(convert)
ntp_status ntp_js_convert(double *counts, const picture *to, const picture *p, int32_t blue,
                          uint32_t touch_unused)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);
    const ntp_convert_options how = { .blue = (ntp_blue) blue, .touch_unused = touch_unused };
    ntp_convert_counts done = { 0 };
    const ntp_status status = ntp_convert(&dst, &src, &how, &done, NULL);

    counts[0] = (double) done.z_negative;
    counts[1] = (double) done.not_finite;
    counts[2] = (double) done.pulled;
    return status;
}

/* ---------------------------------------------------------------------------- pictures */

EXPORT(heatmap)
ntp_status ntp_js_heatmap(const picture *to, const picture *p, int32_t palette,
                          uint32_t touch_unused)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);

    return ntp_heatmap(&dst, &src, (ntp_palette) palette, touch_unused, NULL);
}

EXPORT(shade)
ntp_status ntp_js_shade(const picture *to, const picture *p, double x, double y, double z,
                        double ambient, double diffuse, double specular, double color)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);
    const ntp_light light = { .direction = { x, y, z },
                              .ambient = ambient,
                              .diffuse = diffuse,
                              .specular = specular,
                              .color = { color, color, color } };

    return ntp_shade(&dst, &src, &light, NULL);
}

/* ------------------------------------------------------------------------- new shapes */

EXPORT(resize)
ntp_status ntp_js_resize(const picture *to, const picture *p, int32_t filter, int32_t border_x,
                         int32_t border_y, uint32_t touch_unused)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);
    const ntp_resize_options how = { .filter = (ntp_filter) filter,
                                     .border_x = (ntp_border) border_x,
                                     .border_y = (ntp_border) border_y,
                                     .touch_unused = touch_unused };
    const size_t size = ntp_resize_plan_size(&how, p->width, p->height, to->width, to->height);
    void *memory = size == 0 ? NULL : ntp_js_allocate(size);
    void *scratch = NULL;
    ntp_resize_plan *plan = NULL;
    ntp_status status = NTP_ERR_ARGUMENT;

    if (memory != NULL)
        status = ntp_resize_plan_init(&plan, memory, size, &how, p->width, p->height, to->width,
                                      to->height);
    if (status == NTP_OK) {
        scratch = ntp_js_allocate(ntp_resize_scratch_size(plan));
        status = ntp_resize(&dst, &src, plan, scratch, ntp_resize_scratch_size(plan), NULL);
    }
    free(scratch);
    free(memory);
    return status;
}

EXPORT(transform)
ntp_status ntp_js_transform(const picture *to, const picture *p, int32_t flip_x, int32_t flip_y,
                            double angle, double strength, int32_t border_x, int32_t border_y,
                            uint32_t touch_unused)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image src = const_view_of(p);
    const int32_t turns = ntp_quarter_turns(angle);
    const ntp_transform_options how = { .flip_x = flip_x,
                                        .flip_y = flip_y,
                                        .quarter_turns = turns < 0 ? 0 : turns,
                                        .angle = turns < 0 ? angle : 0,
                                        .use_strength = strength != 1,
                                        .strength = strength,
                                        .border_x = (ntp_border) border_x,
                                        .border_y = (ntp_border) border_y,
                                        .touch_unused = touch_unused };

    return ntp_transform(&dst, &src, &how, NULL);
}

EXPORT(blend)
ntp_status ntp_js_blend(const picture *to, const picture *base, const picture *detail, int32_t mode,
                        double strength, int32_t detail_alpha, uint32_t touch_unused)
{
    const ntp_image dst = view_of(to);
    const ntp_const_image first = const_view_of(base);
    const ntp_const_image second = const_view_of(detail);
    const ntp_blend_options how = { .mode = (ntp_blend_mode) mode,
                                    .use_strength = strength != 1,
                                    .strength = strength,
                                    .touch_unused = touch_unused,
                                    .detail_alpha = detail_alpha };

    return ntp_blend(&dst, &first, &second, &how, NULL);
}
