/* SPDX-License-Identifier: MIT */
/*
 * output.c - a temporary file beside the target, and how it takes the target's name
 *
 * The file is marked to vanish when its last handle is closed, until it takes its name: so nothing
 * is left behind, however the program dies.  Where a file system knows no such mark, the next writer
 * of the target removes what nobody has open.
 */
#include "os/output.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

#include "os/slots.h"
#include "os/windows/state.h"
#include "os/windows/wide.h"

/* Of the newer kind of renaming, which also replaces files that others read. */
enum { RENAME_INFO_EX = 22, REPLACE = 1, POSIX_SEMANTICS = 2 };

struct os_output {
    HANDLE file;
    bool direct;   /* a device, a pipe, standard output */
    bool is_input; /* the target is what the output is made of */
    os_file made_of;
    char *target;  /* NULL: direct */
    wchar_t *temp; /* NULL while there is none */
};

static bool fail_with(os_problem *problem, const char *what, int error)
{
    *problem = (os_problem) { .error = error };
    strcpy(problem->what, what);
    return false;
}

static bool fail(os_problem *problem, const char *what)
{
    os__failed();
    return fail_with(problem, what, errno);
}

static bool fail_memory(os_problem *problem)
{
    *problem = (os_problem) { .error = ENOMEM };
    return false;
}

/* ------------------------------------------------------------------------ temporary files */

/* The path of a slot beside the target. */
static wchar_t *slot_path(const char *target, unsigned slot)
{
    const char *slash = strrchr(target, '/');
    const char *base = slash != NULL ? slash + 1 : os_after_drive(target);
    char *name = os__slot_name(base, OS__SLOT_NAME_LIMIT, slot);
    const size_t head = (size_t) (base - target);
    char *path = name != NULL ? malloc(head + strlen(name) + 1) : NULL;
    wchar_t *wide = NULL;
    if (path != NULL) {
        memcpy(path, target, head);
        strcpy(path + head, name);
        wide = os__wide_path(path);
    }
    free(path);
    free(name);
    return wide;
}

/* A writer lets nobody else open its file, so what can be opened is left over. */
static void remove_all_stale(const char *target)
{
    for (unsigned slot = 1; slot <= OS__SLOTS; slot++) {
        wchar_t *path = slot_path(target, slot);
        const DWORD flags = FILE_FLAG_DELETE_ON_CLOSE | FILE_FLAG_OPEN_REPARSE_POINT;
        const HANDLE stale = path != NULL && GetFileAttributesW(path) != INVALID_FILE_ATTRIBUTES
                                 ? CreateFileW(path, DELETE, 0, NULL, OPEN_EXISTING, flags, NULL)
                                 : INVALID_HANDLE_VALUE;
        if (stale != INVALID_HANDLE_VALUE)
            CloseHandle(stale);
        free(path);
    }
}

static bool vanish_on_close(HANDLE file, bool vanish)
{
    FILE_DISPOSITION_INFO info = { .DeleteFile = vanish };
    return SetFileInformationByHandle(file, FileDispositionInfo, &info, sizeof info);
}

static bool open_temporary(os_output *output, os_problem *problem)
{
    for (unsigned slot = 1; slot <= OS__SLOTS; slot++) {
        wchar_t *path = slot_path(output->target, slot);
        if (path == NULL)
            return fail_memory(problem);
        output->file = CreateFileW(path, GENERIC_READ | GENERIC_WRITE | DELETE, 0, NULL, CREATE_NEW,
                                   FILE_ATTRIBUTE_NORMAL, NULL);
        if (output->file != INVALID_HANDLE_VALUE) {
            output->temp = path;
            vanish_on_close(output->file, true);
            return true;
        }
        const DWORD error = GetLastError();
        free(path);
        SetLastError(error);
        if (error != ERROR_FILE_EXISTS && error != ERROR_SHARING_VIOLATION &&
            !(error == ERROR_ACCESS_DENIED && slot < 2)) /* one that vanishes this moment */
            break;
    }
    return fail(problem, "cannot be written");
}

/* ------------------------------------------------------------------------ what is kept */

