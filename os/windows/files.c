/* SPDX-License-Identifier: MIT */
/*
 * files.c - what a file is, opening, reading
 *
 * Files are opened so that others may replace them meanwhile, as on other systems.
 */
#include "os/files.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

#include "os/windows/state.h"
#include "os/windows/wide.h"

enum { SHARE_ALL = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE };

static uint64_t joined(DWORD high, DWORD low)
{
    return (uint64_t) high << 32 | low;
}

bool os__look_at_handle(void *handle, os_file *file)
{
    const uint64_t second = 10000000, to_1970 = 11644473600; /* of 100 ns; seconds since 1601 */
    BY_HANDLE_FILE_INFORMATION info;
    const DWORD type = GetFileType(handle);
    *file = (os_file) { .kind = type == FILE_TYPE_CHAR ? OS_DEVICE : OS_OTHER };
    if (type != FILE_TYPE_DISK)
        return type != FILE_TYPE_UNKNOWN || GetLastError() == NO_ERROR || os__failed();
    if (!GetFileInformationByHandle(handle, &info))
        return os__failed();
    const uint64_t changed =
        joined(info.ftLastWriteTime.dwHighDateTime, info.ftLastWriteTime.dwLowDateTime);
    const bool directory = (info.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0;
    *file = (os_file) { .kind = directory ? OS_DIRECTORY : OS_REGULAR,
                        .device = info.dwVolumeSerialNumber,
                        .node = joined(info.nFileIndexHigh, info.nFileIndexLow),
                        .size = joined(info.nFileSizeHigh, info.nFileSizeLow),
                        .seconds = (int64_t) (changed / second) - (int64_t) to_1970,
                        .nanoseconds = (int64_t) (changed % second) * 100 };
    return true;
}

/* INVALID_HANDLE_VALUE with errno on failure. */
static HANDLE open_path(const char *path, DWORD access)
{
    wchar_t *wide = os__wide_path(path);
    if (wide == NULL)
        return INVALID_HANDLE_VALUE;
    const HANDLE handle = CreateFileW(wide, access, SHARE_ALL, NULL, OPEN_EXISTING,
                                      access == 0 ? FILE_FLAG_BACKUP_SEMANTICS : 0, NULL);
    if (handle == INVALID_HANDLE_VALUE)
        os__failed();
    free(wide);
    return handle;
}

bool os_look(const char *path, os_file *file)
{
    const HANDLE handle = open_path(path, 0);
    if (handle == INVALID_HANDLE_VALUE)
        return false;
    const bool ok = os__look_at_handle(handle, file);
    CloseHandle(handle);
    return ok;
}

static HANDLE handle_of(FILE *stream)
{
    return (HANDLE) _get_osfhandle(_fileno(stream));
}

bool os_look_at_open(FILE *stream, os_file *file)
{
    return os__look_at_handle(handle_of(stream), file);
}

bool os_exists(const char *path)
{
    wchar_t *wide = os__wide_path(path);
    const bool found = wide != NULL && GetFileAttributesW(wide) != INVALID_FILE_ATTRIBUTES;
    free(wide);
    return found;
}

FILE *os_open_to_read(const char *path, bool no_wait)
{
    os_file file;
    const HANDLE handle = open_path(path, GENERIC_READ);
    (void) no_wait; /* nothing is waited for */
    if (handle == INVALID_HANDLE_VALUE) {
        const int error = errno;
        const bool directory = error == EACCES && os_look(path, &file) && file.kind == OS_DIRECTORY;
        errno = directory ? EISDIR : error;
        return NULL;
    }
    const int fd = _open_osfhandle((intptr_t) handle, _O_RDONLY | _O_BINARY);
    FILE *stream = fd >= 0 ? _fdopen(fd, "rb") : NULL;
    if (fd < 0)
        CloseHandle(handle);
    else if (stream == NULL)
        _close(fd);
    return stream;
}

static bool is_seekable(FILE *stream)
{
    if (GetFileType(handle_of(stream)) == FILE_TYPE_DISK)
        return true;
    errno = ESPIPE;
    return false;
}

bool os_seek(FILE *stream, int64_t offset, int from)
{
    return is_seekable(stream) && _fseeki64(stream, offset, from) == 0;
}

int64_t os_tell(FILE *stream)
{
    return is_seekable(stream) ? _ftelli64(stream) : -1;
}

ptrdiff_t os_read_line(char **line, size_t *size, int end, FILE *stream)
{
    size_t length = 0;
    for (int c = 0; c != end;) {
        if (length + 2 > *size) {
            const size_t larger = (length + 2) * 2;
            char *grown = realloc(*line, larger);
            if (grown == NULL)
                return -1;
            *line = grown;
            *size = larger;
        }
        c = getc(stream);
        if (c == EOF)
            break;
        (*line)[length++] = (char) c;
    }
    if (length == 0)
        return -1;
    (*line)[length] = 0;
    return (ptrdiff_t) length;
}

/* UTF-8 with slashes, and without the mark of the long form. */
static char *as_path(const wchar_t *wide)
{
    const bool marked = wcsncmp(wide, L"\\\\?\\", 4) == 0;
    const bool share = wcsncmp(wide, L"\\\\?\\UNC\\", 8) == 0;
    char *path = os__narrow(share ? wide + 6 : marked ? wide + 4 : wide);
    if (path == NULL)
        return NULL;
    os_take_path(path);
    if (share)
        path[0] = '/'; /* the C of UNC */
    return path;
}

char *os_real_path(const char *path)
{
    const HANDLE handle = open_path(path, 0);
    if (handle == INVALID_HANDLE_VALUE)
        return NULL;
    const DWORD size = GetFinalPathNameByHandleW(handle, NULL, 0, FILE_NAME_NORMALIZED);
    wchar_t *wide = malloc(((size_t) size + 1) * sizeof *wide);
    char *real = NULL;
    if (size > 0 && wide != NULL &&
        GetFinalPathNameByHandleW(handle, wide, size + 1, FILE_NAME_NORMALIZED) != 0)
        real = as_path(wide);
    else
        os__failed();
    free(wide);
    CloseHandle(handle);
    return real;
}

char *os_current_directory(void)
{
    const DWORD size = GetCurrentDirectoryW(0, NULL);
    wchar_t *wide = malloc(((size_t) size + 1) * sizeof *wide);
    char *path = NULL;
    if (wide != NULL && GetCurrentDirectoryW(size + 1, wide) != 0)
        path = as_path(wide);
    free(wide);
    return path;
}

bool os_make_directory(const char *path)
{
    wchar_t *wide = os__wide_path(path);
    if (wide == NULL)
        return false;
    const bool made = CreateDirectoryW(wide, NULL);
    if (!made)
        os__failed();
    free(wide);
    return made;
}
