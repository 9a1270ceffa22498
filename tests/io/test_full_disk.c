/* SPDX-License-Identifier: MIT */
/*
 * test_full_disk.c - a disk that runs full, directories that may not be written, and writers
 * that are killed: the old file stays whole, and nothing stays beside it
 *
 * The full disk is a small tmpfs in a mount namespace of its own, which needs root (else this part
 * is skipped).  Everything is done twice: with unnamed temporary files, and with named ones.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "made.h"
#include "ntpio.h"

enum { SMALL = 9, LARGE = 700, SKIPPED = 77, NOBODY = 65534, KILLS = 40 };

static ntpio_error error;
static uint8_t texels[LARGE * LARGE * 3];

/* The writer gets its rows a few at a time. */
static bool write_image(const char *path, ntpio_format format, uint32_t side)
{
    const ntpio_write_options options = {
        .format = format,
        .width = side,
        .height = side,
        .channels = 3,
        .sample_bytes = 1,
        .level = -1,
    };
    ntpio_writer *writer = ntpio_create(path, &options, &error);
    if (writer == NULL)
        return false;
    for (uint32_t y = 0; y < side; y++)
        if (!ntpio_write_rows(writer, texels + y * side * 3, 0, 1, &error)) {
            ntpio_abort(writer);
            return false;
        }
    return ntpio_commit(writer, &error);
}

/* The side of a whole image; everything that is not one ends the test. */
static uint32_t side_of(const char *path)
{
    ntpio_reader *reader = ntpio_open(path, NULL, &error);
    CHECK(reader != NULL);
    const uint32_t side = ntpio_reader_info(reader)->width;
    static uint8_t rows[sizeof texels];
    CHECK(ntpio_read_rows(reader, rows, (ptrdiff_t) side * 3, side, &error));
    CHECK(ntpio_read_end(reader, &error) && memcmp(rows, texels, (size_t) side * side * 3) == 0);
    ntpio_close(reader);
    return side;
}

static int entries(void)
{
    int count = -2; /* . and .. */
    DIR *directory = opendir(".");
    CHECK(directory != NULL);
    while (readdir(directory) != NULL)
        count++;
    closedir(directory);
    return count;
}

static void fails(const char *path, uint32_t side, const char *why)
{
    CHECK(!write_image(path, NTPIO_PNG, side) && error.status == NTPIO_ERR_WRITE);
    CHECK(strncmp(error.message, path, strlen(path)) == 0);
    if (strstr(error.message, why) == NULL) {
        fprintf(stderr, "%s, not: %s\n", error.message, why);
        exit(1);
    }
}

/* In a namespace whose mounts are private. */
static bool own_mounts(void)
{
    return unshare(CLONE_NEWNS) == 0 && mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0;
}

static bool full_disk(void)
{
    CHECK(mkdir("disk", 0777) == 0);
    if (mount("tmpfs", "disk", "tmpfs", 0, "size=200k") != 0) {
        CHECK(rmdir("disk") == 0);
        return false;
    }
    CHECK(chdir("disk") == 0);
    static const ntpio_format formats[] = { NTPIO_PNG, NTPIO_TGA };
    CHECK(write_image("old.png", NTPIO_PNG, SMALL));
    for (size_t i = 0; i < 2; i++) {
        CHECK(!write_image("old.png", formats[i], LARGE) && error.status == NTPIO_ERR_WRITE);
        CHECK(strstr(error.message, strerror(ENOSPC)) != NULL);
        CHECK(side_of("old.png") == SMALL && entries() == 1);
        CHECK(!write_image("new.png", formats[i], LARGE) && entries() == 1);
    }
    CHECK(write_image("old.png", NTPIO_PNG, SMALL + 1) && side_of("old.png") == SMALL + 1);
    CHECK(chdir("..") == 0 && umount2("disk", MNT_DETACH) == 0 && rmdir("disk") == 0);
    return true;
}

static void in_locked_directory(void)
{
    CHECK(chdir("locked") == 0);
    fails("old.png", SMALL + 1, strerror(EACCES));
    fails("new.png", SMALL + 1, strerror(EACCES));
    fails("no/new.png", SMALL, strerror(ENOENT));
    CHECK(side_of("old.png") == SMALL && entries() == 1);
}

/* As a user without special rights. */
static void locked_directory(void)
{
    CHECK(mkdir("locked", 0755) == 0 && chmod(".", 0755) == 0);
    CHECK(write_image("locked/old.png", NTPIO_PNG, SMALL));
    CHECK(chmod("locked", 0555) == 0);
    const pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        CHECK(geteuid() != 0 || (setgid(NOBODY) == 0 && setuid(NOBODY) == 0));
        in_locked_directory();
        _exit(0);
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child && status == 0);
    CHECK(chmod("locked", 0755) == 0 && unlink("locked/old.png") == 0 && rmdir("locked") == 0);
}

/* Writers that are killed at any moment: the file is the old or the new one, and the next writer
 * leaves it alone in its directory. */
static void killed(void)
{
    CHECK(write_image("it.png", NTPIO_PNG, SMALL));
    for (int i = 0; i < KILLS; i++) {
        const pid_t child = fork();
        CHECK(child >= 0);
        if (child == 0) {
            for (uint32_t side = SMALL;; side = side == SMALL ? LARGE / 4 : SMALL)
                if (!write_image("it.png", NTPIO_PNG, side))
                    _exit(1);
        }
        usleep((useconds_t) (200 + sample((uint32_t) i, 5, 5, 14)));
        CHECK(kill(child, SIGKILL) == 0);
        int status = 0;
        CHECK(waitpid(child, &status, 0) == child && WIFSIGNALED(status));
        const uint32_t side = side_of("it.png");
        CHECK(side == SMALL || side == LARGE / 4);
        CHECK(entries() <= 2);
    }
    CHECK(write_image("it.png", NTPIO_PNG, SMALL) && entries() == 1);
    CHECK(unlink("it.png") == 0);
}

int main(void)
{
    char folder[] = "/tmp/ntpio-test-XXXXXX";
    CHECK(mkdtemp(folder) != NULL && chdir(folder) == 0);
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t) sample((uint32_t) i, 3, 1, 8);
    locked_directory();
    killed();
    bool disk = own_mounts() && full_disk();
    /* Without /proc an unnamed file cannot get a name: temporary files with names instead. */
    if (disk && mount("tmpfs", "/proc", "tmpfs", 0, "size=4k") == 0) {
        killed();
        disk = full_disk();
        CHECK(umount2("/proc", MNT_DETACH) == 0); /* LeakSanitizer reads it at the end */
    }
    CHECK(chdir("/") == 0 && rmdir(folder) == 0);
    return disk ? 0 : SKIPPED;
}
