/* SPDX-License-Identifier: MIT */
/*
 * texture_output.c - makes the mips and the blocks of a DDS or KTX2
 */
#include "write/texture_output.h"

#include <string.h>
#include <strings.h>

#include "cli.h"
#include "run/thread_crew.h"

enum { BC4_BYTES = 8, BC5_BYTES = 16, BAND = 4 /* rows of blocks that a thread takes at once */ };

bool texture_is_output(const production *p)
{
    const char *output = p->in->output, *ending = output != NULL ? name_ending(output) : "";
    return !option_given(p->m->o, OPT_IN_PLACE) &&
           (strcasecmp(ending, ".dds") == 0 || strcasecmp(ending, ".ktx2") == 0);
}

static ntp_const_image picture(const texture_output *t, const void *data, uint32_t width,
                               uint32_t height)
{
    ntp_image image = ntp_image_packed((void *) (uintptr_t) data, (int32_t) width, (int32_t) height,
                                       t->whole.channels, t->whole.type);
    image.encoding = t->whole.encoding;
    image.y = t->whole.y;
    return ntp_image_as_const(&image);
}

/* As ntp resize --mips: each mip is made of the whole picture. */
static bool make_mip(void *context, void *dst, uint32_t width, uint32_t height, const void *whole)
{
    const texture_output *t = context;
    const ntp_resize_options how = { .filter = NTP_FILTER_BOX, .touch_unused = t->touch_unused };
    const ntp_const_image from =
        picture(t, whole, (uint32_t) t->whole.width, (uint32_t) t->whole.height);
    ntp_image to =
        ntp_image_packed(dst, (int32_t) width, (int32_t) height, t->whole.channels, t->whole.type);
    to.encoding = from.encoding;
    to.y = from.y;
    const size_t size = ntp_resize_plan_size(&how, from.width, from.height, to.width, to.height);
    void *memory = need_aligned(size), *scratch = NULL;
    ntp_resize_plan *plan;
    ntp_status status = ntp_resize_plan_init(&plan, memory, size, &how, from.width, from.height,
                                             to.width, to.height);
    if (status == NTP_OK) {
        const size_t working = ntp_resize_scratch_size(plan);
        scratch = need_aligned(working);
        status = ntp_resize(&to, &from, plan, scratch, working, NULL);
    }
    free_aligned(scratch);
    free_aligned(memory);
    return status == NTP_OK;
}

typedef struct bands {
    const texture_output *t;
    ntp_const_image src;
    uint8_t *dst;
} bands;

static void compress_band(void *work, int32_t index)
{
    const bands *b = work;
    const bool pair = b->t->how.blocks == NTPIO_BLOCKS_BC5;
    const int32_t columns = (b->src.width + NTP_BLOCK_SIDE - 1) / NTP_BLOCK_SIDE;
    const int32_t y0 = index * BAND * NTP_BLOCK_SIDE, y1 = y0 + BAND * NTP_BLOCK_SIDE;
    const ntp_rect area = { 0, y0, b->src.width, y1 < b->src.height ? y1 : b->src.height };
    const ptrdiff_t row = (ptrdiff_t) columns * (pair ? BC5_BYTES : BC4_BYTES);
    if (pair)
        ntp_bc5_encode(b->dst, row, &b->src, &b->t->quality, &area);
    else
        ntp_bc4_encode(b->dst, row, &b->src, &b->t->quality, &area);
}

static bool compress(void *context, uint8_t *dst, const void *src, uint32_t width, uint32_t height)
{
    const texture_output *t = context;
    bands b = { t, picture(t, src, width, height), dst };
    const int32_t rows = BAND * NTP_BLOCK_SIDE;
    const int32_t count = ((int32_t) height + rows - 1) / rows;
    crew *threads = crew_start(t->threads < count ? t->threads : count);
    crew_run(threads, count, compress_band, &b);
    crew_stop(threads);
    return true;
}

bool texture_begin(texture_output *t, const production *p, const ntp_image *rows,
                   ntpio_write_options *shape, ntpio_error *error)
{
    const options *o = p->m->o;
    const bool height = rows->encoding == NTP_ENCODING_HEIGHT;
    const bool none = option_given(o, OPT_COMPRESSION) && option_integer(o, OPT_COMPRESSION) == 1;
    *t = (texture_output) { .used = texture_is_output(p) };
    if (!t->used)
        return !option_given(o, OPT_MIPS) ||
               wrong_use(p,
                         "--mips is for .dds and .ktx2; ntp resize --mips writes a file for each",
                         error);
    t->how = (ntpio_texture) {
        .mips = option_given(o, OPT_MIPS), .context = t, .make_mip = make_mip, .compress = compress
    };
    if (!none)
        t->how.blocks = height ? NTPIO_BLOCKS_BC4 : NTPIO_BLOCKS_BC5;
    if (height && t->how.mips)
        return wrong_use(p, "--mips are made of normals, not of heights", error);
    if (height && !none && rows->channels > 1)
        return wrong_use(p, "BC4 holds one channel of heights; --compression none keeps all",
                         error);
    t->whole = *rows;
    t->quality.quality = (ntp_block_quality) option_integer(o, OPT_QUALITY);
    t->touch_unused = p->touch;
    t->threads = p->w->threads;
    shape->texture = &t->how;
    return true;
}

const char *texture_compression(const texture_output *t)
{
    static const char *const NAMES[] = { "none", "bc4", "bc5" };
    return NAMES[t->how.blocks];
}

uint32_t texture_mips(const texture_output *t)
{
    return t->how.mips ? (uint32_t) ntp_mip_levels(t->whole.width, t->whole.height) : 1;
}

void texture_describe(const texture_output *t, text *line)
{
    if (!t->used)
        return;
    const bool more = t->whole.channels > 2;
    if (t->how.blocks == NTPIO_BLOCKS_BC5)
        text_addf(line, " in BC5%s",
                  !more                    ? ""
                  : t->whole.channels == 3 ? " (red and green; blue follows from them)"
                                           : " (red and green; no alpha, blue follows from them)");
    else
        text_add(line, t->how.blocks == NTPIO_BLOCKS_BC4 ? " in BC4" : ", not compressed");
    if (t->how.mips)
        text_addf(line, ", %lu mips", (unsigned long) texture_mips(t));
}
