/* SPDX-License-Identifier: MIT */
/*
 * report_text.c - what `ntp check` prints for people, and its CSV
 *
 * Each file has a headline; its findings follow, indented, the worst first.  -v adds notes (level
 * info), reasons and statistics.
 */
#include <stdlib.h>
#include <string.h>

#include "options/names.h"
#include "os/console.h"
#include "report/report.h"

bool colors_wanted(const options *o)
{
    const int64_t choice = option_integer(o, OPT_COLOR);
    const char *no = getenv("NO_COLOR"), *force = getenv("CLICOLOR_FORCE");
    if (choice != 0)
        return choice == 1;
    if (no != NULL && no[0] != 0)
        return false;
    if (force != NULL && force[0] != 0 && strcmp(force, "0") != 0)
        return true;
    const char *terminal = getenv("TERM");
    return os_output_is_terminal() && (terminal == NULL || strcmp(terminal, "dumb") != 0);
}

void text_paint(text *t, bool colors, paint p, const char *words)
{
    static const char *const CODES[] = { "", "1", "31", "33", "36", "32" };
    if (colors && p != PAINT_NONE)
        text_addf(t, "\033[%sm%s\033[0m", CODES[p], words);
    else
        text_add(t, words);
}

static size_t count_level(const checked *c, finding_level level)
{
    size_t count = 0;
    for (size_t i = 0; i < c->list.count; i++)
        count += !c->list.at[i].known && c->list.at[i].level == level;
    return count;
}

/* Warnings and errors that are in the baseline. */
static size_t count_known(const checked *c)
{
    size_t count = 0;
    for (size_t i = 0; i < c->list.count; i++)
        count += c->list.at[i].known && c->list.at[i].level > LEVEL_INFO;
    return count;
}

static void add_number_of(text *t, size_t count, const char *thing)
{
    text_addf(t, "%zu %s%s", count, thing, count == 1 ? "" : "s");
}

/* What a file without warnings and errors is called.  Lengths can be wrong by so little that it is
 * only a note. */
static const char *praise(const checked *c)
{
    const bool normals = class_is_normals(c->f.type.type) || c->f.type.type == NTP_CLASS_ONE_COLOR;
    for (size_t i = 0; i < c->list.count; i++) {
        const finding_id id = c->list.at[i].id;
        if (id == NT001 || id == NT002 || id == NT003)
            return "no visible errors";
    }
    return normals ? "well formed" : "ok";
}

/* Is a note something worse in a file with the name of normals?  Then the worst of these counts. */
static bool add_possible(text *t, const checked *c)
{
    const finding_level worst = worst_if_named(&c->list);
    size_t count = 0;
    for (size_t i = 0; i < c->list.count; i++)
        count += !c->list.at[i].known && c->list.at[i].if_named == worst;
    if (worst == LEVEL_INFO)
        return false;
    add_number_of(t, count, worst == LEVEL_ERROR ? "possible error" : "possible warning");
    text_add(t, " (not named as a normals texture)");
    return true;
}

static void add_verdict(text *t, const checked *c, const check_settings *s)
{
    const size_t errors = count_level(c, LEVEL_ERROR), warnings = count_level(c, LEVEL_WARNING);
    text words = { 0 };
    if (!c->f.counts) {
        text_add(t, "not judged");
        return;
    }
    if (errors > 0)
        add_number_of(&words, errors, "error");
    if (errors > 0 && warnings > 0)
        text_add(&words, ", ");
    if (warnings > 0)
        add_number_of(&words, warnings, "warning");
    const size_t known = count_known(c);
    if (known > 0)
        text_addf(&words, "%s%zu known", words.size > 0 ? ", " : "", known);
    const bool possible = words.size == 0 && add_possible(&words, c);
    if (words.size == 0)
        text_add(&words, praise(c));
    text_paint(t, s->colors,
               errors > 0                 ? PAINT_RED
               : warnings > 0 || possible ? PAINT_YELLOW
                                          : PAINT_GREEN,
               text_string(&words));
    text_free(&words);
}

