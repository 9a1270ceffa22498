/* SPDX-License-Identifier: MIT */
/*
 * pfm.c - Portable FloatMap: "PF" or "Pf", width, height, scale, then floats from the bottom row
 *
 * The sign of the scale is the byte order: negative is little endian.  Its size is ignored, as the
 * samples are numbers.  Rows are read from the end of the file if it can seek; a pipe is held
 * whole.  NaN and infinity stay as they are.
 */
#include <stdlib.h>
#include <string.h>

#include "formats.h"

enum {
    HEADER_MAX = 256, /* no header is longer */
    WORD_MAX = 40
};

typedef struct pfm_state {
    bool swap;
    uint64_t start; /* of the rows */
} pfm_state;

static void swap_words(uint8_t *row, size_t count)
{
    for (size_t i = 0; i < count; i++, row += 4) {
        const uint8_t a = row[0], b = row[1];
        row[0] = row[3];
        row[1] = row[2];
        row[2] = b;
        row[3] = a;
    }
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Reads a word of the header and the one space after it.  Comments start with #. */
static size_t next_word(const char *header, size_t size, size_t at, char *word)
{
    while (at < size && (is_space(header[at]) || header[at] == '#')) {
        if (header[at] == '#') {
            while (at < size && header[at] != '\n')
                at++;
        } else {
            at++;
        }
    }
    size_t n = 0;
    while (at < size && !is_space(header[at]) && n < WORD_MAX - 1)
        word[n++] = header[at++];
    word[n] = 0;
    return at < size && is_space(header[at]) && n != 0 ? at + 1 : 0;
}

static uint64_t to_number(const char *word)
{
    uint64_t value = 0;
    for (; *word >= '0' && *word <= '9' && value < (uint64_t) 1 << 40; word++)
        value = value * 10 + (uint64_t) (*word - '0');
    return *word == 0 ? value : 0;
}

/* A scale has a digit other than 0 before its exponent; only its sign matters. */
static bool to_sign(const char *word, bool *negative)
{
    bool nonzero = false;
    *negative = word[0] == '-';
    for (word += word[0] == '-' || word[0] == '+'; *word != 0 && *word != 'e' && *word != 'E';
         word++) {
        if (*word != '.' && (*word < '0' || *word > '9'))
            return false;
        nonzero = nonzero || (*word >= '1' && *word <= '9');
    }
    return nonzero;
}

static bool parse_header(ntpio_reader *reader, pfm_state *s, ntpio_error *error)
{
    ntpio_info *info = &reader->info;
    const size_t size = ntpio__peek(&reader->source, HEADER_MAX);
    const char *header = (const char *) reader->source.bytes + reader->source.at;
    const size_t limit = size < HEADER_MAX ? size : HEADER_MAX;
    char width[WORD_MAX], height[WORD_MAX], scale[WORD_MAX];
    bool little = false;
    size_t at = next_word(header, limit, 2, width);
    at = at != 0 ? next_word(header, limit, at, height) : 0;
    at = at != 0 ? next_word(header, limit, at, scale) : 0;
    if (at == 0 && size < HEADER_MAX)
        return ntpio__fail_ended(reader, error);
    if (at == 0 || !to_sign(scale, &little))
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "damaged PFM header");
    /* A line may end with "\r\n": then the one space after the scale is two bytes. */
    if (header[at - 1] == '\r' && at < limit && header[at] == '\n')
        at++;
    const uint64_t w = to_number(width), h = to_number(height);
    if (!ntpio__check_size(reader, w, h, error))
        return false;
    info->format = NTPIO_PFM;
    info->width = (uint32_t) w;
    info->height = (uint32_t) h;
    info->channels = header[1] == 'F' ? 3 : 1;
    info->sample_bytes = 4;
    info->bit_depth = 32;
    s->swap = little != ntpio__little_endian();
    s->start = at;
    reader->source.at += at;
    return true;
}

static bool read_row(ntpio_reader *reader, uint8_t *dst, ntpio_error *error)
{
    const pfm_state *s = reader->state;
    const size_t size = ntpio__row_bytes(&reader->info);
    if (!ntpio__read_all(reader, dst, size, error))
        return false;
    if (s->swap)
        swap_words(dst, size / 4);
    return true;
}

