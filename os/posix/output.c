/* SPDX-License-Identifier: MIT */
/*
 * output.c - an unnamed or temporary file beside the target, and how it takes the target's name
 *
 * An unnamed file (O_TMPFILE) leaves nothing behind, however the program dies.  Some file systems
 * have none, and an unnamed file needs a name for a moment before it replaces the target.  That
 * name is ".NAME.ntp-00000N.tmp", and the writer locks the file: whoever gets the lock knows that
 * the writer is gone, and removes the file.  Names are numbered and not random, so stale files are
 * found without reading directories.
 */
#include "os/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/posix/attributes.h"
#include "os/posix/state.h"
#include "os/slots.h"

#ifndef O_CLOEXEC
#  define O_CLOEXEC 0
#endif

enum {
    SLOTS = 16,       /* writers of one target at the same time */
    SLOT_SUFFIX = 15, /* .ntp-00000N.tmp */
    HASH_SIZE = 9,    /* ~ and 8 hex digits */
    NAME_LIMIT = 255, /* if the file system does not say */
    NAME_FITS = 128,  /* no file system in use allows less */
    LINKS_MAX = 40,   /* symbolic links in a row, as in the kernel */
    PROC_SIZE = 40,
    AT_ONCE = 8 << 20,  /* bytes that the system is told to write, while others are made */
    NEW_MODE = 0666,    /* less the umask */
    PRIVATE_MODE = 0600 /* until it gets that of the file that it replaces */
};

struct os_output {
    int fd, directory; /* directory: -1 when nothing is to be renamed */
    bool unnamed;      /* of O_TMPFILE */
    bool is_input;     /* the target is what the output is made of */
    uint64_t begun;    /* bytes that the system was told to write */
    os_file made_of;
    char *target; /* within directory */
    char *temp;   /* within directory, NULL while there is none */
};

static bool fail(os_problem *problem, const char *what, int error)
{
    *problem = (os_problem) { .error = error };
    snprintf(problem->what, sizeof problem->what, "%s", what);
    return false;
}

static bool fail_memory(os_problem *problem)
{
    *problem = (os_problem) { .error = ENOMEM };
    return false;
}

static bool fail_as_changed(os_problem *problem)
{
    *problem = (os_problem) { .changed = true };
    return false;
}

/* ------------------------------------------------------------------------ names */

