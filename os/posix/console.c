/* SPDX-License-Identifier: MIT */
/*
 * console.c - arguments, terminals, interruption, other programs
 */
#include "os/console.h"

#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

#ifdef __APPLE__
#  include <mach-o/dyld.h>
#endif

static void (*on_interruption)(int number);

void os_start(int *argc, char ***argv)
{
    (void) argc, (void) argv;
}

bool os_input_is_terminal(void)
{
    return isatty(STDIN_FILENO);
}

bool os_output_is_terminal(void)
{
    return isatty(STDOUT_FILENO);
}

bool os_error_is_terminal(void)
{
    return isatty(STDERR_FILENO);
}

int os_columns(void)
{
    struct winsize size;
    enum { USUAL = 80 };
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : USUAL;
}

static void on_write_signals(void (*how)(int))
{
    signal(SIGPIPE, how);
    signal(SIGXFSZ, how);
}

void os_keep_write_errors(void)
{
    on_write_signals(SIG_IGN);
}

bool os_reader_is_gone(void)
{
    return errno == EPIPE;
}

static void on_signal(int number)
{
    on_interruption(number);
}

void os_on_interruption(void (*call)(int number))
{
    const struct sigaction action = { .sa_handler = on_signal, .sa_flags = (int) SA_RESETHAND };
    static const int ENDING[] = { SIGINT, SIGTERM, SIGHUP };
    on_interruption = call;
    for (size_t i = 0; i < sizeof ENDING / sizeof ENDING[0]; i++) {
        struct sigaction old;
        if (sigaction(ENDING[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN)
            sigaction(ENDING[i], &action, NULL);
    }
}

char *os_own_path(void)
{
#ifdef __APPLE__
    enum { SIZE = 4096 };
    char path[SIZE];
    uint32_t size = sizeof path;
    return _NSGetExecutablePath(path, &size) == 0 ? realpath(path, NULL) : NULL;
#else
    return realpath("/proc/self/exe", NULL);
#endif
}

bool os_become(char **argv)
{
    on_write_signals(SIG_DFL);
    execv(argv[0], argv);
    on_write_signals(SIG_IGN);
    return false;
}
