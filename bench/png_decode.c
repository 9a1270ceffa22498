/* SPDX-License-Identifier: MIT */
/*
 * png_decode.c - reads a PNG file with libpng, row by row, and drops it: png_decode FILE
 *
 * The reference for `ntp check`: an image cannot be checked faster than it can be read.
 */
#include <png.h>

#include <stdio.h>
#include <stdlib.h>

static int decode(FILE *file)
{
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png != NULL ? png_create_info_struct(png) : NULL;
    if (info == NULL)
        return EXIT_FAILURE;
    if (setjmp(png_jmpbuf(png)) != 0) {
        png_destroy_read_struct(&png, &info, NULL);
        return EXIT_FAILURE;
    }
    png_init_io(png, file);
    png_read_info(png, info);
    if (png_get_bit_depth(png, info) == 16)
        png_set_swap(png);
    png_read_update_info(png, info);
    png_uint_32 height = png_get_image_height(png, info);
    png_bytep row = png_malloc(png, png_get_rowbytes(png, info));
    for (png_uint_32 y = 0; y < height; y++)
        png_read_row(png, row, NULL);
    png_read_end(png, NULL);
    png_free(png, row);
    png_destroy_read_struct(&png, &info, NULL);
    return EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: png_decode FILE\n");
        return 2;
    }
    FILE *file = fopen(argv[1], "rb");
    if (file == NULL) {
        perror(argv[1]);
        return EXIT_FAILURE;
    }
    int result = decode(file);
    fclose(file);
    return result;
}
