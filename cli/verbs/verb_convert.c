/* SPDX-License-Identifier: MIT */
/*
 * verb_convert.c - ntp convert: encoding, depth, direction of green, layout of channels
 *
 * The library converts to x, y, z and alpha in the depth of the output.  Then letters say which of
 * them goes into which channel of the file.
 *
 * What is not asked for stays: without --to the encoding, without --to-y green.  (Where --type or
 * --y says what the input is, the defaults are standard and up.)  What must be known of the input
 * for that and is not said is found out; if that is not sure, the file is refused with a question.
 */
#include <string.h>
#include <strings.h>

#include "examine/samples.h"
#include "options/names.h"
#include "report/report.h"
#include "verbs/verbs.h"
#include "write/green.h"
#include "write/side_image.h"
#include "write/texture_output.h"
#include "write/whole_image.h"

enum {
    FULL = 4,    /* channels of the converted rows: x, y, z, alpha */
    NOTHING = -3 /* a channel of the input that holds nothing of use */
};

/* Below this, a type is not used where it makes a difference; the same as for green. */
static const double SURE_OF_TYPE = 0.9;

enum { AS_INPUT = -1 };

typedef struct settings {
    int type;          /* of --type, an ntp_class, or -1 */
    int to;            /* an ntp_encoding, or AS_INPUT */
    int y;             /* of --y, or -1 */
    int to_y;          /* or AS_INPUT */
    bool seeks_y;      /* green has to be found out */
    bool lacks_z;      /* by --from-channels */
    int depth;         /* bytes of a sample; 0: as the input */
    int8_t out[FULL];  /* for each channel of the file: 0..3 of the converted rows, or FROM_* */
    int32_t out_count; /* 0: as the input */
    int8_t in[FULL];   /* for each channel of the view: a channel of the file, or FROM_* */
    int32_t in_count;  /* 0: as the input */
    int32_t in_needed; /* channels that the file must have */
    ntp_convert_options how;
} settings;

typedef struct state {
    ntp_encoding from, to;
    green y; /* of the input */
    ntp_y to_y;
    ntp_convert_counts counts;
    ntp_image full; /* the converted rows */
    ntp_diff *diff; /* input against output, where a report asks for it */
    texture_output texture;
    int32_t out_channels;
    size_t out_row; /* bytes of a row of the file */
} state;

/* --------------------------------------------------------------------- the letters */

static int8_t letter_meaning(char letter)
{
    switch (letter) {
    case 'x':
        return 0;
    case 'y':
        return 1;
    case 'z':
        return 2;
    case 'a':
        return 3;
    case '0':
        return FROM_ZERO;
    case '1':
        return FROM_ONE;
    default:
        return NOTHING;
    }
}

static bool wrong_spec(const char *option, const char *spec, const char *problem)
{
    complain("--%s %s: %s", option, spec, problem);
    return false;
}

static bool read_output_spec(settings *set, const char *spec)
{
    if (spec == NULL)
        return true;
    const size_t length = strlen(spec);
    if (length < 1 || length > FULL)
        return wrong_spec("channels", spec, "expected one letter for each channel, 1 to 4 of them");
    for (size_t i = 0; i < length; i++) {
        set->out[i] = letter_meaning(spec[i]);
        if (spec[i] == 'h')
            return wrong_spec("channels", spec, "there is no height in a normals texture");
        if (set->out[i] == NOTHING)
            return wrong_spec("channels", spec, "the letters are x y z 0 1 a");
    }
    set->out_count = (int32_t) length;
    return true;
}

static bool read_input_spec(settings *set, const char *spec)
{
    if (spec == NULL)
        return true;
    const size_t length = strlen(spec);
    int8_t where[FULL] = { NOTHING, NOTHING, NOTHING, NOTHING };
    if (length < 2 || length > FULL)
        return wrong_spec("from-channels", spec,
                          "expected one letter for each channel, 2 to 4 of them");
    for (size_t i = 0; i < length; i++) {
        const int8_t meaning = letter_meaning(spec[i]);
        if (meaning == NOTHING && spec[i] != '-')
            return wrong_spec("from-channels", spec, "the letters are x y z a 0 1 -");
        if (meaning >= 0 && where[meaning] != NOTHING)
            return wrong_spec("from-channels", spec, "a letter is used twice");
        if (meaning >= 0)
            where[meaning] = (int8_t) i;
    }
    if (where[0] == NOTHING || where[1] == NOTHING)
        return wrong_spec("from-channels", spec, "x and y are needed");
    if (where[2] == NOTHING) {
        where[2] = FROM_ONE;
        set->lacks_z = true;
    }
    memcpy(set->in, where, sizeof where);
    set->in_count = where[3] == NOTHING ? 3 : 4;
    set->in_needed = (int32_t) length;
    return true;
}

