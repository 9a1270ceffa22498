/* SPDX-License-Identifier: MIT */
/*
 * output.c - writes a file beside its target and puts it in place at the end
 *
 * An unnamed file (O_TMPFILE) leaves nothing behind, however the program dies.  Some file systems
 * have none, and an unnamed file needs a name for a moment before it replaces the target.  That
 * name is ".NAME.ntp-00000N.tmp", and the writer locks the file: whoever gets the lock knows that
 * the writer is gone, and removes the file.  Names are numbered and not random, so stale files are
 * found without reading directories.
 */
#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "attributes.h"
#include "message.h"
#include "stamp.h"

#ifndef O_CLOEXEC
#  define O_CLOEXEC 0
#endif

enum {
    BUFFER_SIZE = 1 << 18, /* few system calls */
    SLOTS = 16,            /* writers of one target at the same time */
    SLOT_SUFFIX = 15,      /* .ntp-00000N.tmp */
    HASH_SIZE = 9,         /* ~ and 8 hex digits */
    NAME_LIMIT = 255,      /* if the file system does not say */
    NAME_FITS = 128,       /* no file system in use allows less */
    LINKS_MAX = 40,        /* symbolic links in a row, as in the kernel */
    PROC_SIZE = 40,
    NEW_MODE = 0666,    /* less the umask */
    PRIVATE_MODE = 0600 /* until it gets that of the file that it replaces */
};

struct ntpio__output {
    int fd, directory; /* directory: -1 when nothing is to be renamed */
    bool unnamed;      /* of O_TMPFILE */
    bool can_seek;
    bool is_input;   /* the target is the file of read_path */
    char *name;      /* for messages */
    char *target;    /* within directory */
    char *temp;      /* within directory, NULL while there is none */
    char *read_path; /* see ntpio_write_options */
    ntpio_stamp read_stamp;
    uint8_t *buffer;
    size_t used;
    uint64_t offset; /* of the buffer in the file */
};

static bool fail(const ntpio__output *output, const char *what, int problem, ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_WRITE, output->name, "%s: %s", what, strerror(problem));
}

/* ------------------------------------------------------------------------ names */

static uint32_t fnv1a(const char *s)
{
    uint32_t hash = 2166136261u;
    for (; *s != 0; s++)
        hash = (hash ^ (unsigned char) *s) * 16777619u;
    return hash;
}

/* If a name is too long for the suffix, a hash of the whole replaces its end. */
static char *slot_name(const ntpio__output *output, unsigned slot)
{
    const size_t length = strlen(output->target);
    long limit = NAME_LIMIT;
    if (length + 1 + SLOT_SUFFIX > NAME_FITS && output->directory >= 0)
        limit = fpathconf(output->directory, _PC_NAME_MAX);
    if (limit < SLOT_SUFFIX + HASH_SIZE + 2)
        limit = NAME_LIMIT;
    const size_t size = length + HASH_SIZE + SLOT_SUFFIX + 2;
    char *name = malloc(size);
    if (name == NULL)
        return NULL;
    if (length + 1 + SLOT_SUFFIX <= (size_t) limit) {
        snprintf(name, size, ".%s.ntp-%06u.tmp", output->target, slot);
        return name;
    }
    size_t keep = (size_t) limit - 1 - SLOT_SUFFIX - HASH_SIZE;
    keep = keep < length ? keep : length;
    while (keep > 1 && ((unsigned char) output->target[keep] & 0xc0) == 0x80)
        keep--;
    snprintf(name, size, ".%.*s~%08lx.ntp-%06u.tmp", (int) keep, output->target,
             (unsigned long) fnv1a(output->target), slot);
    return name;
}

static char *read_link(const char *path)
{
    for (size_t size = 256; size < (size_t) 1 << 20; size *= 2) {
        char *link = malloc(size);
        const ssize_t n = link != NULL ? readlink(path, link, size) : -1;
        if (n >= 0 && (size_t) n < size) {
            link[n] = 0;
            return link;
        }
        free(link);
        if (n < 0)
            return NULL;
    }
    return NULL;
}

