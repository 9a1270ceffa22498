/* SPDX-License-Identifier: MIT */
/*
 * attributes.c - what a file keeps when another takes its place: owner, permissions, attributes
 *
 * An access control list is an extended attribute.  Where a file has one, its group bits are the
 * list's mask: they must not become the bits of the group.  And a new file may have a list of its
 * own, inherited from the directory, which must not let in anybody that the old file kept out.  So
 * the new file starts with mode 0600, and gets its list, or else its mode, last.
 */
#include "os/posix/attributes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifdef __linux__
#  include <sys/xattr.h>
#endif

enum { ALL_BITS = 0777, OTHER_BITS = 07, GROUP_SHIFT = 3 };

typedef struct keeper {
    int fd;
    const char *path;
    os_problem *problem;
} keeper;

static bool fail(const keeper *k, const char *what, int error)
{
    *k->problem = (os_problem) { .error = error };
    snprintf(k->problem->what, sizeof k->problem->what, "cannot be replaced: %s cannot be kept",
             what);
    return false;
}

#ifdef __linux__

static const char ACCESS_LIST[] = "system.posix_acl_access";

typedef struct value {
    char *bytes;
    size_t size;
} value;

/* Reads an attribute, or with a NULL name the list of names, of the old file or, with a NULL path,
 * of the new one.  Returns false with errno. */
static bool read_value(value *v, const char *path, int fd, const char *name)
{
    *v = (value) { 0 };
    for (;;) {
        const ssize_t size = name == NULL   ? llistxattr(path, v->bytes, v->size)
                             : path == NULL ? fgetxattr(fd, name, v->bytes, v->size)
                                            : lgetxattr(path, name, v->bytes, v->size);
        if (size < 0 && errno != ERANGE)
            break;
        if (size >= 0 && v->bytes != NULL) {
            v->size = (size_t) size;
            return true;
        }
        free(v->bytes);
        v->size = size < 0 ? 0 : (size_t) size + 1; /* of nothing as well: NULL asks for the size */
        v->bytes = size < 0 ? NULL : malloc(v->size);
        if (size >= 0 && v->bytes == NULL)
            break;
    }
    free(v->bytes);
    v->bytes = NULL;
    return false;
}

/* Is it there already, as labels that the system gives are? */
static bool is_kept(const keeper *k, const char *name, const value *old)
{
    value new;
    if (!read_value(&new, NULL, k->fd, name))
        return false;
    const bool same =
        new.size == old->size && (old->size == 0 || memcmp(new.bytes, old->bytes, old->size) == 0);
    free(new.bytes);
    return same;
}

/* Does an attribute speak about the bytes of the file, which are other ones now? */
static bool is_of_content(const char *name)
{
    return strcmp(name, "security.capability") == 0 || strcmp(name, "security.ima") == 0 ||
           strcmp(name, "security.evm") == 0;
}

/* Labels of the system (security.*) are kept where its policy allows it. */
static bool keep_one(const keeper *k, const char *name)
{
    value old;
    if (is_of_content(name))
        return true;
    const bool is_label = strncmp(name, "security.", strlen("security.")) == 0;
    if (!read_value(&old, k->path, -1, name))
        return is_label || errno == ENODATA || fail(k, name, errno);
    const bool kept = is_kept(k, name, &old) || fsetxattr(k->fd, name, old.bytes, old.size, 0) == 0;
    const int problem = errno;
    free(old.bytes);
    return kept || is_label || fail(k, name, problem);
}

/* All but the access control list, and whether there is one. */
static bool keep_others(const keeper *k, bool *has_list)
{
    value names;
    *has_list = false;
    if (!read_value(&names, k->path, -1, NULL))
        return errno == ENOTSUP || errno == ENOSYS || fail(k, "extended attributes", errno);
    bool ok = true;
    for (size_t at = 0; ok && at < names.size; at += strlen(names.bytes + at) + 1) {
        const char *name = names.bytes + at;
        if (strcmp(name, ACCESS_LIST) == 0)
            *has_list = true;
        else
            ok = keep_one(k, name);
    }
    free(names.bytes);
    return ok;
}

static bool keep_list(const keeper *k)
{
    return keep_one(k, ACCESS_LIST);
}

/* Removes a list that the directory gave to the new file. */
static bool drop_list(const keeper *k)
{
    return fremovexattr(k->fd, ACCESS_LIST) == 0 || errno == ENODATA || errno == ENOTSUP ||
           errno == ENOSYS || fail(k, "permissions", errno);
}

#else

static bool keep_others(const keeper *k, bool *has_list)
{
    (void) k;
    *has_list = false;
    return true;
}

static bool keep_list(const keeper *k)
{
    (void) k;
    return true;
}

static bool drop_list(const keeper *k)
{
    (void) k;
    return true;
}

#endif

/* Owner and group where that is allowed: only root may give files away.  Returns whether the group
 * is the old one. */
static bool keep_owner(const keeper *k, const struct stat *old)
{
    struct stat own;
    if (fstat(k->fd, &own) != 0)
        return false;
    if (own.st_uid == old->st_uid && own.st_gid == old->st_gid)
        return true;
    return fchown(k->fd, old->st_uid, old->st_gid) == 0 || own.st_gid == old->st_gid ||
           fchown(k->fd, (uid_t) -1, old->st_gid) == 0;
}

/* Another group gets no more than everybody has. */
static mode_t mode_for(const struct stat *old, bool group_kept)
{
    const mode_t all = old->st_mode & ALL_BITS, other = old->st_mode & OTHER_BITS;
    return group_kept ? all : (all & ~(mode_t) (OTHER_BITS << GROUP_SHIFT)) | other << GROUP_SHIFT;
}

bool os__keep_attributes(int fd, const char *path, const struct stat *old, os_problem *problem)
{
    const keeper k = { fd, path, problem };
    const bool group_kept = keep_owner(&k, old);
    bool has_list;
    if (!keep_others(&k, &has_list))
        return false;
    if (has_list)
        return group_kept ? keep_list(&k) : fail(&k, "the group of its access control list", EPERM);
    return drop_list(&k) &&
           (fchmod(fd, mode_for(old, group_kept)) == 0 || fail(&k, "permissions", errno));
}
