/* SPDX-License-Identifier: MIT */
/*
 * versions.c - which libraries this build reads and writes with
 */
#include <stdio.h>

#include <png.h>
#include <zlib.h>
#ifdef NTPIO_HAVE_JPEG
#  include <jpeglib.h>
#endif
#ifdef NTPIO_HAVE_LIBDEFLATE
#  include <libdeflate.h>
#endif
#ifdef NTPIO_HAVE_ZSTD
#  include <zstd.h>
#endif

#include "ntpio.h"

#define TEXT_OF_(x) #x
#define TEXT_OF(x)  TEXT_OF_(x)

bool ntpio_reads(ntpio_format format)
{
#ifndef NTPIO_HAVE_JPEG
    if (format == NTPIO_JPEG)
        return false;
#endif
#ifndef NTPIO_HAVE_WEBP
    if (format == NTPIO_WEBP)
        return false;
#endif
#ifndef NTPIO_HAVE_EXR
    if (format == NTPIO_EXR)
        return false;
#endif
    return format <= NTPIO_EXR;
}

const char *ntpio_versions(void)
{
    return "libpng " PNG_LIBPNG_VER_STRING ", zlib " ZLIB_VERSION
#ifdef NTPIO_HAVE_LIBDEFLATE
           ", libdeflate " LIBDEFLATE_VERSION_STRING
#endif
#ifdef NTPIO_HAVE_ZSTD
           ", libzstd " ZSTD_VERSION_STRING
#endif
#if defined(NTPIO_HAVE_JPEG) && defined(LIBJPEG_TURBO_VERSION)
           ", libjpeg-turbo " TEXT_OF(LIBJPEG_TURBO_VERSION)
#elif defined(NTPIO_HAVE_JPEG)
           ", libjpeg " TEXT_OF(JPEG_LIB_VERSION)
#endif
#ifdef NTPIO_HAVE_WEBP
               ", libwebp " NTPIO_HAVE_WEBP
#endif
#ifdef NTPIO_HAVE_EXR
               ", OpenEXR " NTPIO_HAVE_EXR
#endif
        ;
}
