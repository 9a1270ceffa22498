/* SPDX-License-Identifier: MIT */
/*
 * verb_check.c - ntp check: what textures are, and whether they are well formed
 */
#include <stdlib.h>
#include <string.h>

#include "report/baseline.h"
#include "report/report.h"
#include "run/jobs.h"
#include "surface/exchange.h"
#include "surface/mips.h"
#include "surface/surface.h"
#include "verbs/verbs.h"

typedef enum check_format { FORMAT_TEXT, FORMAT_JSON, FORMAT_CSV, FORMAT_LIST } check_format;

enum { DEEP_READ_PERMILLE = 250 }; /* of the work that the first reading is */

typedef struct check {
    const options *o;
    check_settings settings;
    check_format format;
    int forced; /* class from --type, or -1 */
    ntpio_limits limits;
    baseline known;
    check_summary summary;
    bool any; /* a JSON item was printed */
} check;

/* ------------------------------------------------------------------------- one file */

/* Does the report have anything about the surface?  If not, it is not examined. */
static bool tells_of_surface(const check *c)
{
    return c->format == FORMAT_JSON || (c->format == FORMAT_TEXT && c->settings.verbose);
}

static void examine_file(const check *c, worker *w, const input *in, checked *done)
{
    source s;
    if (!source_open(&s, w, in, &c->limits, &done->error))
        return;
    const bool deep = option_given(c->o, OPT_DEEP);
    const int y = c->settings.rules.y - 1;
    s.orient = deep ? ORIENT_EVERY_ROW : ORIENT_SAMPLED;
    s.max_angle = c->settings.rules.max_angle;
    const bool of_gpus = s.info->layout[0] != 0;
    s.keep_middle = deep || tells_of_surface(c) || of_gpus;
    if (deep)
        s.read_permille = DEEP_READ_PERMILLE;
    done->readable = examine(&s, c->forced, &done->f, &done->error);
    if (done->readable && (deep || of_gpus))
        exchange_look(&s, &done->f);
    if (done->readable && deep)
        done->readable = surface_look_deeper(&s, &done->f, y, &done->error);
    else if (done->readable && tells_of_surface(c))
        surface_look(&s, &done->f, y);
    if (done->readable && of_gpus)
        done->readable = mips_look(&s, &done->f, &done->error);
    source_close(&s);
    if (!done->readable)
        return;
    judge(&done->list, &done->f, &c->settings.rules);
    baseline_mark(&c->known, in, &done->list);
    for (size_t i = 0; i < done->list.count; i++) {
        const finding *one = &done->list.at[i];
        done->fails |= !one->known && one->level >= c->settings.fail_level;
    }
}

static void render(const check *c, const input *in, const checked *done, result *r)
{
    switch (c->format) {
    case FORMAT_TEXT:
        check_text(&r->out, in, done, &c->settings);
        break;
    case FORMAT_JSON:
        json_item(&r->out, check_json(in, done, &c->settings));
        break;
    case FORMAT_CSV:
        check_csv(&r->out, in, done, &c->settings);
        break;
    case FORMAT_LIST:
        if (done->fails) {
            text_add(&r->out, in->path);
            text_char(&r->out, c->settings.nul ? 0 : '\n');
        }
        break;
    }
    if (!done->readable)
        text_addf(&r->err, "ntp: %s\n", done->error.message);
}

static void work(void *context, worker *w, const input *in, result *r)
{
    const check *c = context;
    checked *done = need(calloc(1, sizeof *done));
    r->data = done;
    examine_file(c, w, in, done);
    if (interrupted_by != 0 && !done->readable)
        return;
    if (!done->readable)
        r->ran |= RAN_FAILED;
    if (done->fails && !c->settings.fail_never)
        r->ran |= RAN_FINDINGS;
    render(c, in, done, r);
}