static void add_headline(text *t, const input *in, const checked *c, const check_settings *s)
{
    static const char *const CHANNELS[] = { "", "gray", "gray and alpha", "RGB", "RGBA" };
    const facts *f = &c->f;
    text name = { 0 };
    text_name(&name, in->path);
    text_paint(t, s->colors, PAINT_BOLD, text_string(&name));
    text_free(&name);
    text_addf(t, ": %s", class_title(f->type.type));
    if (f->type.confidence < 0.9)
        text_addf(t, " (%.0f %% sure)", 100 * f->type.confidence);
    if (f->orientation.decided)
        text_addf(t, ", %s", y_title(f->orientation.y));
    if (f->orientation.decided && f->orientation.confidence < 0.9)
        text_addf(t, " (%.0f %% sure)", 100 * f->orientation.confidence);
    text_addf(t, ", %u x %u ", (unsigned) f->info.width, (unsigned) f->info.height);
    if (f->info.layout[0] != 0)
        text_addf(t, "%s: ", f->info.layout);
    else
        text_addf(t, "%d-bit %s%s: ", (int) f->info.bit_depth, f->info.palette ? "palette " : "",
                  CHANNELS[f->info.channels]);
    add_verdict(t, c, s);
    text_char(t, '\n');
}

static void add_findings(text *t, const checked *c, const check_settings *s)
{
    static const paint PAINTS[] = { PAINT_BLUE, PAINT_YELLOW, PAINT_RED };
    static const char *const LABELS[] = { "note   ", "warning", "error  " };
    for (size_t i = 0; i < c->list.count; i++) {
        const finding *one = &c->list.at[i];
        if (!s->verbose && (one->level == LEVEL_INFO || one->known))
            continue;
        text_add(t, "  ");
        text_paint(t, s->colors, PAINTS[one->level], LABELS[one->level]);
        text_addf(t, " %s  %s%s\n", FINDING_TABLE[one->id].id, one->message,
                  one->known ? " (in the baseline)" : "");
    }
}

static void add_count_line(text *t, const char *label, uint64_t count, uint64_t texels)
{
    text_addf(t, "    %-24s ", label);
    text_count(t, count);
    text_add(t, " (");
    text_percent(t, count, texels);
    text_add(t, ")\n");
}

/* " (its middle, 1024 x 1024)" where an area is not all of the texture. */
static void add_area(text *t, const facts *f, const ntp_rect *area)
{
    const ntp_rect *middle = &f->surface.area;
    const int32_t width = area->x1 - area->x0, height = area->y1 - area->y0;
    if ((uint32_t) width == f->info.width && (uint32_t) height == f->info.height)
        return;
    if (width == middle->x1 - middle->x0 && height == middle->y1 - middle->y0)
        text_addf(t, " (its middle, %d x %d)", (int) width, (int) height);
    else
        text_addf(t, " (%d x %d texels at %d, %d)", (int) width, (int) height, (int) area->x0,
                  (int) area->y0);
}

static const char *tiling(const ntp_seam *seam)
{
    return !seam->decided ? "perhaps" : seam->tiles ? "yes" : "no";
}

static void add_surface(text *t, const facts *f)
{
    const surface_facts *found = &f->surface;
    if (!found->known)
        return;
    text_addf(t, "    %-24s ", "made from heights");
    if (found->origin.decided)
        text_addf(t, "with the kernel %s", ntp_kernel_name(found->origin.kernel));
    else
        text_add(t, "with an unknown kernel, or not from heights");
    add_area(t, f, &found->area);
    text_addf(t, "\n    %-24s across: %s, down: %s\n", "tiles", tiling(&found->seam[0]),
              tiling(&found->seam[1]));
    if (found->steps.decided)
        text_addf(t, "    %-24s in steps of %.2f degrees: low-bit heights\n",
                  "slopes are quantized", found->steps.degrees);
    if (found->residual < 0)
        return;
    text_addf(t, "    %-24s to %.2f levels; rounding alone leaves 0.20", "fits a surface",
              found->residual);
    add_area(t, f, &found->fit_area);
    text_char(t, '\n');
}

