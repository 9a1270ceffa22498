# SPDX-License-Identifier: MIT
"""From the JSON of a check to one HTML page that needs nothing else.

The page contains its style, its script and its pictures.  Its content security policy allows only
these, by their hashes, and no network.  So a file name can never be more than text.  The paths in
the JSON may come from anywhere, so they are opened by `_named`.
"""

import base64
import hashlib
import os
import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from .. import _console, _ntp
from .._atomic import write_atomically
from .._files import read
from .._named import MAX_BYTES, read_named
from ..gltf._document import load as load_gltf
from ..typing import Palette
from ._pictures import DRAWN, HISTOGRAM_BINS, Pictures, draw
from .sarif import all_rules

Json = dict[str, Any]

TYPE_WORDS = {
    "standard": "standard",
    "zzero": "Z-zero",
    "xy": "XY only",
    "height": "heights",
    "object-space": "object space",
    "one-color": "one color",
    "not-normals": "no normals",
}
CHANNEL_WORDS = {1: "gray", 2: "gray and alpha", 3: "RGB", 4: "RGBA"}
GREEN_WORDS = {"up": "up (OpenGL)", "down": "down (DirectX)", "undecided": "undecided"}
_ORDER = {"unreadable": 5, "error": 4, "warning": 3, "possible": 2, "ok": 1, "skipped": 0}
STATE_WORDS = {
    "error": "error",
    "warning": "warning",
    "possible": "possible",
    "ok": "well formed",
    "unreadable": "unreadable",
    "skipped": "not judged",
}
# Files drawn at once, and their texels: each texel is held in some five copies.
_WORKERS = 4
_TEXELS_AT_ONCE = 1 << 26
# The largest file that is drawn: 8192 x 8192.
MAX_TEXELS = 1 << 26


