/* SPDX-License-Identifier: MIT */
/*
 * names.c - names of values that libntp does not name; they are the words of the options
 */
#include "options/names.h"

#include <stddef.h>

#define NAME_OF(names, value) name_of(names, sizeof(names) / sizeof *(names), (size_t) (value))

static const char *name_of(const char *const *names, size_t count, size_t value)
{
    return value < count ? names[value] : "unknown";
}

const char *encoding_name(ntp_encoding encoding)
{
    static const char *const NAMES[] = { "standard", "zzero", "xy", "vector", "height" };
    return NAME_OF(NAMES, encoding);
}

const char *y_name(ntp_y y)
{
    static const char *const NAMES[] = { "up", "down" };
    return NAME_OF(NAMES, y);
}

const char *y_title(ntp_y y)
{
    static const char *const TITLES[] = { "OpenGL (Y up)", "DirectX (Y down)" };
    return NAME_OF(TITLES, y);
}

const char *verdict_name(ntp_verdict verdict)
{
    static const char *const NAMES[] = { "neighbor", "rounded", "exact" };
    return NAME_OF(NAMES, verdict);
}

const char *clean_method_name(ntp_clean_method method)
{
    static const char *const NAMES[] = { "derive", "normalize", "keep" };
    return NAME_OF(NAMES, method);
}

const char *source_name(ntp_height_source source)
{
    static const char *const NAMES[] = { "red",  "green",     "blue",        "alpha",
                                         "luma", "luma-gimp", "luma-eberly", "mean",
                                         "max",  "min",       "screen" };
    return NAME_OF(NAMES, source);
}

const char *decode_name(ntp_decode decode)
{
    static const char *const NAMES[] = { "auto", "unorm", "neutral", "unorm-trunc", "snorm128" };
    return NAME_OF(NAMES, decode);
}

const char *z_name(ntp_z z)
{
    static const char *const NAMES[] = { "auto", "stored", "derived" };
    return NAME_OF(NAMES, z);
}
