# SPDX-License-Identifier: MIT
"""The findings that only a USD scene can have; their ids follow those of glTF."""

from .._ntp import Rule

_TABLE = [
    Rule(
        "NT070",
        "warning or error",
        "normals read as colors",
        "sourceColorSpace of the texture is sRGB, or auto, which means sRGB for 8 bits and three channels; "
        "or an image node of MaterialX gives colors, or has the color space of one. Renderers then "
        "convert the numbers to linear light: 128 becomes 55. With 16 bits auto means raw in most "
        "renderers: a warning.",
        "Set inputs:sourceColorSpace to raw; in MaterialX take an image node of vector3 without a color "
        "space.",
    ),
    Rule(
        "NT071",
        "warning or error",
        "scale and bias do not fit what the image stores",
        "A UsdUVTexture gives numbers of 0..1. Normals need a scale of (2, 2, 2, 1) and a bias of (-1, "
        "-1, -1, 0). A strength s is a scale of (2s, 2s, 2, 1) and a bias of (-s, -s, -1, 0). Float "
        "images that hold -1..1 need neither. If the signs of x and y differ from what the image holds, "
        "NT010 says so.",
        "Set inputs:scale and inputs:bias of the texture.",
    ),
    Rule(
        "NT072",
        "info",
        "another strength than 1",
        "Scale and bias, or the scale of the normalmap node, make the slopes steeper or flatter. The "
        "texels are judged as they are stored.",
        "Nothing, if that is meant.",
    ),
    Rule(
        "NT073",
        "error",
        "not all of x, y and z are connected",
        "The normals input reads an output of the texture that is no rgb, or image nodes reach it "
        "through other nodes (a note), whose arithmetic is not followed.",
        "Connect outputs:rgb.",
    ),
]
RULES = {rule.id: rule for rule in _TABLE}
