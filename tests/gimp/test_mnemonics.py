# SPDX-License-Identifier: MIT
"""The letters that Alt takes to a field of the plug-in's dialogs: each means one field of a dialog."""

import re
from collections import Counter
from pathlib import Path

import pytest

PARTS = Path(__file__).resolve().parents[2] / "gimp-plugin"
FIELDS = (PARTS / "plug-in" / "fields.c").read_text(encoding="utf-8")
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
