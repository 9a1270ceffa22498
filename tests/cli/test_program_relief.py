# SPDX-License-Identifier: MIT
"""ntp curvature and ntp occlusion: the library's numbers in files, ranges, scales, refusals."""

import json

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import relief_maps as maps
from support.pngs import read_png, write_png

HEIGHTS = maps.hills(40, 65535)[:33].astype(np.uint16)
KINDS = {"mean": maps.MEAN, "gaussian": maps.GAUSSIAN, "convex": maps.CONVEX, "cavity": maps.CAVITY}


def pixels_of(path):
    pixels, _ = read_png(path)
    return pixels


def texts_of(path):
    _, chunks = read_png(path)
    pairs = [body.split(b"\0", 1) for body in chunks.get(b"tEXt", [])]
    return {key.decode(): value.decode() for key, value in pairs}


def item(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["files"][0]


@pytest.fixture
def files(run, tmp_path):
    """Heights, and the normals that the program makes of them; returns the normals."""
    write_png(tmp_path / "h.png", HEIGHTS[..., None])
    done = run("from-height", "h.png", "-o", "n.png", "--scale", 9)
    assert done.returncode == 0, done.stderr
    return pixels_of(tmp_path / "n.png")


@pytest.mark.parametrize("kind", KINDS)
def test_curvature(run, tmp_path, files, kind):
    """Of heights and of normals, with the range that is found and with one that is given."""
    for name, src, encoding, more in (
        ("h.png", HEIGHTS, ntp.HEIGHT, {"scale": 9}),
        ("n.png", files, ntp.STANDARD, {}),
    ):
        options = ["--scale", 9] if more else ["--y", "up"]
        options += ["--border", "wrap"]
        args = [name, "--kind", kind, *options, "--format", "json"]
        made = item(run("curvature", *args, "-o", "c.png"))
        raw = maps.curvature(src, encoding, kind=KINDS[kind], **more)
        assert made["kind"] == kind and made["range"] == maps.range_of(raw)
        assert float(texts_of(tmp_path / "c.png")["Curvature range"]) == made["range"]
        for depth, dtype in (("16", np.uint16), ("8", np.uint8)):
            told = item(run("curvature", *args, "-o", "c.png", "--range", 0.25, "--depth", depth))
            want = maps.curvature(src, encoding, dtype, kind=KINDS[kind], range=0.25, **more)
            assert told["range"] == 0.25
            assert np.array_equal(pixels_of(tmp_path / "c.png")[..., 0], want)
    # Heights and their normals bend alike, but for the wider stencil.
    assert item(run("curvature", *args, "-o", "c.pfm"))["range"] is None


def test_occlusion(run, tmp_path, files):
    """From heights: the library's numbers; from their normals: nearly the same."""
    run("occlusion", "h.png", "-o", "a.png", "--scale", 9, "--jobs", 2, "--border", "wrap")
    want = maps.occlusion(HEIGHTS, np.uint16, scale=9)
    made = pixels_of(tmp_path / "a.png")[..., 0]
    assert np.array_equal(made, want) and made.min() < 50000
    solved = item(run("occlusion", "n.png", "-o", "b.png", "--format", "json", "--border", "wrap"))
    assert solved["y"] == "up" and solved["scale"] is None and solved["depth"] == 16
    assert abs(pixels_of(tmp_path / "b.png")[..., 0].astype(int) - made).max() < 400
    run("occlusion", "h.png", "-o", "r.png", "--scale", 9, "--radius", 3, "--border", "clamp")
    near = maps.occlusion(
        HEIGHTS, np.uint16, scale=9, radius=3,
        border_x=maps.CLAMP, border_y=maps.CLAMP,
    )  # fmt: skip
    assert np.array_equal(pixels_of(tmp_path / "r.png")[..., 0], near)


def test_pit_of_normals(run, tmp_path):
    """A dent that is part of a ball, of its normals: each point of it sees 3/4 of the sky."""
    y, x = np.mgrid[-80:81, -80:81].astype(float)
    rim = 70
    far, radius = np.hypot(x, y), rim / np.sin(np.radians(60))
    deep = np.sqrt(np.maximum(radius**2 - far**2, 1))
    n = np.where((far < rim)[..., None], np.stack([-x, y, deep], -1) / radius, (0, 0, 1))
    write_png(tmp_path / "n.png", np.floor((n + 1) / 2 * 65535 + 0.5).astype(np.uint16))
    told = ["--type", "standard", "--y", "up", "--border", "clamp"]
    item(run("occlusion", "n.png", "-o", "a.png", *told, "--format", "json"))
    made = pixels_of(tmp_path / "a.png")[..., 0] / 65535
    assert abs(made / 0.75 - 1)[far < 0.9 * rim].max() < 0.01


@pytest.mark.parametrize("kind", ["cylinder", 0.5, 1.0, 2.0])
def test_groove_of_normals(run, tmp_path, kind):
    """A trench and grooves of straight sides, of their central differences in 16 bit."""
    h, known, inside = maps.groove(kind, 20)
    right = np.roll(h, -1, 1) - np.roll(h, 1, 1)
    n = np.stack([-right / 2, 0 * right, np.ones_like(right)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    levels = np.floor((n + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    write_png(tmp_path / "n.png", np.tile(levels, (2, 1, 1)))
    told = ["--type", "standard", "--y", "up", "--border", "wrap"]
    item(run("occlusion", "n.png", "-o", "a.png", *told, "--format", "json"))
    made = pixels_of(tmp_path / "a.png")[7, :, 0] / 65535
    inside &= kind == "cylinder" or abs(np.arange(-100, 101)) > 2
    assert abs(made[inside] / known[inside] - 1).max() < 0.01


def test_borders(run, tmp_path):
    """A tile wraps, a part of it does not, of heights in any channel and of normals."""
    tile = maps.hills(160, 65535, 12).astype(np.uint16)
    cut = np.ascontiguousarray(tile[10:110, 20:120])
    clamp = {"border_x": maps.CLAMP, "border_y": maps.CLAMP}
    for h, found, how, solved in ((tile, "wrap", {}, "wrap"), (cut, "clamp", clamp, "extrapolate")):
        write_png(tmp_path / "h.png", h[..., None])
        write_png(tmp_path / "c.png", np.stack([0 * h, h, 0 * h], -1))
        run("from-height", "h.png", "-o", "n.png", "--scale", 20, "--border", solved)
        scaled, up = ["--scale", 20, "--type", "height"], ["--type", "standard", "--y", "up"]
        for name, told in (
            ("h.png", scaled),
            ("c.png", [*scaled, "--source", "green"]),
            ("n.png", up),
        ):
            for verb in ("curvature", "occlusion"):
                made = item(run(verb, name, "-o", "a.png", *told, "--format", "json"))
                assert (made["border_x"], made["border_y"]) == (found, found), (verb, name)
                run(verb, name, "-o", "b.png", *told, "--border", found)
                if verb == "curvature" or name != "n.png":  # it solves heights that wrap
                    assert np.array_equal(*(pixels_of(tmp_path / f"{f}.png") for f in "ab"))
        run("occlusion", "h.png", "-o", "a.png", *scaled)
        want = maps.occlusion(h, np.uint16, scale=20, **how)
        assert np.array_equal(pixels_of(tmp_path / "a.png")[..., 0], want)
    done = run("occlusion", "h.png", "-o", "a.png", *scaled, "--border-x", "wrap")
    assert "border-y clamp" in done.stdout


def test_scale_of_heights(run, tmp_path, files):
    """What ntp to-height stored is taken; heights without a scale are refused with its name."""
    done = run("curvature", "h.png", "-o", "c.png")
    assert done.returncode == 1 and "--scale" in done.stderr
    assert run("occlusion", "h.png", "-o", "c.png", "--scale", 0).returncode == 1
    assert not (tmp_path / "c.png").exists()
    solved = item(run("to-height", "n.png", "-o", "back.png", "--format", "json"))
    made = item(run("curvature", "back.png", "-o", "c.png", "--format", "json"))
    assert made["scale"] == pytest.approx(solved["scale"]) and made["from"] == "height"
    assert "Height scale" not in texts_of(tmp_path / "c.png")
    run("to-height", "n.png", "-o", "back.pfm")
    assert item(run("curvature", "back.pfm", "-o", "c.png", "--format", "json"))["scale"] == 1
    auto = ["--scale", "auto", "--format", "json"]
    suits = item(run("from-height", "h.png", "-o", "m.png", *auto))["scale"]
    assert item(run("occlusion", "h.png", "-o", "c.png", *auto))["scale"] == suits
    assert item(run("curvature", "h.png", "-o", "c.png", "--blur", 2, *auto))["scale"] == suits
    assert pixels_of(tmp_path / "c.png").dtype == np.uint16


def test_green(run, tmp_path, files):
    """Normals for DirectX give the map of those for OpenGL; unknown green is asked for."""
    write_png(tmp_path / "dx.png", np.abs(files.astype(int) - [0, 65535, 0]).astype(np.uint16))
    assert item(run("curvature", "n.png", "-o", "a.png", "--format", "json"))["y"] == "up"
    assert item(run("curvature", "dx.png", "-o", "b.png", "--format", "json"))["y"] == "down"
    assert np.array_equal(pixels_of(tmp_path / "a.png"), pixels_of(tmp_path / "b.png"))
    write_png(tmp_path / "s.png", np.ascontiguousarray(files[:12, :12]))
    done = run("curvature", "s.png", "-o", "s2.png", "--type", "standard")
    assert done.returncode == 1 and "--y" in done.stderr


def test_blur(run, tmp_path, files):
    """Blurred normals bend less, by the blur of their curvature: it is linear in them."""
    plain = item(run("curvature", "n.png", "-o", "a.pfm", "--format", "json"))
    assert plain["depth"] == "float"
    ranges = [
        item(run("curvature", "n.png", "-o", "a.png", "--blur", s, "--format", "json"))["range"]
        for s in (0, 1, 3)
    ]
    assert ranges == sorted(ranges, reverse=True) and ranges[2] < 0.6 * ranges[0]


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["curvature", "n.png", "-o", "c.pfm", "--depth", "8"], "PFM holds floats"),
        (["occlusion", "n.png", "-o", "c.png", "--depth", "float"], "writes .pfm"),
        (["occlusion", "n.png", "-o", "c.tga", "--depth", "16"], "TGA"),
        (["curvature", "n.png", "-o", "c.png", "--kind", "sharp"], "cavity"),
        (["curvature", "n.png", "-o", "c.png", "--border", "mirror"], "clamp"),
    ],
)
def test_wrong_use(run, args, words):
    done = run(*args)
    assert done.returncode == 2 and words in done.stderr
