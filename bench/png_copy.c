/* SPDX-License-Identifier: MIT */
/*
 * png_copy.c - copies a PNG file with libpng, row by row: png_copy IN OUT
 *
 * The reference for `ntp clean`: libpng's own defaults, the same sync and rename, and nothing between
 * them.
 */
#include <fcntl.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { BUFFER_SIZE = 1 << 18, READ_SIZE = 1 << 16 };

static int copy(FILE *in, FILE *out)
{
    png_structp reader = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    if (reader == NULL || writer == NULL)
        return EXIT_FAILURE;
    png_infop from = png_create_info_struct(reader), to = png_create_info_struct(writer);
    if (from == NULL || to == NULL || setjmp(png_jmpbuf(reader)) != 0 ||
        setjmp(png_jmpbuf(writer)) != 0)
        return EXIT_FAILURE;
    png_init_io(reader, in);
    png_set_compression_buffer_size(reader, READ_SIZE);
    png_read_info(reader, from);
    const png_uint_32 height = png_get_image_height(reader, from);
    const int depth = png_get_bit_depth(reader, from);
    png_init_io(writer, out);
    png_set_compression_buffer_size(writer, BUFFER_SIZE);
    png_set_IHDR(writer, to, png_get_image_width(reader, from), height, depth,
                 png_get_color_type(reader, from), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(writer, to);
    if (depth == 16) {
        png_set_swap(reader);
        png_set_swap(writer);
    }
    png_read_update_info(reader, from);
    png_bytep row = png_malloc(reader, png_get_rowbytes(reader, from));
    for (png_uint_32 y = 0; y < height; y++) {
        png_read_row(reader, row, NULL);
        png_write_row(writer, row);
    }
    png_read_end(reader, NULL);
    png_write_end(writer, to);
    png_free(reader, row);
    png_destroy_read_struct(&reader, &from, NULL);
    png_destroy_write_struct(&writer, &to);
    return EXIT_SUCCESS;
}

/* Makes the rename durable. */
static int sync_directory_of(const char *path)
{
    char directory[4096];
    const int size = snprintf(directory, sizeof directory, "%s", path);
    if (size < 0 || (size_t) size >= sizeof directory)
        return -1;
    size_t end = (size_t) size;
    while (end > 0 && directory[end - 1] != '/')
        end--;
    directory[end] = 0;
    const int fd = open(end == 0 ? "." : directory, O_RDONLY);
    if (fd < 0)
        return -1;
    const int result = fsync(fd);
    close(fd);
    return result;
}

int main(int argc, char **argv)
{
    char temporary[4096];
    if (argc != 3) {
        fprintf(stderr, "usage: png_copy IN OUT\n");
        return 2;
    }
    const int size = snprintf(temporary, sizeof temporary, "%s.copying", argv[2]);
    if (size < 0 || (size_t) size >= sizeof temporary)
        return 2;
    FILE *in = fopen(argv[1], "rb"), *out = fopen(temporary, "wb");
    if (in == NULL || out == NULL) {
        perror("png_copy");
        return EXIT_FAILURE;
    }
    setvbuf(in, NULL, _IOFBF, READ_SIZE);
    setvbuf(out, NULL, _IOFBF, BUFFER_SIZE);
    if (copy(in, out) != EXIT_SUCCESS || fflush(out) != 0 || fsync(fileno(out)) != 0 ||
        fclose(out) != 0 || rename(temporary, argv[2]) != 0 || sync_directory_of(argv[2]) != 0) {
        fprintf(stderr, "png_copy: failed\n");
        return EXIT_FAILURE;
    }
    fclose(in);
    return EXIT_SUCCESS;
}
