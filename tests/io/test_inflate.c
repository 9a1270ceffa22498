/* SPDX-License-Identifier: MIT */
/*
 * test_inflate.c - deflate unpacked part by part, beside zlib
 *
 * zlib is the witness: it makes streams of all kinds of blocks, most of which are then damaged.
 * What we unpack has to be what zlib unpacks, and what zlib refuses we refuse.  Input and room
 * come in parts of chance sizes, each time at another place and with chance bytes behind them.
 */
#include <zlib.h>

#include "inflate.h"
#include "chance.h"
#include "made.h"

enum {
    STREAMS = 10000,
    RAW_MAX = 1 << 17,
    PACKED_MAX = 1 << 18,
    ROOM_MOST = 5000,
    UNTOUCHED = 0xa5
};

static uint8_t raw[RAW_MAX], packed[PACKED_MAX], ours[2 * RAW_MAX], theirs[2 * RAW_MAX];
static size_t packed_size;

static void make_raw(size_t size)
{
    const uint32_t values = once_in(3) ? 256 : 1 + chance(30), far = 1 + chance(1 << 15);
    for (size_t i = 0; i < size;) {
        const size_t left = size - i, most = 1 + chance(once_in(20) ? 2000 : 20);
        const size_t count = most < left ? most : left, distance = 1 + chance(far);
        const bool again = once_in(2) && distance <= i;
        for (size_t end = i + count; i < end; i++)
            raw[i] = again ? raw[i - distance] : (uint8_t) (chance(values) * chance(values));
    }
}

/* Parts of the bytes with different levels and strategies, so that blocks of all kinds follow each
 * other. */
static void pack(size_t size)
{
    z_stream z = { 0 };
    CHECK(deflateInit2(&z, (int) chance(10), Z_DEFLATED, -MAX_WBITS, 1 + (int) chance(9),
                       (int) chance(5)) == Z_OK);
    z.next_in = raw;
    z.next_out = packed;
    z.avail_out = sizeof packed;
    for (size_t left = size; left > 0;) {
        z.avail_in = (uInt) (once_in(3) ? 1 + chance((uint32_t) left) : left);
        left -= z.avail_in;
        CHECK(deflate(&z, once_in(2) ? Z_BLOCK : Z_NO_FLUSH) == Z_OK && z.avail_in == 0);
        CHECK(deflateParams(&z, (int) chance(10), (int) chance(5)) == Z_OK);
    }
    CHECK(deflate(&z, Z_FINISH) == Z_STREAM_END);
    packed_size = z.total_out;
    deflateEnd(&z);
}

typedef struct unpacked {
    bool good;
    size_t size, used; /* bytes that were made, and that the stream has */
} unpacked;

static unpacked unpack_with_zlib(void)
{
    z_stream z = { 0 };
    CHECK(inflateInit2(&z, -MAX_WBITS) == Z_OK);
    z.next_in = packed;
    z.avail_in = (uInt) packed_size;
    z.next_out = theirs;
    z.avail_out = sizeof theirs;
    const bool good = inflate(&z, Z_FINISH) == Z_STREAM_END;
    const unpacked u = { good, z.total_out, z.total_in };
    inflateEnd(&z);
    return u;
}

static uint8_t input[2 * NTPIO__IN_SLACK + PACKED_MAX];

/* More input, at another place.  *at: how much was given before. */
static void give(ntpio__inflate *s, size_t *at, size_t most)
{
    const size_t kept = (size_t) (s->in_end - s->in), left = packed_size - *at;
    const size_t some = left < most ? left : most;
    uint8_t *to = input + chance(NTPIO__IN_SLACK);
    memmove(to, s->in, kept);
    memcpy(to + kept, packed + *at, some);
    for (size_t i = 0; i < NTPIO__IN_SLACK; i++)
        to[kept + some + i] = (uint8_t) chance(256);
    *at += some;
    s->in = to;
    s->in_end = to + kept + some;
    s->no_more = *at == packed_size;
}

