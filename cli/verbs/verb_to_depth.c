/* SPDX-License-Identifier: MIT */
/*
 * verb_to_depth.c - ntp to-depth: depth of objects from their normals
 *
 * The normals are held whole, with about 300 bytes a texel for the solver.  One thread works on a
 * file.  Photometric stereo has green up: that holds where nothing says otherwise.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "examine/samples.h"
#include "options/names.h"
#include "report/report.h"
#include "surface/solve_heights.h"
#include "verbs/verbs.h"
#include "write/green.h"
#include "write/side_image.h"
#include "write/whole_image.h"

enum { READ_PERMILLE = 100, TEXTS = 2, FULL = 65535 };

static const char SCALE_KEY[] = "Depth scale", OFFSET_KEY[] = "Depth offset";

typedef struct settings {
    ntp_depth_options how; /* without mask */
    int y;                 /* -1: auto, else an ntp_y */
    bool is_float;
    const char *mask_file, *confidence_file;
    ntpio_limits limits;
} settings;

typedef struct state {
    ntp_depth_result result;
    double scale, offset; /* of the output */
    ntp_const_image src;  /* the normals, whole */
    green y;
} state;

/* ------------------------------------------------------------------------- options */

static bool read_camera(ntp_camera *camera, const char *list)
{
    double *const field[] = { &camera->fx, &camera->fy, &camera->cx, &camera->cy };
    const char *at = list;
    for (int i = 0; list != NULL && i < 4; i++) {
        char *end = NULL;
        *field[i] = strtod(at, &end);
        const size_t length = strspn(at, "0123456789.eE+-");
        const bool in_range =
            i < 2 ? *field[i] >= 1e-3 && *field[i] <= 1e6 : fabs(*field[i]) <= 1e6;
        if (length == 0 || end != at + length || !in_range || *end != (i < 3 ? ',' : 0)) {
            complain("--camera %s: expected FX,FY,CX,CY, four numbers with commas between them, "
                     "the first two from 0.001 on, none above 1e6",
                     list);
            return false;
        }
        at = end + 1;
    }
    return true;
}

static bool is_pfm(const char *path)
{
    return path != NULL && strcasecmp(name_ending(path), ".pfm") == 0;
}

static bool is_tga(const char *path)
{
    return path != NULL && strcasecmp(name_ending(path), ".tga") == 0;
}

/* --depth, and the endings of files that are named. */
static bool read_depth(settings *set, const options *o)
{
    const char *output = option_string(o, OPT_OUTPUT);
    const bool given = option_given(o, OPT_DEPTH);
    set->is_float = given ? option_integer(o, OPT_DEPTH) == 1 : is_pfm(output);
    if (given && !set->is_float && is_pfm(output))
        complain("-o %s: PFM holds floats; leave out --depth 16", output);
    else if (set->is_float && output != NULL && strcasecmp(name_ending(output), ".png") == 0)
        complain("-o %s: --depth float writes .pfm", output);
    else if (is_tga(output) || is_tga(set->confidence_file))
        complain("TGA holds 8 bits, too few for depth; use .png or .pfm");
    else
        return true;
    return false;
}

/* ------------------------------------------------------------------------- writing */

/* A number of nine digits: what is printed is exactly what was used. */
static double nine_digits(double v)
{
    char digits[40];
    snprintf(digits, sizeof digits, "%.9g", v);
    return strtod(digits, NULL);
}

/* depth = offset + scale * value; levels 1 to 65535 are values 0 to 1, and level 0 is no surface. */
static void choose_scale(state *st, bool is_float)
{
    st->offset = is_float ? 0 : nine_digits(st->result.min);
    st->scale = is_float ? 1 : nine_digits(st->result.max - st->result.min);
}

static uint16_t level_of(double depth, const state *st)
{
    if (depth != depth)
        return 0;
    const double share = st->scale > 0 ? (depth - st->offset) / st->scale : 0;
    const double v = 1 + share * (FULL - 1) + 0.5;
    return v >= FULL ? FULL : v >= 1 ? (uint16_t) v : 1;
}

