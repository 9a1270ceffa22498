/* SPDX-License-Identifier: MIT */
/*
 * height_from_rows.c - normals -> heightfield, row by row, for pictures larger than memory
 *
 * The direct solver (direct/solve.c) walks down the picture and up again.  Between the two walks
 * the caller keeps what the second one needs, in the rows where the heights will be.
 */
#include "to_height/direct/direct.h"
#include "to_height/make_plan.h"

#include <string.h>

/* Checks the format and the size; the data and strides of `form` are not looked at. */
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
    ntp__height_plan plan;
    ntp_const_image checked;
    if (check_form(&checked, form) != NTP_OK ||
        ntp__make_rows_plan(&plan, how, form->width, form->height) != NTP_OK || parts < 0 ||
        parts > NTP_MAX_PARTS)
        return 0;
    return ntp__direct_rows_scratch(&checked, &plan, parts > 0 ? parts : 1);
}

ntp_status ntp_height_from_rows(const ntp_const_image *form, const ntp_height_rows *rows,
                                const ntp_height_options *how, void *scratch, size_t scratch_size,
                                const ntp_hooks *hooks, ntp_height_result *result)
{
    ntp__height_plan plan;
    ntp_height_result done;
    ntp_const_image checked;
    memset(&done, 0, sizeof done);
    NTP__TRY(check_form(&checked, form));
    NTP__TRY(ntp__make_rows_plan(&plan, how, form->width, form->height));
    if (rows == NULL || rows->read_normals == NULL || rows->read_heights == NULL ||
        rows->write_heights == NULL)
        return NTP_ERR_ARGUMENT;
    int32_t parts = hooks != NULL && hooks->parts != 0 ? hooks->parts : 1;
    if (parts < 1 || parts > NTP_MAX_PARTS)
        return NTP_ERR_ARGUMENT;
    size_t size = ntp__direct_rows_scratch(&checked, &plan, parts);
    if (size == 0)
        return NTP_ERR_FORMAT;
    if (scratch == NULL || (uintptr_t) scratch % NTP__ALIGNMENT != 0 || scratch_size < size)
        return NTP_ERR_SCRATCH;
    NTP__TRY(ntp__direct_rows(&checked, rows, &plan, scratch, hooks, &done));
    done.method = plan.method;
    done.islands = 1;
    done.residual = -1;
    if (result != NULL)
        *result = done;
    return NTP_OK;
}