/* Access rights; false where they cannot be given to the new file. */
static bool keep_rights(const wchar_t *old, const wchar_t *temp)
{
    DWORD size = 0;
    GetFileSecurityW(old, DACL_SECURITY_INFORMATION, NULL, 0, &size);
    void *rights = size > 0 ? malloc(size) : NULL;
    SECURITY_DESCRIPTOR_CONTROL control;
    DWORD revision, what = DACL_SECURITY_INFORMATION;
    bool ok = true; /* a file system without rights has none to keep */
    if (rights != NULL && GetFileSecurityW(old, DACL_SECURITY_INFORMATION, rights, size, &size) &&
        GetSecurityDescriptorControl(rights, &control, &revision)) {
        if ((control & SE_DACL_PROTECTED) != 0)
            what |= PROTECTED_DACL_SECURITY_INFORMATION;
        ok = SetFileSecurityW(temp, what, rights);
    }
    free(rights);
    return ok;
}

static bool keep_attributes(const char *path, const wchar_t *temp, os_problem *problem)
{
    const DWORD kept = FILE_ATTRIBUTE_HIDDEN | FILE_ATTRIBUTE_SYSTEM | FILE_ATTRIBUTE_ARCHIVE |
                       FILE_ATTRIBUTE_NOT_CONTENT_INDEXED;
    wchar_t *old = os__wide_path(path);
    if (old == NULL)
        return fail_memory(problem);
    const DWORD attributes = GetFileAttributesW(old);
    bool ok = keep_rights(old, temp);
    if (!ok)
        fail(problem, "cannot be replaced: permissions cannot be kept");
    else if (attributes != INVALID_FILE_ATTRIBUTES && (attributes & kept) != 0)
        SetFileAttributesW(temp, attributes & kept);
    free(old);
    return ok;
}

/* ------------------------------------------------------------------------ opening */

/* What a link leads to, or the path itself. */
static char *resolve(const char *path)
{
    wchar_t *wide = os__wide_path(path);
    const DWORD attributes = wide != NULL ? GetFileAttributesW(wide) : INVALID_FILE_ATTRIBUTES;
    free(wide);
    const bool link =
        attributes != INVALID_FILE_ATTRIBUTES && (attributes & FILE_ATTRIBUTE_REPARSE_POINT) != 0;
    return link ? os_real_path(path) : _strdup(path);
}

static bool can_be_replaced(const char *target, os_problem *problem)
{
    const DWORD share = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
    wchar_t *wide = os__wide_path(target);
    if (wide == NULL)
        return fail_memory(problem);
    const bool read_only = (GetFileAttributesW(wide) & FILE_ATTRIBUTE_READONLY) != 0;
    const HANDLE probe =
        CreateFileW(wide, GENERIC_WRITE | DELETE, share, NULL, OPEN_EXISTING, 0, NULL);
    const DWORD error = probe == INVALID_HANDLE_VALUE ? GetLastError() : ERROR_ACCESS_DENIED;
    free(wide);
    if (probe != INVALID_HANDLE_VALUE)
        CloseHandle(probe);
    if (probe != INVALID_HANDLE_VALUE && !read_only)
        return true;
    os__failed_with(error);
    return fail_with(problem,
                     error == ERROR_SHARING_VIOLATION
                         ? "cannot be replaced: another program has it open"
                         : "cannot be replaced",
                     errno);
}

static bool open_replacement(os_output *output, const os_file *old, os_problem *problem)
{
    const bool exists = old != NULL;
    if (exists && !can_be_replaced(output->target, problem))
        return false;
    output->is_input = exists && output->is_input && old->device == output->made_of.device &&
                       old->node == output->made_of.node;
    remove_all_stale(output->target);
    return open_temporary(output, problem) &&
           (!exists || keep_attributes(output->target, output->temp, problem));
}

static bool open_direct(os_output *output, const char *path, os_problem *problem)
{
    wchar_t *wide = os__wide_path(path);
    output->direct = true;
    output->file = wide != NULL
                       ? CreateFileW(wide, GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, NULL,
                                     OPEN_EXISTING, 0, NULL)
                       : INVALID_HANDLE_VALUE;
    free(wide);
    return output->file != INVALID_HANDLE_VALUE || fail(problem, "cannot be written");
}

static bool open_target(os_output *output, const char *path, os_problem *problem)
{
    os_file old;
    output->target = resolve(path);
    if (output->target == NULL)
        return fail_with(problem, "cannot be written", errno);
    const bool exists = os_look(output->target, &old);
    if (exists && old.kind == OS_DIRECTORY)
        return fail_with(problem, "cannot be written", EISDIR);
    return exists && old.kind != OS_REGULAR
               ? open_direct(output, output->target, problem)
               : open_replacement(output, exists ? &old : NULL, problem);
}

