# SPDX-License-Identifier: MIT
"""Changes single values in a JSON text and leaves every other byte as it is.

Writing a parsed document out again would spell numbers anew, reorder white space and lose what a
tool's author laid out by hand.  So the text is edited instead: `Editor` finds where a value stands
by its path of keys and indices, and applies all replacements at once.
"""

import json
from collections.abc import Sequence
from typing import Any

Key = str | int
_SPACE = " \t\n\r"
_DECODER = json.JSONDecoder()


def _skip_space(text: str, at: int) -> int:
    while at < len(text) and text[at] in _SPACE:
        at += 1
    return at


def _members(text: str, at: int) -> dict[Key, tuple[int, int]]:
    """Where the values of the object or array that starts at `at` begin and end."""
    is_object = text[at] == "{"
    found: dict[Key, tuple[int, int]] = {}
    at = _skip_space(text, at + 1)
    index = 0
    while text[at] not in "]}":
        key: Key = index
        if is_object:
            key, at = _DECODER.raw_decode(text, at)
            at = _skip_space(text, _skip_space(text, at) + 1)
        _, end = _DECODER.raw_decode(text, at)
        found[key] = (at, end)
        index += 1
        at = _skip_space(text, end)
        if text[at] == ",":
            at = _skip_space(text, at + 1)
    return found


class Editor:
    """Collects replacements in `text`, a valid JSON document."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._edits: dict[tuple[int, int], str] = {}
        self._known: dict[int, dict[Key, tuple[int, int]]] = {}

    def span(self, path: Sequence[Key]) -> tuple[int, int] | None:
        """Where the value at a path begins and ends, or None if there is none."""
        at = _skip_space(self.text, 0)
        end = len(self.text)
        for key in path:
            if self.text[at] not in "{[":
                return None
            if at not in self._known:
                self._known[at] = _members(self.text, at)
            where = self._known[at].get(key)
            if where is None:
                return None
            at, end = where
        return at, end

    def set(self, path: Sequence[Key], value: Any) -> None:
        """Replaces the value at a path; a missing last key is added to its object."""
        spelled = json.dumps(value, ensure_ascii=False)
        where = self.span(path)
        if where is not None:
            self._edits[where] = spelled
            return
        parent = self.span(path[:-1])
        if parent is None or self.text[parent[0]] != "{":
            raise KeyError(f"no object at {list(path[:-1])}")
        inside = parent[0] + 1
        comma = "" if self.text[_skip_space(self.text, inside)] == "}" else ","
        addition = f"{json.dumps(path[-1])}:{spelled}{comma}"
        self._edits[inside, inside] = self._edits.get((inside, inside), "") + addition

    def apply(self) -> str:
        """The text with every replacement made."""
        parts, at = [], 0
        for (start, end), spelled in sorted(self._edits.items()):
            parts += [self.text[at:start], spelled]
            at = end
        return "".join([*parts, self.text[at:]])
