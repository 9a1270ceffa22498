/* SPDX-License-Identifier: MIT */
/*
 * smooth.c - heights blurred, and their small, middle and large forms weighed
 */
#include "smooth.h"

#include <math.h>
#include <stdlib.h>

enum { FORMS = 3, MIDDLE = 2, LARGE = 8, DEVIATIONS = 3 /* to which the library blurs */ };

typedef struct part {
    double sigma, weight;
} part;

/* Blurring twice adds the squares of sigma. */
static double blurred_by(const smoothing *s, double more)
{
    const double sigma = sqrt(s->blur * s->blur + more * more);
    return sigma < NTP_MAX_SIGMA ? sigma : NTP_MAX_SIGMA;
}

/* The blurs that add up to the forms: the first always, the others if they have weight. */
static int parts_of(const smoothing *s, part parts[FORMS])
{
    const part all[FORMS] = { { s->blur, s->small },
                              { blurred_by(s, MIDDLE), s->middle - s->small },
                              { blurred_by(s, LARGE), s->large - s->middle } };
    int count = 0;
    for (int i = 0; i < FORMS; i++) {
        if (i == 0 || all[i].weight != 0)
            parts[count++] = all[i];
    }
    return count;
}

bool smoothing_acts(const smoothing *s)
{
    return s->blur > 0 || s->small != 1 || s->middle != 1 || s->large != 1;
}

int32_t smoothing_reach(const smoothing *s)
{
    part parts[FORMS];
    const int count = parts_of(s, parts);
    return smoothing_acts(s) ? (int32_t) ceil(DEVIATIONS * parts[count - 1].sigma) : 0;
}

int32_t smoothing_channels(int32_t channels)
{
    return channels % 2 == 0 ? 2 : 1;
}

/* Converts the last channel of the heights to the second of `out`. */
static ntp_status copy_alpha(const ntp_image *out, const ntp_const_image *heights)
{
    static const ptrdiff_t SAMPLE[] = { 1, 2, 4 }; /* bytes, by ntp_type */
    ntp_image to = *out;
    ntp_const_image alpha = *heights;
    to.data = (float *) out->data + 1;
    alpha.data =
        (const unsigned char *) heights->data + (heights->channels - 1) * SAMPLE[heights->type];
    to.channels = alpha.channels = 1;
    return ntp_convert(&to, &alpha, NULL, NULL, NULL);
}

ntp_status smoothing_run(const smoothing *s, const ntp_image *out, const ntp_const_image *heights,
                         const ntp_normals_options *how)
{
    part parts[FORMS];
    const int count = parts_of(s, parts);
    ntp_blur_options blur = { .border_x = how->border_x,
                              .border_y = how->border_y,
                              .source = how->source };
    blur.sigma = parts[count - 1].sigma; /* the widest, so the memory is enough for all */
    const size_t size = ntp_height_blur_scratch_size(&blur, out->width);
    void *scratch = malloc(size);
    ntp_status status = scratch != NULL ? NTP_OK : NTP_ERR_SCRATCH;
    for (int i = 0; i < count && status == NTP_OK; i++) {
        blur.sigma = parts[i].sigma;
        blur.weight = parts[i].weight;
        blur.add = i > 0;
        status = ntp_height_blur(out, heights, &blur, scratch, size);
    }
    free(scratch);
    return status == NTP_OK && out->channels == 2 ? copy_alpha(out, heights) : status;
}
