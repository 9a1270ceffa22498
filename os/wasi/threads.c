/* SPDX-License-Identifier: MIT */
/*
 * threads.c - one thread, and time
 */
#include "os/threads.h"

#include <errno.h>
#include <stdlib.h>
#include <time.h>

void os_lock_init(os_lock *lock)
{
    *lock = 0;
}

void os_lock_destroy(os_lock *lock)
{
    (void) lock;
}

void os_lock_take(os_lock *lock)
{
    (void) lock;
}

void os_lock_release(os_lock *lock)
{
    (void) lock;
}

void os_condition_init(os_condition *condition)
{
    *condition = 0;
}

void os_condition_destroy(os_condition *condition)
{
    (void) condition;
}

/* Nobody would wake it. */
void os_condition_wait(os_condition *condition, os_lock *lock)
{
    (void) condition, (void) lock;
    abort();
}

void os_condition_wait_ms(os_condition *condition, os_lock *lock, int milliseconds)
{
    (void) milliseconds;
    os_condition_wait(condition, lock);
}

void os_condition_wake_one(os_condition *condition)
{
    (void) condition;
}

void os_condition_wake_all(os_condition *condition)
{
    (void) condition;
}

int os_thread_start(os_thread *thread, void *(*run)(void *context), void *context)
{
    (void) thread, (void) run, (void) context;
    return EAGAIN;
}

void os_thread_join(os_thread thread)
{
    (void) thread;
}

void os_call_once(os_once *once, void (*call)(void))
{
    if (!*once)
        call();
    *once = true;
}

int os_processors(void)
{
    return 1;
}

int64_t os_now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t) t.tv_sec * 1000 + t.tv_nsec / 1000000;
}