static void add_statistics(text *t, const checked *c, const check_settings *s)
{
    static const char *const FAILS[] = { "fail neighbor", "fail rounded", "fail exact" };
    static const char *const CHANNELS[] = { "red", "green", "blue", "alpha" };
    const facts *f = &c->f;
    const ntp_stats *st = &f->stats;
    for (int32_t i = 0; i < f->type.reason_count && !f->forced; i++) {
        char reason[300];
        ntp_reason_text(reason, sizeof reason, &f->type.reasons[i]);
        text_addf(t, "    because %s\n", reason);
    }
    if (f->forced)
        text_add(t, "    because --type says so\n");
    if (f->orientation.decided)
        text_addf(t, "    %-24s %s: %s, %.0f %% sure\n", "green points", y_name(f->orientation.y),
                  y_title(f->orientation.y), 100 * f->orientation.confidence);
    else if (class_is_normals(f->type.type) && f->type.type != NTP_CLASS_OBJECT_SPACE)
        text_addf(t, "    %-24s up or down: the slopes do not show which\n", "green points");
    add_count_line(t, "unused texels", st->unused, st->texels);
    if (st->padding > 0)
        add_count_line(t, "padding, not judged", st->padding, st->texels);
    for (int v = NTP_VERDICT_NEIGHBOR; v <= NTP_VERDICT_EXACT; v++) {
        uint64_t all = 0, used = 0;
        if (f->encoding != NTP_ENCODING_XY &&
            failing_texels(f, (ntp_verdict) v, s->rules.keep_negative_z, &all, &used))
            add_count_line(t, FAILS[v], all, st->texels);
    }
    if (f->encoding != NTP_ENCODING_HEIGHT) {
        add_count_line(t, "x, y too long", st->xy_too_long, st->texels);
        if (f->encoding == NTP_ENCODING_STANDARD)
            add_count_line(t, "z negative", st->z_negative, st->texels);
        text_addf(t, "    %-24s mean %.3f, 99 %% within %.3f, at most %.3f degrees\n",
                  "stored against cleaned", st->angles.mean, st->angles.p99, st->angles.max);
        const ntp_harm *harm = &f->harm[HARM_LENGTH];
        text_addf(t, "    %-24s mean %.3f, 99 %% within %.2f, at most %.3f degrees\n",
                  "beyond rounding", harm->mean, harm->p99, harm->max);
    }
    if (f->encoding == NTP_ENCODING_STANDARD || f->encoding == NTP_ENCODING_ZZERO) {
        const ntp_fit *fit = f->encoding == NTP_ENCODING_ZZERO ? &st->zzero : &st->standard;
        text_addf(t, "    %-24s %.4f to %.4f, mean %.4f\n", "length", fit->length_min,
                  fit->length_max, fit->length_mean);
    }
    for (int32_t i = 0; i < st->channels && i < 4; i++) {
        const char *label = i == 0 && st->channels < 3    ? "gray"
                            : i == 1 && st->channels == 2 ? "alpha"
                                                          : CHANNELS[i];
        text_addf(t, "    %-24s %u to %u, mean %.2f\n", label, (unsigned) st->channel[i].min,
                  (unsigned) st->channel[i].max, st->channel[i].mean);
    }
}

void check_text(text *t, const input *in, const checked *c, const check_settings *s)
{
    if (!c->readable)
        return;
    const bool has_findings = count_level(c, LEVEL_ERROR) + count_level(c, LEVEL_WARNING) > 0 ||
                              (s->verbose && c->list.count > 0);
    if (s->quiet && !has_findings)
        return;
    add_headline(t, in, c, s);
    add_findings(t, c, s);
    if (s->verbose)
        add_statistics(t, c, s);
    if (s->verbose || (c->f.surface.deep && !s->quiet))
        add_surface(t, &c->f);
}

