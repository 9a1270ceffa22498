/* SPDX-License-Identifier: MIT */
/*
 * threads.h - threads, locks, time
 */
#ifndef NTP_OS_THREADS_H
#define NTP_OS_THREADS_H

#include <stdbool.h>
#include <stdint.h>

#ifdef _WIN32

typedef struct os_lock {
    void *word; /* SRWLOCK */
} os_lock;
typedef struct os_condition {
    void *word; /* CONDITION_VARIABLE */
} os_condition;
typedef struct os_once {
    void *word; /* INIT_ONCE */
} os_once;
typedef void *os_thread;
#  define OS_ONCE { 0 }

#elif defined(__wasi__)

/* There is one thread: no other starts, and nothing is waited for. */
typedef char os_lock;
typedef char os_condition;
typedef bool os_once;
typedef char os_thread;
#  define OS_ONCE false

#else

#  include <pthread.h>

typedef pthread_mutex_t os_lock;
typedef pthread_cond_t os_condition;
typedef pthread_once_t os_once;
typedef pthread_t os_thread;
#  define OS_ONCE PTHREAD_ONCE_INIT

#endif

void os_lock_init(os_lock *lock);
void os_lock_destroy(os_lock *lock);
void os_lock_take(os_lock *lock);
void os_lock_release(os_lock *lock);

/* Waiting releases the lock; it may end without a reason. */
void os_condition_init(os_condition *condition);
void os_condition_destroy(os_condition *condition);
void os_condition_wait(os_condition *condition, os_lock *lock);
void os_condition_wait_ms(os_condition *condition, os_lock *lock, int milliseconds);
void os_condition_wake_one(os_condition *condition);
void os_condition_wake_all(os_condition *condition);

/* 0, or an errno. */
int os_thread_start(os_thread *thread, void *(*run)(void *context), void *context);
void os_thread_join(os_thread thread);

void os_call_once(os_once *once, void (*call)(void));

/* How many threads can run at the same time. */
int os_processors(void);

/* Of a clock that is never set. */
int64_t os_now_ms(void);

#endif
