/* SPDX-License-Identifier: MIT */
/*
 * test_parts.c - blocks of two steps: each step is done once, in the order that is promised, by
 * threads at the same time, one after another, and backwards
 */
#include "base/parts.h"

#include "guarded.h"

#include <pthread.h>
#include <string.h>

enum { MOST_THREADS = 5, TRIALS = 40 };

typedef struct record {
    bool chain_first;
    int32_t lanes;
    uint64_t noise;
    int32_t each[NTP__MOST_BLOCKS], next[NTP__MOST_LANES];
    int32_t chained[NTP__MOST_LANES][NTP__MOST_BLOCKS];
} record;

/* Takes a while that differs from block to block. */
static void dawdle(uint64_t noise, int32_t i)
{
    volatile uint64_t state = noise + (uint64_t) i + 1;
    for (uint64_t k = 0; k < 50 + (noise >> i % 40) % 2000; k++)
        state = state * UINT64_C(6364136223846793005) + 1;
}

static void each(void *job, int32_t part, int32_t block)
{
    record *r = job;
    CHECK(part >= 0 && part < MOST_THREADS);
    for (int32_t lane = 0; lane < r->lanes && r->chain_first; lane++)
        CHECK(r->chained[lane][block] == 1);
    dawdle(r->noise, block);
    r->each[block]++;
}

static void chain(void *job, int32_t lane, int32_t block)
{
    record *r = job;
    CHECK(r->next[lane] == block);
    CHECK(r->chain_first || r->each[block] == 1);
    dawdle(~r->noise, block);
    r->next[lane] = block + 1;
    r->chained[lane][block]++;
}

typedef struct call {
    void (*task)(void *work, int32_t index);
    void *work;
    int32_t index;
} call;

static void *run_call(void *user)
{
    const call *c = user;
    c->task(c->work, c->index);
    return NULL;
}

static void by_threads(void *user, int32_t count, void (*task)(void *work, int32_t index),
                       void *work)
{
    pthread_t thread[MOST_THREADS];
    call calls[MOST_THREADS];
    (void) user;
    for (int32_t i = 0; i < count; i++) {
        calls[i] = (call) { task, work, i };
        CHECK(pthread_create(&thread[i], NULL, run_call, &calls[i]) == 0);
    }
    for (int32_t i = 0; i < count; i++)
        pthread_join(thread[i], NULL);
}

static void backwards(void *user, int32_t count, void (*task)(void *work, int32_t index),
                      void *work)
{
    (void) user;
    for (int32_t i = count - 1; i >= 0; i--)
        task(work, i);
}

static void check(const ntp_hooks *hooks, int32_t count, int32_t lanes, bool chain_first,
                  uint64_t noise)
{
    static record r;
    memset(&r, 0, sizeof r);
    r.chain_first = chain_first;
    r.lanes = lanes;
    r.noise = noise;
    const ntp__crew crew = ntp__crew_of(hooks);
    const ntp__crew_steps steps = { each, chain, &r, count, lanes, chain_first };
    ntp__crew_blocks(&crew, &steps);
    for (int32_t k = 0; k < NTP__MOST_BLOCKS; k++) {
        CHECK(r.each[k] == (k < count));
        for (int32_t lane = 0; lane < NTP__MOST_LANES; lane++)
            CHECK(r.chained[lane][k] == (k < count && lane < lanes));
    }
}

int main(void)
{
    static const int32_t counts[] = { 1, 2, 5, 33, NTP__MOST_BLOCKS };
    static const int32_t lanes[] = { 0, 1, 2, NTP__MOST_LANES };
    uint64_t state = 9;
    for (int32_t i = 0; i < TRIALS; i++) {
        const int32_t parts = 1 + i % MOST_THREADS, count = counts[i % 4 + (i > 20)];
        const uint64_t noise = (uint64_t) random_bits(&state) << 32 | random_bits(&state);
        const ntp_hooks hooks[] = { { NULL, NULL, NULL, parts },
                                    { NULL, NULL, backwards, parts },
                                    { NULL, NULL, by_threads, parts } };
        for (int32_t k = 0; k < 3 * 4 * 2; k++)
            check(&hooks[k % 3], count, lanes[k / 3 % 4], k >= 12, noise);
    }
    return 0;
}
