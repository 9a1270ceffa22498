/* SPDX-License-Identifier: MIT */
/*
 * output.c - writes a file beside its target, and renames it
 *
 * The directory belongs to this program alone, and it has neither links nor attributes.
 */
#include "os/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct os_output {
    int fd;
    char *target, *temp; /* NULL: standard output */
};

static bool fail(os_problem *problem, const char *what, int error)
{
    *problem = (os_problem) { .error = error };
    snprintf(problem->what, sizeof problem->what, "%s", what);
    return false;
}

os_output *os_output_standard(os_problem *problem)
{
    os_output *output = calloc(1, sizeof *output);
    if (output == NULL) {
        *problem = (os_problem) { .error = ENOMEM };
        return NULL;
    }
    fflush(stdout);
    output->fd = STDOUT_FILENO;
    return output;
}

static char *name_of_temporary(const char *path)
{
    const char suffix[] = ".ntp.tmp";
    const size_t length = strlen(path);
    char *name = malloc(length + sizeof suffix);
    if (name != NULL) {
        memcpy(name, path, length);
        memcpy(name + length, suffix, sizeof suffix);
    }
    return name;
}

static bool open_replacement(os_output *output, const char *path, os_problem *problem)
{
    struct stat st;
    if (stat(path, &st) == 0 && S_ISDIR(st.st_mode))
        return fail(problem, "cannot be written", EISDIR);
    output->target = strdup(path);
    output->temp = name_of_temporary(path);
    if (output->target == NULL || output->temp == NULL) {
        *problem = (os_problem) { .error = ENOMEM };
        return false;
    }
    output->fd = open(output->temp, O_RDWR | O_CREAT | O_TRUNC, 0666);
    return output->fd >= 0 || fail(problem, "cannot be written", errno);
}

os_output *os_output_open(const char *path, const os_file *made_of, os_problem *problem)
{
    os_output *output = os_output_standard(problem);
    (void) made_of;
    if (output == NULL)
        return NULL;
    output->fd = -1;
    if (open_replacement(output, path, problem))
        return output;
    os_output_free(output);
    return NULL;
}

bool os_output_can_seek(const os_output *output)
{
    return output->target != NULL;
}

bool os_output_write(os_output *output, uint64_t offset, const void *bytes, size_t size,
                     os_problem *problem)
{
    const unsigned char *from = bytes;
    for (size_t done = 0; done < size;) {
        const ssize_t wrote = output->target != NULL ? pwrite(output->fd, from + done, size - done,
                                                              (off_t) (offset + done))
                                                     : write(output->fd, from + done, size - done);
        if (wrote <= 0)
            return fail(problem, "cannot be written", wrote < 0 ? errno : EIO);
        done += (size_t) wrote;
    }
    return true;
}

bool os_output_sync(os_output *output, os_problem *problem)
{
    (void) output, (void) problem;
    return true;
}

bool os_output_finish(os_output *output, os_problem *problem)
{
    if (output->target == NULL)
        return true;
    close(output->fd);
    output->fd = -1;
    if (rename(output->temp, output->target) != 0)
        return fail(problem, "cannot be put in place", errno);
    free(output->temp);
    output->temp = NULL;
    return true;
}

void os_output_free(os_output *output)
{
    if (output == NULL)
        return;
    if (output->target != NULL && output->fd >= 0)
        close(output->fd);
    if (output->temp != NULL)
        unlink(output->temp);
    free(output->temp);
    free(output->target);
    free(output);
}