static char *number_text(double v)
{
    text t = { 0 };
    text_addf(&t, "%.9g", v);
    char *string = copy_string(text_string(&t));
    text_free(&t);
    return string;
}

static ntpio_writer *open_output(const production *p, const char *path, bool is_float,
                                 const ntpio_text *texts, ntpio_error *error)
{
    ntpio_write_options shape = { .width = p->s.info->width,
                                  .height = p->s.info->height,
                                  .channels = 1,
                                  .sample_bytes = is_float ? 4 : 2,
                                  .copy_from = &p->f.info, /* which has no texts */
                                  .texts = texts,
                                  .text_count = texts != NULL ? TEXTS : 0 };
    return production_open(p, path, &shape, error);
}

static bool write_rows(ntpio_writer *writer, const ntp_image *plane, const uint16_t *levels,
                       ntpio_error *error)
{
    const size_t width = (size_t) plane->width;
    return ntpio_write_rows(writer, levels != NULL ? (const void *) levels : plane->data,
                            (ptrdiff_t) (width * (levels != NULL ? 2 : 4)),
                            (uint32_t) plane->height, error);
}

static bool write_depth(production *p, const ntp_image *depth, ntpio_error *error)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const float *v = depth->data;
    const size_t texels = (size_t) depth->width * (size_t) depth->height;
    uint16_t *levels = set->is_float ? NULL : need(malloc(texels * sizeof *levels));
    for (size_t i = 0; levels != NULL && i < texels; i++)
        levels[i] = level_of((double) v[i], st);
    const ntpio_text texts[TEXTS] = {
        { .key = (char *) (uintptr_t) SCALE_KEY, .value = number_text(st->scale) },
        { .key = (char *) (uintptr_t) OFFSET_KEY, .value = number_text(st->offset) },
    };
    p->writer = open_output(p, p->in->output, set->is_float, texts, error);
    const bool ok = p->writer != NULL && write_rows(p->writer, depth, levels, error);
    for (int i = 0; i < TEXTS; i++)
        free(texts[i].value);
    free(levels);
    return ok;
}

static bool write_confidence(const production *p, const ntp_image *confidence, ntpio_error *error)
{
    const settings *set = p->m->settings;
    const bool is_float = is_pfm(set->confidence_file);
    const float *v = confidence->data;
    const size_t texels = (size_t) confidence->width * (size_t) confidence->height;
    uint16_t *levels = is_float ? NULL : need(malloc(texels * sizeof *levels));
    for (size_t i = 0; levels != NULL && i < texels; i++)
        levels[i] = (uint16_t) ((double) v[i] * FULL + 0.5);
    ntpio_writer *writer = production_may_write(p, set->confidence_file, error)
                               ? open_output(p, set->confidence_file, is_float, NULL, error)
                               : NULL;
    bool ok = writer != NULL && write_rows(writer, confidence, levels, error);
    if (ok)
        ok = ntpio_commit(writer, error);
    else
        ntpio_abort(writer);
    free(levels);
    return ok;
}

/* ----------------------------------------------------------------------- production */

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const settings *set = p->m->settings;
    (void) shape;
    p->changes = true;
    if (set->confidence_file != NULL && p->inputs->count > 1)
        return wrong_use(p, "--confidence names one file, but there are several inputs", error);
    return whole_begin(p, error);
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    (void) error;
    whole_add(p, area);
    return true;
}

static ntp_image floats(buffer *own, const ntp_image *view)
{
    const size_t bytes = (size_t) view->width * (size_t) view->height * sizeof(float);
    return ntp_image_packed(buffer_reserve(own, bytes), view->width, view->height, 1, NTP_TYPE_F32);
}

static bool knows(production *p, text *why)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    st->src = ntp_image_as_const(&p->s.view);
    st->src.data = p->w->extra.data;
    st->src.ring_rows = 0;
    if (set->y < 0)
        green_measure(&p->f, &st->src, 0);
    const bool known = green_find_or_up(&st->y, set->y, &p->f);
    if (!known)
        green_ask(why, &p->f, "--y");
    st->src.y = st->y.y;
    return known;
}

