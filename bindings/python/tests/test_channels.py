# SPDX-License-Identifier: MIT
"""Layouts of channels: against numpy, and against what the program writes."""

import subprocess

import numpy as np
import pytest

import normaltexture as nt

H, W = 9, 13


def drawn(channels, dtype, seed=1):
    rng = np.random.default_rng(seed)
    return rng.integers(0, np.iinfo(dtype).max, (H, W, channels), dtype, endpoint=True)


def laid_out(full, letters):
    """The channels that letters name, of x, y, z, alpha."""
    one = np.iinfo(full.dtype).max
    planes = {"0": np.zeros((H, W), full.dtype), "1": np.full((H, W), one, full.dtype)}
    planes |= {letter: full[..., i] for i, letter in enumerate("xyza")}
    planes["h"] = planes["a"]
    result = np.stack([planes[letter] for letter in letters], -1)
    return result[..., 0] if len(letters) == 1 else result


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("letters", ["xyz", "1y0x", "xy", "z", "azyx", "xx"])
def test_convert_lays_out(dtype, letters):
    texture = drawn(4, dtype)
    how = {"type": "standard", "to": "zzero", "y": "up", "to_y": "down"}
    full = nt.convert(texture, **how)
    got = nt.convert(texture, **how, channels=letters)
    assert np.array_equal(got, laid_out(full, letters))
    out = np.empty_like(got)
    assert nt.convert(texture, **how, channels=letters, out=out) is out
    assert np.array_equal(out, got)


@pytest.mark.parametrize("letters,plain", [("-y-x", False), ("zyx", True), ("xyz", True),
                                           ("xyza", True), ("ax0y", False)])  # fmt: skip
def test_convert_reads(letters, plain):
    texture = drawn(4, np.uint8)
    at = {letter: texture[..., i] for i, letter in enumerate(letters)}
    planes = [at["x"], at["y"], at.get("z", np.full((H, W), 255, np.uint8))]
    source = np.stack(planes + ([at["a"]] if "a" in at else []), -1)
    want = nt.convert(source, type="zzero" if plain else "xy", depth=16)
    assert np.array_equal(nt.convert(texture, type="zzero", from_channels=letters, depth=16), want)


def test_convert_is_the_program(tmp_path):
    nt.write(tmp_path / "in.png", drawn(4, np.uint8))
    for spec, arguments in [
        (["--type", "standard", "--channels", "1y0x"], {"type": "standard", "channels": "1y0x"}),
        (["--type", "zzero", "--channels", "zx"], {"type": "zzero", "channels": "zx"}),
        (["--from-channels", "-y-x", "--to", "zzero"], {"from_channels": "-y-x", "to": "zzero"}),
        (["--from-channels", "zyx", "--channels", "xzya"],
         {"from_channels": "zyx", "channels": "xzya"}),
    ]:  # fmt: skip
        subprocess.run(
            [nt.program(), "convert", tmp_path / "in.png", "-o", tmp_path / "out.png", *spec],
            check=True, capture_output=True,
        )  # fmt: skip
        got = nt.convert(nt.read(tmp_path / "in.png"), **arguments)
        want = nt.read(tmp_path / "out.png")
        assert np.array_equal(got[..., : want.shape[2]], want), spec


def test_heights_are_packed():
    height, ao, alpha = (drawn(1, np.uint8, seed)[..., 0] for seed in (2, 3, 4))
    full = nt.normals_from_height(height, scale=4.0, alpha="height")
    assert np.array_equal(full[..., 3], height)
    normals = full[..., :3]
    for letters in ("xzyh", "1y0x", "h", "xyz", "xya"):
        want = laid_out(full, letters)
        packed = full if "a" in letters else normals
        got = nt.pack_channels(packed, letters, height=height)
        assert np.array_equal(got, want), letters
        out = np.zeros_like(want)
        assert nt.pack_channels(packed, letters, height=height, out=out) is out
        assert np.array_equal(out, want)
    assert (nt.pack_channels(normals, "a") == 255).all()
    got = nt.pack_channels(normals, "xyza", alpha=alpha)
    assert np.array_equal(got[..., 3], alpha)
    flat = nt.normals_from_height(height, scale=4.0, to="xy")
    labpbr = nt.pack_channels(flat, "xyzh", ao=ao, height=height)
    assert np.array_equal(labpbr[..., 2], ao) and np.array_equal(labpbr[..., 3], height)
    deep = nt.normals_from_height(height, to="xy", depth=16, scale=4.0)
    deep = nt.pack_channels(deep, "xyza", ao=ao, alpha=alpha)
    assert np.array_equal(deep[..., 2], ao.astype(np.uint16) * 257)
    assert np.array_equal(deep[..., 3], alpha.astype(np.uint16) * 257)


def test_heights_are_the_program(tmp_path):
    height, ao, alpha = drawn(1, np.uint16)[..., 0], drawn(1, np.uint8, 3), drawn(3, np.uint8, 4)
    for name, image in (("in", height), ("ao", ao), ("alpha", alpha)):
        nt.write(tmp_path / f"{name}.png", image)
    for spec, to, channels, others in [
        (["--to", "xy", "--ao", tmp_path / "ao.png", "--channels", "xyzh"],
         "xy", "xyzh", {"ao": ao, "height": height}),
        (["--alpha", tmp_path / "alpha.png"], "standard", "xyza", {"alpha": alpha}),
        (["--alpha", tmp_path / "alpha.png", "--channels", "a1zx"],
         "standard", "a1zx", {"alpha": alpha}),
    ]:  # fmt: skip
        subprocess.run(
            [nt.program(), "from-height", tmp_path / "in.png", "-o", tmp_path / "out.png",
             "--scale", "3", *spec],
            check=True, capture_output=True,
        )  # fmt: skip
        normals = nt.normals_from_height(height, scale=3.0, to=to)
        got = nt.pack_channels(normals, channels, **others)
        assert np.array_equal(got, nt.read(tmp_path / "out.png")), spec


def test_wrong_layouts():
    texture, height = drawn(3, np.uint8), drawn(1, np.uint8)[..., 0]
    for letters in ("", "xyzxy", "xh", 5, "X"):
        with pytest.raises(nt.ArgumentError, match="^channels="):
            nt.convert(texture, type="standard", channels=letters)
    for letters in ("x", "xz", "xxy", "xyzaa", "xyq", "-y-x", 7):
        with pytest.raises(nt.ArgumentError, match="^from_channels="):
            nt.convert(texture, from_channels=letters)
    with pytest.raises(nt.ArgumentError, match="^channels=.*height is not given"):
        nt.pack_channels(texture, "xyzh")
    with pytest.raises(nt.ArgumentError, match="^channels=.*src has no z"):
        nt.pack_channels(texture[..., :2], "xyz")
    with pytest.raises(nt.ArgumentError, match="^src: 2 to 4 channels"):
        nt.pack_channels(height, "x")
    for name in ("ao", "alpha", "height"):
        with pytest.raises(nt.ArgumentError, match=f"^{name}: must be of the size"):
            nt.pack_channels(texture, "xyz", **{name: height[1:]})
    with pytest.raises(nt.ArgumentError, match="overlaps src"):
        nt.pack_channels(texture, "xzy", out=texture)
