/* SPDX-License-Identifier: MIT */
/*
 * parse.c - from words to options, by popt
 *
 * popt splits the words; the table in options.c says what they mean.  Values are read here and not
 * by popt: so messages name the option, the value and what was expected.
 */
#include <errno.h>
#include <popt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "options/options.h"

const verb_spec *verb_find(const char *name)
{
    for (size_t i = 0; i < VERB_ROWS; i++) {
        if (strcmp(VERB_TABLE[i].name, name) == 0)
            return &VERB_TABLE[i];
    }
    return NULL;
}

unsigned verb_bit(const verb_spec *verb)
{
    return 1U << (verb - VERB_TABLE);
}

bool option_is_shown(const option_spec *row, const verb_spec *verb)
{
    return row->help != NULL && (row->verbs & verb_bit(verb)) != 0;
}

const char *nearest_name(const char *wrong, const char *const *names, size_t count)
{
    enum { FAR = 3 }; /* with three wrong letters it is another word */
    const char *nearest = NULL;
    unsigned least = FAR;
    for (size_t i = 0; i < count; i++) {
        const unsigned distance = edit_distance(wrong, names[i]);
        if (distance < least && distance < strlen(names[i])) {
            least = distance;
            nearest = names[i];
        }
    }
    /* "--rec" for --recursive: popt knows no abbreviations, so they are suggested */
    for (size_t i = 0; nearest == NULL && i < count && strlen(wrong) >= 2; i++) {
        if (strncmp(wrong, names[i], strlen(wrong)) == 0)
            nearest = names[i];
    }
    return nearest;
}

void complain_unknown_verb(const char *name)
{
    const char *names[64];
    size_t count = 0;
    for (size_t i = 0; i < VERB_ROWS; i++)
        names[count++] = VERB_TABLE[i].name;
    for (size_t i = 0; i < COMPANIONS; i++)
        names[count++] = COMPANION_TABLE[i].name;
    names[count++] = "help";
    const char *nearest = nearest_name(name, names, count);
    if (nearest != NULL && strcmp(nearest, name) == 0)
        complain("ntp %s is a separate program, ntp-%s, which the Python package normaltexture "
                 "installs beside ntp; it is not installed here",
                 name, name);
    else if (nearest != NULL)
        complain("no verb \"%s\"; did you mean \"%s\"?", name, nearest);
    else
        complain("no verb \"%s\"; ntp --help lists them", name);
}

static bool wrong_value(const option_spec *row, const char *value, const char *expected)
{
    complain("--%s: \"%s\" is not %s", row->name, value, expected);
    return false;
}

/* The place of a word in "a|b|c", or -1. */
static int64_t choice_place(const char *choices, const char *word)
{
    const size_t size = strlen(word);
    for (int64_t i = 0;; i++) {
        const size_t length = strcspn(choices, "|");
        if (size == length && strncmp(choices, word, length) == 0)
            return i;
        if (choices[length] == 0)
            return -1;
        choices += length + 1;
    }
}

/* Words that mean another choice, where both are listed. */
static const char *meaning_of(const char *word)
{
    return strcmp(word, "opengl") == 0 ? "up" : strcmp(word, "directx") == 0 ? "down" : word;
}

/* "; did you mean sobel3 or sobel5?": the choices that begin with the word, in either case. */
static void add_guesses(text *t, const char *choices, const char *word)
{
    const size_t size = strlen(word);
    const char *separator = "; did you mean ";
    for (const char *c = choices; size >= 2;) {
        const size_t length = strcspn(c, "|");
        if (strncasecmp(c, word, size) == 0) {
            text_add(t, separator);
            text_bytes(t, c, length);
            separator = " or ";
        }
        if (c[length] == 0)
            break;
        c += length + 1;
    }
    if (strcmp(separator, " or ") == 0)
        text_char(t, '?');
}

static bool read_choice(const option_spec *row, const char *value, option_value *into)
{
    if (choice_place(row->value, value) >= 0) {
        into->string = meaning_of(value);
        into->integer = choice_place(row->value, into->string);
        return true;
    }
    text expected = { 0 };
    text_add(&expected, "one of ");
    for (const char *c = row->value; *c != 0; c++) {
        if (*c == '|')
            text_add(&expected, ", ");
        else
            text_char(&expected, *c);
    }
    add_guesses(&expected, row->value, value);
    wrong_value(row, value, text_string(&expected));
    text_free(&expected);
    return false;
}

/* "S|auto": a number that may be left to the program. */
static bool may_be_auto(const option_spec *row)
{
    const char *bar = strchr(row->value, '|');
    return bar != NULL && strcmp(bar, "|auto") == 0;
}

