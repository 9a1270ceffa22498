# SPDX-License-Identifier: MIT
"""rooms.py BUILD: does every include and every call run in the direction of the rooms?

A room is a folder of libntp/src, of cli or of os.  A file uses what lies in its own room and in the rooms
that stand before it in the lists below; a shut room is reached through libntp.h alone.  Includes are
read from the sources, calls from the symbols of the objects in the build directory BUILD.
CONTRIBUTING.md has to name every room, and each room has the file that a newcomer opens first.
Only os/ asks which system it is; io/ and cli/ use its headers, and io/ none of cli/.
Of libntp/src, what calls a function of the user's has tables for unwinding, and so has what calls that.
"""

import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent


class Room(NamedTuple):
    """A folder; `first` is the file to open first, `for_rooms` who may include its headers."""

    name: str
    first: str
    for_rooms: str = ""  # a prefix of the rooms that may; "" all after it, "-" none


LIBRARY = [
    Room("base", "view.h"),
    Room("texel", "level.h"),
    Room("stencil", "taps.h"),
    Room("repair", "clean.c", "-"),
    Room("measure", "tally.h", "-"),
    Room("classify", "classify.c", "-"),
    Room("picture", "picture.h", "-"),
    Room("reshape", "resize.h", "-"),
    Room("from_height", "gradient.h", "-"),
    Room("shape", "curvature.c", "-"),
    Room("to_depth", "depth_from_normals.c", "-"),
    Room("to_height/shared", "slopes.h", "to_height"),
    Room("to_height/direct", "direct.h", "to_height"),
    Room("to_height/weighted", "weighted.h", "to_height"),
    Room("to_height", "height_from_normals.c", "-"),
    Room("detect", "orientation.c", "-"),
    Room("compress", "encode.c", "-"),
]
PROGRAM = [
    Room("text", "text.h"),
    Room("options", "options.h"),
    Room("files", "paths.h"),
    Room("examine", "examine.h"),
    Room("run", "jobs.h"),
    Room("findings", "findings.h"),
    Room("surface", "surface.h"),
    Room("report", "report.h"),
    Room("write", "write_run.h"),
    Room("verbs", "verbs.h"),
    Room("", "main.c"),
]
# Below the program: what differs by system, and image files.
SYSTEM = [
    Room("", "files.h"),
    Room("posix", "output.c", "posix"),
    Room("windows", "output.c", "windows"),
    Room("wasi", "output.c", "wasi"),
]
FILES = [Room("", "ntpio.h")]
# Who may include headers of os/, by their path from the top.
ABOVE_SYSTEM = {"os", "io", "cli"}
SYSTEM_QUESTION = re.compile(
    r"\s*#\s*(?:el)?if.*\b(_WIN32|__APPLE__|__linux__|__unix__|__wasi__)\b"
)
HOUSES = {"libntp/src": LIBRARY, "os": SYSTEM, "io": FILES, "cli": PROGRAM}
# Headers that a room after theirs may include although the room is shut, and why.
OPEN_HEADERS = {
    # The classifier's evidence comes out of the tally; it is no part of the interface.
    ("classify", "measure/evidence.h"),
    # Which border costs less is asked of the slopes that the solver takes.
    ("detect", "to_height/decode.h"),
    ("detect", "to_height/shared/height_plan.h"),
    ("detect", "to_height/shared/slopes.h"),
}
# What every room of the program may include: exit codes and messages.
LOWEST = {"cli.h"}
# A call of a function of the user's: members of ntp_hooks and ntp_height_rows.
USERS_FUNCTION = re.compile(
    r"(?:->|\.)(?:progress|parallel_for|read_normals|read_heights|write_heights)\("
)
# The two ways to the sums of slopes know nothing of each other.
STRANGERS = {frozenset({"to_height/direct", "to_height/weighted"})}


