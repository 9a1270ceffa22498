/* SPDX-License-Identifier: MIT */
/*
 * report_json.c - JSON, by jansson; docs/schema/check-1.json describes it
 *
 * Only items are built as trees.  A report is printed item by item, so memory does not grow with
 * the number of files.
 */
#include <libntp.h>
#include <ntpio.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "options/names.h"
#include "report/report.h"

enum {
    SCHEMA_VERSION = 1,
    /* 15 digits print 0.001 as it was meant */
    DUMP_FLAGS = JSON_REAL_PRECISION(15) | JSON_PRESERVE_ORDER
};

static void dump(text *t, json_t *value)
{
    char *string = need(json_dumps(value, DUMP_FLAGS | JSON_ENCODE_ANY));
    text_add(t, string);
    free(string);
    json_decref(value);
}

static json_t *tool(void)
{
    text t = { 0 };
    text_addf(&t, "%d.%d.%d", NTP_VERSION_MAJOR, NTP_VERSION_MINOR, NTP_VERSION_PATCH);
    json_t *object = json_pack("{s:s, s:s, s:s}", "name", "ntp", "version", text_string(&t),
                               "codecs", ntpio_versions());
    text_free(&t);
    return need(object);
}

void json_begin(text *t)
{
    text_addf(t, "{\"schema_version\": %d, \"tool\": ", SCHEMA_VERSION);
    dump(t, tool());
    text_add(t, ", \"files\": [");
}

void json_item(text *t, json_t *item)
{
    text_add(t, ",\n  ");
    dump(t, item);
}

void json_begin_list(text *item, bool *any)
{
    if (*any || item->size == 0)
        return;
    item->data[0] = ' ';
    *any = true;
}

void json_end(text *t, json_t *summary)
{
    text_add(t, "\n], \"summary\": ");
    dump(t, summary);
    text_add(t, "}\n");
}

void json_document(text *t, json_t *body)
{
    json_t *whole = need(json_object());
    json_object_set_new(whole, "schema_version", json_integer(SCHEMA_VERSION));
    json_object_set_new(whole, "tool", tool());
    json_object_update(whole, body);
    json_decref(body);
    dump(t, whole);
    text_char(t, '\n');
}

static void base64(text *t, const char *bytes)
{
    static const char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *u = (const unsigned char *) bytes;
    size_t left = strlen(bytes);
    while (left > 0) {
        const size_t n = left < 3 ? left : 3;
        const unsigned v = (unsigned) u[0] << 16 | (n > 1 ? (unsigned) u[1] << 8 : 0) |
                           (n > 2 ? (unsigned) u[2] : 0);
        const char four[4] = { DIGITS[v >> 18], DIGITS[v >> 12 & 63],
                               n > 1 ? DIGITS[v >> 6 & 63] : '=', n > 2 ? DIGITS[v & 63] : '=' };
        text_bytes(t, four, 4);
        u += n;
        left -= n;
    }
}

void json_set_name(json_t *object, const char *key, const char *name)
{
    if (utf8_valid(name)) {
        json_object_set_new(object, key, json_string(name));
        return;
    }
    text shown = { 0 };
    for (const char *c = name; *c != 0;) {
        const size_t length = utf8_length(c);
        if (length == 0)
            text_add(&shown, "\xef\xbf\xbd"); /* U+FFFD, the replacement character */
        else
            text_bytes(&shown, c, length);
        c += length > 0 ? length : 1;
    }
    json_object_set_new(object, key, json_string(text_string(&shown)));
    text_free(&shown);
    text coded = { 0 }, coded_key = { 0 };
    base64(&coded, name);
    text_addf(&coded_key, "%s_base64", key);
    json_object_set_new(object, text_string(&coded_key), json_string(text_string(&coded)));
    text_free(&coded);
    text_free(&coded_key);
}

static double to_thousandths(double value)
{
    return (double) (int64_t) (value * 1000 + (value < 0 ? -0.5 : 0.5)) / 1000;
}

json_t *json_angle(double degrees)
{
    return json_real(to_thousandths(degrees));
}

