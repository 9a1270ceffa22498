/* SPDX-License-Identifier: MIT */
/*
 * generate.c - the man page, the shell completions and the list of findings, from the tables
 *
 * `ntp --generate WHAT` prints them while the project is built.
 */
#include "generate.h"

#include <libntp.h>
#include <stdio.h>
#include <string.h>

#include "findings/findings.h"
#include "options/options.h"

/* ------------------------------------------------------------------------- man page */

static void roff(text *t, const char *words)
{
    bool at_line_start = true;
    for (; *words != 0; words++) {
        if (at_line_start && (*words == '.' || *words == '\''))
            text_add(t, "\\&");
        at_line_start = *words == '\n';
        if (*words == '\\')
            text_add(t, "\\e");
        else if (*words == '-')
            text_add(t, "\\-");
        else if (*words == '\n')
            text_add(t, "\n.PP\n");
        else
            text_char(t, *words);
    }
}

static void man_option(text *t, const option_spec *row)
{
    text_add(t, ".TP\n\\fB");
    if (row->letter != 0)
        text_addf(t, "\\-%c\\fR, \\fB", row->letter);
    text_add(t, "\\-\\-");
    roff(t, row->name);
    text_add(t, "\\fR");
    if (row->kind != KIND_FLAG) {
        text_add(t, " \\fI");
        roff(t, row->value);
        text_add(t, "\\fR");
    }
    text_char(t, '\n');
    roff(t, row->help);
    if (row->standard != NULL) {
        text_add(t, " (default: ");
        roff(t, row->standard);
        text_char(t, ')');
    }
    text_add(t, ".\n");
}

static void man_examples(text *t, const char *examples)
{
    text_add(t, ".PP\nExamples:\n.PP\n.nf\n.RS\n");
    while (*examples != 0) {
        const size_t length = strcspn(examples, "\n");
        text line = { 0 };
        text_bytes(&line, examples, length);
        roff(t, text_string(&line));
        text_char(t, '\n');
        text_free(&line);
        examples += length + (examples[length] == '\n');
    }
    text_add(t, ".RE\n.fi\n");
}

static void man_verb(text *t, const verb_spec *verb)
{
    text_add(t, ".SS \"ntp ");
    roff(t, verb->name);
    text_add(t, " [\\fIoption\\fR...] ");
    roff(t, verb->arguments);
    text_add(t, "\"\n");
    roff(t, verb->description);
    text_char(t, '\n');
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        if (option_is_shown(&OPTION_TABLE[i], verb))
            man_option(t, &OPTION_TABLE[i]);
    }
    man_examples(t, verb->examples);
}

static void man_findings(text *t)
{
    text_add(t, ".SH FINDINGS\n");
    for (size_t i = 0; i < FINDING_COUNT; i++) {
        text_addf(t, ".TP\n\\fB%s\\fR (%s)\n", FINDING_TABLE[i].id, FINDING_TABLE[i].levels);
        roff(t, FINDING_TABLE[i].title);
        text_add(t, ".\n");
    }
}

