# SPDX-License-Identifier: MIT
"""How a typed program uses the package; mypy and pyright read it, nobody runs it.

The last part holds what must be an error: an ignore that nothing needs is one itself.
"""

from typing import Any, Literal, assert_type

import numpy as np
from numpy.typing import NDArray

import normaltexture as nt
from normaltexture.typing import AnyPixels, Depth, LikeSettings, MeasuredType, Type

U8 = NDArray[np.uint8]
U16 = NDArray[np.uint16]
F32 = NDArray[np.float32]


def use_images(image: AnyPixels, bytes_: U8, words: U16, floats: F32, some: NDArray[Any]) -> None:
    assert_type(nt.read("wall_n.png"), AnyPixels)
    assert_type(nt.read_with_info("wall_n.png"), tuple[AnyPixels, nt.ImageInfo])
    assert_type(nt.clean(bytes_), U8)
    assert_type(nt.clean(words, type="xy", method="auto"), U16)
    assert_type(nt.clean(floats, type="vector"), F32)
    assert_type(nt.clean(image), AnyPixels)
    assert_type(nt.clean(some), NDArray[Any])
    assert_type(nt.clean_with_counts(bytes_), tuple[U8, nt.CleanCounts])
    assert_type(nt.transform(bytes_, flip="x"), U8)
    assert_type(nt.resize(words, size="50%"), U16)
    assert_type(nt.mip_chain(bytes_), list[U8])
    assert_type(nt.blend(bytes_, words), U8)
    assert_type(nt.blend(bytes_, floats, detail_type="vector"), U8)
    assert_type(nt.pack_channels(bytes_, "xyzh", height=words), U8)
    nt.clean(image[2:4], out=image[2:4])
    nt.write("wall_clean_n.png", nt.clean(image))
    nt.write("wall_n.dds", image, compression="blocks", quality="quick", mips=True, type="auto")


def use_depths(
    image: AnyPixels, bytes_: U8, floats: F32, depth: Depth, maybe: Depth | None
) -> None:
    assert_type(nt.convert(bytes_, to="zzero"), U8)
    assert_type(nt.convert(image, depth=8), U8)
    assert_type(nt.convert(bytes_, depth=16), U16)
    assert_type(nt.convert(bytes_, depth="float"), F32)
    assert_type(nt.convert(bytes_, to="vector"), F32)
    assert_type(nt.convert(floats, type="vector", depth=8), U8)
    assert_type(nt.convert(image, depth=depth), U8 | U16 | F32)
    assert_type(nt.convert(bytes_, depth=maybe), U8 | U16 | F32)
    assert_type(nt.convert_with_counts(bytes_, depth=16), tuple[U16, nt.ConvertCounts])
    assert_type(nt.decode(image), F32)
    assert_type(nt.encode(nt.decode(image)), U8)
    assert_type(nt.encode(floats, depth=16, to="zzero"), U16)
    assert_type(nt.encode(floats, depth=depth), U8 | U16 | F32)


def use_heights(image: AnyPixels, bytes_: U8, floats: F32, flag: bool) -> None:
    assert_type(nt.normals_from_height(bytes_, 8), U8)
    assert_type(nt.normals_from_height(floats, 8), U16)
    assert_type(nt.normals_from_height(floats, 8, depth=8), U8)
    assert_type(nt.normals_from_height(image, 8, depth=16, invert=flag), U16)
    assert_type(nt.normals_from_height(bytes_, 8, to="vector"), F32)
    assert_type(nt.like("gegl", 10), LikeSettings)
    assert_type(nt.normals_from_height(bytes_, **nt.like("gegl", 10)), U8)
    assert_type(nt.normals_from_height_with_counts(bytes_, 8), tuple[U8, nt.NormalsCounts])
    assert_type(nt.blur_height(bytes_, 2, octaves=[1, 0.5]), F32)
    assert_type(nt.curvature(bytes_, kind="cavity", depth=8), AnyPixels)
    assert_type(nt.occlusion(floats, radius=8), AnyPixels)
    assert_type(nt.height_from_normals(image, detrend=flag), F32)
    assert_type(nt.height_from_normals(bytes_, mask=bytes_ > 0), F32)
    assert_type(nt.height_from_normals_with_info(image), tuple[F32, nt.HeightInfo])