static bool finish(production *p, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const ntp_image *view = &p->s.view;
    ntp_depth_options how = set->how;
    ntp_const_image seen;
    unsigned char *plane = NULL;
    if (set->mask_file != NULL) {
        plane = need(malloc((size_t) view->width * (size_t) view->height * 2));
        const ntp_image mask = ntp_image_packed(plane, view->width, view->height, 1, NTP_TYPE_U16);
        seen = ntp_image_as_const(&mask);
        how.mask = &seen;
        if (!side_image_read(plane, NTP_TYPE_U16, set->mask_file, &set->limits, p->s.info,
                             "texture", error)) {
            free(plane);
            return false;
        }
    }
    const ntp_image depth = floats(&p->w->extra2, view), confidence = floats(&p->w->extra3, view);
    const bool sure = set->confidence_file != NULL;
    const ntp_status status = depth_solve(p->w, &depth, sure ? &confidence : NULL, &st->src, &how,
                                          (stretch) { READ_PERMILLE, 1000 }, &st->result);
    free(plane);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    choose_scale(st, set->is_float);
    return (!sure || write_confidence(p, &confidence, error)) && write_depth(p, &depth, error);
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const ntp_depth_result *r = &st->result;
    const ntp_camera *c = &set->how.camera;
    if (line != NULL) {
        text_addf(line, "scale %.9g, offset %.9g, ", st->scale, st->offset);
        text_addf(line, "%s, %d %s", c->fx > 0 ? "perspective" : "orthographic", (int) r->rounds,
                  r->rounds == 1 ? "round" : "rounds");
        green_tell(line, ", ", "green", &st->y);
        if (r->islands != 1) {
            text_add(line, ", ");
            text_count(line, r->islands);
            text_add(line, " islands");
        }
    }
    if (object == NULL)
        return;
    json_set_changes(object, NULL);
    json_object_set_new(object, "scale", json_real(st->scale));
    json_object_set_new(object, "offset", json_real(st->offset));
    json_object_set_new(object, "depth", set->is_float ? json_string("float") : json_integer(16));
    json_object_set_new(object, "min", json_real(r->min));
    json_object_set_new(object, "max", json_real(r->max));
    json_object_set_new(object, "camera",
                        c->fx > 0 ? json_pack("[f,f,f,f]", c->fx, c->fy, c->cx, c->cy)
                                  : json_null());
    json_object_set_new(object, "k", json_real(set->how.k));
    green_report(object, "y", &st->y);
    json_object_set_new(object, "rounds", json_integer(r->rounds));
    json_object_set_new(object, "iterations", json_integer(r->iterations));
    json_object_set_new(object, "islands", json_count(r->islands));
    json_object_set_new(object, "holes", json_count(r->holes));
    json_object_set_new(object, "turned_away", json_count(r->turned_away));
    json_object_set_new(object, "not_finite", json_count(r->not_finite));
    json_object_set_new(object, "confidence_file",
                        set->confidence_file != NULL ? json_string(set->confidence_file)
                                                     : json_null());
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
}

int to_depth_run(const options *o)
{
    settings set = { .how = { .k = option_number(o, OPT_K),
                              .rounds = (int32_t) option_integer(o, OPT_ROUNDS) },
                     .y = green_told(o, OPT_Y),
                     .mask_file = option_string(o, OPT_MASK),
                     .confidence_file = option_string(o, OPT_CONFIDENCE),
                     .limits = limits_from(o) };
    if (!read_camera(&set.how.camera, option_string(o, OPT_CAMERA)) || !read_depth(&set, o))
        return NTP_EXIT_USAGE;
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .of_objects = true,
                      .plan = PLAN_AFTER_READING,
                      .read_permille = READ_PERMILLE,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .knows = knows,
                      .begin = begin,
                      .rows = rows,
                      .finish = finish,
                      .describe = describe };
    return produce(&m);
}
