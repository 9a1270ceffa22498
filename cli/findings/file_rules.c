/* SPDX-License-Identifier: MIT */
/*
 * file_rules.c - findings of a file: its name, green, the surface, how it is stored
 */
#include <string.h>

#include "findings/judgement.h"

/* From this rms on, in levels of 8 bit, no surface has these normals.  It is about 4 degrees. */
static const double POOR_FIT = 8;

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

/* Of DDS and KTX2. */
static void judge_gpu_texture(judgement *j)
{
    const ntpio_info *info = &j->f->info;
    const ntp_stats *s = &j->f->stats;
    const bool still_x = s->channel[0].min == s->channel[0].max;
    const bool still_y = s->channel[1].min == s->channel[1].max;
    if (info->layout[0] == 0)
        return;
    if (info->red_green && still_x != still_y)
        addf(j, NT014, LEVEL_WARNING, s->texels, "%s is %u in every texel: it holds nothing",
             still_x ? "red" : "green", (unsigned) s->channel[still_x ? 0 : 1].min);
    if (info->lossy)
        addf(j, NT036, LEVEL_INFO, s->texels, "compressed in blocks of 16 texels, as %s",
             info->layout);
    if (info->has_srgb)
        addf(j, NT045, LEVEL_WARNING, s->texels,
             "marked sRGB (%s): GPUs convert the numbers as they read them", info->layout);
    if (info->mips == 1 && (info->width > 1 || info->height > 1))
        addf(j, NT053, LEVEL_INFO, 0, "has no mips");
    if (j->f->mips.plain)
        addf(j, NT054, j->f->mips.degrees > j->rules->max_angle / 5 ? LEVEL_WARNING : LEVEL_INFO, 0,
             "mips are plain means of x and y, not of vectors: off by %.2f degrees on average",
             j->f->mips.degrees);
}

static void judge_storage(judgement *j)
{
    const ntpio_info *info = &j->f->info;
    const ntp_stats *s = &j->f->stats;
    judge_gpu_texture(j);
    if (info->format == NTPIO_JPEG && info->jpeg_quality > 0)
        addf(j, NT030, LEVEL_INFO, s->texels, "stored as JPEG, quality about %d",
             (int) info->jpeg_quality);
    else if (info->format == NTPIO_JPEG)
        addf(j, NT030, LEVEL_INFO, s->texels, "stored as JPEG");
    else if ((info->format == NTPIO_WEBP || info->format == NTPIO_EXR) && info->lossy)
        addf(j, NT030, LEVEL_INFO, s->texels, "stored as %s with loss",
             info->format == NTPIO_WEBP ? "WebP" : "EXR");
    if (info->jpeg_subsampled)
        addf(j, NT031, level_of_cause(j), s->texels,
             "%s with chroma subsampling: the directions are blurred",
             info->format == NTPIO_WEBP ? "WebP" : "JPEG");
    if (s->stored_max == 65535 && s->max == 255)
        addf(j, NT034, LEVEL_INFO, s->texels, "a 16-bit file with 8-bit content");
    if (info->layout[0] == 0)
        judge_color_chunks(j);
    if (info->alpha && !info->blocks && s->alpha_full == s->texels)
        addf(j, NT041, LEVEL_INFO, s->texels, "the alpha channel is opaque everywhere");
    if (s->unused > 0 && s->unused < s->texels) {
        text t = { 0 };
        text_percent(&t, s->unused, s->texels);
        text_add(&t, " of the texels are unused (black, white or transparent)");
        add_finding(j, NT042, LEVEL_INFO, s->unused, &t);
        text_free(&t);
    }
    if (s->padding > 0 && is_judged(j->f)) {
        text t = { 0 };
        text_percent(&t, s->padding, s->texels);
        text_add(&t, " of the texels have one color that no normal has: padding, not counted");
        add_finding(j, NT044, LEVEL_INFO, s->padding, &t);
        text_free(&t);
    }
    const bool powers =
        (info->width & (info->width - 1)) == 0 && (info->height & (info->height - 1)) == 0;
    if (!powers)
        addf(j, NT051, LEVEL_INFO, 0, "%u x %u: the sides are not powers of two",
             (unsigned) info->width, (unsigned) info->height);
}

static void judge_one_color(judgement *j)
{
    if (j->f->type.type == NTP_CLASS_ONE_COLOR)
        addf(j, NT050, j->used == 0 ? LEVEL_WARNING : LEVEL_INFO, j->f->stats.texels, "%s",
             j->used == 0 ? "no texel holds a normal: all are black, white or transparent"
                          : "all texels have one color");
}

void judge_file(judgement *j)
{
    judge_one_color(j);
    judge_orientation(j);
    judge_name(j);
    judge_surface(j);
    judge_storage(j);
}
