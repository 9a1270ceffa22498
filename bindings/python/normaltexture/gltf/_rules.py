# SPDX-License-Identifier: MIT
"""The findings that only a glTF file can have; their ids follow those of the program."""

from .._ntp import Rule

_TABLE = [
    Rule(
        "NT060",
        "warning or error",
        "normals and something else from one image",
        "The image is also a color texture, which is decoded from sRGB, so that one of the two is "
        "wrong: an error. Shared with another kind of data it is a warning.",
        "Give the normals an image of their own.",
    ),
    Rule(
        "NT061",
        "warning",
        "odd normalTexture.scale",
        "A scale of 0 switches the texture off; a negative one turns bumps into dents.",
        "Remove the scale, or make it positive. If green or red is inverted, convert the texture.",
    ),
    Rule(
        "NT062",
        "warning",
        "a mesh without the texture coordinates that the normals need",
        "The material has a normals texture, but a mesh that uses it has no TEXCOORD of that number.",
        "Export with texture coordinates, or take the texture out of the material.",
    ),
    Rule(
        "NT063",
        "warning",
        "the media type contradicts the content",
        "mimeType, or that of the data URI, says another format than the bytes are. Some loaders "
        "refuse such a file.",
        "Correct mimeType.",
    ),
    Rule(
        "NT064",
        "info",
        "an image format that is not read",
        "The image is KTX2 (KHR_texture_basisu), or needs the extra normaltexture[images]. It was "
        "not checked.",
        "Check the source that it was compressed from.",
    ),
    Rule(
        "NT065",
        "error",
        "no standard normals texture",
        "glTF reads x, y and z from red, green and blue, each as 2c - 1. This image stores z in "
        "another way, or not at all.",
        "`ntp convert --to standard`.",
    ),
    Rule(
        "NT066",
        "warning",
        "an alpha channel",
        "glTF says that normal textures should not have one: nothing reads it.",
        "`ntp gltf -o` drops it where it is opaque everywhere; `ntp convert --channels xyz` always.",
    ),
    Rule(
        "NT067",
        "info",
        "mirrored or turned by KHR_texture_transform",
        "The normals in the image are not turned with it, so what looks right in the image may be "
        "lit from another side on the model.",
        "Look at the model under a moving light.",
    ),
]
RULES = {rule.id: rule for rule in _TABLE}
