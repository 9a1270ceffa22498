/* SPDX-License-Identifier: MIT */
/*
 * exr_library.c - loads OpenEXRCore; NTPIO_EXR_LIBRARY is its name
 */
#include "exr_library.h"

#include "os/library.h"
#include "os/threads.h"

ntpio__exr_functions ntpio__exr;
static bool loaded;

static void load(void)
{
#define TEXT_OF(name) "exr_" #name,
    static const char *const NAMES[] = { NTPIO__EXR_EACH(TEXT_OF) };
    enum { COUNT = sizeof NAMES / sizeof NAMES[0] };
    _Static_assert(sizeof ntpio__exr == COUNT * sizeof(void *), "pointers alone");
    loaded = os_load_library(NTPIO_EXR_LIBRARY, NAMES, COUNT, &ntpio__exr);
}

bool ntpio__exr_load(const ntpio_reader *reader, ntpio_error *error)
{
    static os_once once = OS_ONCE;
    os_call_once(&once, load);
    return loaded || ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                                 "an EXR, which is read by %s; that is not installed here, or "
                                 "another version of it",
                                 NTPIO_EXR_LIBRARY);
}