/* ------------------------------------------------------------------------ the input */

static bool only_depth(const settings *set)
{
    return set->to == AS_INPUT && set->to_y == AS_INPUT && set->out_count == 0;
}

/* While a file is read for the first time, it is taken for a standard texture. */
static ntp_encoding input_encoding(const production *p)
{
    const settings *set = p->m->settings;
    const int told = set->type >= 0 ? set->type : p->forced;
    if (set->lacks_z)
        return NTP_ENCODING_XY;
    if (told >= 0)
        return told == NTP_CLASS_HEIGHT ? NTP_ENCODING_HEIGHT : class_encoding((ntp_class) told, 3);
    if (set->in_count > 0)
        return NTP_ENCODING_STANDARD;
    return p->known ? p->f.encoding : p->s.view.encoding;
}

/* Is y not 0 in any texel that is converted? */
static bool has_y(const production *p)
{
    const settings *set = p->m->settings;
    const bool touched = set->how.touch_unused != 0 && p->f.stats.unused > 0;
    return touched || !slopes_are_flat(p->f.most.y, &p->f.stats);
}

/* Sets *g and returns true if green is known, or nothing depends on it. */
static bool find_y(const production *p, green *g)
{
    const settings *set = p->m->settings;
    const bool asked = set->to_y != AS_INPUT;
    if (set->y < 0 && !asked) {
        *g = (green) { NTP_Y_UP, GREEN_UNNEEDED, 0 };
        return true;
    }
    if (green_find(g, set->y, &p->f))
        return true;
    const bool needed = has_y(p);
    if (!needed)
        *g = (green) { (ntp_y) set->to_y, GREEN_UNNEEDED, 0 };
    return !needed;
}

/* Which encoding the input has makes a difference only for another one. */
static bool type_is_known(const production *p)
{
    const settings *set = p->m->settings;
    return set->to == AS_INPUT || p->f.forced || set->type >= 0 || set->in_count > 0 ||
           p->f.type.type == NTP_CLASS_ONE_COLOR || p->f.type.confidence >= SURE_OF_TYPE;
}

static bool knows(production *p, text *why)
{
    green g;
    const bool known = type_is_known(p);
    if (!known) {
        text_addf(why, "it looks %s, %.0f %% sure; which is it, --type standard, zzero or xy?",
                  class_title(p->f.type.type), 100 * p->f.type.confidence);
        return false;
    }
    if (find_y(p, &g))
        return true;
    green_ask(why, &p->f, "--y");
    return false;
}

static void resolve(production *p)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    st->from = input_encoding(p);
    st->to = set->to == AS_INPUT ? st->from : (ntp_encoding) set->to;
    find_y(p, &st->y);
    st->to_y = set->to_y == AS_INPUT ? st->y.y : (ntp_y) set->to_y;
}

/* ------------------------------------------------------------------------- the rows */

static ntp_type output_type(const production *p, const settings *set)
{
    const char *output = p->in->output;
    const bool pfm = output != NULL && strcasecmp(name_ending(output), ".pfm") == 0;
    if (set->depth != 0)
        return set->depth == 1 ? NTP_TYPE_U8 : NTP_TYPE_U16;
    return p->s.view.type == NTP_TYPE_F32 && !pfm ? NTP_TYPE_U16 : p->s.view.type;
}

