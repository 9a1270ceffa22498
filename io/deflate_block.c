/* SPDX-License-Identifier: MIT */
/*
 * deflate_block.c - Huffman codes, and blocks of deflate (RFC 1951)
 */
#include "deflate_block.h"

#include <stdlib.h>

#include "simd.h"

enum {
    END = 256,
    CODE_MAX = 15,        /* bits */
    LENGTHS = 19,         /* words of the code that tells the lengths of the codes */
    LENGTHS_CODE_MAX = 7, /* bits of that */
    REPEAT = 16,          /* ... the last length 3 to 6 times */
    ZEROS = 17,           /* ... 3 to 10 */
    MORE_ZEROS = 18,      /* ... 11 to 138 */
    DEPTH_MAX = 64,       /* a tree is as deep as Fibonacci's numbers fit in the sum: 45 */
    SMALL = 2048,         /* symbols; in larger blocks, codes made for them are shorter */
    COUNT_MAX = (1 << 22) - 1,
    WORD_BITS = 9,
    KEY_BITS = 32, /* of a count and its word */
    FOUR_MAX = 14, /* bits: four such words fit beside 7 bits that wait */
    STORED_MAX = 65535,
    FIXED = 1,
    MADE = 2
};

typedef struct code {
    uint8_t bits[NTPIO__WORDS]; /* 0: the word does not occur */
    uint16_t word[NTPIO__WORDS];
} code;

/* --------------------------------------------------------------------------- codes */

/*
 * Sorts keys by their counts, those of equal counts as they stand: by a byte after the other, the
 * lowest first.  qsort took a fiftieth of the time of a file.
 */
static void sort_keys(uint32_t *keys, int n)
{
    enum { DIGIT = 8, DIGITS = 1 << DIGIT };
    uint32_t sorted[NTPIO__WORDS], all = 0;
    for (int i = 0; i < n; i++)
        all |= keys[i];
    for (unsigned shift = WORD_BITS; shift < KEY_BITS && all >> shift != 0; shift += DIGIT) {
        uint16_t next[DIGITS + 1] = { 0 };
        for (int i = 0; i < n; i++)
            next[(keys[i] >> shift) % DIGITS + 1]++;
        for (int digit = 1; digit < DIGITS; digit++)
            next[digit] = (uint16_t) (next[digit] + next[digit - 1]);
        for (int i = 0; i < n; i++)
            sorted[next[(keys[i] >> shift) % DIGITS]++] = keys[i];
        memcpy(keys, sorted, (size_t) n * sizeof *keys);
    }
}

/*
 * Moffat and Katajainen: the depths of n counts in rising order, within their own array.  The
 * counts become sums of pairs, then parents, then depths; those fall as the counts rise.
 */
static void count_depths(uint32_t *a, int n, unsigned *at_depth)
{
    int root = 0, leaf = 2, inner = 1, used = 0;
    a[0] += a[1];
    for (int next = 1; next < n - 1; next++) {
        uint32_t sum = 0;
        for (int i = 0; i < 2; i++) {
            if (leaf >= n || (root < next && a[root] < a[leaf])) {
                sum += a[root];
                a[root++] = (uint32_t) next;
            } else {
                sum += a[leaf++];
            }
        }
        a[next] = sum;
    }
    a[n - 2] = 0;
    for (int next = n - 3; next >= 0; next--)
        a[next] = a[a[next]] + 1;
    root = n - 2;
    for (unsigned depth = 0; inner > 0; depth++) {
        for (used = 0; root >= 0 && a[root] == depth; root--)
            used++;
        at_depth[depth] = (unsigned) (inner - used);
        inner = 2 * used;
    }
}

/* Too deep words move up to `most`; for each that has no place there, another one goes down. */
static void limit_depths(unsigned *at_depth, unsigned most)
{
    uint32_t used = 0;
    for (unsigned d = most + 1; d < DEPTH_MAX; d++)
        at_depth[most] += at_depth[d];
    for (unsigned d = 1; d <= most; d++)
        used += at_depth[d] << (most - d);
    for (; used > 1u << most; used--) {
        unsigned d = most - 1;
        while (at_depth[d] == 0)
            d--;
        at_depth[most]--;
        at_depth[d]--;
        at_depth[d + 1] += 2;
    }
}

/* The first bit last. */
static uint16_t reversed(uint32_t value, unsigned bits)
{
    uint32_t result = 0;
    for (; bits > 0; bits--, value >>= 1)
        result = result << 1 | (value & 1);
    return (uint16_t) result;
}

