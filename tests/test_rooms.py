# SPDX-License-Identifier: MIT
"""tools/rooms.py: the tree respects the direction of its rooms, and a planted fault is reported."""

import importlib.util
import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def rooms(tmp_path, monkeypatch):
    """tools/rooms.py on a copy of the sources."""
    spec = importlib.util.spec_from_file_location("rooms", ROOT / "tools" / "rooms.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for folder in module.HOUSES:
        shutil.copytree(ROOT / folder, tmp_path / folder)
    shutil.copy(ROOT / "CONTRIBUTING.md", tmp_path)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    return module


def faults(rooms, folder, names):
    house = rooms.House(folder, names)
    house.check_rooms((rooms.ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"))
    house.check_includes()
    return house.faults


def all_faults(rooms):
    return [f for folder, names in rooms.HOUSES.items() for f in faults(rooms, folder, names)]


def add_line(path, line):
    path.write_text(line + "\n" + path.read_text(encoding="utf-8"), encoding="utf-8")


def test_the_tree_keeps_the_direction(rooms):
    assert all_faults(rooms) == []


@pytest.mark.parametrize(
    ("path", "include", "told"),
    [
        ("libntp/src/base/view.c", "texel/level.h", "base may not include texel/level.h"),
        ("libntp/src/detect/find_steps.c", "measure/tally.h", "detect may not include measure/"),
        (
            "libntp/src/to_height/direct/axis.c",
            "to_height/weighted/weighted.h",
            "to_height/direct may not include to_height/weighted/weighted.h",
        ),
        ("libntp/src/reshape/blend.c", "elsewhere.h", "elsewhere.h is no file of these rooms"),
        ("cli/examine/orient.c", "report/report.h", "examine may not include report/report.h"),
        ("io/open.c", "cli.h", "cli.h is no file of these rooms"),
        ("io/open.c", "os/posix/state.h", "os/posix/state.h is no file of these rooms"),
        ("os/version.c", "ntpio.h", "ntpio.h is no file of these rooms"),
        ("libntp/src/base/view.c", "os/files.h", "os/files.h is no file of these rooms"),
    ],
)
def test_an_include_against_the_direction_is_told(rooms, path, include, told):
    add_line(rooms.ROOT / path, f'#include "{include}"')
    (fault,) = all_faults(rooms)
    assert fault.startswith(f"{path}: line 1: {told}")


def test_a_question_for_the_system_outside_its_room_is_told(rooms):
    add_line(rooms.ROOT / "io/open.c", "#ifdef _WIN32")
    (fault,) = all_faults(rooms)
    assert fault == "io/open.c: line 1: asks for _WIN32; what differs by system is in os/"


def test_a_room_that_contributing_does_not_name_is_told(rooms):
    page = rooms.ROOT / "CONTRIBUTING.md"
    page.write_text(page.read_text(encoding="utf-8").replace("`detect/`", ""), encoding="utf-8")
    (fault,) = all_faults(rooms)
    assert "does not name the room `detect/`" in fault


def test_a_call_against_the_direction_is_told(rooms, monkeypatch):
    build = Path(os.environ.get("NTP_BUILD", ROOT / "build"))
    house = rooms.House("libntp/src", rooms.LIBRARY)
    house.check_calls(build)
    assert house.faults == []
    monkeypatch.setattr(
        house, "order", {name: len(house.order) - i for name, i in house.order.items()}
    )
    house.check_calls(build)
    assert any("against the direction" in fault for fault in house.faults)
