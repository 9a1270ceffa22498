/* SPDX-License-Identifier: MIT */
/*
 * exr_library.h - OpenEXRCore, linked or loaded with the first EXR
 *
 * To load it, and the libraries that it needs, takes a twentieth of the time of a small PNG.
 */
#ifndef NTPIO_EXR_LIBRARY_H
#define NTPIO_EXR_LIBRARY_H

#include <openexr.h>

#include "reader.h"

#ifdef NTPIO_EXR_LIBRARY

#  define NTPIO__EXR_EACH(DO)                                                                      \
      DO(decoding_choose_default_routines)                                                         \
      DO(decoding_destroy)                                                                         \
      DO(decoding_initialize)                                                                      \
      DO(decoding_run)                                                                             \
      DO(decoding_update)                                                                          \
      DO(finish)                                                                                   \
      DO(get_channels)                                                                             \
      DO(get_compression)                                                                          \
      DO(get_count)                                                                                \
      DO(get_data_window)                                                                          \
      DO(get_default_error_message)                                                                \
      DO(get_scanlines_per_chunk)                                                                  \
      DO(get_storage)                                                                              \
      DO(get_tile_descriptor)                                                                      \
      DO(get_user_data)                                                                            \
      DO(read_chunk)                                                                               \
      DO(read_scanline_chunk_info)                                                                 \
      DO(read_tile_chunk_info)                                                                     \
      DO(start_read)

typedef struct ntpio__exr_functions {
#  define NTPIO__EXR_MEMBER(name) __typeof__(exr_##name) *name;
    NTPIO__EXR_EACH(NTPIO__EXR_MEMBER)
} ntpio__exr_functions;

extern ntpio__exr_functions ntpio__exr;

/* Call this before anything else.  False, with a message: the library is missing. */
bool ntpio__exr_load(const ntpio_reader *reader, ntpio_error *error);

#  define EXR(name) ntpio__exr.name

#else

static inline bool ntpio__exr_load(const ntpio_reader *reader, ntpio_error *error)
{
    (void) reader, (void) error;
    return true;
}

#  define EXR(name) exr_##name

#endif

#endif