static unpacked unpack_in_parts(void)
{
    static ntpio__inflate s;
    static uint8_t room[NTPIO__WINDOW + ROOM_MOST + NTPIO__OUT_SLACK];
    const size_t most = 1 + chance(once_in(2) ? 2000 : PACKED_MAX);
    uint8_t *const end =
        room + NTPIO__WINDOW + NTPIO__OUT_SLACK + chance(ROOM_MOST - NTPIO__OUT_SLACK);
    uint8_t *out = room;
    memset(end, UNTOUCHED, NTPIO__OUT_SLACK);
    size_t size = 0, at = 0;
    memset(&s, 0, offsetof(ntpio__inflate, literals));
    s.in = s.in_end = input;
    for (;;) {
        uint8_t *from = out;
        const ntpio__inflated now = ntpio__inflate_some(&s, room, &out, end);
        const size_t some = (size_t) (out - from);
        CHECK(out <= end);
        for (int i = 0; i < NTPIO__OUT_SLACK; i++)
            CHECK(end[i] == UNTOUCHED);
        if (some > sizeof ours - size) /* nor does zlib go on */
            return (unpacked) { .size = size };
        memcpy(ours + size, from, some);
        size += some;
        if (now == NTPIO__STREAM_BAD)
            return (unpacked) { .size = size };
        if (now == NTPIO__STREAM_ENDS)
            return (unpacked) { true, size, at - (size_t) (s.in_end - ntpio__inflate_end(&s)) };
        if (now == NTPIO__NEEDS_INPUT) {
            CHECK(!s.no_more);
            give(&s, &at, most);
        } else {
            CHECK(out - room > NTPIO__WINDOW);
            memmove(room, out - NTPIO__WINDOW, NTPIO__WINDOW);
            out = room + NTPIO__WINDOW;
        }
    }
}

static void test_streams(void)
{
    uint32_t good = 0, bad = 0, few = 0; /* few: good ones that we refuse */
    for (uint32_t n = 0; n < STREAMS; n++) {
        const bool damaged = n % 2 != 0;
        const size_t size = chance(once_in(30) ? RAW_MAX : 3000);
        make_raw(size);
        pack(size);
        for (uint32_t k = damaged ? 1 + chance(3) : 0; k > 0; k--)
            packed[once_in(2) ? chance((uint32_t) packed_size) : chance(40) % packed_size] ^=
                (uint8_t) (1u << chance(8));
        for (uint32_t k = once_in(2) ? chance(20) : 0; k > 0; k--) /* what follows the stream */
            packed[packed_size++] = (uint8_t) chance(256);
        const unpacked a = unpack_with_zlib(), b = unpack_in_parts();
        CHECK(damaged || (a.good && b.good));
        CHECK(!b.good || (a.good && a.size == b.size && a.used == b.used));
        few += a.good && !b.good;
        CHECK(memcmp(ours, theirs, a.size < b.size ? a.size : b.size) == 0);
        good += b.good;
        bad += !a.good;
    }
    CHECK(good >= STREAMS / 2 && bad > STREAMS / 8 && few < STREAMS / 1000);
}

/* ------------------------------------------------------------------ forbidden codes */

static unsigned bit_count;

static void put_bits(unsigned value, unsigned size)
{
    for (unsigned i = 0; i < size; i++, bit_count++)
        packed[bit_count / 8] |= (uint8_t) ((value >> i & 1) << bit_count % 8);
    packed_size = (bit_count + 7) / 8;
}

static void put_code(unsigned code, unsigned size)
{
    for (unsigned i = size; i-- > 0;)
        put_bits(code >> i & 1, 1);
}

static void start_bits(void)
{
    memset(packed, 0, sizeof packed);
    bit_count = 0;
}

static void check_both(bool good)
{
    for (int n = 0; n < 50; n++) {
        const unpacked a = unpack_with_zlib(), b = unpack_in_parts();
        CHECK(a.good == good && b.good == good);
        CHECK(!good || (a.size == b.size && memcmp(ours, theirs, a.size) == 0));
    }
}

