/* SPDX-License-Identifier: MIT */
/*
 * verb_curvature.c - ntp curvature: curvature and cavity maps, from normals or heights
 *
 * The texture is held whole, and the map of floats too where its range is to be found.
 */
#include <stdlib.h>

#include "report/report.h"
#include "verbs/relief.h"
#include "verbs/verbs.h"

enum { BLOCK_ROWS = 64, XYZ = 3 };

static const char *const KINDS[] = { "mean", "gaussian", "convex", "cavity" };
static const char RANGE_KEY[] = "Curvature range";

typedef struct settings {
    relief_settings relief; /* first */
    ntp_curvature_options how;
} settings;

typedef struct state {
    relief_state relief; /* first */
    double range;
} state;

/* Vectors without a direction, such as black, are flat, so that they do not bend what is near. */
static void flatten_unused(float *vectors, size_t texels)
{
    for (size_t i = 0; i < texels; i++) {
        float *v = vectors + i * XYZ;
        if (!(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < 2)) {
            v[0] = v[1] = 0;
            v[2] = 1;
        }
    }
}

/* x and y of the normals, blurred, as vectors. */
static ntp_status blurred_normals(production *p, const settings *set, const ntp_const_image *src,
                                  ntp_image *out)
{
    const size_t texels = (size_t) src->width * (size_t) src->height;
    float *vectors =
        (float *) (void *) buffer_reserve(&p->w->extra2, 2 * XYZ * texels * sizeof(float));
    ntp_image raw = ntp_image_packed(vectors, src->width, src->height, XYZ, NTP_TYPE_F32);
    *out = raw;
    out->data = vectors + XYZ * texels;
    raw.encoding = out->encoding = NTP_ENCODING_VECTOR;
    raw.y = out->y = src->y;
    ntp_status status = ntp_convert(&raw, src, NULL, NULL, NULL);
    flatten_unused(vectors, texels);
    for (int c = 0; c < 2 && status == NTP_OK; c++) {
        ntp_image from = raw, to = *out;
        from.encoding = to.encoding = NTP_ENCODING_HEIGHT;
        to.data = (float *) out->data + c;
        to.channels = 1;
        const ntp_const_image seen = ntp_image_as_const(&from);
        status = relief_blur(&to, &seen, p, (ntp_height_source) c, set->relief.blur);
    }
    return status;
}

/* What the curvature is taken of. */
static bool find_surface(production *p, ntp_const_image *src, ntpio_error *error)
{
    const settings *set = p->m->settings;
    ntp_image made;
    if (relief_is_height(p))
        return relief_heights(p, src, error);
    const state *st = p->state;
    *src = st->relief.solve.src;
    src->y = st->relief.solve.y.y;
    if (set->relief.blur == 0)
        return true;
    const ntp_status status = blurred_normals(p, set, src, &made);
    *src = ntp_image_as_const(&made);
    return status == NTP_OK || library_error(&p->s, status, error);
}

/* The range that is asked for, or that of the whole map. */
static ntp_status find_range(const ntp_const_image *src, ntp_curvature_options *how)
{
    const size_t texels = (size_t) src->width * (size_t) src->height;
    if (how->range > 0)
        return NTP_OK;
    float *values = need(malloc(texels * sizeof *values));
    const ntp_image map = ntp_image_packed(values, src->width, src->height, 1, NTP_TYPE_F32);
    const ntp_const_image seen = ntp_image_as_const(&map);
    ntp_status status = ntp_curvature(&map, src, how, NULL);
    if (status == NTP_OK)
        status = ntp_curvature_range(&how->range, &seen);
    if (how->range == 0) /* flat */
        how->range = 1;
    free(values);
    return status;
}

static bool write_map(production *p, const ntp_const_image *src, const ntp_curvature_options *how,
                      ntpio_error *error)
{
    const relief_state *st = p->state;
    ntp_image map = ntp_image_packed(NULL, src->width, src->height, 1, st->type);
    map.ring_rows = BLOCK_ROWS;
    map.data = need(malloc((size_t) map.row_stride * BLOCK_ROWS));
    bool ok = true;
    for (int32_t y = 0; ok && y < src->height; y += BLOCK_ROWS) {
        const int32_t end = src->height - y < BLOCK_ROWS ? src->height : y + BLOCK_ROWS;
        const ntp_rect area = { 0, y, src->width, end };
        const ntp_status status = ntp_curvature(&map, src, how, &area);
        ok = status == NTP_OK ? interrupted_by == 0 &&
                                    production_write(p, map.data, map.row_stride, &area, error)
                              : library_error(&p->s, status, error);
    }
    free(map.data);
    return ok;
}

static bool finish(production *p, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const bool is_float = st->relief.type == NTP_TYPE_F32;
    ntp_const_image src;
    ntp_curvature_options how = set->how;
    if (!relief_choose_borders(p, error) || !find_surface(p, &src, error))
        return false;
    how.border_x = st->relief.border_x;
    how.border_y = st->relief.border_y;
    how.scale = relief_is_height(p) ? st->relief.scale : 1;
    if (is_float)
        how.range = 0;
    const ntp_status status = is_float ? NTP_OK : find_range(&src, &how);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    st->range = how.range;
    return relief_start(p, is_float ? NULL : RANGE_KEY, how.range, error) &&
           write_map(p, &src, &how, error);
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const char *kind = KINDS[set->how.kind];
    if (line != NULL) {
        text_addf(line, "%s curvature ", kind);
        relief_describe(p, line, NULL);
        if (st->range > 0)
            text_addf(line, ", range %.9g", st->range);
    }
    if (object == NULL)
        return;
    relief_describe(p, NULL, object);
    json_object_set_new(object, "kind", json_string(kind));
    json_object_set_new(object, "range", st->range > 0 ? json_real(st->range) : json_null());
}

int curvature_run(const options *o)
{
    settings set;
    if (!relief_read_settings(&set.relief, o))
        return NTP_EXIT_USAGE;
    set.how = (ntp_curvature_options) { .kind = (ntp_curvature_kind) option_integer(o, OPT_KIND),
                                        .range = option_number(o, OPT_RANGE) };
    const maker m = { .o = o,
                      .forced = forced_class(o),
                      .takes_heights = true,
                      .plan = PLAN_AFTER_READING,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .knows = relief_knows,
                      .begin = relief_begin,
                      .rows = relief_rows,
                      .finish = finish,
                      .describe = describe };
    return produce(&m);
}
