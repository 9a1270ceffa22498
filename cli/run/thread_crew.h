/* SPDX-License-Identifier: MIT */
/*
 * thread_crew.h - threads for the parts of one large piece of work
 *
 * libntp starts no threads.  Its long operations call back with parts that may be done at once
 * (ntp_hooks.parallel_for), and a crew does them.
 */
#ifndef NTP_CLI_THREAD_CREW_H
#define NTP_CLI_THREAD_CREW_H

#include <stdint.h>

typedef struct crew crew;

/* Starts threads - 1 threads, as the caller is one; fewer if the system refuses. */
crew *crew_start(int threads);

/* Ends them.  NULL is allowed. */
void crew_stop(crew *c);

/* A parallel_for; the first argument is a crew. */
void crew_run(void *crew, int32_t count, void (*task)(void *work, int32_t index), void *work);

#endif
