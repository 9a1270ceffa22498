/* SPDX-License-Identifier: MIT */
/*
 * main.c - from the first word to a verb: one of ours, or a program ntp-VERB beside ntp
 */
#include <errno.h>
#include <libntp.h>
#include <ntpio.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "generate.h"
#include "options/options.h"
#include "os/console.h"
#include "os/files.h"
#include "os/memory.h"
#include "verbs/verbs.h"

static void on_interruption(int number)
{
    interrupted_by = number;
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

static int print_help(const verb_spec *verb)
{
    text t = { 0 };
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

/* The directory of an absolute path; frees the path, which may be NULL. */
static char *directory_of(char *path)
{
    char *slash = path != NULL ? strrchr(path, '/') : NULL;
    if (slash != NULL)
        slash[slash == path] = 0;
    else
        free(path);
    return slash != NULL ? path : NULL;
}

/* Becomes the program ntp-VERB of a directory; frees `directory`.  Returns false if there is
 * none, and true, after a message, if it cannot be run. */
static bool failed_to_become(char *directory, const char *verb, char **argv)
{
    text name = { 0 };
    text_addf(&name, "ntp-%s", verb);
    char *path = join_path(directory, text_string(&name));
    text_free(&name);
    free(directory);
    argv[0] = path;
    os_become(argv);
    const int error = errno;
    os_file file;
    const bool found = os_look(path, &file);
    if (found) /* ENOENT is then about the first line of a script */
        complain("%s: %s", path, error == ENOENT ? "its interpreter is missing" : strerror(error));
    free(path);
    return found;
}

/*
 * Becomes ntp-VERB of our own directory, or returns if there is none.  Our directory is that of
 * this executable, or that of the script of an installed wheel which started it under the script's
 * name.  PATH is never used.
 */
static int run_external(const char *started_as, const char *verb, char **argv)
{
    const bool plain =
        verb[0] != 0 && strspn(verb, "abcdefghijklmnopqrstuvwxyz0123456789-") == strlen(verb);
    for (int way = 0; plain && way < 2; way++) {
        char *own = way == 0                  ? os_own_path()
                    : strchr(started_as, '/') ? os_real_path(started_as)
                                              : NULL;
        char *directory = directory_of(own);
        if (directory != NULL && failed_to_become(directory, verb, argv))
            return NTP_EXIT_FAILED;
    }
    complain_unknown_verb(verb);
    return NTP_EXIT_USAGE;
}

/* "help VERB": a program beside ntp prints its own --help. */
static int explain_verb(const char *started_as, const char *name)
{
    const verb_spec *verb = verb_find(name);
    char help[] = "--help";
    char *words[] = { NULL, help, NULL };
    return verb != NULL ? print_help(verb) : run_external(started_as, name, words);
}

/* The functions of the verbs, for every row of the table in options.c. */
static int run_parsed(const options *o)
{
    static const struct {
        unsigned verb_bit;
        int (*run)(const options *o);
    } VERBS[] = {
        { V_CHECK, check_run },
        { V_CLEAN, clean_run },
        { V_CONVERT, convert_run },
        { V_HEATMAP, heatmap_run },
        { V_DUMP, dump_run },
        { V_DIFF, diff_run },
        { V_FROM_HEIGHT, from_height_run },
        { V_TRANSFORM, transform_run },
        { V_RESIZE, resize_run },
        { V_BLEND, blend_run },
        { V_TO_HEIGHT, to_height_run },
        { V_CURVATURE, curvature_run },
        { V_OCCLUSION, occlusion_run },
        { V_TO_DEPTH, to_depth_run },
    };
    for (size_t i = 0; i < sizeof VERBS / sizeof VERBS[0]; i++) {
        if (VERBS[i].verb_bit == o->verb_bit)
            return VERBS[i].run(o);
    }
    return NTP_EXIT_USAGE;
}

static int run_verb(const verb_spec *verb, int argc, char **argv)
{
    options o;
    int code = NTP_EXIT_USAGE;
    if (options_parse(&o, verb, argc, argv)) {
        if (option_given(&o, OPT_HELP)) {
            code = print_help(verb);
        } else {
            os_on_interruption(on_interruption);
            code = finish(run_parsed(&o));
        }
    }
    options_free(&o);
    return code;
}

int main(int argc, char **argv)
{
    os_start(&argc, &argv);
    if (argc < 2) {
        text t = { 0 };
        help_program(&t);
        fputs(text_string(&t), stderr);
        text_free(&t);
        return NTP_EXIT_USAGE;
    }
    const char *word = argv[1];
    os_keep_write_errors();
    os_keep_memory();
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0)
        return print_help(NULL);
    if (strcmp(word, "help") == 0 && argc > 2)
        return explain_verb(argv[0], argv[2]);
    if (strcmp(word, "help") == 0)
        return print_help(NULL);
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
