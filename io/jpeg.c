/* SPDX-License-Identifier: MIT */
/*
 * jpeg.c - JPEG through libjpeg-turbo, read only
 *
 * The accurate integer transform makes the bytes the same everywhere.  Gray and color stay as they
 * are; CMYK is refused.  A warning that means damaged pixels is an error.
 */
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <jerror.h>

#include "formats.h"

enum {
    BUFFER_SIZE = 1 << 14,
    SCANS_MAX = 500, /* of a progressive file; more is an attack on time */
    QUALITY_MAX = 100
};

typedef struct jpeg_state {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_source_mgr source;
    struct jpeg_progress_mgr progress;
    jmp_buf jump;
    ntpio_reader *reader;
    bool created, ended, too_many_scans;
    uint8_t buffer[BUFFER_SIZE];
} jpeg_state;

static jpeg_state *state_of(j_common_ptr jpeg)
{
    return jpeg->client_data;
}

static void on_error(j_common_ptr jpeg)
{
    longjmp(state_of(jpeg)->jump, 1);
}

/* Warnings without damage: junk between segments, markers of odd versions. */
static void on_message(j_common_ptr jpeg, int level)
{
    const int code = jpeg->err->msg_code;
    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_ADOBE_XFORM &&
        code != JWRN_JFIF_MAJOR)
        on_error(jpeg);
}

static void on_output(j_common_ptr jpeg)
{
    (void) jpeg;
}

static void on_progress(j_common_ptr jpeg)
{
    if (jpeg->is_decompressor && ((j_decompress_ptr) jpeg)->input_scan_number > SCANS_MAX) {
        state_of(jpeg)->too_many_scans = true;
        on_error(jpeg);
    }
}

static void on_start(j_decompress_ptr jpeg)
{
    (void) jpeg;
}

static boolean on_fill(j_decompress_ptr jpeg)
{
    jpeg_state *s = state_of((j_common_ptr) jpeg);
    s->source.bytes_in_buffer = ntpio__read(&s->reader->source, s->buffer, BUFFER_SIZE);
    s->source.next_input_byte = s->buffer;
    if (s->source.bytes_in_buffer == 0) {
        s->ended = true;
        on_error((j_common_ptr) jpeg);
    }
    return TRUE;
}

static void on_skip(j_decompress_ptr jpeg, long count)
{
    jpeg_state *s = state_of((j_common_ptr) jpeg);
    while (count > 0 && (size_t) count > s->source.bytes_in_buffer) {
        count -= (long) s->source.bytes_in_buffer;
        on_fill(jpeg);
    }
    if (count > 0) {
        s->source.next_input_byte += count;
        s->source.bytes_in_buffer -= (size_t) count;
    }
}

/* Intact files of a kind that is not read, such as lossless ones or those of 12 bits. */
static bool is_unsupported(int code)
{
    return code == JERR_SOF_UNSUPPORTED || code == JERR_BAD_PRECISION ||
           code == JERR_ARITH_NOTIMPL || code == JERR_CONVERSION_NOTIMPL ||
           code == JERR_FRACT_SAMPLE_NOTIMPL || code == JERR_NOT_COMPILED;
}

static bool fail(jpeg_state *s, ntpio_error *error)
{
    char message[JMSG_LENGTH_MAX];
    const char *name = s->reader->name;
    if (s->ended)
        return ntpio__fail_ended(s->reader, error);
    if (s->too_many_scans)
        return ntpio__fail(error, NTPIO_ERR_LIMIT, name, "more than %d scans", SCANS_MAX);
    if (s->errors.msg_code == JERR_OUT_OF_MEMORY)
        return ntpio__fail_memory(error, name);
    s->errors.format_message((j_common_ptr) &s->jpeg, message);
    if (is_unsupported(s->errors.msg_code))
        return ntpio__fail(error, NTPIO_ERR_FORMAT, name,
                           "a JPEG of a kind that is not read here (%s)", message);
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, name, "damaged (%s)", message);
}

/* The quality of the Independent JPEG Group's scale whose luminance table is nearest. */
static int32_t estimate_quality(const JQUANT_TBL *table)
{
    static const uint8_t standard[DCTSIZE2] = {
        16, 11, 10, 16, 24,  40,  51,  61,  12, 12, 14, 19, 26,  58,  60,  55,
        14, 13, 16, 24, 40,  57,  69,  56,  14, 17, 22, 29, 51,  87,  80,  62,
        18, 22, 37, 56, 68,  109, 103, 77,  24, 35, 55, 64, 81,  104, 113, 92,
        49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99
    };
    long least = 0;
    int32_t best = 0;
    for (int32_t quality = QUALITY_MAX; table != NULL && quality >= 1; quality--) {
        const long scale = quality < 50 ? 5000 / quality : 200 - 2 * quality;
        long difference = 0;
        for (int i = 0; i < DCTSIZE2; i++) {
            long q = (standard[i] * scale + 50) / 100;
            q = q < 1 ? 1 : q > 255 ? 255 : q;
            difference += labs(q - (long) table->quantval[i]);
        }
        if (best == 0 || difference < least) {
            best = quality;
            least = difference;
        }
    }
    return best;
}

