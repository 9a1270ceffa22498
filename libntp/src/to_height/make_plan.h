/* SPDX-License-Identifier: MIT */
/*
 * make_plan.h - from the options of the caller to what is to be solved
 */
#ifndef NTP_MAKE_PLAN_H
#define NTP_MAKE_PLAN_H

#include "to_height/shared/height_plan.h"

/* Checks all options, NULL standing for the defaults, but not the mask's pixels: which size and type
 * they have.  Sides are 1..NTP_MAX_SIDE. */
ntp_status ntp__make_plan(ntp__height_plan *plan, const ntp_height_options *how, int32_t width,
                          int32_t height);

/* The same for solving row by row, where nothing is left AUTO: evidence takes a whole picture. */
ntp_status ntp__make_rows_plan(ntp__height_plan *plan, const ntp_height_options *how, int32_t width,
                               int32_t height);

#endif
