/* SPDX-License-Identifier: MIT */
/*
 * cli.h - what every room uses: exit codes, messages, standard output, the progress bar
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

/* What happened in a run; a mask.  The worst of them decides the exit code. */
enum { RAN_FINDINGS = 1, RAN_USAGE = 2, RAN_FAILED = 4, RAN_INTERRUPTED = 8 };
int exit_code(unsigned ran);

/* The signal that ended the run, or 0.  Whoever reads or writes looks at it between blocks of
 * rows. */
extern _Atomic int interrupted_by; /* lock-free: a signal handler sets it, threads read it */

/* The progress bar; `done` is the share of all work.  left: texels that refinement has not brought
 * back yet; 0: none runs. */
void progress_draw(double done, size_t files, size_t total, uint64_t left);
void progress_clear(void);

/* Prints "ntp: MESSAGE" on standard error.  Clears the progress bar, and escapes what is unfit to
 * print, as text_name does. */
void complain(const char *format, ...) TEXT_FORMAT(1, 2);

/* Every result goes through here.  Results are dropped once their reader is gone (EPIPE).  Any
 * other failure is reported once, and output_failed() is true from then on. */
void output_text(const text *t);
void output_flush(void);
bool output_failed(void);
bool output_closed(void);
/* Sends results to standard error, because standard output is an image. */
void output_to_stderr(void);

#endif
