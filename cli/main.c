/* SPDX-License-Identifier: MIT */
/*
 * main.c - from the first word to a verb, our own or a program that stands beside ntp
 */
#include <errno.h>
#include <libgen.h>
#include <libntp.h>
#include <ntpio.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "options.h"

_Atomic int interrupted_by;

static void on_signal(int number)
{
    interrupted_by = number;
}

/* The first signal asks for an orderly end, the second ends at once. */
static void catch_signals(void)
{
    const struct sigaction action = { .sa_handler = on_signal, .sa_flags = (int) SA_RESETHAND };
    static const int ENDING[] = { SIGINT, SIGTERM, SIGHUP };
    for (size_t i = 0; i < sizeof ENDING / sizeof ENDING[0]; i++) {
        struct sigaction old;
        if (sigaction(ENDING[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN)
            sigaction(ENDING[i], &action, NULL);
    }
    signal(SIGPIPE, SIG_IGN);
}

static int finish(int code)
{
    output_flush();
    return output_failed() ? NTP_EXIT_FAILED : code;
}

static int print_text(text *t)
{
    output_text(t);
    text_free(t);
    return finish(NTP_EXIT_DONE);
}

static int print_version(void)
{
    const uint32_t v = ntp_version();
    text t = { 0 };
    text_addf(&t, "ntp %d.%d.%d\nlibntp %u.%u.%u\n%s\n", NTP_VERSION_MAJOR, NTP_VERSION_MINOR,
              NTP_VERSION_PATCH, v >> 16, v >> 8 & 255, v & 255, ntpio_versions());
    return print_text(&t);
}

static int print_help(const char *verb_name)
{
    text t = { 0 };
    const verb_spec *verb = verb_name != NULL ? verb_find(verb_name) : NULL;
    if (verb_name != NULL && verb == NULL) {
        complain_unknown_verb(verb_name);
        return NTP_EXIT_USAGE;
    }
    if (verb != NULL)
        help_verb(&t, verb);
    else
        help_program(&t);
    return print_text(&t);
}

static int print_generated(const char *what)
{
    text t = { 0 };
    if (what == NULL || !generate(&t, what)) {
        complain("--generate makes man, bash, zsh, fish or findings");
        return NTP_EXIT_USAGE;
    }
    return print_text(&t);
}

/* The directory that this program was started from, or NULL. */
static char *own_directory(const char *started_as)
{
    char *self = realpath("/proc/self/exe", NULL);
    if (self == NULL && strchr(started_as, '/') != NULL)
        self = realpath(started_as, NULL);
    if (self == NULL)
        return NULL;
    char *directory = copy_string(dirname(self));
    free(self);
    return directory;
}

/* Becomes ntp-VERB from our own directory; returns where there is none. */
static int run_external(const char *started_as, const char *verb, char **argv)
{
    const bool plain =
        verb[0] != 0 && strspn(verb, "abcdefghijklmnopqrstuvwxyz0123456789-") == strlen(verb);
    char *directory = plain ? own_directory(started_as) : NULL;
    if (directory != NULL) {
        text name = { 0 };
        text_addf(&name, "ntp-%s", verb);
        char *path = join_path(directory, text_string(&name));
        argv[0] = path;
        signal(SIGPIPE, SIG_DFL);
        execv(path, argv);
        const int error = errno;
        text_free(&name);
        free(directory);
        if (error != ENOENT) {
            complain("%s: %s", path, strerror(error));
            return NTP_EXIT_FAILED;
        }
        free(path);
    }
    complain_unknown_verb(verb);
    return NTP_EXIT_USAGE;
}

static int run_verb(const verb_spec *verb, int argc, char **argv)
{
    options o;
    int code = NTP_EXIT_USAGE;
    if (options_parse(&o, verb, argc, argv)) {
        if (option_given(&o, OPT_HELP)) {
            code = print_help(verb->name);
        } else {
            catch_signals();
            code = finish(verb->run(&o));
        }
    }
    options_free(&o);
    return code;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        text t = { 0 };
        help_program(&t);
        fputs(text_string(&t), stderr);
        text_free(&t);
        return NTP_EXIT_USAGE;
    }
    const char *word = argv[1];
    signal(SIGPIPE, SIG_IGN);
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0)
        return print_help(NULL);
    if (strcmp(word, "help") == 0)
        return print_help(argc > 2 ? argv[2] : NULL);
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0)
        return print_version();
    if (strcmp(word, "--generate") == 0)
        return print_generated(argv[2]);
    if (word[0] == '-') {
        complain("the first word is a verb, --help or --version, not \"%s\"", word);
        return NTP_EXIT_USAGE;
    }
    const verb_spec *verb = verb_find(word);
    if (verb == NULL)
        return run_external(argv[0], word, argv + 1);
    return run_verb(verb, argc - 1, argv + 1);
}
