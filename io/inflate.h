/* SPDX-License-Identifier: MIT */
/*
 * inflate.h - unpacks deflate part by part, in memory that stays small
 *
 * libdeflate unpacks only a whole stream into a whole picture.  Fresh memory for both can take as
 * long as the unpacking.  This stops where the room ends or the input does; it takes half the time
 * where nearly all codes are literals, and up to a tenth more where few are.
 * It refuses every stream that zlib refuses (libdeflate takes some of them), and a code of one
 * literal, which no encoder makes.
 */
#ifndef NTPIO_INFLATE_H
#define NTPIO_INFLATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    NTPIO__WINDOW = 1 << 15,
    /* Bytes that must follow `in_end`, of any value: more than the code lengths of a block take. */
    NTPIO__IN_SLACK = 512,
    /* Room that must be left after `out` for a step: a repetition and what is written beyond. */
    NTPIO__OUT_SLACK = 320,
    NTPIO__LITERAL_BITS = 11,
    NTPIO__DISTANCE_BITS = 8,
    NTPIO__CODE_MAX = 15,
    /* A table, and for at most half as many symbols tables of the longer codes. */
    NTPIO__LITERAL_TABLE = (1 << 11) + 144 * (1 << 4),
    NTPIO__DISTANCE_TABLE = (1 << 8) + 16 * (1 << 7)
};

typedef enum ntpio__inflated {
    NTPIO__NEEDS_ROOM,
    NTPIO__NEEDS_INPUT,
    NTPIO__STREAM_ENDS,
    NTPIO__STREAM_BAD
} ntpio__inflated;

typedef struct ntpio__inflate {
    const uint8_t *in, *in_end;
    uint64_t
        bits; /* read and not used: the lowest `bit_count`; above them anything that comes next */
    unsigned bit_count;
    bool no_more;         /* nothing comes after in_end */
    bool in_block, last;  /* within a block; it is the last one */
    bool stored;          /* its bytes are as they are: */
    uint32_t stored_left; /* so many more */
    uint32_t literals[NTPIO__LITERAL_TABLE],
        distances[NTPIO__DISTANCE_TABLE]; /* last; need no zeros */
} ntpio__inflate;

/*
 * Unpacks until less than NTPIO__OUT_SLACK bytes are left before `out_end`, or until the input
 * runs short and more comes.  *out moves on.  What was unpacked before stands from `begin` on: all
 * of it, or the window at least.
 */
ntpio__inflated ntpio__inflate_some(ntpio__inflate *s, const uint8_t *begin, uint8_t **out,
                                    const uint8_t *out_end);

/* Once the stream has ended: where the bytes after it begin. */
const uint8_t *ntpio__inflate_end(ntpio__inflate *s);

#endif
