/* SPDX-License-Identifier: MIT */
/*
 * report_text.c - a report in words, and as values for scripts
 */
#include "report_text.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define N_(TEXT) TEXT

/* --------------------------------------------------------------------------- for scripts */

enum {
    V_TYPE,
    V_CONFIDENCE,
    V_TEXELS,
    V_UNUSED,
    V_FAIL_NEIGHBOR,
    V_FAIL_ROUNDED,
    V_FAIL_EXACT,
    V_XY_TOO_LONG,
    V_Z_NEGATIVE,
    V_ANGLE_MEAN,
    V_ANGLE_MAX,
    V_Y,
    V_Y_CONFIDENCE,
    V_RIGHT,
    V_REPORT
};

const report_value report_value_table[REPORT_VALUES] = {
    [V_TYPE] = { "type", "standard, zzero, xy, height, object-space, one-color or not-normals",
                 true },
    [V_CONFIDENCE] = { "confidence", "How sure that is, 0 to 1", false },
    [V_TEXELS] = { "texels", "All texels", false },
    [V_UNUSED] = { "unused", "Black, white and transparent ones", false },
    [V_FAIL_NEIGHBOR] = { "fail-neighbor", "Texels that are not unit vectors to within a level",
                          false },
    [V_FAIL_ROUNDED] = { "fail-rounded", "Texels that are not rounded unit vectors", false },
    [V_FAIL_EXACT] = { "fail-exact", "Texels whose blue is not that of red and green", false },
    [V_XY_TOO_LONG] = { "xy-too-long", "Texels whose red and green are too long", false },
    [V_Z_NEGATIVE] = { "z-negative", "Texels that point into the surface", false },
    [V_ANGLE_MEAN] = { "angle-mean", "Mean error of the direction in degrees", false },
    [V_ANGLE_MAX] = { "angle-max", "Greatest error of the direction in degrees", false },
    [V_Y] = { "y", "up (OpenGL), down (DirectX) or undecided", true },
    [V_Y_CONFIDENCE] = { "y-confidence", "How sure that is, 0 to 1", false },
    [V_RIGHT] = { "right", "1: a normals texture with nothing to repair", false },
    [V_REPORT] = { "report", "The report as text", true },
};

double report_number_of(const report *r, int value)
{
    const ntp_stats *s = &r->stats;
    const ntp_fit *fit = r->encoding == NTP_ENCODING_ZZERO ? &s->zzero : &s->standard;
    const bool xy = r->encoding == NTP_ENCODING_XY;
    switch (value) {
    case V_CONFIDENCE:
        return r->type.confidence;
    case V_TEXELS:
        return (double) s->texels;
    case V_UNUSED:
        return (double) s->unused;
    case V_FAIL_NEIGHBOR:
        return (double) (xy ? s->xy_too_long : s->texels - fit->neighbor);
    case V_FAIL_ROUNDED:
        return (double) (xy ? s->xy_too_long : s->texels - fit->rounded);
    case V_FAIL_EXACT:
        return (double) (xy ? s->xy_too_long : s->texels - fit->exact);
    case V_XY_TOO_LONG:
        return (double) s->xy_too_long;
    case V_Z_NEGATIVE:
        return (double) s->z_negative;
    case V_ANGLE_MEAN:
        return s->angles.mean;
    case V_ANGLE_MAX:
        return s->angles.max;
    case V_Y_CONFIDENCE:
        return r->green.confidence;
    case V_RIGHT:
        return r->right;
    default:
        return 0;
    }
}

const char *report_text_of(const report *r, int value)
{
    if (value == V_TYPE)
        return ntp_class_name(r->type.type);
    if (value == V_Y)
        return !r->green.decided ? "undecided" : r->green.y == NTP_Y_UP ? "up" : "down";
    return r->text;
}

/* ---------------------------------------------------------------------------- for people */

typedef struct writer {
    report *r;
    size_t length;
    const char *(*translate)(const char *text);
} writer;