static void generate_man(text *t)
{
    const uint32_t version = ntp_version();
    text_addf(t, ".TH NTP 1 \"\" \"ntp %u.%u.%u\" \"User Commands\"\n", version >> 16,
              version >> 8 & 255, version & 255);
    text_add(t, ".SH NAME\nntp \\- check, repair and convert normals textures (normal maps)\n"
                ".SH SYNOPSIS\n");
    for (size_t i = 0; i < VERB_ROWS; i++) {
        text_addf(t, ".B ntp %s\n[\\fIoption\\fR...] ", VERB_TABLE[i].name);
        roff(t, VERB_TABLE[i].arguments);
        text_add(t, "\n.br\n");
    }
    text_add(t, ".B ntp \\-\\-version\n.SH DESCRIPTION\n");
    roff(
        t,
        "Checks, repairs and converts normals textures, of any size, in little "
        "memory. " HELP_FORMATS "\n"
        "PATH is a file, a directory (with -r also its subdirectories), or - for standard input or "
        "output; -- ends options. Results go to standard output, messages to standard error. "
        "Any other VERB runs the program ntp-VERB in the directory of ntp, never "
        "one from PATH.");
    text_add(t, "\n.SH VERBS\n");
    for (size_t i = 0; i < VERB_ROWS; i++)
        man_verb(t, &VERB_TABLE[i]);
    text_add(t, ".SH VERBS OF THE PYTHON PACKAGE\n");
    for (size_t i = 0; i < COMPANIONS; i++) {
        text_addf(t, ".TP\n.B ntp %s\n", COMPANION_TABLE[i].name);
        roff(t, COMPANION_TABLE[i].summary);
        text_addf(t, "; see ntp %s \\-\\-help\n", COMPANION_TABLE[i].name);
    }
    man_findings(t);
    text_add(t, ".SH EXIT STATUS\n.TP\n0\nAll is well, or done.\n.TP\n1\nFindings at or above "
                "\\-\\-fail\\-on; differences; refused files.\n.TP\n2\nWrong usage.\n.TP\n3\nAn "
                "input could not be read or an output not written; the rest is done.\n.TP\n130\n"
                "Interrupted.\n.SH ENVIRONMENT\n.TP\nNO_COLOR\nIf not empty, no color unless "
                "\\-\\-color always.\n.TP\nCLICOLOR_FORCE\nIf set and not 0, color also where "
                "output is not a terminal.\n");
}

/* ---------------------------------------------------------------------- completions */

static void words_of(text *t, const char *choices)
{
    for (; *choices != 0; choices++)
        text_char(t, *choices == '|' ? ' ' : *choices);
}

static void bash_verb(text *t, const verb_spec *verb)
{
    text_addf(t, "    %s)\n        case $previous in\n", verb->name);
    text all = { 0 };
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        const option_spec *row = &OPTION_TABLE[i];
        if (!option_is_shown(row, verb))
            continue;
        text_addf(&all, " --%s", row->name);
        if (row->letter != 0)
            text_addf(&all, " -%c", row->letter);
        if (row->kind == KIND_FLAG)
            continue;
        text_addf(t, "        --%s", row->name);
        if (row->letter != 0)
            text_addf(t, "|-%c", row->letter);
        if (row->kind == KIND_CHOICE) {
            text_add(t, ") COMPREPLY=($(compgen -W \"");
            words_of(t, row->value);
            text_add(t, "\" -- \"$current\")); return ;;\n");
        } else if (row->kind == KIND_STRING) {
            text_add(t, ") COMPREPLY=($(compgen -f -- \"$current\")); return ;;\n");
        } else {
            text_add(t, ") return ;;\n");
        }
    }
    text_addf(t, "        esac\n        options=\"%s\"\n        ;;\n", text_string(&all) + 1);
    text_free(&all);
}

static void generate_bash(text *t)
{
    text_add(
        t, "# bash completion for ntp\n_ntp()\n{\n"
           "    local current=${COMP_WORDS[COMP_CWORD]} previous= options= verb=${COMP_WORDS[1]}\n"
           "    COMPREPLY=()\n    compopt -o filenames 2>/dev/null\n"
           "    if [ \"$COMP_CWORD\" -gt 1 ]; then\n"
           "        previous=${COMP_WORDS[COMP_CWORD - 1]}\n    else\n"
           "        COMPREPLY=($(compgen -W \"");
    for (size_t i = 0; i < VERB_ROWS; i++)
        text_addf(t, "%s ", VERB_TABLE[i].name);
    for (size_t i = 0; i < COMPANIONS; i++)
        text_addf(t, "%s ", COMPANION_TABLE[i].name);
    text_add(t, "help --help --version\" -- \"$current\"))\n        return\n    fi\n"
                "    case $verb in\n");
    for (size_t i = 0; i < VERB_ROWS; i++)
        bash_verb(t, &VERB_TABLE[i]);
    text_add(t, "    esac\n    case $current in\n"
                "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$current\")) ;;\n"
                "    *) COMPREPLY=($(compgen -f -- \"$current\")) ;;\n    esac\n}\n"
                "complete -F _ntp ntp\n");
}

