/* SPDX-License-Identifier: MIT */
/*
 * spng_decode.c - decodes a PNG file at once with libspng, as it is stored: spng_decode FILE
 */
#include <spng.h>
#include <stdio.h>
#include <stdlib.h>

static int decode(FILE *file)
{
    size_t size;
    spng_ctx *context = spng_ctx_new(0);
    if (context == NULL || spng_set_png_file(context, file) != 0 ||
        spng_decoded_image_size(context, SPNG_FMT_PNG, &size) != 0)
        return EXIT_FAILURE;
    void *image = malloc(size);
    const int result = image != NULL ? spng_decode_image(context, image, size, SPNG_FMT_PNG, 0) : 1;
    free(image);
    spng_ctx_free(context);
    return result == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: spng_decode FILE\n");
        return 2;
    }
    FILE *file = fopen(argv[1], "rb");
    if (file == NULL) {
        perror(argv[1]);
        return EXIT_FAILURE;
    }
    const int result = decode(file);
    fclose(file);
    return result;
}