/* Sets how the input is seen; until now it was seen as a standard texture. */
static bool view_input(production *p, ntpio_error *error)
{
    static const int8_t PAIR[3] = { 0, 1, FROM_ONE };
    const settings *set = p->m->settings;
    const state *st = p->state;
    const int32_t channels = p->s.info->channels;
    const ntp_y y = st->y.y;
    const bool pair = channels == 2 && (set->type == NTP_CLASS_XY || p->forced == NTP_CLASS_XY);
    if (set->in_count > 0) {
        if (set->in_needed > channels)
            return wrong_use(p, "--from-channels names more channels than the image has", error);
        source_view(&p->s, st->from, y, set->in, set->in_count);
    } else if (channels >= 3 && st->from != NTP_ENCODING_HEIGHT) {
        source_view(&p->s, st->from, y, NULL, 0);
    } else if (pair) {
        source_view(&p->s, NTP_ENCODING_XY, y, PAIR, 3);
    } else {
        const bool as_told = set->type >= 0 && set->type != NTP_CLASS_HEIGHT;
        const bool same = set->to == AS_INPUT || (as_told && st->from == st->to);
        if (set->out_count > 0 || !same || y != st->to_y)
            return wrong_use(
                p,
                "heights are not normals; only --depth can convert them (--type xy takes gray and "
                "alpha for x and y)",
                error);
        source_view(&p->s, NTP_ENCODING_HEIGHT, NTP_Y_UP, NULL, 0);
    }
    return true;
}

/* DDS and KTX2 have x and y in red and green, or are not compressed and have one size. */
static bool begin_texture(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const bool height = st->full.encoding == NTP_ENCODING_HEIGHT;
    const bool other = set->out_count > 0 && (set->out[0] != 0 || set->out[1] != 1);
    const bool lacks_z = set->out_count > 2 && set->out[2] != 2;
    ntp_image rows =
        ntp_image_packed(NULL, st->full.width, st->full.height, st->out_channels, st->full.type);
    rows.y = st->full.y;
    rows.encoding = height                             ? NTP_ENCODING_HEIGHT
                    : st->out_channels == 2 || lacks_z ? NTP_ENCODING_XY
                    : st->out_channels == 1            ? NTP_ENCODING_HEIGHT
                                                       : st->full.encoding;
    if (!texture_begin(&st->texture, p, &rows, shape, error))
        return false;
    st->texture.touch_unused |= set->how.touch_unused;
    return !st->texture.used || !other ||
           (st->texture.how.blocks == NTPIO_BLOCKS_NONE && !st->texture.how.mips) ||
           wrong_use(p,
                     "BC5 and mips need x, y first in --channels; --compression none takes others",
                     error);
}

static bool begin(production *p, ntpio_write_options *shape, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    resolve(p);
    if (!view_input(p, error))
        return false;
    const ntp_image *view = &p->s.view;
    const bool height = view->encoding == NTP_ENCODING_HEIGHT;
    const int32_t full_channels = height ? view->channels : FULL;
    const ntp_type type = output_type(p, set);
    const size_t row = (size_t) view->width * (size_t) full_channels * sample_size(type);
    st->full = ntp_image_packed(buffer_reserve(&p->w->extra, row * (size_t) p->s.block_rows),
                                view->width, view->height, full_channels, type);
    st->full.ring_rows = p->s.block_rows;
    st->full.encoding = height ? NTP_ENCODING_HEIGHT : st->to;
    st->full.y = height ? NTP_Y_UP : st->to_y;
    const bool stays_pair =
        p->s.info->channels == 2 && set->in_count == 0 && st->to == NTP_ENCODING_XY;
    st->out_channels = set->out_count > 0 ? set->out_count : stays_pair ? 2 : view->channels;
    st->out_row = (size_t) view->width * (size_t) st->out_channels * sample_size(type);
    if (option_integer(p->m->o, OPT_FORMAT) == 1 && !height)
        st->diff = worker_diff(p->w);
    shape->channels = st->out_channels;
    shape->as_it_came = p->s.info;
    shape->sample_bytes = (int32_t) sample_size(type);
    p->changes = !option_given(p->m->o, OPT_IN_PLACE) || type != view->type ||
                 st->out_channels != p->s.info->channels;
    return begin_texture(p, shape, error);
}

static const int8_t PLAIN[FULL] = { 0, 1, 2, 3 };

