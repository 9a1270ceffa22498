/* SPDX-License-Identifier: MIT */
/*
 * slots.h - names of temporary files beside a target: ".NAME.ntp-00000N.tmp"
 *
 * They are numbered and not random, so stale files are found without reading directories.
 */
#ifndef NTP_OS_SLOTS_H
#define NTP_OS_SLOTS_H

enum {
    OS__SLOTS = 16,           /* writers of one target at the same time */
    OS__SLOT_SUFFIX = 15,     /* .ntp-00000N.tmp */
    OS__SLOT_NAME_LIMIT = 255 /* if the file system does not say */
};

/* Of a file, without its directory; limit: the most bytes of a name.  To be freed; NULL: no memory. */
char *os__slot_name(const char *target, long limit, unsigned slot);

#endif
