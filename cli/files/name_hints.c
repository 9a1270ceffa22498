/* SPDX-License-Identifier: MIT */
/*
 * name_hints.c - what the name of a file says about it
 *
 * A name is split into words at '_', '-', '.', blanks, and where a capital follows a small letter:
 * "BrickWall_1K_NormalGL" is brick, wall, 1, k, normal, gl.  The last word that names a kind of
 * image decides: "normals_mask" is a mask.  Long words for "normals" count anywhere.  Short ones (n,
 * nm, nor ...) count only at the end, where sizes and orientations may follow.
 */
#include <ctype.h>
#include <string.h>
#include <strings.h>

#include "files/paths.h"

enum { MAX_WORDS = 24, WORD_SIZE = 24 };

typedef struct words {
    char at[MAX_WORDS][WORD_SIZE];
    int count;
} words;

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

const char *name_ending(const char *path)
{
    const char *base = base_name(path);
    const char *dot = strrchr(base, '.');
    return dot != NULL && dot != base ? dot : "";
}

static bool ends_word(char before, char c)
{
    return (islower((unsigned char) before) && isupper((unsigned char) c)) ||
           (isdigit((unsigned char) before) != 0) != (isdigit((unsigned char) c) != 0);
}

static void cut(words *w, const char *path)
{
    const char *base = base_name(path);
    const size_t length = strlen(base) - strlen(name_ending(base));
    w->count = 0;
    size_t filled = 0;
    for (size_t i = 0; i <= length && w->count < MAX_WORDS; i++) {
        const char c = i < length ? base[i] : '_';
        const bool separator = strchr("_-. ()", c) != NULL;
        if (filled > 0 && (separator || ends_word(base[i - 1], c))) {
            w->at[w->count++][filled] = 0;
            filled = 0;
        }
        if (!separator && w->count < MAX_WORDS && filled < WORD_SIZE - 1)
            w->at[w->count][filled++] = (char) tolower((unsigned char) c);
    }
}

static bool is_one_of(const char *word, const char *const *list)
{
    for (; *list != NULL; list++) {
        if (strcmp(word, *list) == 0)
            return true;
    }
    return false;
}

static const char *const WORDS_UP[] = { "gl", "ogl", "opengl", "normalgl", "normalogl", NULL };
static const char *const WORDS_DOWN[] = { "dx", "directx", "normaldx", NULL };

static bool is_size(const char *word)
{
    return isdigit((unsigned char) word[0]) || strcmp(word, "k") == 0 || strcmp(word, "px") == 0;
}

/* Other images that belong to a material or show one. */
static const char *const OTHER_KINDS[] = {
    "albedo",    "basecolor", "color",      "colour",    "diffuse", "mask",         "masks",
    "roughness", "metallic",  "metalness",  "occlusion", "ao",      "orm",          "specular",
    "gloss",     "emissive",  "emission",   "height",    "bump",    "displacement", "opacity",
    "curvature", "thickness", "screenshot", "thumbnail", "preview", "icon",         NULL
};

/* Does a word before this one name a control of a window?  Its "normal" is a state, beside hovered and
 * pressed. */
static bool is_control(const words *w, int end)
{
    static const char *const CONTROLS[] = { "ui",     "gui",      "hud",    "button", "btn",
                                            "cursor", "checkbox", "slider", "menu",   NULL };
    for (int i = 0; i < end; i++) {
        if (is_one_of(w->at[i], CONTROLS))
            return true;
    }
    return false;
}

bool name_is_normals(const char *path)
{
    static const char *const ANYWHERE[] = { "normal",   "normals",   "normalmap", "normalmaps",
                                            "nrm",      "nrml",      "nmap",      "ddn",
                                            "normalgl", "normalogl", "normaldx",  NULL };
    static const char *const LAST[] = { "n", "nm", "nor", "norm", "nn", "ddna", "nml", NULL };
    words w;
    cut(&w, path);
    for (int i = w.count - 1; i >= 0; i--) {
        if (is_one_of(w.at[i], ANYWHERE))
            return !is_control(&w, i);
        if (is_one_of(w.at[i], OTHER_KINDS))
            return false;
    }
    int last = w.count - 1;
    while (last > 0 && (is_size(w.at[last]) || is_one_of(w.at[last], WORDS_UP) ||
                        is_one_of(w.at[last], WORDS_DOWN)))
        last--;
    return last > 0 && is_one_of(w.at[last], LAST);
}

name_y name_orientation(const char *path)
{
    words w;
    cut(&w, path);
    for (int i = w.count - 1; i > 0; i--) {
        if (is_one_of(w.at[i], WORDS_UP))
            return NAME_Y_UP;
        if (is_one_of(w.at[i], WORDS_DOWN))
            return NAME_Y_DOWN;
    }
    return NAME_Y_NONE;
}

static bool ends_in_one_of(const char *path, const char *const *endings)
{
    const char *ending = name_ending(path);
    for (; *endings != NULL; endings++) {
        if (strcasecmp(ending, *endings) == 0)
            return true;
    }
    return false;
}

bool name_promises(const char *path, bool zzero)
{
    static const char *const XY[] = { "xy", "rg", "bc", "ati", "dxn", NULL };
    static const char *const ZZERO[] = { "zzero", NULL };
    words w;
    cut(&w, path);
    for (int i = 1; i < w.count; i++) {
        const bool number = i + 1 < w.count && isdigit((unsigned char) w.at[i + 1][0]);
        const bool format = strcmp(w.at[i], "bc") == 0 || strcmp(w.at[i], "ati") == 0;
        if (is_one_of(w.at[i], zzero ? ZZERO : XY) &&
            (!format || (number && strchr("25", w.at[i + 1][0]) != NULL)))
            return true;
    }
    return false;
}

/* Is the file of a format that some builds read, and this one does, or does not? */
static bool name_is_optional(const char *path, bool is_read)
{
    static const char *const WEBP[] = { ".webp", NULL }, *const EXR[] = { ".exr", NULL };
    return (ends_in_one_of(path, WEBP) && ntpio_reads(NTPIO_WEBP) == is_read) ||
           (ends_in_one_of(path, EXR) && ntpio_reads(NTPIO_EXR) == is_read);
}

bool name_is_image(const char *path)
{
    static const char *const ENDINGS[] = { ".png", ".tga", ".jpg",  ".jpeg", ".jpe",
                                           ".pfm", ".dds", ".ktx2", NULL };
    return ends_in_one_of(path, ENDINGS) || name_is_optional(path, true);
}

bool name_is_foreign(const char *path)
{
    static const char *const ENDINGS[] = { ".astc", ".avif", ".basis", ".bmp", ".crn", ".dib",
                                           ".gif",  ".hdr",  ".heic",  ".j2k", ".jp2", ".jxl",
                                           ".ktx",  ".pcx",  ".pgm",   ".pnm", ".ppm", ".psb",
                                           ".psd",  ".pvr",  ".qoi",   ".rgb", ".sgi", ".svg",
                                           ".tif",  ".tiff", ".tx",    ".vtf", NULL };
    return ends_in_one_of(path, ENDINGS) || name_is_optional(path, false);
}
