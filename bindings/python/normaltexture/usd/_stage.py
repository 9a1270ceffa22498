# SPDX-License-Identifier: MIT
"""Which textures of a USD stage hold normals, and how the shaders read them.

UsdPreviewSurface has inputs:normal, fed by a UsdUVTexture with scale and bias.  MaterialX has the
nodes ND_normalmap, whose input `in` is fed by an image node; they read 0..1 as -1..1 themselves.
Connections through node graphs are followed, and those through other nodes noted.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ._pxr import Usd, UsdShade

_MAX_DEPTH = 16  # nodes between a normals input and its texture
_IMAGE_NODES = (
    "ND_image_",
    "ND_tiledimage_",
    "ND_gltf_image_",
    "ND_hextiledimage_",
    "ND_gltf_normalmap",
)
_UNIT = (1.0, 1.0, 1.0, 1.0)
_ZERO = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Reading:
    """A shader that reads an image for a normals input.

    ``scale`` and ``bias`` turn a stored number into a component: those of a UsdUVTexture, or 2 and
    -1 times the strength of a MaterialX normalmap.  ``color_space`` is "" where nothing is
    authored.  ``direct``: no other node stands in between.
    """

    shader: str
    input: str
    node: str
    output: str
    color_space: str
    scale: tuple[float, ...]
    bias: tuple[float, ...]
    direct: bool

    def to_dict(self) -> dict[str, Any]:
        return {
            "shader": self.shader,
            "input": self.input,
            "node": self.node,
            "output": self.output,
            "color_space": self.color_space,
            "scale": list(self.scale),
            "bias": list(self.bias),
            "direct": self.direct,
        }


@dataclass
class NormalsImage:
    """An image: as the layer names it, where it was found, who reads normals or else from it."""

    asset: str
    resolved: str
    readings: list[Reading]
    others: list[tuple[str, str]]  # (shader, color space)


def _identifier(shader: Any) -> str:
    return str(shader.GetIdAttr().Get() or "") if shader else ""


def _is_preview_texture(name: str) -> bool:
    return name == "UsdUVTexture" or name.startswith("ND_UsdUVTexture")


def _is_image(name: str) -> bool:
    return _is_preview_texture(name) or name.startswith(_IMAGE_NODES)


def _value(shader: Any, name: str, otherwise: Any) -> Any:
    """The value of an input, also of one that a material's interface gives."""
    source = shader.GetInput(name)
    if not source:
        return otherwise
    for attribute in UsdShade.Utils.GetValueProducingAttributes(source):
        if UsdShade.Utils.GetType(attribute.GetName()) == UsdShade.AttributeType.Input:
            value = attribute.Get(Usd.TimeCode.EarliestTime())
            return otherwise if value is None else value
    return otherwise


def _four(value: Any, last: float) -> tuple[float, ...]:
    """A value of one to four components as four finite numbers."""
    numbers = [float(v) for v in value] if hasattr(value, "__len__") else [float(value)] * 3
    numbers = [*numbers, *[last] * 4][:4]
    return tuple(number if math.isfinite(number) else 0.0 for number in numbers)


def _assets(shader: Any) -> Iterator[tuple[str, str]]:
    """(path as authored, where it was found or "") of a texture, each tile of a UDIM."""
    source = shader.GetInput("file")
    if not source:
        return
    for attribute in UsdShade.Utils.GetValueProducingAttributes(source):
        times = attribute.GetTimeSamples() or [Usd.TimeCode.Default()]
        for path in dict.fromkeys(attribute.Get(time) for time in times):
            if path is None or not path.path:
                continue
            stack = attribute.GetPropertyStack(Usd.TimeCode.Default())
            if UsdShade.UdimUtils.IsUdimIdentifier(path.path) and stack:
                found = UsdShade.UdimUtils.ResolveUdimTilePaths(path.path, stack[0].layer)
                for tile, number in found:
                    yield path.path.replace("<UDIM>", number), str(tile)
                if found:
                    continue
            yield path.path, path.resolvedPath


def _color_space(shader: Any, node: str) -> str:
    if _is_preview_texture(node):
        return str(_value(shader, "sourceColorSpace", "") or "")
    source = shader.GetInput("file")
    attribute = source.GetAttr() if source else None
    return str(attribute.GetColorSpace() or "") if attribute else ""


