/* SPDX-License-Identifier: MIT */
/*
 * report_text.c - a report in the words of `ntp check -v`: a headline, and the findings, the worst
 * first
 *
 * What concerns a file rather than its texels is left out, and so are commands.
 */
#include "report_text.h"
#include "text/numbers.h"

#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define N_(TEXT) TEXT

enum { MOST_FINDINGS = 24 };

typedef struct finding {
    finding_level level;
    int number; /* as in NT001 */
    char text[400];
} finding;

typedef struct writer {
    report *r;
    size_t length;
    const char *(*translate)(const char *text);
    number_words words;
    finding findings[MOST_FINDINGS];
    int count;
} writer;

static const char *tr(const writer *w, const char *text)
{
    return w->translate != NULL ? w->translate(text) : text;
}

#if defined(__GNUC__)
#  define FORMAT(STRING, FIRST) __attribute__((format(printf, STRING, FIRST)))
#else
#  define FORMAT(STRING, FIRST)
#endif

static void FORMAT(2, 3) add(writer *w, const char *format, ...)
{
    const size_t room = sizeof w->r->text - w->length;
    va_list arguments;
    va_start(arguments, format);
    const int more = vsnprintf(w->r->text + w->length, room, format, arguments);
    va_end(arguments);
    w->length += more < 0 ? 0 : (size_t) more < room ? (size_t) more : room - 1;
}

static void FORMAT(4, 5) found(writer *w, int number, finding_level level, const char *format, ...)
{
    if (w->count == MOST_FINDINGS)
        return;
    finding *f = &w->findings[w->count++];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(f->text, sizeof f->text, format, arguments);
    va_end(arguments);
    f->level = level;
    f->number = number;
}

