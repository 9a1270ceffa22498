/* SPDX-License-Identifier: MIT */
/*
 * exr_library_name.c - prints the name by which a program loads the OpenEXRCore that it is linked to
 *
 * A later version has other functions under the same names, so this one is needed.
 */
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

#include <openexr.h>

int main(void)
{
    int major, minor, patch;
    const char *extra;
    exr_get_library_version(&major, &minor, &patch, &extra); /* which links it */
    void *const function = dlsym(RTLD_DEFAULT, "exr_get_library_version");
    Dl_info of;
    if (function == NULL || dladdr(function, &of) == 0 || strchr(of.dli_fname, '/') == NULL)
        return 1;
    puts(strrchr(of.dli_fname, '/') + 1);
    return 0;
}
