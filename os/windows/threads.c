/* SPDX-License-Identifier: MIT */
/*
 * threads.c - threads, locks, time
 */
#include "os/threads.h"

#include <errno.h>
#include <process.h>
#include <stdlib.h>
#include <windows.h>

_Static_assert(sizeof(os_lock) == sizeof(SRWLOCK), "");
_Static_assert(sizeof(os_condition) == sizeof(CONDITION_VARIABLE), "");
_Static_assert(sizeof(os_once) == sizeof(INIT_ONCE), "");

static SRWLOCK *lock_of(os_lock *lock)
{
    return (SRWLOCK *) (void *) lock;
}

static CONDITION_VARIABLE *variable_of(os_condition *condition)
{
    return (CONDITION_VARIABLE *) (void *) condition;
}

void os_lock_init(os_lock *lock)
{
    InitializeSRWLock(lock_of(lock));
}

void os_lock_destroy(os_lock *lock)
{
    (void) lock;
}

void os_lock_take(os_lock *lock)
{
    AcquireSRWLockExclusive(lock_of(lock));
}

void os_lock_release(os_lock *lock)
{
    ReleaseSRWLockExclusive(lock_of(lock));
}

void os_condition_init(os_condition *condition)
{
    InitializeConditionVariable(variable_of(condition));
}

void os_condition_destroy(os_condition *condition)
{
    (void) condition;
}

void os_condition_wait(os_condition *condition, os_lock *lock)
{
    SleepConditionVariableSRW(variable_of(condition), lock_of(lock), INFINITE, 0);
}

void os_condition_wait_ms(os_condition *condition, os_lock *lock, int milliseconds)
{
    SleepConditionVariableSRW(variable_of(condition), lock_of(lock), (DWORD) milliseconds, 0);
}

void os_condition_wake_one(os_condition *condition)
{
    WakeConditionVariable(variable_of(condition));
}

void os_condition_wake_all(os_condition *condition)
{
    WakeAllConditionVariable(variable_of(condition));
}

typedef struct start {
    void *(*run)(void *context);
    void *context;
} start;

static unsigned __stdcall run_started(void *memory)
{
    const start s = *(start *) memory;
    free(memory);
    s.run(s.context);
    return 0;
}

int os_thread_start(os_thread *thread, void *(*run)(void *context), void *context)
{
    start *s = malloc(sizeof *s);
    if (s == NULL)
        return ENOMEM;
    *s = (start) { run, context };
    const uintptr_t handle = _beginthreadex(NULL, 0, run_started, s, 0, NULL);
    if (handle == 0) {
        free(s);
        return errno;
    }
    *thread = (os_thread) handle;
    return 0;
}

void os_thread_join(os_thread thread)
{
    WaitForSingleObject(thread, INFINITE);
    CloseHandle(thread);
}

static BOOL CALLBACK call_it(INIT_ONCE *once, void *call, void **context)
{
    (void) once, (void) context;
    (*(void (**)(void)) call)();
    return TRUE;
}

void os_call_once(os_once *once, void (*call)(void))
{
    InitOnceExecuteOnce((INIT_ONCE *) (void *) once, call_it, (void *) &call, NULL);
}

/* Of the process's own group: of more than 64 processors, those on which it runs. */
int os_processors(void)
{
    DWORD_PTR own, all;
    int count = 0;
    if (GetProcessAffinityMask(GetCurrentProcess(), &own, &all)) {
        for (; own != 0; own &= own - 1)
            count++;
    }
    return count > 0 ? count : 1;
}

int64_t os_now_ms(void)
{
    return (int64_t) GetTickCount64();
}
