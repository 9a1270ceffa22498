/* SPDX-License-Identifier: MIT */
/*
 * texel_rules.c - findings of the texels of a normals texture: lengths, z, flat color, tilt
 */
#include "findings/judgement.h"

/* The level of texels that are wrong: `count` of them, with this harm. */
static finding_level level_of(const judgement *j, uint64_t count, const ntp_harm *harm)
{
    return j->rules->strict ? level_of_share(j, count) : level_of_harm(j, harm);
}

/* "; 1.2 % are off by more than 5 degrees" */
static void add_visible(const judgement *j, text *t, const ntp_harm *harm)
{
    if (j->rules->strict || harm->over == 0)
        return;
    text_add(t, "; ");
    text_percent(t, harm->over, j->used);
    text_add(t, " are off by more than ");
    text_addf(t, "%g degrees", j->rules->max_angle);
}

static void judge_length(judgement *j)
{
    const facts *f = j->f;
    const ntp_stats *s = &f->stats;
    const ntp_harm *harm = &f->harm[HARM_LENGTH];
    uint64_t all = 0, used = 0;
    if (!failing_texels(f, j->rules->verdict, j->rules->keep_negative_z, &all, &used) ||
        used == 0 || f->encoding == NTP_ENCODING_XY)
        return;
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
    text_degrees(&t, j->rules->strict ? s->angles.max : harm->max);
    text_add(&t, " degrees (");
    text_degrees(&t, j->rules->strict ? s->angles.mean : harm->mean);
    text_add(&t, " on average)");
    add_visible(j, &t, harm);
    add_finding(j, NT001, level_of(j, used, harm), used, &t);
    text_free(&t);
}

static void judge_xy(judgement *j)
{
    const ntp_stats *s = &j->f->stats;
    const ntp_harm *harm = &j->f->harm[HARM_XY];
    const uint64_t all = counts_xy_too_long(s);
    /* Rounding makes pairs too long that were not; only `exact` minds. */
    const bool rounding = harm->texels == 0 && j->rules->verdict != NTP_VERDICT_EXACT;
    const bool every = rounding || j->rules->verdict == NTP_VERDICT_EXACT;
    const uint64_t count = every ? all : harm->texels;
    if (count == 0)
        return;
    text t = { 0 };
    const bool pair = j->f->info.channels < 3;
    text_addf(&t, "%s alone are too long in ", pair ? "gray and alpha" : "red and green");
    add_share(j, &t, count);
    if (rounding)
        text_add(&t, ", by no more than rounding");
    else
        text_addf(&t, ": no %s can be right there", pair ? "z" : "blue");
    add_visible(j, &t, harm);
    add_finding(j, NT002, rounding ? LEVEL_INFO : level_of(j, count, harm), count, &t);
    text_free(&t);
}

static void judge_z(judgement *j)
{
    const ntp_stats *s = &j->f->stats;
    const ntp_harm *harm = &j->f->harm[HARM_Z];
    const uint64_t count = counts_z_negative(s);
    if (count == 0 || j->f->encoding != NTP_ENCODING_STANDARD || j->rules->keep_negative_z)
        return;
    text t = { 0 };
    text_add(&t, "blue is at or below one half in ");
    add_share(j, &t, count);
    text_add(&t, ": these normals point into the surface");
    if ((j->f->type.accidents & NTP_ACCIDENT_Z_FLIPPED) != 0)
        text_add(&t, "; blue seems to be inverted as a whole");
    add_visible(j, &t, harm);
    add_finding(j, NT003, level_of(j, count, harm), count, &t);
    text_free(&t);
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
    add_finding(j, NT020, LEVEL_INFO, used, &t);
    text_free(&t);
}

/* For "%.2f", which would print "-0.00". */
static double without_sign_of_zero(double v)
{
    return v > -0.005 && v < 0 ? 0 : v;
}

static void judge_flat(judgement *j)
{
    const ntp_stats *s = &j->f->stats;
    if (s->distinct_flat > 1)
        addf(j, NT021, LEVEL_INFO, s->flat, "flat texels have %llu different colors",
             (unsigned long long) s->distinct_flat);
}

static void judge_tilt(judgement *j)
{
    const facts *f = j->f;
    const double x = 2 * f->stats.used_mean[0] - 1, y = 2 * f->stats.used_mean[1] - 1;
    const double worst = counts_tilt(&f->stats);
    if (f->type.type == NTP_CLASS_ONE_COLOR || (worst < 0 ? -worst : worst) <= j->rules->max_tilt)
        return;
    addf(j, NT022, LEVEL_WARNING, 0,
         "tilted on average: the mean of x is %.2f and of y %.2f, but 0 is expected",
         without_sign_of_zero(x), without_sign_of_zero(y));
}

void judge_texels(judgement *j)
{
    judge_length(j);
    judge_xy(j);
    judge_z(j);
    judge_tilt(j);
    judge_exactness(j);
    judge_flat(j);
}
