# SPDX-License-Identifier: MIT
"""How a typed program uses the package; mypy and pyright read it, nobody runs it."""

from typing import Any, Literal, assert_type

import numpy as np
from numpy.typing import NDArray

import normaltexture as nt

Type = Literal["standard", "zzero", "xy", "vector", "height"]
Pixels = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]

texture = nt.read("wall_n.png")
assert_type(texture, Pixels)
assert_type(nt.read("wall_n.png", return_info=True), tuple[Pixels, nt.ImageInfo])
assert_type(nt.clean(texture), Pixels)
assert_type(nt.clean(texture, return_counts=True), tuple[Pixels, nt.CleanCounts])
assert_type(nt.convert(texture, to="zzero", depth=16), Pixels)
assert_type(nt.decode(texture), NDArray[np.float32])
assert_type(nt.encode(nt.decode(texture)), Pixels)
assert_type(nt.validate(texture), NDArray[np.uint8])
assert_type(nt.measure(texture).to_dict(), dict[str, Any])
assert_type(nt.classify(texture).confidence, float)
assert_type(nt.heatmap(texture), NDArray[np.uint8])
assert_type(nt.mip_chain(texture), list[Pixels])
assert_type(nt.height_from_normals(texture), NDArray[np.float32])
assert_type(
    nt.height_from_normals(texture, return_info=True), tuple[NDArray[np.float32], nt.HeightInfo]
)


def read_normals(y: int, count: int) -> Pixels:
    return texture[y : y + count]


def write_heights(y: int, rows: NDArray[np.float32]) -> None:
    print(y, rows.max())


def read_heights(y: int, count: int) -> NDArray[np.float32]:
    return np.zeros((count, texture.shape[1]), np.float32)


assert_type(
    nt.height_from_rows(read_normals, write_heights, read_heights, shape=(64, 96, 3)),
    nt.HeightInfo,
)
assert_type(nt.measure(texture, type="height").type, Type)

# Strings that the command line does not know are errors already here.
print(nt.measure(texture).pixels)  # type: ignore[attr-defined]  # pyright: ignore
nt.clean(texture, method="newest")  # type: ignore[call-overload]  # pyright: ignore
nt.heatmap(texture, palette="pink")  # type: ignore[arg-type]  # pyright: ignore
nt.resize(texture, size=(64, 64), border="extrapolate")  # type: ignore[arg-type]  # pyright: ignore
