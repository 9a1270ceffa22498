/* SPDX-License-Identifier: MIT */
/*
 * reconstruct.c - normals -> heightfield: checks, the choice of the method, and what comes after
 *
 * A solver (integrate.c, weighted.c) makes heights of mean 0.  What else is wanted works on these:
 * the plane is taken out, and the result described.
 */
#include "integrate.h"
#include "weighted.h"

#include <string.h>

enum { ALIGNMENT = 64 };

/* ------------------------------------------------------------------------------- checks */

static bool in_range(int value, int last)
{
    return value >= 0 && value <= last;
}

static ntp_status check_seeds(const ntp_height_options *how)
{
    for (int32_t i = 0; how->use_seeds && i < 4; i++) {
        if (!(how->seeds[i] - how->seeds[i] == 0))
            return NTP_ERR_ARGUMENT;
    }
    return how->use_seeds && how->method != NTP_HEIGHT_TELESCOPING ? NTP_ERR_ARGUMENT : NTP_OK;
}

/* Makes the defaults explicit. */
static ntp_status resolve(ntp_height_options *resolved, const ntp_height_options *how)
{
    memset(resolved, 0, sizeof *resolved);
    if (how != NULL)
        *resolved = *how;
    how = resolved;
    if (!in_range((int) how->method, NTP_HEIGHT_WEIGHTED) ||
        !in_range((int) how->decode, NTP_DECODE_SNORM) || !in_range((int) how->z, NTP_Z_AUTO) ||
        !in_range((int) how->border_x, NTP_BORDER_REPEAT_SLOPE) ||
        !in_range((int) how->border_y, NTP_BORDER_REPEAT_SLOPE) ||
        !in_range((int) how->kernel, NTP_KERNEL_BAKED) ||
        !in_range(how->refine, NTP_MAX_ITERATIONS) ||
        !in_range(how->max_iterations, NTP_MAX_ITERATIONS) || !(how->tolerance >= 0) ||
        !(how->tolerance < 1))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(check_seeds(how));
    bool wrap = how->border_x == NTP_BORDER_WRAP && how->border_y == NTP_BORDER_WRAP;
    if (how->method == NTP_HEIGHT_AUTO && how->mask != NULL)
        resolved->method = NTP_HEIGHT_WEIGHTED;
    else if (how->method == NTP_HEIGHT_AUTO && wrap)
        resolved->method = NTP_HEIGHT_FRANKOT_CHELLAPPA;
    else if (how->method == NTP_HEIGHT_AUTO && how->border_x != NTP_BORDER_WRAP &&
             how->border_y != NTP_BORDER_WRAP)
        resolved->method = NTP_HEIGHT_POISSON_DCT;
    if (how->mask != NULL && resolved->method != NTP_HEIGHT_WEIGHTED)
        return NTP_ERR_ARGUMENT;
    /* Where one axis wraps, the solver goes by neither name; it is told "auto". */
    return NTP_OK;
}

static ntp_status check_views(const ntp_image *dst, const ntp_const_image *src)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image seen = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_view(&seen));
    if (dst->encoding != NTP_HEIGHT || dst->type != NTP_F32 || dst->channels != 1)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&seen, src) || src->ring_rows != 0 || dst->ring_rows != 0 ||
        dst->pixel_stride != (ptrdiff_t) sizeof(float))
        return NTP_ERR_SHAPE;
    return NTP_OK;
}

static ntp_status check_mask(const ntp_const_image *mask, const ntp_const_image *src)
{
    if (mask == NULL)
        return NTP_OK;
    NTP__TRY(ntp__check_view(mask));
    if (mask->encoding != NTP_HEIGHT || mask->type == NTP_F32)
        return NTP_ERR_FORMAT;
    return ntp__same_size(mask, src) && mask->ring_rows == 0 ? NTP_OK : NTP_ERR_SHAPE;
}

size_t ntp_height_scratch_size(const ntp_height_options *how, int32_t width, int32_t height,
                               int32_t parts)
{
    ntp_height_options r;
    if (width < 1 || height < 1 || width > NTP_MAX_SIDE || height > NTP_MAX_SIDE || parts < 0 ||
        parts > NTP_MAX_PARTS || resolve(&r, how) != NTP_OK)
        return 0;
    parts = parts > 0 ? parts : 1;
    return r.method == NTP_HEIGHT_WEIGHTED ? ntp__weighted_scratch(&r, width, height, parts)
                                           : ntp__integrate_scratch(&r, width, height, parts);
}

/* ------------------------------------------------------------------------------- result */

/* Takes the best plane out of heights of mean 0, along the axes that do not wrap.  The columns, and
 * the rows, of a rectangle are orthogonal: two fits, each of one slope. */
