# SPDX-License-Identifier: MIT
"""Atlases that Blender bakes, into a directory: made_by_blender.py DIRECTORY [COUNT] (needs bpy).

A body with fine relief is baked onto a plain one, whose charts Blender lays out and turns.  So the
charts have frames of their own and padding between them, as in models that are shipped.  Blender
writes green up.  ./dev bench quality reads the directory that NTP_BAKED names.
"""

import math
import random
import sys
from pathlib import Path

import bpy

SIZES = (64, 128, 256, 512)
MOST_FACES = 100_000


def body(rng):
    """A plain body, the active object."""
    add = bpy.ops.mesh
    sort = rng.randrange(6)
    if sort == 0:
        add.primitive_monkey_add()
    elif sort == 1:
        add.primitive_cube_add()
    elif sort == 2:
        add.primitive_torus_add(major_segments=24, minor_segments=12, minor_radius=0.4)
    elif sort == 3:
        add.primitive_cylinder_add(vertices=rng.choice([8, 16, 32]))
    elif sort == 4:
        add.primitive_uv_sphere_add(segments=16, ring_count=8)
    else:
        add.primitive_cone_add(vertices=rng.choice([6, 24]))
    return bpy.context.active_object


def modifier(thing, name, kind, **values):
    made = thing.modifiers.new(name, kind)
    for key, value in values.items():
        setattr(made, key, value)
    return made


def detailed(low, rng):
    """A copy with many faces and relief."""
    high = low.copy()
    high.data = low.data.copy()
    bpy.context.collection.objects.link(high)
    if rng.random() < 0.5:
        modifier(high, "edges", "BEVEL", width=rng.uniform(0.02, 0.1), segments=3)
    deep = max(1, int(math.log(MOST_FACES / len(low.data.polygons), 4)))
    modifier(high, "faces", "SUBSURF", levels=deep, render_levels=deep,
             subdivision_type=rng.choice(["SIMPLE", "CATMULL_CLARK"]))  # fmt: skip
    texture = bpy.data.textures.new("relief", rng.choice(["CLOUDS", "VORONOI", "MUSGRAVE"]))
    texture.noise_scale = rng.uniform(0.08, 0.5)
    modifier(high, "relief", "DISPLACE", texture=texture, strength=rng.uniform(0.02, 0.1))
    for face in high.data.polygons:
        face.use_smooth = True
    return high


def unwrapped(low, rng):
    bpy.context.view_layer.objects.active = low
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    angle = math.radians(rng.choice([30, 66, 80]))
    bpy.ops.uv.smart_project(angle_limit=angle, island_margin=rng.choice([0.005, 0.02]))
    bpy.ops.object.mode_set(mode="OBJECT")
    smooth = rng.random() < 0.7
    for face in low.data.polygons:
        face.use_smooth = smooth


def target(low, side):
    """The picture that is baked into, as a node of the body's material."""
    image = bpy.data.images.new("normals", side, side)
    image.colorspace_settings.name = "Non-Color"
    material = bpy.data.materials.new("plain")
    material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
    low.data.materials.clear()
    low.data.materials.append(material)
    return image


def bake(path, number):
    """One atlas, a function of its number."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    rng = random.Random(number)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    low = body(rng)
    high = detailed(low, rng)
    unwrapped(low, rng)
    side = rng.choice(SIZES)
    image = target(low, side)
    bpy.ops.object.select_all(action="DESELECT")
    high.select_set(True)
    low.select_set(True)
    bpy.context.view_layer.objects.active = low
    bpy.ops.object.bake(type="NORMAL", use_selected_to_active=True, cage_extrusion=0.3,
                        margin=rng.choice([0, 2, 8]), use_clear=rng.random() < 0.7)  # fmt: skip
    image.filepath_raw = str(path)
    image.file_format = "PNG"
    image.save()


def main():
    place, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 100
    place.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        bake(place / f"baked_{number:03d}.png", number)


if __name__ == "__main__":
    main()
