# SPDX-License-Identifier: MIT
"""ntp check: the kernel, the seams, the fit of a surface; of the middle, and --deep of all of it."""

import json

import numpy as np
import pytest

from support import libntp_ffi, maps, schemas, textures
from support import oracle_height as model
from support import to_height as reconstruction
from support.pngs import write_png
from support.spawn import spawn

ADDED = (
    *("kernel", "tiles", "residual_levels", "slope_step_deg", "surface_area"),
    "residual_area",
)


def only(run, *args, code=0):
    done = run("check", "--format", "json", *args)
    assert done.returncode == code, done.stderr
    report = json.loads(done.stdout)
    schemas.validate(report, "check-1")
    (file,) = report["files"]
    return file


def ids(file):
    return {f["id"] for f in file["findings"]}


@pytest.mark.parametrize("kernel", ["central", "forward", "sobel3", "scharr3"])
def test_kernel_tiling_and_fit(run, tmp_path, kernel):
    n = reconstruction.from_height(reconstruction.fractal(256), kernel)
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["kernel"] == kernel and file["tiles"] == {"x": "yes", "y": "yes"}
    assert 0.15 < file["residual_levels"] < 0.3
    assert not ids(file) & {"NT023", "NT052"}
    text = run("check", "a_n.png", "--deep").stdout
    assert f"kernel {kernel}\n" in text and "across: yes, down: yes\n" in text
    assert "fits a surface" not in run("check", "a_n.png", "--deep", "-q").stdout


@pytest.mark.parametrize("kernel", ["central", "forward", "scharr3"])
@pytest.mark.parametrize("border", ["clamp", "extrapolate", "mirror"])
def test_fit_does_not_depend_on_the_border(run, tmp_path, border, kernel):
    number = model.BORDER_NAMES.index(border)
    h = reconstruction.fractal(256)[20:180, 30:200].copy()
    write_png(tmp_path / "a_n.png", reconstruction.from_height(h, kernel, number, number))
    file = only(run, "a_n.png", "--deep")
    assert file["kernel"] == kernel and file["residual_levels"] < 0.4
    assert file["tiles"]["x"] != "yes" and file["tiles"]["y"] != "yes"


def test_plain_check(run, tmp_path):
    """The same as --deep up to 1024 x 1024, except for findings; reported in JSON and with -v."""
    n = reconstruction.from_height(reconstruction.fractal(256), "sobel3")[:, 30:170]
    write_png(tmp_path / "a_n.png", n)
    plain, deep = only(run, "a_n.png"), only(run, "a_n.png", "--deep")
    assert all(plain[key] == deep[key] for key in ADDED)
    assert plain["kernel"] == "sobel3" and plain["tiles"] == {"x": "no", "y": "yes"}
    assert plain["surface_area"] == {"x": 0, "y": 0, "width": 140, "height": 256}
    assert "NT052" in ids(deep) and "NT052" not in ids(plain)
    text = run("check", "-v", "a_n.png").stdout
    assert "with the kernel sobel3\n" in text and "across: no, down: yes\n" in text
    assert "fits a surface" in text and "middle" not in text
    assert "tiles" not in run("check", "a_n.png").stdout


def rms_off_inside(n):
    """By float64 transforms: the residual of the central differences of the best heights, in
    levels."""
    p, q = reconstruction.slopes(n)
    free = reconstruction.EXTRAPOLATE
    ours = reconstruction.by_eigenvectors(p, q, "central", free, free)
    p2 = (ours[3:-3, 4:-2] - ours[3:-3, 2:-4]) / 2
    q2 = (ours[4:-2, 3:-3] - ours[2:-4, 3:-3]) / 2
    pair = (p[3:-3, 3:-3], q[3:-3, 3:-3]), (p2, q2)
    a, b = (np.stack(v) / np.sqrt(1 + v[0] ** 2 + v[1] ** 2) for v in pair)
    return np.sqrt(np.mean((a - b) ** 2)) * 127.5