/* The words of a code follow from its lengths; their bits are written the last one first. */
static void name_words(uint16_t *word, const uint8_t *lengths, unsigned words)
{
    uint32_t first[CODE_MAX + 2] = { 0 };
    unsigned at_depth[CODE_MAX + 1] = { 0 };
    for (unsigned i = 0; i < words; i++)
        at_depth[lengths[i]]++;
    at_depth[0] = 0;
    for (unsigned d = 1; d <= CODE_MAX; d++)
        first[d + 1] = (first[d] + at_depth[d]) << 1;
    for (unsigned i = 0; i < words; i++) {
        const unsigned bits = lengths[i];
        word[i] = reversed(bits != 0 ? first[bits]++ : 0, bits);
    }
}

static void make_code(code *c, const uint32_t *counts, unsigned words, unsigned most)
{
    uint32_t keys[NTPIO__WORDS] = { 0 }, depths[NTPIO__WORDS] = { 0 };
    unsigned at_depth[DEPTH_MAX] = { 0 };
    int n = 0;
    memset(c->bits, 0, sizeof c->bits);
    for (unsigned i = 0; i < words; i++) {
        const uint32_t count = counts[i] < COUNT_MAX ? counts[i] : COUNT_MAX;
        if (count != 0)
            keys[n++] = count << WORD_BITS | i;
    }
    if (n > 1) {
        sort_keys(keys, n); /* they stand in the order of their words */
        for (int i = 0; i < n; i++)
            depths[i] = keys[i] >> WORD_BITS;
        count_depths(depths, n, at_depth);
        limit_depths(at_depth, most);
    } else {
        at_depth[1] = (unsigned) n;
    }
    for (unsigned d = 1; d <= most; d++) {
        for (unsigned i = 0; i < at_depth[d]; i++)
            c->bits[keys[--n] & ((1 << WORD_BITS) - 1)] = (uint8_t) d;
    }
    name_words(c->word, c->bits, words);
}

