/* SPDX-License-Identifier: MIT */
/*
 * height_from_rows.c - normals -> heightfield, row by row, for pictures beyond memory
 *
 * The direct solver (direct/solve.c) walks down the picture and up again; between the two, rows of
 * the heights' file hold what the second walk needs.
 */
#include "to_height/direct/direct.h"

#include <string.h>

/* Evidence is found in a whole picture: without it AUTO is the plain convention. */
static ntp_status resolve(ntp_height_options *resolved, const ntp_height_options *how)
{
    memset(resolved, 0, sizeof *resolved);
    if (how != NULL)
        *resolved = *how;
    if ((int) resolved->method < NTP_HEIGHT_AUTO || (int) resolved->method > NTP_HEIGHT_WEIGHTED ||
        (int) resolved->decode < NTP_DECODE_AUTO || (int) resolved->decode > NTP_DECODE_SNORM ||
        (int) resolved->z < NTP_Z_AUTO || (int) resolved->z > NTP_Z_DERIVED ||
        (int) resolved->border_x < 0 || (int) resolved->border_x > NTP_BORDER_REPEAT_SLOPE ||
        (int) resolved->border_y < 0 || (int) resolved->border_y > NTP_BORDER_REPEAT_SLOPE)
        return NTP_ERR_ARGUMENT;
    if (resolved->method == NTP_HEIGHT_TELESCOPING || resolved->method == NTP_HEIGHT_WEIGHTED ||
        resolved->mask != NULL || resolved->residual_scope != NTP_RESIDUAL_NONE ||
        resolved->detrend || resolved->refine != 0)
        return NTP_ERR_FORMAT;
    if (resolved->decode == NTP_DECODE_AUTO)
        resolved->decode = NTP_DECODE_UNORM;
    if (resolved->z == NTP_Z_AUTO)
        resolved->z = NTP_Z_STORED;
    return NTP_OK;
}

/* Its samples and strides are not looked at. */
static ntp_status check_form(ntp_const_image *checked, const ntp_const_image *form)
{
    if (form == NULL)
        return NTP_ERR_ARGUMENT;
    *checked = *form;
    if ((int) form->type < NTP_TYPE_U8 || (int) form->type > NTP_TYPE_F32 || form->channels < 1 ||
        form->channels > 4)
        return NTP_ERR_ARGUMENT;
    checked->data = checked; /* anything that is aligned */
    checked->ring_rows = 0;
    checked->pixel_stride = form->channels * ntp__sample_size(form->type);
    checked->row_stride = checked->pixel_stride * form->width;
    return ntp__check_normals(checked);
}

size_t ntp_height_rows_scratch_size(const ntp_const_image *form, const ntp_height_options *how,
                                    int32_t parts)
{
    ntp_height_options r;
    ntp_const_image checked;
    if (check_form(&checked, form) != NTP_OK || resolve(&r, how) != NTP_OK || parts < 0 ||
        parts > NTP_MAX_PARTS)
        return 0;
    return ntp__stream_scratch(&checked, &r, parts > 0 ? parts : 1);
}

ntp_status ntp_height_from_rows(const ntp_const_image *form, const ntp_height_rows *rows,
                                const ntp_height_options *how, void *scratch, size_t scratch_size,
                                const ntp_hooks *hooks, ntp_height_result *result)
{
    ntp_height_options r;
    ntp_height_result done;
    ntp_const_image checked;
    memset(&done, 0, sizeof done);
    NTP__TRY(check_form(&checked, form));
    NTP__TRY(resolve(&r, how));
    if (rows == NULL || rows->read_normals == NULL || rows->read_heights == NULL ||
        rows->write_heights == NULL)
        return NTP_ERR_ARGUMENT;
    int32_t parts = hooks != NULL && hooks->parts != 0 ? hooks->parts : 1;
    if (parts < 1 || parts > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__integrate_check(&r, form->width, form->height));
    size_t size = ntp__stream_scratch(&checked, &r, parts);
    if (size == 0)
        return NTP_ERR_FORMAT;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 || scratch_size < size)
        return NTP_ERR_SCRATCH;
    NTP__TRY(ntp__stream(&checked, rows, &r, scratch, hooks, &done));
    bool wrap = r.border_x == NTP_BORDER_WRAP && r.border_y == NTP_BORDER_WRAP;
    done.method = wrap ? NTP_HEIGHT_FRANKOT_CHELLAPPA : NTP_HEIGHT_POISSON_DCT;
    done.islands = 1;
    done.residual = -1;
    if (result != NULL)
        *result = done;
    return NTP_OK;
}
