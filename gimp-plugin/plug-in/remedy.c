/* SPDX-License-Identifier: MIT */
/*
 * remedy.c - what a report suggests to do with a layer
 */
#include "remedy.h"

enum { AUTO_METHOD = 2, FROM_STANDARD = 1 };

job_status remedy_look(findings *f, const settings *s, const raster *layer,
                       const char *(*translate)(const char *text), const surroundings *around)
{
    settings question = *s;
    undone right;
    f->undoes = false;
    job_status status = report_run(&f->found, s, layer, translate, around);
    if (status != JOB_DONE || !undone_is_possible(f->found.accident, layer))
        return status;
    question.value[FK_FROM] = FROM_STANDARD;
    undone_open(&right, layer, f->found.accident);
    status = report_run(&f->undone, &question, &right.raster, NULL, around);
    f->undoes = status == JOB_DONE;
    return status;
}

bool remedy_applies(remedy which, const findings *f)
{
    const report *r = &f->found;
    const bool usable = r->judged && !r->misplaced && r->used > 0;
    switch (which) {
    case REMEDY_UNDO:
        return f->undoes;
    case REMEDY_CLEAN:
        return usable && (!r->right || r->inexact > 0);
    case REMEDY_STANDARD:
        return usable && r->encoding != NTP_ENCODING_STANDARD;
    default:
        return usable;
    }
}

remedy remedy_needed(const findings *f)
{
    if (f->undoes)
        return REMEDY_UNDO;
    if (remedy_applies(REMEDY_CLEAN, f) && !f->found.right)
        return REMEDY_CLEAN;
    return remedy_applies(REMEDY_STANDARD, f) ? REMEDY_STANDARD : (remedy) REMEDIES;
}

static repair_job cleaning(const report *r)
{
    settings s;
    settings_reset(&procedures[PROCEDURE_CLEAN], &s);
    s.value[FC_METHOD] = AUTO_METHOD;
    s.value[FC_KEEP_NEGATIVE_Z] = r->keeps;
    return repair_job_from(&s, r);
}

repair_job remedy_job(remedy which, const findings *f, undo_kind *accident)
{
    const report *r = &f->found;
    *accident = which == REMEDY_UNDO ? r->accident : UNDO_NOTHING;
    if (which == REMEDY_UNDO)
        return cleaning(&f->undone);
    if (which == REMEDY_CLEAN)
        return cleaning(r);
    return (repair_job) { .from = r->encoding,
                          .how.touch_unused = r->touch,
                          .convert = true,
                          .to = which == REMEDY_STANDARD ? NTP_ENCODING_STANDARD : r->encoding,
                          .turn_green = which == REMEDY_GREEN };
}

ntp_y remedy_green(remedy which, const findings *f)
{
    const ntp_orientation_result *g = which == REMEDY_UNDO ? &f->undone.green : &f->found.green;
    const ntp_y before = g->decided ? g->y : NTP_Y_UP;
    if (which != REMEDY_GREEN)
        return before;
    return before == NTP_Y_UP ? NTP_Y_DOWN : NTP_Y_UP;
}
