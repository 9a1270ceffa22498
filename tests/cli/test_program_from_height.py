# SPDX-License-Identifier: MIT
"""ntp from-height: files against the model in oracle_height.py, options, layouts, refusals."""

import json

import numpy as np
import pytest

from support import oracle_height as model
from support.pngs import read_png, write_png


def pixels_of(path):
    return read_png(path)[0]


def heights(shape, dtype=np.uint8, seed=1):
    top = np.iinfo(dtype).max
    return np.random.default_rng(seed).integers(0, top + 1, shape).astype(dtype)


def make(run, tmp_path, src, *args, code=0):
    """The pixels of from-height on src."""
    write_png(tmp_path / "h.png", src)
    done = run("from-height", "h.png", "-o", "n.png", *args)
    assert done.returncode == code, done.stderr
    return pixels_of(tmp_path / "n.png") if code == 0 else done.stderr


@pytest.mark.parametrize("kernel", model.NAMES)
def test_every_kernel(run, tmp_path, kernel):
    src = heights((7, 9))
    ours = make(run, tmp_path, src, "--scale", 6.5, "--kernel", kernel)
    assert np.array_equal(ours, model.normals(src, kernel, scale=6.5))


@pytest.mark.parametrize("border_x", model.BORDERS)
@pytest.mark.parametrize("border_y", model.BORDERS)
def test_every_border(run, tmp_path, border_x, border_y):
    src = heights((6, 8))
    names = model.BORDER_NAMES
    args = ["--border-x", names[border_x], "--border-y", names[border_y], "--kernel", "sobel5"]
    ours = make(run, tmp_path, src, "--scale", -3, *args)
    assert np.array_equal(ours, model.normals(src, "sobel5", border_x, border_y, -3.0))


@pytest.mark.parametrize("source", model.SOURCES)
def test_every_source(run, tmp_path, source):
    src = heights((5, 6, 4))
    ours = make(run, tmp_path, src, "--scale", 4, "--source", source, "--channels", "xyz")
    assert np.array_equal(ours, model.normals(src, scale=4.0, source=source))
    if source == "alpha":
        assert "no alpha" in make(
            run, tmp_path, src[..., :3], "--scale", 1, "--source", source, code=2
        )


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_depths_and_encodings(run, tmp_path, dtype, depth):
    src = heights((6, 7), dtype)
    dst = np.uint8 if depth == 8 else np.uint16
    plain = make(run, tmp_path, src, "--scale", 9, "--depth", depth)
    assert plain.dtype == dst and np.array_equal(plain, model.normals(src, scale=9.0, dst=dst))
    kept = make(run, tmp_path, src, "--scale", 9)
    assert kept.dtype == dtype
    args = ["--to", "zzero", "--to-y", "down", "--blue", "nearest", "--min-z", "0.4", "--invert"]
    args += ["--dx", "2", "--dy", "0.5"]
    ours = make(run, tmp_path, src, "--scale", 9, "--depth", depth, *args)
    how = {"zz": True, "y_down": True, "nearest": True, "min_z": 0.4, "invert": True}
    assert np.array_equal(ours, model.normals(src, scale=9.0, dx=2.0, dy=0.5, dst=dst, **how))


@pytest.mark.parametrize("border", model.BORDER_NAMES)
def test_tall_images_stream(run, tmp_path, border):
    """More rows than the ring: each band is as if made from the whole."""
    src = heights((700, 150), seed=3)
    ours = make(run, tmp_path, src, "--scale", 5, "--kernel", "gimp9", "--border", border)
    number = model.BORDER_NAMES.index(border)
    h = model.heights(src)
    rng = np.random.default_rng(4)
    ys = [0, 1, 4, 5, 63, 64, 65, 127, 128, 350, 640, 690, 695, 698, 699]
    for y in ys:
        for x in [0, 3, 149, *rng.integers(0, 150, 5)]:
            p, q = model.slopes(h, int(x), y, "gimp9", number, number, 5.0, 1.0, 1.0)
            assert tuple(ours[y, x].tolist()) == model.texel(p, q, 255), (x, y)


