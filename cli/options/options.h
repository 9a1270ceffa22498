/* SPDX-License-Identifier: MIT */
/*
 * options.h - the verbs and options of ntp
 *
 * The room of the command line.  One table says what verbs and options there are; parsing, --help,
 * the man page and the completions are made from it.
 *   options.c  the table of options and the table of verbs
 *   parse.c    words to option values, and the messages about wrong ones
 *   help.c     the texts of --help
 *   names.c    names of values that libntp does not name
 *
 * A new verb is a file in verbs/, a row in the table of verbs, a row in main.c, and rows for its
 * options.
 */
#ifndef NTP_CLI_OPTIONS_H
#define NTP_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "cli.h"

/* One bit for each verb of our own, in the order of the table. */
enum {
    V_CHECK = 1,
    V_CLEAN = 2,
    V_CONVERT = 4,
    V_HEATMAP = 8,
    V_DUMP = 16,
    V_DIFF = 32,
    V_FROM_HEIGHT = 64,
    V_TRANSFORM = 128,
    V_RESIZE = 256,
    V_BLEND = 512,
    V_TO_HEIGHT = 1024,
    V_CURVATURE = 2048,
    V_OCCLUSION = 4096,
    V_TO_DEPTH = 8192,
    V_RELIEF = V_CURVATURE | V_OCCLUSION,
    V_MAPS = V_CLEAN | V_CONVERT | V_HEATMAP | V_FROM_HEIGHT | V_TRANSFORM | V_RESIZE |
             V_TO_HEIGHT | V_RELIEF | V_TO_DEPTH,
    V_WRITES = V_MAPS | V_BLEND,
    V_PATHS = V_CHECK | V_MAPS,
    V_ALL = V_CHECK | V_WRITES | V_DUMP | V_DIFF
};

typedef enum option_id {
    OPT_TYPE,
    OPT_Y,
    OPT_VERDICT,
    OPT_KEEP_NEGATIVE_Z,
    OPT_POLICY,
    OPT_MAX_ANGLE,
    OPT_MAX_FAIL,
    OPT_MAX_TILT,
    OPT_FAIL_ON,
    OPT_BASELINE,
    OPT_DEEP,
    OPT_OUTPUT,
    OPT_IN_PLACE,
    OPT_METHOD,
    OPT_ONLY_FAILING,
    OPT_ONLY_CHANGED,
    OPT_TOUCH_UNUSED,
    OPT_DRY_RUN,
    OPT_FORCE,
    OPT_UNDO,
    OPT_TO,
    OPT_TO_Y,
    OPT_DEPTH,
    OPT_CHANNELS,
    OPT_FROM_CHANNELS,
    OPT_SCALE,
    OPT_DX,
    OPT_DY,
    OPT_INVERT,
    OPT_KERNEL,
    OPT_BORDER,
    OPT_BORDER_X,
    OPT_BORDER_Y,
    OPT_SOURCE,
    OPT_BLUR,
    OPT_OCTAVES,
    OPT_DITHER,
    OPT_BLUE,
    OPT_MIN_Z,
    OPT_ALPHA,
    OPT_AO,
    OPT_LIKE,
    OPT_REFINE,
    OPT_SEEDS,
    OPT_EQUALIZE,
    OPT_MASK,
    OPT_DETREND,
    OPT_CLIP,
    OPT_DECODE,
    OPT_Z,
    OPT_STRENGTH,
    OPT_FLIP,
    OPT_ROTATE,
    OPT_SIZE,
    OPT_MIPS,
    OPT_COMPRESSION,
    OPT_QUALITY,
    OPT_FILTER,
    OPT_MODE,
    OPT_KIND,
    OPT_RANGE,
    OPT_RADIUS,
    OPT_CAMERA,
    OPT_CONFIDENCE,
    OPT_K,
    OPT_ROUNDS,
    OPT_DETAIL_ALPHA,
    OPT_DETAIL_Y,
    OPT_PALETTE,
    OPT_ALL,
    OPT_LEVEL,
    OPT_FORMAT,
    OPT_NUL,
    OPT_RECURSIVE,
    OPT_MATCH,
    OPT_EXCLUDE,
    OPT_FILES_FROM,
    OPT_ALLOW_EMPTY,
    OPT_JOBS,
    OPT_QUIET,
    OPT_VERBOSE,
    OPT_COLOR,
    OPT_NO_PROGRESS,
    OPT_MAX_SIDE,
    OPT_MAX_AT_ONCE,
    OPT_MAX_TEXELS,
    OPT_MIP,
    OPT_LAYER,
    OPT_FAIL_OVER,
    OPT_HELP,
    OPT_COUNT
} option_id;