/* Inside single quotes of zsh, and inside [...] of an option's description. */
static void zsh_words(text *t, const char *words)
{
    for (; *words != 0; words++) {
        if (*words == '\'')
            text_add(t, "'\\''");
        else if (strchr("[]:\\", *words) != NULL)
            text_addf(t, "\\%c", *words);
        else
            text_char(t, *words);
    }
}

/* The first clause of a help text: enough beside an option in a menu. */
static void short_help(text *t, const char *help)
{
    text_bytes(t, help, strcspn(help, ".;:"));
}

static void zsh_option(text *t, const option_spec *row)
{
    text help = { 0 };
    short_help(&help, row->help);
    const char *star = row->id == OPT_MATCH || row->id == OPT_EXCLUDE ? "*" : "";
    for (int form = row->letter != 0 ? 0 : 1; form < 2; form++) {
        text_addf(t, "            '%s", star);
        if (form == 0)
            text_addf(t, "-%c", row->letter);
        else
            text_addf(t, "--%s", row->name);
        text_char(t, '[');
        zsh_words(t, text_string(&help));
        text_char(t, ']');
        if (row->kind == KIND_CHOICE) {
            text_addf(t, ":%s:(", row->name);
            words_of(t, row->value);
            text_char(t, ')');
        } else if (row->kind == KIND_STRING) {
            text_addf(t, ":%s:_files", row->name);
        } else if (row->kind != KIND_FLAG) {
            text_addf(t, ":%s:", row->name);
        }
        text_add(t, "' \\\n");
    }
    text_free(&help);
}

static void generate_zsh(text *t)
{
    text_add(t, "#compdef ntp\n_ntp() {\n    local -a verbs\n    verbs=(\n");
    for (size_t i = 0; i < VERB_ROWS; i++) {
        text_addf(t, "        '%s:", VERB_TABLE[i].name);
        zsh_words(t, VERB_TABLE[i].summary);
        text_add(t, "'\n");
    }
    for (size_t i = 0; i < COMPANIONS; i++)
        text_addf(t, "        '%s:%s'\n", COMPANION_TABLE[i].name, COMPANION_TABLE[i].summary);
    text_add(t,
             "        'help:print help'\n    )\n    if (( CURRENT == 2 )); then\n"
             "        _describe verb verbs\n        return\n    fi\n"
             "    local verb=$words[2]\n    shift words\n    (( CURRENT-- ))\n    case $verb in\n");
    for (size_t i = 0; i < VERB_ROWS; i++) {
        text_addf(t, "    %s)\n        _arguments -s \\\n", VERB_TABLE[i].name);
        for (size_t k = 0; k < OPTION_ROWS; k++) {
            if (option_is_shown(&OPTION_TABLE[k], &VERB_TABLE[i]))
                zsh_option(t, &OPTION_TABLE[k]);
        }
        text_add(t, "            '*:path:_files'\n        ;;\n");
    }
    text_add(t, "    help) _describe verb verbs ;;\n    *) _files ;;\n    esac\n}\n"
                "_ntp \"$@\"\n");
}

static void fish_words(text *t, const char *words)
{
    for (; *words != 0; words++) {
        if (*words == '\'' || *words == '\\')
            text_char(t, '\\');
        text_char(t, *words);
    }
}

