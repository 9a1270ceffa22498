/* SPDX-License-Identifier: MIT */
/*
 * sums.c - a checksum of what each operation of libntp makes of generated pictures
 *
 * The lines are equal on every processor, compiler and C library: ./dev elsewhere compares them.
 * Samples and numbers are hashed by value, not by the order of their bytes.
 *
 *   sums [SHARE [NAME]]    1 in SHARE of the 2^24 triplets (default: all); only that operation
 */
#include "sums.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int share = 1;
const char *current;

static const char *const type_names[] = { "u8", "u16", "f32" };

/* Each is run with the types up to the last one. */
static const struct {
    const char *name;
    uint64_t (*run)(ntp_type type);
    ntp_type last;
} operations[] = {
    { "validate", validate, NTP_TYPE_U8 },
    { "clean", clean, NTP_TYPE_U8 },
    { "convert", convert, NTP_TYPE_U8 },
    { "clean-picture", clean_picture, NTP_TYPE_F32 },
    { "inspect", inspect, NTP_TYPE_F32 },
    { "measure", measure, NTP_TYPE_U16 },
    { "levels-off", levels_off, NTP_TYPE_U8 },
    { "difference", difference, NTP_TYPE_F32 },
    { "pictures", pictures, NTP_TYPE_F32 },
    { "which-way-green", which_way_green, NTP_TYPE_F32 },
    { "find-kernel", find_kernel, NTP_TYPE_U16 },
    { "find-seams", find_seams, NTP_TYPE_U16 },
    { "find-borders", find_borders, NTP_TYPE_U16 },
    { "normals", normals_from_height, NTP_TYPE_F32 },
    { "relief", relief, NTP_TYPE_F32 },
    { "heights-direct", heights_direct, NTP_TYPE_F32 },
    { "heights-refined", heights_refined, NTP_TYPE_U16 },
    { "heights-weighted", heights_weighted, NTP_TYPE_F32 },
    { "heights-summed", heights_summed, NTP_TYPE_F32 },
    { "depth", depth, NTP_TYPE_U16 },
    { "resize", resize, NTP_TYPE_F32 },
    { "transform", transform, NTP_TYPE_F32 },
    { "blend", blend, NTP_TYPE_F32 },
    { "curvature", curvature, NTP_TYPE_F32 },
    { "occlusion", occlusion, NTP_TYPE_F32 },
    { "blur", blur, NTP_TYPE_F32 },
    { "blocks", blocks, NTP_TYPE_F32 },
};

int main(int argc, char **argv)
{
    const char *only = argc > 2 ? argv[2] : NULL;
    share = argc > 1 ? (int) strtol(argv[1], NULL, 10) : 1;
    if (share < 1) {
        fprintf(stderr, "usage: %s [SHARE [NAME]]\n", argv[0]);
        return 2;
    }
    for (size_t i = 0; i < sizeof operations / sizeof *operations; i++) {
        current = operations[i].name;
        for (int type = NTP_TYPE_U8; type <= (int) operations[i].last; type++) {
            if (only && strcmp(only, current) != 0)
                continue;
            printf("%-18s %-4s %016" PRIx64 "\n", current, type_names[type],
                   operations[i].run((ntp_type) type));
            fflush(stdout);
        }
    }
    return 0;
}
