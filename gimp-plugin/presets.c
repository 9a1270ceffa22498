/* SPDX-License-Identifier: MIT */
/*
 * presets.c - the settings that an engine or another program asks for
 *
 * README.md has the sources.  Engines ask for a direction of green and for what the channels hold.
 * Other programs are their own formulas: kernel, borders, source of the height.
 */
#include "presets.h"

#include <stddef.h>
#include <string.h>

/* The filter of gimp-normalmap with that kernel; NULL: it has none. */
static const char *const FILTERS[NTP_KERNELS] = {
    [NTP_KERNEL_CENTRAL] = "gimp-normalmap:4sample",
    [NTP_KERNEL_PREWITT3] = "gimp-normalmap:prewitt3",
    [NTP_KERNEL_SOBEL3] = "gimp-normalmap:sobel3",
    [NTP_KERNEL_PREWITT5] = "gimp-normalmap:prewitt5",
    [NTP_KERNEL_SOBEL5] = "gimp-normalmap:sobel5",
    [NTP_KERNEL_GIMP5] = "gimp-normalmap:5x5",
    [NTP_KERNEL_GIMP7] = "gimp-normalmap:7x7",
    [NTP_KERNEL_GIMP9] = "gimp-normalmap:9x9",
};

/* Takes over what the library knows of another program.  A scale of 0 stays. */
static void take_like(recipe *r, const char *name)
{
    ntp_peer peer;
    if (name == NULL || ntp_normals_like(&peer, name, r->how.scale) != NTP_OK)
        return;
    r->how.scale = peer.options.scale;
    r->how.kernel = peer.options.kernel;
    r->how.border_x = peer.options.border_x;
    r->how.border_y = peer.options.border_y;
    r->how.source = peer.options.source;
    r->y = peer.y;
}

void preset_apply(preset p, recipe *r)
{
    const char *filter = FILTERS[r->how.kernel];
    if (p == PRESET_NONE)
        return;
    r->to = p == PRESET_LABPBR ? NTP_ENCODING_XY : NTP_ENCODING_STANDARD;
    r->channels = 0;
    r->y = p == PRESET_UNITY || p == PRESET_GODOT ? NTP_Y_UP : NTP_Y_DOWN;
    if (p == PRESET_LABPBR)
        r->how.alpha = NTP_ALPHA_HEIGHT;
    if (p == PRESET_GIMP)
        take_like(r, "gegl");
    if (p == PRESET_GIMP_NORMALMAP)
        take_like(r, filter != NULL ? filter : FILTERS[NTP_KERNEL_CENTRAL]);
    if (p == PRESET_GIMP)
        r->how.blue = NTP_BLUE_NEAREST;
    if (p >= PRESET_GIMP)
        r->luminance = p == PRESET_GIMP;
}

static bool is_one_of(const char *option, const char *const *names)
{
    while (*names != NULL && strcmp(option, *names) != 0)
        names++;
    return *names != NULL;
}

bool preset_decides(preset p, const char *option)
{
    static const char *const ALL[] = { "to-y", "to", "channels", NULL };
    static const char *const PROGRAMS[] = { "source", "border-x", "border-y", NULL };
    static const char *const GIMP[] = { "kernel", "blue", NULL };
    return p != PRESET_NONE &&
           (is_one_of(option, ALL) || (p >= PRESET_GIMP && is_one_of(option, PROGRAMS)) ||
            (p == PRESET_GIMP && is_one_of(option, GIMP)) ||
            (p == PRESET_LABPBR && strcmp(option, "alpha") == 0));
}
