# SPDX-License-Identifier: MIT
"""The findings that only a glTF file can have; their ids follow those of the program."""

from .._ntp import Rule

_TABLE = [
    Rule(
        "NT060",
        "warning or error",
        "normals and something else from one image",
        "The image is also used as a color texture, which is decoded from sRGB. One of the two uses is "
        "wrong: an error. If the other use is another kind of data, it is a warning.",
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
        "The material has a normals texture. A mesh that uses it has no TEXCOORD of that number.",
        "Export with texture coordinates, or take the texture out of the material.",
    ),
    Rule(
        "NT063",
        "warning",
        "the media type contradicts the content",
        "mimeType or the data URI names a format that the bytes do not have. Some loaders refuse such "
        "a file.",
        "Correct mimeType.",
    ),
    Rule(
        "NT064",
        "info",
        "an image format that is not read",
        "Its pixels were not checked: they need an extra of the package, normaltexture[basisu] for ETC1S "
        "and UASTC or normaltexture[images] for WebP and AVIF, or are of a format that nothing reads "
        "here, such as ASTC. What its header says was checked.",
        "Install the extra that the message names, or check the source that it was compressed from.",
    ),
    Rule(
        "NT065",
        "warning or error",
        "z is not stored as glTF reads it",
        "glTF reads x, y and z from red, green and blue, each as 2c - 1. This image stores z in 0..1, or "
        "not at all: packed normals (BC5, and the layouts RRRG and RG of KTX2) are no part of glTF 2.0, "
        "and KHR_texture_basisu asks for RGB. It is an error if an error follows from reading it so.",
        "`ntp gltf -o` computes blue anew; so do `ntp convert --type zzero --to standard` and, without z, "
        "`ntp convert --type xy --to standard`.",
    ),
    Rule(
        "NT066",
        "warning",
        "an alpha channel",
        "glTF says that normals textures should not have one. Nothing reads it.",
        "`ntp gltf -o` drops it where it is opaque everywhere; `ntp convert --channels xyz` always.",
    ),
    Rule(
        "NT067",
        "info",
        "mirrored or turned by KHR_texture_transform",
        "The normals in the image are not turned with it. What looks right in the image may be lit "
        "from another side on the model.",
        "Look at the model under a moving light.",
    ),
    Rule(
        "NT068",
        "warning or error",
        "an image that readers may not show",
        "A texture names it by an extension that the file does not declare, or declares without "
        "requiring it though there is no other image; or the format is not the one that the extension, or "
        "plain `source`, may name. It is an error if no other image is there.",
        "List the extension in extensionsUsed and, without a fallback, in extensionsRequired.",
    ),
    Rule(
        "NT069",
        "warning or error",
        "a KTX2 that KHR_texture_basisu does not allow",
        "It is not of ETC1S or UASTC, no 2D texture, turned or swizzled by its metadata, of sides that are "
        "no multiples of 4, or its descriptor is one of colors.",
        "Compress the source anew, as UASTC, linear, without swizzle.",
    ),
]
RULES = {rule.id: rule for rule in _TABLE}
