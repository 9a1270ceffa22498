/* SPDX-License-Identifier: MIT */
/*
 * help.c - the texts of --help, from the table in options.c
 */
#include <stdio.h>
#include <string.h>

#include "options/options.h"

enum {
    HELP_WIDTH = 79, /* columns of a plain terminal, less one */
    HELP_INDENT = 26 /* where the explanation of an option starts */
};

static void help_option(text *t, const option_spec *row)
{
    text head = { 0 };
    if (row->letter != 0)
        text_addf(&head, "  -%c, --%s", row->letter, row->name);
    else
        text_addf(&head, "      --%s", row->name);
    if (row->kind != KIND_FLAG)
        text_addf(&head, " %s", row->value);
    text_bytes(t, text_string(&head), head.size);
    if (head.size + 2 > HELP_INDENT)
        text_addf(t, "\n%*s", HELP_INDENT, "");
    else
        text_addf(t, "%*s", HELP_INDENT - (int) head.size, "");
    text words = { 0 };
    text_add(&words, row->help);
    if (row->standard != NULL)
        text_addf(&words, " (default: %s)", row->standard);
    text_wrap(t, text_string(&words), HELP_INDENT, HELP_INDENT, HELP_WIDTH);
    text_char(t, '\n');
    text_free(&words);
    text_free(&head);
}

static void help_examples(text *t, const char *examples)
{
    text_add(t, "\nExamples:\n");
    while (*examples != 0) {
        const size_t length = strcspn(examples, "\n");
        text_add(t, "  ");
        text_bytes(t, examples, length);
        text_char(t, '\n');
        examples += length + (examples[length] == '\n');
    }
}

void help_verb(text *t, const verb_spec *verb)
{
    text_addf(t, "Usage: ntp %s [OPTION...] %s\n\n", verb->name, verb->arguments);
    text_wrap(t, verb->description, 0, 0, HELP_WIDTH);
    text_add(t, "\n\nOptions:\n");
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        if (option_is_shown(&OPTION_TABLE[i], verb))
            help_option(t, &OPTION_TABLE[i]);
    }
    help_examples(t, verb->examples);
}

void help_program(text *t)
{
    text_add(t, "Usage: ntp VERB [OPTION...] PATH...\n\n");
    text_wrap(
        t,
        "Checks, repairs and converts normals textures (normal maps), of any size. " HELP_FORMATS,
        0, 0, HELP_WIDTH);
    text_add(t, "\n\nVerbs:\n");
    for (size_t i = 0; i < VERB_ROWS; i++)
        text_addf(t, "  %-11s %s\n", VERB_TABLE[i].name, VERB_TABLE[i].summary);
    text_add(t, "  help        print this help, or that of a verb\n"
                "\nVerbs of the Python package normaltexture, if it is installed beside ntp:\n");
    for (size_t i = 0; i < COMPANIONS; i++)
        text_addf(t, "  %-11s %s\n", COMPANION_TABLE[i].name, COMPANION_TABLE[i].summary);
    text_add(t, "\n");
    text_wrap(
        t,
        "ntp VERB --help describes a verb and its options. PATH is a file, a directory (with "
        "-r also its subdirectories), or - for standard input or output; -- ends options. Any "
        "other VERB runs the program ntp-VERB in the directory of ntp.",
        0, 0, HELP_WIDTH);
    text_add(t, "\n\nExit codes:\n"
                "  0    all is well, or done\n"
                "  1    findings at or above --fail-on; differences; refused files\n"
                "  2    wrong usage\n"
                "  3    an input could not be read or an output not written (the rest is done)\n"
                "  130  interrupted\n"
                "\nntp --version prints the versions of ntp and of its image libraries.\n");
}
