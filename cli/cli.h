/* SPDX-License-Identifier: MIT */
/*
 * cli.h - what every part of the program shares: exit codes, messages, standard output
 */
#ifndef NTP_CLI_H
#define NTP_CLI_H

#include <stdbool.h>

#include "text/text.h"

enum {
    NTP_EXIT_DONE = 0,
    NTP_EXIT_FINDINGS = 1, /* findings at or above --fail-on, differences, refused files */
    NTP_EXIT_USAGE = 2,
    NTP_EXIT_FAILED = 3, /* an input could not be read or an output not written */
    NTP_EXIT_INTERRUPTED = 130
};

/* What happened in a run; a mask.  The exit code is the weightiest of them. */
enum { RAN_FINDINGS = 1, RAN_USAGE = 2, RAN_FAILED = 4, RAN_INTERRUPTED = 8 };
int exit_code(unsigned ran);

/* The signal that asks for an end, 0 while none came.  Writers look at it between rows. */
extern _Atomic int interrupted_by; /* lock-free: a signal handler sets it, threads read it */

/* The progress bar: `done` is the share of all work.  It stands until it is drawn anew or cleared. */
void progress_draw(double done, size_t files, size_t total);
void progress_clear(void);

/* "ntp: MESSAGE" on standard error, names in it made fit to print (text_name).  A progress bar that
 * stands there is cleared. */
void complain(const char *format, ...) TEXT_FORMAT(1, 2);

/* Everything that is a result goes through here.  After a reader went away (EPIPE) it is
 * dropped; any other failure is told once, and output_failed() is true from then on. */
void output_text(const text *t);
void output_flush(void);
bool output_failed(void);
bool output_closed(void);
/* Sends results to standard error, because standard output is an image. */
void output_to_stderr(void);

#endif
