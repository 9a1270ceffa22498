/* SPDX-License-Identifier: MIT */
/*
 * deflate.h - packs the filtered rows of pictures as deflate does (RFC 1951)
 */
#ifndef NTPIO_DEFLATE_H
#define NTPIO_DEFLATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    NTPIO__WINDOW = 32768, /* how far back a match may reach */
    NTPIO__SLACK = 16,     /* bytes that are read, and do not matter, after the last one */
    NTPIO__LEVEL_ZLIB = 0, /* takes the matches that zlib would at level 6, of six bytes and more */
    NTPIO__LEVEL_MAX = 12, /* 1: fastest */
    NTPIO__LEVEL_FAR,      /* as the usual one, without matches below eight bytes */
    NTPIO__LEVEL_TRIAL,    /* as fast, nearly, and tells more of what the usual level makes */
    NTPIO__LEVEL_USUAL = 6
};

typedef struct ntpio__deflater ntpio__deflater;

/* Working memory, for this level and those below it; NULL without memory. */
ntpio__deflater *ntpio__deflater_new(int level);
void ntpio__deflater_free(ntpio__deflater *d);

/* What `size` bytes may take at most. */
size_t ntpio__deflate_bound(size_t size);

/*
 * Packs bytes[from] to bytes[to - 1]; they may repeat what stands up to a window before.  The slack
 * after them is zeros.  Returns the size in out, which ends at a whole byte, so that parts of a
 * stream packed by themselves are the stream one after the other.  `last` ends the stream.  The
 * result depends on nothing else.
 */
size_t ntpio__deflate(ntpio__deflater *d, int level, const uint8_t *bytes, size_t from, size_t to,
                      bool last, uint8_t *out);

/* Bits of that, without those that fill it up to a whole byte.  Up to there, zeros follow. */
size_t ntpio__deflated_bits(const ntpio__deflater *d);

/* May that begin within a byte?  Not where it has bytes as they are, which begin at whole ones. */
bool ntpio__deflated_shifts(const ntpio__deflater *d);

/* Bytes that matches below eight bytes saved at the usual level, and those next to it. */
size_t ntpio__deflate_saved_by_short(const ntpio__deflater *d);

#endif