static const char *tr(const writer *w, const char *text)
{
    return w->translate != NULL ? w->translate(text) : text;
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
line(writer *w, const char *format, ...)
{
    const size_t room = sizeof w->r->text - w->length;
    va_list arguments;
    va_start(arguments, format);
    const int more = vsnprintf(w->r->text + w->length, room, format, arguments);
    va_end(arguments);
    w->length += more < 0 ? 0 : (size_t) more < room ? (size_t) more : room - 1;
    if (w->length + 1 < sizeof w->r->text)
        w->r->text[w->length++] = '\n';
    w->r->text[w->length] = 0;
}

static const char *class_text(ntp_class type)
{
    switch (type) {
    case NTP_CLASS_STANDARD:
        return N_("This is a normals texture: x, y, z in red, green, blue.");
    case NTP_CLASS_ZZERO:
        return N_("This is a normals texture with z in 0..1 (Z-zero).");
    case NTP_CLASS_XY:
        return N_("This is a normals texture with x and y only; blue is something else.");
    case NTP_CLASS_HEIGHT:
        return N_("This looks like a heightfield (bump map), not like normals.");
    case NTP_CLASS_OBJECT_SPACE:
        return N_("These normals point in all directions: object space, not tangent space.");
    case NTP_CLASS_ONE_COLOR:
        return N_("All texels have one color.");
    default:
        return N_("This is no normals texture: its colors are not those of unit vectors.");
    }
}

static double percent(const report *r, uint64_t count)
{
    return r->used == 0 ? 0 : 100 * (double) count / (double) r->used;
}

static void write_lengths(writer *w)
{
    report *r = w->r;
    if (r->failing == 0) {
        line(w, "%s", tr(w, N_("Every texel is a unit vector, to within a level.")));
    } else {
        line(w, tr(w, N_("%.1f %% of the texels (%llu) are not unit vectors.")),
             percent(r, r->failing), (unsigned long long) r->failing);
        line(w, tr(w, N_("All directions are off by %.2f degrees on average, by %.2f at most.")),
             r->stats.angles.mean, r->stats.angles.max);
    }
    const uint64_t longs = r->stats.xy_too_long - r->stats.unused_xy_too_long;
    if (longs > 0)
        line(w, tr(w, N_("Red and green alone are too long in %llu: no blue can be right there.")),
             (unsigned long long) longs);
    const uint64_t negative = r->stats.z_negative - r->stats.unused_z_negative;
    if (negative > 0 && r->encoding == NTP_ENCODING_STANDARD)
        line(w, tr(w, N_("%llu point into the surface (blue below one half).")),
             (unsigned long long) negative);
    if (r->failing == 0 && r->inexact > 0)
        line(w, tr(w, N_("In %.1f %% blue is not the one that red and green imply; harmless.")),
             percent(r, r->inexact));
}

static void write_accidents(writer *w)
{
    static const struct {
        uint32_t bit;
        const char *text;
    } TEXTS[] = {
        { NTP_ACCIDENT_GAMMA, N_("Flat texels lie near 188, not 128: the numbers were converted "
                                 "to sRGB.") },
        { NTP_ACCIDENT_RED_IS_Z, N_("Red and blue seem to be swapped: red holds z.") },
        { NTP_ACCIDENT_GREEN_IS_Z, N_("Green and blue seem to be swapped: green holds z.") },
        { NTP_ACCIDENT_DXT5NM, N_("Packed as DXT5nm: x is in alpha, y in green.") },
        { NTP_ACCIDENT_LOSSY, N_("The texels show the marks of lossy compression.") },
        { NTP_ACCIDENT_FILTERED, N_("Normals are too short where the surface bends: resized or "
                                    "blurred without normalizing.") },
        { NTP_ACCIDENT_Z_FLIPPED, N_("Blue seems to be inverted as a whole.") },
        { NTP_ACCIDENT_BLUE_CONSTANT, N_("Blue is the same in every texel.") },
    };
    for (size_t i = 0; i < sizeof TEXTS / sizeof TEXTS[0]; i++) {
        if ((w->r->type.accidents & TEXTS[i].bit) != 0)
            line(w, "%s", tr(w, TEXTS[i].text));
    }
}

static void write_green(writer *w)
{
    const ntp_orientation_result *g = &w->r->green;
    if (!g->decided)
        line(w, "%s", tr(w, N_("Which way green points cannot be told.")));
    else
        line(w,
             tr(w, g->y == NTP_Y_UP ? N_("Green points up: OpenGL (%.0f %% sure).")
                                    : N_("Green points down: DirectX (%.0f %% sure).")),
             100 * g->confidence);
}

void report_write(report *r, const char *(*translate)(const char *text))
{
    writer w = { .r = r, .translate = translate };
    line(&w, "%s", tr(&w, class_text(r->type.type)));
    write_accidents(&w);
    if (r->judged && r->used > 0) {
        write_lengths(&w);
        if (r->type.type != NTP_CLASS_ONE_COLOR)
            write_green(&w);
    }
    if (r->stats.unused > 0)
        line(&w, tr(&w, N_("%llu texels are unused: black, white or transparent.")),
             (unsigned long long) r->stats.unused);
    if (r->misplaced)
        line(&w, "%s", tr(&w, job_status_text(JOB_MISPLACED)));
    else if (r->right)
        line(&w, "%s", tr(&w, N_("There is nothing to clean.")));
    else if (r->judged && r->used > 0)
        line(&w, "%s",
             tr(&w, r->method == NTP_CLEAN_NORMALIZE
                        ? N_("Cleaning by normalizing suits these errors.")
                    : r->method == NTP_CLEAN_KEEP
                        ? N_("Cleaning makes negative z positive, and changes nothing else.")
                        : N_("Cleaning by deriving blue suits these errors.")));
    if (w.length > 0)
        r->text[w.length - 1] = 0; /* the last line's end */
}
