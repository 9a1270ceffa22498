/* SPDX-License-Identifier: MIT */
/*
 * library.c - a shared library that is loaded when it is needed
 */
#include "os/library.h"

#include <dlfcn.h>
#include <string.h>

bool os_load_library(const char *library, const char *const *names, size_t count, void *functions)
{
    void *const handle = dlopen(library, RTLD_LAZY | RTLD_LOCAL);
    for (size_t i = 0; handle != NULL && i < count; i++) {
        void *const address = dlsym(handle, names[i]);
        if (address == NULL)
            return false;
        /* ISO C has no cast to a pointer to a function; POSIX gives both one form. */
        memcpy((char *) functions + i * sizeof address, &address, sizeof address);
    }
    return handle != NULL;
}