typedef enum option_kind {
    KIND_FLAG,
    KIND_STRING,
    KIND_CHOICE,
    KIND_INTEGER,
    KIND_NUMBER
} option_kind;

typedef struct option_spec {
    option_id id;
    const char *name;
    char letter; /* 0: none */
    option_kind kind;
    const char *value;    /* the value's name in the help; KIND_CHOICE: "a|b|c" */
    const char *standard; /* the default, as a user would type it; NULL: none */
    double least, most;   /* of numbers; "N|auto" also takes that word, as 0 */
    unsigned verbs;
    const char *help; /* NULL: an older name, which is accepted and not shown */
} option_spec;

typedef struct verb_spec {
    const char *name;
    const char *arguments;
    const char *summary;
    const char *description;
    const char *examples; /* lines "command\n  what it does" */
} verb_spec;

extern const option_spec OPTION_TABLE[];
extern const size_t OPTION_ROWS;
extern const verb_spec VERB_TABLE[];
extern const size_t VERB_ROWS;

#define HELP_FORMATS                                                                               \
    "Reads PNG, TGA, JPEG, PFM, DDS and KTX2, and WebP and OpenEXR if built with them; writes "    \
    "PNG, "                                                                                        \
    "TGA, PFM and WebP, and converts to DDS and KTX2."

typedef struct option_value {
    bool given;
    int64_t integer; /* also the index of a choice */
    double number;
    const char *string; /* the last one given */
    char **all;         /* every one given, in order */
    size_t count;
} option_value;

typedef struct options {
    const verb_spec *verb;
    unsigned verb_bit;
    option_value values[OPT_COUNT];
    char **paths;
    size_t path_count;
} options;

/* Fills *o from the words after the verb.  Returns false after a message about what is wrong. */
bool options_parse(options *o, const verb_spec *verb, int argc, char **argv);
void options_free(options *o);

/* The row of an option for a verb, or NULL. */
const option_spec *option_row(option_id id, unsigned verb_bit);
const verb_spec *verb_find(const char *name);
unsigned verb_bit(const verb_spec *verb);
/* Do the help, the man page and the completions of the verb name this row? */
bool option_is_shown(const option_spec *row, const verb_spec *verb);

/* The programs ntp-NAME that the Python package puts beside ntp. */
typedef struct companion {
    const char *name;
    const char *summary;
} companion;

enum { COMPANIONS = 3 };
extern const companion COMPANION_TABLE[COMPANIONS];

/* The nearest of the names, or NULL if none is near. */
const char *nearest_name(const char *wrong, const char *const *names, size_t count);
void complain_unknown_verb(const char *name);

static inline bool option_given(const options *o, option_id id)
{
    return o->values[id].given;
}

static inline int64_t option_integer(const options *o, option_id id)
{
    return o->values[id].integer;
}

static inline double option_number(const options *o, option_id id)
{
    return o->values[id].number;
}

static inline const char *option_string(const options *o, option_id id)
{
    return o->values[id].string;
}

/* help.c */
void help_program(text *t);
void help_verb(text *t, const verb_spec *verb);

#endif