def test_middle_of_a_large_texture(run, tmp_path):
    """The kernel and the fit are those of the middle, the seams those of the whole."""
    rng = np.random.default_rng(5)
    n = np.tile(reconstruction.from_height(reconstruction.fractal(128)), (9, 10, 1))[:1100, :1200]
    painted = n.copy()
    paint = reconstruction.random_vectors(rng, (38, 1200), 0.3)
    painted[:38] = painted[-38:] = maps.to_type(maps.encode(paint))
    write_png(tmp_path / "a_n.png", n)
    write_png(tmp_path / "b_n.png", painted)
    whole, part = only(run, "a_n.png"), only(run, "b_n.png")
    assert whole["surface_area"] == {"x": 88, "y": 38, "width": 1024, "height": 1024}
    assert part["surface_area"] == whole["surface_area"]
    assert part["kernel"] == whole["kernel"] == "central"
    assert part["residual_levels"] == whole["residual_levels"] < 0.3  # not a row of the paint
    assert whole["tiles"] == {"x": "no", "y": "no"}
    deep = only(run, "b_n.png", "--deep")
    assert deep["surface_area"] == {"x": 0, "y": 0, "width": 1200, "height": 1100}
    assert deep["residual_levels"] > 1
    assert "(its middle, 1024 x 1024)\n" in run("check", "-v", "a_n.png").stdout
    assert "middle" not in run("check", "-v", "--deep", "a_n.png").stdout

    write_png(tmp_path / "c_n.png", n[:1024, :1152])  # 9 tiles across, 8 down
    tiled = only(run, "c_n.png")
    assert tiled["tiles"] == {"x": "yes", "y": "yes"} and tiled["surface_area"]["x"] == 64


@pytest.mark.parametrize("shape", [(16, 3000), (3000, 17), (40, 1025)])
def test_long_textures(run, tmp_path, shape):
    """Lines from edge to edge: the result of ntp_find_seams for the whole."""
    h, w = (side if side == 3000 else 2 * side for side in shape)  # only the longer one tiles
    heights = reconstruction.fractal(h, width=w)[: shape[0], : shape[1]]
    n = reconstruction.from_height(heights.copy())
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png")
    x, y = (libntp_ffi.ffi.new("ntp_seam *") for _ in "xy")
    src = libntp_ffi.view(n, libntp_ffi.STANDARD, const=True)
    libntp_ffi.check(libntp_ffi.lib.ntp_find_seams(x, y, src, 0))
    said = [("yes" if seam.tiles else "no") if seam.decided else "undecided" for seam in (x, y)]
    assert file["tiles"] == {"x": said[0], "y": said[1]}
    area = file["surface_area"]
    assert (area["width"], area["height"]) == (min(shape[1], 1024), min(shape[0], 1024))


def test_fit_is_that_of_the_best_heights(run, tmp_path):
    """Against dense float64 least squares, on noise."""
    rng = np.random.default_rng(11)
    n = reconstruction.random_vectors(rng, (70, 90), 0.3)
    levels = maps.to_type(maps.encode(n))
    write_png(tmp_path / "a_n.png", levels)
    file = only(run, "a_n.png", "--y", "up")
    assert file["kernel"] is None
    assert file["residual_levels"] == pytest.approx(rms_off_inside(levels), rel=2e-3)


def test_seam(run, tmp_path):
    n = reconstruction.from_height(reconstruction.fractal(256))[:, 30:170]
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["tiles"] == {"x": "no", "y": "yes"} and "NT052" in ids(file)
    assert "left and right edges" in run("check", "-v", "--deep", "a_n.png").stdout


def test_no_surface(run, tmp_path):
    """x and y of two surfaces: each texel is a unit vector, and nothing has these slopes."""
    one, other = (reconstruction.fractal(128, seed) for seed in (1, 2))
    p = np.roll(one, -1, 1) - one
    q = np.roll(other, -1, 0) - other
    n = maps.to_type(maps.encode(reconstruction.vectors_of(p, q)))
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["kernel"] is None and file["residual_levels"] > 8 and "NT023" in ids(file)
    assert all(f["level"] == "info" for f in file["findings"] if f["id"] == "NT023")
    plain = only(run, "a_n.png")  # the numbers, but no finding
    assert plain["residual_levels"] == file["residual_levels"] and "NT023" not in ids(plain)


