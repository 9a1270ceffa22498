/* SPDX-License-Identifier: MIT */
/*
 * wide.c - between UTF-8 with slashes and what Windows takes; its errors as errno
 *
 * A path of more than 260 characters works only in its long form, \\?\C:\..., which must be
 * absolute and free of "." and "..".
 */
#include "os/windows/wide.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

enum {
    SHORT_PATH = 240, /* less than MAX_PATH by what a directory needs for a file */
    REPLACEMENT = 0xfffd
};

/* The code at *s, which moves on; bytes that are no UTF-8 become U+FFFD. */
static uint32_t next_code(const unsigned char **s)
{
    const unsigned char *u = *s;
    const int more = u[0] < 0x80 ? 0 : u[0] < 0xc2 ? -1 : u[0] < 0xe0 ? 1 : u[0] < 0xf0 ? 2 : 3;
    static const uint32_t KEEP[] = { 0x7f, 0x1f, 0x0f, 0x07 };
    *s = u + 1;
    if (more < 0 || u[0] > 0xf4)
        return REPLACEMENT;
    uint32_t code = u[0] & KEEP[more];
    for (int i = 1; i <= more; i++) {
        if ((u[i] & 0xc0) != 0x80)
            return REPLACEMENT;
        code = code << 6 | (u[i] & 0x3f);
    }
    *s = u + 1 + more;
    return code;
}

wchar_t *os__wide(const char *utf8)
{
    wchar_t *wide = malloc((strlen(utf8) + 1) * sizeof *wide); /* never more units than bytes */
    size_t n = 0;
    if (wide == NULL)
        return NULL;
    for (const unsigned char *s = (const unsigned char *) utf8; *s != 0;) {
        const uint32_t code = next_code(&s);
        if (code >= 0x10000) {
            wide[n++] = (wchar_t) (0xd800 + ((code - 0x10000) >> 10));
            wide[n++] = (wchar_t) (0xdc00 + ((code - 0x10000) & 0x3ff));
        } else {
            wide[n++] = (wchar_t) code;
        }
    }
    wide[n] = 0;
    return wide;
}

static size_t put_code(char *to, uint32_t code)
{
    if (code < 0x80) {
        to[0] = (char) code;
        return 1;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const uint32_t FIRST[] = { 0, 0xc0, 0xe0, 0xf0 };
    to[0] = (char) (FIRST[more] | code >> (6 * more));
    for (int i = 1; i <= more; i++)
        to[i] = (char) (0x80 | (code >> (6 * (more - i)) & 0x3f));
    return (size_t) more + 1;
}

char *os__narrow(const wchar_t *wide)
{
    enum { MOST = 3 }; /* bytes of a unit; two units take four */
    char *utf8 = malloc(wcslen(wide) * MOST + 1);
    size_t n = 0;
    if (utf8 == NULL)
        return NULL;
    for (size_t i = 0; wide[i] != 0; i++) {
        uint32_t code = wide[i];
        const uint32_t next = wide[i + 1];
        if (code >= 0xd800 && code < 0xdc00 && next >= 0xdc00 && next < 0xe000) {
            code = 0x10000 + ((code - 0xd800) << 10) + (next - 0xdc00);
            i++;
        }
        n += put_code(utf8 + n, code);
    }
    utf8[n] = 0;
    return utf8;
}

static bool is_drive(const wchar_t *path)
{
    return path[0] != 0 && path[1] == L':';
}

/* The long form; frees what it is given. */
static wchar_t *long_form(wchar_t *path)
{
    static const wchar_t LOCAL[] = L"\\\\?\\", SHARE[] = L"\\\\?\\UNC";
    const DWORD size = GetFullPathNameW(path, 0, NULL, NULL);
    wchar_t *full = malloc((size + 1) * sizeof *full);
    wchar_t *whole = malloc((size + sizeof SHARE) * sizeof *whole);
    const DWORD length = full != NULL ? GetFullPathNameW(path, size + 1, full, NULL) : 0;
    if (whole != NULL && length > 0 && length <= size) {
        const bool share = full[0] == L'\\' && full[1] == L'\\';
        wcscpy(whole, share ? SHARE : LOCAL);
        wcscat(whole, share ? full + 1 : full);
        free(full);
        free(path);
        return whole;
    }
    free(full);
    free(whole);
    return path;
}

wchar_t *os__wide_path(const char *path)
{
    wchar_t *wide = os__wide(path);
    if (wide == NULL)
        return NULL;
    for (wchar_t *c = wide; *c != 0; c++) {
        if (*c == L'/')
            *c = L'\\';
    }
    if (wcslen(wide) < SHORT_PATH && is_drive(wide))
        return wide;
    if (wcsncmp(wide, L"\\\\?\\", 4) == 0 || wcsncmp(wide, L"\\\\.\\", 4) == 0)
        return wide;
    if (wcslen(wide) + GetCurrentDirectoryW(0, NULL) < SHORT_PATH)
        return wide;
    return long_form(wide);
}

bool os__failed_with(unsigned long error)
{
    static const struct {
        DWORD error;
        int number;
    } TABLE[] = {
        { ERROR_FILE_NOT_FOUND, ENOENT },
        { ERROR_PATH_NOT_FOUND, ENOENT },
        { ERROR_INVALID_NAME, ENOENT },
        { ERROR_BAD_NETPATH, ENOENT },
        { ERROR_BAD_NET_NAME, ENOENT },
        { ERROR_BAD_PATHNAME, ENOENT },
        { ERROR_INVALID_DRIVE, ENOENT },
        { ERROR_CANT_RESOLVE_FILENAME, ELOOP },
        { ERROR_ACCESS_DENIED, EACCES },
        { ERROR_SHARING_VIOLATION, EACCES },
        { ERROR_LOCK_VIOLATION, EACCES },
        { ERROR_USER_MAPPED_FILE, EACCES },
        { ERROR_WRITE_PROTECT, EROFS },
        { ERROR_ALREADY_EXISTS, EEXIST },
        { ERROR_FILE_EXISTS, EEXIST },
        { ERROR_DIRECTORY, ENOTDIR },
        { ERROR_FILENAME_EXCED_RANGE, ENAMETOOLONG },
        { ERROR_DISK_FULL, ENOSPC },
        { ERROR_HANDLE_DISK_FULL, ENOSPC },
        { ERROR_TOO_MANY_OPEN_FILES, EMFILE },
        { ERROR_NOT_ENOUGH_MEMORY, ENOMEM },
        { ERROR_OUTOFMEMORY, ENOMEM },
        { ERROR_BROKEN_PIPE, EPIPE },
        { ERROR_NO_DATA, EPIPE },
        { ERROR_NOT_SUPPORTED, ENOSYS },
        { ERROR_INVALID_PARAMETER, EINVAL },
    };
    errno = EIO;
    for (size_t i = 0; i < sizeof TABLE / sizeof TABLE[0]; i++) {
        if (TABLE[i].error == error)
            errno = TABLE[i].number;
    }
    return false;
}

bool os__failed(void)
{
    return os__failed_with(GetLastError());
}