json_t *json_angles(const ntp_angles *angles)
{
    json_t *object = need(json_object());
    json_object_set_new(object, "mean", json_angle(angles->mean));
    json_object_set_new(object, "p99", json_angle(angles->p99));
    json_object_set_new(object, "max", json_angle(angles->max));
    return object;
}

json_t *json_count(uint64_t count)
{
    return json_integer((json_int_t) count);
}

void json_set_changes(json_t *object, const ntp_diff_stats *stats)
{
    const bool known = stats != NULL;
    json_object_set_new(object, "changed", known ? json_count(stats->different) : json_null());
    json_object_set_new(object, "angle_deg", known ? json_angles(&stats->angles) : json_null());
}

json_t *json_file(const input *in, const char *status, const char *message)
{
    json_t *object = need(json_object());
    json_set_name(object, "path", in->path);
    json_object_set_new(object, "status", json_string(status));
    json_object_set_new(object, "message", message != NULL ? json_string(message) : json_null());
    return object;
}

/* ---------------------------------------------------------------------------- check */

static const char *format_name(ntpio_format format)
{
    switch (format) {
    case NTPIO_PNG:
        return "png";
    case NTPIO_TGA:
        return "tga";
    case NTPIO_JPEG:
        return "jpeg";
    case NTPIO_DDS:
        return "dds";
    case NTPIO_KTX2:
        return "ktx2";
    case NTPIO_WEBP:
        return "webp";
    case NTPIO_EXR:
        return "exr";
    default:
        return "pfm";
    }
}

static json_t *reasons(const facts *f)
{
    json_t *list = need(json_array());
    if (f->forced)
        json_array_append_new(list, json_string("--type says so"));
    for (int32_t i = 0; i < f->type.reason_count && !f->forced; i++) {
        char reason[300];
        ntp_reason_text(reason, sizeof reason, &f->type.reasons[i]);
        json_array_append_new(list, json_string(reason));
    }
    return list;
}

/* Counts of texels that fail, by verdict; of all texels or of the used ones.  null: not judged. */
static json_t *fails(const facts *f, const check_settings *s, bool of_used)
{
    json_t *object = need(json_object());
    for (int v = NTP_VERDICT_NEIGHBOR; v <= NTP_VERDICT_EXACT; v++) {
        uint64_t all = 0, used = 0;
        const bool judged =
            f->type.type <= NTP_CLASS_XY &&
            failing_texels(f, (ntp_verdict) v, s->rules.keep_negative_z, &all, &used);
        if (!judged) {
            json_decref(object);
            return json_null();
        }
        json_object_set_new(object, verdict_name((ntp_verdict) v),
                            json_count(of_used ? used : all));
    }
    return object;
}

/* The counts beside it again, without unused texels and padding. */
static json_t *used_counts(const facts *f, const check_settings *s)
{
    const ntp_stats *st = &f->stats;
    json_t *object = need(json_object());
    json_object_set_new(object, "texels", json_count(judged_texels(f)));
    json_object_set_new(object, "fail", fails(f, s, true));
    json_object_set_new(object, "xy_too_long",
                        json_count(st->xy_too_long - st->unused_xy_too_long - st->padding));
    json_object_set_new(
        object, "z_negative",
        json_count(st->z_negative - st->unused_z_negative - st->padding_z_negative));
    return object;
}

static json_t *harm(const facts *f, const check_settings *s)
{
    static const char *const KEYS[HARM_KINDS] = { "length", "xy", "z_negative" };
    json_t *object = need(json_object());
    json_object_set_new(object, "max_angle", json_real(s->rules.max_angle));
    for (int i = 0; i < HARM_KINDS; i++) {
        const ntp_harm *one = &f->harm[i];
        json_t *kind = need(json_object());
        json_object_set_new(kind, "texels", json_count(one->texels));
        json_object_set_new(kind, "over", json_count(one->over));
        json_object_set_new(kind, "mean", json_angle(one->mean));
        json_object_set_new(kind, "p99", json_angle(one->p99));
        json_object_set_new(kind, "max", json_angle(one->max));
        json_object_set_new(object, KEYS[i], kind);
    }
    return object;
}