def test_steps(run, tmp_path):
    """8-bit heights give a note with --deep and the number in JSON; the same heights in 16 bit do
    not."""
    h = reconstruction.fractal(256)
    h = (h - h.min()) / np.ptp(h)
    for name, levels in (("a_n.png", 255), ("b_n.png", 65535)):
        coarse = (30 * np.floor(h * levels + 0.5) / levels).astype(np.float32)
        write_png(tmp_path / name, reconstruction.from_height(coarse))
    file, fine = only(run, "a_n.png", "--deep"), only(run, "b_n.png", "--deep")
    assert file["slope_step_deg"] == pytest.approx(np.degrees(np.arctan(30 / 510)), rel=0.01)
    (note,) = (f for f in file["findings"] if f["id"] == "NT033")
    assert note["level"] == "info" and "steps of 3.3" in note["message"]
    assert fine["slope_step_deg"] is None and "NT033" not in ids(fine)
    plain = only(run, "a_n.png")
    assert plain["slope_step_deg"] == file["slope_step_deg"] and "NT033" not in ids(plain)
    for option in ("-v", "--deep"):
        assert "slopes are quantized     in steps of 3.3" in run("check", option, "a_n.png").stdout
        assert "in steps" not in run("check", option, "b_n.png").stdout
    maps.Image.fromarray(reconstruction.from_height(coarse)).save(tmp_path / "c_n.jpg", quality=95)
    assert only(run, "c_n.jpg", "--deep")["slope_step_deg"] is None


def test_green_down(run, tmp_path):
    n = reconstruction.from_height(reconstruction.fractal(128))
    n[..., 1] = 255 - n[..., 1]
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["y"] == "down" and file["kernel"] == "central" and file["residual_levels"] < 0.4
    wrong = only(run, "a_n.png", "--deep", "--y", "up")  # as asked: it does not fit
    assert wrong["kernel"] is None and wrong["residual_levels"] > 5


def box(area):
    return area["x"], area["y"], area["width"], area["height"]


@pytest.mark.parametrize("kernel", ["central", "forward", "scharr3"])
def test_holes(run, tmp_path, kernel):
    """The fit is for the texels around them; in a small texture, for all of it."""
    n = reconstruction.from_height(reconstruction.fractal(128), kernel)
    n[40:60, 50:90] = 0
    n[100, 20] = n[7, 100:103] = 255
    write_png(tmp_path / "a_n.png", n)
    file, plain = only(run, "a_n.png", "--deep"), only(run, "a_n.png")
    assert file["kernel"] == plain["kernel"] == kernel
    assert 0.15 < file["residual_levels"] < 0.3
    assert plain["residual_levels"] == pytest.approx(file["residual_levels"], rel=0.05)
    assert box(plain["residual_area"]) == box(file["residual_area"]) == (0, 0, 128, 128)