static bool pfm_open(ntpio_reader *reader, ntpio_error *error)
{
    pfm_state *s = calloc(1, sizeof *s);
    uint64_t size;
    if (s == NULL)
        return ntpio__fail_memory(error, reader->name);
    reader->state = s;
    if (!parse_header(reader, s, error))
        return false;
    const size_t row = ntpio__row_bytes(&reader->info);
    if (ntpio__can_seek(&reader->source)) {
        if (!ntpio__size(&reader->source, &size) ||
            size - s->start < (uint64_t) row * reader->info.height)
            return ntpio__fail_ended(reader, error);
        return true;
    }
    if (!ntpio__hold(reader, error))
        return false;
    for (uint32_t y = reader->info.height; y-- > 0;) {
        if (!read_row(reader, reader->held + (size_t) y * row, error))
            return false;
    }
    return true;
}

static bool pfm_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error)
{
    const pfm_state *s = reader->state;
    const uint64_t row = ntpio__row_bytes(&reader->info);
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t y = reader->info.height - 1 - (reader->row + i);
        if (!ntpio__seek(&reader->source, s->start + y * row))
            return ntpio__fail_ended(reader, error);
        if (!read_row(reader, dst + (ptrdiff_t) i * stride, error))
            return false;
    }
    return true;
}

static void pfm_close(ntpio_reader *reader)
{
    free(reader->state);
}

const ntpio__decoder ntpio__pfm_decoder = { pfm_open, pfm_rows, NULL, pfm_close, NULL, NULL };

/* ------------------------------------------------------------------------ writing */

typedef struct pfm_writer {
    uint64_t start;
    uint8_t *held; /* the image, if the output cannot seek */
} pfm_writer;

static size_t written_row(const ntpio_writer *writer)
{
    return (size_t) writer->options.width * (size_t) writer->options.channels * 4;
}

static bool pfm_write_open(ntpio_writer *writer, ntpio_error *error)
{
    const ntpio_write_options *o = &writer->options;
    char header[HEADER_MAX];
    pfm_writer *s = calloc(1, sizeof *s);
    writer->state = s;
    if (s != NULL && !ntpio__output_can_seek(writer->output) &&
        written_row(writer) <= PTRDIFF_MAX / o->height)
        s->held = malloc(written_row(writer) * o->height);
    if (s == NULL || (s->held == NULL && !ntpio__output_can_seek(writer->output)))
        return ntpio__fail_memory(error, writer->name);
    const int size = snprintf(header, sizeof header, "%s\n%lu %lu\n%s\n",
                              o->channels == 3 ? "PF" : "Pf", (unsigned long) o->width,
                              (unsigned long) o->height, ntpio__little_endian() ? "-1.0" : "1.0");
    s->start = (uint64_t) size;
    return ntpio__output_write(writer->output, header, (size_t) size, error);
}

static bool pfm_write_rows(ntpio_writer *writer, const uint8_t *src, ptrdiff_t stride,
                           uint32_t count, ntpio_error *error)
{
    const pfm_writer *s = writer->state;
    const size_t row = written_row(writer);
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t y = writer->options.height - 1 - (writer->row + i);
        const uint8_t *from = src + (ptrdiff_t) i * stride;
        if (s->held != NULL)
            memcpy(s->held + (size_t) y * row, from, row);
        else if (!ntpio__output_write_at(writer->output, s->start + y * row, from, row, error))
            return false;
    }
    return true;
}

static bool pfm_write_end(ntpio_writer *writer, ntpio_error *error)
{
    const pfm_writer *s = writer->state;
    return s->held == NULL ||
           ntpio__output_write(writer->output, s->held,
                               written_row(writer) * writer->options.height, error);
}

static void pfm_write_close(ntpio_writer *writer)
{
    pfm_writer *s = writer->state;
    free(s->held);
    free(s);
}

const ntpio__encoder ntpio__pfm_encoder = { pfm_write_open, pfm_write_rows, pfm_write_end,
                                            pfm_write_close };
