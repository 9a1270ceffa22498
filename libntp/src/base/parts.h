/* SPDX-License-Identifier: MIT */
/*
 * parts.h - shares items of work out among the parts that the caller's hooks offer
 */
#ifndef NTP_PARTS_H
#define NTP_PARTS_H

#include "libntp.h"

#include <stdbool.h>

/* Part `part` does item `item`.  An item does not touch what another item writes. */
typedef void ntp__crew_task(void *job, int32_t part, int32_t item);

typedef struct ntp__crew {
    const ntp_hooks *hooks;
    int32_t parts;
} ntp__crew;

ntp__crew ntp__crew_of(const ntp_hooks *hooks);

/* Does items 0..count - 1. */
void ntp__crew_each(const ntp__crew *crew, ntp__crew_task *task, void *job, int32_t count);

enum { NTP__MOST_BLOCKS = 64, NTP__MOST_LANES = 16 };

/* Work on blocks in two steps.  `each` takes blocks in any order.  `chain` takes them in their
 * order, in each lane of its own. */
typedef struct ntp__crew_steps {
    ntp__crew_task *each;
    void (*chain)(void *job, int32_t lane, int32_t block);
    void *job;
    int32_t count;    /* of blocks, up to NTP__MOST_BLOCKS */
    int32_t lanes;    /* up to NTP__MOST_LANES; 0: there is no chain */
    bool chain_first; /* chain is the first step of a block, else each */
} ntp__crew_steps;

/* Does both steps of all blocks.  A part takes what is ready, so that none waits for another, and
 * mostly does the second step of a block right after the first, while it is in the part's cache. */
void ntp__crew_blocks(const ntp__crew *crew, const ntp__crew_steps *steps);

#endif
