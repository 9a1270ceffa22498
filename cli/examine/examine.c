/* SPDX-License-Identifier: MIT */
/*
 * examine.c - finding out what a file is
 *
 * A file is first measured as a standard texture.  It is read a second time if its class changes
 * what was measured: angles in 16 bit, whether alpha 0 means unused, x and y in gray and alpha.
 */
#include "examine/examine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "examine/middle_and_lines.h"
#include "os/memory.h"

ntpio_limits limits_from(const options *o)
{
    return (ntpio_limits) { .max_side = (uint32_t) option_integer(o, OPT_MAX_SIDE),
                            .max_texels = (uint64_t) option_integer(o, OPT_MAX_TEXELS),
                            .max_at_once = /* never 0: that is the default */
                            ((uint64_t) option_integer(o, OPT_MAX_AT_ONCE) << 20) + 1,
                            .mip = (uint32_t) option_integer(o, OPT_MIP),
                            .layer_and_one = option_given(o, OPT_LAYER)
                                                 ? 1 + (uint32_t) option_integer(o, OPT_LAYER)
                                                 : 0,
                            .pairs_as_rgb = true,
                            .vectors_as_texels = true };
}

int forced_class(const options *o)
{
    return (int) option_integer(o, OPT_TYPE) - 1; /* the choices are in the order of ntp_class */
}

/* ----------------------------------------------------------------------- the class */

ntp_encoding class_encoding(ntp_class type, int32_t channels)
{
    if (type == NTP_CLASS_XY && channels == 2) /* gray is x, alpha y */
        return NTP_ENCODING_XY;
    if (type == NTP_CLASS_HEIGHT || channels < 3)
        return NTP_ENCODING_HEIGHT;
    return type == NTP_CLASS_ZZERO ? NTP_ENCODING_ZZERO
           : type == NTP_CLASS_XY  ? NTP_ENCODING_XY
                                   : NTP_ENCODING_STANDARD;
}

bool class_is_tangent(ntp_class type)
{
    return type == NTP_CLASS_STANDARD || type == NTP_CLASS_ZZERO || type == NTP_CLASS_XY;
}

bool class_is_normals(ntp_class type)
{
    return class_is_tangent(type) || type == NTP_CLASS_OBJECT_SPACE;
}

bool facts_are_tangent(const facts *f)
{
    const uint32_t misplaced =
        NTP_ACCIDENT_RED_IS_Z | NTP_ACCIDENT_GREEN_IS_Z | NTP_ACCIDENT_DXT5NM | NTP_ACCIDENT_GAMMA;
    return f->encoding != NTP_ENCODING_HEIGHT && (f->type.accidents & misplaced) == 0 &&
           class_is_tangent(f->type.type);
}

const char *class_title(ntp_class type)
{
    switch (type) {
    case NTP_CLASS_STANDARD:
        return "standard";
    case NTP_CLASS_ZZERO:
        return "Z-zero";
    case NTP_CLASS_XY:
        return "XY-only";
    case NTP_CLASS_HEIGHT:
        return "height map";
    case NTP_CLASS_OBJECT_SPACE:
        return "object-space";
    case NTP_CLASS_ONE_COLOR:
        return "one color";
    default:
        return "not a normals texture";
    }
}

/* LabPBR textures have a height in alpha: there, alpha 0 is a depth and not a hole.  But an
 * alpha of only 0 and M is a mask. */
uint32_t touch_for(const ntp_stats *stats, ntp_encoding encoding)
{
    const bool mask = stats->alpha_zero + stats->alpha_full == stats->texels;
    return encoding == NTP_ENCODING_XY && stats->channels == 4 && !mask ? NTP_UNUSED_TRANSPARENT
                                                                        : 0;
}

void facts_free(facts *f)
{
    free(f->levels);
    *f = (facts) { 0 };
}

static void keep_levels(facts *f, source *s)
{
    worker *w = s->w;
    /* Few levels are common; only unused texels may be further off than that. */
    size_t size = (size_t) f->stats.levels_off_max[f->encoding == NTP_ENCODING_ZZERO] + 1;
    if (w->histogram == NULL)
        w->histogram = need(os_alloc_zeros(HISTOGRAM_SIZE));
    if (ntp_tally_levels_off(w->histogram, size, w->tally, f->encoding) != NTP_OK) {
        size = (size_t) f->stats.max + 1;
        if (ntp_tally_levels_off(w->histogram, size, w->tally, f->encoding) != NTP_OK)
            return;
    }
    size_t count = 0;
    for (size_t i = 0; i < size; i++)
        count += w->histogram[i] != 0;
    free(f->levels);
    f->levels = need(calloc(count + 1, sizeof *f->levels));
    f->level_count = 0;
    for (size_t i = 0; i < size; i++) {
        if (w->histogram[i] != 0)
            f->levels[f->level_count++] = (level_count) { (uint32_t) i, w->histogram[i] };
    }
}

/* The first of two readings may have another encoding; it has no harm. */
static void measure_harm(facts *f, source *s)
{
    static const uint32_t KINDS[HARM_KINDS] = { NTP_HARM_LENGTH | NTP_HARM_XY, NTP_HARM_XY,
                                                NTP_HARM_Z_NEGATIVE };
    for (int i = 0; i < HARM_KINDS; i++) {
        if (f->encoding == NTP_ENCODING_HEIGHT ||
            ntp_tally_harm(&f->harm[i], s->w->tally, f->encoding, KINDS[i], s->max_angle) != NTP_OK)
            f->harm[i] = (ntp_harm) { 0 };
    }
}

