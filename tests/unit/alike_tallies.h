/* SPDX-License-Identifier: MIT */
/*
 * alike_tallies.h - the tallies of a texture with and without a set of instructions are the same
 */
#ifndef NTP_ALIKE_TALLIES_H
#define NTP_ALIKE_TALLIES_H

#include "guarded.h"
#include "measure/tally.h"

#include <stdlib.h>
#include <string.h>

/* Measures packed RGB of 8 bit with *allowed false, then true; returns what classify/ asks of it. */
static inline const ntp__evidence *alike_tallies(uint8_t *texels, int32_t width, int32_t height,
                                                 bool *allowed)
{
    static ntp__evidence evidence[2];
    ntp_tally *const tally[2] = { calloc(1, ntp_tally_size()), calloc(1, ntp_tally_size()) };
    CHECK(tally[0] != NULL && tally[1] != NULL);
    const ntp_image image = ntp_image_packed(texels, width, height, 3, NTP_TYPE_U8);
    const ntp_const_image view = ntp_image_as_const(&image);
    for (int32_t i = 0; i < 2; i++) {
        *allowed = i == 1;
        CHECK(ntp_tally_add(tally[i], &view, 0, NULL) == NTP_OK);
        CHECK(ntp__sum_up(tally[i], NTP_ENCODING_STANDARD) == NTP_OK);
        const ntp__evidence *gathered;
        CHECK(ntp__gather_evidence(&gathered, tally[i]) == NTP_OK);
        evidence[i] = *gathered;
    }
    /* NOLINTNEXTLINE */
    CHECK(memcmp(&tally[0]->used, &tally[1]->used, sizeof tally[0]->used) == 0);
    CHECK(memcmp(tally[0]->blues, tally[1]->blues, sizeof tally[0]->blues) == 0);
    /* All were zero-filled, padding included.  NOLINTNEXTLINE */
    CHECK(memcmp(&evidence[0], &evidence[1], sizeof evidence[0]) == 0);
    free(tally[1]);
    free(tally[0]);
    return evidence;
}

#endif
