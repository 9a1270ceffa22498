/* SPDX-License-Identifier: MIT */
/*
 * rules.c - from the facts of a file to its findings
 *
 * Every rule is a function that looks at the facts and may add a finding.  Shares are of the used
 * texels.  Counts in reports are of all texels.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "findings/findings.h"

/* JPEG: an angle that is still invisible, and one that is certainly visible. */
static const double LOSSY_WARNING_MEAN = 2, LOSSY_ERROR_P99 = 10;

/* From this rms on, in levels of 8 bit, no surface has these normals.  It is about 4 degrees. */
static const double POOR_FIT = 8;

typedef struct judgement {
    finding_list *list;
    const facts *f;
    const judge_rules *rules;
    uint64_t used;
} judgement;

judge_rules judge_rules_from(const options *o)
{
    return (judge_rules) {
        .verdict = (ntp_verdict) option_integer(o, OPT_VERDICT),
        .keep_negative_z = option_given(o, OPT_KEEP_NEGATIVE_Z),
        .max_fail = option_number(o, OPT_MAX_FAIL),
        .max_tilt = option_number(o, OPT_MAX_TILT),
        .y = (int) option_integer(o, OPT_Y),
    };
}

static void add(judgement *j, finding_id id, finding_level level, uint64_t count, const text *t)
{
    finding *next = &j->list->at[j->list->count++];
    *next = (finding) { .id = id, .level = level, .count = count };
    snprintf(next->message, sizeof next->message, "%s", text_string(t));
}