void check_text_summary(text *t, const check_summary *sum, const check_settings *s)
{
    if (sum->files < 2 || s->quiet)
        return;
    text_addf(t, "\n%zu files:", sum->files);
    const char *separator = " ";
    for (int i = 0; i <= NTP_CLASS_NOT_NORMALS; i++) {
        if (sum->by_class[i] == 0)
            continue;
        text_addf(t, "%s%zu %s", separator, sum->by_class[i], class_title((ntp_class) i));
        separator = ", ";
    }
    if (sum->unreadable > 0)
        text_addf(t, "%s%zu unreadable", separator, sum->unreadable);
    if (sum->foreign > 0)
        text_addf(t, " (%zu of formats that are not read)", sum->foreign);
    text_addf(t, "\n%zu without warnings, %zu with warnings, %zu with errors", sum->well_formed,
              sum->worst[LEVEL_WARNING], sum->worst[LEVEL_ERROR]);
    if (sum->possible > 0)
        text_addf(t, ", %zu with possible ones (not named as normals textures)", sum->possible);
    if (sum->only_known > 0)
        text_addf(t, ", %zu with known findings only", sum->only_known);
    if (sum->left_out > 0)
        text_addf(t, ", %zu not judged (no normals, by name and content)", sum->left_out);
    if (sum->known > 0)
        text_addf(t, "; %zu findings are in the baseline", sum->known);
    if (sum->notes > 0 && !s->verbose)
        text_addf(t, "; %zu notes (-v shows them)", sum->notes);
    text_char(t, '\n');
}

/* ------------------------------------------------------------------------------- CSV */

static void csv_field(text *t, const char *field)
{
    if (strpbrk(field, ",\"\r\n") == NULL) {
        text_add(t, field);
        return;
    }
    text_char(t, '"');
    for (; *field != 0; field++) {
        if (*field == '"')
            text_char(t, '"');
        text_char(t, *field);
    }
    text_char(t, '"');
}

void check_csv_header(text *t)
{
    text_add(t, "path,status,type,confidence,width,height,bit_depth,channels,texels,unused,"
                "fail_neighbor,fail_rounded,fail_exact,xy_too_long,z_negative,angle_mean,angle_p99,"
                "angle_max,errors,warnings,findings,message\n");
}

void check_csv(text *t, const input *in, const checked *c, const check_settings *s)
{
    csv_field(t, in->path);
    if (!c->readable) {
        text_add(t, ",unreadable,,,,,,,,,,,,,,,,,,,,");
        csv_field(t, c->error.message);
        text_char(t, '\n');
        return;
    }
    const facts *f = &c->f;
    const bool height = f->encoding == NTP_ENCODING_HEIGHT;
    text_addf(t, ",ok,%s,%.3f,%u,%u,%d,%d,%llu,%llu", ntp_class_name(f->type.type),
              f->type.confidence, (unsigned) f->info.width, (unsigned) f->info.height,
              (int) f->info.bit_depth, (int) f->info.channels, (unsigned long long) f->stats.texels,
              (unsigned long long) f->stats.unused);
    for (int v = NTP_VERDICT_NEIGHBOR; v <= NTP_VERDICT_EXACT; v++) {
        uint64_t all = 0, used = 0;
        text_char(t, ',');
        if (f->type.type <= NTP_CLASS_XY &&
            failing_texels(f, (ntp_verdict) v, s->rules.keep_negative_z, &all, &used))
            text_addf(t, "%llu", (unsigned long long) all);
    }
    if (height)
        text_add(t, ",,,,,");
    else
        text_addf(t, ",%llu,%llu,%.3f,%.3f,%.3f", (unsigned long long) f->stats.xy_too_long,
                  (unsigned long long) f->stats.z_negative, f->stats.angles.mean,
                  f->stats.angles.p99, f->stats.angles.max);
    text_addf(t, ",%zu,%zu,", count_level(c, LEVEL_ERROR), count_level(c, LEVEL_WARNING));
    for (size_t i = 0; i < c->list.count; i++)
        text_addf(t, "%s%s", i > 0 ? " " : "", FINDING_TABLE[c->list.at[i].id].id);
    text_add(t, ",\n");
}