static void fish_option(text *t, const option_spec *row, const verb_spec *verb)
{
    text help = { 0 };
    short_help(&help, row->help);
    text_addf(t, "complete -c ntp -n '__fish_seen_subcommand_from %s' -l %s", verb->name,
              row->name);
    if (row->letter != 0)
        text_addf(t, " -s %c", row->letter);
    if (row->kind == KIND_CHOICE) {
        text_add(t, " -x -a '");
        words_of(t, row->value);
        text_char(t, '\'');
    } else if (row->kind == KIND_STRING) {
        text_add(t, " -r");
    } else if (row->kind != KIND_FLAG) {
        text_add(t, " -x");
    }
    text_add(t, " -d '");
    fish_words(t, text_string(&help));
    text_add(t, "'\n");
    text_free(&help);
}

static void generate_fish(text *t)
{
    text_add(t, "# fish completion for ntp\n");
    for (size_t i = 0; i < VERB_ROWS; i++) {
        text_addf(t, "complete -c ntp -n __fish_use_subcommand -f -a %s -d '", VERB_TABLE[i].name);
        fish_words(t, VERB_TABLE[i].summary);
        text_add(t, "'\n");
    }
    for (size_t i = 0; i < COMPANIONS; i++)
        text_addf(t, "complete -c ntp -n __fish_use_subcommand -a %s -d '%s'\n",
                  COMPANION_TABLE[i].name, COMPANION_TABLE[i].summary);
    text_add(t, "complete -c ntp -n __fish_use_subcommand -f -a help -d 'print help'\n");
    for (size_t i = 0; i < VERB_ROWS; i++) {
        for (size_t k = 0; k < OPTION_ROWS; k++) {
            if (option_is_shown(&OPTION_TABLE[k], &VERB_TABLE[i]))
                fish_option(t, &OPTION_TABLE[k], &VERB_TABLE[i]);
        }
    }
}

/* ------------------------------------------------------------------------- findings */

static const char LEVELS[] =
    "\n<a id=\"levels\"></a>\n\n## Levels\n\n"
    "A level says how much a finding matters on the screen. One rule holds for every format and "
    "depth (`--policy harm`, the default).\n\n"
    "The measure is an angle. A renderer either normalizes the three stored components or derives "
    "z from x and y. The two agree on a sound texel. The angle between them is what is wrong "
    "with a texel. A texel that one level more or less in each channel would put right (`--verdict "
    "neighbor`) counts as 0: 8 bits cannot hold it better, and steep normals turn by degrees for "
    "one level. So nothing that an exact encoder or `ntp clean` writes has NT001, NT002 or NT003 "
    "above a note. In an XY-only texture there is no z to compare. There the angle is how far x "
    "and y lie outside the unit circle, a radian for a length of 1.\n\n"
    "| level | when |\n|---|---|\n"
    "| error | more than `--max-fail` percent (2) of the used texels are off by more than "
    "`--max-angle` degrees (5) |\n"
    "| warning | more than a twentieth of that share (0.1 %) is off by more than `--max-angle`; or "
    "the 99th percentile is above a half of `--max-angle` (2.5 degrees); or the mean is above a "
    "fifth of it (1 degree) |\n"
    "| info (a note) | everything else, even if every texel fails |\n\n"
    "The reasons are those of shading. A light at 45 degrees gives a flat surface a diffuse "
    "light of 0.71, which 8-bit sRGB stores as 219. One degree changes it by 0.0123 of the light, "
    "which is 1.7 levels, and 1.8 % of the light that was there.\n\n"
    "- Rounding to 8 bits costs up to 0.4 degrees on gentle slopes: 0.7 of a level, never "
    "visible.\n"
    "- 1 degree on average, 1.8 % of the light: the eye sees 1 to 2 % at the edge between two "
    "areas, "
    "so a whole picture that is off by this can be told from the right one beside it.\n"
    "- 2.5 degrees, 4 levels, 4.5 % of the light: visible in the lines and edges that steep texels "
    "make.\n"
    "- 5 degrees, 9 levels, 9 % of the light: visible in fine detail too, where the eye needs "
    "several times more contrast than between areas.\n"
    "- 2 % of the texels is the reference program's limit. A twentieth of it is 1,049 texels of "
    "1024 x 1024: specks, which the eye finds although the picture as a whole is right.\n\n"
    "`--policy strict` is for pipelines that want bits: every texel that fails `--verdict` makes a "
    "warning, and more than `--max-fail` percent of them make an error, in every format. A shader "
    "that does not normalize shows errors of length too: for such shaders strict is the better "
    "choice. With `--keep-negative-z` texels of negative z take no part in the angles.\n\n"
    "`--baseline FILE` is the JSON report of an earlier check. Its findings are known: they are "
    "shown as `known`, and do not count for the exit code. A file is known by its path from the "
    "working directory, in any spelling (`a`, `./a`, the whole path). So run both checks from one "
    "directory.\n\n"
    "In a directory a file that only its content makes a normals texture may be none. All its "
    "findings are notes then; the headline says `1 possible error`, and `level_if_named` in JSON "
    "has the level that the finding has in a file that is named.\n\n"
    "[Severity](severity.md) has what this rule says of real textures, beside lit pictures of "
    "them.\n";