/* Is each channel of the rows for the file the same as in the input?  The view may show the
 * channels of the input in another order. */
static bool rows_are_same(const production *p, const ntp_rect *area)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const ntp_image *view = &p->s.view;
    const size_t size = sample_size(view->type);
    const int8_t *out = set->out_count > 0 ? set->out : PLAIN;
    const size_t texels = (size_t) view->width * (size_t) (area->y1 - area->y0);
    for (int32_t c = 0; c < st->out_channels; c++) {
        const int8_t from = out[c];
        if (from < 0 || from >= view->channels || (p->s.mapped ? p->s.map[from] : from) != c)
            return false;
        const unsigned char *was = source_rows(&p->s, area) + (size_t) from * size;
        const unsigned char *is = (const unsigned char *) st->full.data + (size_t) from * size;
        for (size_t i = 0; i < texels; i++) {
            if (memcmp(was + i * (size_t) view->channels * size,
                       is + i * (size_t) st->full.channels * size, size) != 0)
                return false;
        }
    }
    return true;
}

static bool rows(production *p, const ntp_rect *area, ntpio_error *error)
{
    const settings *set = p->m->settings;
    state *st = p->state;
    const ntp_const_image seen = ntp_image_as_const(&p->s.view);
    const ntp_const_image made = ntp_image_as_const(&st->full);
    ntp_convert_options how = set->how;
    how.touch_unused |= p->touch;
    ntp_status status = ntp_convert(&st->full, &seen, &how, &st->counts, area);
    if (status == NTP_OK && st->diff != NULL)
        status = ntp_diff_add(st->diff, NULL, &seen, &made, area);
    if (status != NTP_OK)
        return library_error(&p->s, status, error);
    if (!p->changes)
        p->changes = !rows_are_same(p, area);
    if (st->full.encoding == NTP_ENCODING_HEIGHT)
        return production_write(p, st->full.data, st->full.row_stride, area, error);
    void *out = buffer_reserve(&p->w->extra2, st->out_row * (size_t) p->s.block_rows);
    const channel_order order = { st->full.type, st->out_channels, FULL,
                                  set->out_count > 0 ? set->out : PLAIN };
    reorder_channels(out, st->full.data, &order,
                     (size_t) p->s.view.width * (size_t) (area->y1 - area->y0));
    return production_write(p, out, (ptrdiff_t) st->out_row, area, error);
}

/* --------------------------------------------------------------------- what was done */

static bool looks_different(const production *p)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    const ntp_class type = p->f.type.type;
    return set->in_count == 0 && type <= NTP_CLASS_XY && p->f.type.confidence > 0.8 &&
           (ntp_encoding) type != st->from && p->s.view.encoding != NTP_ENCODING_HEIGHT;
}

static void describe_green(const production *p, text *line)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    if (set->to_y == AS_INPUT)
        return;
    if (st->y.by == GREEN_UNNEEDED)
        text_add(line, ", nothing slopes up or down");
    else if (st->y.y != st->to_y)
        text_addf(line, ", green from %s to %s", y_name(st->y.y), y_name(st->to_y));
    else
        text_addf(line, ", green already %s", y_name(st->to_y));
    if (st->y.by == GREEN_BY_TEXELS)
        text_addf(line, " (%.0f %% sure)", 100 * st->y.confidence);
}

static void describe_text(const production *p, text *line)
{
    const state *st = p->state;
    if (p->s.view.encoding == NTP_ENCODING_HEIGHT)
        text_add(line, "heights");
    else if (st->from != st->to)
        text_addf(line, "%s to %s", encoding_name(st->from), encoding_name(st->to));
    else
        text_add(line, encoding_name(st->from));
    describe_green(p, line);
    if (st->texture.used && st->texture.how.blocks != NTPIO_BLOCKS_NONE)
        text_add(line, ",");
    else
        text_addf(line, ", %zu bit", 8 * sample_size(st->full.type));
    texture_describe(&st->texture, line);
    const struct {
        uint64_t count;
        const char *what;
    } COUNTS[] = { { st->counts.z_negative, "with negative z made positive" },
                   { st->counts.pulled, "with x, y too long shortened to length 1" },
                   { st->counts.not_finite, "that are not finite made flat" } };
    for (size_t i = 0; i < sizeof COUNTS / sizeof COUNTS[0]; i++) {
        if (COUNTS[i].count == 0)
            continue;
        text_add(line, "; ");
        text_count(line, COUNTS[i].count);
        text_addf(line, " texels %s", COUNTS[i].what);
    }
    if (looks_different(p))
        text_addf(line, "\n  note: the input looks %s, but was read as --type %s says",
                  class_title(p->f.type.type), encoding_name(st->from));
}