class _Budget:
    """Lets workers continue while the sum of their texels is small enough.

    A file that is larger runs alone."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._used = 0
        self._changed = threading.Condition()

    @contextmanager
    def take(self, texels: int) -> Iterator[None]:
        with self._changed:
            self._changed.wait_for(lambda: self._used == 0 or self._used + texels <= self._most)
            self._used += texels
        try:
            yield
        finally:
            with self._changed:
                self._used -= texels
                self._changed.notify_all()


def state(file: Mapping[str, Any]) -> str:
    """What a file comes to: "error", "warning", "possible", "ok", "unreadable" or "skipped".

    "possible": in a file with the name of normals there would be warnings or errors.
    """
    if file["status"] == "unreadable":
        return "unreadable"
    if file["status"] != "ok" or not _ntp.counts(file):
        return "skipped"
    level = _ntp.worst_level(file)
    if level in ("error", "warning"):
        return level
    return "possible" if _if_named(file) else "ok"


def _if_named(file: Mapping[str, Any]) -> list[Any]:
    """Notes that would be more in a file with the name of normals."""
    return [
        found
        for found in file["findings"]
        if "level_if_named" in found and not found.get("baseline")
    ]


def _result(file: Mapping[str, Any]) -> str:
    """The state in words; a file has visible errors or none as `ntp check` says."""
    found = state(file)
    if found == "possible":
        levels = {found["level_if_named"] for found in _if_named(file)}
        return "possible error" if "error" in levels else "possible warning"
    if found == "ok" and any(f["id"] in ("NT001", "NT002", "NT003") for f in file["findings"]):
        return "no visible errors"
    return STATE_WORDS[found]


def green(file: Mapping[str, Any]) -> str:
    """Which way green points, in words.

    If a direction was required, the JSON repeats it as certain, and NT010 reports the other one.
    """
    y = str(file["y"])
    if any(found["id"] == "NT010" for found in file["findings"]):
        return GREEN_WORDS["down" if y == "up" else "up"]
    return f"{y}, as required" if file["y_confidence"] == 1 else GREEN_WORDS[y]


def percent(part: int, whole: int) -> str:
    """A share that is never rounded to 0 or to everything."""
    if part == 0 or whole == 0:
        return "0 %"
    share = 100 * part / whole
    if share < 0.01:
        return "< 0.01 %"
    if 99.99 < share < 100:
        return "> 99.99 %"
    return f"{share:.3g} %"


def _histogram(lengths: Sequence[int]) -> list[Json]:
    """The bars of a histogram with a logarithmic scale: a single texel is a visible bar."""
    top = max(lengths, default=0).bit_length()
    bars = []
    for i, count in enumerate(lengths):
        if count:
            bars.append({"x": i, "height": round(100 * count.bit_length() / max(top, 1), 1)})
    return bars


def _view(
    file: Mapping[str, Any], number: int, rules: Mapping[str, _ntp.Rule], rule: Mapping[str, Any]
) -> Json:
    """What the template shows of a file."""
    view: Json = {
        "id": f"file-{number}",
        "path": _console.shown(file["path"]),
        "state": state(file),
        "rank": _ORDER[state(file)],
        "result": _result(file),
        "status": file["status"],
        "message": _console.shown((file["message"] or "").removeprefix(f"{file['path']}: ")),
        "findings": [],
        "pictures": None,
    }
    folder, _, view["name"] = view["path"].rpartition("/")
    view["folder"] = folder + "/" if folder else ""
    if "image" in file:
        view["name"] += f", image {file['image']}"
        view["uses"] = [
            _console.shown(f"{u['slot']} of {u['material_name'] or u['material']}")
            for u in file["uses"]
        ]
        view["image_name"] = _console.shown(file["name"])
    for found in file["findings"]:
        view["findings"].append({**found, "rule": rules.get(found["id"])})
    if file["status"] != "ok":
        return view
    view.update(
        type=TYPE_WORDS.get(file["type"], file["type"]),
        confidence=file["confidence"],
        reasons=file["reasons"],
        green=green(file),
        size=f"{file['width']} × {file['height']}",
        texels=file["texels"],
        layout=f"{file['bit_depth']}-bit {CHANNEL_WORDS[file['channels']]}",
        format=file["format"].upper(),
        angle=file["angle_deg"],
        length=file["length"],
        unused=file["unused"],
    )
    view.update(_figures(file, rule["verdict"]))
    return view


def _figures(file: Mapping[str, Any], verdict: str) -> Json:
    """The numbers that levels follow from, and how they explain the result.

    `harm` counts texels that are off by more than `max_angle`; older JSON has none.
    """
    failing = (_used(file)["fail"] or {}).get(verdict)
    figures: Json = {"failing": failing, "failing_text": "", "visible": None, "judged": ""}
    if failing is None:
        return figures
    used = _used(file)["texels"]
    figures["share"] = failing / max(used, 1)
    figures["failing_text"] = percent(failing, used)
    harm, angle = file.get("harm"), file["angle_deg"]
    by = f"by {angle['mean']:.3g}° on average and {angle['max']:.3g}° at most"
    figures["judged"] = (
        f"{figures['failing_text']} of the used texels fail the test {verdict}, {by}."
    )
    if harm:
        over = max(harm[kind]["over"] for kind in ("length", "xy", "z_negative") if kind in harm)
        figures["visible"] = over / max(used, 1)
        figures["visible_text"] = percent(over, used)
        figures["judged"] += (
            f" {figures['visible_text']} of the used texels are off by more than "
            f"{harm['max_angle']:g}°, which is what can be seen."
        )
    if failing and state(file) == "ok":
        figures["judged"] += " That is too little for a warning."
    if state(file) == "possible":
        figures["judged"] += " It is only noted, because the name is not that of a normals texture."
    return figures


def _used(file: Mapping[str, Any]) -> Mapping[str, Any]:
    """The counts of used texels; older JSON has those of all texels only."""
    found: Mapping[str, Any] = file.get("used") or {
        "texels": file["texels"] - file["unused"],
        "fail": file["fail"],
    }
    return found


def rule_of(report: Mapping[str, Any]) -> Json:
    """The rule by which a report judges texels; older JSON does not state it."""
    rule = report.get("summary", {}).get("rule") or {}
    return {"policy": "", "verdict": "neighbor", **rule}


def rule_text(rule: Mapping[str, Any]) -> str:
    """The same in a sentence or two; "" where it is not known."""
    if rule["policy"] == "harm":
        return (
            f"The result follows the angle that a renderer shows. A texel is visibly wrong if its "
            f"normal is off by more than {rule['max_angle']:g}°. If more than "
            f"{rule['max_fail']:g} % of the used texels are, that is an error."
        )
    if rule["policy"] == "strict":
        return (
            f"The result follows the share of texels that fail the test {rule['verdict']}. A share "
            f"of more than {rule['max_fail']:g} % is an error, a smaller one a warning."
        )
    return ""


def _badness(file: Mapping[str, Any]) -> tuple[float, ...]:
    """Grows with what is wrong: the state, what can be seen, the mean error, the share."""
    if file["status"] != "ok" or not file.get("fail"):
        return (_ORDER[state(file)], 0, 0, 0)
    harm = (file.get("harm") or {}).get("length") or {}
    used = max(_used(file)["texels"], 1)
    angle = harm.get("mean", file["angle_deg"]["mean"])
    failing = _used(file)["fail"].get("neighbor") or 0
    return (_ORDER[state(file)], harm.get("over", 0) / used, angle, failing / used)


def _breakable(name: str) -> Any:
    """A name as HTML that may break between its parts: BrickWall_1K_Normal, a.b-c."""
    from markupsafe import Markup, escape

    parts = re.split(r"(?<=[/_.\- ])(?=[^/_.\- ])|(?<=[a-z])(?=[A-Z])|(?<=[A-Za-z])(?=\d)", name)
    return Markup("<wbr>").join(escape(part) for part in parts)


@dataclass(frozen=True)
class _Sources:
    """Where pictures are read from: the paths in a report may come from anywhere."""

    base: str | os.PathLike[str]
    root: str | os.PathLike[str] | None
    max_bytes: int
    max_texels: int

    def pixels(self, file: Mapping[str, Any]) -> Any:
        path = os.path.join(self.base, _ntp.path_of(file))
        if "image" in file:
            document = load_gltf(path, root=self.root, max_bytes=self.max_bytes)
            return read(document.image_bytes(file["image"]), max_texels=self.max_texels)
        data, _ = read_named(path, self.root, self.max_bytes)
        return read(data, max_texels=self.max_texels)


def _draw_all(
    files: Sequence[Mapping[str, Any]], limit: int, size: int, palette: Palette, sources: _Sources
) -> dict[int, Pictures | str]:
    """{number of the file: its pictures, or why there are none}; the files come worst first."""
    wanted = [i for i in range(len(files)) if files[i]["status"] == "ok"]
    drawn: dict[int, Pictures | str] = {
        i: f"Pictures are limited to {limit} files." for i in wanted[limit:]
    }

    budget = _Budget(_TEXELS_AT_ONCE)

    def one(number: int) -> Pictures | str:
        file = files[number]
        if file["texels"] > sources.max_texels:
            return "Too large for pictures."
        try:
            with budget.take(file["texels"]):
                pixels = sources.pixels(file)
                return draw(pixels, file, size=size, palette=palette)
        except MemoryError:
            return "No pictures: not enough memory."
        except (OSError, ValueError, RuntimeError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            return f"No pictures: {_console.shown(reason or str(error))}"

    with ThreadPoolExecutor(min(_WORKERS, os.cpu_count() or 1)) as pool:
        drawn.update(zip(wanted[:limit], pool.map(one, wanted[:limit]), strict=True))
    return drawn


def _frequent(files: Sequence[Mapping[str, Any]], rules: Mapping[str, _ntp.Rule]) -> list[Json]:
    """How many files have each warning or error, the most frequent first."""
    counted: dict[str, int] = {}
    for file in files:
        if _ntp.counts(file):
            for name in {f["id"] for f in file["findings"] if f["level"] != "info"}:
                counted[name] = counted.get(name, 0) + 1
    ordered = sorted(counted.items(), key=lambda item: (-item[1], item[0]))
    return [{"id": name, "files": n, "rule": rules.get(name)} for name, n in ordered]


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")


def _environment() -> Any:
    try:
        import jinja2
    except ImportError:
        raise _ntp.ProgramError("HTML needs Jinja2: pip install jinja2") from None
    loader = jinja2.FunctionLoader(_template)
    environment = jinja2.Environment(
        loader=loader,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["thousands"] = lambda number: f"{number:,}"
    environment.filters["breakable"] = _breakable
    return environment


def _template(name: str) -> str:
    return (resources.files("normaltexture.report") / name).read_text(encoding="utf-8")


def build(
    report: Mapping[str, Any],
    *,
    title: str = "Normals textures",
    base: str | os.PathLike[str] = "",
    size: int = 256,
    limit: int = 200,
    palette: Palette = "reference",
    max_texels: int = MAX_TEXELS,
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
) -> str:
    """One HTML page of a check.

    Parameters
    ----------
    report
        What ``ntp check --format json``, `normaltexture.gltf.check` or
        `normaltexture.distributed.check` gives.
    title
        The heading.
    base
        The directory that relative paths in the report start in; default: the current one.
    size
        The longer side of the pictures, in pixels.
    limit
        How many files get pictures, the worst first.
    palette
        "reference": red, green and blue as the heatmap of ntp has them; "safe": colors that can be
        told apart with every kind of color vision.
    max_texels
        Larger files get no pictures.
    root
        The folder in which all files have to lie that the report names, links followed; others get
        no pictures.  None: anywhere.  What a glTF file names then has to lie in its own folder.
    max_bytes
        The most that is read of one file.

    Returns
    -------
    str
        The page.  It refers to nothing outside of itself.

    Raises
    ------
    normaltexture._ntp.ProgramError
        Jinja2 or the program ntp is missing.
    """
    environment = _environment()
    files = sorted(report["files"], key=_badness, reverse=True)
    rules, rule = all_rules(), rule_of(report)
    views = [_view(file, number, rules, rule) for number, file in enumerate(files, 1)]
    sources = _Sources(base, root, max_bytes, max_texels)
    for number, drawn in _draw_all(files, limit, size, palette, sources).items():
        views[number]["pictures"] = drawn if isinstance(drawn, Pictures) else None
        views[number]["no_pictures"] = drawn if isinstance(drawn, str) else ""
        if isinstance(drawn, Pictures):
            views[number]["bars"] = _histogram(drawn.lengths)
    states = [view["state"] for view in views]
    style, script = _template("page.css"), _template("page.js")
    page: str = environment.get_template("page.html.j2").render(
        title=title,
        tool=report["tool"],
        files=views,
        tiles=[
            (name, STATE_WORDS[name], states.count(name))
            for name in ("unreadable", "error", "warning", "possible", "ok", "skipped")
        ],
        frequent=_frequent(files, rules),
        rule=rule,
        rule_text=rule_text(rule),
        has_harm=any(view.get("visible") is not None for view in views),
        palette=palette,
        bins=HISTOGRAM_BINS,
        style=style,
        script=script,
        style_hash=_hash(style),
        script_hash=_hash(script),
    )
    return page


def drawable(file: Mapping[str, Any]) -> bool:
    """Whether a file gets a heatmap and a lit picture."""
    return file["status"] == "ok" and file["type"] in DRAWN


def save(page: str, path: str | os.PathLike[str]) -> None:
    """Writes a page as UTF-8; an older file is replaced once the page is complete.

    Parameters
    ----------
    page
        What `build` returned.
    path
        Where to write.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    write_atomically(Path(path), page.encode("utf-8"))
