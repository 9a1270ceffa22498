/* SPDX-License-Identifier: MIT */
/*
 * fuzz_io.c - any bytes as an image: read whole or refused with a message
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "ntpio.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    /* Small limits: the fuzzer looks for mistakes, not for slow images. */
    const ntpio_limits limits = { 1024, 1 << 16, 1 << 22 };
    ntpio_error error = { 0 };
    ntpio_reader *reader = ntpio_open_memory(data, size, "fuzz.tga", &limits, &error);
    bool done = reader != NULL;
    if (done) {
        const ntpio_info *info = ntpio_reader_info(reader);
        const size_t row = (size_t) info->width * (size_t) (info->channels * info->sample_bytes);
        uint8_t *rows = malloc(row * 2);
        for (uint32_t y = 0; done && rows != NULL && y < info->height; y += 2)
            done = ntpio_read_rows(reader, rows, (ptrdiff_t) row,
                                   info->height - y < 2 ? info->height - y : 2, &error);
        done = done && rows != NULL && ntpio_read_end(reader, &error);
        free(rows);
    }
    if (!done && (error.status == NTPIO_OK || strlen(error.message) == 0))
        abort();
    ntpio_close(reader);
    return 0;
}