static void TEXT_FORMAT(5, 6)
    addf(judgement *j, finding_id id, finding_level level, uint64_t count, const char *format, ...)
{
    char message[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    text t = { 0 };
    text_add(&t, message);
    add(j, id, level, count, &t);
    text_free(&t);
}

static const ntp_fit *fit_of(const facts *f)
{
    return f->encoding == NTP_ENCODING_ZZERO ? &f->stats.zzero : &f->stats.standard;
}

static bool is_judged(const facts *f)
{
    return f->encoding != NTP_ENCODING_HEIGHT &&
           (class_is_tangent(f->type.type) || f->type.type == NTP_CLASS_ONE_COLOR);
}

bool failing_texels(const facts *f, ntp_verdict verdict, bool keep_negative_z, uint64_t *all,
                    uint64_t *used)
{
    const ntp_stats *s = &f->stats;
    const ntp_fit *fit = fit_of(f);
    if (!is_judged(f))
        return false;
    if (f->encoding == NTP_ENCODING_XY) {
        *all = s->xy_too_long;
        *used = s->xy_too_long - s->unused_xy_too_long;
        return true;
    }
    uint64_t pass = fit->neighbor, unused_pass = fit->unused_neighbor;
    if (verdict == NTP_VERDICT_ROUNDED)
        pass = fit->rounded, unused_pass = fit->unused_rounded;
    if (verdict == NTP_VERDICT_EXACT) {
        /* unused texels are rarely exact with z mirrored, so these all count as used */
        pass = fit->exact + (keep_negative_z ? fit->exact_mirrored : 0);
        unused_pass = fit->unused_exact;
    }
    *all = s->texels - pass;
    const uint64_t unused_fail = s->unused - unused_pass;
    *used = *all > unused_fail ? *all - unused_fail : 0;
    return true;
}

/* "12.3 % of the texels (12,345)" */
static void add_share(const judgement *j, text *t, uint64_t count)
{
    text_percent(t, count, j->used);
    text_add(t, j->f->stats.unused > 0 ? " of the used texels (" : " of the texels (");
    text_count(t, count);
    text_char(t, ')');
}

static finding_level level_of_share(const judgement *j, uint64_t count)
{
    const double percent = j->used == 0 ? 0 : 100.0 * (double) count / (double) j->used;
    return percent > j->rules->max_fail ? LEVEL_ERROR : LEVEL_WARNING;
}

static void judge_length(judgement *j)
{
    const facts *f = j->f;
    const ntp_stats *s = &f->stats;
    uint64_t all = 0, used = 0;
    if (!failing_texels(f, j->rules->verdict, j->rules->keep_negative_z, &all, &used) ||
        used == 0 || f->encoding == NTP_ENCODING_XY)
        return;
    finding_level level = level_of_share(j, used);
    if (f->info.lossy) {
        const bool error = s->angles.p99 > LOSSY_ERROR_P99;
        if (!error && s->angles.mean <= LOSSY_WARNING_MEAN)
            return;
        level = error ? LEVEL_ERROR : LEVEL_WARNING;
    }
    text t = { 0 };
    add_share(j, &t, used);
    if (j->rules->verdict == NTP_VERDICT_EXACT)
        text_add(&t, " do not have the blue that red and green imply");
    else
        text_add(&t, " are not unit vectors");
    const uint64_t off = s->levels_off_max[f->encoding == NTP_ENCODING_ZZERO];
    if (off > 0) {
        text_add(&t, ": blue is up to ");
        text_count(&t, off);
        text_addf(&t, " level%s off, the normal up to ", off == 1 ? "" : "s");
    } else { /* only red and green are wrong */
        text_add(&t, ": the normal is off by up to ");
    }
    text_degrees(&t, s->angles.max);
    text_add(&t, " degrees (");
    text_degrees(&t, s->angles.mean);
    text_add(&t, " on average)");
    add(j, NT001, level, used, &t);
    text_free(&t);
}

static void judge_xy(judgement *j)
{
    const ntp_stats *s = &j->f->stats;
    const uint64_t count = s->xy_too_long - s->unused_xy_too_long;
    if (count == 0)
        return;
    finding_level level = level_of_share(j, count);
    if (j->f->info.lossy)
        level = level == LEVEL_ERROR ? LEVEL_WARNING : LEVEL_INFO;
    text t = { 0 };
    const bool pair = j->f->info.channels < 3;
    text_addf(&t, "%s alone are too long in ", pair ? "gray and alpha" : "red and green");
    add_share(j, &t, count);
    text_addf(&t, ": no %s can be right there", pair ? "z" : "blue");
    add(j, NT002, level, count, &t);
    text_free(&t);
}

static void judge_z(judgement *j)
{
    const ntp_stats *s = &j->f->stats;
    const uint64_t count = s->z_negative - s->unused_z_negative;
    if (count == 0 || j->f->encoding != NTP_ENCODING_STANDARD || j->rules->keep_negative_z)
        return;
    finding_level level = level_of_share(j, count);
    if (j->f->info.lossy)
        level = level == LEVEL_ERROR ? LEVEL_WARNING : LEVEL_INFO;
    text t = { 0 };
    text_add(&t, "blue is at or below one half in ");
    add_share(j, &t, count);
    text_add(&t, ": these normals point into the surface");
    if ((j->f->type.accidents & NTP_ACCIDENT_Z_FLIPPED) != 0)
        text_add(&t, "; blue seems to be inverted as a whole");
    add(j, NT003, level, count, &t);
    text_free(&t);
}

static void judge_class(judgement *j)
{
    const facts *f = j->f;
    const ntp_stats *s = &f->stats;
    if (f->forced)
        return;
    switch (f->type.type) {
    case NTP_CLASS_ZZERO:
        addf(j, NT005, LEVEL_INFO, s->texels, "blue stores z in 0..1 (Z-zero), not in -1..1");
        break;
    case NTP_CLASS_XY:
        addf(j, NT006, LEVEL_INFO, s->texels, "%s",
             f->info.channels > 2
                 ? "only red and green hold a normal; blue is not z and is not judged"
                 : "gray and alpha hold x and y, in this order or the other");
        break;
    case NTP_CLASS_HEIGHT:
        addf(j, NT007, LEVEL_ERROR, s->texels, "this looks like a height map, not like normals");
        break;
    case NTP_CLASS_OBJECT_SPACE:
        addf(j, NT009, LEVEL_WARNING, s->texels,
             "normals point in all directions: object space, not tangent space");
        break;
    case NTP_CLASS_NOT_NORMALS:
        addf(j, NT008, LEVEL_ERROR, s->texels,
             "this is not a normals texture: its colors are not those of unit vectors");
        break;
    default:
        break;
    }
}

static void judge_accidents(judgement *j)
{
    const facts *f = j->f;
    const uint32_t a = f->type.accidents;
    const uint64_t n = f->stats.texels;
    if (f->forced && f->type.type == NTP_CLASS_HEIGHT)
        return;
    if ((a & NTP_ACCIDENT_BLUE_CONSTANT) != 0 && f->encoding != NTP_ENCODING_XY &&
        f->type.type != NTP_CLASS_ONE_COLOR)
        addf(j, NT004, LEVEL_WARNING, n, "blue is %u in every texel: it was not computed",
             (unsigned) f->stats.channel[2].min);
    if ((a & NTP_ACCIDENT_RED_IS_Z) != 0)
        addf(j, NT012, LEVEL_ERROR, n, "red and blue seem to be swapped: red holds z");
    else if ((a & NTP_ACCIDENT_GREEN_IS_Z) != 0)
        addf(j, NT012, LEVEL_ERROR, n, "green and blue seem to be swapped: green holds z");
    else if ((a & NTP_ACCIDENT_DXT5NM) != 0 && f->info.channels > 2)
        addf(j, NT012, LEVEL_ERROR, n, "packed as DXT5nm: x is in alpha, y in green");
    if ((a & NTP_ACCIDENT_GAMMA) != 0)
        addf(j, NT040, LEVEL_ERROR, f->stats.near_gamma_flat,
             "flat texels lie near 188, not 128: the numbers were converted to sRGB");
    if ((a & NTP_ACCIDENT_LOSSY) != 0 && !f->info.lossy)
        addf(j, NT032, LEVEL_WARNING, n,
             "the texels show lossy compression, although the file is lossless");
    if ((a & NTP_ACCIDENT_FILTERED) != 0 && !f->info.lossy)
        addf(j, NT035, LEVEL_WARNING, n,
             "normals are too short where the surface is curved: resized or blurred, not "
             "normalized");
}

static void judge_exactness(judgement *j)
{
    const facts *f = j->f;
    uint64_t all = 0, used = 0;
    if (f->encoding == NTP_ENCODING_XY || f->info.lossy || j->rules->verdict == NTP_VERDICT_EXACT ||
        !failing_texels(f, NTP_VERDICT_EXACT, j->rules->keep_negative_z, &all, &used) || used == 0)
        return;
    text t = { 0 };
    text_add(&t, "in ");
    add_share(j, &t, used);
    text_add(&t, " blue is not the one that red and green imply");
    add(j, NT020, LEVEL_INFO, used, &t);
    text_free(&t);
}

static void judge_flat(judgement *j)
{
    const ntp_stats *s = &j->f->stats;
    if (s->distinct_flat > 1)
        addf(j, NT021, LEVEL_INFO, s->flat, "flat texels have %llu different colors",
             (unsigned long long) s->distinct_flat);
}

/* For "%.2f", which would print "-0.00". */
static double without_sign_of_zero(double v)
{
    return v > -0.005 && v < 0 ? 0 : v;
}

static void judge_tilt(judgement *j)
{
    const facts *f = j->f;
    const double x = 2 * f->stats.used_mean[0] - 1, y = 2 * f->stats.used_mean[1] - 1;
    const double worst = (x < 0 ? -x : x) > (y < 0 ? -y : y) ? x : y;
    if (f->type.type == NTP_CLASS_ONE_COLOR || (worst < 0 ? -worst : worst) <= j->rules->max_tilt)
        return;
    addf(j, NT022, LEVEL_WARNING, 0,
         "tilted on average: the mean of x is %.2f and of y %.2f, but 0 is expected",
         without_sign_of_zero(x), without_sign_of_zero(y));
}

static void judge_name(judgement *j)
{
    const name_y name = j->f->in->y;
    if (j->rules->y == 1 && name == NAME_Y_DOWN)
        addf(j, NT011, LEVEL_WARNING, 0,
             "the name says DirectX (green down), but --y up requires OpenGL");
    if (j->rules->y == 2 && name == NAME_Y_UP)
        addf(j, NT011, LEVEL_WARNING, 0,
             "the name says OpenGL (green up), but --y down requires DirectX");
}

static void judge_orientation(judgement *j)
{
    const ntp_orientation_result *o = &j->f->orientation;
    const int asked = j->rules->y, found = o->y == NTP_Y_UP ? 1 : 2;
    if (asked == 0 || !o->decided || found == asked)
        return;
    addf(j, NT010, LEVEL_WARNING, 0, "looks %s where %s is required (%.0f %% sure)",
         found == 1 ? "OpenGL (green up)" : "DirectX (green down)",
         asked == 1 ? "OpenGL (green up)" : "DirectX (green down)", 100 * o->confidence);
}

static void judge_surface(judgement *j)
{
    const surface_facts *found = &j->f->surface;
    const bool across = found->seam[0].decided && !found->seam[0].tiles;
    const bool down = found->seam[1].decided && !found->seam[1].tiles;
    if (!found->known || !found->deep) /* only --deep makes findings of the surface */
        return;
    const double levels = found->residual / (j->f->info.sample_bytes == 1 ? 1 : 257);
    if (levels >= POOR_FIT)
        addf(j, NT023, LEVEL_INFO, 0,
             "no surface has these normals: the best one differs by %.0f of 255 levels on average",
             levels);
    if (found->steps.decided)
        addf(j, NT033, LEVEL_INFO, 0,
             "slopes are quantized in steps of %.2f degrees: low-bit heights made flat terraces "
             "with edges between them",
             found->steps.degrees);
    if (across || down)
        addf(j, NT052, LEVEL_INFO, 0, "does not tile: the %s edges do not fit together",
             across && down ? "left and right and the upper and lower"
             : across       ? "left and right"
                            : "upper and lower");
}

static void judge_color_chunks(judgement *j)
{
    const ntpio_info *info = &j->f->info;
    text t = { 0 };
    text_addf(&t, "%s%s%s%s%s", info->has_iccp ? ", iCCP" : "", info->has_srgb ? ", sRGB" : "",
              info->has_gama ? ", gAMA" : "", info->has_chrm ? ", cHRM" : "",
              info->has_cicp ? ", cICP" : "");
    if (t.size > 0 && (j->f->type.accidents & NTP_ACCIDENT_GAMMA) == 0)
        addf(j, NT040, LEVEL_INFO, 0, "contains color information (%s): ignore it",
             text_string(&t) + strlen(", "));
    text_free(&t);
}

static void judge_file(judgement *j)
{
    const ntpio_info *info = &j->f->info;
    const ntp_stats *s = &j->f->stats;
    if (info->lossy && info->jpeg_quality > 0)
        addf(j, NT030, LEVEL_INFO, s->texels, "stored as JPEG, quality about %d",
             (int) info->jpeg_quality);
    else if (info->lossy)
        addf(j, NT030, LEVEL_INFO, s->texels, "stored as JPEG");
    if (info->jpeg_subsampled)
        addf(j, NT031, LEVEL_WARNING, s->texels,
             "JPEG with chroma subsampling: the directions are blurred");
    if (s->stored_max == 65535 && s->max == 255)
        addf(j, NT034, LEVEL_INFO, s->texels, "a 16-bit file with 8-bit content");
    judge_color_chunks(j);
    if (info->alpha && s->alpha_full == s->texels)
        addf(j, NT041, LEVEL_INFO, s->texels, "the alpha channel is opaque everywhere");
    if (s->unused > 0 && s->unused < s->texels) {
        text t = { 0 };
        text_percent(&t, s->unused, s->texels);
        text_add(&t, " of the texels are unused (black, white or transparent)");
        add(j, NT042, LEVEL_INFO, s->unused, &t);
        text_free(&t);
    }
    const bool powers =
        (info->width & (info->width - 1)) == 0 && (info->height & (info->height - 1)) == 0;
    if (!powers)
        addf(j, NT051, LEVEL_INFO, 0, "%u x %u: the sides are not powers of two",
             (unsigned) info->width, (unsigned) info->height);
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

void judge(finding_list *list, const facts *f, const judge_rules *rules)
{
    list->count = 0;
    if (!f->counts)
        return;
    judgement j = { list, f, rules, f->stats.texels - f->stats.unused };
    judge_class(&j);
    judge_accidents(&j);
    const bool judged = is_judged(f) && j.used > 0;
    const uint32_t misplaced = NTP_ACCIDENT_RED_IS_Z | NTP_ACCIDENT_GREEN_IS_Z |
                               NTP_ACCIDENT_GAMMA |
                               (f->info.channels > 2 ? NTP_ACCIDENT_DXT5NM : 0);
    const bool wrong_channels = (f->type.accidents & misplaced) != 0;
    if (judged && !wrong_channels) {
        judge_length(&j);
        judge_xy(&j);
        judge_z(&j);
        judge_tilt(&j);
        judge_exactness(&j);
        judge_flat(&j);
    }
    if (f->type.type == NTP_CLASS_ONE_COLOR) {
        if (j.used == 0)
            addf(&j, NT050, LEVEL_INFO, f->stats.texels, "all texels are unused");
        else
            addf(&j, NT050, LEVEL_INFO, f->stats.texels, "all texels have one color");
    }
    judge_orientation(&j);
    judge_name(&j);
    judge_surface(&j);
    judge_file(&j);
    tidy(list);
    sort(list);
}
