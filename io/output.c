/* SPDX-License-Identifier: MIT */
/*
 * output.c - a buffer in front of the file that os/ writes, and the check that its input is the same
 */
#include "output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "os/output.h"
#include "stamp.h"

enum { BUFFER_SIZE = 1 << 18 /* few system calls */ };

struct ntpio__output {
    os_output *file;
    char *name;      /* for messages */
    char *read_path; /* see ntpio_write_options */
    ntpio_stamp read_stamp;
    uint8_t *buffer;
    size_t used;
    uint64_t offset; /* of the buffer in the file */
};

static bool fail_as_changed(const ntpio__output *output, ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_WRITE, output->read_path, "%s",
                       "changed meanwhile; the result of its older version is not written");
}

static bool fail(const ntpio__output *output, const os_problem *problem, ntpio_error *error)
{
    if (problem->changed)
        return fail_as_changed(output, error);
    if (problem->error == ENOMEM && problem->what[0] == 0)
        return ntpio__fail_memory(error, output->name);
    return ntpio__fail(error, NTPIO_ERR_WRITE, output->name, "%s: %s", problem->what,
                       strerror(problem->error));
}

static bool input_is_current(const ntpio__output *output, ntpio_error *error)
{
    return output->read_path == NULL || ntpio_is_current(output->read_path, &output->read_stamp) ||
           fail_as_changed(output, error);
}

/* ------------------------------------------------------------------------ opening */

static ntpio__output *new_output(const char *name, const ntpio_write_options *options,
                                 ntpio_error *error)
{
    const char *read_path = options->read_path;
    ntpio__output *output = calloc(1, sizeof *output);
    if (output != NULL) {
        output->name = ntpio__copy_string(name, strlen(name));
        output->buffer = malloc(BUFFER_SIZE);
        output->read_stamp = options->read_stamp;
        if (read_path != NULL)
            output->read_path = ntpio__copy_string(read_path, strlen(read_path));
    }
    if (output != NULL && output->name != NULL && output->buffer != NULL &&
        (read_path == NULL || output->read_path != NULL))
        return output;
    ntpio__fail_memory(error, name);
    if (output != NULL)
        ntpio__output_abort(output);
    return NULL;
}

ntpio__output *ntpio__output_open(const char *path, const ntpio_write_options *options,
                                  ntpio_error *error)
{
    const bool standard = strcmp(path, "-") == 0;
    ntpio__output *output = new_output(standard ? "standard output" : path, options, error);
    if (output == NULL)
        return NULL;
    os_problem problem;
    const os_file made_of = ntpio__version_of(&output->read_stamp);
    output->file = standard
                       ? os_output_standard(&problem)
                       : os_output_open(path, output->read_stamp.known ? &made_of : NULL, &problem);
    if (output->file != NULL)
        return output;
    fail(output, &problem, error);
    input_is_current(output, error); /* else that is the reason */
    ntpio__output_abort(output);
    return NULL;
}

/* ------------------------------------------------------------------------ writing */

static bool write_out(ntpio__output *output, const uint8_t *bytes, size_t size, ntpio_error *error)
{
    os_problem problem;
    if (size != 0 && !os_output_write(output->file, output->offset, bytes, size, &problem))
        return fail(output, &problem, error);
    output->offset += size;
    return true;
}

static bool flush(ntpio__output *output, ntpio_error *error)
{
    const size_t used = output->used;
    output->used = 0;
    return write_out(output, output->buffer, used, error);
}

bool ntpio__output_write(ntpio__output *output, const void *bytes, size_t size, ntpio_error *error)
{
    if (size > BUFFER_SIZE - output->used) {
        if (!flush(output, error))
            return false;
        if (size >= BUFFER_SIZE)
            return write_out(output, bytes, size, error);
    }
    memcpy(output->buffer + output->used, bytes, size);
    output->used += size;
    return true;
}

bool ntpio__output_can_seek(const ntpio__output *output)
{
    return os_output_can_seek(output->file);
}

bool ntpio__output_write_at(ntpio__output *output, uint64_t offset, const void *bytes, size_t size,
                            ntpio_error *error)
{
    if (!flush(output, error))
        return false;
    output->offset = offset;
    return write_out(output, bytes, size, error);
}

/* Somebody may save another version while a large file goes to the disk. */
static bool end(ntpio__output *output, ntpio_error *error)
{
    os_problem problem;
    if (!flush(output, error))
        return false;
    if (!os_output_sync(output->file, &problem))
        return fail(output, &problem, error);
    return input_is_current(output, error) &&
           (os_output_finish(output->file, &problem) || fail(output, &problem, error));
}

bool ntpio__output_commit(ntpio__output *output, ntpio_error *error)
{
    const bool done = end(output, error);
    ntpio__output_abort(output); /* what is finished stays */
    return done;
}

void ntpio__output_abort(ntpio__output *output)
{
    os_output_free(output->file);
    free(output->read_path);
    free(output->name);
    free(output->buffer);
    free(output);
}