static char *slot_name(const os_output *output, unsigned slot)
{
    long limit = OS__SLOT_NAME_LIMIT;
    if (strlen(output->target) + 1 + OS__SLOT_SUFFIX > NAME_FITS && output->directory >= 0)
        limit = fpathconf(output->directory, _PC_NAME_MAX);
    return os__slot_name(output->target, limit, slot);
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
    char *at = strdup(path);
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
static void remove_stale(const os_output *output, const char *temp)
{
    struct stat by_fd, by_name;
    if (fstatat(output->directory, temp, &by_name, AT_SYMLINK_NOFOLLOW) != 0)
        return; /* nearly always, and told in half the time of opening */
    const int fd = openat(output->directory, temp, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0 && fstat(fd, &by_fd) == 0 && S_ISREG(by_fd.st_mode) &&
        fstatat(output->directory, temp, &by_name, AT_SYMLINK_NOFOLLOW) == 0 &&
        by_fd.st_ino == by_name.st_ino && by_fd.st_dev == by_name.st_dev)
        unlinkat(output->directory, temp, 0);
    close(fd);
}

static void remove_all_stale(const os_output *output)
{
    for (unsigned slot = 1; slot <= OS__SLOTS; slot++) {
        char *temp = slot_name(output, slot);
        if (temp != NULL)
            remove_stale(output, temp);
        free(temp);
    }
}

#ifdef O_TMPFILE
/* Gives an unnamed file a name.  Who may not do that by its descriptor alone does it through /proc, which
 * has to be there and takes longer. */
static bool link_to(const os_output *output, const char *name)
{
    char proc[PROC_SIZE];
    if (linkat(output->fd, "", output->directory, name, AT_EMPTY_PATH) == 0)
        return true;
    if (errno == EEXIST)
        return false;
    snprintf(proc, sizeof proc, "/proc/self/fd/%d", output->fd);
    return linkat(AT_FDCWD, proc, output->directory, name, AT_SYMLINK_FOLLOW) == 0;
}

static bool open_unnamed(os_output *output, mode_t mode)
{
    output->fd = openat(output->directory, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, mode);
    if (output->fd < 0)
        return false;
    /* Can it get a name?  "." is in use, and that is the last that is found out about it. */
    if (!link_to(output, ".") && errno == EEXIST) {
        flock(output->fd, LOCK_EX | LOCK_NB);
        output->unnamed = true;
        return true;
    }
    close(output->fd);
    output->fd = -1;
    return false;
}
#else
static bool link_to(const os_output *output, const char *name)
{
    (void) output, (void) name;
    return false;
}

static bool open_unnamed(os_output *output, mode_t mode)
{
    (void) output, (void) mode;
    return false;
}
#endif

/* Takes a free slot.  Another writer may remove the file before it is locked, so its links are
 * counted. */
static bool open_named(os_output *output, mode_t mode, os_problem *problem)
{
    int error = EEXIST;
    for (unsigned slot = 1; slot <= OS__SLOTS && error == EEXIST; slot++) {
        struct stat st;
        char *temp = slot_name(output, slot);
        if (temp == NULL)
            return fail_memory(problem);
        const int fd = openat(output->directory, temp,
                              O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        error = fd < 0 ? errno : EEXIST;
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
    return fail(problem, "cannot be written", error);
}

/* Gives an unnamed file the name of the target or, if the target exists, that of a slot. */
static bool link_unnamed(os_output *output, os_problem *problem)
{
    if (link_to(output, output->target))
        return true;
    for (unsigned slot = 1; slot <= OS__SLOTS && errno == EEXIST; slot++) {
        char *temp = slot_name(output, slot);
        if (temp == NULL)
            return fail_memory(problem);
        if (link_to(output, temp)) {
            output->temp = temp;
            return true;
        }
        const int error = errno;
        free(temp);
        errno = error;
    }
    return fail(problem, "cannot be put in place", errno);
}

/* ------------------------------------------------------------------------ opening */

static bool open_directory(os_output *output, const char *path, os_problem *problem)
{
    const char *slash = strrchr(path, '/');
    const char *base = slash != NULL ? slash + 1 : path;
    char *directory = slash == NULL   ? strdup(".")
                      : slash == path ? strdup("/")
                                      : strndup(path, (size_t) (slash - path));
    output->target = strdup(base);
    if (directory == NULL || output->target == NULL) {
        free(directory);
        return fail_memory(problem);
    }
    output->directory = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
#ifdef O_PATH
    if (output->directory < 0 && errno == EACCES) /* may be searched and written, not listed */
        output->directory = open(directory, O_PATH | O_DIRECTORY | O_CLOEXEC);
#endif
    free(directory);
    return output->directory >= 0 || fail(problem, "cannot be written", errno);
}

static bool open_replacement(os_output *output, const char *path, const struct stat *old,
                             os_problem *problem)
{
    if (!open_directory(output, path, problem))
        return false;
    if (output->target[0] == 0)
        return fail(problem, "cannot be written", EISDIR);
    if (old != NULL && faccessat(output->directory, output->target, W_OK, AT_EACCESS) != 0)
        return fail(problem, "cannot be replaced", errno);
    remove_all_stale(output);
    output->is_input = output->is_input && old != NULL &&
                       (uint64_t) old->st_dev == output->made_of.device &&
                       (uint64_t) old->st_ino == output->made_of.node;
    const mode_t mode = old == NULL ? NEW_MODE : PRIVATE_MODE;
    if (!open_unnamed(output, mode) && !open_named(output, mode, problem))
        return false;
    return old == NULL || os__keep_attributes(output->fd, path, old, problem);
}

static bool open_target(os_output *output, const char *path, os_problem *problem)
{
    struct stat st;
    char *resolved = resolve(path);
    if (resolved == NULL)
        return fail(problem, "cannot be written", errno);
    const bool exists = lstat(resolved, &st) == 0;
    bool done;
    if (exists && S_ISDIR(st.st_mode)) {
        done = fail(problem, "cannot be written", EISDIR);
    } else if (exists && !S_ISREG(st.st_mode)) { /* a device or a pipe cannot be replaced */
        output->fd = open(resolved, O_WRONLY | O_CLOEXEC);
        done = output->fd >= 0 || fail(problem, "cannot be written", errno);
    } else {
        done = open_replacement(output, resolved, exists ? &st : NULL, problem);
    }
    free(resolved);
    return done;
}

os_output *os_output_standard(os_problem *problem)
{
    os_output *output = calloc(1, sizeof *output);
    if (output == NULL) {
        fail_memory(problem);
        return NULL;
    }
    fflush(stdout);
    output->fd = STDOUT_FILENO;
    output->directory = -1;
    return output;
}

os_output *os_output_open(const char *path, const os_file *made_of, os_problem *problem)
{
    os_output *output = os_output_standard(problem);
    if (output == NULL)
        return NULL;
    output->fd = -1;
    if (made_of != NULL) {
        output->is_input = true;
        output->made_of = *made_of;
    }
    if (open_target(output, path, problem))
        return output;
    os_output_free(output);
    return NULL;
}

/* ------------------------------------------------------------------------ writing */

bool os_output_can_seek(const os_output *output)
{
    return output->directory >= 0;
}

/* The system keeps written bytes in memory.  Told early, it writes them to the disk while others are made,
 * and os_output_sync() waits for less.  That one also says whether it worked. */
static void begin_to_write(os_output *output, uint64_t end)
{
#ifdef SYNC_FILE_RANGE_WRITE
    if (!os_output_can_seek(output) || end < output->begun + AT_ONCE)
        return;
    const off_t from = (off_t) output->begun, size = (off_t) (end - output->begun);
    if (sync_file_range(output->fd, from, size, SYNC_FILE_RANGE_WRITE) == 0)
        output->begun = end;
#else
    (void) output, (void) end;
#endif
}

bool os_output_write(os_output *output, uint64_t offset, const void *bytes, size_t size,
                     os_problem *problem)
{
    const char *at = bytes;
    while (size != 0) {
        const ssize_t n = os_output_can_seek(output) ? pwrite(output->fd, at, size, (off_t) offset)
                                                     : write(output->fd, at, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return fail(problem, "cannot be written", n < 0 ? errno : ENOSPC);
        at += n;
        size -= (size_t) n;
        offset += (uint64_t) n;
    }
    begin_to_write(output, offset);
    return true;
}

static bool sync_file(int fd)
{
#ifdef F_FULLFSYNC
    if (fcntl(fd, F_FULLFSYNC) == 0)
        return true;
#endif
    return fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS;
}

bool os_output_sync(os_output *output, os_problem *problem)
{
    return output->directory < 0 || sync_file(output->fd) ||
           fail(problem, "cannot be written", errno);
}

static bool has_version(int directory, const char *name, const os_file *version)
{
    struct stat st;
    if (fstatat(directory, name, &st, 0) != 0)
        return false;
    const os_file now = os__file_of(&st);
    return os_same_version(&now, version);
}

#ifdef OS_HAVE_RENAMEAT2
static bool exchange(const os_output *output)
{
    const int in = output->directory;
    return renameat2(in, output->temp, in, output->target, RENAME_EXCHANGE) == 0;
}

/* The temporary name has a version that somebody saved: it takes the target's name again.  If he saved
 * once more meanwhile, the newest stays there. */
static void give_back(os_output *output)
{
    struct stat st;
    const bool known = fstat(output->fd, &st) == 0;
    const os_file own = known ? os__file_of(&st) : (os_file) { 0 };
    bool back = exchange(output);
    if (back && !has_version(output->directory, output->temp, &own))
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
static bool take_name(os_output *output, os_problem *problem)
{
    const int in = output->directory;
#ifdef OS_HAVE_RENAMEAT2
    if (output->is_input && exchange(output)) {
        if (!has_version(in, output->temp, &output->made_of)) {
            give_back(output);
            return fail_as_changed(problem);
        }
        unlinkat(in, output->temp, 0);
        return true;
    }
    if (output->is_input && errno == ENOENT)
        return fail_as_changed(problem);
#endif
    return renameat(in, output->temp, in, output->target) == 0 ||
           fail(problem, "cannot be put in place", errno);
}

static bool put_in_place(os_output *output, os_problem *problem)
{
    if (output->unnamed && !link_unnamed(output, problem))
        return false;
    if (output->temp != NULL) {
        if (!take_name(output, problem))
            return false;
        free(output->temp);
        output->temp = NULL;
    }
    if (fsync(output->directory) != 0 && errno == EIO)
        return fail(problem, "cannot be put in place", errno);
    return true;
}

bool os_output_finish(os_output *output, os_problem *problem)
{
    if (output->directory >= 0)
        return put_in_place(output, problem);
    const int fd = output->fd;
    output->fd = -1;
    return fd == STDOUT_FILENO || close(fd) == 0 || fail(problem, "cannot be written", errno);
}

void os_output_free(os_output *output)
{
    if (output == NULL)
        return;
    if (output->temp != NULL)
        unlinkat(output->directory, output->temp, 0);
    if (output->fd >= 0 && output->fd != STDOUT_FILENO)
        close(output->fd);
    if (output->directory >= 0)
        close(output->directory);
    free(output->temp);
    free(output->target);
    free(output);
}