class House:
    """The rooms below a folder."""

    def __init__(self, folder, rooms):
        self.folder = ROOT / folder
        self.rooms = {room.name: room for room in rooms}
        self.order = {room.name: i for i, room in enumerate(rooms)}
        self.sources = sorted([*self.folder.rglob("*.c"), *self.folder.rglob("*.h")])
        self.faults = []

    def fault(self, path, words):
        self.faults.append(f"{path.relative_to(ROOT)}: {words}")

    def room_of(self, path):
        name = path.parent.relative_to(self.folder).as_posix()
        return "" if name == "." else name

    def may_call(self, user, used):
        """Whether code of one room may call another's."""
        return self.order[used] <= self.order[user] and frozenset({user, used}) not in STRANGERS

    def may_include(self, user, used):
        """Whether a room may include the headers of another."""
        readers = self.rooms[used].for_rooms
        return user == used or (
            self.may_call(user, used)
            and readers != "-"
            and (user == readers or user.startswith(readers))
        )

    def check_rooms(self, pages):
        for path in self.sources:
            if self.room_of(path) not in self.rooms:
                self.fault(path, "lies in no room of tools/rooms.py")
        for room in self.rooms.values():
            first = self.folder / room.name / room.first
            if not first.exists():
                self.fault(first, "the first file of its room is not there")
            if room.name and f"`{room.name}/`" not in pages:
                self.fault(first, f"CONTRIBUTING.md does not name the room `{room.name}/`")

    def check_includes(self):
        for path in self.sources:
            user = self.room_of(path)
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                self.check_system_question(path, number, line)
                found = re.match(r'\s*#\s*include "([^"]+)"', line)
                if found is not None and self.is_of_system(path, found[1]):
                    continue
                if (
                    found is None
                    or (user, found[1]) in OPEN_HEADERS
                    or (self.folder.name == "cli" and found[1] in LOWEST)
                ):
                    continue
                used = found[1].rpartition("/")[0]
                if used not in self.rooms or not (self.folder / found[1]).exists():
                    if found[1] != "libntp.h":
                        self.fault(path, f"line {number}: {found[1]} is no file of these rooms")
                elif not self.may_include(user, used):
                    self.fault(path, f"line {number}: {user or 'main'} may not include {found[1]}")

    def is_of_system(self, path, name):
        """Whether an include is a header of os/ that the file may use: its own system's, or none's."""
        header = ROOT / name
        user = path.parent.relative_to(ROOT).as_posix()
        return (
            name.startswith("os/")
            and self.folder.name in ABOVE_SYSTEM
            and header.exists()
            and (header.parent == ROOT / "os" or header.parent == ROOT / user)
        )

    def check_system_question(self, path, number, line):
        found = SYSTEM_QUESTION.match(line)
        if found is not None and self.folder.name in ("io", "cli"):
            self.fault(
                path, f"line {number}: asks for {found[1]}; what differs by system is in os/"
            )

    def check_calls(self, build):
        """Symbols that an object leaves open, against the room that defines them."""
        objects = self.objects(build)
        if not objects:
            sys.exit(f"rooms: no objects of {self.folder.name} in {build}")
        home, open_in = {}, []
        for path, names in objects.items():
            done = subprocess.run(["nm", "-P", *names], capture_output=True, text=True, check=True)
            for line in done.stdout.splitlines():
                symbol, kind, *_ = [*line.split(), "", ""]
                if kind == "U":
                    open_in.append((path, symbol))
                elif kind.isupper():
                    home[symbol] = path
        for path, symbol in sorted(set(open_in)):
            used = home.get(symbol)
            if used is not None and not self.may_call(self.room_of(path), self.room_of(used)):
                self.fault(
                    path, f"calls {symbol} of {used.relative_to(ROOT)}, against the direction"
                )
        if self.folder.name == "src":
            self.check_tables(objects, home, open_in)

    def check_tables(self, objects, home, open_in):
        """Whether an exception can pass from the user's functions to who called the library."""
        tables = set()
        for path, names in objects.items():
            command = ["readelf", "-SW", *names]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            if ".eh_frame" in done.stdout:
                tables.add(path)
        need = "needs tables for unwinding, see libntp_callback_sources:"
        for path in objects.keys() - tables:
            if USERS_FUNCTION.search(path.read_text(encoding="utf-8")):
                self.fault(path, f"{need} it calls a function of the user's")
        for path, symbol in sorted(set(open_in)):
            if path not in tables and home.get(symbol) in tables:
                self.fault(path, f"{need} it calls {symbol}")

    def objects(self, build):
        """{source: its objects}; Meson writes a path's slashes as underscores."""
        found = {}
        places = [*(build / self.folder.relative_to(ROOT).parts[0]).glob("*.p")]
        for path in self.sources:
            below = self.folder.relative_to(ROOT).parts[1:]
            name = "_".join([*below, *path.relative_to(self.folder).parts]) + ".o"
            objects = [str(place / name) for place in places if (place / name).exists()]
            if path.suffix == ".c" and objects:
                found[path] = objects
        return found


def main(build):
    pages = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    faults = []
    for folder, rooms in HOUSES.items():
        house = House(folder, rooms)
        house.check_rooms(pages)
        house.check_includes()
        house.check_calls(Path(build).resolve())
        faults += house.faults
    print(*faults, sep="\n" if faults else "")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
