/* SPDX-License-Identifier: MIT */
/*
 * resize_plan.c - what ntp_resize knows before it sees a texture; sides of mip levels
 */
#include "reshape/resize_job.h"

#include <string.h>

static size_t axis_size(const ntp__axis *a)
{
    return ntp__align16((size_t) a->dst * sizeof *a->span) +
           ntp__align16((size_t) a->dst * (size_t) a->stride * sizeof *a->weight);
}

static bool side_is_good(int32_t side)
{
    return side >= 1 && side <= NTP_MAX_SIDE;
}

static bool border_is_good(ntp_border border)
{
    return (int) border >= NTP_BORDER_WRAP && (int) border <= NTP_BORDER_MIRROR;
}

/* Fills in all of the plan but the tables; false if an argument is bad. */
static bool describe(ntp_resize_plan *p, const ntp_resize_options *how, int32_t src_width,
                     int32_t src_height, int32_t width, int32_t height)
{
    memset(p, 0, sizeof *p);
    if (how != NULL)
        p->how = *how;
    if ((int) p->how.filter < NTP_FILTER_TRIANGLE || (int) p->how.filter > NTP_FILTER_LANCZOS3 ||
        !border_is_good(p->how.border_x) || !border_is_good(p->how.border_y) ||
        p->how.touch_unused > NTP_UNUSED_ALL || !side_is_good(src_width) ||
        !side_is_good(src_height) || !side_is_good(width) || !side_is_good(height))
        return false;
    p->x.src = src_width;
    p->x.dst = width;
    p->x.border = p->how.border_x;
    p->x.stride = ntp__axis_stride(p->how.filter, src_width, width);
    p->y.src = src_height;
    p->y.dst = height;
    p->y.border = p->how.border_y;
    p->y.stride = ntp__axis_stride(p->how.filter, src_height, height);
    return true;
}

size_t ntp_resize_plan_size(const ntp_resize_options *how, int32_t src_width, int32_t src_height,
                            int32_t width, int32_t height)
{
    ntp_resize_plan p;
    if (!describe(&p, how, src_width, src_height, width, height))
        return 0;
    return ntp__align16(sizeof p) + axis_size(&p.x) + axis_size(&p.y);
}

static void place_axis(ntp__axis *axis, char *memory, ntp_filter filter)
{
    axis->span = (ntp__span_of_taps *) (void *) memory;
    axis->weight =
        (int32_t *) (void *) (memory + ntp__align16((size_t) axis->dst * sizeof *axis->span));
    ntp__axis_init(axis, filter);
}

ntp_status ntp_resize_plan_init(ntp_resize_plan **plan, void *memory, size_t size,
                                const ntp_resize_options *how, int32_t src_width,
                                int32_t src_height, int32_t width, int32_t height)
{
    ntp_resize_plan p;
    if (plan == NULL || !describe(&p, how, src_width, src_height, width, height))
        return NTP_ERR_ARGUMENT;
    if (memory == NULL || (uintptr_t) memory % 16 != 0 ||
        size < ntp__align16(sizeof p) + axis_size(&p.x) + axis_size(&p.y))
        return NTP_ERR_SCRATCH;
    char *tables = (char *) memory + ntp__align16(sizeof p);
    place_axis(&p.x, tables, p.how.filter);
    place_axis(&p.y, tables + axis_size(&p.x), p.how.filter);
    *plan = (ntp_resize_plan *) memory;
    **plan = p;
    return NTP_OK;
}

ntp_rows ntp_resize_rows(const ntp_resize_plan *plan, int32_t y)
{
    y = y < 0 ? 0 : y < plan->y.dst ? y : plan->y.dst - 1;
    const ntp__span_of_taps *span = &plan->y.span[y];
    ntp_rows rows = { span->first, span->first + span->count - 1 };
    return rows;
}

int32_t ntp_mip_side(int32_t side, int32_t level)
{
    if (side < 1 || level < 0 || level > 30)
        return side < 1 ? 0 : level < 0 ? side : 1;
    return side >> level > 0 ? side >> level : 1;
}

int32_t ntp_mip_levels(int32_t width, int32_t height)
{
    if (width < 1 || height < 1)
        return 0;
    int32_t levels = 1;
    for (int32_t side = width > height ? width : height; side > 1; side /= 2)
        levels++;
    return levels;
}

const char *ntp_filter_name(ntp_filter filter)
{
    static const char *const NAME[] = { "triangle", "box", "lanczos3" };
    return (int) filter >= 0 && (int) filter < 3 ? NAME[filter] : "unknown";
}
