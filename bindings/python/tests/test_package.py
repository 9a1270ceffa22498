# SPDX-License-Identifier: MIT
"""The package as a whole: versions, what is exported, the program, and `check`."""

import importlib.metadata
import json
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest

import normaltexture as nt
from normaltexture._native import lib
from pysupport import ROOT


def test_versions_agree():
    assert nt.__version__ == importlib.metadata.version("normaltexture")
    said = subprocess.run([nt.program(), "--version"], capture_output=True, text=True, check=True)
    assert said.stdout.splitlines()[0] == f"ntp {nt.__version__}"
    assert "libpng" in nt.codecs


def test_the_installed_package_is_tested():
    assert not Path(nt.__file__).is_relative_to(ROOT / "bindings")


def test_what_is_exported_is_documented():
    for name in nt.__all__:
        thing = getattr(nt, name)
        if callable(thing):
            assert thing.__doc__, name
    public = {name for name in vars(nt) if not name.startswith("_")}
    modules = {name for name in public if isinstance(getattr(nt, name), type(nt))}
    assert public - modules == {name for name in nt.__all__ if not name.startswith("_")}


# Functions of libntp for which Python has something else.
ELSEWHERE = {
    "ntp_image_packed": "arrays",
    "ntp_image_as_const": "arrays",
    "ntp_resize_rows": "a ring of rows: arrays are whole",
    "ntp_orientation_row": "a ring of rows",
    "ntpio_is_current": "output files take what was read by themselves",
    "ntpio_copy": "shutil copies files",
    "ntpio_rewind": "files are read once",
    "ntpio_unpack": "files are read once",
    "ntpio_close_file": "files are closed when they are read",
    "ntp_find_border": "ntp_find_borders",
    "ntp_tally_harm": "the data of `check` has it",
}


def test_all_of_the_library_is_within_reach():
    sources = Path(nt.__file__).parent.rglob("*.py")
    used = set(re.findall(r"lib\.(ntp(?:io)?_\w+)", "".join(map(Path.read_text, sources))))
    functions = {name for name in dir(lib) if callable(getattr(lib, name))}
    assert len(functions) > 70
    assert functions - used == set(ELSEWHERE)


