# SPDX-License-Identifier: MIT
"""What ntp suggests works: each command in a finding, a question or a refusal is run as printed.

A command is run on test files that have the finding.  It has to end with 0, and the finding has to
be gone from the result, or to be a note where it was more.
"""

import json
import re
import shutil
import subprocess

import pytest

from support.libntp_ffi import ROOT

FILES = ROOT / "test_files"
LEVELS = ("info", "warning", "error")

# {finding: {file: options of the check that has it}}; a name after > is given to a copy of the file.
CASES = {
    "NT001": {"standard_z_off.png": (), "too_short.png": (), "too_long.png": (), "jpeg.jpg": ()},
    "NT002": {"xy_too_long.png": ()},
    "NT003": {"z_negative.png": (), "z_flipped.png": ()},
    "NT004": {"blue_255.png": (), "blue_0.png": ()},
    "NT005": {"zzero.png": (), "zzero_16.png": ()},
    "NT006": {"labpbr.png": ()},
    "NT007": {"height_gray8.png": (), "height_gray16.png": (), "tga_gray.tga": ()},
    "NT010": {"standard_down.png": ("--y", "up"), "standard.png": ("--y", "directx")},
    "NT011": {"standard_down.png>wall_dx_n.png": ("--y", "up")},
    "NT012": {"dxt5nm.png": (), "red_blue_swapped.png": (), "green_blue_swapped.png": ()},
    "NT013": {"bc5_exchanged.dds": ()},
    "NT020": {"standard_rounded.png": (), "standard_16_rounded.png": (), "resized.png": ()},
    "NT032": {"jpeg_damaged.png": ()},
    "NT034": {"standard_16_of_8.png": ()},
    "NT035": {"too_short.png": ()},
    "NT040": {"standard_text.png": (), "gamma.png": ()},
    "NT041": {"standard_alpha.png": (), "tga_32_rle.tga": ()},
}
# Commands that are for some of these only, as their sentences say.
ONLY = {
    ("NT010", "ntp convert --y down --to-y up"): ["standard_down.png"],
    ("NT012", "ntp convert --from-channels -y-x"): ["dxt5nm.png"],
    ("NT012", "ntp convert --from-channels zyx"): ["red_blue_swapped.png"],
    ("NT040", "ntp convert"): ["standard_text.png"],
}
NOT_REMOVED = {
    "NT032": "traces of compression stay in the directions; a note that they are there stays, too"
}
NO_COMMANDS = {
    ("NT023", "ntp blend"),
    ("NT012", "ntp convert"),
    ("NT053", "ntp resize --mips"),
    ("NT054", "ntp resize --mips"),
}  # a verb is named, no command


def table(run):
    """{id: (text, what to do)} of the program's own table."""
    page = run("--generate", "findings").stdout
    section = r"^## (NT\d+): [^\n]*\n\nLevel: [^\n]*\n\n(.*?)\n\nWhat to do: (.*?)\n\n"
    return {
        name: texts for name, *texts in re.findall(section, page + "\n", re.MULTILINE | re.DOTALL)
    }


def checked(run, path, *options):
    """{id: level} of a file."""
    (found,) = json.loads(run("check", path, "--format", "json", *options).stdout)["files"]
    return {f["id"]: f["level"] for f in found["findings"]}


def input_of(tmp_path, case):
    name, _, new = case.partition(">")
    if not new:
        return FILES / name
    shutil.copy(FILES / name, tmp_path / new)
    return tmp_path / new


def follow(run, tmp_path, finding, words, case, options, known):
    """Runs a command on a file and says what became of the finding: None or its level."""
    source, out = input_of(tmp_path, case), tmp_path / "out.png"
    if (case, options) not in known:
        known[case, options] = checked(run, source, *options)
    before = known[case, options]
    assert finding in before, (finding, case, before)
    out.unlink(missing_ok=True)
    done = run(*words[1:], source, "-o", out)
    assert done.returncode == 0, (words, case, done.stderr)
    return before[finding], checked(run, out, *options).get(finding)


def test_what_to_do(run, tmp_path):
    followed, known = set(), {}
    for finding, (_, remedy) in table(run).items():
        for command in re.findall(r"`(ntp [^`]*)`", remedy):
            if (finding, command) in NO_COMMANDS:
                continue
            assert finding in CASES, f"{finding} suggests {command}: no file here has it"
            for case in ONLY.get((finding, command), CASES[finding]):
                words = command.split()
                options = CASES[finding][case]
                before, after = follow(run, tmp_path, finding, words, case, options, known)
                lower = after == "info" and (before != "info" or finding in NOT_REMOVED)
                assert after is None or lower, (finding, command, case, after)
            followed.add(finding)
    assert followed >= set(CASES) - {"NT011"} and len(followed) >= 14


def test_old_names_are_not_suggested(run):
    """Options have one name in what is printed; older ones are only understood."""
    pages = [run("--generate", page).stdout for page in ("findings", "man", "bash")]
    pages += [path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("*.md")]
    pages.append((ROOT / "README.md").read_text(encoding="utf-8"))
    for page in pages:
        for line in page.splitlines():
            assert not re.search(r"ntp convert [^`]*--from(-y)? (up|down|xy|zzero)", line), line


