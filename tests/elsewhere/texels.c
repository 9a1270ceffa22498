/* SPDX-License-Identifier: MIT */
/* texels.c - sums of what looks at texels: every triplet of 8 bits, counts, pictures, detection. */
#include "sums.h"

#include <stdlib.h>

enum { ROW = 4096 }; /* triplets at a time */

/* ---------------------------------------------------------------------- every triplet */

/* One row of triplets: red is `row / 16`, green and blue go through 16 x 256 values. */
static ntp_image triplets(int row, ntp_encoding encoding)
{
    static uint8_t texels[3 * ROW];
    ntp_image image = ntp_image_packed(texels, ROW, 1, 3, NTP_TYPE_U8);
    image.encoding = encoding;
    for (int i = 0; i < ROW; i++) {
        texels[3 * i] = (uint8_t) (row / 16);
        texels[3 * i + 1] = (uint8_t) (row % 16 * 16 + i / 256);
        texels[3 * i + 2] = (uint8_t) (i % 256);
    }
    return image;
}

typedef uint64_t of_row(uint64_t hash, const ntp_const_image *row);

static uint64_t every_triplet(of_row *operation)
{
    uint64_t hash = seed;
    for (int e = NTP_ENCODING_STANDARD; e <= NTP_ENCODING_ZZERO; e++) {
        for (int row = 0; row < ROW; row += share) {
            const ntp_image image = triplets(row, (ntp_encoding) e);
            const ntp_const_image src = ntp_image_as_const(&image);
            hash = operation(hash, &src);
        }
    }
    return hash;
}

static uint64_t validate_row(uint64_t hash, const ntp_const_image *src)
{
    static uint8_t flags[ROW];
    const ntp_image mask = ntp_image_packed(flags, ROW, 1, 1, NTP_TYPE_U8);
    OK(ntp_validate(&mask, src, 0, NULL));
    return hash_image(hash, &mask);
}

static uint64_t clean_row(uint64_t hash, const ntp_const_image *src)
{
    static uint8_t texels[3 * ROW];
    ntp_image out = ntp_image_packed(texels, ROW, 1, 3, NTP_TYPE_U8);
    out.encoding = src->encoding;
    for (int method = NTP_CLEAN_DERIVE; method <= NTP_CLEAN_NORMALIZE; method++) {
        const ntp_clean_options how = { .method = (ntp_clean_method) method };
        OK(ntp_clean(&out, src, &how, NULL, NULL, NULL));
        hash = hash_image(hash, &out);
    }
    return hash;
}

static uint64_t convert_row(uint64_t hash, const ntp_const_image *src)
{
    static uint16_t texels[3 * ROW];
    static float vectors[3 * ROW];
    ntp_image deep = ntp_image_packed(texels, ROW, 1, 3, NTP_TYPE_U16);
    ntp_image vector = ntp_image_packed(vectors, ROW, 1, 3, NTP_TYPE_F32);
    deep.encoding = src->encoding;
    vector.encoding = NTP_ENCODING_VECTOR;
    OK(ntp_convert(&deep, src, NULL, NULL, NULL));
    OK(ntp_convert(&vector, src, NULL, NULL, NULL));
    return hash_image(hash_image(hash, &deep), &vector);
}

uint64_t validate(ntp_type type)
{
    (void) type;
    return every_triplet(validate_row);
}

uint64_t clean(ntp_type type)
{
    (void) type;
    return every_triplet(clean_row);
}

uint64_t convert(ntp_type type)
{
    (void) type;
    return every_triplet(convert_row);
}

/* 16 bit and floats: what of them depends on the processor is not in the loops over 8 bits. */
uint64_t clean_picture(ntp_type type)
{
    static const ntp_encoding encodings[] = { NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO,
                                              NTP_ENCODING_VECTOR };
    uint64_t hash = seed;
    for (int e = 0; e < (type == NTP_TYPE_F32 ? 3 : 2); e++) {
        ntp_image image = make_damaged(WIDE, HIGH, type, encodings[e], 4);
        const ntp_const_image src = ntp_image_as_const(&image);
        ntp_image other = picture(WIDE, HIGH, 4, type == NTP_TYPE_U8 ? NTP_TYPE_U16 : NTP_TYPE_U8,
                                  NTP_ENCODING_ZZERO);
        for (int method = NTP_CLEAN_DERIVE; method <= NTP_CLEAN_KEEP; method++) {
            const ntp_clean_options how = { .method = (ntp_clean_method) method };
            ntp_image out = picture(WIDE, HIGH, 4, type, encodings[e]);
            OK(ntp_clean(&out, &src, &how, NULL, NULL, NULL));
            hash = hash_image(hash, &out);
            free(out.data);
        }
        OK(ntp_convert(&other, &src, NULL, NULL, NULL));
        hash = hash_image(hash, &other);
        free(other.data);
        free(image.data);
    }
    return hash;
}

