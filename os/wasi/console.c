/* SPDX-License-Identifier: MIT */
/*
 * console.c - no terminals, signals or other programs
 */
#include "os/console.h"

#include <errno.h>
#include <stddef.h>

void os_start(int *argc, char ***argv)
{
    (void) argc, (void) argv;
}

bool os_input_is_terminal(void)
{
    return false;
}

bool os_output_is_terminal(void)
{
    return false;
}

bool os_error_is_terminal(void)
{
    return false;
}

int os_columns(void)
{
    enum { USUAL = 80 };
    return USUAL;
}

void os_keep_write_errors(void)
{
}

bool os_reader_is_gone(void)
{
    return errno == EPIPE;
}

void os_on_interruption(void (*call)(int number))
{
    (void) call;
}

char *os_own_path(void)
{
    return NULL;
}

bool os_become(char **argv)
{
    (void) argv;
    errno = ENOSYS;
    return false;
}