bool facts_from_tally(facts *f, source *s, int forced, ntpio_error *error)
{
    f->in = s->in;
    f->info = *s->info;
    f->info.texts = NULL;
    f->info.text_count = 0;
    f->forced = forced >= 0;
    /* heights are not read in a way of their own: they are counted like any other encoding */
    const ntp_encoding read_as =
        s->view.encoding == NTP_ENCODING_HEIGHT ? NTP_ENCODING_STANDARD : s->view.encoding;
    ntp_status status = ntp_tally_summarize(&f->stats, s->w->tally, read_as);
    if (status == NTP_OK)
        status = ntp_classify(&f->type, s->w->tally);
    if (status != NTP_OK)
        return library_error(s, status, error);
    if (forced >= 0) {
        f->type.type = (ntp_class) forced;
        f->type.confidence = 1;
    }
    f->encoding = class_encoding(f->type.type, s->view.channels);
    if (s->view.type == NTP_TYPE_U8 && f->encoding != s->view.encoding &&
        f->encoding != NTP_ENCODING_HEIGHT && s->view.encoding != NTP_ENCODING_HEIGHT)
        status = ntp_tally_summarize(&f->stats, s->w->tally, f->encoding);
    if (status != NTP_OK)
        return library_error(s, status, error);
    measure_harm(f, s);
    f->counts = s->in->named || s->in->hinted || class_is_normals(f->type.type);
    if (f->encoding == NTP_ENCODING_STANDARD || f->encoding == NTP_ENCODING_ZZERO)
        keep_levels(f, s);
    return true;
}

void first_view(source *s, int forced)
{
    const bool gray = s->info->channels < 3;
    const bool pair = s->info->channels == 2 && forced == NTP_CLASS_XY;
    if (forced >= 0 && forced != NTP_CLASS_HEIGHT && gray && !pair)
        source_view_as_rgb(s, class_encoding((ntp_class) forced, 3));
    else if (forced >= 0)
        source_view(s, class_encoding((ntp_class) forced, s->info->channels), NTP_Y_UP, NULL, 0);
    else
        source_view(s, gray ? NTP_ENCODING_HEIGHT : NTP_ENCODING_STANDARD, NTP_Y_UP, NULL, 0);
}

/* Puts large pages where counts lie (ntp_tally_size says where).  The system clears one in the time of 30 to
 * 150 faults, and textures of MANY texels cause 100 to 300.  In large ones of 8 bit many colors may be far from
 * exact; those counts lie behind the others. */
static void large_pages(source *s)
{
    enum { MANY = 128 * 128, MORE = 512 * 512, PAGE = 2 << 20 };
    const int64_t texels = (int64_t) s->view.width * s->view.height;
    unsigned char *const counts = (unsigned char *) s->w->tally;
    if (texels < MANY || s->view.encoding == NTP_ENCODING_HEIGHT)
        return;
    if (s->view.type != NTP_TYPE_U8)
        os_large_pages(counts + 6 * PAGE, PAGE);
    else
        os_large_pages(counts, texels < MORE ? PAGE : 2 * PAGE);
}

static bool measure(source *s, uint32_t touch, ntpio_error *error)
{
    large_pages(s);
    ntp_tally_clear(s->w->tally);
    orient_begin(s);
    middle_begin(s);
    const ntp_const_image view = ntp_image_as_const(&s->view);
    ntp_rect area;
    int more;
    while ((more = source_next(s, &area, error)) > 0) {
        ntp_status status = ntp_tally_add(s->w->tally, &view, touch, &area);
        if (status == NTP_OK)
            status = orient_rows(s, &area, touch);
        if (status != NTP_OK)
            return library_error(s, status, error);
        middle_rows(s, &area);
    }
    return more == 0;
}

bool examine_as_seen(source *s, int forced, facts *f, ntpio_error *error)
{
    if (!measure(s, 0, error) || !facts_from_tally(f, s, forced, error))
        return false;
    orient_end(s, f);
    const uint32_t touch = touch_for(&f->stats, f->encoding);
    const bool pair = f->encoding == NTP_ENCODING_XY && s->view.encoding == NTP_ENCODING_HEIGHT;
    const bool angles_differ = f->encoding != s->view.encoding && s->view.type != NTP_TYPE_U8;
    const bool alpha_differs = touch != 0 && f->stats.transparent > 0;
    s->view.encoding = f->encoding;
    if (!pair && !angles_differ && !alpha_differs)
        return true;
    const ntp_classification type = f->type; /* settled by the first reading */
    const bool counts = f->counts;
    if (!source_rewind(s, error) || !measure(s, touch, error) ||
        !facts_from_tally(f, s, (int) type.type, error))
        return false;
    f->type = type;
    f->forced = forced >= 0;
    f->counts = counts;
    orient_end(s, f);
    return true;
}

bool examine(source *s, int forced, facts *f, ntpio_error *error)
{
    first_view(s, forced);
    return examine_as_seen(s, forced, f, error);
}