/* ------------------------------------------------------------------- what is measured */

uint64_t inspect(ntp_type type)
{
    ntp_image image = make_damaged(NARROW, LOW, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    uint64_t hash = seed;
    for (int i = 0; i < NARROW * LOW; i++) {
        ntp_texel texel;
        OK(ntp_inspect(&texel, &src, i % NARROW, i / NARROW, i % 2));
        hash = hash_number(hash, texel.cleaned[0] + ((uint64_t) texel.cleaned[2] << 32));
        hash = hash_number(hash, texel.flags + ((uint64_t) texel.cleaned[1] << 32));
        hash = hash_double(hash_double(hash, texel.length), texel.angle);
    }
    free(image.data);
    return hash;
}

static uint64_t hash_stats(uint64_t hash, const ntp_stats *stats)
{
    hash = hash_number(hash, stats->texels + stats->unused + stats->xy_too_long);
    hash = hash_number(hash, stats->z_negative);
    hash = hash_number(hash, stats->standard.neighbor);
    hash = hash_number(hash, stats->standard.exact);
    hash = hash_number(hash, stats->zzero.rounded);
    hash = hash_double(hash, stats->angles.mean);
    hash = hash_double(hash, stats->angles.p99);
    hash = hash_double(hash, stats->angles.max);
    hash = hash_double(hash, stats->standard.length_mean);
    return hash_double(hash, stats->used_mean[1]);
}

uint64_t measure(ntp_type type)
{
    ntp_image image = make_damaged(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 4);
    const ntp_const_image src = ntp_image_as_const(&image);
    ntp_tally *tally = reserve(ntp_tally_size());
    uint64_t lengths[256], hash;
    ntp_classification found;
    ntp_clean_method method;
    ntp_stats stats;
    ntp_harm harm;
    OK(ntp_tally_add(tally, &src, 0, NULL));
    OK(ntp_tally_summarize(&stats, tally, NTP_ENCODING_STANDARD));
    OK(ntp_tally_harm(&harm, tally, NTP_ENCODING_STANDARD, NTP_HARM_ALL, 1));
    OK(ntp_tally_lengths(lengths, tally, NTP_ENCODING_STANDARD));
    OK(ntp_classify(&found, tally));
    OK(ntp_choose_method(&method, NULL, tally, NTP_ENCODING_STANDARD, 0));
    hash = hash_double(hash_stats(seed, &stats), harm.mean);
    for (int i = 0; i < 256; i++)
        hash = hash_number(hash, lengths[i]);
    hash = hash_double(hash, found.confidence);
    hash = hash_number(hash, (uint64_t) found.type + found.accidents * 16 + (uint64_t) method * 8);
    for (int i = 0; i < found.reason_count; i++)
        hash = hash_double(hash, found.reasons[i].value);
    free(tally);
    free(image.data);
    return hash;
}

uint64_t levels_off(ntp_type type)
{
    ntp_image image = make_damaged(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    ntp_tally *tally = reserve(ntp_tally_size());
    static uint64_t counts[65536];
    uint64_t hash = seed;
    OK(ntp_tally_add(tally, &src, 0, NULL));
    OK(ntp_tally_levels_off(counts, 65536, tally, NTP_ENCODING_STANDARD));
    for (int i = 0; i < 65536; i++)
        hash = hash_number(hash, counts[i]);
    free(tally);
    free(image.data);
    return hash;
}

uint64_t difference(ntp_type type)
{
    ntp_image image = make_normals(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 3);
    ntp_image other = make_damaged(WIDE, HIGH, NTP_TYPE_U16, NTP_ENCODING_ZZERO, 3);
    ntp_image heat = picture(WIDE, HIGH, 3, NTP_TYPE_U8, NTP_ENCODING_HEIGHT);
    const ntp_const_image a = ntp_image_as_const(&image), b = ntp_image_as_const(&other);
    ntp_diff *diff = reserve(ntp_diff_size());
    ntp_diff_stats stats;
    uint64_t hash;
    OK(ntp_diff_add(diff, &heat, &a, &b, NULL));
    OK(ntp_diff_summarize(&stats, diff));
    hash = hash_number(hash_image(seed, &heat), stats.different);
    hash = hash_double(hash_double(hash, stats.angles.mean), stats.angles.max);
    free(diff);
    free(heat.data);
    free(other.data);
    free(image.data);
    return hash_double(hash, stats.levels_mean[2]);
}

uint64_t pictures(ntp_type type)
{
    ntp_image image = make_damaged(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 4);
    ntp_image out = picture(WIDE, HIGH, 3, NTP_TYPE_U8, NTP_ENCODING_HEIGHT);
    const ntp_const_image src = ntp_image_as_const(&image);
    uint64_t hash;
    OK(ntp_heatmap(&out, &src, NTP_PALETTE_REFERENCE, 0, NULL));
    hash = hash_image(seed, &out);
    OK(ntp_heatmap(&out, &src, NTP_PALETTE_SAFE, 0, NULL));
    hash = hash_image(hash, &out);
    OK(ntp_shade(&out, &src, NULL, NULL));
    hash = hash_image(hash, &out);
    free(out.data);
    free(image.data);
    return hash;
}

uint64_t which_way_green(ntp_type type)
{
    ntp_image image = make_normals(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    ntp_orientation *sums = reserve(ntp_orientation_size());
    ntp_orientation_result green;
    OK(ntp_orientation_add(sums, &src, 0, 1, NULL));
    OK(ntp_orientation_summarize(&green, sums));
    free(sums);
    free(image.data);
    return hash_double(hash_double(hash_number(seed, green.loops), green.statistic), green.score);
}

uint64_t find_kernel(ntp_type type)
{
    ntp_image image = make_normals(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    ntp_kernel_fit fit;
    uint64_t hash;
    OK(ntp_find_kernel(&fit, &src, 0));
    hash = hash_number(seed, (uint64_t) fit.kernel);
    for (int k = 0; k < NTP_KERNELS; k++)
        hash = hash_double(hash, fit.misfit[k]);
    free(image.data);
    return hash;
}

uint64_t find_seams(ntp_type type)
{
    ntp_image image = make_damaged(WIDE, HIGH, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    ntp_border x, y;
    ntp_seam seams[2];
    ntp_steps steps;
    uint64_t hash = seed;
    OK(ntp_find_seams(&seams[0], &seams[1], &src, 0));
    for (int i = 0; i < 2; i++)
        hash = hash_double(hash_double(hash, seams[i].closure), seams[i].jump);
    OK(ntp_relief_borders(&x, &y, &src));
    hash = hash_number(hash, (uint64_t) x * 16 + (uint64_t) y);
    OK(ntp_find_steps(&steps, &src, 0));
    free(image.data);
    return hash_double(hash_double(hash, steps.share), steps.slope);
}

uint64_t find_borders(ntp_type type)
{
    static const int32_t open[2] = { 1, 1 }, wraps[2] = { 0, 0 };
    const ntp_height_options how = { .kernel = NTP_KERNEL_SOBEL3 };
    ntp_image image = make_normals(NARROW, LOW, type, NTP_ENCODING_STANDARD, 3);
    const ntp_const_image src = ntp_image_as_const(&image);
    const size_t size = ntp_find_borders_scratch_size(&how, NARROW, LOW, 1);
    void *scratch = reserve(size);
    ntp_border_fit fit[2];
    uint64_t hash = seed;
    OK(ntp_find_borders(fit, &src, &how, open, wraps, scratch, size, NULL));
    for (int i = 0; i < 2; i++) {
        hash = hash_number(hash, (uint64_t) fit[i].border);
        for (int b = 0; b < NTP_BORDERS; b++)
            hash = hash_double(hash, fit[i].error[b]);
    }
    free(scratch);
    free(image.data);
    return hash;
}
