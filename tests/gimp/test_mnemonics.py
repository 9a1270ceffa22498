# SPDX-License-Identifier: MIT
"""What the dialogs say: each letter that Alt takes means one field, each option has one name."""

import re
from collections import Counter
from pathlib import Path

import pytest

PARTS = Path(__file__).resolve().parents[2] / "gimp-plugin"
CHOICES = (PARTS / "choices.h").read_text(encoding="utf-8")
SHARED = dict(re.findall(r'#define (NTP_\w+_LABEL) N_\("(.*)"\)', CHOICES))


def spelled_out(text):
    """With the labels of choices.h in the place of their names."""
    return re.sub(r"\bNTP_\w+_LABEL\b", lambda name: f'N_("{SHARED[name[0]]}")', text)


FIELDS = spelled_out((PARTS / "plug-in" / "fields.c").read_text(encoding="utf-8"))
DIALOGS = re.findall(r"static const field (\w+)\[\w+\] = \{(.*?)\n\};", FIELDS, re.DOTALL)
# Those of the buttons, GIMP's own among them: Help, Reset, Cancel, OK, Load and Save.
BUTTONS = {"en": "hrcols", "de": "hzcaols"}


def translations(language):
    text = "" if language == "en" else (PARTS / "po" / f"{language}.po").read_text(encoding="utf-8")
    return dict(re.findall(r'^msgid "(.+)"\nmsgstr "(.+)"$', text, re.MULTILINE))


@pytest.mark.parametrize("language", BUTTONS)
@pytest.mark.parametrize(("name", "rows"), DIALOGS, ids=[name for name, _ in DIALOGS])
def test_each_letter_once(name, rows, language):
    texts = translations(language)
    labels = [
        texts.get(label, label) for label in re.findall(r'N_\("([^"]*_[^"]*)"\)', rows, re.DOTALL)
    ]
    letters = Counter(BUTTONS[language])
    letters.update(label[label.index("_") + 1].lower() for label in labels)
    assert [letter for letter, count in letters.items() if count > 1] == []
    assert labels or name == "classic_fields"  # for scripts only


@pytest.mark.parametrize("language", BUTTONS)
def test_each_letter_once_in_the_report(language):
    """Of two buttons with one letter Alt would only go to one after the other."""
    window = (PARTS / "plug-in" / "report_window.c").read_text(encoding="utf-8")
    labels = re.findall(r'_\("([^"]*_[^"]*)"\)', window + dict(DIALOGS)["check_fields"])
    texts = translations(language)
    # While it is busy, only Stop is there in the place of Check again and of the remedies.  Flip
    # green has three texts and one letter.
    labels = {texts.get(label, label).split(":")[0] for label in labels} - {
        texts.get("_Stop", "_Stop")
    }
    letters = Counter(label[label.index("_") + 1].lower() for label in labels)
    letters["h"] += 1  # GIMP's own: Help, Hilfe
    assert len(letters) == 9
    assert [letter for letter, count in letters.items() if count > 1] == []


def plain(text):
    return text.replace("_", "")


def operation_labels(file):
    """{"min-z": "Minimum Z"} of an operation's properties."""
    text = spelled_out((PARTS / "gegl" / file).read_text(encoding="utf-8"))
    found = re.findall(r'^property_\w+\((\w+), (?:_|LABEL)\((?:N_\()?"(.+?)"\)', text, re.MULTILINE)
    return {name.replace("_", "-"): label for name, label in found}


def plugin_labels(name):
    rows = dict(DIALOGS)[name]
    return dict(re.findall(r'(?:NUMBER|CHOICE|SWITCH)\("([\w-]+)", N_\("([^"]*)"\)', rows))


# What an option of the plug-in is called in the operation, where that is not its own name.
SAME = {
    "normals_fields": ("normals_from_height.c", {}),
    "clean_fields": ("clean_normals.c", {"method": "repair"}),
    "check_fields": ("clean_normals.c", {}),
    "height_fields": ("clean_normals.c", {}),
}


