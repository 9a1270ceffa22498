/* SPDX-License-Identifier: MIT */
/*
 * verb_from_height_options.c - the options of ntp from-height
 *
 * --like fills the settings first, with the kernel, border, weights and channel order of another
 * program.  Other options override them.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "examine/samples.h"
#include "text/text.h"
#include "verbs/verb_from_height.h"

static bool wrong(const char *option, const char *value, const char *problem)
{
    complain("--%s %s: %s", option, value, problem);
    return false;
}

static bool read_channels(from_height_settings *set, const char *spec)
{
    static const char LETTERS[] = "xyzah01";
    static const int8_t MEANINGS[] = { 0, 1, 2, ALPHA, ALPHA, FROM_ZERO, FROM_ONE };
    if (spec == NULL)
        return true;
    const size_t length = strlen(spec);
    if (length < 1 || length > FULL)
        return wrong("channels", spec, "expected one letter for each channel, 1 to 4 of them");
    if (strchr(spec, 'a') != NULL && strchr(spec, 'h') != NULL)
        return wrong("channels", spec, "a and h do not go together; --alpha says what a is");
    if (strchr(spec, 'h') != NULL && set->alpha_given)
        return wrong("channels", spec, "h and --alpha do not go together");
    for (size_t i = 0; i < length; i++) {
        const char *letter = strchr(LETTERS, spec[i]);
        if (letter == NULL)
            return wrong("channels", spec, "the letters are x y z 0 1 h a");
        set->out[i] = MEANINGS[letter - LETTERS];
    }
    if (strchr(spec, 'h') != NULL)
        set->how.alpha = NTP_ALPHA_HEIGHT;
    set->out_count = (int32_t) length;
    return true;
}

static bool read_alpha(from_height_settings *set, const options *o)
{
    const char *word = option_string(o, OPT_ALPHA);
    static const struct {
        const char *name;
        ntp_alpha alpha;
    } WORDS[] = { { "keep", NTP_ALPHA_KEEP },
                  { "one", NTP_ALPHA_ONE },
                  { "inverse", NTP_ALPHA_INVERSE },
                  { "height", NTP_ALPHA_HEIGHT } };
    set->alpha_given = option_given(o, OPT_ALPHA);
    set->alpha_name = word;
    for (size_t i = 0; i < sizeof WORDS / sizeof WORDS[0]; i++) {
        if (strcmp(word, WORDS[i].name) == 0) {
            set->how.alpha = WORDS[i].alpha;
            return true;
        }
    }
    set->how.alpha = NTP_ALPHA_ONE;
    set->alpha_file = word;
    return true;
}

/* The weights of the heights without blur, and blurred by 1, by 2, by 4 texels, ... */
static bool read_octaves(from_height_settings *set, const char *list)
{
    const char *at = list;
    while (list != NULL) {
        char *end = NULL;
        const double weight = strtod(at, &end);
        const size_t length = strspn(at, "0123456789.eE+-");
        if (length == 0 || end != at + length || !(weight - weight == 0))
            return wrong("octaves", list, "expected numbers with commas between them");
        if (set->octaves == MAX_OCTAVES)
            return wrong("octaves", list, "at most 8 octaves");
        set->octave[set->octaves++] = weight;
        if (*end == 0)
            return true;
        if (*end != ',')
            return wrong("octaves", list, "expected numbers with commas between them");
        at = end + 1;
    }
    return true;
}

/* --like NAME:VALUE; other options override it. */
static bool read_like(from_height_settings *set, const char *like)
{
    const char *colon = strrchr(like, ':');
    char name[40];
    char *end = NULL;
    ntp_peer peer;
    if (colon == NULL || colon == like || (size_t) (colon - like) >= sizeof name)
        return wrong("like", like, "expected a name, a colon and a number, such as reference:5");
    snprintf(name, sizeof name, "%.*s", (int) (colon - like), like);
    const double value = strtod(colon + 1, &end);
    if (colon[1] == 0 || *end != 0 || strspn(colon + 1, "0123456789.eE+-") != strlen(colon + 1))
        return wrong("like", like, "what follows the last colon is not a number");
    if (ntp_normals_like(&peer, name, value) != NTP_OK)
        return wrong("like", like,
                     "the names are reference, eberly, zima, zima-corrected, gegl, and "
                     "gimp-normalmap:FILTER");
    set->how = peer.options;
    set->to_y = peer.y;
    if (peer.swap_green_blue) {
        static const int8_t XZY[] = { 0, 2, 1 };
        memcpy(set->out, XZY, sizeof XZY);
        set->out_count = 3;
    }
    return true;
}