static bool read_number(const option_spec *row, const char *value, option_value *into)
{
    if (may_be_auto(row) && strcmp(value, "auto") == 0)
        return true;
    char *end = NULL;
    errno = 0;
    const double number = strtod(value, &end);
    const bool whole = row->kind == KIND_INTEGER;
    /* plain decimals only: no hexadecimal, no "nan", no leading blank */
    const size_t length = strspn(value, "0123456789.eE+-");
    const char *rest = value + length;
    const bool percent = strcmp(row->value, "PERCENT") == 0 && strcmp(rest, "%") == 0;
    const bool plain = length > 0 && (*rest == 0 || percent);
    const bool bad =
        !plain || end != rest || errno != 0 || (whole && strpbrk(value, ".eE") != NULL);
    if (bad || !(number >= row->least && number <= row->most)) {
        char expected[80];
        snprintf(expected, sizeof expected, "%sa%s number from %.15g to %.15g",
                 may_be_auto(row) ? "auto or " : "", whole ? " whole" : "", row->least, row->most);
        return wrong_value(row, value, expected);
    }
    into->number = number;
    into->integer = (int64_t) number;
    return true;
}

/* Takes over `value`, which popt allocated; it is NULL for flags. */
static bool read_value(options *o, const option_spec *row, char *value)
{
    option_value *into = &o->values[row->id];
    into->given = true;
    into->integer = 1;
    if (row->kind == KIND_FLAG)
        return true;
    into->all = need(realloc(into->all, (into->count + 1) * sizeof *into->all));
    into->all[into->count++] = value;
    into->string = value;
    if (row->kind == KIND_CHOICE)
        return read_choice(row, value, into);
    if (row->kind == KIND_INTEGER || row->kind == KIND_NUMBER)
        return read_number(row, value, into);
    if (value[0] == 0) {
        complain("--%s: the value is empty", row->name);
        return false;
    }
    return true;
}

static void set_defaults(options *o)
{
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        const option_spec *row = &OPTION_TABLE[i];
        if ((row->verbs & o->verb_bit) == 0 || row->standard == NULL)
            continue;
        option_value *into = &o->values[row->id];
        into->string = row->standard;
        if (row->kind == KIND_CHOICE)
            read_choice(row, row->standard, into);
        else if (row->kind == KIND_INTEGER || row->kind == KIND_NUMBER)
            read_number(row, row->standard, into);
    }
}

static void complain_bad_option(const options *o, const char *bad)
{
    const char *names[OPT_COUNT];
    size_t count = 0;
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        if (option_is_shown(&OPTION_TABLE[i], o->verb))
            names[count++] = OPTION_TABLE[i].name;
    }
    char *word = copy_string(bad + strspn(bad, "-"));
    word[strcspn(word, "=")] = 0;
    const char *nearest = strncmp(bad, "--", 2) == 0 ? nearest_name(word, names, count) : NULL;
    if (nearest != NULL)
        complain("ntp %s has no option \"%s\"; did you mean --%s?", o->verb->name, bad, nearest);
    else
        complain("ntp %s has no option \"%s\"; ntp %s --help lists them", o->verb->name, bad,
                 o->verb->name);
    free(word);
}

static void complain_popt(const options *o, poptContext context, int error)
{
    const char *bad = poptBadOption(context, POPT_BADOPTION_NOALIAS);
    if (bad == NULL)
        bad = "";
    if (error == POPT_ERROR_BADOPT)
        complain_bad_option(o, bad);
    else if (error == POPT_ERROR_NOARG)
        complain("%s needs a value", bad);
    else if (error == POPT_ERROR_UNWANTEDARG)
        complain("%s takes no value", bad);
    else
        complain("%s: %s", bad, poptStrerror(error));
}

static struct poptOption *popt_table(const options *o)
{
    struct poptOption *table = need(calloc(OPTION_ROWS + 1, sizeof *table));
    size_t n = 0;
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        const option_spec *row = &OPTION_TABLE[i];
        if ((row->verbs & o->verb_bit) == 0)
            continue;
        table[n++] = (struct poptOption) {
            .longName = row->name,
            .shortName = row->letter,
            .argInfo = row->kind == KIND_FLAG ? POPT_ARG_NONE : POPT_ARG_STRING,
            .val = (int) i + 1,
        };
    }
    return table;
}

bool options_parse(options *o, const verb_spec *verb, int argc, char **argv)
{
    *o = (options) { .verb = verb, .verb_bit = verb_bit(verb) };
    set_defaults(o);
    struct poptOption *table = popt_table(o);
    const char **words = need(calloc((size_t) argc + 1, sizeof *words));
    for (int i = 0; i < argc; i++)
        words[i] = argv[i];
    poptContext context = need(poptGetContext(NULL, argc, words, table, 0));
    bool ok = true;
    int row = 0;
    while (ok && (row = poptGetNextOpt(context)) > 0)
        ok = read_value(o, &OPTION_TABLE[row - 1], poptGetOptArg(context));
    if (ok && row < -1) {
        complain_popt(o, context, row);
        ok = false;
    }
    for (const char *path; ok && (path = poptGetArg(context)) != NULL;) {
        o->paths = need(realloc(o->paths, (o->path_count + 1) * sizeof *o->paths));
        o->paths[o->path_count++] = copy_string(path);
    }
    poptFreeContext(context);
    free(words);
    free(table);
    return ok;
}

void options_free(options *o)
{
    for (size_t i = 0; i < OPT_COUNT; i++) {
        for (size_t k = 0; k < o->values[i].count; k++)
            free(o->values[i].all[k]);
        free(o->values[i].all);
    }
    for (size_t i = 0; i < o->path_count; i++)
        free(o->paths[i]);
    free(o->paths);
}
