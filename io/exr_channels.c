/* SPDX-License-Identifier: MIT */
/*
 * exr_channels.c - which channels of an EXR are read
 */
#include "exr_channels.h"

#include <string.h>

enum {
    CHANNELS_MAX = 1024, /* more would be an attack on time */
    NAME_SIZE = 80       /* of which a message shows so much */
};

void ntpio__exr_plain(char *dst, size_t room, const char *src)
{
    size_t n = 0;
    for (; src[n] != 0 && n + 1 < room; n++)
        dst[n] = src[n] >= 0x20 && src[n] < 0x7f ? src[n] : '?';
    dst[n] = 0;
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char) (c + ('a' - 'A')) : c;
}

static const char *name_of(const exr_attr_chlist_t *list, int i)
{
    return list->entries[i].name.str;
}

/* How long the name of a channel's layer is, its dot not counted; 0: it has none. */
static size_t layer_size(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot != NULL ? (size_t) (dot - name) : 0;
}

static const char *own_name(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot != NULL ? dot + 1 : name;
}

static bool same_layer(const char *a, const char *b)
{
    const size_t size = layer_size(a);
    return size == layer_size(b) && memcmp(a, b, size) == 0 &&
           (strchr(a, '.') != NULL) == (strchr(b, '.') != NULL);
}

static bool layer_has(const char *name, const char *word)
{
    const size_t size = layer_size(name), n = strlen(word);
    for (size_t i = 0; i + n <= size; i++) {
        size_t same = 0;
        while (same < n && lower(name[i + same]) == word[same])
            same++;
        if (same == n)
            return true;
    }
    return false;
}

/* Lower is taken first. */
static int rank_of(const char *name)
{
    return layer_has(name, "normal") || layer_has(name, "nrm") ? 0
           : strchr(name, '.') == NULL                         ? 1
                                                               : 2;
}

/* The channel of a letter in the layer of channel `of`, or -1. */
static int find(const exr_attr_chlist_t *list, int of, char letter)
{
    for (int i = 0; i < list->num_channels; i++) {
        const char *own = own_name(name_of(list, i));
        if (lower(own[0]) == letter && own[1] == 0 &&
            same_layer(name_of(list, i), name_of(list, of)))
            return i;
    }
    return -1;
}

static bool take(const exr_attr_chlist_t *list, int of, const char *letters,
                 ntpio__exr_choice *choice)
{
    choice->count = 0;
    for (; *letters != 0; letters++) {
        const int i = find(list, of, *letters);
        if (i < 0)
            return false;
        choice->index[choice->count++] = i;
    }
    return true;
}

static bool is_alone(const exr_attr_chlist_t *list, int of)
{
    int count = 0;
    for (int i = 0; i < list->num_channels; i++)
        count += same_layer(name_of(list, i), name_of(list, of));
    return count == 1;
}

/* What the layer of a channel offers. */
static bool take_layer(const exr_attr_chlist_t *list, int of, ntpio__exr_choice *choice)
{
    static const char *const SETS[] = { "rgb", "xyz", "rg", "y" };
    *choice = (ntpio__exr_choice) { .half = true };
    for (size_t i = 0; i < sizeof SETS / sizeof *SETS; i++) {
        if (!take(list, of, SETS[i], choice))
            continue;
        const int alpha = find(list, of, 'a');
        choice->vectors = SETS[i][0] == 'x';
        choice->pair = choice->count == 2;
        choice->alpha = alpha >= 0 && !choice->pair;
        if (choice->alpha)
            choice->index[choice->count++] = alpha;
        return true;
    }
    if (!is_alone(list, of))
        return false;
    choice->count = 1;
    choice->index[0] = of;
    return true;
}

static bool check_kind(const ntpio_reader *reader, const exr_attr_chlist_entry_t *c, bool picked,
                       ntpio_error *error)
{
    char name[NAME_SIZE];
    ntpio__exr_plain(name, sizeof name, c->name.str);
    if (c->x_sampling != 1 || c->y_sampling != 1)
        return ntpio__fail(
            error, NTPIO_ERR_FORMAT, reader->name,
            "an EXR whose channel %s has fewer samples than texels, which is not read", name);
    if (picked && c->pixel_type != EXR_PIXEL_HALF && c->pixel_type != EXR_PIXEL_FLOAT)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "the channel %s holds integers; half and single floats are read", name);
    return true;
}

/* Where the channels are in a line, and whether all of it can be read. */
static bool lay_out(const ntpio_reader *reader, const exr_attr_chlist_t *list,
                    ntpio__exr_choice *choice, ntpio_error *error)
{
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *c = &list->entries[i];
        const size_t bytes = c->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        bool picked = false;
        for (int32_t k = 0; k < choice->count; k++) {
            if (choice->index[k] != i)
                continue;
            picked = true;
            choice->bytes[k] = bytes;
            choice->offset[k] = choice->texel;
            choice->half = choice->half && bytes == 2;
        }
        if (!check_kind(reader, c, picked, error))
            return false;
        choice->texel += bytes;
    }
    return true;
}

bool ntpio__exr_choose(const ntpio_reader *reader, const exr_attr_chlist_t *list,
                       ntpio__exr_choice *choice, ntpio_error *error)
{
    if (list->num_channels > CHANNELS_MAX)
        return ntpio__fail(error, NTPIO_ERR_LIMIT, reader->name, "more than %d channels",
                           CHANNELS_MAX);
    for (int rank = 0; rank <= 2; rank++) {
        for (int i = 0; i < list->num_channels; i++) {
            if (rank_of(name_of(list, i)) == rank && take_layer(list, i, choice))
                return lay_out(reader, list, choice, error);
        }
    }
    return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                       "an EXR of %d channels, of which none are R, G, B or X, Y, Z or Y",
                       list->num_channels);
}
