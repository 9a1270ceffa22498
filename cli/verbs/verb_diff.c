/* SPDX-License-Identifier: MIT */
/*
 * verb_diff.c - ntp diff: two textures, in levels and degrees
 */
#include <stdlib.h>
#include <string.h>

#include "examine/hold_image.h"
#include "examine/samples.h"
#include "report/report.h"
#include "verbs/diff_details.h"
#include "verbs/verbs.h"

typedef struct side {
    input in;
    ntpio_limits limits;
    worker *w;
    source s;
    facts f;
} side;

typedef struct comparison {
    const options *o;
    side a, b;
    bool sizes_agree;
    ntp_diff *diff;
    ntp_diff_stats stats;
    diff_details details;
    ntpio_writer *writer;
} comparison;

/* A DDS or KTX2? */
static bool is_of_gpus(const side *s)
{
    return s->s.info->layout[0] != 0;
}

/* Two channels, or those of DXT5nm. */
static bool has_no_blue(const side *s)
{
    return s->s.info->red_green ||
           (is_of_gpus(s) && (s->f.type.accidents & NTP_ACCIDENT_DXT5NM) != 0);
}

/* A class with a confidence of 0.8 is trusted.  A texture is read as XY only if both are,
 * because XY has no blue to compare. */
static ntp_encoding encoding_of(const side *one, const side *other)
{
    const bool sure = one->f.type.confidence >= 0.8;
    if (has_no_blue(one) || (has_no_blue(other) && one->f.type.type == NTP_CLASS_XY))
        return NTP_ENCODING_XY;
    if (one->f.encoding == NTP_ENCODING_XY && other->f.encoding == NTP_ENCODING_XY)
        return NTP_ENCODING_XY;
    return one->f.encoding == NTP_ENCODING_ZZERO && sure ? NTP_ENCODING_ZZERO
                                                         : NTP_ENCODING_STANDARD;
}

static bool open_side(comparison *c, side *s, const char *path, ntpio_error *error)
{
    char *name = copy_string(path);
    s->in = (input) { .path = name, .named = true };
    s->limits = limits_from(c->o);
    s->w = worker_new();
    if (!source_open(&s->s, s->w, &s->in, &s->limits, error))
        return false;
    s->s.orient = ORIENT_SAMPLED;
    return examine(&s->s, forced_class(c->o), &s->f, error) && source_rewind(&s->s, error);
}

static void close_side(side *s)
{
    source_close(&s->s);
    facts_free(&s->f);
    if (s->w != NULL)
        worker_free(s->w);
    free(s->in.path);
}

/* With a DDS or KTX2, green is matched where both files surely show which way it points. */
static ntp_y y_of(const side *s, const side *other)
{
    const bool sure = s->f.orientation.decided && other->f.orientation.decided;
    return sure && (is_of_gpus(s) || is_of_gpus(other)) ? s->f.orientation.y : NTP_Y_UP;
}

/* Gray files become RGB, except those that hold x and y. */
static void view_side(side *s, const side *other)
{
    static const int8_t DXT5NM[3] = { 3, 1, FROM_ONE };
    const int32_t channels = s->s.info->channels;
    if (has_no_blue(s) && !s->s.info->red_green)
        source_view(&s->s, NTP_ENCODING_XY, y_of(s, other), DXT5NM, 3);
    else if (channels < 3 && s->f.encoding == NTP_ENCODING_XY)
        source_view(&s->s, NTP_ENCODING_XY, NTP_Y_UP, NULL, 0);
    else if (channels < 3)
        source_view_as_rgb(&s->s, encoding_of(s, other));
    else
        source_view(&s->s, encoding_of(s, other), y_of(s, other), NULL, 0);
}

/* Mips and blocks: of B if it is a DDS or KTX2, else of A. */
static bool look_closer(comparison *c, ntpio_error *error)
{
    side *texture = is_of_gpus(&c->b) ? &c->b : &c->a;
    side *plain = texture == &c->b ? &c->a : &c->b;
    if (!is_of_gpus(texture) || !hold_is_possible(&plain->s) || !hold_is_possible(&texture->s) ||
        texture->s.view.encoding == NTP_ENCODING_HEIGHT)
        return true;
    return source_rewind(&plain->s, error) && source_rewind(&texture->s, error) &&
           diff_details_find(&c->details, &plain->s, &texture->s, error);
}

static bool open_heat(comparison *c, ntpio_error *error)
{
    const char *output = option_string(c->o, OPT_OUTPUT);
    const ntpio_write_options shape = { .format = NTPIO_PNG,
                                        .width = c->a.s.info->width,
                                        .height = c->a.s.info->height,
                                        .channels = 3,
                                        .sample_bytes = 1,
                                        .level = -1 };
    if (output == NULL)
        return true;
    c->writer = ntpio_create(output, &shape, error);
    return c->writer != NULL;
}

