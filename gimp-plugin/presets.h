/* SPDX-License-Identifier: MIT */
/*
 * presets.h - the settings that an engine or another program asks for
 */
#ifndef NTP_GIMP_PRESETS_H
#define NTP_GIMP_PRESETS_H

#include "libntp.h"

#include <stdbool.h>

typedef enum preset { /* in the order of NTP_PRESET_CHOICES */
                      PRESET_NONE,
                      PRESET_UNREAL,
                      PRESET_UNITY,
                      PRESET_GODOT,
                      PRESET_SOURCE,
                      PRESET_LABPBR,
                      PRESET_GIMP,
                      PRESET_GIMP_NORMALMAP
} preset;

/* What a preset may set. */
typedef struct recipe {
    ntp_normals_options how;
    bool luminance; /* the height is the luminance */
    ntp_y y;
    ntp_encoding to;
    int channels; /* their order, of NTP_CHANNEL_CHOICES */
} recipe;

void preset_apply(preset p, recipe *r);

/* Does it decide the option of that name, such as "to-y"? */
bool preset_decides(preset p, const char *option);

#endif