def use_results(image: AnyPixels, floats: F32, type: Type, flag: bool) -> None:
    assert_type(nt.validate(image), U8)
    assert_type(nt.heatmap(image, touch_unused=flag), U8)
    assert_type(nt.heatmap(floats, type=type), U8)
    assert_type(nt.clean(floats, type=type, only_failing=flag, keep_negative_z=flag), F32)
    assert_type(nt.measure(image).to_dict(), dict[str, Any])
    assert_type(nt.measure(image, type="height").type, MeasuredType)
    assert_type(nt.classify(image).confidence, float)
    assert_type(nt.detect_orientation(image).y, Literal["up", "down", "undecided"])
    assert_type(nt.compare(image, floats, type=("auto", "vector"), y=("up", "down")).texels, int)


def use_rows(image: AnyPixels) -> None:
    def read_normals(y: int, count: int) -> AnyPixels:
        return image[y : y + count]

    def write_heights(y: int, rows: F32) -> None:
        print(y, rows.max())

    def read_heights(y: int, count: int) -> F32:
        return np.zeros((count, image.shape[1]), np.float32)

    info = nt.height_from_rows(read_normals, write_heights, read_heights, shape=(64, 96, 3))
    assert_type(info, nt.HeightInfo)
    functions = read_normals, write_heights, read_heights
    nt.height_from_rows(*functions, shape=(64, 96, 3), type="vector", depth="float")
    nt.height_from_rows(*functions, shape=(64, 96, 3), type="vector", depth=8)  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]


def use_doubles(doubles: NDArray[np.float64]) -> None:
    # Vectors and heights: rounded once.
    assert_type(nt.clean(doubles, type="vector"), F32)
    assert_type(nt.encode(doubles), U8)
    _ = nt.normals_from_height(doubles, 8)
    _ = nt.measure(doubles, type="vector")


def use_wrongly(image: AnyPixels, bytes_: U8, floats: F32, doubles: NDArray[np.float64]) -> None:
    # Results have the fields that they have.
    _ = nt.measure(image).pixels  # type: ignore[attr-defined]  # pyright: ignore[reportAttributeAccessIssue]
    # Strings that the command line does not know.
    nt.clean(bytes_, method="newest")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType]
    nt.heatmap(bytes_, palette="pink")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType]
    nt.resize(bytes_, size=(64, 64), border="extrapolate")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType]
    nt.normals_from_height(bytes_, 8, kernel="baked")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    # Vectors are floats.
    nt.clean(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.validate(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.measure(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.choose_method(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.detect_orientation(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.find_kernel(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.find_seams(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.find_steps(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.inspect(bytes_, 0, 0, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.compare(bytes_, floats, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.compare(bytes_, floats, type=("vector", "auto"))  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.mip_chain(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.heatmap(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.shade(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.transform(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.resize(bytes_, size="50%", type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.blend(bytes_, bytes_, detail_type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.decode(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.convert(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.convert(bytes_, to="vector", depth=8)  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.height_from_normals(bytes_, type="vector")  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.encode(bytes_)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    # Samples of other types, and what is no array.
    nt.clean(doubles)  # type: ignore[type-var]  # pyright: ignore[reportArgumentType]
    nt.measure(doubles)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    nt.clean([[[128, 128, 255]]])  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType]
    # `out` is of the samples of the result.
    nt.convert(bytes_, depth=16, out=bytes_)  # type: ignore[call-overload]  # pyright: ignore[reportArgumentType, reportCallIssue]
    nt.height_from_normals(bytes_, out=bytes_)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    # There is no default scale.
    nt.normals_from_height(bytes_)  # type: ignore[call-overload]  # pyright: ignore[reportCallIssue]
