/* SPDX-License-Identifier: MIT */
/*
 * threads.c - threads, locks, time
 */
#include "os/threads.h"

#include <sched.h>
#include <stddef.h>
#include <time.h>
#include <unistd.h>

void os_lock_init(os_lock *lock)
{
    pthread_mutex_init(lock, NULL);
}

void os_lock_destroy(os_lock *lock)
{
    pthread_mutex_destroy(lock);
}

void os_lock_take(os_lock *lock)
{
    pthread_mutex_lock(lock);
}

void os_lock_release(os_lock *lock)
{
    pthread_mutex_unlock(lock);
}

void os_condition_init(os_condition *condition)
{
    pthread_cond_init(condition, NULL);
}

void os_condition_destroy(os_condition *condition)
{
    pthread_cond_destroy(condition);
}

void os_condition_wait(os_condition *condition, os_lock *lock)
{
    pthread_cond_wait(condition, lock);
}

void os_condition_wait_ms(os_condition *condition, os_lock *lock, int milliseconds)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += milliseconds * 1000000L;
    until.tv_sec += until.tv_nsec / 1000000000L;
    until.tv_nsec %= 1000000000L;
    pthread_cond_timedwait(condition, lock, &until);
}

void os_condition_wake_one(os_condition *condition)
{
    pthread_cond_signal(condition);
}

void os_condition_wake_all(os_condition *condition)
{
    pthread_cond_broadcast(condition);
}

int os_thread_start(os_thread *thread, void *(*run)(void *context), void *context)
{
    return pthread_create(thread, NULL, run, context);
}

void os_thread_join(os_thread thread)
{
    pthread_join(thread, NULL);
}

void os_call_once(os_once *once, void (*call)(void))
{
    pthread_once(once, call);
}

int os_processors(void)
{
#ifdef __linux__
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        return CPU_COUNT(&set);
#endif
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (int) online : 1;
}

int64_t os_now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t) t.tv_sec * 1000 + t.tv_nsec / 1000000;
}
