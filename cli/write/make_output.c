/* SPDX-License-Identifier: MIT */
/*
 * make_output.c - the passes over one file, from its first row to the output in its place
 */
#include "write/make_output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli.h"
#include "os/files.h"
#include "write/green.h"
#include "write/question.h"
#include "write/refusal.h"

/* ----------------------------------------------------------------------- the plan */

bool is_dry_run(const maker *m)
{
    return option_given(m->o, OPT_DRY_RUN);
}

bool is_in_place(const maker *m)
{
    return option_given(m->o, OPT_IN_PLACE);
}

/* Is an output only written if it differs from the input? */
static bool needs_change(const maker *m)
{
    return is_in_place(m) || option_given(m->o, OPT_ONLY_CHANGED);
}

static bool one_row_tells(const production *p)
{
    return p->m->plan == PLAN_AS_TOLD && p->forced >= 0;
}

/* ----------------------------------------------------------------------- one file */

bool wrong_use(const production *p, const char *what, ntpio_error *error)
{
    return file_error(error, NTPIO_ERR_USAGE, p->in->path, what);
}

bool production_write(production *p, const void *rows, ptrdiff_t stride, const ntp_rect *area,
                      ntpio_error *error)
{
    return p->writer == NULL ||
           ntpio_write_rows(p->writer, rows, stride, (uint32_t) (area->y1 - area->y0), error);
}

static ntpio_format format_of(const production *p, const char *output, int32_t sample_bytes)
{
    const char *ending = name_ending(output);
    if (is_in_place(p->m))
        return p->s.info->format;
    if (p->m->plan == PLAN_AFTER_READING && sample_bytes == 4) /* standard output, too */
        return NTPIO_PFM;
    return strcasecmp(ending, ".tga") == 0    ? NTPIO_TGA
           : strcasecmp(ending, ".pfm") == 0  ? NTPIO_PFM
           : strcasecmp(ending, ".webp") == 0 ? NTPIO_WEBP
           : strcasecmp(ending, ".dds") == 0  ? NTPIO_DDS
           : strcasecmp(ending, ".ktx2") == 0 ? NTPIO_KTX2
                                              : NTPIO_PNG;
}

bool production_may_write(const production *p, const char *path, ntpio_error *error)
{
    if (output_is_free(p->inputs, path))
        return true;
    text t = { 0 };
    text_name(&t, path);
    error->status = NTPIO_ERR_USAGE;
    snprintf(error->message, sizeof error->message,
             "%.380s is an input, or the output of one; nothing is overwritten", text_string(&t));
    text_free(&t);
    return false;
}

/* The result would replace a file outside of the directories that were named. */
static bool leads_out(const production *p, ntpio_error *error)
{
    if (p->in->outside == NULL)
        return false;
    text why = { 0 };
    text_add(&why, "leads to ");
    text_name(&why, p->in->outside);
    text_add(&why, ", outside of what was named; not written");
    file_error(error, NTPIO_ERR_WRITE, p->in->path, text_string(&why));
    text_free(&why);
    return true;
}

/* A JPEG is never replaced: that would destroy the only original; nor is WebP that lost as much.  Nor
 * are DDS and KTX2: what was compressed once is not compressed again; nor EXR, which is not
 * written. */
static bool replaces_original(const production *p, ntpio_error *error)
{
    const char *output = p->in->output, *name = unwritten_name(p->s.info);
    if (name == NULL || output == NULL || !is_same_file(p->in->path, output))
        return false;
    text why = { 0 };
    text_addf(&why, "%s is not written; give -o for a PNG of another name", name);
    file_error(error, is_in_place(p->m) ? NTPIO_ERR_WRITE : NTPIO_ERR_USAGE, p->in->path,
               text_string(&why));
    text_free(&why);
    return true;
}

/* Such a file is an error only where it would change, which these verbs find out by their rows. */
static bool may_stay(const production *p)
{
    return is_in_place(p->m) && (p->m->o->verb_bit & (V_CLEAN | V_CONVERT)) != 0;
}

/* Whether the place of an output may be written, and its directories are there. */
static bool prepare_place(const production *p, const char *output, ntpio_error *error)
{
    text why = { 0 };
    if (leads_out(p, error))
        return false;
    if (strcmp(output, "-") == 0 || make_parents(output, &why))
        return true;
    error->status = NTPIO_ERR_WRITE;
    snprintf(error->message, sizeof error->message, "%.500s", text_string(&why));
    text_free(&why);
    return false;
}

