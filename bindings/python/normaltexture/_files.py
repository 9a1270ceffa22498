# SPDX-License-Identifier: MIT
"""Image files: PNG, TGA, PFM, WebP, DDS, KTX2, and to read JPEG and EXR, sample for sample.

Numbers are kept as stored: no color management, no gamma, no premultiplication.  16-bit RGB and
RGBA PNG are exact both ways.
"""

import os
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from ._arrays import pixels
from ._errors import ArgumentError, FileError, FileStatus, Status
from ._measure import _Result
from ._names import FILE_FORMATS, names_of
from ._native import ffi, lib
from ._texture_file import ENDINGS as _TEXTURE_ENDINGS
from ._texture_file import texture_output
from .typing import AnyPixels, AutoType, BlockQuality, Compression

File: TypeAlias = str | os.PathLike[str] | bytes | bytearray | memoryview
Format: TypeAlias = Literal["png", "tga", "jpeg", "pfm", "dds", "ktx2", "webp", "exr"]

_FORMAT_NAMES: Any = names_of(FILE_FORMATS)
_SAMPLES: dict[int, Any] = {1: np.uint8, 2: np.uint16, 4: np.float32}
_ENDINGS = {f".{name}": FILE_FORMATS[name] for name in ("png", "tga", "pfm", "webp")}
_ENDINGS |= _TEXTURE_ENDINGS


@dataclass(frozen=True)
class ImageInfo(_Result):
    """What a file says about its image.

    Attributes
    ----------
    format : {"png", "tga", "jpeg", "pfm", "dds", "ktx2", "webp", "exr"}
    width, height : int
    channels : int
        Of the array that `read` returns: 1 gray, 2 gray and alpha, 3 RGB, 4 RGBA; or 2 red and
        green, where `red_green` says so.
    bit_depth : int
        Of a sample in the file: 1, 2, 4, 5, 8, 16 or 32.
    interlaced, palette, lossy, alpha : bool
        Properties of the file; `alpha`: it has an alpha channel or transparency.
    color_chunks : tuple of str
        "gAMA", "sRGB", "iCCP", "cHRM", "cICP": color information of a PNG, which is not applied.
    texts : dict
        The texts of a PNG by their keys.
    jpeg_quality : int
        Estimated, 1..100; 0: unknown, or not a JPEG.
    jpeg_subsampled : bool
        Of a JPEG or a WebP: the colors have fewer samples than the brightness, such as 4:2:0.
    red_green : bool
        The file has two channels, and they are red and green, as in BC5.
    vectors : bool
        An EXR with channels X, Y, Z: its numbers are -1..1, for ``type="vector"``.
    layout : str
        Of a DDS or KTX2, such as "BC5" or "R8G8B8A8"; else "".
    mips, layers : int
        Of a DDS or KTX2: smaller copies, the first included; textures of an array, or faces of
        cubes.  Else 0.
    """

    format: Format
    width: int
    height: int
    channels: int
    bit_depth: int
    interlaced: bool
    palette: bool
    lossy: bool
    alpha: bool
    color_chunks: tuple[str, ...]
    texts: dict[str, str]
    jpeg_quality: int
    jpeg_subsampled: bool
    red_green: bool
    vectors: bool
    layout: str
    mips: int
    layers: int


def _raise(error: Any) -> None:
    message = ffi.string(error.message).decode("utf-8", "replace")
    raise FileError(message, FileStatus(error.status))


def _info(info: Any) -> ImageInfo:
    chunks = {"gAMA": info.has_gama, "sRGB": info.has_srgb}
    chunks |= {"iCCP": info.has_iccp, "cHRM": info.has_chrm, "cICP": info.has_cicp}
    texts: dict[str, str] = {}
    for i in range(info.text_count):
        text = info.texts[i]
        coding = "utf-8" if text.itxt else "latin-1"
        key = ffi.string(text.key).decode("latin-1")
        texts[key] = ffi.string(text.value).decode(coding, "replace")
    return ImageInfo(
        format=_FORMAT_NAMES[info.format],
        width=info.width,
        height=info.height,
        channels=info.channels,
        bit_depth=info.bit_depth,
        interlaced=info.interlaced,
        palette=info.palette,
        lossy=info.lossy,
        alpha=info.alpha,
        color_chunks=tuple(name for name, has in chunks.items() if has),
        texts=texts,
        jpeg_quality=info.jpeg_quality,
        jpeg_subsampled=info.jpeg_subsampled,
        red_green=info.red_green,
        vectors=info.vectors,
        layout=ffi.string(info.layout).decode(),
        mips=info.mips,
        layers=info.layers,
    )


