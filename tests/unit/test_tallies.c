/* SPDX-License-Identifier: MIT */
/*
 * test_tallies.c - a texture has the same facts in whatever way its texels come into a tally
 *
 * All at once; texel by texel, as those of views that are not packed; in parts, with facts asked for in between;
 * in tallies that are merged into one that is empty or not, some of so few texels that these are counted in
 * another way; and in a tally that was cleared.  Tallies are fresh but for the last one.
 */
#include "guarded.h"
#include "libntp.h"
#include "measure/evidence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 256, H = 100, FEW_ROWS = 9, KINDS = 7, WAYS = 6 };

typedef enum kind { CLEAN, SOME_FAR, NOISE, BANDS, STRIPES, ALPHAS, DOTS } kind;

typedef struct facts {
    ntp_stats stats[2];
    ntp_harm harm;
    ntp_classification type;
    double ag_in_disc; /* see evidence.h */
    uint64_t levels_off[65536];
} facts;

static uint16_t pixels[W * H * 4], apart[W * H * 5]; /* of 16 bit, or bytes */
static ntp_type type;
static uint32_t touched;

static int32_t most(void)
{
    return type == NTP_TYPE_U8 ? 255 : 65535;
}

static uint16_t level(double v)
{
    return (uint16_t) (0.5 * most() * (1 + v) + 0.5);
}

static void draw_clean(uint16_t *p, int32_t x, int32_t y)
{
    const double a = 0.65 * sin(0.11 * x + 0.05 * y), b = 0.6 * cos(0.07 * y);
    p[0] = level(a);
    p[1] = level(b);
    p[2] = level(sqrt(1 - a * a - b * b));
}

static bool is_noise(kind k, int32_t y)
{
    return k == NOISE || (k == BANDS && y / 20 % 2 != 0);
}

/* Stripes of transparent black, then colors without alpha, then any alpha. */
static void draw_background(uint16_t *p, int32_t x, int32_t y)
{
    const int32_t row = y % 20;
    if (row < 5 && x / 8 % 2 == 0)
        p[0] = p[1] = p[2] = p[3] = 0;
    else if (row >= 5 && row < 8 && x / 31 % 2 == 0)
        p[3] = 0;
    else if (row >= 8 && row < 10)
        p[3] = (uint16_t) (x * most() / (W - 1));
}

/* Alpha is 0 or M: stripes without it, of colors or black. */
static void draw_stripes(uint16_t *p, int32_t x, int32_t y)
{
    if (x / 8 % 2 != 0)
        return;
    p[3] = 0;
    if (y / 8 % 2 != 0)
        p[0] = p[1] = p[2] = 0;
}

/* Colors of 8 bit, with alpha of 16 bit around the middle between any two of 8 bit. */
static void draw_alphas(uint16_t *p, int32_t x, int32_t y, uint32_t any)
{
    const int32_t by = most() / 255, alpha = 257 * x + 128 + y - H / 2;
    for (int32_t c = 0; c < 3; c++)
        p[c] = (uint16_t) ((int32_t) (any >> 8 * c & 255) * by);
    p[3] = (uint16_t) (alpha > 65535 ? most() : alpha * by / 257);
}

/* Noise, clean texels and a few colors in any order; rows of which none, any or all have an alpha of 0. */
static void draw_dots(uint16_t *p, int32_t y, uint32_t any)
{
    const uint16_t m = (uint16_t) most(), middle = m / 2;
    const uint16_t colors[][3] = { { 0, 0, 0 },          { m, m, m },
                                   { 257, 514, 771 },    { middle, middle, m },
                                   { 1000, 1000, 1000 }, { middle, (uint16_t) (middle + 1), m } };
    const uint32_t which = y < H / 2 ? any % 8 : any % 64;
    if (which < sizeof colors / sizeof colors[0])
        memcpy(p, colors[which], sizeof colors[0]);
    else if (y / 10 % 2 != 0)
        memcpy(p, &any, sizeof any);
    if (y % 10 > 6 || (y % 10 > 2 && any >> 30 != 0))
        p[3] = 0;
}

static void store(int32_t at, uint16_t sample)
{
    if (type == NTP_TYPE_U8)
        ((uint8_t *) (void *) pixels)[at] = (uint8_t) sample;
    else
        pixels[at] = sample;
}

static void draw(kind k, int32_t channels, uint64_t *seed)
{
    for (int32_t i = 0; i < W * H; i++) {
        uint16_t p[4];
        const uint32_t any = random_bits(seed);
        draw_clean(p, i % W, i / W);
        for (int32_t c = 0; is_noise(k, i / W) && c < 3; c++)
            p[c] = (uint16_t) random_bits(seed);
        if (k == SOME_FAR && any % 37 == 0)
            p[2] = (uint16_t) (any >> 8);
        if (k != CLEAN && any % 41 == 0) /* gray; black and white are unused */
            p[0] = p[1] = p[2] = (uint16_t) (any >> 9 & 1 ? any >> 16 : 0 - (any >> 10 & 1));
        p[3] = (uint16_t) most();
        if ((k == SOME_FAR || k == NOISE) && any % 11 == 0)
            p[3] = (uint16_t) (any >> 20 & 3);
        if (k == BANDS)
            draw_background(p, i % W, i / W);
        if (k == STRIPES)
            draw_stripes(p, i % W, i / W);
        if (k == DOTS)
            draw_dots(p, i / W, any);
        if (k == ALPHAS)
            draw_alphas(p, i % W, i / W, any);
        for (int32_t c = 0; c < channels; c++)
            store(i * channels + c, p[c]);
    }
}

