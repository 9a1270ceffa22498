# SPDX-License-Identifier: MIT
"""The gallery of the website: the code beside each picture makes it."""

import tempfile
from pathlib import Path

import numpy as np

import normaltexture as nt

INTRO = """# Gallery

Each picture was made by the build of this site, by the lines above it; `nt` is the package
`normaltexture`. Normals are shown as they are stored and, beside it, lit from the upper left.
"""

# (title, words, code, {caption: expression})
ENTRIES = [
    (
        "Normals from heights",
        "White is high. A larger scale is steeper.",
        (
            'normals = nt.normals_from_height(height, scale=14, kernel="sobel3")\n'
            'rough = nt.normals_from_height(height, scale=40, kernel="sobel3")'
        ),
        {
            "height": "height",
            "scale 14": "normals",
            "lit": "nt.shade(normals)",
            "scale 40, lit": "nt.shade(rough)",
        },
    ),
    (
        "Kernels",
        "All are equally strong; wider ones are smoother.",
        (
            "fine = nt.normals_from_height(noisy, scale=14)\n"
            'wide = nt.normals_from_height(noisy, scale=14, kernel="gimp9")\n'
            "soft = nt.normals_from_height(nt.blur_height(noisy, 3), scale=14)"
        ),
        {
            "central, lit": "nt.shade(fine)",
            "gimp9, lit": "nt.shade(wide)",
            "central after a blur of 3, lit": "nt.shade(soft)",
        },
    ),
    (
        "Which way is green",
        "The same surface for OpenGL and for DirectX; read the wrong way, bumps are dents.",
        'down = nt.convert(normals, to_y="down")',
        {
            "green up": "normals",
            "green down": "down",
            "green down, lit as such": 'nt.shade(down, y="down")',
            "green down, lit as up": "nt.shade(down)",
        },
    ),
    (
        "Wrong blue, found and repaired",
        "Two patches of blue were painted over. The heatmap marks them; cleaning computes blue anew.",
        "heat = nt.heatmap(damaged)\nrepaired = nt.clean(damaged)",
        {
            "damaged": "damaged",
            "heatmap": "heat",
            "heatmap, safe colors": 'nt.heatmap(damaged, palette="safe")',
            "repaired": "repaired",
        },
    ),
    (
        "A quarter of the size",
        "Averaged as colors, arrows get too short, and the heatmap shows it; `resize` keeps them whole.",
        (
            'small = nt.resize(normals, size="25%", filter="box")\n'
            "averaged = normals.reshape(64, 4, 64, 4, 3).mean((1, 3)).round().astype(np.uint8)"
        ),
        {
            "averaged as colors, heatmap": "large(nt.heatmap(averaged))",
            "resize, heatmap": "large(nt.heatmap(small))",
            "resize, lit": "large(nt.shade(small))",
        },
    ),
    (
        "Blending a detail",
        "The detail as if it lay on the base's surface.",
        'both = nt.blend(normals, detail, mode="rnm")',
        {
            "base, lit": "nt.shade(normals)",
            "detail, lit": "nt.shade(detail)",
            "both": "both",
            "both, lit": "nt.shade(both)",
        },
    ),
    (
        "Turning, and strength",
        "Pixels and arrows turn together: the light still comes from the upper left.",
        "turned = nt.transform(normals, rotate=90)\nstrong = nt.transform(normals, strength=3)",
        {
            "turned": "turned",
            "turned, lit": "nt.shade(turned)",
            "three times as strong, lit": "nt.shade(strong)",
        },
    ),
    (
        "Heights from normals",
        "The surface behind the normals, and what is left to the height map above.",
        (
            'again, info = nt.height_from_normals_with_info(normals, kernel="sobel3")\n'
            "shape = (again - info.offset) / info.scale"
        ),
        {"normals": "normals", "heights": "gray(shape)", "difference times 100": "difference"},
    ),
]


def surface(size, exponent, seed):
    """A rough surface that tiles, 0..1."""
    rng = np.random.default_rng(seed)
    fy, fx = np.meshgrid(np.fft.fftfreq(size), np.fft.rfftfreq(size), indexing="ij")
    frequency = np.maximum(np.hypot(fy, fx), 2 / size)
    spectrum = np.fft.rfft2(rng.standard_normal((size, size))) / frequency**exponent
    height = np.fft.irfft2(spectrum, (size, size))
    return (height - height.min()) / np.ptp(height)


def gray(values):
    return np.round(255 * np.clip(values, 0, 1)).astype(np.uint8)


def large(picture):
    return picture.repeat(4, 0).repeat(4, 1)


def scene():
    """The variables that the snippets use."""
    height = gray(surface(256, 2.2, 5))
    normals = nt.normals_from_height(height, scale=14, kernel="sobel3")
    damaged = normals.copy()
    damaged[40:110, 50:150, 2] = np.minimum(damaged[40:110, 50:150, 2] + 40, 255)
    damaged[150:230, 130:220, 2] = 200
    rng = np.random.default_rng(8)
    noisy = gray(height / 255 + 0.02 * rng.standard_normal(height.shape))
    y, x = np.mgrid[0:32, 0:32] / 16 - 1
    studs = np.sqrt(np.maximum(0.7 - x * x - y * y, 0)).astype(np.float32)
    detail = np.tile(nt.normals_from_height(studs, scale=6, depth=8), (8, 8, 1))
    names = {"np": np, "nt": nt, "gray": gray, "large": large, "height": height}
    return names | {"damaged": damaged, "noisy": noisy, "detail": detail}


def make():
    """(Markdown, {path: bytes})."""
    names, page, pictures = scene(), [INTRO], {}
    with tempfile.TemporaryDirectory() as folder:
        for number, (title, words, code, shown) in enumerate(ENTRIES):
            exec(code, names)  # noqa: S102  the code of this file
            if "shape" in names:
                names["difference"] = gray(
                    0.5 + 100 * (names["shape"] - (names["height"] / 255.0 - names["height"].min() / 255)
                                 / (np.ptp(names["height"]) / 255))
                )  # fmt: skip
            page += [f"## {title}", "", words, "", "```python", code, "```", ""]
            for index, (caption, expression) in enumerate(shown.items()):
                name = f"gallery/{number}-{index}.png"
                file = Path(folder) / "picture.png"
                nt.write(file, eval(expression, names))
                pictures[name] = file.read_bytes()
                page.append(
                    f'<figure markdown="span" style="display: inline-block; margin: 0 .5em">\n'
                    f"![{caption}]({name})\n<figcaption>{caption}</figcaption>\n</figure>"
                )
            page.append("")
    return "\n".join(page), pictures
