/* SPDX-License-Identifier: MIT */
/*
 * parts.h - items of work shared out among the parts that the caller's hooks offer
 */
#ifndef NTP_PARTS_H
#define NTP_PARTS_H

#include "libntp.h"

/* Part `part` does item `item`; items do not touch what others write. */
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

/* Does items of two kinds, none of which touches what another writes; every other part begins with
 * the second kind, so that what waits for memory goes on beside what computes. */
void ntp__crew_both(const ntp__crew *crew, const ntp__crew_items *a, const ntp__crew_items *b);

/* Does items 0..count - 1. */
void ntp__crew_each(const ntp__crew *crew, ntp__crew_task *task, void *job, int32_t count);

#endif
