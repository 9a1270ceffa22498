# SPDX-License-Identifier: MIT
"""Additions to mkdocs: pages that the build makes, and links out of docs/.

libntp.md comes from the header, ntp.md from the program's help, gallery.md with its pictures from
the snippets in site_gallery.py.  normaltexture is installed where this runs.
"""

import html
import posixpath
import re
import subprocess
from pathlib import Path

import site_gallery
from mkdocs.structure.files import File

import normaltexture as nt

HERE = Path(__file__).resolve().parent
HEADER = HERE.parent / "libntp" / "include" / "libntp.h"

SECTION = re.compile(r"/\* -{8,} (.*?) \*/")
# A comment in the first column, or a declaration up to its ";" (with braces, the one after them).
ITEM = re.compile(r"/\*.*?\*/|^[a-zA-Z][^;{]*(?:\{.*?\n?\}[^;]*)?;", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)(#[^)]*)?\)")


def prose(comment):
    """A C comment as Markdown: the words are the header's."""
    lines = [re.sub(r"^\s*(/\*+|\*/|\*)? ?", "", line) for line in comment.splitlines()]
    text = "\n".join(lines).rsplit("*/", 1)[0].strip()
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([*_|`\[\]])", r"\\\1", text)


def name_of(declaration):
    function = re.search(r"\b(ntp_\w+)\s*\(", declaration)
    if function and "{" not in declaration:
        return function[1]
    named = re.match(r"typedef (?:struct|enum) (\w+)", declaration)
    if named:
        return named[1]
    first = re.search(r"\bNTP_\w+", declaration)
    return first[0] if first else declaration.split()[-1].strip(";")


def header_page():
    text = HEADER.read_text(encoding="utf-8")
    intro, rest = text.split("/* --- cdef begin", 1)
    comment = re.findall(r"/\*.*?\*/", intro, re.DOTALL)[1]
    plain = html.unescape(re.sub(r"\\(.)", r"\1", prose(comment)))
    out = ["# libntp.h", "", "```text", plain, "```", ""]
    rest = rest.split("/* --- cdef end")[0]
    rest = rest[rest.index("*/") + 2 :]
    for index, part in enumerate(SECTION.split(rest)):
        if index % 2 == 1:
            out += [f"## {part[0].upper()}{part[1:]}", ""]
            continue
        waiting = ""
        for match in ITEM.finditer(part):
            item = match[0]
            if item.startswith("/*"):
                if waiting:
                    out += [waiting, ""]
                waiting = prose(item)
                continue
            out += [f"### {name_of(item)}", "", "```c", item.replace("NTP_API ", ""), "```", ""]
            out += [waiting, ""]
            waiting = ""
        out += [waiting, ""]
    return "\n".join(out)


def program_page():
    def says(*args):
        return subprocess.run(
            [nt.program(), *args], capture_output=True, text=True, check=True
        ).stdout.rstrip()

    verbs = re.findall(r"^  ([a-z-]+) {2,}", says("--help"), re.MULTILINE)
    out = ["# The command line", "", "```text", says("--help"), "```", ""]
    for verb in dict.fromkeys(verbs):
        try:
            out += [f"## ntp {verb}", "", "```text", says(verb, "--help"), "```", ""]
        except subprocess.CalledProcessError:  # a verb of an extra that is not installed
            out = out[: -len(["heading", "", "fence"])] if out[-1] == "```text" else out
    return "\n".join(out)


def on_files(files, config):
    made = {"libntp.md": header_page(), "ntp.md": program_page()}
    page, pictures = site_gallery.make()
    made["gallery.md"] = page
    made |= pictures
    for path, content in made.items():
        files.append(File.generated(config, path, content=content))
    return files


def on_page_markdown(markdown, page, config, files):
    """Links out of docs/ become plain names, because the site has no sources.  The header has a
    page."""

    def inside(match):
        target = posixpath.normpath(posixpath.join(posixpath.dirname(page.file.src_uri), match[1]))
        if target == "../libntp/include/libntp.h":
            return "](libntp.md)"
        if target.startswith("../"):
            return "](#)"
        return match[0]

    return LINK.sub(inside, markdown)
