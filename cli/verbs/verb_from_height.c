/* SPDX-License-Identifier: MIT */
/*
 * verb_from_height.c - ntp from-height: normals from a heightfield
 *
 * A ring keeps rows of heights until the neighbors of a row are there.  A border that wraps needs
 * the rows of the other end, and a blur needs rows far away: then the whole heightfield is held.
 */
#include "verbs/verb_from_height.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "examine/samples.h"
#include "options/names.h"
#include "report/report.h"
#include "run/thread_crew.h"
#include "surface/relief_scale.h"
#include "verbs/verbs.h"
#include "write/side_image.h"

enum {
    CHUNK = 64,       /* rows made at once */
    RING = 2 * CHUNK, /* rows that are being made or written */
};

typedef struct state {
    ntp_normals_counts counts;
    ntp_image heights; /* the ring */
    ntp_image made;
    void *errors; /* of dithering; NULL: none */
    size_t errors_size;
    double scale;
    int32_t reach, done; /* rows written */
    int32_t out_channels;
    size_t out_row;                  /* bytes of a row of the file */
    const unsigned char *alpha, *ao; /* whole planes in the depth of the output, or NULL */
} state;

/* ---------------------------------------------------------------------- other images */

static bool read_planes(production *p, ntpio_error *error)
{
    const from_height_settings *set = p->m->settings;
    state *st = p->state;
    const ntp_type type = st->made.type;
    const size_t plane = (size_t) p->s.info->width * p->s.info->height * sample_size(type);
    const size_t count = (set->alpha_file != NULL) + (size_t) (set->ao_file != NULL);
    if (count == 0)
        return true;
    /* The worker's `raw` is free: it is for views whose channels are not those of the file. */
    unsigned char *planes = buffer_reserve(&p->w->raw, plane * count);
    if (set->alpha_file != NULL) {
        if (!side_image_read(planes, type, set->alpha_file, &set->limits, p->s.info, "heightfield",
                             error))
            return false;
        st->alpha = planes;
        planes += plane;
    }
    if (set->ao_file != NULL) {
        if (!side_image_read(planes, type, set->ao_file, &set->limits, p->s.info, "heightfield",
                             error))
            return false;
        st->ao = planes;
    }
    return true;
}

/* ------------------------------------------------------------------------- the rows */

static ntp_type output_type(const production *p, const from_height_settings *set)
{
    const char *output = p->in->output;
    const bool pfm = output != NULL && strcasecmp(name_ending(output), ".pfm") == 0;
    if (pfm)
        return NTP_TYPE_F32;
    if (set->depth != 0)
        return set->depth == 1 ? NTP_TYPE_U8 : NTP_TYPE_U16;
    return p->s.view.type == NTP_TYPE_F32 ? NTP_TYPE_U16 : p->s.view.type;
}

static int32_t output_channels(const production *p, const from_height_settings *set)
{
    if (set->out_count > 0)
        return set->out_count;
    const bool kept = p->s.view.channels % 2 == 0 && !set->alpha_given &&
                      set->how.source != NTP_HEIGHT_SOURCE_ALPHA;
    return set->alpha_given || kept ? 4 : 3;
}