static bool compare_rows(comparison *c, ntpio_error *error)
{
    const ntp_const_image a = ntp_image_as_const(&c->a.s.view);
    const ntp_const_image b = ntp_image_as_const(&c->b.s.view);
    const size_t row = (size_t) a.width * 3;
    ntp_image heat = ntp_image_packed(buffer_reserve(&c->a.w->extra, row * (size_t) a.ring_rows),
                                      a.width, a.height, 3, NTP_TYPE_U8);
    heat.ring_rows = a.ring_rows;
    heat.encoding = NTP_ENCODING_HEIGHT;
    ntp_rect area, same;
    int more;
    while ((more = source_next(&c->a.s, &area, error)) > 0) {
        if (source_next(&c->b.s, &same, error) <= 0)
            return false;
        const ntp_status status =
            ntp_diff_add(c->diff, c->writer != NULL ? &heat : NULL, &a, &b, &area);
        if (status != NTP_OK)
            return library_error(&c->a.s, status, error);
        if (c->writer != NULL && !ntpio_write_rows(c->writer, heat.data, heat.row_stride,
                                                   (uint32_t) (area.y1 - area.y0), error))
            return false;
    }
    return more == 0 && source_next(&c->b.s, &same, error) == 0;
}

static bool compare(comparison *c, ntpio_error *error)
{
    c->sizes_agree =
        c->a.s.info->width == c->b.s.info->width && c->a.s.info->height == c->b.s.info->height;
    if (!c->sizes_agree)
        return true;
    view_side(&c->a, &c->b);
    view_side(&c->b, &c->a);
    /* both files are read in blocks of the same size */
    int32_t ring = c->a.s.view.ring_rows;
    if (c->b.s.view.ring_rows < ring)
        ring = c->b.s.view.ring_rows;
    c->a.s.view.ring_rows = c->b.s.view.ring_rows = ring;
    c->a.s.block_rows = c->b.s.block_rows = ring;
    c->diff = worker_diff(c->a.w);
    if (!open_heat(c, error) || !compare_rows(c, error))
        return false;
    const ntp_status status = ntp_diff_summarize(&c->stats, c->diff);
    if (status != NTP_OK)
        return library_error(&c->a.s, status, error);
    if (!look_closer(c, error))
        return false;
    ntpio_writer *writer = c->writer;
    c->writer = NULL;
    if (writer == NULL)
        return true;
    if (source_is_current(&c->a.s, error) && source_is_current(&c->b.s, error))
        return ntpio_commit(writer, error);
    ntpio_abort(writer);
    return false;
}

static bool is_same(const comparison *c)
{
    return c->sizes_agree && c->stats.different == 0;
}

/* With --fail-over, the mean angle decides, of mips too. */
static bool fails(const comparison *c)
{
    if (!option_given(c->o, OPT_FAIL_OVER) || !c->sizes_agree)
        return !is_same(c);
    const double most = option_number(c->o, OPT_FAIL_OVER);
    bool over = c->stats.angles.mean > most;
    for (int i = 0; i < c->details.mips; i++)
        over = over || c->details.mip[i].angles.mean > most;
    return over;
}

static json_t *side_json(const side *s)
{
    json_t *object = need(json_object());
    json_set_name(object, "path", s->in.path);
    json_object_set_new(object, "width", json_integer((json_int_t) s->s.info->width));
    json_object_set_new(object, "height", json_integer((json_int_t) s->s.info->height));
    json_object_set_new(object, "bit_depth", json_integer(s->s.info->bit_depth));
    json_object_set_new(object, "channels", json_integer(s->s.info->channels));
    json_object_set_new(object, "type", json_string(ntp_class_name(s->f.type.type)));
    return object;
}

static void tell_details_json(const diff_details *d, json_t *object)
{
    json_t *blocks = need(json_array()), *mips = need(json_array());
    for (int i = 0; i < d->blocks; i++) {
        json_t *one = need(json_object());
        json_object_set_new(one, "x", json_integer(d->worst[i].x));
        json_object_set_new(one, "y", json_integer(d->worst[i].y));
        json_object_set_new(one, "angle_deg", json_angles(&d->worst[i].angles));
        json_array_append_new(blocks, one);
    }
    for (int i = 0; i < d->mips; i++) {
        json_t *one = need(json_object());
        json_object_set_new(one, "mip", json_integer(i + 1));
        json_object_set_new(one, "width", json_integer(d->mip[i].width));
        json_object_set_new(one, "height", json_integer(d->mip[i].height));
        json_object_set_new(one, "angle_deg", json_angles(&d->mip[i].angles));
        json_array_append_new(mips, one);
    }
    json_object_set_new(object, "worst_blocks", blocks);
    json_object_set_new(object, "mips", mips);
}

