/* SPDX-License-Identifier: MIT */
/*
 * class_rules.c - findings of what a texture is, and of what was done to it as a whole
 */
#include "findings/judgement.h"

/* A warning, unless the name says that it is meant so: most engines read the texture as standard. */
static void judge_zzero(judgement *j)
{
    if (name_promises(j->f->in->path, true))
        addf(j, NT005, LEVEL_INFO, j->f->stats.texels,
             "blue stores z in 0..1 (Z-zero), as the name says");
    else
        addf(j, NT005, LEVEL_WARNING, j->f->stats.texels,
             "blue stores z in 0..1 (Z-zero), not in -1..1: ntp convert --type zzero --to standard "
             "makes it standard, --type zzero says that it is meant so");
}

/* A blue that holds something else is meant so where another map is in alpha as well, as in LabPBR,
 * or where the name says so.  Else it is a standard texture that lost its z, and whoever reads it as
 * standard sees wrong normals. */
static void judge_xy_only(judgement *j)
{
    const facts *f = j->f;
    const bool nothing = (f->type.accidents & NTP_ACCIDENT_BLUE_CONSTANT) != 0;
    if (f->info.red_green)
        addf(j, NT006, LEVEL_INFO, f->stats.texels,
             "%s holds x and y, and no blue: whoever reads it computes z", f->info.layout);
    else if (f->info.channels <= 2)
        addf(j, NT006, LEVEL_INFO, f->stats.texels,
             "gray and alpha hold x and y, in this order or the other");
    else if (name_promises(f->in->path, false) || (!nothing && counts_alpha_map(&f->stats)))
        addf(j, NT006, LEVEL_INFO, f->stats.texels,
             "only red and green hold a normal; blue is not z and is not judged");
    else if (!nothing)
        addf(j, NT006, LEVEL_WARNING, f->stats.texels,
             "only red and green hold a normal; blue is not their z, but noise or another map: ntp "
             "convert --type xy --to standard computes it, --type xy says that it is meant so");
    else
        addf(
            j, NT004, LEVEL_WARNING, f->stats.texels,
            "red and green hold normals, and blue holds nothing (about %u throughout): ntp convert "
            "--type xy --to standard computes it, --type xy says that it is meant so",
            (unsigned) (255 * f->stats.used_mean[2] + 0.5));
}

void judge_class(judgement *j)
{
    const facts *f = j->f;
    const ntp_stats *s = &f->stats;
    if (f->forced)
        return;
    switch (f->type.type) {
    case NTP_CLASS_ZZERO:
        judge_zzero(j);
        break;
    case NTP_CLASS_XY:
        judge_xy_only(j);
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

void judge_accidents(judgement *j)
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
    if (f->exchange.sure)
        addf(j, NT013, LEVEL_ERROR, n,
             "x and y are exchanged: the slopes fit a surface only the other way round (%.0f "
             "standard "
             "deviations)",
             f->exchange.deviations < 99 ? f->exchange.deviations : 99);
    if ((a & NTP_ACCIDENT_GAMMA) != 0)
        addf(j, NT040, LEVEL_ERROR, f->stats.near_gamma_flat,
             "flat texels lie near 188, not 128: the numbers were converted to sRGB");
    if ((a & NTP_ACCIDENT_LOSSY) != 0 && !f->info.lossy)
        addf(j, NT032, level_of_cause(j), n,
             "the texels show lossy compression, although the file is lossless");
    if ((a & NTP_ACCIDENT_FILTERED) != 0 && !f->info.lossy)
        addf(j, NT035, level_of_cause(j), n,
             "normals are too short where the surface is curved: resized or blurred, not "
             "normalized");
}

bool has_misplaced_channels(const facts *f)
{
    return counts_misplaced(&f->type, f->info.channels);
}