/* Do the first rows need the last ones? */
static bool needs_all(const from_height_settings *set)
{
    return set->measures || set->how.border_y == NTP_BORDER_WRAP || set->blur > 0 ||
           set->octaves > 0;
}

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const from_height_settings *set = p->m->settings;
    state *st = p->state;
    const ntp_image *view = &p->s.view;
    const ntp_type type = output_type(p, set);
    if (set->how.source == NTP_HEIGHT_SOURCE_ALPHA && view->channels % 2 == 1)
        return wrong_use(p, "it has no alpha to take the height from", error);
    if (set->dither && type == NTP_TYPE_F32)
        return wrong_use(p, "--dither is for outputs of 8 or 16 bit", error);
    const bool whole = needs_all(set);
    st->scale = set->how.scale;
    st->reach = ntp_normals_reach(&set->how);
    st->out_channels = output_channels(p, set);
    st->out_row = (size_t) view->width * (size_t) st->out_channels * sample_size(type);

    const int32_t ring = view->ring_rows + CHUNK + 2 * st->reach;
    const int32_t rows = whole || ring > view->height ? view->height : ring;
    const size_t row = (size_t) view->width * (size_t) view->channels * sample_size(view->type);
    st->heights = *view;
    st->heights.data = buffer_reserve(&p->w->extra, row * (size_t) rows);
    st->heights.row_stride = (ptrdiff_t) row;
    st->heights.ring_rows = rows;

    const bool plain = st->out_channels == 3 && set->out_count == 0 && set->ao_file == NULL;
    const int32_t channels = plain ? 3 : FULL;
    const size_t made_row = (size_t) view->width * (size_t) channels * sample_size(type);
    const size_t needed = set->dither ? ntp_normals_dithered_scratch_size(view->width) : 0;
    const size_t errors = (needed + 15) / 16 * 16;
    unsigned char *memory = buffer_reserve(&p->w->extra2, errors + made_row * RING);
    if (set->dither)
        st->errors = memset(memory, 0, errors);
    st->errors_size = errors;
    st->made = ntp_image_packed(memory + errors, view->width, view->height, channels, type);
    st->made.ring_rows = RING;
    st->made.encoding = set->to;
    st->made.y = set->to_y;
    shape->channels = st->out_channels;
    shape->sample_bytes = (int32_t) sample_size(type);
    p->changes = true;
    return read_planes(p, error);
}

/* Sets one channel of packed pixels of FULL channels to a plane of the same type. */
static void set_channel(unsigned char *pixels, const unsigned char *plane, size_t count,
                        size_t sample, size_t channel)
{
    pixels += channel * sample;
    for (size_t i = 0; i < count; i++)
        memcpy(pixels + i * FULL * sample, plane + i * sample, sample);
}

static void lay_out(const state *st, const from_height_settings *set, void *out, int32_t y0,
                    int32_t y1)
{
    static const int8_t PLAIN[FULL] = { 0, 1, 2, ALPHA };
    const channel_order order = { st->made.type, st->out_channels, FULL,
                                  set->out_count > 0 ? set->out : PLAIN };
    const size_t width = (size_t) st->made.width, sample = sample_size(st->made.type);
    for (int32_t y = y0; y < y1; y++) {
        const size_t plane_row = (size_t) y * width * sample;
        unsigned char *from =
            (unsigned char *) st->made.data + (size_t) (y % RING) * (size_t) st->made.row_stride;
        unsigned char *to = (unsigned char *) out + (size_t) (y - y0) * st->out_row;
        if (st->ao != NULL)
            set_channel(from, st->ao + plane_row, width, sample, 2);
        if (st->alpha != NULL)
            set_channel(from, st->alpha + plane_row, width, sample, ALPHA);
        reorder_channels(to, from, &order, width);
    }
}

/* The rows that are written, and those that are made at the same time. */
typedef struct step {
    production *p;
    const ntp_image *heights;
    ntp_normals_options how;
    ntp_rect write, make;
    ntp_status status; /* of what was made */
    bool written;
    ntpio_error *error;
} step;

static void make_chunk(step *s)
{
    state *st = s->p->state;
    const ntp_const_image seen = ntp_image_as_const(s->heights);
    if (s->make.y0 == s->make.y1)
        return;
    s->status = st->errors != NULL
                    ? ntp_normals_dithered(&st->made, &seen, &s->how, st->errors, st->errors_size,
                                           &st->counts, &s->make)
                    : ntp_normals_from_height(&st->made, &seen, &s->how, &st->counts, &s->make);
}

static bool write_chunk(const step *s)
{
    const state *st = s->p->state;
    unsigned char *out = (unsigned char *) st->made.data +
                         (size_t) (s->write.y0 % RING) * (size_t) st->made.row_stride;
    if (st->made.channels == FULL) {
        out = buffer_reserve(&s->p->w->extra3, st->out_row * CHUNK);
        lay_out(st, s->p->m->settings, out, s->write.y0, s->write.y1);
    }
    return production_write(s->p, out, (ptrdiff_t) st->out_row, &s->write, s->error);
}

static void do_half(void *work, int32_t index)
{
    step *s = work;
    if (index == 0)
        s->written = write_chunk(s);
    else
        make_chunk(s);
}

