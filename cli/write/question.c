/* SPDX-License-Identifier: MIT */
/*
 * question.c - what every verb that writes asks first
 */
#include "write/question.h"

#include "write/refusal.h"

/* From here on an accident is undone without being asked to; `ntp check` calls it sure, too. */
static const double SURE = 0.9;

static bool undoes(const production *p)
{
    return p->m->o->verb_bit == V_CLEAN;
}

/* Is the file of a class that the verb works on? */
static bool is_of_class(const production *p)
{
    const bool takes = p->m->takes_heights && p->f.type.type == NTP_CLASS_HEIGHT;
    if (p->m->plan == PLAN_AS_TOLD || takes)
        return p->f.forced || p->f.counts;
    return has_tangent_normals(&p->f, p->m->any_order);
}

/* The accident that is in the way.  A heatmap shows accidents, and --type says that there is none,
 * unless --undo asks for it. */
static undo_kind accident_of(const production *p)
{
    const bool asked = undoes(p) && option_given(p->m->o, OPT_UNDO);
    if (p->m->plan == PLAN_AS_TOLD || p->m->o->verb_bit == V_HEATMAP || p->undone.kind != 0 ||
        (p->f.forced && !asked))
        return UNDO_NOTHING;
    return undo_kind_of(&p->f);
}

static bool may_undo(const production *p, undo_kind kind)
{
    const bool sure = p->f.type.confidence >= SURE && !p->f.forced;
    return undoes(p) && undo_is_possible(kind, p->s.info) &&
           (sure || option_given(p->m->o, OPT_UNDO));
}

answer question(const production *p)
{
    if (!is_of_class(p))
        return ANSWER_REFUSE;
    const undo_kind kind = accident_of(p);
    /* ntp clean mirrors negative z anyhow. */
    if (kind == UNDO_NOTHING || (kind == UNDO_BLUE && undoes(p) && !may_undo(p, kind)))
        return ANSWER_WORK;
    return may_undo(p, kind) ? ANSWER_UNDO : ANSWER_REFUSE;
}

static void add_accident(text *t, undo_kind kind, double confidence, bool possible)
{
    text_addf(t, "%s (%.0f %% sure); ", undo_title(kind), 100 * confidence);
    if (possible)
        text_add(t, "ntp clean --undo puts that right, ");
    text_add(t, "--type standard or --force takes the file as it is");
}

bool question_is_of_heights(const production *p)
{
    const options *o = p->m->o;
    return o->verb_bit == V_FROM_HEIGHT && p->s.info->channels >= 3 &&
           !option_given(o, OPT_SOURCE) && !option_given(o, OPT_FORCE);
}

bool question_finds_normals(const facts *f)
{
    return class_is_normals(f->type.type) && f->type.confidence >= SURE;
}

bool question_is_no_object(const production *p)
{
    const ntp_classification *found = &p->f.type;
    return found->confidence >= SURE &&
           (found->type == NTP_CLASS_HEIGHT || found->type == NTP_CLASS_NOT_NORMALS ||
            accident_of(p) != UNDO_NOTHING);
}

void question_refusal(text *t, const production *p)
{
    if (question_is_of_heights(p)) {
        text_addf(t,
                  "it holds normals already (%s, %.0f %% sure), not heights; --source says which "
                  "channel is a height, and --force takes the first",
                  class_title(p->f.type.type), 100 * p->f.type.confidence);
        return;
    }
    const option_spec *row = option_row(OPT_TYPE, p->m->o->verb_bit);
    const undo_kind kind = accident_of(p);
    if (is_of_class(p) && kind != UNDO_NOTHING)
        add_accident(t, kind, p->f.type.confidence, undo_is_possible(kind, p->s.info));
    else
        add_refusal(t, &p->f, p->f.counts && row != NULL ? row->name : NULL);
}

bool question_detail(text *t, const facts *f)
{
    const undo_kind kind = f->forced ? UNDO_NOTHING : undo_kind_of(f);
    const bool fit = has_tangent_normals(f, false);
    if (t != NULL && !fit)
        add_refusal(t, f, "type");
    else if (t != NULL && kind != UNDO_NOTHING)
        add_accident(t, kind, f->type.confidence, undo_is_possible(kind, &f->info));
    return fit && kind == UNDO_NOTHING;
}
