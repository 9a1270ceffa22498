/* SPDX-License-Identifier: MIT */
/*
 * rules.c - from the facts of a file to its findings
 *
 * Every rule is a function that looks at the facts and may add a finding.  Shares are of the used
 * texels.  Counts in reports are of all texels.  The rules stand in class_rules.c, texel_rules.c
 * and file_rules.c.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "findings/judgement.h"

judge_rules judge_rules_from(const options *o)
{
    return (judge_rules) {
        .strict = option_integer(o, OPT_POLICY) == 1,
        .max_angle = option_number(o, OPT_MAX_ANGLE),
        .verdict = (ntp_verdict) option_integer(o, OPT_VERDICT),
        .keep_negative_z = option_given(o, OPT_KEEP_NEGATIVE_Z),
        .max_fail = option_number(o, OPT_MAX_FAIL),
        .max_tilt = option_number(o, OPT_MAX_TILT),
        .y = (int) option_integer(o, OPT_Y),
    };
}

void add_finding(judgement *j, finding_id id, finding_level level, uint64_t count, const text *t)
{
    finding *next = &j->list->at[j->list->count++];
    *next = (finding) { .id = id, .level = level, .count = count };
    snprintf(next->message, sizeof next->message, "%s", text_string(t));
}

void addf(judgement *j, finding_id id, finding_level level, uint64_t count, const char *format, ...)
{
    char message[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    text t = { 0 };
    text_add(&t, message);
    add_finding(j, id, level, count, &t);
    text_free(&t);
}

bool is_judged(const facts *f)
{
    return f->encoding != NTP_ENCODING_HEIGHT &&
           (class_is_tangent(f->type.type) || f->type.type == NTP_CLASS_ONE_COLOR);
}

uint64_t judged_texels(const facts *f)
{
    return counts_judged(&f->stats);
}

bool failing_texels(const facts *f, ntp_verdict verdict, bool keep_negative_z, uint64_t *all,
                    uint64_t *used)
{
    if (!is_judged(f))
        return false;
    counts_failing(&f->stats, f->encoding, verdict, keep_negative_z, all, used);
    return true;
}

void add_share(const judgement *j, text *t, uint64_t count)
{
    text_percent(t, count, j->used);
    text_add(t, j->f->stats.unused + j->f->stats.padding > 0 ? " of the used texels ("
                                                             : " of the texels (");
    text_count(t, count);
    text_char(t, ')');
}

finding_level level_of_share(const judgement *j, uint64_t count)
{
    const double percent = j->used == 0 ? 0 : 100.0 * (double) count / (double) j->used;
    return percent > j->rules->max_fail ? LEVEL_ERROR : LEVEL_WARNING;
}

finding_level level_of_harm(const judgement *j, const ntp_harm *harm)
{
    return counts_level(harm, j->used, j->rules->max_angle, j->rules->max_fail);
}

finding_level level_of_cause(const judgement *j)
{
    const bool harmless =
        !j->rules->strict && level_of_harm(j, &j->f->harm[HARM_LENGTH]) == LEVEL_INFO;
    return harmless ? LEVEL_INFO : LEVEL_WARNING;
}

/* The color chunks of NT040 are listed with a blank after each; the last one goes. */
static void tidy(finding_list *list)
{
    for (size_t i = 0; i < list->count; i++) {
        char *blank = strstr(list->at[i].message, " )");
        if (blank != NULL)
            memmove(blank, blank + 1, strlen(blank));
    }
}

static bool heavier(const finding *a, const finding *b)
{
    return a->level != b->level ? a->level > b->level : a->id < b->id;
}

static void sort(finding_list *list)
{
    for (size_t i = 1; i < list->count; i++) {
        const finding moved = list->at[i];
        size_t k = i;
        for (; k > 0 && heavier(&moved, &list->at[k - 1]); k--)
            list->at[k] = list->at[k - 1];
        list->at[k] = moved;
    }
}

/* In a directory a file that only its content makes a normals texture may be none. */
static void make_notes(finding_list *list)
{
    for (size_t i = 0; i < list->count; i++)
        list->at[i].level = LEVEL_INFO;
}

finding_level worst_if_named(const finding_list *list)
{
    finding_level worst = LEVEL_INFO;
    for (size_t i = 0; i < list->count; i++) {
        const finding *one = &list->at[i];
        if (!one->known && one->if_named > worst)
            worst = one->if_named;
    }
    return worst;
}

static void keep_levels(finding_list *list)
{
    for (size_t i = 0; i < list->count; i++)
        list->at[i].if_named = list->at[i].level;
}

void judge(finding_list *list, const facts *f, const judge_rules *rules)
{
    list->count = 0;
    if (!f->counts)
        return;
    judgement j = { list, f, rules, judged_texels(f) };
    judge_class(&j);
    judge_accidents(&j);
    if (is_judged(f) && j.used > 0 && !has_misplaced_channels(f))
        judge_texels(&j);
    judge_file(&j);
    keep_levels(list);
    if (!f->in->named && !f->in->hinted)
        make_notes(list);
    tidy(list);
    sort(list);
}