@pytest.mark.parametrize("language", BUTTONS)
@pytest.mark.parametrize("name", SAME)
def test_one_name_for_an_option(name, language):
    """In the operation and in the plug-in."""
    file, others = SAME[name]
    texts, operation = translations(language), operation_labels(file)
    shared = 0
    for option, label in plugin_labels(name).items():
        there = operation.get(others.get(option, option))
        if there is not None:
            assert plain(texts.get(label, label)) == plain(texts.get(there, there)), option
            shared += 1
    assert shared >= 2


def test_shared_options_are_named_in_one_place():
    """Options of Normals from Height that both have: name and explanation are those of choices.h."""
    fields = (PARTS / "plug-in" / "fields.c").read_text(encoding="utf-8")
    operation = (PARTS / "gegl" / "normals_from_height.c").read_text(encoding="utf-8")
    rows = fields[fields.index("normals_fields[FN_COUNT] =") :]
    rows = dict(re.findall(r'\("([\w-]+)", (\w+)', rows[: rows.index("\n};")]))
    properties = re.findall(r"^property_\w+\((\w+), (?:LABEL\((\w+)\))?", operation, re.MULTILINE)
    shared = {name: label for name, label in properties if name.replace("_", "-") in rows}
    assert len(shared) > 20
    for name, label in shared.items():
        assert label == f"NTP_{name.upper()}_LABEL" == rows[name.replace("_", "-")]


# Pixels in GIMP 2.10 at a scale of 1: rows of a dialog, all else that it has, and what fits.  With
# letters of twice the size the window is 1.75 times as high.
ROWS = {"enum": 33, "double": 23, "boolean": 21, "dial": 33, "string": 29, "file_path": 33}
AROUND, MOST = 258, 590


@pytest.mark.parametrize("file", sorted((PARTS / "gegl").glob("*.c")), ids=lambda file: file.stem)
def test_dialogs_fit(file):
    """The window does not scroll, so at a scale of 2 it must fit a screen of 1080 rows."""
    text = file.read_text(encoding="utf-8")
    row = r"^property_(\w+)\((\w+),(.*?)(?=^property|/\*|^#)"
    rows = re.findall(row, text, re.MULTILINE | re.DOTALL)
    pages = {words for _, _, meta in rows for words in re.findall(r"page \{\w+\}", meta)}
    for page in pages or {""}:
        shown = [("dial" if '"degree"' in meta else kind, meta) for kind, _, meta in rows]
        shown = [kind for kind, meta in shown if page in meta or '"visible"' not in meta]
        assert AROUND + sum(ROWS[kind] for kind in shown) <= MOST, page
    if file.stem == "normals_from_height":
        assert len(pages) == 3


LIST = 52  # characters of GIMP 2.10's list of operations that have room in the narrowest dialog


@pytest.mark.parametrize("language", BUTTONS)
def test_titles_fit(language):
    """GIMP 2.10 leaves letters out of the middle of a longer one."""
    texts = translations(language)
    texts_of = [f.read_text(encoding="utf-8") for f in sorted((PARTS / "gegl").glob("*.c"))]
    named = r'"name", "(ntp:[\w-]+)",\s*"title", _\("(.+?)"\)'
    titles = dict(found for text in texts_of for found in re.findall(named, text))
    assert len(titles) == 7
    for name, title in titles.items():
        assert len(f"{texts.get(title, title)} ({name})") <= LIST, name


@pytest.mark.parametrize("language", ["de", "en_GB"])
def test_nothing_untranslated(language):
    text = (PARTS / "po" / f"{language}.po").read_text(encoding="utf-8")
    assert "#, fuzzy" not in text and "#~" not in text
    assert (
        re.findall(r'^msgid (".+"(?:\n".+")*|""(?:\n".+")+)\nmsgstr ""\n\n', text, re.MULTILINE)
        == []
    )