/* More words at the end of the last finding. */
static void FORMAT(2, 3) more(writer *w, const char *format, ...)
{
    finding *f = &w->findings[w->count - 1];
    const size_t length = strlen(f->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(f->text + length, sizeof f->text - length, format, arguments);
    va_end(arguments);
}

/* "12.3 % of the texels (12,345)" */
typedef struct share {
    char text[160];
} share;

static share share_of(const writer *w, uint64_t count)
{
    const ntp_stats *s = &w->r->stats;
    char percent[NUMBER_SIZE], texels[NUMBER_SIZE];
    share made;
    number_percent(percent, count, w->r->used, &w->words);
    number_count(texels, count, &w->words);
    snprintf(made.text, sizeof made.text,
             tr(w, s->unused + s->padding > 0 ? N_("%s of the used texels (%s)")
                                              : N_("%s of the texels (%s)")),
             percent, texels);
    return made;
}

static finding_level level_of(const writer *w, report_harm harm)
{
    return counts_level(&w->r->harm[harm], w->r->used, COUNTS_MAX_ANGLE, COUNTS_MAX_FAIL);
}

/* Of what makes lengths wrong, such as compression: a warning where they are visibly wrong. */
static finding_level level_of_cause(const writer *w)
{
    return level_of(w, REPORT_LENGTH) == LEVEL_INFO ? LEVEL_INFO : LEVEL_WARNING;
}

static void add_visible(writer *w, report_harm harm)
{
    char percent[NUMBER_SIZE];
    if (w->r->harm[harm].over == 0)
        return;
    number_percent(percent, w->r->harm[harm].over, w->r->used, &w->words);
    more(w, tr(w, N_("; %s are off by more than %g degrees")), percent, COUNTS_MAX_ANGLE);
}

/* ------------------------------------------------------------------- what a texture is */

static void find_xy(writer *w)
{
    const bool nothing = (w->r->type.accidents & NTP_ACCIDENT_BLUE_CONSTANT) != 0;
    if (!nothing && counts_alpha_map(&w->r->stats))
        found(w, 6, LEVEL_INFO, "%s",
              tr(w, N_("only red and green hold a normal; blue is not z and is not judged")));
    else if (!nothing)
        found(
            w, 6, LEVEL_WARNING, "%s",
            tr(w, N_("only red and green hold a normal; blue is not their z, but noise or another "
                     "map")));
    else
        found(w, 4, LEVEL_WARNING,
              tr(w, N_("red and green hold normals, and blue holds nothing (about %u throughout)")),
              (unsigned) (255 * w->r->stats.used_mean[2] + 0.5));
}

static void find_class(writer *w)
{
    switch (w->r->type.type) {
    case NTP_CLASS_ZZERO:
        found(w, 5, LEVEL_WARNING, "%s", tr(w, N_("blue stores z in 0..1 (Z-zero), not in -1..1")));
        break;
    case NTP_CLASS_XY:
        find_xy(w);
        break;
    case NTP_CLASS_HEIGHT:
        found(w, 7, LEVEL_ERROR, "%s", tr(w, N_("this looks like a height map, not like normals")));
        break;
    case NTP_CLASS_OBJECT_SPACE:
        found(w, 9, LEVEL_WARNING, "%s",
              tr(w, N_("normals point in all directions: object space, not tangent space")));
        break;
    case NTP_CLASS_NOT_NORMALS:
        found(w, 8, LEVEL_ERROR, "%s",
              tr(w, N_("this is not a normals texture: its colors are not those of unit vectors")));
        break;
    default:
        break;
    }
}

static void find_places(writer *w)
{
    const uint32_t a = w->r->type.accidents;
    if ((a & NTP_ACCIDENT_RED_IS_Z) != 0)
        found(w, 12, LEVEL_ERROR, "%s", tr(w, N_("red and blue seem to be swapped: red holds z")));
    else if ((a & NTP_ACCIDENT_GREEN_IS_Z) != 0)
        found(w, 12, LEVEL_ERROR, "%s",
              tr(w, N_("green and blue seem to be swapped: green holds z")));
    else if ((a & NTP_ACCIDENT_DXT5NM) != 0 && w->r->channels > 2)
        found(w, 12, LEVEL_ERROR, "%s", tr(w, N_("packed as DXT5nm: x is in alpha, y in green")));
    if ((a & NTP_ACCIDENT_GAMMA) != 0)
        found(w, 40, LEVEL_ERROR, "%s",
              tr(w, N_("flat texels lie near 188, not 128: the numbers were converted to sRGB")));
}

static void find_accidents(writer *w)
{
    const report *r = w->r;
    const uint32_t a = r->type.accidents;
    if ((a & NTP_ACCIDENT_BLUE_CONSTANT) != 0 && r->encoding != NTP_ENCODING_XY &&
        r->type.type != NTP_CLASS_ONE_COLOR)
        found(w, 4, LEVEL_WARNING, tr(w, N_("blue is %u in every texel: it was not computed")),
              (unsigned) r->stats.channel[2].min);
    find_places(w);
    if ((a & NTP_ACCIDENT_LOSSY) != 0)
        found(w, 32, level_of_cause(w), "%s",
              tr(w, N_("the texels show lossy compression, although the file is lossless")));
    if ((a & NTP_ACCIDENT_FILTERED) != 0)
        found(w, 35, level_of_cause(w), "%s",
              tr(w, N_("normals are too short where the surface is curved: resized or blurred, not "
                       "normalized")));
}

/* -------------------------------------------------------------------------- its texels */

static void find_length(writer *w)
{
    const report *r = w->r;
    const ntp_harm *harm = &r->harm[REPORT_LENGTH];
    const uint64_t off = r->stats.levels_off_max[r->encoding == NTP_ENCODING_ZZERO];
    char levels[NUMBER_SIZE], worst[NUMBER_SIZE], mean[NUMBER_SIZE];
    if (r->failing == 0 || r->encoding == NTP_ENCODING_XY)
        return;
    const share texels = share_of(w, r->failing);
    const finding_level level = level_of(w, REPORT_LENGTH);
    number_count(levels, off, &w->words);
    number_degrees(worst, harm->max, &w->words);
    number_degrees(mean, harm->mean, &w->words);
    if (off == 1)
        found(w, 1, level,
              tr(w, N_("%s are not unit vectors: blue is up to 1 level off, the normal up to %s "
                       "degrees (%s on average)")),
              texels.text, worst, mean);
    else if (off > 0)
        found(w, 1, level,
              tr(w, N_("%s are not unit vectors: blue is up to %s levels off, the normal up to %s "
                       "degrees (%s on average)")),
              texels.text, levels, worst, mean);
    else /* only red and green are wrong */
        found(w, 1, level,
              tr(w, N_("%s are not unit vectors: the normal is off by up to %s degrees (%s on "
                       "average)")),
              texels.text, worst, mean);
    add_visible(w, REPORT_LENGTH);
}

static void find_longs(writer *w)
{
    const ntp_harm *harm = &w->r->harm[REPORT_XY];
    const uint64_t all = counts_xy_too_long(&w->r->stats);
    /* Rounding makes pairs too long that were not. */
    const bool rounding = harm->texels == 0;
    const uint64_t count = rounding ? all : harm->texels;
    if (count == 0)
        return;
    const share texels = share_of(w, count);
    if (rounding)
        found(w, 2, LEVEL_INFO,
              tr(w, N_("red and green alone are too long in %s, by no more than rounding")),
              texels.text);
    else
        found(w, 2, level_of(w, REPORT_XY),
              tr(w, N_("red and green alone are too long in %s: no blue can be right there")),
              texels.text);
    add_visible(w, REPORT_XY);
}

static void find_negative(writer *w)
{
    const report *r = w->r;
    const uint64_t count = counts_z_negative(&r->stats);
    if (count == 0 || r->encoding != NTP_ENCODING_STANDARD || r->keeps)
        return;
    found(w, 3, level_of(w, REPORT_Z),
          tr(w, N_("blue is at or below one half in %s: these normals point into the surface")),
          share_of(w, count).text);
    if ((r->type.accidents & NTP_ACCIDENT_Z_FLIPPED) != 0)
        more(w, "%s", tr(w, N_("; blue seems to be inverted as a whole")));
    add_visible(w, REPORT_Z);
}

/* For "%.2f", which would print "-0.00". */
static double without_sign_of_zero(double v)
{
    return v > -0.005 && v < 0 ? 0 : v;
}

static void find_texels(writer *w)
{
    const report *r = w->r;
    const double tilt = counts_tilt(&r->stats);
    find_length(w);
    find_longs(w);
    find_negative(w);
    if (r->type.type != NTP_CLASS_ONE_COLOR && (tilt < 0 ? -tilt : tilt) > COUNTS_MAX_TILT)
        found(w, 22, LEVEL_WARNING,
              tr(w, N_("tilted on average: the mean of x is %.2f and of y %.2f, but 0 is "
                       "expected")),
              without_sign_of_zero(2 * r->stats.used_mean[0] - 1),
              without_sign_of_zero(2 * r->stats.used_mean[1] - 1));
    if (r->encoding != NTP_ENCODING_XY && r->inexact > 0)
        found(w, 20, LEVEL_INFO, tr(w, N_("in %s blue is not the one that red and green imply")),
              share_of(w, r->inexact).text);
    if (r->stats.distinct_flat > 1)
        found(w, 21, LEVEL_INFO, tr(w, N_("flat texels have %llu different colors")),
              (unsigned long long) r->stats.distinct_flat);
}

/* ---------------------------------------------------------------------------- the rest */

static void find_parts(writer *w)
{
    const report *r = w->r;
    const ntp_stats *s = &r->stats;
    char percent[NUMBER_SIZE];
    if (s->stored_max == 65535 && s->max == 255 && r->samples == NTP_TYPE_U16)
        found(w, 34, LEVEL_INFO, "%s", tr(w, N_("a 16-bit file with 8-bit content")));
    if (r->channels % 2 == 0 && s->alpha_full == s->texels)
        found(w, 41, LEVEL_INFO, "%s", tr(w, N_("the alpha channel is opaque everywhere")));
    if (s->unused > 0 && s->unused < s->texels) {
        number_percent(percent, s->unused, s->texels, &w->words);
        found(w, 42, LEVEL_INFO,
              tr(w, N_("%s of the texels are unused (black, white or transparent)")), percent);
    }
    if (s->padding > 0 && r->judged) {
        number_percent(percent, s->padding, s->texels, &w->words);
        found(w, 44, LEVEL_INFO,
              tr(w, N_("%s of the texels have one color that no normal has: padding, not counted")),
              percent);
    }
    if ((r->width & (r->width - 1)) != 0 || (r->height & (r->height - 1)) != 0)
        found(w, 51, LEVEL_INFO, tr(w, N_("%u x %u: the sides are not powers of two")),
              (unsigned) r->width, (unsigned) r->height);
}

static void find(writer *w)
{
    const report *r = w->r;
    if (!r->told)
        find_class(w);
    find_accidents(w);
    if (r->judged && r->used > 0 && !counts_misplaced(&r->type, r->channels))
        find_texels(w);
    if (r->type.type == NTP_CLASS_ONE_COLOR && r->used == 0)
        found(w, 50, LEVEL_WARNING, "%s",
              tr(w, N_("no texel holds a normal: all are black, white or transparent")));
    else if (r->type.type == NTP_CLASS_ONE_COLOR)
        found(w, 50, LEVEL_INFO, "%s", tr(w, N_("all texels have one color")));
    find_parts(w);
}

static bool is_heavier(const finding *a, const finding *b)
{
    return a->level != b->level ? a->level > b->level : a->number < b->number;
}

static void sort(writer *w)
{
    for (int i = 1; i < w->count; i++) {
        const finding moved = w->findings[i];
        int k = i;
        for (; k > 0 && is_heavier(&moved, &w->findings[k - 1]); k--)
            w->findings[k] = w->findings[k - 1];
        w->findings[k] = moved;
    }
}

/* ------------------------------------------------------------------------ the headline */

static const char *class_text(ntp_class type)
{
    switch (type) {
    case NTP_CLASS_STANDARD:
        return N_("standard");
    case NTP_CLASS_ZZERO:
        return N_("Z-zero");
    case NTP_CLASS_XY:
        return N_("XY-only");
    case NTP_CLASS_HEIGHT:
        return N_("height map");
    case NTP_CLASS_OBJECT_SPACE:
        return N_("object-space");
    case NTP_CLASS_ONE_COLOR:
        return N_("one color");
    default:
        return N_("not a normals texture");
    }
}

static void add_sure(writer *w, double confidence)
{
    if (confidence < 0.9)
        add(w, tr(w, N_(" (%.0f %% sure)")), 100 * confidence);
}

static const char *praise(const writer *w)
{
    const ntp_class type = w->r->type.type;
    for (int i = 0; i < w->count; i++) {
        if (w->findings[i].number <= 3)
            return N_("no visible errors");
    }
    return type == NTP_CLASS_HEIGHT || type == NTP_CLASS_NOT_NORMALS ? N_("ok") : N_("well formed");
}

static void add_verdict(writer *w)
{
    report *r = w->r;
    for (int i = 0; i < w->count; i++) {
        r->errors += w->findings[i].level == LEVEL_ERROR;
        r->warnings += w->findings[i].level == LEVEL_WARNING;
    }
    if (r->errors > 0)
        add(w, tr(w, r->errors == 1 ? N_("%d error") : N_("%d errors")), r->errors);
    if (r->errors > 0 && r->warnings > 0)
        add(w, ", ");
    if (r->warnings > 0)
        add(w, tr(w, r->warnings == 1 ? N_("%d warning") : N_("%d warnings")), r->warnings);
    if (r->errors + r->warnings == 0)
        add(w, "%s", tr(w, praise(w)));
}

static void add_headline(writer *w)
{
    static const char *const CHANNELS[] = { "", N_("gray"), N_("gray and alpha"), "RGB", "RGBA" };
    static const int BITS[] = { 8, 16, 32 }; /* of ntp_type */
    const report *r = w->r;
    add(w, "%s", tr(w, class_text(r->type.type)));
    add_sure(w, r->type.confidence);
    if (r->green.decided) {
        add(w, ", %s",
            tr(w, r->green.y == NTP_Y_UP ? N_("OpenGL (Y up)") : N_("DirectX (Y down)")));
        add_sure(w, r->green.confidence);
    }
    add(w, tr(w, N_(", %u x %u %d-bit %s: ")), (unsigned) r->width, (unsigned) r->height,
        BITS[r->samples], tr(w, CHANNELS[r->channels]));
    add_verdict(w);
}

/* What cleaning would do, by the method that suits the errors. */
static const char *cleaning_text(const report *r)
{
    if (r->misplaced)
        return r->accident != UNDO_NOTHING ? N_("This can be undone exactly.") : NULL;
    if (r->right)
        return N_("There is nothing to clean.");
    if (!r->judged || r->used == 0)
        return NULL;
    return r->method == NTP_CLEAN_NORMALIZE ? N_("Cleaning by normalizing suits these errors.")
           : r->method == NTP_CLEAN_KEEP
               ? N_("Cleaning makes negative z positive, and changes nothing else.")
               : N_("Cleaning by deriving blue suits these errors.");
}

void report_write(report *r, const char *(*translate)(const char *text))
{
    static const char *const LEVELS[] = { N_("note"), N_("warning"), N_("error") };
    writer w = { .r = r, .translate = translate, .words = NUMBERS_ENGLISH };
    if (translate != NULL) {
        w.words.separator = localeconv()->decimal_point[0] == ',' ? '.' : ',';
        w.words.under = tr(&w, N_("under"));
        w.words.over = tr(&w, N_("over"));
    }
    r->errors = r->warnings = 0;
    find(&w);
    sort(&w);
    add_headline(&w);
    for (int i = 0; i < w.count; i++)
        add(&w, "\n%s NT%03d  %s", tr(&w, LEVELS[w.findings[i].level]), w.findings[i].number,
            w.findings[i].text);
    if (cleaning_text(r) != NULL)
        add(&w, "\n%s", tr(&w, cleaning_text(r)));
}