def _textures(
    source: Any, depth: int = 0, seen: frozenset[str] = frozenset()
) -> Iterator[tuple[Any, str, bool]]:
    """(texture shader, its output, no node between) that feed an input."""
    for attribute in UsdShade.Utils.GetValueProducingAttributes(source, True):
        shader = UsdShade.Shader(attribute.GetPrim())
        place = str(attribute.GetPath())
        node = _identifier(shader)
        if _is_image(node):
            yield shader, UsdShade.Utils.GetBaseNameAndType(attribute.GetName())[0], depth == 0
        elif shader and depth < _MAX_DEPTH and place not in seen:
            for further in shader.GetInputs():
                if further.HasConnectedSource():
                    yield from _textures(further, depth + 1, seen | {place})


def _normals_inputs(shader: Any, node: str) -> Iterator[tuple[Any, tuple[float, ...] | None]]:
    """(input that takes normals, the strength of a MaterialX node or None)."""
    if node == "UsdPreviewSurface" or node.startswith("ND_UsdPreviewSurface"):
        source = shader.GetInput("normal")
        if source and source.HasConnectedSource():
            yield source, None
    elif node.startswith("ND_normalmap"):
        source = shader.GetInput("in")
        if source and source.HasConnectedSource():
            strength = _value(shader, "scale", 1.0)
            both = [float(v) for v in strength] if hasattr(strength, "__len__") else [strength] * 2
            yield source, (float(both[0]), float(both[1]))


def _reading(
    texture: Any, output: str, direct: bool, target: str, strength: tuple[float, ...] | None
) -> Reading:
    node = _identifier(texture)
    scale: tuple[float, ...] = (2.0, 2.0, 2.0, 1.0)
    bias: tuple[float, ...] = (-1.0, -1.0, -1.0, 0.0)
    if _is_preview_texture(node):
        scale = _four(_value(texture, "scale", _UNIT), 1.0)
        bias = _four(_value(texture, "bias", _ZERO), 0.0)
    if strength is not None:
        if _is_preview_texture(node):  # normalmap decodes what the texture has scaled
            scale = tuple(2 * v for v in scale)
            bias = tuple(2 * v - 1 for v in bias)
        x, y = strength
        scale = (x * scale[0], y * scale[1], *scale[2:])
        bias = (x * bias[0], y * bias[1], *bias[2:])
    space = _color_space(texture, node)
    return Reading(str(texture.GetPath()), target, node, output, space, scale, bias, direct)


def _readings(shader: Any, node: str) -> Iterator[tuple[Any, Reading]]:
    """The textures that a shader takes normals from, and how."""
    if node.startswith("ND_gltf_normalmap"):  # reads and decodes an image by itself
        strength = float(_value(shader, "scale", 1.0))
        place = str(shader.GetPath())
        yield shader, _reading(shader, "rgb", True, place, (strength, strength))
    for source, strengths in _normals_inputs(shader, node):
        target = str(source.GetAttr().GetPath())
        for texture, output, direct in _textures(source):
            yield texture, _reading(texture, output, direct, target, strengths)


def normals_images(stage: Any) -> list[NormalsImage]:
    """The images that hold normals, in the order in which they are met."""
    found: dict[str, NormalsImage] = {}
    shaders = []
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdShade.Shader):
            continue
        shader = UsdShade.Shader(prim)
        node = _identifier(shader)
        shaders.append((shader, node))
        for texture, reading in _readings(shader, node):
            for asset, resolved in _assets(texture):
                image = found.setdefault(resolved or asset, NormalsImage(asset, resolved, [], []))
                if reading not in image.readings:
                    image.readings.append(reading)
    readers = {reading.shader for image in found.values() for reading in image.readings}
    for shader, node in shaders:
        if _is_image(node) and str(shader.GetPath()) not in readers:
            for asset, resolved in _assets(shader):
                if (resolved or asset) in found:
                    other = (str(shader.GetPath()), _color_space(shader, node))
                    found[resolved or asset].others.append(other)
    return list(found.values())