static void detrend(const ntp_image *dst, const ntp_height_options *how, ntp_height_result *result)
{
    double along = 0, down = 0, w = dst->width, h = dst->height;
    double middle_x = (w - 1) / 2, middle_y = (h - 1) / 2;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        double sum = 0, moment = 0;
        for (int32_t x = 0; x < dst->width; x++) {
            sum += (double) row[x];
            moment += (double) row[x] * (x - middle_x);
        }
        along += moment;
        down += sum * (y - middle_y);
    }
    /* The sum of (i - middle)^2 over n places is n (n^2 - 1)/12. */
    if (how->border_x != NTP_BORDER_WRAP && dst->width > 1)
        result->trend_x = 12 * along / (h * w * (w * w - 1));
    if (how->border_y != NTP_BORDER_WRAP && dst->height > 1)
        result->trend_y = 12 * down / (w * h * (h * h - 1));
    for (int32_t y = 0; y < dst->height; y++) {
        float *row = ntp__at_mut(dst, 0, y);
        double shift = (y - middle_y) * result->trend_y;
        for (int32_t x = 0; x < dst->width; x++)
            row[x] = (float) ((double) row[x] - shift - (x - middle_x) * result->trend_x);
    }
}

static void find_range(const ntp_image *dst, ntp_height_result *result)
{
    float min = *(const float *) dst->data, max = min;
    for (int32_t y = 0; y < dst->height; y++) {
        const float *row = ntp__at_mut(dst, 0, y);
        for (int32_t x = 0; x < dst->width; x++) {
            min = row[x] < min ? row[x] : min;
            max = row[x] > max ? row[x] : max;
        }
    }
    result->min = min;
    result->max = max;
}

/* ------------------------------------------------------------------------------- public */

ntp_status ntp_height_from_normals(const ntp_image *dst, const ntp_const_image *src,
                                   const ntp_height_options *how, void *scratch,
                                   size_t scratch_size, const ntp_hooks *hooks,
                                   ntp_height_result *result)
{
    ntp_height_options r;
    ntp_height_result done;
    ntp__slope_counts counts = { 0, 0, 0, 0, { 0, 0 } };
    ntp__slopes slopes;
    memset(&done, 0, sizeof done);
    NTP__TRY(check_views(dst, src));
    NTP__TRY(resolve(&r, how));
    NTP__TRY(check_mask(r.mask, src));
    int32_t parts = hooks != NULL && hooks->parts != 0 ? hooks->parts : 1;
    if (parts < 1 || parts > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    bool weighted = r.method == NTP_HEIGHT_WEIGHTED;
    if (!weighted)
        NTP__TRY(ntp__integrate_check(&r, src->width, src->height));
    if (scratch == NULL || (uintptr_t) scratch % ALIGNMENT != 0 ||
        scratch_size < ntp_height_scratch_size(&r, src->width, src->height, parts))
        return NTP_ERR_SCRATCH;
    if (hooks != NULL && hooks->progress != NULL && hooks->progress(hooks->user, 0) != 0)
        return NTP_ERR_CANCELLED;
    ntp__slopes_init(&slopes, src, &r);
    done.islands = 1;
    ntp_status status = weighted ? ntp__weighted_solve(dst, &slopes, &r, scratch, hooks, &done)
                                 : ntp__integrate(dst, &slopes, &r, scratch, hooks, &counts);
    if (status != NTP_OK && status != NTP_ERR_NOT_CONVERGED)
        return status;
    done.method = r.method != NTP_HEIGHT_AUTO ? r.method : NTP_HEIGHT_POISSON_DCT;
    done.decode = slopes.decode;
    done.z = slopes.derived ? NTP_Z_DERIVED : NTP_Z_STORED;
    done.unused += counts.unused;
    done.not_finite += counts.not_finite;
    done.consistency = counts.consistency;
    done.consistency_max = counts.consistency_max;
    done.min = (double) counts.range[0];
    done.max = (double) counts.range[1];
    done.residual = -1;
    if (r.detrend && !weighted)
        detrend(dst, &r, &done);
    /* The direct solver has found the range as it wrote. */
    if (weighted || r.method == NTP_HEIGHT_TELESCOPING || r.detrend)
        find_range(dst, &done);
    if (result != NULL)
        *result = done;
    return status;
}

const char *ntp_height_method_name(ntp_height_method method)
{
    switch (method) {
    case NTP_HEIGHT_AUTO:
        return "auto";
    case NTP_HEIGHT_TELESCOPING:
        return "telescoping";
    case NTP_HEIGHT_FRANKOT_CHELLAPPA:
        return "frankot-chellappa";
    case NTP_HEIGHT_POISSON_DCT:
        return "poisson-dct";
    case NTP_HEIGHT_WEIGHTED:
        return "weighted";
    }
    return "unknown";
}
