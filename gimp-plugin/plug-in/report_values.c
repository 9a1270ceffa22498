/* SPDX-License-Identifier: MIT */
/*
 * report_values.c - a report as values for scripts
 */
#include "report.h"

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