def _open(file: Any, limits: Any, error: Any) -> tuple[Any, Any]:
    """A reader, and what must outlive it."""
    if isinstance(file, (bytes, bytearray, memoryview)):
        held = ffi.from_buffer(file)
        return lib.ntpio_open_memory(held, len(held), b"<bytes>", limits, error), held
    os.stat(file)  # missing, or no permission: the builtin exception
    return lib.ntpio_open(os.fsencode(file), limits, error), None


def _limits(mip: int, layer: int | None, max_side: int = 0, max_texels: int = 0) -> Any:
    for name, value in (("mip", mip), ("layer", layer or 0)):
        if not 0 <= value <= 12287:
            raise ArgumentError(f"{name}={value!r}: must be within 0..12287")
    limits = ffi.new("ntpio_limits *", (max_side, max_texels, 0))
    limits.one_pass = True
    limits.mip, limits.layer_and_one = mip, 0 if layer is None else layer + 1
    return limits


def read(
    file: File,
    *,
    mip: int = 0,
    layer: int | None = None,
    max_side: int = 65535,
    max_texels: int = 1 << 30,
) -> AnyPixels:
    """Read a PNG, TGA, JPEG, PFM, WebP, EXR, DDS or KTX2.

    Parameters
    ----------
    file : path, or bytes
        A file, or the content of one.
    mip : int
        Of a DDS or KTX2: 0 is the largest, each next one is half as large.
    layer : int, optional
        Of a DDS or KTX2 that is an array or a cube map: the texture to read, from 0; six faces a
        cube.  Without it such files are refused.
    max_side, max_texels : int
        Refuse images larger than this before anything is allocated.

    Returns
    -------
    array
        (height, width) for gray images, else (height, width, 2 to 4); uint8, uint16 or, for PFM
        and EXR, float32.  Samples of less than 8 bits are scaled to 8, palettes become RGB.  BC5 is
        (height, width, 2), red and green of 16 bits as GPUs interpolate them: ``type="xy"``.

    Raises
    ------
    FileError
        For a file that is not an image, damaged, or too large; `status` says which.
    FileNotFoundError, PermissionError
        As from `open`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> texture = nt.read("wall_n.png")
    >>> texture.shape, texture.dtype
    ((64, 96, 3), dtype('uint8'))
    """
    return read_with_info(file, mip=mip, layer=layer, max_side=max_side, max_texels=max_texels)[0]


def read_with_info(
    file: File,
    *,
    mip: int = 0,
    layer: int | None = None,
    max_side: int = 65535,
    max_texels: int = 1 << 30,
) -> tuple[AnyPixels, ImageInfo]:
    """Read a PNG, TGA, JPEG, PFM, WebP, EXR, DDS or KTX2, and what the file says about its image.

    Parameters
    ----------
    file, mip, layer, max_side, max_texels
        As in `read`.

    Returns
    -------
    (array, ImageInfo)

    Raises
    ------
    FileError, FileNotFoundError, PermissionError
        As `read`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> texture, info = nt.read_with_info("wall_n.png")
    >>> info.format, info.bit_depth
    ('png', 8)
    """
    error = ffi.new("ntpio_error *")
    limits = _limits(mip, layer, max_side, max_texels)
    reader, held = _open(file, limits, error)
    if reader == ffi.NULL:
        _raise(error)
    try:
        info = lib.ntpio_reader_info(reader)
        shape: tuple[int, ...] = (info.height, info.width, info.channels)
        shape = shape[:2] if info.channels == 1 else shape
        image: AnyPixels = np.empty(shape, _SAMPLES[info.sample_bytes])
        where = ffi.cast("void *", image.__array_interface__["data"][0])
        if not lib.ntpio_read_rows(reader, where, image.strides[0], info.height, error):
            _raise(error)
        if not lib.ntpio_read_end(reader, error):
            _raise(error)
        return image, _info(info)
    finally:
        lib.ntpio_close(reader)
        del held


def read_info(file: File, *, mip: int = 0, layer: int | None = None) -> ImageInfo:
    """Read what a file says about its image, without its pixels.

    Parameters
    ----------
    file : path, or bytes
    mip, layer
        As in `read`.

    Returns
    -------
    ImageInfo
        Texts that follow the pixels of a PNG are missing; `read_with_info` finds them.

    Raises
    ------
    FileError, FileNotFoundError, PermissionError
        As `read`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.read_info("wall_n.png").bit_depth
    8
    """
    error = ffi.new("ntpio_error *")
    reader, held = _open(file, _limits(mip, layer), error)
    if reader == ffi.NULL:
        _raise(error)
    try:
        return _info(lib.ntpio_reader_info(reader))
    finally:
        lib.ntpio_close(reader)
        del held


