/* SPDX-License-Identifier: MIT */
/*
 * reader.c - what decoders share: limits, images that are held whole, files that end too early
 */
#include "reader.h"

#include <stdlib.h>
#include <string.h>

size_t ntpio__row_bytes(const ntpio_info *info)
{
    return (size_t) info->width * (size_t) info->channels * (size_t) info->sample_bytes;
}

bool ntpio__check_size(const ntpio_reader *reader, uint64_t width, uint64_t height,
                       ntpio_error *error)
{
    if (width == 0 || height == 0)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "no texels: %llu x %llu",
                           (unsigned long long) width, (unsigned long long) height);
    if (width > reader->limits.max_side || height > reader->limits.max_side)
        return ntpio__fail(error, NTPIO_ERR_LIMIT, reader->name,
                           "%llu x %llu is larger than the limit of %lu a side",
                           (unsigned long long) width, (unsigned long long) height,
                           (unsigned long) reader->limits.max_side);
    if (width > reader->limits.max_texels / height)
        return ntpio__fail(error, NTPIO_ERR_LIMIT, reader->name,
                           "%llu x %llu is more than the limit of %llu texels",
                           (unsigned long long) width, (unsigned long long) height,
                           (unsigned long long) reader->limits.max_texels);
    return true;
}

bool ntpio__check_memory(const ntpio_reader *reader, uint64_t bytes, ntpio_error *error)
{
    if (bytes > reader->limits.max_memory || bytes > PTRDIFF_MAX)
        return ntpio__fail(error, NTPIO_ERR_LIMIT, reader->name,
                           "needs %llu MiB of memory, more than the limit of %llu MiB",
                           (unsigned long long) (bytes >> 20) + 1,
                           (unsigned long long) (reader->limits.max_memory >> 20));
    return true;
}

bool ntpio__hold_source(ntpio_reader *reader, ntpio_error *error)
{
    bool too_long;
    if (ntpio__source_hold(&reader->source, reader->limits.max_memory, &too_long))
        return true;
    return too_long ? ntpio__check_memory(reader, UINT64_MAX, error)
                    : ntpio__fail_memory(error, reader->name);
}

bool ntpio__hold(ntpio_reader *reader, ntpio_error *error)
{
    /* No overflow: the sides have passed ntpio__check_size. */
    const uint64_t size = (uint64_t) ntpio__row_bytes(&reader->info) * reader->info.height;
    if (!ntpio__check_memory(reader, size, error))
        return false;
    reader->held = malloc((size_t) size);
    if (reader->held == NULL)
        return ntpio__fail_memory(error, reader->name);
    reader->info.streams = false;
    return true;
}

bool ntpio__fail_ended(const ntpio_reader *reader, ntpio_error *error)
{
    if (reader->source.problem != 0)
        return ntpio__fail(error, NTPIO_ERR_OPEN, reader->name, "cannot be read: %s",
                           strerror(reader->source.problem));
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "truncated");
}

bool ntpio__read_all(ntpio_reader *reader, void *dst, size_t size, ntpio_error *error)
{
    return ntpio__read(&reader->source, dst, size) == size || ntpio__fail_ended(reader, error);
}
