# SPDX-License-Identifier: MIT
"""Normals textures in glTF files: what they are, whether they are well formed, and clean copies.

``check`` reads .gltf and .glb files, finds every image that a material reads normals from
(normalTexture, clearcoatNormalTexture and the like in other extensions) and judges it by the rules
of glTF: standard encoding, green up, blue above one half, no alpha channel.  ``clean`` writes a
copy in which only those images differ.

Source: glTF 2.0 specification, section 3.9.3; KHR_materials_clearcoat.
"""

from ._check import check, check_document
from ._clean import clean
from ._document import Document, GltfError, load
from ._rules import RULES
from ._walk import NormalImage, Use, normal_images

__all__ = [
    "RULES",
    "Document",
    "GltfError",
    "NormalImage",
    "Use",
    "check",
    "check_document",
    "clean",
    "load",
    "normal_images",
]
