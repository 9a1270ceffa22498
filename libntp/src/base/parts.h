/* SPDX-License-Identifier: MIT */
/*
 * parts.h - shares items of work out among the parts that the caller's hooks offer
 */
#ifndef NTP_PARTS_H
#define NTP_PARTS_H

#include "libntp.h"

/* Part `part` does item `item`.  An item does not touch what another item writes. */
typedef void ntp__crew_task(void *job, int32_t part, int32_t item);

typedef struct ntp__crew {
    const ntp_hooks *hooks;
    int32_t parts;
} ntp__crew;

ntp__crew ntp__crew_of(const ntp_hooks *hooks);

typedef struct ntp__crew_items {
    ntp__crew_task *task;
    void *job;
    int32_t count;
} ntp__crew_items;

/* Does items of two kinds, none of which touches what another writes.  Every other part begins with
 * the second kind.  So items that wait for memory run at the same time as items that compute. */
void ntp__crew_both(const ntp__crew *crew, const ntp__crew_items *a, const ntp__crew_items *b);

/* Does items 0..count - 1. */
void ntp__crew_each(const ntp__crew *crew, ntp__crew_task *task, void *job, int32_t count);

#endif