/* The rows from y on, up to the end of the chunk that they are in. */
static ntp_rect chunk_from(const state *st, int32_t y, int32_t end)
{
    const int32_t full = (y / CHUNK + 1) * CHUNK;
    return (ntp_rect) { 0, y, st->made.width, full < end ? full : end };
}

/* Makes and writes the rows before `end`, whose neighbors are there.  If there are many rows, as
 * with borders that wrap, a second thread makes them while the first one compresses. */
static bool make_rows(production *p, const ntp_image *heights, int32_t end, ntpio_error *error)
{
    const from_height_settings *set = p->m->settings;
    state *st = p->state;
    step s = { .p = p, .heights = heights, .how = set->how, .written = true, .error = error };
    s.how.scale = st->scale;
    if (heights != &st->heights)
        s.how.source = NTP_HEIGHT_SOURCE_RED;
    crew *two = p->w->threads > 1 && end - st->done > RING ? crew_start(2) : NULL;
    s.make = chunk_from(st, st->done, end);
    make_chunk(&s);
    while (st->done < end && s.status == NTP_OK && s.written) {
        s.write = s.make;
        s.make = chunk_from(st, s.write.y1, end);
        if (two != NULL) {
            crew_run(two, 2, do_half, &s);
        } else {
            do_half(&s, 0);
            do_half(&s, 1);
        }
        st->done = s.write.y1;
    }
    crew_stop(two);
    return s.status == NTP_OK ? s.written : library_error(&p->s, s.status, error);
}

/* The weighted sum of the octaves of the whole heightfield. */
static ntp_status smooth(const state *st, const from_height_settings *set, const ntp_image *out)
{
    static const double ONE[] = { 1 };
    const double *weights = set->octaves > 0 ? set->octave : ONE;
    const int count = set->octaves > 0 ? set->octaves : 1;
    const ntp_const_image seen = ntp_image_as_const(&st->heights);
    ntp_status status = NTP_OK;
    for (int i = 0; i < count && status == NTP_OK; i++) {
        /* blurring twice adds the squares of sigma */
        const double own = i > 0 ? (double) (1 << (i - 1)) : 0;
        const double sigma = i > 0 ? sqrt(set->blur * set->blur + own * own) : set->blur;
        const ntp_blur_options how = { .sigma = sigma < NTP_MAX_SIGMA ? sigma : NTP_MAX_SIGMA,
                                       .weight = weights[i],
                                       .add = i > 0,
                                       .border_x = set->how.border_x,
                                       .border_y = set->how.border_y,
                                       .source = set->how.source };
        const size_t size = ntp_height_blur_scratch_size(&how, out->width);
        void *scratch = need_aligned(size);
        status = ntp_height_blur(out, &seen, &how, scratch, size);
        free_aligned(scratch);
    }
    return status;
}

/* Converts the last channel of `from` to the second of `out`. */
static void copy_alpha(const ntp_image *out, const ntp_image *from)
{
    ntp_image to = *out, alpha = *from;
    const size_t last = (size_t) (from->channels - 1) * sample_size(from->type);
    to.data = (float *) out->data + 1;
    to.channels = 1;
    alpha.data = (unsigned char *) from->data + last;
    alpha.channels = 1;
    const ntp_const_image seen = ntp_image_as_const(&alpha);
    ntp_convert(&to, &seen, NULL, NULL, NULL);
}