def _texts(texts: dict[str, str] | None, alive: list[Any]) -> Any:
    """The dict as C structs; what they point at joins `alive`."""
    if not texts:
        return ffi.NULL
    array = ffi.new("ntpio_text[]", len(texts))
    for i, (key, value) in enumerate(texts.items()):
        try:
            held = ffi.new("char[]", key.encode("latin-1")), ffi.new("char[]", value.encode())
        except UnicodeEncodeError:
            raise ArgumentError(f"texts: the key {key!r} is not Latin-1") from None
        if not 1 <= len(key) <= 79:
            raise ArgumentError(f"texts: the key {key!r} must have 1..79 characters")
        empty = ffi.new("char[]", b"")
        alive += [*held, empty]
        array[i].key, array[i].value = held
        array[i].language = array[i].translated_key = empty
        array[i].itxt = True
    alive.append(array)
    return array


def write(
    path: str | os.PathLike[str],
    image: AnyPixels,
    *,
    level: int | None = None,
    texts: dict[str, str] | None = None,
    compression: Compression = "blocks",
    quality: BlockQuality = "angle",
    mips: bool = False,
    type: AutoType = "auto",
    threads: int = 1,
) -> None:
    """Write a PNG, TGA, PFM, WebP, DDS or KTX2; the ending of the name says which.

    An older file of that name is replaced only when the new one is complete.

    Parameters
    ----------
    path : path
        A name that ends in .png, .tga, .pfm, .webp, .dds or .ktx2.
    image : array, (height, width) or (height, width, channels)
        uint8 or, in a PNG, DDS or KTX2, uint16; float32 in a PFM (1 or 3 channels).  WebP is written without
        loss, and takes 3 or 4 channels; an alpha of only 255 is not stored in it.  Strided arrays are written
        row by row, without a copy where a row has no gaps.
    level : int, optional
        of a PNG or WebP: 1 is fastest, 12 smallest and slow; default: 6, in a PNG smaller than
        libpng's.
    texts : dict, optional
        Texts of a PNG by their keys.
    compression : {"blocks", "none"}
        Of a DDS or KTX2.  "blocks": BC5, which keeps x and y in red and green, or BC4 of one channel;
        "none": 1, 2 or 4 channels, RGB with an opaque alpha.
    quality : {"angle", "channel", "quick"}
        Of these blocks, as in `encode_bc5`.
    mips : bool
        Of a DDS or KTX2: all smaller copies down to 1 x 1 too, as `mip_chain` makes them.
    type : {"auto", "standard", "zzero", "xy"}
        How a normal is stored; only mips depend on it.  "auto" detects it from the texels; two
        channels are "xy".
    threads : int
        How many threads share the mips and blocks; 0: one for each processor.  The bytes are the
        same.

    Raises
    ------
    FileError
        For what the format cannot hold, or cannot be written; `status` says which.
    ArgumentError, SampleTypeError
        For other arrays and names.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> deep = np.full((2, 3, 3), (32768, 32768, 65535), np.uint16)
    >>> nt.write("deep.png", deep)
    >>> np.array_equal(nt.read("deep.png"), deep)
    True
    """
    array = pixels("image", image)
    name = os.fspath(path)
    ending = os.path.splitext(os.fsdecode(name))[1].lower()
    if ending not in _ENDINGS:
        raise ArgumentError(
            f"path={name!r}: the name must end in .png, .tga, .pfm, .webp, .dds or .ktx2"
        )
    if level is not None and not 1 <= level <= 12:
        raise ArgumentError(f"level={level!r}: must be within 1..12")
    channels = array.shape[2] if array.ndim == 3 else 1
    if not array.size or channels > 4:
        raise ArgumentError(
            f"image: 1 to 4 channels are needed, the shape is {array.shape}", Status.SHAPE
        )
    if array.strides[1] != channels * array.itemsize and array.shape[1] > 1:
        array = np.ascontiguousarray(array)
    texture = texture_output(
        path,
        ending,
        image=array,
        compression=compression,
        quality=quality,
        mips=mips,
        type=type,
        threads=threads,
    )
    alive: list[Any] = []
    options = ffi.new("ntpio_write_options *")
    options.texture = ffi.NULL if texture is None else texture.how
    options.format = _ENDINGS[ending]
    options.width, options.height, options.channels = array.shape[1], array.shape[0], channels
    options.sample_bytes = array.itemsize
    options.level = -1 if level is None else level
    options.texts = _texts(texts, alive)
    options.text_count = len(texts or {})
    error = ffi.new("ntpio_error *")
    writer = lib.ntpio_create(os.fsencode(name), options, error)
    if writer == ffi.NULL:
        _raise(error)
    where = ffi.cast("void *", array.__array_interface__["data"][0])
    if not lib.ntpio_write_rows(writer, where, array.strides[0], array.shape[0], error):
        lib.ntpio_abort(writer)
        _raise(error)
    if not lib.ntpio_commit(writer, error):
        if texture is not None and texture.raised is not None:
            raise texture.raised
        _raise(error)
