/* SPDX-License-Identifier: MIT */
/*
 * classic.h - the arguments of the gimp-normalmap plug-in as jobs of today
 *
 * They compute what it was meant to compute, without its defects; docs/gimp-normalmap.md lists the
 * differences.
 */
#ifndef NTP_PLUGIN_CLASSIC_H
#define NTP_PLUGIN_CLASSIC_H

#include "height.h"
#include "repair.h"

typedef enum classic_kind { CLASSIC_NORMALS, CLASSIC_REPAIR, CLASSIC_HEIGHT } classic_kind;

typedef struct classic_job {
    classic_kind kind;
    normals_job normals; /* CLASSIC_NORMALS */
    repair_job repair;   /* CLASSIC_REPAIR; CLASSIC_HEIGHT: done before the heights are made */
    height_job height;   /* CLASSIC_HEIGHT */
    alpha_rule alpha;
} classic_job;

/* The job for the settings of PROCEDURE_CLASSIC, in a layer with this number of channels and this
 * type. */
classic_job classic_job_from(const settings *s, int32_t channels, ntp_type type);

#endif
