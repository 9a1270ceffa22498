/* SPDX-License-Identifier: MIT */
/*
 * clean_texture.c - says what a texture is and how large its errors are, and writes a clean copy
 *
 *     clean_texture IN.rgb WIDTH HEIGHT OUT.rgb     8-bit RGB rows without a header
 *     clean_texture                                 a small texture made here
 *
 * Build: cc clean_texture.c $(pkg-config --cflags --libs libntp)
 */
#include <libntp.h>

#include <stdio.h>
#include <stdlib.h>

static unsigned char encode(double v)
{
    return (unsigned char) ((v + 1) / 2 * 255 + 0.5);
}

/* A bump; its z is an approximation that is good for gentle slopes only. */
static void make_bump(unsigned char *rgb, int width, int height)
{
    for (int row = 0; row < height; row++) {
        for (int column = 0; column < width; column++) {
            double x = 0.6 * (2 * column - width + 1) / width;
            double y = 0.6 * (height - 1 - 2 * row) / height;
            *rgb++ = encode(x);
            *rgb++ = encode(y);
            *rgb++ = encode(1 - (x * x + y * y) / 2);
        }
    }
}

static int fail(const char *what, ntp_status status)
{
    fprintf(stderr, "%s: %s\n", what, ntp_status_string(status));
    return EXIT_FAILURE;
}

/* Measures, says what it is, and cleans in place. */
static int process(unsigned char *rgb, int width, int height)
{
    ntp_image image = ntp_image_packed(rgb, width, height, 3, NTP_TYPE_U8);
    ntp_const_image source = ntp_image_as_const(&image);

    ntp_tally *tally = (ntp_tally *) calloc(1, ntp_tally_size());
    if (tally == NULL)
        return fail("tally", NTP_ERR_SCRATCH);
    ntp_stats stats;
    ntp_status status = ntp_tally_add(tally, &source, 0, NULL);
    if (status == NTP_OK)
        status = ntp_tally_summarize(&stats, tally, NTP_ENCODING_STANDARD);
    ntp_classification found;
    if (status == NTP_OK)
        status = ntp_classify(&found, tally);
    free(tally);
    if (status != NTP_OK)
        return fail("measure", status);

    printf("%s, confidence %.2f\n", ntp_class_name(found.type), found.confidence);
    for (int i = 0; i < found.reason_count; i++) {
        char text[200];
        ntp_reason_text(text, sizeof text, &found.reasons[i]);
        printf("  %s\n", text);
    }
    printf("%.1f %% of %llu texels are no unit vector; off by at most %.2f degrees\n",
           100.0 * (double) (stats.texels - stats.standard.neighbor) / (double) stats.texels,
           (unsigned long long) stats.texels, stats.angles.max);

    if (found.type != NTP_CLASS_STANDARD && found.type != NTP_CLASS_ONE_COLOR) {
        fprintf(stderr, "not a standard normals texture: left as it is\n");
        return EXIT_FAILURE;
    }
    ntp_clean_counts counts = { 0, 0 };
    status = ntp_clean(&image, &source, NULL, NULL, &counts, NULL);
    if (status != NTP_OK)
        return fail("clean", status);
    printf("cleaned: %llu texels changed\n", (unsigned long long) counts.changed);
    return EXIT_SUCCESS;
}

static int read_file(unsigned char *rgb, size_t size, const char *path)
{
    FILE *file = fopen(path, "rb");
    size_t got = file != NULL ? fread(rgb, 1, size, file) : 0;
    if (file == NULL)
        perror(path);
    else
        fclose(file);
    if (file != NULL && got != size)
        fprintf(stderr, "%s: shorter than WIDTH x HEIGHT x 3 bytes\n", path);
    return got == size;
}

static int write_file(const unsigned char *rgb, size_t size, const char *path)
{
    FILE *file = fopen(path, "wb");
    int written = file != NULL && fwrite(rgb, 1, size, file) == size;
    if (file != NULL && fclose(file) != 0)
        written = 0;
    if (!written)
        perror(path);
    return written;
}

int main(int argc, char **argv)
{
    if (argc != 1 && argc != 5) {
        fprintf(stderr, "usage: %s [IN.rgb WIDTH HEIGHT OUT.rgb]\n", argv[0]);
        return 2;
    }
    long width = argc == 5 ? strtol(argv[2], NULL, 10) : 64;
    long height = argc == 5 ? strtol(argv[3], NULL, 10) : 64;
    if (width < 1 || height < 1 || width > NTP_MAX_SIDE || height > NTP_MAX_SIDE) {
        fprintf(stderr, "width and height are 1..%d\n", NTP_MAX_SIDE);
        return 2;
    }
    size_t size = (size_t) width * (size_t) height * 3;
    unsigned char *rgb = (unsigned char *) malloc(size);
    int result = EXIT_FAILURE;
    if (rgb == NULL) {
        perror("texture");
    } else if (argc == 1) {
        make_bump(rgb, (int) width, (int) height);
        result = process(rgb, (int) width, (int) height);
    } else if (read_file(rgb, size, argv[1])) {
        result = process(rgb, (int) width, (int) height);
        if (result == EXIT_SUCCESS && !write_file(rgb, size, argv[4]))
            result = EXIT_FAILURE;
    }
    free(rgb);
    return result;
}
