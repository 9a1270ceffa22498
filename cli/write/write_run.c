/* SPDX-License-Identifier: MIT */
/*
 * write_run.c - what is reported about each file, and the run over all files
 */
#include "write/write_run.h"

#include <stdlib.h>
#include <string.h>

#include "report/report.h"
#include "write/make_output.h"

static const char *const OUTCOMES[] = { "ok", "ok", "skipped", "refused", "unreadable", "failed" };

typedef struct run {
    const maker *m;
    const input_list *inputs;
    size_t outcomes[FAILED + 1];
    size_t files;
    size_t foreign; /* unreadable files with the names of other formats */
    bool any;
} run;

/* ------------------------------------------------------------------------ reporting */

static void list_dropped(const ntpio_info *info, text *line, json_t *object)
{
    const struct {
        const char *name;
        bool there;
    } CHUNKS[] = { { "gAMA", info->has_gama },
                   { "sRGB", info->has_srgb },
                   { "iCCP", info->has_iccp },
                   { "cHRM", info->has_chrm },
                   { "cICP", info->has_cicp } };
    json_t *list = need(json_array());
    for (size_t i = 0; i < sizeof CHUNKS / sizeof CHUNKS[0]; i++) {
        if (!CHUNKS[i].there)
            continue;
        json_array_append_new(list, json_string(CHUNKS[i].name));
        if (line != NULL)
            text_addf(line, "%s%s", json_array_size(list) > 1 ? ", " : "  note: left out ",
                      CHUNKS[i].name);
    }
    if (line != NULL && json_array_size(list) > 0)
        text_add(line, " (normals are numbers, not colors)\n");
    if (object != NULL)
        json_object_set_new(object, "dropped", list);
    else
        json_decref(list);
}

static void tell_json(const production *p, outcome done, const ntpio_error *error, result *r)
{
    const char *message = done == MADE || done == UNCHANGED ? NULL : error->message;
    json_t *object = json_file(p->in, OUTCOMES[done], message);
    const bool written = done == MADE && !is_dry_run(p->m);
    if (p->in->output != NULL && done == MADE)
        json_set_name(object, "output", p->in->output);
    else
        json_object_set_new(object, "output", json_null());
    json_object_set_new(object, "written", json_boolean(written));
    if (done == MADE || done == UNCHANGED) {
        json_object_set_new(object, "type", json_string(ntp_class_name(p->f.type.type)));
        json_object_set_new(object, "confidence", json_angle(p->f.type.confidence));
        p->m->describe(p, NULL, object);
        list_dropped(&p->f.info, NULL, object);
    }
    json_item(&r->out, object);
}

static void warn_quietly(const production *p, result *r)
{
    text words = { 0 };
    p->m->warn(p, &words);
    if (words.size > 0) {
        text_add(&r->err, "ntp: ");
        text_name(&r->err, p->in->path);
        text_addf(&r->err, ": %s\n", text_string(&words));
    }
    text_free(&words);
}

static void tell_text(const production *p, outcome done, const ntpio_error *error, result *r)
{
    const bool quiet = option_given(p->m->o, OPT_QUIET);
    if (done == SKIPPED && !quiet && option_given(p->m->o, OPT_VERBOSE))
        text_addf(&r->out, "%s: left out\n", error->message);
    if (done != MADE && done != UNCHANGED)
        return;
    if (quiet && p->m->warn != NULL)
        warn_quietly(p, r);
    if (quiet)
        return;
    text_name(&r->out, p->in->path);
    if (done == MADE && p->in->output != NULL && !is_in_place(p->m)) {
        text_add(&r->out, " -> ");
        text_name(&r->out, p->in->output);
    }
    text_add(&r->out, ": ");
    p->m->describe(p, &r->out, NULL);
    if (done == UNCHANGED)
        text_add(&r->out, ", not written");
    else if (is_dry_run(p->m))
        text_add(&r->out, " (dry run)");
    text_char(&r->out, '\n');
    if (done == MADE && !is_dry_run(p->m))
        list_dropped(&p->f.info, &r->out, NULL);
}

static unsigned ran_of(outcome done, const ntpio_error *error)
{
    if (done == REFUSED)
        return RAN_FINDINGS;
    if (done == FAILED && error->status == NTPIO_ERR_USAGE)
        return RAN_USAGE;
    return done == UNREADABLE || done == FAILED ? RAN_FAILED : 0;
}