static json_t *levels(const facts *f)
{
    json_t *object = need(json_object());
    for (size_t i = 0; i < f->level_count; i++) {
        char key[16];
        snprintf(key, sizeof key, "%u", (unsigned) f->levels[i].level);
        json_object_set_new(object, key, json_count(f->levels[i].count));
    }
    return object;
}

static json_t *length(const facts *f)
{
    if (f->encoding != NTP_ENCODING_STANDARD && f->encoding != NTP_ENCODING_ZZERO)
        return json_null();
    const ntp_fit *fit = f->encoding == NTP_ENCODING_ZZERO ? &f->stats.zzero : &f->stats.standard;
    json_t *object = need(json_object());
    json_object_set_new(object, "min", json_real(fit->length_min));
    json_object_set_new(object, "mean", json_real(fit->length_mean));
    json_object_set_new(object, "max", json_real(fit->length_max));
    return object;
}

/* Is the count of this finding one of used texels? */
static bool counts_used(finding_id id)
{
    return id == NT001 || id == NT002 || id == NT003 || id == NT020 || id == NT021 || id == NT040;
}

static json_t *finding_objects(const finding_list *list)
{
    json_t *array = need(json_array());
    for (size_t i = 0; i < list->count; i++) {
        const finding *one = &list->at[i];
        json_t *object = need(json_object());
        json_object_set_new(object, "id", json_string(FINDING_TABLE[one->id].id));
        json_object_set_new(object, "level", json_string(level_name(one->level)));
        json_object_set_new(object, "message", json_string(one->message));
        json_object_set_new(object, "count", json_count(one->count));
        json_object_set_new(object, "count_of", json_string(counts_used(one->id) ? "used" : "all"));
        if (one->if_named != one->level)
            json_object_set_new(object, "level_if_named", json_string(level_name(one->if_named)));
        if (one->known)
            json_object_set_new(object, "baseline", json_true());
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *rectangle(const ntp_rect *r)
{
    return need(json_pack("{s:i, s:i, s:i, s:i}", "x", (int) r->x0, "y", (int) r->y0, "width",
                          (int) (r->x1 - r->x0), "height", (int) (r->y1 - r->y0)));
}

static const char *tiling(const ntp_seam *seam)
{
    return !seam->decided ? "undecided" : seam->tiles ? "yes" : "no";
}

/* null: there are no slopes, or it is not known. */
static void set_surface(json_t *object, const surface_facts *found)
{
    json_t *kernel = json_null(), *tiles = json_null(), *residual = json_null(),
           *area = json_null(), *fit_area = json_null(), *steps = json_null();
    if (found->known) {
        area = rectangle(&found->area);
        tiles = need(
            json_pack("{s:s, s:s}", "x", tiling(&found->seam[0]), "y", tiling(&found->seam[1])));
    }
    if (found->known && found->origin.decided)
        kernel = json_string(ntp_kernel_name(found->origin.kernel));
    if (found->known && found->residual >= 0) {
        residual = json_angle(found->residual);
        fit_area = rectangle(&found->fit_area);
    }
    if (found->known && found->steps.decided)
        steps = json_angle(found->steps.degrees);
    json_object_set_new(object, "kernel", kernel);
    json_object_set_new(object, "tiles", tiles);
    json_object_set_new(object, "residual_levels", residual);
    json_object_set_new(object, "slope_step_deg", steps);
    json_object_set_new(object, "surface_area", area);
    json_object_set_new(object, "residual_area", fit_area);
}

json_t *check_json(const input *in, const checked *c, const check_settings *s)
{
    if (!c->readable) {
        json_t *unread = json_file(in, "unreadable", c->error.message);
        json_object_set_new(unread, "type", json_null());
        json_object_set_new(unread, "findings", need(json_array()));
        return unread;
    }
    const facts *f = &c->f;
    const bool height = f->encoding == NTP_ENCODING_HEIGHT;
    json_t *object = json_file(in, "ok", NULL);
    json_object_set_new(object, "format", json_string(format_name(f->info.format)));
    json_object_set_new(object, "width", json_integer((json_int_t) f->info.width));
    json_object_set_new(object, "height", json_integer((json_int_t) f->info.height));
    json_object_set_new(object, "bit_depth", json_integer(f->info.bit_depth));
    json_object_set_new(object, "channels", json_integer(f->info.channels));
    json_object_set_new(object, "type", json_string(ntp_class_name(f->type.type)));
    json_object_set_new(object, "confidence", json_angle(f->type.confidence));
    json_object_set_new(object, "reasons", reasons(f));
    static const char *const Y[] = { "undecided", "up", "down" };
    const ntp_orientation_result *found = &f->orientation;
    const int seen = !found->decided ? 0 : found->y == NTP_Y_UP ? 1 : 2, y = s->rules.y;
    json_object_set_new(object, "y", json_string(Y[y != 0 ? y : seen]));
    json_object_set_new(object, "y_confidence", json_angle(y != 0 ? 1 : found->confidence));
    json_object_set_new(object, "texels", json_count(f->stats.texels));
    json_object_set_new(object, "unused", json_count(f->stats.unused));
    json_object_set_new(object, "padding", json_count(f->stats.padding));
    json_object_set_new(object, "counts", json_boolean(f->counts));
    json_object_set_new(object, "fail", fails(f, s, false));
    json_object_set_new(object, "xy_too_long",
                        height ? json_null() : json_count(f->stats.xy_too_long));
    json_object_set_new(object, "z_negative",
                        height ? json_null() : json_count(f->stats.z_negative));
    json_object_set_new(object, "used", height ? json_null() : used_counts(f, s));
    json_object_set_new(object, "levels_off", levels(f));
    json_object_set_new(object, "length", length(f));
    json_object_set_new(object, "angle_deg", height ? json_null() : json_angles(&f->stats.angles));
    json_object_set_new(object, "harm", height ? json_null() : harm(f, s));
    set_surface(object, &f->surface);
    json_object_set_new(object, "findings", finding_objects(&c->list));
    return object;
}

static json_t *rule(const judge_rules *rules)
{
    json_t *object = need(json_object());
    json_object_set_new(object, "policy", json_string(rules->strict ? "strict" : "harm"));
    json_object_set_new(object, "verdict", json_string(verdict_name(rules->verdict)));
    json_object_set_new(object, "max_angle", json_real(rules->max_angle));
    json_object_set_new(object, "max_fail", json_real(rules->max_fail));
    return object;
}

json_t *check_json_summary(const check_summary *sum, const check_settings *s)
{
    json_t *types = need(json_object());
    for (int i = 0; i <= NTP_CLASS_NOT_NORMALS; i++)
        json_object_set_new(types, ntp_class_name((ntp_class) i),
                            json_integer((json_int_t) sum->by_class[i]));
    json_t *found = need(json_object());
    for (int i = 0; i < FINDING_COUNT; i++) {
        if (sum->found[i] > 0)
            json_object_set_new(found, FINDING_TABLE[i].id,
                                json_integer((json_int_t) sum->found[i]));
    }
    json_t *object = need(json_object());
    const struct {
        const char *key;
        size_t count;
    } COUNTS[] = {
        { "files", sum->files },
        { "unreadable", sum->unreadable },
        { "unsupported", sum->foreign },
        { "not_counted", sum->left_out },
        { "well_formed", sum->well_formed },
        { "possible", sum->possible },
        { "with_warnings", sum->worst[LEVEL_WARNING] },
        { "with_errors", sum->worst[LEVEL_ERROR] },
        { "failing", sum->failing },
        { "in_baseline", sum->known },
        { "only_known", sum->only_known },
    };
    for (size_t i = 0; i < sizeof COUNTS / sizeof COUNTS[0]; i++)
        json_object_set_new(object, COUNTS[i].key, json_integer((json_int_t) COUNTS[i].count));
    json_object_set_new(object, "rule", rule(&s->rules));
    json_object_set_new(object, "types", types);
    json_object_set_new(object, "findings", found);
    return object;
}
