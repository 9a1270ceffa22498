# SPDX-License-Identifier: MIT
"""Runs inside GIMP 3 for gimp3.py: does to copies of a layer, in turns, what NTP_TURNS names.

The seconds of each go to times.json, the bytes that the last of ours made to result-NAME.
"""

import json
import os
import time

from gi.repository import Gegl, Gimp, Gio

HERE = os.environ["NTP_JOBS"]
ROUNDS = int(os.environ["NTP_ROUNDS"])
CLAMPED = {"scale": 10.0, "border-x": "clamp", "border-y": "clamp", "to-y": "down"}


def merge(image, layer, operation, settings):
    """Merges an operation into the layer."""
    made = Gimp.DrawableFilter.new(layer, operation, "")
    for name, value in settings.items():
        made.get_config().set_property(name, value)
    made.update()
    start = time.perf_counter()
    layer.merge_filter(made)
    return time.perf_counter() - start


def call(image, layer, **others):
    """Calls the plug-in."""
    procedure = Gimp.get_pdb().lookup_procedure("plug-in-ntp-normals-from-height")
    config = procedure.create_config()
    config.set_property("run-mode", Gimp.RunMode.NONINTERACTIVE)
    config.set_property("image", image)
    config.set_core_object_array("drawables", [layer])
    for name, value in (CLAMPED | others).items():
        config.set_property(name, value)
    start = time.perf_counter()
    answer = procedure.run(config)
    assert answer.index(0) == Gimp.PDBStatusType.SUCCESS
    return time.perf_counter() - start


def alone(image, layer):
    """Calls the plug-in with an option that the operation does not have, so that it does all the
    work."""
    return call(image, layer, **{"swap-rgb": True})


def start(image, layer):
    """Calls the plug-in on a few texels: most of this is the start of its process."""
    little = Gimp.Image.new(16, 16, Gimp.ImageBaseType.RGB)
    few = Gimp.Layer.new(
        little, "few", 16, 16, Gimp.ImageType.RGB_IMAGE, 100, Gimp.LayerMode.NORMAL
    )
    little.insert_layer(few, None, 0)
    seconds = call(little, few)
    little.delete()
    return seconds


def copy(image, layer):
    """The round trip of a buffer: all texels come from GIMP and go back, unchanged.

    The least that it can take: tiles are passed on as they are, by a process that did it before.
    """
    box = Gegl.Rectangle.new(0, 0, layer.get_width(), layer.get_height())
    start = time.perf_counter()
    shadow = layer.get_shadow_buffer()
    layer.get_buffer().copy(box, Gegl.AbyssPolicy.NONE, shadow, box)
    shadow.flush()
    layer.merge_shadow(True)
    layer.update(0, 0, box.width, box.height)
    return time.perf_counter() - start


TURNS = {
    "gimp": lambda image, layer: merge(image, layer, "gegl:normal-map", {"scale": 10.0}),
    "filter": lambda image, layer: merge(image, layer, "ntp:normals-from-height", CLAMPED),
    "plug-in": call,
    "alone": alone,
    "start": start,
    "copy": copy,
}


def write(layer, file):
    box = Gegl.Rectangle.new(0, 0, layer.get_width(), layer.get_height())
    data = layer.get_buffer().get(box, 1.0, None, Gegl.AbyssPolicy.NONE)
    with open(os.path.join(HERE, file), "wb") as out:
        out.write(bytes(data))


def main():
    file = Gio.File.new_for_path(os.path.join(HERE, "heights.png"))
    image = Gimp.file_load(Gimp.RunMode.NONINTERACTIVE, file)
    names = os.environ["NTP_TURNS"].split()
    times = {name: [] for name in names}
    for turn in range(ROUNDS):
        for name in names:
            layer = image.get_layers()[-1].copy()
            image.insert_layer(layer, None, 0)
            times[name].append(TURNS[name](image, layer))
            if turn == ROUNDS - 1 and name in ("filter", "plug-in", "alone"):
                write(layer, f"result-{name}")
            image.remove_layer(layer)
    with open(os.path.join(HERE, "times.json"), "w", encoding="utf-8") as out:
        json.dump(times, out)


main()