/* A block of the fixed codes: one literal, a repetition with `length` and `distance`, the end. */
static void test_fixed(unsigned length, unsigned distance, bool good)
{
    start_bits();
    put_bits(1, 1);
    put_bits(1, 2);
    put_code(0x30 + 'a', 8);
    put_code(length < 280 ? length - 256 : 0xc0 + length - 280, length < 280 ? 7 : 8);
    put_code(distance, 5);
    put_code(0, 7);
    check_both(good);
}

/* A block whose codes are: literals a (one bit) and the end of the block (one bit; or two: a code
 * that is not complete; or none).  It says that there are so many literals and distances; the first
 * `words` distances have one bit each. */
static void test_codes(unsigned end_bits, unsigned literals, unsigned distances, unsigned words,
                       bool good)
{
    start_bits();
    put_bits(1, 1);
    put_bits(2, 2);
    put_bits(literals - 257, 5);
    put_bits(distances - 1, 5);
    put_bits(18 - 4, 4);
    /* lengths 0, 1, 2 and 18 (zeros) have two bits each: codes 0, 1, 2, 3 */
    static const uint8_t order[] = { 16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1 };
    for (size_t i = 0; i < sizeof order; i++)
        put_bits(order[i] == 0 || order[i] == 1 || order[i] == 2 || order[i] == 18 ? 2 : 0, 3);
    unsigned zeros = 'a';
    put_code(3, 2);
    put_bits(zeros - 11, 7);
    put_code(1, 2);
    zeros = 256 - 'a' - 1;
    put_code(3, 2);
    put_bits(138 - 11, 7);
    put_code(3, 2);
    put_bits(zeros - 138 - 11, 7);
    put_code(end_bits, 2);
    for (unsigned i = 257; i < literals; i++)
        put_code(0, 2);
    for (unsigned i = 0; i < distances; i++)
        put_code(i < words, 2);
    put_code(0, 1); /* a */
    put_code(end_bits == 1 ? 1 : 2, end_bits);
    check_both(good);
}

static void test_forbidden(void)
{
    test_fixed(257, 0, true);
    test_fixed(285, 0, true);
    test_fixed(286, 0, false);
    test_fixed(287, 0, false);
    test_fixed(257, 1, false); /* further back than there are bytes */
    test_fixed(257, 29, false);
    test_fixed(257, 30, false);
    test_fixed(257, 31, false);
    test_codes(1, 257, 1, 0, true);
    test_codes(1, 257, 1, 1, true);
    test_codes(1, 257, 2, 2, true);
    test_codes(1, 257, 3, 3, false);
    test_codes(1, 286, 30, 1, true);
    test_codes(1, 287, 1, 0, false);
    test_codes(1, 257, 31, 1, false);
    test_codes(2, 257, 1, 0, false);
    test_codes(0, 257, 1, 0, false);
}

/* --------------------------------------------------------------------- chance codes */

enum { LITERALS = 286, DISTANCES = 30, CODE_MAX = 15, SYMBOLS_MOST = 60, END = 256 };

static unsigned bytes; /* that the stream makes */

/*
 * A complete code of `symbols`, one of which is `certain`; the others are most often below `usual`.
 * A word is made two, one bit longer, again and again; few of them make short words.
 */
static void make_code(uint8_t *sizes, unsigned symbols, unsigned usual, unsigned certain)
{
    uint8_t words[LITERALS] = { 0 };
    const unsigned most = 2 + chance(once_in(2) ? 20 : symbols - 1);
    unsigned count = 1;
    for (unsigned tries = 0; count < most && tries < 10000; tries++) {
        const unsigned i = once_in(3) ? count - 1 : chance(count);
        if (words[i] < CODE_MAX) {
            words[i]++;
            words[count++] = words[i];
        }
    }
    memset(sizes, 0, symbols);
    const unsigned its = chance(count);
    sizes[certain] = words[its];
    for (unsigned i = 0; i < count; i++) {
        unsigned symbol = certain;
        while (i != its && sizes[symbol] != 0)
            symbol = chance(once_in(10) || count > usual / 2 ? symbols : usual);
        sizes[symbol] = words[i];
    }
}

