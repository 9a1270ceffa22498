/* SPDX-License-Identifier: MIT */
/*
 * report.c - measuring a layer
 *
 * Rows are read through a ring, and the rows of a chunk are measured in parts by threads.  A first
 * pass detects what the layer is, unless it is given.  A
 * second pass follows if the first one assumed something else about blue.
 */
#include "report_text.h"

#include <stdlib.h>
#include <string.h>

enum {
    CHUNK = 64, /* rows read at once */
    RING = 128, /* rows kept; the orientation looks back at less than CHUNK + 8 */
    PARTS = 4,  /* of a chunk, each with a tally; they merge exactly */
    AHEAD = 3   /* rows below a row that are needed for its orientation */
};

typedef struct measurement {
    const raster *layer;
    const surroundings *around;
    ntp_tally *tally;        /* of everything, once it is measured */
    ntp_tally *parts[PARTS]; /* the first one is that of everything */
    ntp_status status[PARTS];
    int32_t y0, y1; /* the chunk */
    ntp_orientation *green;
    unsigned char *rows;
    ntp_image view;
    uint32_t touch;
} measurement;

static void release(measurement *m)
{
    for (int i = 0; i < PARTS; i++)
        free(m->parts[i]);
    free(m->green);
    free(m->rows);
}

static bool reserve(measurement *m)
{
    bool ok = true;
    for (int i = 0; i < PARTS; i++) {
        m->parts[i] = calloc(1, ntp_tally_size());
        ok = ok && m->parts[i] != NULL;
    }
    m->tally = m->parts[0];
    m->green = calloc(1, ntp_orientation_size());
    m->rows = malloc(raster_row(m->layer) * RING);
    m->view = raster_view(m->layer, m->rows, m->layer->height);
    m->view.ring_rows = RING;
    return ok && m->green != NULL && m->rows != NULL;
}

static void measure_part(void *data, int32_t index)
{
    measurement *m = data;
    const int32_t rows = m->y1 - m->y0;
    const ntp_const_image seen = ntp_image_as_const(&m->view);
    const ntp_rect area = { 0, m->y0 + rows * index / PARTS, m->layer->width,
                            m->y0 + rows * (index + 1) / PARTS };
    m->status[index] =
        area.y0 < area.y1 ? ntp_tally_add(m->parts[index], &seen, m->touch, &area) : NTP_OK;
}

static bool measure_chunk(measurement *m, int32_t y0, int32_t y1)
{
    bool ok = true;
    m->y0 = y0;
    m->y1 = y1;
    surroundings_parallel(m->around, PARTS, measure_part, m);
    for (int i = 0; i < PARTS; i++)
        ok = ok && m->status[i] == NTP_OK;
    return ok;
}

static job_status merge_parts(measurement *m)
{
    ntp_status status = NTP_OK;
    for (int i = 1; i < PARTS && status == NTP_OK; i++)
        status = ntp_tally_merge(m->tally, m->parts[i]);
    return status == NTP_OK ? JOB_DONE : JOB_WRONG;
}

static job_status measure(measurement *m)
{
    const raster *layer = m->layer;
    const ntp_const_image seen = ntp_image_as_const(&m->view);
    int32_t oriented = 0;
    for (int i = 0; i < PARTS; i++)
        ntp_tally_clear(m->parts[i]);
    memset(m->green, 0, ntp_orientation_size());
    for (int32_t y = 0; y < layer->height; y += CHUNK) {
        const int32_t end = layer->height - y > CHUNK ? y + CHUNK : layer->height;
        if (!surroundings_progress(m->around, (double) y / (double) layer->height))
            return JOB_CANCELLED;
        if (!layer->read(layer->user, y, end, m->rows + (size_t) (y % RING) * raster_row(layer)))
            return JOB_NO_PIXELS;
        if (!measure_chunk(m, y, end))
            return JOB_WRONG;
        const int32_t known = end == layer->height ? end : end - AHEAD;
        const ntp_rect next = { 0, oriented, layer->width, known };
        if (m->view.encoding == NTP_ENCODING_HEIGHT || known <= oriented)
            continue;
        if (ntp_orientation_add(m->green, &seen, m->touch, 0, &next) != NTP_OK)
            return JOB_WRONG;
        oriented = known;
    }
    return merge_parts(m);
}

static ntp_encoding encoding_of(ntp_class type, int32_t channels)
{
    if (channels < 3)
        return NTP_ENCODING_HEIGHT;
    switch (type) {
    case NTP_CLASS_ZZERO:
        return NTP_ENCODING_ZZERO;
    case NTP_CLASS_XY:
        return NTP_ENCODING_XY;
    case NTP_CLASS_HEIGHT:
        return NTP_ENCODING_HEIGHT;
    default:
        return NTP_ENCODING_STANDARD;
    }
}

static ntp_class class_of(int reading)
{
    static const ntp_class CLASSES[] = { NTP_CLASS_STANDARD, NTP_CLASS_ZZERO, NTP_CLASS_XY };
    return CLASSES[reading - 1];
}

