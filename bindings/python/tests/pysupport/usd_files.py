# SPDX-License-Identifier: MIT
"""USD scenes for tests, made with usd-core: a material whose normals come from a texture."""

from pathlib import Path

from pxr import Sdf, Usd, UsdShade

TYPES = Sdf.ValueTypeNames
SCALE, BIAS = (2, 2, 2, 1), (-1, -1, -1, 0)


def _shader(stage, path, node, **inputs):
    """A shader; inputs by name: (type, value)."""
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(node)
    for name, (kind, value) in inputs.items():
        shader.CreateInput(name, kind).Set(value)
    return shader


def texture(stage, path, file, space="raw", scale=SCALE, bias=BIAS):
    """A UsdUVTexture; None leaves an input out."""
    inputs = {"file": (TYPES.Asset, file)}
    if space is not None:
        inputs["sourceColorSpace"] = (TYPES.Token, space)
    if scale is not None:
        inputs["scale"] = (TYPES.Float4, scale)
    if bias is not None:
        inputs["bias"] = (TYPES.Float4, bias)
    return _shader(stage, path, "UsdUVTexture", **inputs)


def surface(stage, path="/M"):
    """A material and its UsdPreviewSurface."""
    material = UsdShade.Material.Define(stage, path)
    shader = _shader(stage, f"{path}/Surface", "UsdPreviewSurface")
    output = shader.CreateOutput("surface", TYPES.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    return material, shader


def scene(path, file, output="rgb", color=None, **more):
    """A scene with one material; `color` also reads a file, as a color."""
    stage = Usd.Stage.CreateNew(str(path))
    _, shader = surface(stage)
    image = texture(stage, "/M/Normals", file, **more)
    kind = TYPES.Float3 if output == "rgb" else TYPES.Float
    source = image.CreateOutput(output, kind)
    shader.CreateInput("normal", TYPES.Normal3f).ConnectToSource(source)
    if color is not None:
        other = texture(stage, "/M/Color", color, "sRGB", None, None)
        source = other.CreateOutput("rgb", TYPES.Float3)
        shader.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(source)
    stage.Save()
    return Path(path)


def through_graph(path, file):
    """The file is an input of the material, the texture stands in a node graph."""
    stage = Usd.Stage.CreateNew(str(path))
    material, shader = surface(stage)
    named = material.CreateInput("normalMap", TYPES.Asset)
    named.Set(file)
    graph = UsdShade.NodeGraph.Define(stage, "/M/Graph")
    inner = graph.CreateInput("file", TYPES.Asset)
    inner.ConnectToSource(named)
    image = texture(stage, "/M/Graph/Normals", "")
    image.GetInput("file").GetAttr().Clear()
    image.GetInput("file").ConnectToSource(inner)
    given = graph.CreateOutput("normal", TYPES.Float3)
    given.ConnectToSource(image.CreateOutput("rgb", TYPES.Float3))
    shader.CreateInput("normal", TYPES.Normal3f).ConnectToSource(given)
    stage.Save()
    return Path(path)


def materialx(path, file, node="ND_image_vector3", strength=None, between=None, space=None):
    """A normalmap of MaterialX, fed by an image node, perhaps through another node."""
    stage = Usd.Stage.CreateNew(str(path))
    material = UsdShade.Material.Define(stage, "/M")
    image = _shader(stage, "/M/Image", node, file=(TYPES.Asset, file))
    if space is not None:
        image.GetInput("file").GetAttr().SetColorSpace(space)
    if "UsdUVTexture" in node:
        image.CreateInput("sourceColorSpace", TYPES.Token).Set("raw")
        image.CreateInput("scale", TYPES.Float4).Set(SCALE)
        image.CreateInput("bias", TYPES.Float4).Set(BIAS)
    source = image.CreateOutput("out", TYPES.Float3)
    if between is not None:
        middle = _shader(stage, "/M/Between", between)
        middle.CreateInput("in1", TYPES.Float3).ConnectToSource(source)
        source = middle.CreateOutput("out", TYPES.Float3)
    normals = _shader(stage, "/M/NormalMap", "ND_normalmap_float")
    normals.CreateInput("in", TYPES.Float3).ConnectToSource(source)
    if strength is not None:
        normals.CreateInput("scale", TYPES.Float).Set(strength)
    shader = _shader(stage, "/M/Surface", "ND_standard_surface_surfaceshader")
    shader.CreateInput("normal", TYPES.Float3).ConnectToSource(
        normals.CreateOutput("out", TYPES.Float3)
    )
    output = shader.CreateOutput("out", TYPES.Token)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(output)
    stage.Save()
    return Path(path)


def package(path, parts):
    """A .usdz of files by their names in it, the scene first."""
    writer = Sdf.ZipFileWriter.CreateNew(str(path))
    for name, file in parts.items():
        assert writer.AddFile(str(file), name)
    assert writer.Save()
    return Path(path)
