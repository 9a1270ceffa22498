/* SPDX-License-Identifier: MIT */
/*
 * output.h - where the bytes of an image go: a file beside its target, or a pipe
 */
#ifndef NTPIO_OUTPUT_H
#define NTPIO_OUTPUT_H

#include "ntpio.h"

typedef struct ntpio__output ntpio__output;

/* Of the options, only those about the file that was read are looked at. */
ntpio__output *ntpio__output_open(const char *path, const ntpio_write_options *options,
                                  ntpio_error *error);
bool ntpio__output_write(ntpio__output *output, const void *bytes, size_t size, ntpio_error *error);

/* Does ntpio__output_write_at work?  Not for a pipe. */
bool ntpio__output_can_seek(const ntpio__output *output);
bool ntpio__output_write_at(ntpio__output *output, uint64_t offset, const void *bytes, size_t size,
                            ntpio_error *error);
bool ntpio__output_commit(ntpio__output *output, ntpio_error *error);
void ntpio__output_abort(ntpio__output *output);

#endif