def test_the_program_of_the_scripts_directory_runs(test_files):
    script = Path(sysconfig.get_path("scripts")) / "ntp"
    done = subprocess.run(
        [script, "check", test_files / "standard.png"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and "well formed" in done.stdout


def test_the_program_is_found_by_many_threads_at_once(tmp_path):
    """In processes where nothing has looked for it before."""
    script = tmp_path / "threads.py"
    script.write_text(
        "import sys, threading\n"
        "from concurrent.futures import ThreadPoolExecutor\n"
        "import normaltexture as nt\n"
        "sys.setswitchinterval(1e-6)\n"
        "start = threading.Barrier(8)\n"
        "with ThreadPoolExecutor(8) as pool:\n"
        "    found = set(pool.map(lambda _: start.wait() >= 0 and nt.program(), range(8)))\n"
        "assert len(found) == 1\n"
    )
    for _ in range(8):
        done = subprocess.run([sys.executable, script], capture_output=True, check=False)
        assert done.returncode == 0, done.stderr.decode()


def test_check(test_files, tmp_path):
    report = nt.check([test_files / "standard.png", test_files / "standard_z_off.png"])
    fine, wrong = report.files
    assert (fine.type, wrong.type) == ("standard", "standard")
    assert fine.level in (None, "info") and wrong.level == "error"
    assert wrong.findings[0].id == "NT001" and not report.ok
    assert wrong.data["fail"]["exact"] == wrong.findings[0].count
    assert json.loads(json.dumps(report.to_dict()))["summary"]["files"] == 2
    assert nt.check(test_files / "standard.png").ok
    missing = nt.check(tmp_path / "none.png")
    assert missing.files[0].status == "unreadable" and not missing.ok
    strict = nt.check(test_files / "standard.png", y="down")
    assert "NT010" in [finding.id for finding in strict.files[0].findings]


def test_check_of_folders(test_files, tmp_path):
    for name in ("wall_n.png", "sub/floor_n.png", "sub/photo.png"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        original = "photograph.png" if "photo" in name else "standard.png"
        (tmp_path / name).write_bytes((test_files / original).read_bytes())
    assert len(nt.check(tmp_path).files) == 1
    found = nt.check(tmp_path, recursive=True, exclude=["floor*"])
    assert sorted(Path(file.path).name for file in found.files) == ["photo.png", "wall_n.png"]
    assert len(nt.check(tmp_path, recursive=True, match=["*_n.png"], jobs=1).files) == 2


def test_check_refuses_what_the_program_refuses(test_files):
    with pytest.raises(nt.ArgumentError, match="verdict"):
        nt.check(test_files / "standard.png", verdict="strict")
    with pytest.raises(nt.ArgumentError, match="at least one"):
        nt.check([])


def test_arrays_and_program_agree(test_files, tmp_path):
    """What the program writes is what the function returns."""

    def ntp(*args):
        done = subprocess.run([nt.program(), *map(str, args)], check=True, capture_output=True)
        return done.stdout

    source, height = test_files / "standard_z_off.png", test_files / "height_gray8.png"
    texture, heights = nt.read(source), nt.read(height)
    out = tmp_path / "out.png"
    cases = [
        (("clean", source), nt.clean(texture)),
        (("convert", source, "--to-y", "down", "--depth", 16),
         nt.convert(texture, to_y="down", depth=16)),
        (("heatmap", source), nt.heatmap(texture)),
        (("resize", source, "--size", "30%"), nt.resize(texture, size="30%")),
        (("transform", source, "--rotate", 90, "--strength", 2),
         nt.transform(texture, rotate=90, strength=2)),
        (("transform", source, "--rotate", -33.3, "--border-y", "clamp"),
         nt.transform(texture, rotate=-33.3, border_y="clamp")),
        (("blend", source, source, "--strength", 0.5), nt.blend(texture, texture, strength=0.5)),
        (("blend", source, source, "--mode", "linear", "--detail-alpha"),
         nt.blend(texture, texture, mode="linear", detail_alpha=True)),
        (("from-height", height, "--scale", 5, "--blur", 2, "--octaves", "1,0.5"),
         nt.normals_from_height(nt.blur_height(heights, 2, octaves=[1, 0.5]), 5, depth=8)),
        (("from-height", height, "--scale", "auto", "--strength", 0.5, "--kernel", "sobel3"),
         nt.normals_from_height(heights, "auto", strength=0.5, kernel="sobel3", depth=8)),
        (("curvature", source, "--kind", "cavity", "--blur", 1),
         nt.curvature(texture, kind="cavity", blur=1)),
        (("curvature", height, "--scale", 5, "--range", 0.5, "--border", "clamp"),
         nt.curvature(heights, scale=5, range=0.5, border="clamp")),
        (("occlusion", source, "--radius", 9), nt.occlusion(texture, radius=9)),
        (("occlusion", height, "--scale", 5, "--blur", 1, "--depth", 16),
         nt.occlusion(heights, scale=5, blur=1, depth=16)),
        (("from-height", height, "--like", "zima:2"), nt.pack_channels(nt.normals_from_height(heights, **nt.like("zima", 2)), "xzy")),
    ]  # fmt: skip
    for command, want in cases:
        ntp(*command, "-o", out)
        assert np.array_equal(nt.read(out), want), command


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ("zzero.png", "standard.png"),
        ("standard.png", "standard_z_off.png"),
        ("labpbr.png", "standard.png"),
        ("photograph.png", "photograph.png"),
    ],
)
def test_differences_of_arrays_and_program_agree(test_files, a, b):
    """Also what the two are taken for, where nothing says so."""
    paths = test_files / a, test_files / b
    command = [nt.program(), "diff", *paths, "--format", "json"]
    told = json.loads(subprocess.run(command, capture_output=True, check=False).stdout)
    found = nt.compare(*map(nt.read, paths))
    assert told["different"] == found.different
    assert told["angle_deg"]["max"] == pytest.approx(found.angles.max, abs=1e-3)


def test_heights_of_arrays_and_program_agree(test_files, tmp_path):
    """Kernel, borders and direction of green, told by the texels, are the program's."""
    height = nt.read(test_files / "height_gray16.png")
    textures = [nt.read(test_files / name) for name in ("standard.png", "standard_down.png")]
    for kernel, border, to_y, depth in (
        ("central", "wrap", "up", 16),
        ("sobel3", "extrapolate", "down", 16),
        ("forward", "mirror", "up", 8),
        ("prewitt3", "clamp", "down", 8),
    ):
        textures.append(
            nt.normals_from_height(
                height, scale=9, kernel=kernel, border=border, to_y=to_y, depth=depth
            )
        )
    for texture in textures:
        nt.write(tmp_path / "n.png", texture)
        command = [nt.program(), "to-height", "--type", "standard", tmp_path / "n.png"]
        command += ["-o", tmp_path / "h.pfm", "--format", "json"]
        done = subprocess.run(command, check=True, capture_output=True)
        told = json.loads(done.stdout)["files"][0]
        want, info = nt.height_from_normals_with_info(texture, type="standard")
        for name in ("method", "kernel", "border_x", "border_y", "y", "decode"):
            assert told[name] == getattr(info, name), name
        assert np.array_equal(nt.read(tmp_path / "h.pfm"), want)