def test_like(run, tmp_path):
    src = heights((6, 7, 3))
    ours = make(run, tmp_path, src, "--like", "reference:5")
    assert np.array_equal(ours, model.normals(src, scale=10.0))
    ours = make(run, tmp_path, src, "--like", "zima:2")
    zima = model.normals(src, "sobel3", scale=-16.0, y_down=True)
    assert np.array_equal(ours, zima[..., [0, 2, 1]])
    ours = make(run, tmp_path, src, "--like", "gimp-normalmap:9x9:1.5", "--border", "wrap")
    scale = 1.5 * 170 / 77
    gimp = model.normals(src, "gimp9", scale=scale, y_down=True, source="luma-gimp")
    assert np.array_equal(ours, gimp)
    for wrong in ("nobody:1", "gegl", "gegl:", "gegl:x", ":1"):
        make(run, tmp_path, src, "--like", wrong, code=2)
    make(run, tmp_path, src, "--like", "gegl:1", "--scale", 1, code=2)


def test_alpha_and_layouts(run, tmp_path):
    src = heights((6, 7, 4))
    plain = model.normals(src, scale=3.0)
    kept = make(run, tmp_path, src, "--scale", 3)
    assert np.array_equal(kept, np.dstack([plain, src[..., 3]]))
    high = make(run, tmp_path, src, "--scale", 3, "--alpha", "height")
    assert np.array_equal(high[..., 3], src[..., 0])
    inverse = make(run, tmp_path, src, "--scale", 3, "--alpha", "inverse")
    assert np.array_equal(inverse[..., 3], 255 - src[..., 3])
    one = make(run, tmp_path, src, "--scale", 3, "--alpha", "one")
    assert (one[..., 3] == 255).all()
    other, ao = heights((6, 7), np.uint16, 8), heights((6, 7), np.uint8, 9)
    write_png(tmp_path / "a.png", other)
    write_png(tmp_path / "ao.png", ao)
    lab = make(run, tmp_path, src, "--scale", 3, "--to", "xy", "--ao", "ao.png", "--alpha", "a.png")
    xy = model.normals(src, scale=3.0, xy=True)
    narrow = (other.astype(int) + 128) // 257
    assert np.array_equal(lab, np.dstack([xy[..., :2], ao, narrow.astype(np.uint8)]))
    swizzled = make(run, tmp_path, src, "--scale", 3, "--channels", "1y0x")
    assert np.array_equal(swizzled[..., [1, 3]], plain[..., [1, 0]])
    assert (swizzled[..., 0] == 255).all() and (swizzled[..., 2] == 0).all()
    with_height = make(run, tmp_path, src, "--scale", 3, "--channels", "xyzh")
    assert np.array_equal(with_height, np.dstack([plain, src[..., 0]]))
    two = make(run, tmp_path, src, "--scale", 3, "--channels", "xy")
    assert np.array_equal(two, plain[..., :2])


@pytest.mark.parametrize(("dtype", "border"), [(np.uint8, "wrap"), (np.uint16, "clamp")])
def test_scale_of_the_heights(run, tmp_path, dtype, border):
    """--scale auto: one in twenty of the slopes above 45 degrees, rounded; told, and multiplied."""
    x = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    hills = 0.5 + 0.25 * (np.sin(3 * x)[:, None] + np.cos(2 * x))
    src = np.round(hills * np.iinfo(dtype).max).astype(dtype)
    args = ["--border", border, "--blur", 1]
    write_png(tmp_path / "h.png", src)
    done = run("from-height", "h.png", "-o", "n.png", "--scale", "auto", *args, "--format", "json")
    scale = json.loads(done.stdout)["files"][0]["scale"]
    edge = np.pad(src, 1, "wrap" if border == "wrap" else "edge") / float(np.iinfo(dtype).max)
    across = (edge[1:-1, 2:] - edge[1:-1, :-2]) / 2
    down = (edge[2:, 1:-1] - edge[:-2, 1:-1]) / 2
    steep = np.hypot(across, down)[(across != 0) | (down != 0)] * scale
    assert scale == float(f"{scale:.3g}")
    assert np.mean(steep * 0.985 > 1) <= 0.05 <= np.mean(steep * 1.015 >= 1)
    for strength in (1, -0.5):
        ours = make(run, tmp_path, src, "--scale", "auto", "--strength", strength, *args)
        told = make(run, tmp_path, src, "--scale", repr(scale * strength), *args)
        assert np.array_equal(ours, told)
    flat = make(run, tmp_path, np.full((9, 9), 7, dtype), "--scale", "auto")
    assert np.array_equal(flat, make(run, tmp_path, np.full((9, 9), 7, dtype), "--scale", 1))