os_output *os_output_standard(os_problem *problem)
{
    os_output *output = calloc(1, sizeof *output);
    if (output == NULL) {
        fail_memory(problem);
        return NULL;
    }
    fflush(stdout);
    output->file = GetStdHandle(STD_OUTPUT_HANDLE);
    output->direct = true;
    return output;
}

os_output *os_output_open(const char *path, const os_file *made_of, os_problem *problem)
{
    os_output *output = os_output_standard(problem);
    if (output == NULL)
        return NULL;
    output->file = INVALID_HANDLE_VALUE;
    output->direct = false;
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
    return !output->direct;
}

bool os_output_write(os_output *output, uint64_t offset, const void *bytes, size_t size,
                     os_problem *problem)
{
    const char *at = bytes;
    const size_t most = (size_t) 1 << 26;
    while (size != 0) {
        OVERLAPPED place = { .Offset = (DWORD) offset, .OffsetHigh = (DWORD) (offset >> 32) };
        DWORD done = 0;
        if (!WriteFile(output->file, at, (DWORD) (size < most ? size : most), &done,
                       output->direct ? NULL : &place))
            return fail(problem, "cannot be written");
        if (done == 0)
            return fail_with(problem, "cannot be written", ENOSPC);
        at += done;
        size -= done;
        offset += done;
    }
    return true;
}

bool os_output_sync(os_output *output, os_problem *problem)
{
    return output->direct || FlushFileBuffers(output->file) || fail(problem, "cannot be written");
}

/* Renames the open file, so that nobody gets between closing and renaming it. */
static bool rename_open(HANDLE file, const wchar_t *to, bool replace_open_files)
{
    const size_t length = wcslen(to) * sizeof *to,
                 size = offsetof(FILE_RENAME_INFO, FileName) + length;
    FILE_RENAME_INFO *info = calloc(1, size + sizeof *info);
    if (info == NULL)
        return false;
    if (replace_open_files) /* in the place of the older member */
        *(DWORD *) (void *) info = REPLACE | POSIX_SEMANTICS;
    else
        info->ReplaceIfExists = TRUE;
    info->FileNameLength = (DWORD) length;
    memcpy(info->FileName, to, length);
    const int kind = replace_open_files ? RENAME_INFO_EX : (int) FileRenameInfo;
    const bool done = SetFileInformationByHandle(file, (FILE_INFO_BY_HANDLE_CLASS) kind, info,
                                                 (DWORD) (size + sizeof *to));
    const DWORD error = GetLastError();
    free(info);
    SetLastError(error);
    return done;
}

static wchar_t *full_path(const char *path)
{
    wchar_t *wide = os__wide_path(path);
    const DWORD size = wide != NULL ? GetFullPathNameW(wide, 0, NULL, NULL) : 0;
    wchar_t *full = malloc(((size_t) size + 1) * sizeof *full);
    if (full != NULL && (size == 0 || GetFullPathNameW(wide, size + 1, full, NULL) == 0)) {
        free(full);
        full = NULL;
    }
    free(wide);
    return full;
}

static bool take_name(os_output *output, os_problem *problem)
{
    wchar_t *full = full_path(output->target);
    if (full == NULL)
        return fail_memory(problem);
    vanish_on_close(output->file, false);
    bool done = rename_open(output->file, full, true) || rename_open(output->file, full, false);
    if (!done) { /* a file system that renames by name only */
        CloseHandle(output->file);
        output->file = INVALID_HANDLE_VALUE;
        done = MoveFileExW(output->temp, full, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH);
    }
    if (!done)
        fail(problem, "cannot be put in place");
    free(full);
    return done;
}

/* Of a file that somebody saves between the comparison and the renaming, that version is lost:
 * Windows cannot exchange two names. */
bool os_output_finish(os_output *output, os_problem *problem)
{
    os_file now;
    if (output->direct)
        return true;
    if (output->is_input &&
        !(os_look(output->target, &now) && os_same_version(&now, &output->made_of))) {
        *problem = (os_problem) { .changed = true };
        return false;
    }
    if (!take_name(output, problem))
        return false;
    free(output->temp);
    output->temp = NULL;
    return true;
}

void os_output_free(os_output *output)
{
    if (output == NULL)
        return;
    if (output->file != INVALID_HANDLE_VALUE && output->file != GetStdHandle(STD_OUTPUT_HANDLE)) {
        if (output->temp != NULL)
            vanish_on_close(output->file, true);
        CloseHandle(output->file);
    }
    if (output->temp != NULL)
        DeleteFileW(output->temp);
    free(output->temp);
    free(output->target);
    free(output);
}