static const char OF_GLTF[] =
    "\n## NT060 to NT073\n\n"
    "`ntp gltf` has findings of its own about the file that contains an image: "
    "[NT060](gltf.md) (an image with two uses), [NT061](gltf.md) (odd scale), [NT062](gltf.md) "
    "(no texture coordinates), [NT063](gltf.md) (media type), [NT064](gltf.md) (a format that is "
    "not read), [NT065](gltf.md) (no standard normals texture, which glTF requires), "
    "[NT066](gltf.md) (alpha), [NT067](gltf.md) (mirrored or turned), [NT068](gltf.md) (an image "
    "that readers may not show), [NT069](gltf.md) (a KTX2 that is not allowed). [gltf.md](gltf.md) "
    "describes them. `ntp usd` has [NT070](usd.md) (color space), [NT071](usd.md) (scale and "
    "bias), [NT072](usd.md) (strength) and [NT073](usd.md) (outputs); see [usd.md](usd.md).\n";

static void generate_findings(text *t)
{
    text_add(t,
             "# Findings of `ntp check`\n\n"
             "Each finding has a stable id and a level. `--fail-on` sets the level from which on "
             "the exit code is 1. This page is made from the program's own table "
             "(`ntp --generate findings`).\n\n"
             "| id | level | what it says |\n|---|---|---|\n");
    for (size_t i = 0; i < FINDING_COUNT; i++)
        text_addf(t, "| [%s](#%s) | %s | %s |\n", FINDING_TABLE[i].id, FINDING_TABLE[i].anchor,
                  FINDING_TABLE[i].levels, FINDING_TABLE[i].title);
    text_add(t, LEVELS);
    for (size_t i = 0; i < FINDING_COUNT; i++) {
        const finding_spec *spec = &FINDING_TABLE[i];
        text_addf(t, "\n<a id=\"%s\"></a>\n\n## %s: %s\n\nLevel: %s.\n\n%s\n\nWhat to do: %s\n",
                  spec->anchor, spec->id, spec->title, spec->levels, spec->why, spec->remedy);
    }
    text_add(t, OF_GLTF);
}

bool generate(text *t, const char *what)
{
    static const struct {
        const char *what;
        void (*make)(text *t);
    } KINDS[] = {
        { "man", generate_man },   { "bash", generate_bash },         { "zsh", generate_zsh },
        { "fish", generate_fish }, { "findings", generate_findings },
    };
    for (size_t i = 0; i < sizeof KINDS / sizeof KINDS[0]; i++) {
        if (strcmp(what, KINDS[i].what) == 0) {
            KINDS[i].make(t);
            return true;
        }
    }
    return false;
}
