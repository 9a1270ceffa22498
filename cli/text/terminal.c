/* SPDX-License-Identifier: MIT */
/*
 * terminal.c - standard output, and standard error with the progress bar
 *
 * Results are written whole and checked.  A full disk behind standard output is an error.  A reader
 * that went away is none.
 */
#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"
#include "os/console.h"

_Atomic int interrupted_by;

static struct {
    bool failed, closed, to_stderr;
} out;

static bool progress_is_drawn;

int exit_code(unsigned ran)
{
    if ((ran & RAN_INTERRUPTED) != 0)
        return NTP_EXIT_INTERRUPTED;
    if ((ran & RAN_USAGE) != 0)
        return NTP_EXIT_USAGE;
    if ((ran & RAN_FAILED) != 0)
        return NTP_EXIT_FAILED;
    return (ran & RAN_FINDINGS) != 0 ? NTP_EXIT_FINDINGS : NTP_EXIT_DONE;
}

void progress_clear(void)
{
    if (progress_is_drawn)
        fputs("\r\033[K", stderr);
    progress_is_drawn = false;
}

/* Of one file it is not worth saying how many are done. */
static int write_counts(char *counts, size_t size, size_t files, size_t total, uint64_t left)
{
    if (left > 0 && total == 1)
        return snprintf(counts, size, "  %" PRIu64 " texels left", left);
    if (left > 0)
        return snprintf(counts, size, "  %zu of %zu files, %" PRIu64 " texels left", files, total,
                        left);
    return snprintf(counts, size, "  %zu of %zu files", files, total);
}

/* A line that is wrapped cannot be cleared.  So the bar gets shorter, and then the counts go. */
void progress_draw(double done, size_t files, size_t total, uint64_t left)
{
    enum { CELLS = 30, FEWEST_CELLS = 4, BRACKETS = 2, SIZE = 80 };
    char bar[CELLS + 1], counts[SIZE], line[SIZE];
    const int percent = (int) (100 * done), room = os_columns() - 1; /* the last column wraps */
    const int share = snprintf(line, sizeof line, " %3d %%", percent);
    const int used = share + write_counts(counts, sizeof counts, files, total, left);
    const bool counts_fit = used <= room;
    int cells = room - BRACKETS - (counts_fit ? used : share);
    cells = cells > CELLS ? CELLS : cells < FEWEST_CELLS ? 0 : cells;
    const int full = (int) (done * cells);
    for (int i = 0; i < cells; i++)
        bar[i] = i < full ? '#' : '.';
    bar[cells] = 0;
    if (share > room)
        return;
    fprintf(stderr, "\r%s%s%s%s%s\033[K", cells > 0 ? "[" : "", bar, cells > 0 ? "]" : "", line,
            counts_fit ? counts : "");
    fflush(stderr);
    progress_is_drawn = true;
}

void complain(const char *format, ...)
{
    progress_clear();
    char message[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    text t = { 0 };
    text_name(&t, message); /* it may quote file names */
    fprintf(stderr, "ntp: %s\n", text_string(&t));
    fflush(stderr);
    text_free(&t);
}

static void note_failure(void)
{
    if (os_reader_is_gone()) {
        out.closed = true;
    } else if (!out.failed) {
        out.failed = true;
        complain("standard output: %s", strerror(errno));
    }
}

void output_text(const text *t)
{
    FILE *file = out.to_stderr ? stderr : stdout;
    if (out.failed || out.closed || t->size == 0)
        return;
    if (fwrite(t->data, 1, t->size, file) != t->size)
        note_failure();
}

void output_flush(void)
{
    if (!out.failed && !out.closed && !out.to_stderr && fflush(stdout) != 0)
        note_failure();
}

bool output_failed(void)
{
    return out.failed;
}

bool output_closed(void)
{
    return out.closed;
}

void output_to_stderr(void)
{
    out.to_stderr = true;
}