ntpio_writer *production_open(const production *p, const char *output, ntpio_write_options *shape,
                              ntpio_error *error)
{
    if (!prepare_place(p, output, error))
        return NULL;
    shape->format = format_of(p, output, shape->sample_bytes);
    if (shape->copy_from == NULL)
        shape->copy_from = p->s.info;
    shape->read_path = p->s.in->path;
    shape->read_stamp = p->s.info->stamp;
    shape->level =
        option_given(p->m->o, OPT_LEVEL) ? (int32_t) option_integer(p->m->o, OPT_LEVEL) : -1;
    if (shape->threads == 0)
        shape->threads = p->w->threads;
    return ntpio_create(output, shape, error);
}

typedef enum pass_end { PASS_DONE, PASS_CHANGES, PASS_UNREADABLE, PASS_FAILED } pass_end;

/* Reads all rows: measures them unless the facts are known, and lets the verb work on them. */
static pass_end run_pass(production *p, bool writes, ntpio_error *error)
{
    ntpio_write_options shape = { .width = p->s.info->width,
                                  .height = p->s.info->height,
                                  .channels = p->s.view.channels,
                                  .sample_bytes = p->s.info->sample_bytes };
    memset(p->state, 0, p->m->state_size);
    p->changes = false;
    undo_restart(&p->undone);
    if (!p->m->begin(p, &shape, error))
        return PASS_FAILED;
    if (p->probing && p->changes)
        return PASS_CHANGES;
    if (writes && p->m->plan != PLAN_AFTER_READING) {
        if (format_of(p, p->in->output, shape.sample_bytes) == NTPIO_PNG)
            shape.threads = source_leave_threads(&p->s);
        p->writer = production_open(p, p->in->output, &shape, error);
        if (p->writer == NULL)
            return PASS_FAILED;
    }
    if (!p->known)
        ntp_tally_clear(p->w->tally);
    const ntp_const_image view = ntp_image_as_const(&p->s.view);
    ntp_rect area;
    int more;
    while ((more = source_next(&p->s, &area, error)) > 0) {
        const ntp_rect seen = { area.x0, area.y0, area.x1, one_row_tells(p) ? 1 : area.y1 };
        const bool skip = p->known || seen.y0 >= seen.y1;
        const ntp_status status =
            skip ? NTP_OK : ntp_tally_add(p->w->tally, &view, p->touch, &seen);
        if (status != NTP_OK)
            library_error(&p->s, status, error);
        if (status != NTP_OK || !p->m->rows(p, &area, error))
            return PASS_FAILED;
        if (p->probing && p->changes)
            return PASS_CHANGES;
    }
    return more == 0 ? PASS_DONE : PASS_UNREADABLE;
}

static outcome refuse(const production *p, ntpio_error *error)
{
    text t = { 0 };
    text_name(&t, p->in->path);
    text_add(&t, ": ");
    question_refusal(&t, p);
    snprintf(error->message, sizeof error->message, "%.500s", text_string(&t));
    text_free(&t);
    const bool told = p->in->named || p->in->hinted || has_tangent_normals(&p->f, true);
    return p->f.counts && told ? REFUSED : SKIPPED;
}

/* Refuses a file of which something is not known that the verb needs. */
static outcome ask(production *p, ntpio_error *error)
{
    text t = { 0 };
    text_name(&t, p->in->path);
    text_add(&t, ": ");
    const bool known = p->m->knows == NULL || p->m->knows(p, &t);
    if (!known)
        snprintf(error->message, sizeof error->message, "%.500s", text_string(&t));
    text_free(&t);
    return known ? MADE : p->f.counts ? REFUSED : SKIPPED;
}

static outcome end_of(pass_end end)
{
    return end == PASS_UNREADABLE ? UNREADABLE : FAILED;
}

/* Sets the view of the class in the facts.  A gray file of one color becomes RGB. */
static void view_as_known(production *p)
{
    const bool gray = p->s.info->channels < 3 && p->f.encoding == NTP_ENCODING_HEIGHT;
    if (gray && p->f.type.type == NTP_CLASS_ONE_COLOR && p->m->plan != PLAN_AS_TOLD)
        source_view_as_rgb(&p->s, NTP_ENCODING_STANDARD);
    else
        p->s.view.encoding = p->f.encoding;
}

/* Undoes the accident of the facts, and finds out what the file is then.  It is undone in all later
 * passes. */
static outcome know_undone(production *p, ntpio_error *error)
{
    const ntp_classification before = p->f.type;
    const bool counts = p->f.counts;
    const undo_kind kind = undo_kind_of(&p->f);
    ntpio_abort(p->writer);
    p->writer = NULL;
    facts_free(&p->f);
    if (!source_rewind(&p->s, error))
        return UNREADABLE;
    undo_begin(&p->undone, &p->s, kind, before.confidence);
    if (!examine_as_seen(&p->s, NTP_CLASS_STANDARD, &p->f, error))
        return UNREADABLE;
    p->f.forced = false;
    p->f.counts = counts;
    p->f.type.confidence = before.confidence;
    p->known = true;
    p->touch = 0;
    return source_rewind(&p->s, error) ? MADE : UNREADABLE;
}

