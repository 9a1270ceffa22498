/* SPDX-License-Identifier: MIT */
/*
 * fuzz_io.c - reads any bytes as an image
 *
 * PNG is read again with its chunks' checksums mended, or hardly any change would get further than
 * those.  Formats are recognized by content; because of the name, everything else is read as TGA.
 * Of DDS and KTX2 other mips and layers than the first are read by inputs of other sizes.
 */
#include "both_ways.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    read_both_ways(data, size);
    if (size < 8 || memcmp(data, "\x89PNG\r\n\x1a\n", 8) != 0)
        return 0;
    uint8_t *copy = malloc(size);
    require(copy != NULL, "memory");
    memcpy(copy, data, size);
    mend(copy, size);
    read_both_ways(copy, size);
    free(copy);
    return 0;
}