/* What the symbolic links of a path lead to, which need not exist.  NULL with errno on failure. */
static char *resolve(const char *path)
{
    char *at = ntpio__copy_string(path, strlen(path));
    struct stat st;
    for (int links = 0; at != NULL && lstat(at, &st) == 0 && S_ISLNK(st.st_mode); links++) {
        char *link = links < LINKS_MAX ? read_link(at) : NULL;
        const char *slash = strrchr(at, '/');
        if (links == LINKS_MAX)
            errno = ELOOP;
        if (link != NULL && link[0] != '/' && slash != NULL) {
            const size_t head = (size_t) (slash - at) + 1, tail = strlen(link);
            char *joined = malloc(head + tail + 1);
            if (joined != NULL) {
                memcpy(joined, at, head);
                memcpy(joined + head, link, tail + 1);
            }
            free(link);
            link = joined;
        }
        free(at);
        at = link;
    }
    return at;
}

/* ------------------------------------------------------------------------ temporary files */

/* Removes the file of a slot if its writer, which holds a lock while it runs, is gone. */
static void remove_stale(const ntpio__output *output, const char *temp)
{
    struct stat by_fd, by_name;
    const int fd = openat(output->directory, temp, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0 && fstat(fd, &by_fd) == 0 && S_ISREG(by_fd.st_mode) &&
        fstatat(output->directory, temp, &by_name, AT_SYMLINK_NOFOLLOW) == 0 &&
        by_fd.st_ino == by_name.st_ino && by_fd.st_dev == by_name.st_dev)
        unlinkat(output->directory, temp, 0);
    close(fd);
}

static void remove_all_stale(const ntpio__output *output)
{
    for (unsigned slot = 1; slot <= SLOTS; slot++) {
        char *temp = slot_name(output, slot);
        if (temp != NULL)
            remove_stale(output, temp);
        free(temp);
    }
}

static bool open_unnamed(ntpio__output *output, mode_t mode)
{
#ifdef O_TMPFILE
    char proc[PROC_SIZE];
    output->fd = openat(output->directory, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, mode);
    if (output->fd < 0)
        return false;
    snprintf(proc, sizeof proc, "/proc/self/fd/%d", output->fd);
    if (access(proc, F_OK) == 0) {
        flock(output->fd, LOCK_EX | LOCK_NB);
        output->unnamed = true;
        return true;
    }
    close(output->fd);
    output->fd = -1;
#else
    (void) output;
    (void) mode;
#endif
    return false;
}

/* Takes a free slot.  Another writer may remove the file before it is locked, so its links are
 * counted. */
static bool open_named(ntpio__output *output, mode_t mode, ntpio_error *error)
{
    int problem = EEXIST;
    for (unsigned slot = 1; slot <= SLOTS && problem == EEXIST; slot++) {
        struct stat st;
        char *temp = slot_name(output, slot);
        if (temp == NULL)
            return ntpio__fail_memory(error, output->name);
        const int fd = openat(output->directory, temp,
                              O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        problem = fd < 0 ? errno : EEXIST;
        if (fd >= 0) {
            flock(fd, LOCK_EX | LOCK_NB);
            if (fstat(fd, &st) == 0 && st.st_nlink != 0) {
                output->fd = fd;
                output->temp = temp;
                return true;
            }
            close(fd);
        }
        free(temp);
    }
    return fail(output, "cannot be written", problem, error);
}

/* Gives an unnamed file the name of the target or, if the target exists, that of a slot. */
static bool link_unnamed(ntpio__output *output, ntpio_error *error)
{
    char proc[PROC_SIZE];
    snprintf(proc, sizeof proc, "/proc/self/fd/%d", output->fd);
    if (linkat(AT_FDCWD, proc, output->directory, output->target, AT_SYMLINK_FOLLOW) == 0)
        return true;
    for (unsigned slot = 1; slot <= SLOTS && errno == EEXIST; slot++) {
        char *temp = slot_name(output, slot);
        if (temp == NULL)
            return ntpio__fail_memory(error, output->name);
        if (linkat(AT_FDCWD, proc, output->directory, temp, AT_SYMLINK_FOLLOW) == 0) {
            output->temp = temp;
            return true;
        }
        const int problem = errno;
        free(temp);
        errno = problem;
    }
    return fail(output, "cannot be put in place", errno, error);
}

/* ------------------------------------------------------------------------ opening */

static bool open_directory(ntpio__output *output, const char *path, ntpio_error *error)
{
    const char *slash = strrchr(path, '/');
    const char *base = slash != NULL ? slash + 1 : path;
    char *directory = slash == NULL   ? ntpio__copy_string(".", 1)
                      : slash == path ? ntpio__copy_string("/", 1)
                                      : ntpio__copy_string(path, (size_t) (slash - path));
    output->target = ntpio__copy_string(base, strlen(base));
    if (directory == NULL || output->target == NULL) {
        free(directory);
        return ntpio__fail_memory(error, output->name);
    }
    output->directory = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
#ifdef O_PATH
    if (output->directory < 0 && errno == EACCES) /* may be searched and written, not listed */
        output->directory = open(directory, O_PATH | O_DIRECTORY | O_CLOEXEC);
#endif
    free(directory);
    return output->directory >= 0 || fail(output, "cannot be written", errno, error);
}

static bool fail_as_changed(const ntpio__output *output, ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_WRITE, output->read_path, "%s",
                       "changed meanwhile; the result of its older version is not written");
}