static const char icc_name[] = "ICC_PROFILE"; /* its zero included, as in the file */

static bool take_header(jpeg_state *s, ntpio_error *error)
{
    const struct jpeg_decompress_struct *jpeg = &s->jpeg;
    ntpio_reader *reader = s->reader;
    ntpio_info *info = &reader->info;
    info->format = NTPIO_JPEG;
    if (!ntpio__check_size(reader, jpeg->image_width, jpeg->image_height, error))
        return false;
    if (jpeg->jpeg_color_space == JCS_CMYK || jpeg->jpeg_color_space == JCS_YCCK)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "a CMYK JPEG; only gray and RGB are read");
    if (jpeg->num_components != 1 && jpeg->num_components != 3)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name, "a JPEG of %d components",
                           jpeg->num_components);
    info->width = jpeg->image_width;
    info->height = jpeg->image_height;
    info->channels = jpeg->num_components;
    info->sample_bytes = 1;
    info->bit_depth = 8;
    info->lossy = true;
    for (jpeg_saved_marker_ptr m = jpeg->marker_list; m != NULL; m = m->next)
        info->has_iccp = info->has_iccp || (m->data_length >= sizeof icc_name &&
                                            memcmp(m->data, icc_name, sizeof icc_name) == 0);
    for (int i = 0; i < jpeg->num_components; i++) {
        const jpeg_component_info *c = &jpeg->comp_info[i];
        info->jpeg_subsampled = info->jpeg_subsampled ||
                                c->h_samp_factor < jpeg->max_h_samp_factor ||
                                c->v_samp_factor < jpeg->max_v_samp_factor;
    }
    return true;
}

static bool read_header(jpeg_state *s, ntpio_error *error)
{
    if (setjmp(s->jump) != 0)
        return fail(s, error);
    jpeg_create_decompress(&s->jpeg);
    s->created = true;
    s->jpeg.client_data = s;
    s->source = (struct jpeg_source_mgr) { .init_source = on_start,
                                           .fill_input_buffer = on_fill,
                                           .skip_input_data = on_skip,
                                           .resync_to_restart = jpeg_resync_to_restart,
                                           .term_source = on_start };
    s->jpeg.src = &s->source;
    jpeg_save_markers(&s->jpeg, JPEG_APP0 + 2, sizeof icc_name);
    jpeg_read_header(&s->jpeg, TRUE);
    return true;
}

static bool start_rows(jpeg_state *s, ntpio_error *error)
{
    if (setjmp(s->jump) != 0)
        return fail(s, error);
    const ntpio_info *info = &s->reader->info;
    if (jpeg_has_multiple_scans(&s->jpeg)) { /* the library keeps every coefficient */
        const uint64_t sides = ((uint64_t) info->width + DCTSIZE) * (info->height + DCTSIZE);
        s->reader->info.streams = false;
        if (!ntpio__check_memory(s->reader, sides * (uint64_t) info->channels * sizeof(JCOEF),
                                 error))
            return false;
    }
    s->progress.progress_monitor = on_progress;
    s->jpeg.progress = &s->progress;
    s->jpeg.dct_method = JDCT_ISLOW;
    s->jpeg.out_color_space = info->channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&s->jpeg);
    s->reader->info.jpeg_quality =
        estimate_quality(s->jpeg.quant_tbl_ptrs[s->jpeg.comp_info[0].quant_tbl_no]);
    return true;
}

static bool jpeg_open(ntpio_reader *reader, ntpio_error *error)
{
    jpeg_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return ntpio__fail_memory(error, reader->name);
    reader->state = s;
    s->reader = reader;
    s->jpeg.err = jpeg_std_error(&s->errors);
    s->jpeg.client_data = s;
    s->errors.error_exit = on_error;
    s->errors.emit_message = on_message;
    s->errors.output_message = on_output;
    return read_header(s, error) && take_header(s, error) && start_rows(s, error);
}

static bool jpeg_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                      ntpio_error *error)
{
    jpeg_state *s = reader->state;
    if (setjmp(s->jump) != 0)
        return fail(s, error);
    for (uint32_t i = 0; i < count; i++) {
        JSAMPROW row = dst + (ptrdiff_t) i * stride;
        jpeg_read_scanlines(&s->jpeg, &row, 1);
    }
    return true;
}

static bool jpeg_end(ntpio_reader *reader, ntpio_error *error)
{
    jpeg_state *s = reader->state;
    if (setjmp(s->jump) != 0)
        return fail(s, error);
    jpeg_finish_decompress(&s->jpeg);
    return true;
}

static void jpeg_close(ntpio_reader *reader)
{
    jpeg_state *s = reader->state;
    if (s != NULL && s->created)
        jpeg_destroy_decompress(&s->jpeg);
    free(s);
}

const ntpio__decoder ntpio__jpeg_decoder = {
    jpeg_open, jpeg_rows, jpeg_end, jpeg_close, NULL, NULL
};