/* Reads the file once, so that the facts are known when the rows are made. */
static outcome know_first(production *p, ntpio_error *error)
{
    source_keep(&p->s);
    if (p->m->finds_green)
        green_seek(&p->s);
    if (!examine(&p->s, p->forced, &p->f, error))
        return UNREADABLE;
    const answer found = question(p);
    if (found != ANSWER_WORK)
        return found == ANSWER_UNDO ? know_undone(p, error) : refuse(p, error);
    p->known = true;
    p->touch = touch_for(&p->f.stats, p->f.encoding);
    view_as_known(p);
    const bool later = p->m->plan == PLAN_AFTER_READING;
    const outcome known = later ? MADE : ask(p, error);
    return known != MADE ? known : source_rewind(&p->s, error) ? MADE : UNREADABLE;
}

/* After all rows were read, when the facts are known. */
static outcome finish(production *p, ntpio_error *error)
{
    const outcome known = p->m->plan == PLAN_AFTER_READING ? ask(p, error) : MADE;
    return known != MADE ? known : p->m->finish == NULL || p->m->finish(p, error) ? MADE : FAILED;
}

/*
 * Makes the output, on the supposition that the view is right, and again if it was not.  On return
 * the writer has the whole output, unless nothing is written.
 */
static outcome speculate(production *p, bool writes, ntpio_error *error)
{
    for (;;) {
        const pass_end end = run_pass(p, writes, error);
        if (end == PASS_CHANGES)
            return MADE;
        if (end != PASS_DONE)
            return end_of(end);
        if (p->known)
            return finish(p, error);
        if (!facts_from_tally(&p->f, &p->s, p->forced, error))
            return UNREADABLE;
        const answer answered = question(p);
        if (answered == ANSWER_REFUSE)
            return refuse(p, error);
        if (answered == ANSWER_UNDO) {
            const outcome undone = know_undone(p, error);
            if (undone != MADE)
                return undone;
            continue;
        }
        const outcome known = p->m->plan == PLAN_WHILE_READING ? ask(p, error) : MADE;
        if (known != MADE)
            return known;
        const uint32_t touch = touch_for(&p->f.stats, p->f.encoding);
        const bool same_touch = touch == p->touch || p->f.stats.transparent == 0;
        const bool same = p->f.encoding == p->s.view.encoding && same_touch;
        if (p->m->plan == PLAN_AS_TOLD || (same && (p->m->holds == NULL || p->m->holds(p))))
            return finish(p, error);
        ntpio_abort(p->writer);
        p->writer = NULL;
        if (!same && (p->s.view.type != NTP_TYPE_U8 || !same_touch)) {
            facts_free(&p->f);
            const outcome first = source_rewind(&p->s, error) ? know_first(p, error) : UNREADABLE;
            if (first != MADE)
                return first;
        } else {
            p->known = true;
            p->s.view.encoding = p->f.encoding;
            if (!source_rewind(&p->s, error))
                return UNREADABLE;
        }
    }
}

/* What went to standard output or to a pipe cannot be taken back. */
static bool can_be_dropped(const char *output)
{
    os_file found;
    return strcmp(output, "-") != 0 && (!os_look(output, &found) || found.kind == OS_REGULAR);
}

/*
 * Is an output without changes a copy of its input?  Then its packing and its other chunks stay; only
 * color chunks are left out.  Who gives a level wants the file packed by it.
 */
static bool is_copied(const production *p)
{
    const ntpio_info *info = p->s.info;
    return p->m->o->verb_bit == V_CLEAN && p->in->output != NULL && !is_dry_run(p->m) &&
           !needs_change(p->m) && !option_given(p->m->o, OPT_LEVEL) && info->format == NTPIO_PNG &&
           format_of(p, p->in->output, info->sample_bytes) == NTPIO_PNG;
}

static outcome copy_input(const production *p, ntpio_error *error)
{
    const ntpio_info *info = p->s.info;
    const ntpio_write_options how = { .read_path = p->s.in->path,
                                      .read_stamp = info->stamp,
                                      .without_color = info->has_gama || info->has_srgb ||
                                                       info->has_iccp || info->has_chrm ||
                                                       info->has_cicp };
    return prepare_place(p, p->in->output, error) &&
                   ntpio_copy(p->in->output, p->s.bytes, p->s.size, &how, error)
               ? MADE
               : FAILED;
}

