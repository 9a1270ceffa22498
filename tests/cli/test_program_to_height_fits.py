# SPDX-License-Identifier: MIT
"""`ntp to-height`: borders by trying, clipping, and warnings where the fit is poor."""

import numpy as np
import pytest

from support import to_height as reconstruction
from support.pngs import read_png, write_png
from support.run_to_height import make_normals, only, read_pfm, texts

EVERY = ["wrap", "clamp", "mirror", "extrapolate"]


def write_noisy(tmp_path, heights, border, noise, seed=3):
    """n.png: normals of these heights, moved by noise of so many levels."""
    rng = np.random.default_rng(seed)
    at = reconstruction.WRAP if border == "wrap" else reconstruction.EXTRAPOLATE
    n = reconstruction.from_height(heights, "central", at, at).astype(float)
    n[..., :2] += rng.normal(0, noise, n[..., :2].shape)
    write_png(tmp_path / "n.png", n.round().clip(1, 254).astype(np.uint8))


@pytest.mark.parametrize("border", ["wrap", "extrapolate"])
def test_where_no_border_shows_the_best_fit_decides(run, tmp_path, border):
    """Of noisy normals, whose edges show nothing."""
    h = reconstruction.fractal(96, rms_slope=0.3)
    if border == "extrapolate":
        h = h[:80, :64] + np.arange(64) * 0.4 - np.arange(80)[:, None] * 0.3
    write_noisy(tmp_path, h, border, 8)
    how = ["--type", "standard", "--kernel", "central", "--y", "up"]
    found = only(run, "n.png", "-o", "auto.png", *how)
    fits = {
        b: only(run, "n.png", "-o", f"{b}.png", *how, "--border", b)["residual_levels"]
        for b in EVERY
    }
    assert found["residual_levels"] <= min(fits.values()) * 1.02, (found, fits)
    assert fits["mirror"] > 1.1 * min(fits.values())  # what was taken before
    assert "mirror" not in (found["border_x"], found["border_y"])
    assert found["border_x_by"] == found["border_y_by"] == "texels"
    free = only(run, "n.png", "-o", "p.png", *how, "--method", "poisson-dct")
    assert "wrap" not in (free["border_x"], free["border_y"])
    held = only(run, "n.png", "-o", "m.png", *how, "--border-x", "mirror")
    assert (held["border_x"], held["border_x_by"]) == ("mirror", "option")


def clipped_by_model(heights, percent):
    ordered = np.sort(heights, axis=None)
    k = int(len(ordered) * percent / 100)
    return heights.clip(ordered[k], ordered[-1 - k])


@pytest.mark.parametrize("percent", ["0", "0.1", "0.1%", "3", "49%"])
def test_clipping(run, tmp_path, surface, percent):
    make_normals(run)
    only(run, "n.png", "-o", "all.pfm")
    all_heights = read_pfm(tmp_path / "all.pfm")
    want = clipped_by_model(all_heights, float(percent.rstrip("%")))
    file = only(run, "n.png", "-o", "clipped.pfm", "--clip", percent)
    assert np.array_equal(read_pfm(tmp_path / "clipped.pfm"), want)
    assert file["clip"] == float(percent.rstrip("%"))
    assert file["clipped"] == np.count_nonzero(want != all_heights)
    assert (file["min"], file["max"]) == (want.min(), want.max())
    middle = np.sort(want, axis=None)
    k = len(middle) // 100
    share = (float(middle[-1 - k]) - float(middle[k])) / (float(want.max()) - float(want.min()))
    assert file["middle_share"] == pytest.approx(share, rel=1e-12)
    file = only(run, "n.png", "-o", "clipped.png", "--clip", percent)
    back = read_png(tmp_path / "clipped.png")[0][..., 0] / 65535 * file["scale"] + file["offset"]
    assert np.abs(back - want).max() <= 0.51 * file["scale"] / 65535
    assert texts(tmp_path / "clipped.png")["Height scale"] == f"{file['scale']:.9g}"
    line = run("to-height", "n.png", "-o", "x.png", "--clip", percent).stdout
    assert (f"{file['clipped']:,} heights clipped" in line) == (file["clipped"] > 0)


def test_clipping_leaves_holes_out_of_the_count(run, tmp_path, surface):
    make_normals(run)
    pixels = read_png(tmp_path / "n.png")[0].copy()
    pixels[:64] = 0
    write_png(tmp_path / "n.png", pixels)
    only(run, "n.png", "-o", "all.pfm")
    all_heights = read_pfm(tmp_path / "all.pfm")
    want = clipped_by_model(all_heights[64:], 5)
    file = only(run, "n.png", "-o", "clipped.pfm", "--clip", "5")
    assert file["holes"] >= 64 * 128
    assert np.array_equal(read_pfm(tmp_path / "clipped.pfm")[64:], want)


@pytest.mark.parametrize("percent", ["50", "-1", "%", "1%%", "0.1 %", "nan"])
def test_clip_is_a_percentage(run, tmp_path, surface, percent):
    make_normals(run)
    done = run("to-height", "n.png", "-o", "x.png", "--clip", percent)
    assert done.returncode == 2 and "--clip" in done.stderr


def test_spikes_are_told(run, tmp_path, surface):
    make_normals(run)
    assert only(run, "n.png", "-o", "plain.png")["notes"] == []
    rng = np.random.default_rng(4)
    h = 0.3 * rng.random((128, 128))
    h[40:42, 50:53] += 60
    write_png(tmp_path / "n.png", reconstruction.from_height(h.astype(np.float32), dst=np.uint16))
    file = only(run, "n.png", "-o", "spiked.png", "--border", "wrap", "--kernel", "central")
    assert file["middle_share"] < 0.03 and len(file["notes"]) == 1
    assert "--clip" in file["notes"][0]
    line = run("to-height", "n.png", "-o", "x.png", "--border", "wrap", "--kernel", "central")
    assert f"note: {file['notes'][0]}" in line.stdout
    file = only(
        run, "n.png", "-o", "cut.png", "--border", "wrap", "--kernel", "central", "--clip", "0.1"
    )
    assert file["middle_share"] > 0.5 and file["notes"] == []


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_a_poor_fit_is_a_warning(run, tmp_path, surface, depth):
    make_normals(run, "--depth", 8 * np.dtype(depth).itemsize)
    assert only(run, "n.png", "-o", "fits.png")["warnings"] == []
    m = np.iinfo(depth).max
    rng = np.random.default_rng(5)
    for spread, poor in ((0.025, False), (0.3, True)):
        n = rng.normal(0.5, spread / 2, (64, 64, 3)).clip(0.1, 0.9)
        n[..., 2] = 0.95
        write_png(tmp_path / "n.png", (n * m).astype(depth))
        file = only(run, "n.png", "-o", "x.png", "--y", "up", "--type", "standard")
        level = 1 if depth is np.uint8 else 257
        assert (file["residual_levels"] > 8 * level) == poor, file["residual_levels"]
        assert len(file["warnings"]) == poor
        line = run("to-height", "n.png", "-o", "x.png", "--y", "up", "--type", "standard")
        assert line.returncode == 0
        assert (f"warning: {''.join(file['warnings'])}" in line.stdout) == poor
        quiet = run("to-height", "n.png", "-o", "x.png", "--y", "up", "--type", "standard", "-q")
        assert quiet.stdout == "" and ("n.png: warning: " in quiet.stderr) == poor
