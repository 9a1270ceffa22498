/* SPDX-License-Identifier: MIT */
/*
 * replay.c - runs a fuzz target over files and directories of files, without libFuzzer
 */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { INPUT_MAX = 1 << 20, PATH_SIZE = 4096 };

static int run(const char *path)
{
    FILE *file = fopen(path, "rb");
    uint8_t *data = malloc(INPUT_MAX);
    if (file == NULL || data == NULL) {
        perror(path);
        exit(EXIT_FAILURE);
    }
    const size_t size = fread(data, 1, INPUT_MAX, file);
    fclose(file);
    LLVMFuzzerTestOneInput(data, size);
    free(data);
    return 1;
}

static int run_all(const char *path)
{
    DIR *directory = opendir(path);
    int count = 0;
    if (directory == NULL)
        return run(path);
    for (const struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        char inner[PATH_SIZE];
        const int size = snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] != '.' && size > 0 && (size_t) size < sizeof inner)
            count += run(inner);
    }
    closedir(directory);
    return count;
}

int main(int argc, char **argv)
{
    int count = 0;
    for (int i = 1; i < argc; i++)
        count += run_all(argv[i]);
    printf("%d inputs\n", count);
    return count != 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
