/* SPDX-License-Identifier: MIT */
/*
 * fields.h - the procedures of the plug-in and their arguments, declared once
 *
 * From these tables come the PDB arguments of both GIMPs, the dialogs, last values and saved
 * settings.  Every value is a double: a number, the index of a choice, 0 or 1 for a switch, or the
 * ID of a layer (0 or less: none).  Does not depend on GIMP.
 */
#ifndef NTP_PLUGIN_FIELDS_H
#define NTP_PLUGIN_FIELDS_H

#include <stdbool.h>
#include <stddef.h>

typedef enum field_kind { FIELD_NUMBER, FIELD_CHOICE, FIELD_SWITCH, FIELD_LAYER } field_kind;

typedef struct choice {
    const char *name;  /* in scripts and saved settings */
    const char *label; /* in the dialog, to be translated */
} choice;

typedef struct field {
    const char *name;
    const char *label;
    const char *help;
    field_kind kind;
    int page;                   /* of the dialog; -1: for scripts only */
    double value;               /* the default */
    double low, high;           /* of numbers: what is taken */
    double soft_low, soft_high; /* and what a slider offers; on a curve beyond 100 */
    int digits;
    const choice *choices; /* up to one without a name */
} field;

/* The arguments of plug-in-ntp-normals-from-height, in the order of its PDB arguments. */
enum {
    FN_SCALE,
    FN_KERNEL,
    FN_BORDER_X,
    FN_BORDER_Y,
    FN_SOURCE,
    FN_INVERT,
    FN_TO_Y,
    FN_TO,
    FN_MIN_Z,
    FN_ALPHA,
    FN_DX,
    FN_DY,
    FN_BLUE,
    FN_HEIGHT_LAYER,
    FN_ALPHA_LAYER,
    FN_FLIP_X,
    FN_SWAP,
    FN_DUDV,
    FN_PRESET,
    FN_STRENGTH,
    FN_BLUR,
    FN_SMALL,
    FN_MIDDLE,
    FN_LARGE,
    FN_CHANNELS,
    FN_DITHER,
    FN_OCCLUSION,
    FN_FORCE,
    FN_COUNT
};

/* plug-in-ntp-height-from-normals */
enum {
    FH_BORDER_X,
    FH_BORDER_Y,
    FH_FROM_Y,
    FH_FROM,
    FH_METHOD,
    FH_KERNEL,
    FH_DECODE,
    FH_Z,
    FH_INVERT,
    FH_CONTRAST,
    FH_RESULT,
    FH_COUNT
};

/* plug-in-ntp-check-normals */
enum { FK_FROM, FK_KEEP_NEGATIVE_Z, FK_REMEDY, FK_COUNT };

/* plug-in-ntp-clean-normals */
enum {
    FC_METHOD,
    FC_FROM,
    FC_KEEP_NEGATIVE_Z,
    FC_ONLY_FAILING,
    FC_VERDICT,
    FC_UNUSED,
    FC_UNDO,
    FC_COUNT
};

/* plug-in-normalmap, the arguments of the old plug-in */
enum {
    FO_FILTER,
    FO_MIN_Z,
    FO_SCALE,
    FO_WRAP,
    FO_HEIGHT_SOURCE,
    FO_ALPHA,
    FO_CONVERSION,
    FO_DUDV,
    FO_FLIP_X,
    FO_FLIP_Y,
    FO_SWAP,
    FO_CONTRAST,
    FO_ALPHA_LAYER,
    FO_COUNT
};

/* plug-in-ntp-resize-normals */
enum {
    FZ_PERCENT,
    FZ_WIDTH,
    FZ_HEIGHT,
    FZ_SCOPE,
    FZ_FILTER,
    FZ_BORDER_X,
    FZ_BORDER_Y,
    FZ_FROM,
    FZ_COUNT
};

enum { MAX_FIELDS = 32, PAGES = 3 /* of a dialog: the first, forms, more */ };

typedef enum procedure_id {
    PROCEDURE_NORMALS,
    PROCEDURE_HEIGHT,
    PROCEDURE_CHECK,
    PROCEDURE_CLEAN,
    PROCEDURE_CLASSIC,
    PROCEDURE_RESIZE,
    PROCEDURE_COUNT
} procedure_id;

typedef struct procedure_labels {
    const char *title; /* of the dialog */
    const char *menu;  /* with a mnemonic; NULL: not in the menus */
} procedure_labels;

typedef struct procedure {
    const char *name;
    /* GIMP 3 has the operations in its menus too, so names say what only the plug-in does. */
    procedure_labels in_gimp3, in_gimp2;
    const char *blurb;
    const char *help;
    const field *fields;
    int count;
} procedure;

extern const procedure procedures[PROCEDURE_COUNT];

/* NULL if there is none with this name. */
const procedure *procedure_find(const char *name);

typedef struct settings {
    double value[MAX_FIELDS];
} settings;

void settings_reset(const procedure *p, settings *s);

/* Clamps values that are out of range; returns the first field that was, or NULL. */
const field *settings_check(const procedure *p, settings *s);

/* The fields on a page of the dialog, in the order shown; returns how many. */
int fields_on_page(const procedure *p, int page, int fields[MAX_FIELDS]);

/* The index of a choice by its name; -1: none. */
int choice_find(const field *f, const char *name);
int choice_count(const field *f);

/* Settings as lines of "name = value", numbers in the C locale: returns the length as snprintf. */
size_t settings_write(const procedure *p, const settings *s, char *text, size_t size);

/* Reads such lines; unknown names and values are ignored.  Layers are not saved. */
void settings_read(const procedure *p, settings *s, const char *text);

#endif