static bool input_is_current(ntpio__output *output, ntpio_error *error)
{
    return output->read_path == NULL || ntpio_is_current(output->read_path, &output->read_stamp) ||
           fail_as_changed(output, error);
}

/* After a failure: that the input changed is the reason, where it did. */
static bool fail_if_current(ntpio__output *output, ntpio_error *error)
{
    input_is_current(output, error);
    return false;
}

static bool open_replacement(ntpio__output *output, const char *path, const struct stat *old,
                             ntpio_error *error)
{
    if (!open_directory(output, path, error))
        return false;
    if (output->target[0] == 0)
        return fail(output, "cannot be written", EISDIR, error);
    if (old != NULL && faccessat(output->directory, output->target, W_OK, AT_EACCESS) != 0) {
        fail(output, "cannot be replaced", errno, error);
        return fail_if_current(output, error);
    }
    remove_all_stale(output);
    output->can_seek = true;
    output->is_input = old != NULL && output->read_stamp.known &&
                       (uint64_t) old->st_dev == output->read_stamp.device &&
                       (uint64_t) old->st_ino == output->read_stamp.node;
    const mode_t mode = old == NULL ? NEW_MODE : PRIVATE_MODE;
    if (!open_unnamed(output, mode) && !open_named(output, mode, error))
        return false;
    return old == NULL || ntpio__keep_attributes(output->fd, path, old, output->name, error) ||
           fail_if_current(output, error);
}

static bool open_target(ntpio__output *output, const char *path, ntpio_error *error)
{
    struct stat st;
    char *resolved = resolve(path);
    if (resolved == NULL)
        return fail(output, "cannot be written", errno, error);
    const bool exists = lstat(resolved, &st) == 0;
    bool done;
    if (exists && S_ISDIR(st.st_mode)) {
        done = fail(output, "cannot be written", EISDIR, error);
    } else if (exists && !S_ISREG(st.st_mode)) { /* a device or a pipe cannot be replaced */
        output->fd = open(resolved, O_WRONLY | O_CLOEXEC);
        done = output->fd >= 0 || fail(output, "cannot be written", errno, error);
    } else {
        done = open_replacement(output, resolved, exists ? &st : NULL, error);
    }
    free(resolved);
    return done;
}