static void tell_details_text(const diff_details *d, text *t)
{
    if (d->mips > 0)
        text_add(t, "  mips, compared with those of ntp resize --mips\n");
    for (int i = 0; i < d->mips; i++)
        text_addf(t, "    %-2d %5d x %-5d mean %.3f, 99 %% within %.3f, at most %.3f degrees\n",
                  i + 1, (int) d->mip[i].width, (int) d->mip[i].height, d->mip[i].angles.mean,
                  d->mip[i].angles.p99, d->mip[i].angles.max);
    if (d->blocks > 0)
        text_add(t, "  blocks that are farthest off, by their first texel\n");
    for (int i = 0; i < d->blocks; i++)
        text_addf(t, "    %5d, %-5d     mean %.3f, at most %.3f degrees\n", (int) d->worst[i].x,
                  (int) d->worst[i].y, d->worst[i].angles.mean, d->worst[i].angles.max);
}

static void tell_json(const comparison *c, text *t)
{
    json_t *object = need(json_object());
    const ntp_diff_stats *d = &c->stats;
    json_object_set_new(object, "a", side_json(&c->a));
    json_object_set_new(object, "b", side_json(&c->b));
    json_object_set_new(object, "sizes_agree", json_boolean(c->sizes_agree));
    json_object_set_new(object, "same", json_boolean(is_same(c)));
    if (c->sizes_agree) {
        json_t *most = need(json_array()), *mean = need(json_array());
        for (int32_t i = 0; i < d->channels; i++) {
            json_array_append_new(most, json_count(d->levels_max[i]));
            json_array_append_new(mean, json_real(d->levels_mean[i]));
        }
        json_object_set_new(object, "texels", json_count(d->texels));
        json_object_set_new(object, "different", json_count(d->different));
        json_object_set_new(object, "max_level", json_count(d->max));
        json_object_set_new(object, "levels_max", most);
        json_object_set_new(object, "levels_mean", mean);
        json_object_set_new(object, "angle_deg", json_angles(&d->angles));
    }
    if (c->details.known)
        tell_details_json(&c->details, object);
    json_document(t, object);
}

static void tell_text(const comparison *c, text *t)
{
    static const char *const NAMES[] = { "red", "green", "blue", "alpha" };
    const ntp_diff_stats *d = &c->stats;
    if (!c->sizes_agree) {
        text_addf(t, "sizes differ: %u x %u and %u x %u\n", (unsigned) c->a.s.info->width,
                  (unsigned) c->a.s.info->height, (unsigned) c->b.s.info->width,
                  (unsigned) c->b.s.info->height);
        return;
    }
    if (d->different == 0) {
        text_add(t, "the same: ");
        text_count(t, d->texels);
        text_add(t, " texels\n");
        return;
    }
    text_count(t, d->different);
    text_add(t, " of ");
    text_count(t, d->texels);
    text_add(t, " texels differ (");
    text_percent(t, d->different, d->texels);
    text_addf(t, ")\n  angle  mean %.3f, 99 %% within %.3f, at most %.3f degrees\n", d->angles.mean,
              d->angles.p99, d->angles.max);
    for (int32_t i = 0; i < d->channels; i++)
        text_addf(t, "  %-6s mean %.3f, at most %u levels of %u\n", NAMES[i], d->levels_mean[i],
                  (unsigned) d->levels_max[i], (unsigned) d->max);
    if (c->details.known)
        tell_details_text(&c->details, t);
}

int diff_run(const options *o)
{
    const char *output = option_string(o, OPT_OUTPUT);
    if (!inputs_are_two(o, "") || (output != NULL && !output_is_allowed(output, o)))
        return NTP_EXIT_USAGE;
    if (output != NULL && strcmp(output, "-") == 0)
        output_to_stderr();
    comparison c = { .o = o };
    ntpio_error error = { 0 };
    const bool ok = open_side(&c, &c.a, o->paths[0], &error) &&
                    open_side(&c, &c.b, o->paths[1], &error) && compare(&c, &error);
    unsigned ran = 0;
    text t = { 0 };
    if (interrupted_by != 0) {
        ran = RAN_INTERRUPTED;
    } else if (!ok) {
        ran = error.status == NTPIO_ERR_USAGE ? RAN_USAGE : RAN_FAILED;
        complain("%s", error.message);
    } else {
        ran = fails(&c) ? RAN_FINDINGS : 0;
        if (option_integer(o, OPT_FORMAT) == 1)
            tell_json(&c, &t);
        else if (!option_given(o, OPT_QUIET))
            tell_text(&c, &t);
    }
    output_text(&t);
    text_free(&t);
    ntpio_abort(c.writer);
    close_side(&c.a);
    close_side(&c.b);
    return exit_code(ran);
}