/* --scale or --like: one of them is needed. */
static bool read_base(from_height_settings *set, const options *o)
{
    const char *like = option_string(o, OPT_LIKE);
    set->measures = like == NULL && option_given(o, OPT_SCALE) &&
                    strcmp(option_string(o, OPT_SCALE), "auto") == 0;
    set->how.scale = set->measures ? 1 : option_number(o, OPT_SCALE);
    if (like != NULL && option_given(o, OPT_SCALE))
        complain("--like sets the scale; leave out --scale");
    else if (like == NULL && !option_given(o, OPT_SCALE))
        complain("--scale is needed: how many texels a height of 1 (white) rises, or auto");
    else
        return like == NULL || read_like(set, like);
    return false;
}

/* The options that override --like.  Without --like, the defaults are zeros. */
static void read_given(from_height_settings *set, const options *o)
{
    ntp_normals_options *how = &set->how;
    how->scale *= option_number(o, OPT_STRENGTH);
    how->dx = option_number(o, OPT_DX);
    how->dy = option_number(o, OPT_DY);
    how->min_z = option_number(o, OPT_MIN_Z);
    how->invert = option_given(o, OPT_INVERT);
    how->blue = (ntp_blue) option_integer(o, OPT_BLUE);
    if (option_given(o, OPT_KERNEL))
        how->kernel = (ntp_kernel) option_integer(o, OPT_KERNEL);
    if (option_given(o, OPT_SOURCE))
        how->source = (ntp_height_source) option_integer(o, OPT_SOURCE);
    if (option_given(o, OPT_BORDER))
        how->border_x = how->border_y = (ntp_border) option_integer(o, OPT_BORDER);
    if (option_given(o, OPT_BORDER_X))
        how->border_x = (ntp_border) option_integer(o, OPT_BORDER_X);
    if (option_given(o, OPT_BORDER_Y))
        how->border_y = (ntp_border) option_integer(o, OPT_BORDER_Y);
    if (option_given(o, OPT_TO_Y))
        set->to_y = (ntp_y) option_integer(o, OPT_TO_Y);
    set->to = (ntp_encoding) option_integer(o, OPT_TO);
    set->depth = option_given(o, OPT_DEPTH) ? (int) option_integer(o, OPT_DEPTH) + 1 : 0;
    set->ao_file = option_string(o, OPT_AO);
    set->blur = option_number(o, OPT_BLUR);
    set->dither = option_integer(o, OPT_DITHER) == 1;
    set->limits = limits_from(o);
}

/* Reports options that contradict each other, whatever the input is. */
static bool agree(const from_height_settings *set)
{
    if (!(set->how.dx > 0) || !(set->how.dy > 0))
        complain("--dx and --dy must be greater than 0");
    else if (ntp_normals_reach(&set->how) < 0)
        complain("the scale or the spacing is out of range");
    else if (set->ao_file != NULL && set->to != NTP_ENCODING_XY)
        complain("--ao needs --to xy, which leaves the blue channel free");
    else if (set->dither && set->how.blue == NTP_BLUE_NEAREST)
        complain("--dither integrable derives blue; leave out --blue nearest");
    else
        return true;
    return false;
}

bool from_height_read_settings(from_height_settings *set, const options *o)
{
    if (!read_base(set, o))
        return false;
    read_given(set, o);
    return agree(set) && read_octaves(set, option_string(o, OPT_OCTAVES)) && read_alpha(set, o) &&
           read_channels(set, option_string(o, OPT_CHANNELS));
}
