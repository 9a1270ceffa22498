/* SPDX-License-Identifier: MIT */
/*
 * replay_main.c - runs a fuzz target over files: replay FILE_OR_DIRECTORY...
 *
 * Replaces libFuzzer, so that any compiler can replay a corpus.  Each file is also run without its
 * second half, and with single bits flipped.
 */
#include <dirent.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST = 1 << 20, FLIPS = 24 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned long runs;

/* A copy of the exact size, so that reading past the end is caught. */
static void run(const uint8_t *data, size_t size, size_t flipped_byte, unsigned bit)
{
    uint8_t *copy = malloc(size > 0 ? size : 1);
    if (copy == NULL)
        exit(EXIT_FAILURE);
    memcpy(copy, data, size);
    if (flipped_byte < size)
        copy[flipped_byte] ^= (uint8_t) (1u << bit);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
    runs++;
}

static void replay_file(FILE *file)
{
    static uint8_t data[LARGEST];
    size_t size = fread(data, 1, sizeof data, file);
    run(data, size, SIZE_MAX, 0);
    run(data, size / 2, SIZE_MAX, 0);
    /* Dense at the start, where headers are, and sparse beyond. */
    for (size_t i = 0, at = 0; i < FLIPS && at < size; i++, at += 1 + at / 2)
        run(data, size, at, (unsigned) (i % 8));
}

static void replay(const char *path)
{
    DIR *directory = opendir(path);
    if (directory == NULL) {
        FILE *file = fopen(path, "rb");
        if (file == NULL) {
            perror(path);
            exit(EXIT_FAILURE);
        }
        replay_file(file);
        fclose(file);
        return;
    }
    for (const struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        char child[PATH_MAX];
        if (entry->d_name[0] == '.')
            continue;
        int length = snprintf(child, sizeof child, "%s/%s", path, entry->d_name);
        if (length > 0 && (size_t) length < sizeof child)
            replay(child);
    }
    closedir(directory);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        replay(argv[i]);
    printf("%lu inputs\n", runs);
    return runs > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
