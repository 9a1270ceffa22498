/* SPDX-License-Identifier: MIT */
/*
 * written.h - images of noise, written and read back
 */
#ifndef WRITTEN_H
#define WRITTEN_H

#include "../system.h"
#include <dirent.h>

#include "made.h"
#include "ntpio.h"

static ntpio_error error;
static uint8_t noise[1 << 20];

static inline void make_noise(void)
{
    for (size_t i = 0; i < sizeof noise; i++)
        noise[i] = (uint8_t) sample((uint32_t) i, 3, 1, 8);
}

static inline ntpio_write_options rgb(uint32_t side)
{
    return (ntpio_write_options) { .format = NTPIO_PNG,
                                   .width = side,
                                   .height = side,
                                   .channels = 3,
                                   .sample_bytes = 1,
                                   .level = -1 };
}

static inline bool write_all(const char *path, const ntpio_write_options *o)
{
    ntpio_writer *w = ntpio_create(path, o, &error);
    const size_t row = (size_t) o->width * (size_t) (o->channels * o->sample_bytes);
    if (w == NULL)
        return false;
    if (!ntpio_write_rows(w, noise, (ptrdiff_t) row, o->height, &error)) {
        ntpio_abort(w);
        return false;
    }
    return ntpio_commit(w, &error);
}

static inline ntpio_reader *read_back(const char *path, const ntpio_write_options *o)
{
    const size_t row = (size_t) o->width * (size_t) (o->channels * o->sample_bytes);
    uint8_t *image = malloc(row * o->height);
    ntpio_reader *r = ntpio_open(path, NULL, &error);
    CHECK(image != NULL && r != NULL);
    CHECK(ntpio_read_rows(r, image, (ptrdiff_t) row, o->height, &error));
    CHECK(ntpio_read_end(r, &error));
    CHECK(memcmp(image, noise, row * o->height) == 0);
    free(image);
    return r;
}

/* How many files the folder holds. */
static inline size_t entries(void)
{
    size_t n = 0;
    DIR *d = opendir(".");
    CHECK(d != NULL);
    for (const struct dirent *e; (e = readdir(d)) != NULL;)
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(d);
    return n;
}

#endif