static void work(void *context, worker *w, const input *in, result *r)
{
    const run *all = context;
    const maker *m = all->m;
    production p = {
        .m = m, .in = in, .inputs = all->inputs, .w = w, .state = need(calloc(1, m->state_size))
    };
    ntpio_error error = { 0 };
    ntpio_limits limits = limits_from(m->o);
    limits.regular_only = is_in_place(m); /* nothing else can be replaced */
    outcome done = UNREADABLE;
    if (source_open(&p.s, w, in, &limits, &error)) {
        p.s.read_permille = m->read_permille;
        done = make_output(&p, &error);
        ntpio_abort(p.writer);
    }
    const bool interrupted = interrupted_by != 0 && (done == UNREADABLE || done == FAILED);
    if (!interrupted) {
        r->ran |= ran_of(done, &error);
        if (option_integer(m->o, OPT_FORMAT) == 1)
            tell_json(&p, done, &error, r);
        else
            tell_text(&p, done, &error, r);
        if (done >= REFUSED)
            text_addf(&r->err, "ntp: %s\n", error.message);
    }
    source_close(&p.s);
    facts_free(&p.f);
    int *kept = need(malloc(sizeof *kept));
    *kept = (int) done;
    r->data = kept;
    free(p.state);
}

/* ------------------------------------------------------------------------- the run */

static void deliver(void *context, const input *in, result *r)
{
    run *all = context;
    int *done = r->data;
    all->files++;
    all->outcomes[*done]++;
    all->foreign += *done == (int) UNREADABLE && in->foreign;
    free(done);
    if (option_integer(all->m->o, OPT_FORMAT) == 1)
        json_begin_list(&r->out, &all->any);
}

static void end_run(const run *all)
{
    const size_t *n = all->outcomes;
    const size_t bad = n[UNREADABLE] + n[FAILED];
    text t = { 0 };
    if (option_integer(all->m->o, OPT_FORMAT) == 1) {
        json_t *summary = need(json_object());
        json_object_set_new(summary, "files", json_integer((json_int_t) all->files));
        json_object_set_new(summary, "written",
                            json_integer(is_dry_run(all->m) ? 0 : (json_int_t) n[MADE]));
        json_object_set_new(summary, "unchanged", json_integer((json_int_t) n[UNCHANGED]));
        json_object_set_new(summary, "skipped", json_integer((json_int_t) n[SKIPPED]));
        json_object_set_new(summary, "refused", json_integer((json_int_t) n[REFUSED]));
        json_object_set_new(summary, "failed", json_integer((json_int_t) bad));
        json_object_set_new(summary, "unsupported", json_integer((json_int_t) all->foreign));
        json_end(&t, summary);
    } else if (all->files > 1 && !option_given(all->m->o, OPT_QUIET)) {
        text_addf(&t, "\n%zu files: %zu %s", all->files, n[MADE],
                  is_dry_run(all->m) ? "would be written" : "written");
        if (n[UNCHANGED] > 0)
            text_addf(&t, ", %zu unchanged", n[UNCHANGED]);
        if (n[SKIPPED] > 0)
            text_addf(&t, ", %zu left out (no normals)", n[SKIPPED]);
        if (n[REFUSED] > 0)
            text_addf(&t, ", %zu refused", n[REFUSED]);
        if (bad > 0)
            text_addf(&t, ", %zu failed", bad);
        if (all->foreign > 0)
            text_addf(&t, " (%zu of formats that are not read)", all->foreign);
        text_char(&t, '\n');
    }
    output_text(&t);
    text_free(&t);
}

int produce(const maker *m)
{
    input_list inputs;
    run all = { .m = m, .inputs = &inputs };
    if (!inputs_collect(&inputs, m->o))
        return NTP_EXIT_USAGE;
    if (!outputs_plan(&inputs, m->o)) {
        inputs_free(&inputs);
        return NTP_EXIT_USAGE;
    }
    const char *output = option_string(m->o, OPT_OUTPUT);
    if (output != NULL && strcmp(output, "-") == 0)
        output_to_stderr();
    if (option_integer(m->o, OPT_FORMAT) == 1) {
        text t = { 0 };
        json_begin(&t);
        output_text(&t);
        text_free(&t);
    }
    const batch b = { .inputs = &inputs,
                      .jobs = (int) option_integer(m->o, OPT_JOBS),
                      .show_progress = progress_wanted(m->o),
                      .context = &all,
                      .work = work,
                      .deliver = deliver };
    unsigned ran = batch_run(&b);
    if (inputs.count == 0 && !option_given(m->o, OPT_ALLOW_EMPTY))
        ran |= RAN_FAILED;
    end_run(&all);
    inputs_free(&inputs);
    return exit_code(ran);
}