/* No sample changed; nor does a copy show gray as RGB, or the like. */
static bool stays(const production *p, bool copied)
{
    return !p->changes && !(copied && p->s.mapped);
}

/* Makes the output as far as its first change, without writing it: *unchanged says that there is none. */
static outcome probe(production *p, bool copied, bool *unchanged, ntpio_error *error)
{
    p->probing = true;
    const outcome done = speculate(p, false, error);
    p->probing = false;
    *unchanged = done == MADE && stays(p, copied);
    if (done != MADE || *unchanged)
        return done;
    return source_rewind(&p->s, error) ? MADE : UNREADABLE;
}

static outcome make_as_known(production *p, ntpio_error *error)
{
    const maker *m = p->m;
    const bool gray = p->s.info->channels < 3 && p->forced < 0;
    first_view(&p->s, p->forced);
    outcome done = MADE;
    const bool dry_run = is_dry_run(m), only_changed = needs_change(m);
    const bool final = !dry_run && !can_be_dropped(p->in->output);
    /* Rows that are held cost little to read twice; rows that were packed in vain cost much. */
    const bool may_fail = m->plan == PLAN_WHILE_READING && m->holds != NULL;
    const bool twice = gray || final || (may_fail && ntpio_rewind(p->s.reader));
    if (m->plan == PLAN_MEASURE_FIRST || (m->plan != PLAN_AS_TOLD && twice))
        done = know_first(p, error);
    if (done != MADE)
        return done;
    const bool copied = is_copied(p), cheap = final || ntpio_rewind(p->s.reader);
    if ((only_changed && !dry_run) || (copied && cheap)) {
        bool unchanged = false;
        done = probe(p, copied, &unchanged, error);
        if (done != MADE)
            return done;
        if (unchanged)
            return copied ? copy_input(p, error) : UNCHANGED;
    }
    ntpio_error never = { 0 };
    const bool writes = !dry_run && p->in->outside == NULL && !replaces_original(p, &never);
    done = speculate(p, writes, error);
    if (done == MADE && only_changed && !p->changes && !writes)
        return UNCHANGED;
    if (done == MADE && (leads_out(p, error) || replaces_original(p, error)))
        return FAILED;
    if (done != MADE || dry_run)
        return done;
    ntpio_writer *writer = p->writer;
    p->writer = NULL;
    if ((only_changed || copied) && stays(p, copied)) {
        ntpio_abort(writer); /* there was no probe, or it had supposed another class */
        return copied ? copy_input(p, error) : UNCHANGED;
    }
    source_close_file(&p->s);
    return ntpio_commit(writer, error) ? MADE : FAILED;
}

/* Does a verb that takes heights get normals? */
static outcome ask_for_heights(production *p, ntpio_error *error)
{
    if (!question_is_of_heights(p))
        return MADE;
    if (!examine(&p->s, -1, &p->f, error))
        return UNREADABLE;
    const bool fit = !question_finds_normals(&p->f);
    const outcome done = fit ? MADE : refuse(p, error);
    facts_free(&p->f);
    return !fit ? done : source_rewind(&p->s, error) ? MADE : UNREADABLE;
}

/* Finds out how a picture of an object stores its normals. */
static outcome ask_about_object(production *p, ntpio_error *error)
{
    if (!p->m->of_objects || p->forced >= 0)
        return MADE;
    if (!examine(&p->s, -1, &p->f, error))
        return UNREADABLE;
    const ntp_class found = p->f.type.type;
    const bool other = found == NTP_CLASS_ZZERO || found == NTP_CLASS_XY;
    const bool refused = question_is_no_object(p) && !option_given(p->m->o, OPT_FORCE);
    p->forced = (int) (other && question_finds_normals(&p->f) ? found : NTP_CLASS_STANDARD);
    const outcome done = refused ? refuse(p, error) : MADE;
    facts_free(&p->f);
    return refused ? done : source_rewind(&p->s, error) ? MADE : UNREADABLE;
}

outcome make_output(production *p, ntpio_error *error)
{
    p->forced = p->m->forced;
    if (!may_stay(p) && replaces_original(p, error))
        return FAILED;
    outcome asked = ask_for_heights(p, error);
    if (asked == MADE)
        asked = ask_about_object(p, error);
    if (asked != MADE)
        return asked;
    const outcome done = make_as_known(p, error);
    if (done != REFUSED || !option_given(p->m->o, OPT_FORCE))
        return done;
    ntpio_abort(p->writer);
    p->writer = NULL;
    facts_free(&p->f);
    p->known = false;
    p->forced = NTP_CLASS_STANDARD;
    return source_rewind(&p->s, error) ? make_as_known(p, error) : UNREADABLE;
}