static ntpio__output *new_output(const char *name, const ntpio_write_options *options,
                                 ntpio_error *error)
{
    const char *read_path = options->read_path;
    ntpio__output *output = calloc(1, sizeof *output);
    if (output != NULL) {
        output->fd = output->directory = -1;
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
    if (standard) {
        fflush(stdout);
        output->fd = STDOUT_FILENO;
    } else if (!open_target(output, path, error)) {
        ntpio__output_abort(output);
        return NULL;
    }
    return output;
}

/* ------------------------------------------------------------------------ writing */

static bool write_out(ntpio__output *output, const uint8_t *bytes, size_t size, ntpio_error *error)
{
    while (size != 0) {
        const ssize_t n = output->can_seek ? pwrite(output->fd, bytes, size, (off_t) output->offset)
                                           : write(output->fd, bytes, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return fail(output, "cannot be written", n < 0 ? errno : ENOSPC, error);
        bytes += n;
        size -= (size_t) n;
        output->offset += (uint64_t) n;
    }
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
    return output->can_seek;
}

bool ntpio__output_write_at(ntpio__output *output, uint64_t offset, const void *bytes, size_t size,
                            ntpio_error *error)
{
    if (!flush(output, error))
        return false;
    output->offset = offset;
    return write_out(output, bytes, size, error);
}

static bool sync_file(int fd)
{
#ifdef F_FULLFSYNC
    if (fcntl(fd, F_FULLFSYNC) == 0)
        return true;
#endif
    return fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS;
}

#ifdef NTPIO_HAVE_RENAMEAT2
static bool exchange(const ntpio__output *output)
{
    const int in = output->directory;
    return renameat2(in, output->temp, in, output->target, RENAME_EXCHANGE) == 0;
}

/* The temporary name has a version that somebody saved: it takes the target's name again.  If he saved
 * once more meanwhile, the newest stays there. */
static void give_back(ntpio__output *output)
{
    const ntpio_stamp own = ntpio__stamp_of(output->fd);
    bool back = exchange(output);
    if (back && !ntpio__has_stamp(output->directory, output->temp, &own))
        back = exchange(output);
    if (!back) { /* not removed with what is left of this output */
        free(output->temp);
        output->temp = NULL;
    }
}
#endif

/*
 * Gives the complete file the name of the target.  Between the comparison and a plain rename somebody
 * could save another version, which would be lost.  So the two files exchange their names, and the one
 * that was replaced is compared again.  Where the file system cannot do that, it is renamed.
 */
static bool take_name(ntpio__output *output, ntpio_error *error)
{
    const int in = output->directory;
#ifdef NTPIO_HAVE_RENAMEAT2
    if (output->is_input && exchange(output)) {
        if (!ntpio__has_stamp(in, output->temp, &output->read_stamp)) {
            give_back(output);
            return fail_as_changed(output, error);
        }
        unlinkat(in, output->temp, 0);
        return true;
    }
    if (output->is_input && errno == ENOENT)
        return fail_as_changed(output, error);
#endif
    return renameat(in, output->temp, in, output->target) == 0 ||
           fail(output, "cannot be put in place", errno, error);
}

static bool put_in_place(ntpio__output *output, ntpio_error *error)
{
    if (!sync_file(output->fd))
        return fail(output, "cannot be written", errno, error);
    if (!input_is_current(output, error))
        return false;
    if (output->unnamed && !link_unnamed(output, error))
        return false;
    if (output->temp != NULL) {
        if (!take_name(output, error))
            return false;
        free(output->temp);
        output->temp = NULL;
    }
    if (fsync(output->directory) != 0 && errno == EIO)
        return fail(output, "cannot be put in place", errno, error);
    return true;
}

static void destroy(ntpio__output *output)
{
    if (output->fd >= 0 && output->fd != STDOUT_FILENO)
        close(output->fd);
    if (output->directory >= 0)
        close(output->directory);
    free(output->temp);
    free(output->target);
    free(output->read_path);
    free(output->name);
    free(output->buffer);
    free(output);
}

bool ntpio__output_commit(ntpio__output *output, ntpio_error *error)
{
    if (!flush(output, error) ||
        !(output->directory >= 0 ? put_in_place : input_is_current)(output, error)) {
        ntpio__output_abort(output);
        return false;
    }
    if (output->directory < 0 && output->fd != STDOUT_FILENO) {
        const int fd = output->fd;
        output->fd = -1;
        if (close(fd) != 0) {
            fail(output, "cannot be written", errno, error);
            destroy(output);
            return false;
        }
    }
    destroy(output);
    return true;
}

void ntpio__output_abort(ntpio__output *output)
{
    if (output->temp != NULL)
        unlinkat(output->directory, output->temp, 0);
    destroy(output);
}