def test_report_says_every_choice(run, tmp_path):
    write_png(tmp_path / "h.png", heights((6, 7)))
    done = run("from-height", "h.png", "-o", "n.png", "--scale", "0.1", "--format", "json")
    (item,) = json.loads(done.stdout)["files"]
    assert item["scale"] == 0.1 and item["kernel"] == "central" and item["output"] == "n.png"
    assert item["border_x"] == item["border_y"] == "wrap" and item["to_y"] == "up"
    assert item["depth"] == 8 and item["texels"] == 42 and item["not_finite"] == 0


@pytest.mark.parametrize(
    "args",
    [
        (),
        ("--scale", "nan"),
        ("--scale", "automatic"),
        ("--scale", "auto", "--strength", "auto"),
        ("--scale", "auto", "--like", "gegl:1"),
        ("--scale", "1e999"),
        ("--scale", "1", "--dx", "0"),
        ("--scale", "1", "--dy", "-1"),
        ("--scale", "1", "--min-z", "1.5"),
        ("--scale", "1", "--kernel", "sobel4"),
        ("--scale", "1", "--border", "none"),
        ("--scale", "1", "--channels", "xyq"),
        ("--scale", "1", "--channels", "xyah"),
        ("--scale", "1", "--ao", "h.png"),
        ("--scale", "1e300", "--dx", "1e-300"),
    ],
)
def test_usage_errors(run, tmp_path, args):
    write_png(tmp_path / "h.png", heights((4, 4)))
    done = run("from-height", "h.png", "-o", "n.png", *args)
    assert done.returncode == 2 and done.stderr.startswith("ntp: ")
    assert not (tmp_path / "n.png").exists()


def test_other_images_must_fit(run, tmp_path):
    write_png(tmp_path / "h.png", heights((4, 4)))
    write_png(tmp_path / "a.png", heights((4, 5)))
    done = run("from-height", "h.png", "-o", "n.png", "--scale", "1", "--alpha", "a.png")
    assert done.returncode == 2 and "size" in done.stderr
    done = run("from-height", "h.png", "-o", "n.png", "--scale", "1", "--alpha", "missing.png")
    assert done.returncode == 3
    assert not (tmp_path / "n.png").exists()


def test_blur_octaves_dither(run, tmp_path):
    src = heights((40, 50), np.uint16, 11)
    plain = make(run, tmp_path, src, "--scale", 9)
    one = make(run, tmp_path, src, "--scale", 9, "--octaves", "1")  # heights become floats
    assert np.abs(one.astype(int) - plain)[..., :2].max() <= 1
    blurred = make(run, tmp_path, src, "--scale", 9, "--blur", 2)
    assert blurred[..., 2].mean() > plain[..., 2].mean()
    sums = make(run, tmp_path, src, "--scale", 9, "--octaves", "0,1,0.5")
    rolled = np.roll(src, (13, 17), (0, 1))
    again = make(run, tmp_path, rolled, "--scale", 9, "--octaves", "0,1,0.5")
    assert np.array_equal(again, np.roll(sums, (13, 17), (0, 1)))
    dithered = make(run, tmp_path, src, "--scale", 0.3, "--depth", 8, "--dither", "integrable")
    rounded = make(run, tmp_path, src, "--scale", 0.3, "--depth", 8)
    difference = np.abs(dithered.astype(int) - rounded)[..., :2]
    assert 0 < difference.max() <= 2
    with_alpha = heights((20, 30, 4))
    kept = make(run, tmp_path, with_alpha, "--scale", 9, "--blur", 1)
    assert np.array_equal(kept[..., 3], with_alpha[..., 3])
    for wrong in ("", "1,", "a", "1,,2", "1,2,3,4,5,6,7,8,9"):
        make(run, tmp_path, src, "--scale", 1, "--octaves", wrong, code=2)
    make(run, tmp_path, src, "--scale", 1, "--blur", "-1", code=2)