static ntp_const_image view_of(int32_t channels, bool packed)
{
    const size_t sample = type == NTP_TYPE_U8 ? 1 : 2, size = sample * (size_t) channels;
    ntp_image view = ntp_image_packed(packed ? pixels : apart, W, H, channels, type);
    for (size_t i = 0; !packed && i < (size_t) W * H; i++)
        memcpy((uint8_t *) apart + i * (size + sample), (uint8_t *) pixels + i * size, size);
    if (!packed) {
        view.pixel_stride = (ptrdiff_t) (size + sample);
        view.row_stride = W * view.pixel_stride;
    }
    return ntp_image_as_const(&view);
}

static ntp_tally *fresh(void)
{
    ntp_tally *const tally = calloc(1, ntp_tally_size());
    CHECK(tally != NULL);
    return tally;
}

static void add(ntp_tally *tally, const ntp_const_image *view, int32_t y0, int32_t y1)
{
    const ntp_rect area = { 0, y0, W, y1 };
    CHECK(ntp_tally_add(tally, view, touched, &area) == NTP_OK);
}

static void ask(facts *f, ntp_tally *tally)
{
    const ntp__evidence *evidence;
    memset(f, 0, sizeof *f);
    if (type == NTP_TYPE_U8) /* angles of 16 bit are of one encoding */
        CHECK(ntp_tally_summarize(&f->stats[1], tally, NTP_ENCODING_ZZERO) == NTP_OK);
    CHECK(ntp_tally_summarize(&f->stats[0], tally, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_harm(&f->harm, tally, NTP_ENCODING_STANDARD, NTP_HARM_ALL, 5) == NTP_OK);
    CHECK(ntp_tally_levels_off(f->levels_off, (size_t) most() + 1, tally, NTP_ENCODING_STANDARD) ==
          NTP_OK);
    CHECK(ntp_classify(&f->type, tally) == NTP_OK);
    CHECK(ntp__gather_evidence(&evidence, tally) == NTP_OK);
    f->ag_in_disc = evidence->ag_in_disc;
}

/* Rows of one tally after those of another, which may have none. */
static void add_merged(ntp_tally *tally, const ntp_const_image *view, int32_t first, int32_t part)
{
    add(tally, view, 0, first > 0 ? first : 1);
    for (int32_t y = first > 0 ? first : 1; y < H; y += part) {
        ntp_tally *const other = fresh();
        add(other, view, y, y + part < H ? y + part : H);
        CHECK(ntp_tally_merge(tally, other) == NTP_OK);
        free(other);
    }
}

static void measure(facts *f, int32_t way, int32_t channels)
{
    const ntp_const_image view = view_of(channels, way != 0);
    ntp_tally *tally = fresh();
    switch (way) {
    case 2: /* asked in between */
        add(tally, &view, 0, H / 3);
        ask(f, tally);
        add(tally, &view, H / 3, H);
        break;
    case 3:
        add_merged(tally, &view, 0, H / 2);
        break;
    case 4: /* few texels each */
        add_merged(tally, &view, H / 2, FEW_ROWS);
        break;
    case 5: /* cleared, with others and without that they were asked for */
        add(tally, &view, H / 4, H);
        ask(f, tally);
        CHECK(ntp_tally_clear(tally) == NTP_OK);
        add(tally, &view, H / 2, H / 2 + FEW_ROWS);
        add(tally, &view, 0, H);
        CHECK(ntp_tally_clear(tally) == NTP_OK);
        add(tally, &view, 0, H);
        break;
    default: /* 0: not packed */
        add(tally, &view, 0, H);
    }
    ask(f, tally);
    free(tally);
}

/* Stats and harm are filled with zeros first. */
static bool are_same(const facts *a, const facts *b)
{
    const void *const stats[] = { a->stats, b->stats }, *const harm[] = { &a->harm, &b->harm };
    return memcmp(stats[0], stats[1], sizeof a->stats) == 0 &&
           memcmp(harm[0], harm[1], sizeof a->harm) == 0 && a->type.type == b->type.type &&
           a->type.confidence == b->type.confidence && a->ag_in_disc == b->ag_in_disc &&
           memcmp(a->levels_off, b->levels_off, sizeof a->levels_off) == 0;
}

static void check(kind k, int32_t channels, uint64_t *seed)
{
    static facts want, found;
    draw(k, channels, seed);
    measure(&want, 0, channels);
    CHECK(want.stats[0].texels == W * H);
    for (int32_t way = 1; way < WAYS; way++) {
        measure(&found, way, channels);
        CHECK(are_same(&found, &want));
    }
}

int main(void)
{
    static const ntp_type TYPES[] = { NTP_TYPE_U8, NTP_TYPE_U16 };
    static const uint32_t TOUCHED[] = { NTP_UNUSED_TRANSPARENT, NTP_UNUSED_BLACK };
    uint64_t seed = 39;
    for (int32_t i = 0; i < 2; i++) {
        type = TYPES[i];
        for (int32_t channels = 3; channels <= 4; channels++) {
            for (int32_t k = 0; k < KINDS; k++)
                check((kind) k, channels, &seed);
        }
    }
    for (int32_t i = 0; i < 2; i++) {
        touched = TOUCHED[i];
        check(BANDS, 4, &seed);
        check(STRIPES, 4, &seed);
        check(DOTS, 4, &seed);
    }
    return 0;
}