static void take_fixed_codes(code *words, code *distances)
{
    for (unsigned i = 0; i < NTPIO__WORDS; i++)
        words->bits[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
    memset(distances->bits, 5, sizeof distances->bits);
    name_words(distances->word, distances->bits, NTPIO__DISTANCES);
    for (unsigned i = 0; i < NTPIO__WORDS; i++) { /* words 286 and 287 are missing in the array */
        const uint32_t value = i < 144   ? 0x30 + i
                               : i < 256 ? 0x190 + i - 144
                               : i < 280 ? i - 256
                                         : 0xc0 + i - 280;
        words->word[i] = reversed(value, words->bits[i]);
    }
}

/* -------------------------------------------------------------- lengths of the codes */

typedef struct header {
    code lengths;
    uint16_t items[NTPIO__WORDS + NTPIO__DISTANCES]; /* word | extra bits << 5 */
    unsigned count, words, distances, told;
} header;

static const uint8_t extra_bits[LENGTHS] = { [REPEAT] = 2, [ZEROS] = 3, [MORE_ZEROS] = 7 };
static const uint8_t told_order[LENGTHS] = { 16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                             11, 4,  12, 3, 13, 2, 14, 1, 15 };

static void add_item(header *h, uint32_t *counts, unsigned word, unsigned extra)
{
    h->items[h->count++] = (uint16_t) (word | extra << 5);
    counts[word]++;
}

static void add_run(header *h, uint32_t *counts, unsigned length, unsigned run)
{
    for (unsigned n; length == 0 && run >= 3; run -= n) {
        n = run < 138 ? run : 138;
        add_item(h, counts, n < 11 ? ZEROS : MORE_ZEROS, n < 11 ? n - 3 : n - 11);
    }
    if (length != 0) {
        add_item(h, counts, length, 0);
        run--;
    }
    for (unsigned n; length != 0 && run >= 3; run -= n) {
        n = run < 6 ? run : 6;
        add_item(h, counts, REPEAT, n - 3);
    }
    for (; run > 0; run--)
        add_item(h, counts, length, 0);
}

static void make_header(header *h, const code *words, const code *distances)
{
    uint8_t all[NTPIO__WORDS + NTPIO__DISTANCES] = { 0 };
    uint32_t counts[LENGTHS] = { 0 };
    h->count = 0;
    h->words = NTPIO__WORDS;
    while (words->bits[h->words - 1] == 0)
        h->words--;
    h->distances = NTPIO__DISTANCES;
    while (h->distances > 1 && distances->bits[h->distances - 1] == 0)
        h->distances--;
    memcpy(all, words->bits, h->words);
    memcpy(all + h->words, distances->bits, h->distances);
    const unsigned total = h->words + h->distances;
    for (unsigned i = 0, run; i < total; i += run) {
        for (run = 1; i + run < total && all[i + run] == all[i];)
            run++;
        add_run(h, counts, all[i], run);
    }
    make_code(&h->lengths, counts, LENGTHS, LENGTHS_CODE_MAX);
    h->told = LENGTHS;
    while (h->told > 4 && h->lengths.bits[told_order[h->told - 1]] == 0)
        h->told--;
}

static uint64_t header_bits(const header *h)
{
    uint64_t bits = 5 + 5 + 4 + 3 * h->told;
    for (unsigned i = 0; i < h->count; i++) {
        const unsigned word = h->items[i] & 31;
        bits += h->lengths.bits[word] + extra_bits[word];
    }
    return bits;
}

static void put_header(ntpio__bits *b, const header *h)
{
    ntpio__put_bits(b, h->words - NTPIO__FIRST_LENGTH, 5);
    ntpio__put_bits(b, h->distances - 1, 5);
    ntpio__put_bits(b, h->told - 4, 4);
    for (unsigned i = 0; i < h->told; i++)
        ntpio__put_bits(b, h->lengths.bits[told_order[i]], 3);
    for (unsigned i = 0; i < h->count; i++) {
        const unsigned word = h->items[i] & 31;
        ntpio__put_bits(b, h->lengths.word[word], h->lengths.bits[word]);
        ntpio__put_bits(b, h->items[i] >> 5u, extra_bits[word]);
    }
}

/* -------------------------------------------------------------------------- blocks */

/* Of the symbols, without their extra bits, which all kinds of codes share. */
static uint64_t code_bits(const ntpio__counts *counts, const code *words, const code *distances)
{
    uint64_t bits = 0;
    for (unsigned i = 0; i < NTPIO__WORDS; i++)
        bits += (uint64_t) counts->words[i] * words->bits[i];
    for (unsigned i = 0; i < NTPIO__DISTANCES; i++)
        bits += (uint64_t) counts->distances[i] * distances->bits[i];
    return bits;
}

static uint64_t shared_bits(const ntpio__counts *counts)
{
    uint64_t bits = 0;
    for (unsigned i = 8; i < 28; i++)
        bits += (uint64_t) counts->words[NTPIO__FIRST_LENGTH + i] * (i / 4 - 1);
    for (unsigned i = 4; i < NTPIO__DISTANCES; i++)
        bits += (uint64_t) counts->distances[i] * (i / 2 - 1);
    return bits;
}

/* Its bits fit: 15 and 5 of the length, 15 and 13 of the distance, 7 that wait. */
NTPIO_PART void put_match(ntpio__bits *b, ntpio__match match, const uint32_t *words,
                          const code *distances)
{
    const uint32_t length = match >> 16, distance = match & 0xffff;
    const uint32_t word = words[NTPIO__FIRST_LENGTH + ntpio__length_slot(length)];
    const unsigned slot = ntpio__distance_slot(distance);
    unsigned extra = ntpio__length_extra(length);
    ntpio__add_bits(b, word >> 16, word & 0xffff);
    ntpio__add_bits(b, (length - 3) & ((1u << extra) - 1), extra);
    extra = ntpio__distance_extra(distance);
    ntpio__add_bits(b, distances->word[slot], distances->bits[slot]);
    ntpio__add_bits(b, distance & ((1u << extra) - 1), extra);
    ntpio__flush_bits(b);
}

/* Two words of the table, one after the other, and the bits that they take. */
NTPIO_PART uint64_t join_words(uint32_t first, uint32_t second, unsigned *bits)
{
    *bits = (first & 0xffff) + (second & 0xffff);
    return (uint64_t) (second >> 16) << (first & 0xffff) | first >> 16;
}

/* Four words, where some may be empty, are joined before what waits is known. */
NTPIO_PART void put_words(ntpio__bits *b, uint32_t one, uint32_t two, uint32_t three, uint32_t four)
{
    unsigned some = 0, more = 0;
    const uint64_t first = join_words(one, two, &some), second = join_words(three, four, &more);
    b->waiting |= (second << some | first) << b->count;
    b->count += some + more;
    ntpio__flush_bits(b);
}

/* Three at once: 45 bits, and 7 that wait.  Four, if no word is longer than FOUR_MAX.  The last ones are
 * fewer, without a branch that is hard to foresee. */
NTPIO_PART const uint8_t *put_literals(ntpio__bits *b, const uint8_t *bytes, size_t count,
                                       const uint32_t *words, size_t at_once)
{
    for (; count >= at_once; count -= at_once, bytes += at_once)
        put_words(b, words[bytes[0]], words[bytes[1]], words[bytes[2]],
                  at_once > 3 ? words[bytes[3]] : 0);
    put_words(b, count > 0 ? words[bytes[0]] : 0, count > 1 ? words[bytes[1]] : 0,
              count > 2 ? words[bytes[2]] : 0, 0);
    return bytes + count;
}

NTPIO_PART void put_some(ntpio__bits *b, const ntpio__step *steps, size_t count,
                         const uint8_t *bytes, const uint32_t *words, const code *distances,
                         size_t at_once)
{
    for (size_t i = 0; i < count; i++) {
        bytes = put_literals(b, bytes, steps[i].literals, words, at_once);
        if (steps[i].match != 0)
            put_match(b, steps[i].match, words, distances);
        bytes += steps[i].match >> 16;
    }
}

NTPIO_PART void put_all(ntpio__bits *to, const ntpio__step *steps, size_t count,
                        const uint8_t *bytes, const uint32_t *words, const code *distances,
                        bool four)
{
    ntpio__bits b = *to; /* stays in registers */
    if (four)
        put_some(&b, steps, count, bytes, words, distances, 4);
    else
        put_some(&b, steps, count, bytes, words, distances, 3);
    *to = b;
}

#ifdef NTPIO_IN_BMI2
NTPIO_IN_BMI2 static void put_all_bmi2(ntpio__bits *to, const ntpio__step *steps, size_t count,
                                       const uint8_t *bytes, const uint32_t *words,
                                       const code *distances, bool four)
{
    put_all(to, steps, count, bytes, words, distances, four);
}
#endif

static void put_steps(ntpio__bits *b, const ntpio__step *steps, size_t count, const uint8_t *bytes,
                      const code *words, const code *distances)
{
    uint32_t both[NTPIO__WORDS]; /* word << 16 | its bits: one look finds both */
    unsigned longest = 0;
    for (unsigned i = 0; i < NTPIO__WORDS; i++)
        both[i] = (uint32_t) words->word[i] << 16 | words->bits[i];
    for (unsigned i = 0; i < NTPIO__LITERALS; i++)
        longest = words->bits[i] > longest ? words->bits[i] : longest;
#ifdef NTPIO_IN_BMI2
    if (ntpio__has_bmi2())
        put_all_bmi2(b, steps, count, bytes, both, distances, longest <= FOUR_MAX);
    else
#endif
        put_all(b, steps, count, bytes, both, distances, longest <= FOUR_MAX);
    ntpio__put_bits(b, words->word[END], words->bits[END]);
}

void ntpio__end_byte(ntpio__bits *b)
{
    if (b->count > 0)
        b->out[b->size++] = (uint8_t) b->waiting;
    b->waiting = 0;
    b->count = 0;
}

void ntpio__put_stored(ntpio__bits *b, const uint8_t *bytes, size_t size, bool last)
{
    do {
        const size_t some = size < STORED_MAX ? size : STORED_MAX;
        ntpio__put_bits(b, last && some == size, 3);
        ntpio__end_byte(b);
        ntpio__put_bits(b, (uint32_t) some, 16);
        ntpio__put_bits(b, (uint32_t) some ^ STORED_MAX, 16);
        memcpy(b->out + b->size, bytes, some);
        b->size += some;
        bytes += some;
        size -= some;
    } while (size > 0);
}

void ntpio__put_block(ntpio__bits *b, const ntpio__step *steps, size_t count, ntpio__counts *counts,
                      const uint8_t *bytes, size_t size, bool last)
{
    code words, distances, fixed_words, fixed_distances;
    header h;
    uint64_t fixed = UINT64_MAX / 2;
    uint32_t symbols = 0;
    for (unsigned i = 0; i < NTPIO__WORDS; i++)
        symbols += counts->words[i];
    counts->words[END] = 1;
    make_code(&words, counts->words, NTPIO__WORDS, CODE_MAX);
    make_code(&distances, counts->distances, NTPIO__DISTANCES, CODE_MAX);
    make_header(&h, &words, &distances);
    const uint64_t made = header_bits(&h) + code_bits(counts, &words, &distances);
    if (symbols <= SMALL) {
        take_fixed_codes(&fixed_words, &fixed_distances);
        fixed = code_bits(counts, &fixed_words, &fixed_distances);
    }
    const uint64_t least = shared_bits(counts) + (made < fixed ? made : fixed);
    if (least > 8 * ((uint64_t) size + 5 * (size / STORED_MAX + 1))) {
        ntpio__put_stored(b, bytes, size, last);
        b->stored = true;
        return;
    }
    ntpio__put_bits(b, (last ? 1u : 0u) | (made < fixed ? MADE : FIXED) << 1u, 3);
    if (made < fixed)
        put_header(b, &h);
    put_steps(b, steps, count, bytes, made < fixed ? &words : &fixed_words,
              made < fixed ? &distances : &fixed_distances);
}