static void put_symbol(const uint8_t *sizes, unsigned symbols, unsigned symbol)
{
    unsigned code = 0, size = sizes[symbol];
    for (unsigned i = 0; i < symbols; i++) { /* those of shorter codes come first */
        const bool before = sizes[i] == size ? i < symbol : sizes[i] < size;
        code += sizes[i] != 0 && before ? 1u << (CODE_MAX - sizes[i]) : 0;
    }
    put_code(code >> (CODE_MAX - size), size);
}

static void put_repetition(const uint8_t *lengths, const uint8_t *distances, unsigned symbol)
{
    const unsigned n = symbol - END - 1, d = chance(DISTANCES);
    const unsigned more = n < 8 || n == 28 ? 0 : n / 4 - 1, far = d < 4 ? 0 : d / 2 - 1;
    const unsigned length = n < 8 ? 3 + n : n == 28 ? 258 : ((4 + n % 4) << more) + 3;
    const unsigned distance = d < 4 ? d + 1 : ((2 + d % 2) << far) + 1;
    const unsigned length_bits = chance(1u << more), far_bits = chance(1u << far);
    if (distances[d] == 0 || distance + far_bits > bytes)
        return;
    put_symbol(lengths, LITERALS, symbol);
    put_bits(length_bits, more);
    put_symbol(distances, DISTANCES, d);
    put_bits(far_bits, far);
    bytes += length + length_bits;
}

/* Lengths of codes have four bits each. */
static void put_block_of_code(bool last)
{
    uint8_t sizes[LITERALS], distances[DISTANCES];
    make_code(sizes, LITERALS, END, END);
    make_code(distances, DISTANCES, DISTANCES, chance(DISTANCES));
    put_bits(last, 1);
    put_bits(2, 2);
    put_bits(LITERALS - 257, 5);
    put_bits(DISTANCES - 1, 5);
    put_bits(19 - 4, 4);
    for (unsigned i = 0; i < 19; i++)
        put_bits(i < 3 ? 0 : 4, 3); /* 16, 17 and 18 come first */
    for (unsigned i = 0; i < LITERALS; i++)
        put_code(sizes[i], 4);
    for (unsigned i = 0; i < DISTANCES; i++)
        put_code(distances[i], 4);
    for (unsigned left = 500 * chance(SYMBOLS_MOST); left > 0; left--) {
        const unsigned symbol = chance(LITERALS); /* most have no code */
        if (sizes[symbol] == 0 || symbol == END)
            continue;
        if (symbol > END) {
            put_repetition(sizes, distances, symbol);
        } else {
            put_symbol(sizes, LITERALS, symbol);
            bytes++;
        }
    }
    put_symbol(sizes, LITERALS, END);
}

static void put_stored_block(bool last)
{
    const unsigned size = once_in(4) ? chance(1 << 15) : chance(10);
    put_bits(last, 1);
    put_bits(0, 2);
    put_bits(0, -bit_count % 8);
    put_bits(size, 16);
    put_bits(~size & 0xffff, 16);
    for (unsigned i = 0; i < size; i++)
        put_bits(chance(256), 8);
    bytes += size;
}

/* Literals of all lengths side by side, ends of blocks behind them, and ends of the input everywhere. */
static void test_chance_codes(void)
{
    uint32_t good = 0;
    for (int n = 0; n < 500; n++) {
        start_bits();
        bytes = 0;
        for (uint32_t left = 1 + chance(4); left-- > 0;) {
            if (once_in(4))
                put_stored_block(left == 0);
            else
                put_block_of_code(left == 0);
        }
        for (size_t whole = packed_size, k = 0; k < 10; k++) {
            packed_size = k < 3 ? whole : chance((uint32_t) whole);
            const unpacked a = unpack_with_zlib(), b = unpack_in_parts();
            CHECK(a.good == b.good && (!a.good || k < 3));
            CHECK(!a.good || (a.size == b.size && a.used == b.used));
            CHECK(memcmp(ours, theirs, a.size < b.size ? a.size : b.size) == 0);
            good += a.good;
        }
    }
    CHECK(good > 1400);
}

int main(void)
{
    test_forbidden();
    test_chance_codes();
    test_streams();
    return 0;
}