static void describe(const production *p, text *line, json_t *object)
{
    const settings *set = p->m->settings;
    const state *st = p->state;
    if (line != NULL)
        describe_text(p, line);
    if (object == NULL)
        return;
    ntp_diff_stats stats;
    const bool known = st->diff != NULL && ntp_diff_summarize(&stats, st->diff) == NTP_OK;
    json_set_changes(object, known ? &stats : NULL);
    json_object_set_new(object, "from", json_string(encoding_name(st->from)));
    json_object_set_new(object, "to", json_string(encoding_name(st->to)));
    green_report(object, "from_y", &st->y);
    json_object_set_new(object, "to_y",
                        set->to_y == AS_INPUT ? json_null() : json_string(y_name(st->to_y)));
    json_object_set_new(object, "depth", json_integer(8 * (json_int_t) sample_size(st->full.type)));
    json_object_set_new(object, "channels", json_integer(st->out_channels));
    if (st->texture.used) {
        json_object_set_new(object, "compression", json_string(texture_compression(&st->texture)));
        json_object_set_new(object, "mips", json_integer(texture_mips(&st->texture)));
    }
    json_object_set_new(object, "z_negative", json_count(st->counts.z_negative));
    json_object_set_new(object, "pulled", json_count(st->counts.pulled));
    json_object_set_new(object, "not_finite", json_count(st->counts.not_finite));
    json_object_set_new(object, "texels", json_count(p->f.stats.texels));
}

/* The defaults of --to and --to-y depend on what is said of the input. */
static bool read_targets(settings *set, const options *o)
{
    const bool told = (set->type >= 0 && set->type != NTP_CLASS_HEIGHT) || set->in_count > 0;
    set->to = option_given(o, OPT_TO) ? (int) option_integer(o, OPT_TO)
              : told                  ? NTP_ENCODING_STANDARD
                                      : AS_INPUT;
    set->to_y = option_given(o, OPT_TO_Y) ? (int) option_integer(o, OPT_TO_Y)
                : set->y >= 0             ? NTP_Y_UP
                                          : AS_INPUT;
    set->seeks_y = set->to_y != AS_INPUT && set->y < 0;
    if (!set->seeks_y || set->in_count == 0)
        return true;
    complain("--to-y with --from-channels needs --y: in channels of another order it is not "
             "detected which way green points");
    return false;
}

int convert_run(const options *o)
{
    settings set = {
        .type = forced_class(o),
        .y = green_told(o, OPT_Y),
        .depth = option_given(o, OPT_DEPTH) ? (int) option_integer(o, OPT_DEPTH) + 1 : 0,
        .how = { .touch_unused = option_given(o, OPT_TOUCH_UNUSED) ? NTP_UNUSED_ALL : 0 },
    };
    if (!read_output_spec(&set, option_string(o, OPT_CHANNELS)) ||
        !read_input_spec(&set, option_string(o, OPT_FROM_CHANNELS)) || !read_targets(&set, o))
        return NTP_EXIT_USAGE;
    const bool as_told = !set.seeks_y && (set.type >= 0 || set.in_count > 0);
    const maker m = { .o = o,
                      .forced = as_told ? -1 : set.type,
                      .any_order = only_depth(&set),
                      .takes_heights = only_depth(&set),
                      .finds_green = set.seeks_y,
                      .plan = as_told       ? PLAN_AS_TOLD
                              : set.seeks_y ? PLAN_MEASURE_FIRST
                                            : PLAN_WHILE_READING,
                      .state_size = sizeof(state),
                      .settings = &set,
                      .knows = knows,
                      .begin = begin,
                      .rows = rows,
                      .describe = describe };
    return produce(&m);
}
