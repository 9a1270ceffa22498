/* SPDX-License-Identifier: MIT */
/*
 * test_output.c - links, modes and names of targets; a failure leaves the old file whole and nothing
 * beside it
 */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "written.h"

static void targets(void)
{
    struct stat st;
    const ntpio_write_options o = rgb(7);
    char name[256];
    memset(name, 'n', 255);
    name[255] = 0;
    const char *const names[] = { name, "a b\n%n\xff", "-x" };
    for (size_t i = 0; i < 3; i++) {
        for (int again = 0; again < 2; again++) /* new, then replaced */
            CHECK(write_all(names[i], &o));
        ntpio_close(read_back(names[i], &o));
        unlink(names[i]);
    }
    CHECK(write_all("real", &o) && chmod("real", 0640) == 0 && symlink("real", "link") == 0);
    CHECK(write_all("link", &o));
    CHECK(lstat("link", &st) == 0 && S_ISLNK(st.st_mode));
    CHECK(stat("real", &st) == 0 && (st.st_mode & 0777) == 0640);
    unlink("real");
    CHECK(write_all("link", &o) && lstat("real", &st) == 0 && S_ISREG(st.st_mode));
    unlink("link");
    unlink("real");
    CHECK(!write_all(".", &o) && error.status == NTPIO_ERR_WRITE);
    CHECK(!write_all("none/x.png", &o) && error.status == NTPIO_ERR_WRITE);
    CHECK(symlink("loop", "loop") == 0 && !write_all("loop", &o));
    unlink("loop");
    CHECK(entries() == 0);
}

static void no_room(void)
{
    const struct rlimit little = { 5000, RLIM_INFINITY };
    struct rlimit all;
    const ntpio_write_options small = rgb(3), large = rgb(500);
    CHECK(write_all("old", &small) && getrlimit(RLIMIT_FSIZE, &all) == 0);
    signal(SIGXFSZ, SIG_IGN);
    CHECK(setrlimit(RLIMIT_FSIZE, &little) == 0);
    CHECK(!write_all("old", &large) && error.status == NTPIO_ERR_WRITE);
    CHECK(!write_all("new", &large) && error.status == NTPIO_ERR_WRITE);
    CHECK(setrlimit(RLIMIT_FSIZE, &all) == 0);
    ntpio_close(read_back("old", &small));
    CHECK(entries() == 1);
    if (access("/dev/full", W_OK) == 0)
        CHECK(!write_all("/dev/full", &large) && error.status == NTPIO_ERR_WRITE);
    unlink("old");
}

/* A writer dies halfway; another leaves a named file, as one without O_TMPFILE would. */
static void killed(void)
{
    const ntpio_write_options small = rgb(3), large = rgb(500);
    CHECK(write_all("old", &small));
    const pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        ntpio_writer *w = ntpio_create("old", &large, &error);
        if (w != NULL)
            ntpio_write_rows(w, noise, 1500, 300, &error);
        raise(SIGKILL);
    }
    CHECK(waitpid(child, NULL, 0) == child);
    ntpio_close(read_back("old", &small));
    const int stale = open(".old.ntp-000001.tmp", O_CREAT | O_WRONLY, 0666);
    const int living = open(".old.ntp-000002.tmp", O_CREAT | O_WRONLY, 0666);
    CHECK(stale >= 0 && living >= 0 && flock(living, LOCK_EX) == 0);
    close(stale);
    CHECK(write_all("old", &small));
    CHECK(access(".old.ntp-000001.tmp", F_OK) != 0 && access(".old.ntp-000002.tmp", F_OK) == 0);
    close(living);
    CHECK(write_all("old", &small) && entries() == 1);
    ntpio_writer *w = ntpio_create("old", &large, &error);
    CHECK(w != NULL && !ntpio_commit(w, &error) && error.status == NTPIO_ERR_USAGE);
    ntpio_close(read_back("old", &small));
    ntpio_write_options dry = large;
    dry.dry_run = true;
    CHECK(write_all("dry", &dry) && entries() == 1);
    unlink("old");
}

/* What somebody does to the input just before the program renames for the n-th time. */
typedef void rival(unsigned n);
static rival *act;
static unsigned renames;
static bool unsupported;

#ifdef RENAME_EXCHANGE
/* In the place of that of the C library. */
int renameat2(int from, const char *old, int to, const char *name, unsigned flags)
{
    if (act != NULL)
        act(++renames);
    if (unsupported) {
        errno = EINVAL;
        return -1;
    }
    return (int) syscall(SYS_renameat2, from, old, to, name, flags);
}
#endif

static void save(const char *text)
{
    const int fd = open("new", O_CREAT | O_EXCL | O_WRONLY, 0666);
    CHECK(fd >= 0 && write(fd, text, 6) == 6 && close(fd) == 0 && rename("new", "in") == 0);
}

static void saves_once(unsigned n)
{
    if (n == 1)
        save("first ");
}

static void saves_twice(unsigned n)
{
    if (n <= 2)
        save(n == 1 ? "first " : "second");
}

static void rewrites(unsigned n)
{
    const int fd = n == 1 ? open("in", O_WRONLY | O_TRUNC) : -1;
    CHECK(n != 1 || (fd >= 0 && write(fd, "first ", 6) == 6 && close(fd) == 0));
}

static void removes(unsigned n)
{
    CHECK(n != 1 || unlink("in") == 0);
}

static void idles(unsigned n)
{
    (void) n;
}

/* Replaces "in" while a rival works; returns whether it was replaced. */
static bool replaced(rival *by)
{
    ntpio_write_options o = rgb(8);
    act = NULL;
    CHECK(write_all("in", &o));
    ntpio_reader *r = read_back("in", &o);
    const ntpio_stamp stamp = ntpio_reader_info(r)->stamp;
    ntpio_close(r);
    o.read_path = "in";
    o.read_stamp = stamp;
    renames = 0;
    act = by;
    const bool done = write_all("in", &o);
    act = NULL;
    CHECK(done || strstr(error.message, "changed meanwhile") != NULL);
    if (done)
        ntpio_close(read_back("in", &o));
    return done;
}

static bool holds(const char *text)
{
    char bytes[6] = { 0 };
    const int fd = open("in", O_RDONLY);
    const bool same = fd >= 0 && read(fd, bytes, 6) == 6 && memcmp(bytes, text, 6) == 0;
    close(fd);
    return same;
}

/* Somebody saves between the comparison and the rename. */
static void saved_at_the_last_moment(void)
{
    CHECK(replaced(idles) && entries() == 1);
    if (renames > 0) { /* else the system has no exchange */
        CHECK(!replaced(saves_once) && holds("first ") && entries() == 1);
        CHECK(!replaced(rewrites) && holds("first ") && entries() == 1);
        CHECK(!replaced(saves_twice) && holds("second") && entries() == 1);
        CHECK(!replaced(removes) && entries() == 0);
    }
    unsupported = true;
    CHECK(replaced(idles) && entries() == 1);
    unsupported = false;
    unlink("in");
}

int main(void)
{
    CHECK(system_enter_folder());
    make_noise();
    targets();
    no_room();
    killed();
    saved_at_the_last_moment();
    CHECK(system_leave_folder());
    return 0;
}