static void count(check_summary *sum, const input *in, const checked *done)
{
    sum->files++;
    if (!done->readable) {
        sum->unreadable++;
        sum->foreign += in->foreign;
        return;
    }
    sum->by_class[done->f.type.type]++;
    sum->failing += done->fails;
    if (!done->f.counts) {
        sum->left_out++;
        return;
    }
    int worst = LEVEL_INFO, worst_known = LEVEL_INFO;
    for (size_t i = 0; i < done->list.count; i++) {
        const finding *one = &done->list.at[i];
        if (one->known) {
            sum->known++;
            worst_known = (int) one->level > worst_known ? (int) one->level : worst_known;
            continue;
        }
        sum->found[one->id]++;
        sum->notes += one->level == LEVEL_INFO;
        worst = (int) one->level > worst ? (int) one->level : worst;
    }
    sum->worst[worst]++;
    sum->only_known += worst == LEVEL_INFO && worst_known > LEVEL_INFO;
    const bool possible = worst_if_named(&done->list) > LEVEL_INFO;
    sum->possible += worst == LEVEL_INFO && worst_known == LEVEL_INFO && possible;
    sum->well_formed += worst == LEVEL_INFO && worst_known == LEVEL_INFO && !possible;
}

static void deliver(void *context, const input *in, result *r)
{
    check *c = context;
    checked *done = r->data;
    count(&c->summary, in, done);
    facts_free(&done->f);
    free(done);
    if (c->format == FORMAT_JSON)
        json_begin_list(&r->out, &c->any);
}

static void begin(const check *c)
{
    text t = { 0 };
    if (c->format == FORMAT_JSON)
        json_begin(&t);
    else if (c->format == FORMAT_CSV)
        check_csv_header(&t);
    output_text(&t);
    text_free(&t);
}

static void end(const check *c)
{
    text t = { 0 };
    if (c->format == FORMAT_JSON)
        json_end(&t, check_json_summary(&c->summary, &c->settings));
    else if (c->format == FORMAT_TEXT)
        check_text_summary(&t, &c->summary, &c->settings);
    output_text(&t);
    text_free(&t);
}

/* A check of the wrong directory must not pass for a good one. */
static unsigned nothing_checked(const check *c)
{
    const check_summary *sum = &c->summary;
    if (sum->files > sum->left_out || interrupted_by != 0 || option_given(c->o, OPT_ALLOW_EMPTY))
        return 0;
    if (sum->files > 0)
        complain("nothing was checked: of %zu image%s, none is a normals texture by name or "
                 "content; --allow-empty allows that",
                 sum->files, sum->files == 1 ? "" : "s");
    return RAN_FAILED;
}

int check_run(const options *o)
{
    static const finding_level FAIL_ON[] = { LEVEL_ERROR, LEVEL_WARNING, LEVEL_ERROR };
    const int64_t fail_on = option_integer(o, OPT_FAIL_ON);
    input_list inputs;
    check c = { .o = o,
                .format = (check_format) option_integer(o, OPT_FORMAT),
                .forced = forced_class(o),
                .limits = limits_from(o),
                .settings = { .rules = judge_rules_from(o),
                              .fail_level = FAIL_ON[fail_on],
                              .fail_never = fail_on == 2,
                              .colors = colors_wanted(o),
                              .quiet = option_given(o, OPT_QUIET),
                              .verbose = option_given(o, OPT_VERBOSE),
                              .nul = option_given(o, OPT_NUL) } };
    c.limits.one_pass = true;
    if (!baseline_read(&c.known, option_string(o, OPT_BASELINE)))
        return NTP_EXIT_USAGE;
    if (!inputs_collect(&inputs, o)) {
        baseline_free(&c.known);
        return NTP_EXIT_USAGE;
    }
    const batch b = { .inputs = &inputs,
                      .jobs = (int) option_integer(o, OPT_JOBS),
                      .show_progress = progress_wanted(o),
                      .reads_only = true,
                      .context = &c,
                      .work = work,
                      .deliver = deliver };
    begin(&c);
    unsigned ran = batch_run(&b);
    end(&c);
    ran |= nothing_checked(&c);
    inputs_free(&inputs);
    baseline_free(&c.known);
    return exit_code(ran);
}