def test_options_that_say_what_is_meant(run):
    """--type and --keep-negative-z, where a text says that they make it a note or remove it."""
    for options, name, finding in (
        (("--type", "xy"), "blue_255.png", "NT004"),
        (("--type", "zzero"), "zzero.png", "NT005"),
        (("--type", "standard"), "photograph.png", "NT008"),
        (("--keep-negative-z",), "z_negative.png", "NT003"),
    ):
        _, remedy = table(run)[finding]
        assert f"`{options[0]}" in remedy
        assert checked(run, FILES / name)[finding] in ("warning", "error")
        assert checked(run, FILES / name, *options).get(finding) in (None, "info")


def images(*but):
    return [
        path
        for path in sorted(FILES.iterdir())
        if path.suffix in (".png", ".tga", ".jpg") and not path.name.startswith(("broken", *but))
    ]


def test_messages_of_findings(run, tmp_path):
    told = json.loads(run("check", *images(), "--format", "json").stdout)["files"]
    seen = set()
    for file in told:
        for found in file["findings"]:
            message = found["message"]
            for command in re.findall(r"ntp (\w[\w-]*(?: --[\w-]+ [\w.]+)+)", message):
                seen.add((found["id"], command))
                out = tmp_path / "out.png"
                done = run(*command.split(), file["path"], "-o", out)
                assert done.returncode == 0, (message, done.stderr)
                assert checked(run, out).get(found["id"]) in (None, "info"), message
            for option, type in re.findall(r"(--type) (\w+) says", message):
                left = checked(run, file["path"], option, type).get(found["id"])
                assert left in (None, "info"), message
    assert {finding for finding, _ in seen} == {"NT004", "NT005"}


VERBS = {
    "clean": ["clean"],
    "encoding": ["convert", "--to", "zzero"],
    "depth": ["convert", "--depth", "16"],
    "green": ["convert", "--to-y", "down"],
    "turn": ["transform", "--rotate", "90"],
    "resize": ["resize", "--size", "50%"],
    "heatmap": ["heatmap"],
    "to-height": ["to-height"],
    "from-height": ["from-height", "--scale", "5"],
}
SUGGESTED = re.compile(
    r"(?<!clean )(?<!10 )(--(?:type|y|force|source)\b)(?: (standard|xy|up|down)\b)?"
)


def refused(run, tmp_path, args, files):
    """{file: message} of those that a verb refuses."""
    done = run(*args, *files, "-o", tmp_path / "out", "--format", "json")
    assert done.returncode in (0, 1), done.stderr
    told = json.loads(done.stdout)["files"]
    return {f["path"]: f["message"] for f in told if f["status"] == "refused"}


def suggestions(message):
    """The options in a message, as words."""
    found = [(name, value) for name, value in SUGGESTED.findall(message)]
    if "zzero or xy" in message:
        found += [("--type", "zzero"), ("--type", "xy")]
    return {(name,) if name == "--force" else (name, value or "red") for name, value in found}


@pytest.mark.parametrize("verb", VERBS)
def test_refusals(run, tmp_path, verb):
    """Each way out of a refusal leads out.  Who says what a file is may be asked about green then."""
    args = VERBS[verb]
    # Of the many good textures one will do.
    asked = refused(run, tmp_path, args, images("standard_", "tga_2", "too_", "jpeg", "padded"))
    ways = {}
    for path, message in asked.items():
        found = suggestions(message)
        assert found or "ntp from-height" in message, message
        for way in found:
            ways.setdefault(way, []).append(path)
    for way, files in ways.items():
        still = refused(run, tmp_path, [*args, *way], files)
        for path, message in still.items():
            assert way[0] != "--y" and ("--y", "up") in suggestions(message), (way, path, message)
        if still:
            assert not refused(run, tmp_path, [*args, *way, "--y", "up"], list(still))
    heights = [path for path, message in asked.items() if "ntp from-height" in message]
    if heights:
        words = re.search(r"ntp (from-height --scale \d+)", asked[heights[0]])[1].split()
        assert not refused(run, tmp_path, words, heights)
    accidents = [path for path, message in asked.items() if "ntp clean --undo" in message]
    if accidents:
        out = tmp_path / "undone"
        assert run("clean", "--undo", *accidents, "-o", out).returncode == 0
        for path in out.rglob("*.png"):
            assert not {"NT012", "NT040"} & checked(run, path).keys()


def test_hints_of_usage(run, tmp_path):
    shutil.copy(FILES / "standard.png", tmp_path / "a.png")
    for wrong in (
        ["resize", "a.png", "-o", "b.png", "--size", "64"],
        [
            "from-height",
            "a.png",
            "-o",
            "b.png",
            "--scale",
            "5",
            "--source",
            "red",
            "--kernel",
            "sobel",
        ],
    ):
        done = run(*wrong)
        assert done.returncode == 2
        hints = re.findall(rf"{wrong[-2]} ([\w%]+\b%?)", done.stderr.partition(": ")[2])
        hints = [hint for hint in hints if hint != wrong[-1]] or re.findall(
            r"\b\w+\d\b", done.stderr
        )
        assert hints, done.stderr
        for hint in hints:
            assert run(*wrong[:-1], hint).returncode == 0, (hint, done.stderr)


def test_scripts_see_the_same_as_a_shell(program, tmp_path):
    """The channels that begin with a hyphen reach the program from a shell as they are printed."""
    command = f"{program} convert --from-channels -y-x {FILES}/dxt5nm.png -o out.png"
    assert subprocess.run(["sh", "-c", command], cwd=tmp_path, check=False).returncode == 0