/* An alpha of XY textures that is not a mask holds a height: 0 is not a hole there. */
static uint32_t touch_for(const report *r)
{
    const ntp_stats *s = &r->stats;
    const bool mask = s->alpha_zero + s->alpha_full == s->texels;
    return r->encoding == NTP_ENCODING_XY && s->channels == 4 && !mask ? NTP_UNUSED_TRANSPARENT : 0;
}

static job_status summarize(report *r, measurement *m)
{
    const ntp_encoding encoding =
        m->view.encoding == NTP_ENCODING_HEIGHT ? NTP_ENCODING_STANDARD : m->view.encoding;
    return ntp_tally_summarize(&r->stats, m->tally, encoding) == NTP_OK ? JOB_DONE : JOB_WRONG;
}

/* The first of two passes may have another encoding; it has no harm. */
static void measure_harm(report *r, measurement *m)
{
    static const uint32_t KINDS[REPORT_HARMS] = { NTP_HARM_LENGTH | NTP_HARM_XY, NTP_HARM_XY,
                                                  NTP_HARM_Z_NEGATIVE };
    for (int i = 0; i < REPORT_HARMS; i++) {
        if (r->encoding == NTP_ENCODING_HEIGHT ||
            ntp_tally_harm(&r->harm[i], m->tally, r->encoding, KINDS[i], COUNTS_MAX_ANGLE) !=
                NTP_OK)
            r->harm[i] = (ntp_harm) { 0 };
    }
}

static job_status look(report *r, measurement *m, int reading)
{
    m->view.encoding = m->layer->channels < 3 ? NTP_ENCODING_HEIGHT
                       : reading > 0          ? encoding_of(class_of(reading), 3)
                                              : NTP_ENCODING_STANDARD;
    job_status status = measure(m);
    if (status == JOB_DONE)
        status = summarize(r, m);
    if (status != JOB_DONE)
        return status;
    if (ntp_classify(&r->type, m->tally) != NTP_OK)
        return JOB_WRONG;
    if (reading > 0 && m->layer->channels >= 3) {
        r->type.type = class_of(reading);
        r->type.confidence = 1;
    }
    r->encoding = encoding_of(r->type.type, m->layer->channels);
    const uint32_t touch = touch_for(r);
    const bool heights = r->encoding == NTP_ENCODING_HEIGHT;
    const bool angles_differ = !heights && r->encoding != m->view.encoding;
    const bool again =
        (angles_differ && m->view.type != NTP_TYPE_U8) || (touch != 0 && r->stats.transparent > 0);
    if (!heights)
        m->view.encoding = r->encoding;
    m->touch = r->touch = touch;
    if (again)
        status = measure(m);
    return status == JOB_DONE && (again || angles_differ) ? summarize(r, m) : status;
}

static void judge(report *r, const settings *s, ntp_tally *tally)
{
    const ntp_class type = r->type.type;
    const bool tangent =
        type == NTP_CLASS_STANDARD || type == NTP_CLASS_ZZERO || type == NTP_CLASS_XY;
    uint64_t all = 0;
    r->told = (int) s->value[FK_FROM] != 0;
    r->keeps = s->value[FK_KEEP_NEGATIVE_Z] != 0;
    r->used = counts_judged(&r->stats);
    r->judged = r->encoding != NTP_ENCODING_HEIGHT && (tangent || type == NTP_CLASS_ONE_COLOR);
    if (!r->judged)
        return;
    counts_failing(&r->stats, r->encoding, NTP_VERDICT_NEIGHBOR, r->keeps, &all, &r->failing);
    counts_failing(&r->stats, r->encoding, NTP_VERDICT_EXACT, r->keeps, &all, &r->inexact);
    /* Who says how blue stores z, says that the channels are in their places. */
    r->misplaced = !r->told && counts_misplaced(&r->type, r->channels);
    r->accident = r->told ? UNDO_NOTHING : undo_kind_shown(&r->type, r->channels);
    r->right =
        !r->misplaced && r->failing == 0 &&
        (r->keeps || r->encoding != NTP_ENCODING_STANDARD || counts_z_negative(&r->stats) == 0);
    if (ntp_choose_method(&r->method, NULL, tally, r->encoding, 0) != NTP_OK)
        r->method = NTP_CLEAN_DERIVE;
}

job_status report_run(report *r, const settings *s, const raster *layer,
                      const char *(*translate)(const char *text), const surroundings *around)
{
    measurement m = { .layer = layer, .around = around };
    memset(r, 0, sizeof *r);
    r->width = layer->width;
    r->height = layer->height;
    r->channels = layer->channels;
    r->samples = layer->type;
    job_status status = reserve(&m) ? JOB_DONE : JOB_NO_MEMORY;
    if (status == JOB_DONE)
        status = look(r, &m, (int) s->value[FK_FROM]);
    if (status == JOB_DONE) {
        measure_harm(r, &m);
        judge(r, s, m.tally);
        if (r->judged && !counts_misplaced(&r->type, r->channels) &&
            r->type.type != NTP_CLASS_ONE_COLOR)
            ntp_orientation_summarize(&r->green, m.green);
        report_write(r, translate);
    }
    release(&m);
    return status;
}