def fullest(used, side):
    """Corner of the square in 16s that has most used texels, the nearest to the middle; the share."""
    h, w = used.shape
    best = None
    for y in range(0, h // 16 * 16 - side + 1, 16):
        for x in range(0, w // 16 * 16 - side + 1, 16):
            off = np.hypot(x + side / 2 - w // 16 * 8, y + side / 2 - h // 16 * 8)
            key = (-used[y : y + side, x : x + side].sum(), off)
            if best is None or key < best[0]:
                best = key, (x, y)
    return best[1], -best[0][0] / side**2


@pytest.mark.parametrize(("case", "side"), [("few", 256), ("rows", 128), ("many", 128)])
def test_part_of_a_texture_with_holes(run, tmp_path, case, side):
    """A square without holes if there is one, else around the fewest; by exhaustive search."""
    rng = np.random.default_rng(31)
    n = reconstruction.from_height(reconstruction.fractal(512))[:505, :490].copy()
    used = np.ones(n.shape[:2], bool)
    if case == "few":
        used[300:310] = used[:, 100:110] = False
    elif case == "rows":
        used[::150] = False
    else:
        used[rng.random(used.shape) < 0.01] = False
        used[:200, :300] &= rng.random((200, 300)) < 0.5
    n[~used] = 0
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png")
    (x, y), share = fullest(used, side)
    assert box(file["residual_area"]) == (x, y, side, side)
    assert box(file["surface_area"]) == (0, 0, 490, 505)
    assert 0.15 < file["residual_levels"] < 0.3 and (share == 1) == (case != "many")
    assert f"({side} x {side} texels at {x}, {y})\n" in run("check", "-v", "a_n.png").stdout
    part = n[y : y + side, x : x + side].copy()
    if share == 1:  # as of a texture that is no more than this part
        write_png(tmp_path / "b_n.png", part)
        alone = only(run, "b_n.png", "--y", "up")["residual_levels"]
        assert file["residual_levels"] == pytest.approx(alone, rel=0.05)


def test_paint_around_holes_and_too_many(run, tmp_path):
    rng = np.random.default_rng(32)
    n = maps.to_type(maps.encode(reconstruction.random_vectors(rng, (300, 300), 0.3)))
    n[rng.random(n.shape[:2]) < 0.05] = 0
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png")
    assert file["residual_levels"] > 8 and "NT023" not in ids(file)
    n = reconstruction.from_height(reconstruction.fractal(300))
    n[rng.random(n.shape[:2]) < 0.9] = 0
    write_png(tmp_path / "b_n.png", n)
    file = only(run, "b_n.png")
    assert file["residual_levels"] is None and file["residual_area"] is None


@pytest.mark.parametrize("name", ["right", "rotated", "exchanged"])
def test_exchanged_x_and_y(run, tmp_path, name):
    """Rotating a picture without its normals exchanges them too, whichever way green points."""
    n = reconstruction.from_height(reconstruction.fractal(128), "central")
    wrong = {"right": n, "rotated": np.rot90(n), "exchanged": n[..., [1, 0, 2]]}[name]
    write_png(tmp_path / "a_n.png", np.ascontiguousarray(wrong))
    assert "NT013" not in ids(only(run, "a_n.png"))
    assert ("NT013" in ids(only(run, "a_n.png", "--deep", code=int(name != "right")))) == (
        name != "right"
    )


def test_what_has_no_slopes(run, tmp_path):
    rng = np.random.default_rng(3)
    flat = np.full((64, 64, 3), (128, 128, 255), np.uint8)
    cases = {
        "h.png": (textures.heights(), 1),
        "p.png": (textures.photograph(), 1),
        "f_n.png": (flat, 0),
        "t_n.png": (textures.standard(64, 64)[:1, :1], 0),
        "noise_n.png": (rng.integers(0, 256, (40, 40, 3), dtype=np.uint8), None),
    }
    for name, (pixels, code) in cases.items():
        write_png(tmp_path / name, pixels)
        done = run("check", "--deep", "--format", "json", name)
        assert code is None or done.returncode == code, name
        (file,) = json.loads(done.stdout)["files"]
        schemas.validate(json.loads(done.stdout), "check-1")
        assert file["kernel"] is None, name
        plain = json.loads(run("check", "--format", "json", name).stdout)
        schemas.validate(plain, "check-1")
        assert all(plain["files"][0][key] == file[key] for key in ADDED), name


def test_standard_input(program, tmp_path):
    """It can be read only once, and is held."""
    n = reconstruction.from_height(reconstruction.fractal(64))
    write_png(tmp_path / "a_n.png", n)
    with open(tmp_path / "a_n.png", "rb") as file:
        done = spawn([program, "check", "--deep", "-"], stdin=file, text=True)
    assert done.returncode == 0 and "kernel central" in done.stdout
