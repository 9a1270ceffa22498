/* SPDX-License-Identifier: MIT */
/*
 * system.h - what the C tests need of the system: pages that may not be touched, aligned memory, a
 * folder of their own, pipes
 */
#ifndef TESTS_SYSTEM_H
#define TESTS_SYSTEM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#ifdef _WIN32

#  include <direct.h>
#  include <fcntl.h>
#  include <io.h>
#  include <windows.h>

/* Words of old compilers, which that header makes nothing of. */
#  undef NEAR
#  undef FAR
#  undef near
#  undef far

enum { SYSTEM_NAMES_PIPES = false };

static inline size_t system_page(void)
{
    SYSTEM_INFO info;
    GetSystemInfo(&info);
    return info.dwPageSize;
}

/* Memory that may not be touched, or NULL. */
static inline void *system_reserve(size_t size)
{
    return VirtualAlloc(NULL, size, MEM_RESERVE, PAGE_NOACCESS);
}

/* Lets some pages of it be read and written. */
static inline bool system_allow(void *pages, size_t size)
{
    return VirtualAlloc(pages, size, MEM_COMMIT, PAGE_READWRITE) != NULL;
}

static inline void system_release(void *memory, size_t size)
{
    (void) size;
    VirtualFree(memory, 0, MEM_RELEASE);
}

static inline void *system_aligned(size_t size)
{
    return _aligned_malloc(size, 64);
}

static inline void system_aligned_free(void *memory)
{
    _aligned_free(memory);
}

/* Makes a new folder and goes there; leaves it, and removes it if it is empty. */
static char system_folder[MAX_PATH + 40];

static inline bool system_enter_folder(void)
{
    const DWORD length = GetTempPathA(MAX_PATH, system_folder);
    sprintf(system_folder + length, "ntpio-test-%lu", (unsigned long) GetCurrentProcessId());
    return length > 0 && _mkdir(system_folder) == 0 && _chdir(system_folder) == 0;
}

static inline bool system_leave_folder(void)
{
    return _chdir("..") == 0 && _rmdir(system_folder) == 0;
}

static inline bool system_pipe(int ends[2])
{
    return _pipe(ends, 1 << 16, _O_BINARY) == 0;
}

static inline bool system_binary_input(void)
{
    return _setmode(_fileno(stdin), _O_BINARY) != -1;
}

static inline bool system_make_pipe(const char *name)
{
    (void) name;
    return false;
}

#else

#  include <sys/mman.h>
#  include <sys/stat.h>

enum { SYSTEM_NAMES_PIPES = true }; /* /dev/fd/N, and those that system_make_pipe makes */

static inline size_t system_page(void)
{
    return (size_t) sysconf(_SC_PAGESIZE);
}

/* Memory that may not be touched, or NULL. */
static inline void *system_reserve(size_t size)
{
    void *memory = mmap(NULL, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory != MAP_FAILED ? memory : NULL;
}

/* Lets some pages of it be read and written. */
static inline bool system_allow(void *pages, size_t size)
{
    return mprotect(pages, size, PROT_READ | PROT_WRITE) == 0;
}

static inline void system_release(void *memory, size_t size)
{
    munmap(memory, size);
}

static inline void *system_aligned(size_t size)
{
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static inline void system_aligned_free(void *memory)
{
    free(memory);
}

/* Makes a new folder and goes there; leaves it, and removes it if it is empty. */
static char system_folder[] = "/tmp/ntpio-test-XXXXXX";

static inline bool system_enter_folder(void)
{
    return mkdtemp(system_folder) != NULL && chdir(system_folder) == 0;
}

static inline bool system_leave_folder(void)
{
    return rmdir(system_folder) == 0;
}

static inline bool system_pipe(int ends[2])
{
    return pipe(ends) == 0;
}

static inline bool system_binary_input(void)
{
    return true;
}

static inline bool system_make_pipe(const char *name)
{
    return mkfifo(name, 0600) == 0;
}

#endif

#endif
