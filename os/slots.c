/* SPDX-License-Identifier: MIT */
/*
 * slots.c - names of temporary files beside a target
 */
#include "os/slots.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HASH_SIZE = 9 /* ~ and 8 hex digits */ };

static uint32_t fnv1a(const char *s)
{
    uint32_t hash = 2166136261u;
    for (; *s != 0; s++)
        hash = (hash ^ (unsigned char) *s) * 16777619u;
    return hash;
}

/* If a name is too long for the suffix, a hash of the whole replaces its end. */
char *os__slot_name(const char *target, long limit, unsigned slot)
{
    const size_t length = strlen(target);
    if (limit < OS__SLOT_SUFFIX + HASH_SIZE + 2)
        limit = OS__SLOT_NAME_LIMIT;
    const size_t size = length + HASH_SIZE + OS__SLOT_SUFFIX + 2;
    char *name = malloc(size);
    if (name == NULL)
        return NULL;
    if (length + 1 + OS__SLOT_SUFFIX <= (size_t) limit) {
        snprintf(name, size, ".%s.ntp-%06u.tmp", target, slot);
        return name;
    }
    size_t keep = (size_t) limit - 1 - OS__SLOT_SUFFIX - HASH_SIZE;
    keep = keep < length ? keep : length;
    while (keep > 1 && ((unsigned char) target[keep] & 0xc0) == 0x80)
        keep--;
    snprintf(name, size, ".%.*s~%08lx.ntp-%06u.tmp", (int) keep, target,
             (unsigned long) fnv1a(target), slot);
    return name;
}
