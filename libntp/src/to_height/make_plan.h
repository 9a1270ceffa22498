/* SPDX-License-Identifier: MIT */
/*
 * make_plan.h - turns the options of the caller into a plan
 */
#ifndef NTP_MAKE_PLAN_H
#define NTP_MAKE_PLAN_H

#include "to_height/shared/height_plan.h"

/* Checks all options; NULL stands for the defaults.  The caller checks the size and the type of the
 * mask.  Sides are 1..NTP_MAX_SIDE. */
ntp_status ntp__make_plan(ntp__height_plan *plan, const ntp_height_options *how, int32_t width,
                          int32_t height);

/* The same for solving row by row.  Nothing stays AUTO there, as evidence takes a whole picture. */
ntp_status ntp__make_rows_plan(ntp__height_plan *plan, const ntp_height_options *how, int32_t width,
                               int32_t height);

#endif
