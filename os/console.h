/* SPDX-License-Identifier: MIT */
/*
 * console.h - arguments, terminals, interruption, other programs
 */
#ifndef NTP_OS_CONSOLE_H
#define NTP_OS_CONSOLE_H

#include <stdbool.h>

/* First of all: arguments become UTF-8 with slashes, streams binary, terminals ready for it. */
void os_start(int *argc, char ***argv);

/* Is it a terminal that knows colors? */
bool os_input_is_terminal(void);
bool os_output_is_terminal(void);
bool os_error_is_terminal(void);

/* Columns of the terminal of standard error; 80 if it does not tell. */
int os_columns(void);

/* What ends a program that writes to a closed pipe or beyond a limit becomes an error of writing. */
void os_keep_write_errors(void);

/* After an error of writing: is it that the reader of a pipe went away?  It reads errno. */
bool os_reader_is_gone(void);

/* Calls a function when the user or the system asks for an end.  The second time ends at once. */
void os_on_interruption(void (*call)(int number));

/* The program's own file, to be freed; NULL if that is unknown. */
char *os_own_path(void);

/* Becomes another program, or returns false with errno.  argv[0] is its path. */
bool os_become(char **argv);

#endif