static bool make_smoothed(production *p, ntpio_error *error)
{
    const from_height_settings *set = p->m->settings;
    const state *st = p->state;
    const ntp_image *from = &st->heights;
    const int32_t channels = from->channels % 2 == 0 ? 2 : 1;
    const size_t texels = (size_t) from->width * (size_t) from->height;
    float *data = need(calloc(texels * (size_t) channels, sizeof *data));
    ntp_image out = ntp_image_packed(data, from->width, from->height, channels, NTP_TYPE_F32);
    out.encoding = NTP_ENCODING_HEIGHT;
    const ntp_status status = smooth(st, set, &out);
    if (channels == 2)
        copy_alpha(&out, from);
    const bool ok = status == NTP_OK ? make_rows(p, &out, from->height, error)
                                     : library_error(&p->s, status, error);
    free(data);
    return ok;
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    const from_height_settings *set = p->m->settings;
    state *st = p->state;
    const ntp_image *view = &p->s.view;
    for (int32_t y = area->y0; y < area->y1; y++) {
        const unsigned char *from = (const unsigned char *) view->data +
                                    (size_t) (y % view->ring_rows) * (size_t) view->row_stride;
        unsigned char *to = (unsigned char *) st->heights.data +
                            (size_t) (y % st->heights.ring_rows) * (size_t) st->heights.row_stride;
        memcpy(to, from, (size_t) view->row_stride);
    }
    if (area->y1 == view->height && set->measures) {
        const ntp_const_image all = ntp_image_as_const(&st->heights);
        const ntp_status status = heights_suit_scale(&all, &set->how, &st->scale);
        if (status != NTP_OK)
            return library_error(&p->s, status, error);
    }
    if (area->y1 == view->height)
        return set->blur > 0 || set->octaves > 0 ? make_smoothed(p, error)
                                                 : make_rows(p, &st->heights, view->height, error);
    if (needs_all(set) || area->y1 - st->reach <= st->done)
        return true;
    return make_rows(p, &st->heights, area->y1 - st->reach, error);
}

/* --------------------------------------------------------------------- what was done */

static void describe(const production *p, text *line, json_t *object)
{
    const from_height_settings *set = p->m->settings;
    const state *st = p->state;
    const ntp_normals_options *how = &set->how;
    const size_t bits = 8 * sample_size(st->made.type);
    if (line != NULL) {
        text_addf(line, "%s normals, scale %.15g, %s, green %s, %zu bit", encoding_name(set->to),
                  st->scale, ntp_kernel_name(how->kernel), y_name(set->to_y), bits);
        if (st->counts.not_finite > 0) {
            text_add(line, "; ");
            text_count(line, st->counts.not_finite);
            text_add(line, " texels made flat because heights are not finite");
        }
    }
    if (object == NULL)
        return;
    json_set_changes(object, NULL);
    json_object_set_new(object, "scale", json_real(st->scale));
    json_object_set_new(object, "dx", json_real(how->dx));
    json_object_set_new(object, "dy", json_real(how->dy));
    json_object_set_new(object, "invert", json_boolean(how->invert));
    json_object_set_new(object, "kernel", json_string(ntp_kernel_name(how->kernel)));
    json_object_set_new(object, "border_x", json_string(ntp_border_name(how->border_x)));
    json_object_set_new(object, "border_y", json_string(ntp_border_name(how->border_y)));
    json_object_set_new(object, "source", json_string(source_name(how->source)));
    json_object_set_new(object, "min_z", json_real(how->min_z));
    json_object_set_new(object, "blue",
                        json_string(how->blue == NTP_BLUE_DERIVED ? "derived" : "nearest"));
    json_object_set_new(object, "blur", json_real(set->blur));
    json_t *octaves = need(json_array());
    for (int i = 0; i < set->octaves; i++)
        json_array_append_new(octaves, json_real(set->octave[i]));
    json_object_set_new(object, "octaves", octaves);
    json_object_set_new(object, "dither", json_string(set->dither ? "integrable" : "none"));
    json_object_set_new(object, "to", json_string(encoding_name(set->to)));
    json_object_set_new(object, "to_y", json_string(y_name(set->to_y)));
    json_object_set_new(object, "depth", json_integer((json_int_t) bits));
    json_object_set_new(object, "channels", json_integer(st->out_channels));
    json_object_set_new(object, "not_finite", json_count(st->counts.not_finite));
    json_object_set_new(object, "exact", json_count(st->counts.exact));
    json_object_set_new(object, "texels",
                        json_count((uint64_t) st->made.width * (uint64_t) st->made.height));
}

int from_height_run(const options *o)
{
    from_height_settings set = { .out_count = 0 };
    if (!from_height_read_settings(&set, o))
        return NTP_EXIT_USAGE;
    const maker m = { .o = o,
                      .forced = NTP_CLASS_HEIGHT,
                      .plan = PLAN_AS_TOLD,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .begin = begin,
                      .rows = rows,
                      .describe = describe };
    return produce(&m);
}
