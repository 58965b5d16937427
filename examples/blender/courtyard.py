# SPDX-License-Identifier: Apache-2.0
"""Makes an animated scene for Blender: a courtyard with columns, a mobile that turns above a sundial, balls that roll and a
cloth that waves, for 48 frames.

    blender -b --factory-startup -P examples/blender/courtyard.py -- courtyard.blend [--detail N]

Most of it stands still. The sun and a few lights light it, and a sky from an image beside the .blend."""
from __future__ import annotations

import argparse
import math
import os
import sys

import bpy
import numpy as np

FRAMES = 48
SKY = (64, 32)


def material(name: str, color, roughness: float = 0.8, metallic: float = 0.0, transmission: float = 0.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    node = made.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (*color, 1)
    node.inputs["Roughness"].default_value = roughness
    node.inputs["Metallic"].default_value = metallic
    node.inputs["Transmission"].default_value = transmission
    return made


def tiles(name: str):
    """A material whose base colour is an image."""
    size = 64
    image = bpy.data.images.new(name, size, size)
    random = np.random.default_rng(1)
    shade = np.kron(0.35 + 0.3 * random.random((8, 8)), np.ones((8, 8)))
    pixels = np.stack([shade, shade * 0.95, shade * 0.85, np.ones_like(shade)], axis=-1)
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.pack()
    made = material(name, (1, 1, 1), 0.9)
    node = made.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    made.node_tree.links.new(node.outputs["Color"], made.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    return made


def add(make, place=(0, 0, 0), of=None, smooth: bool = False, parent=None, name: str = "", **more):
    make(location=place, **more)
    made = bpy.context.object
    if name:
        made.name = name
    if of is not None:
        made.data.materials.append(of)
    if smooth:
        bpy.ops.object.shade_smooth()
    if parent is not None:
        made.parent = parent
    return made


def key_linear(block, path: str, values: dict, index: int = -1) -> None:
    for frame, value in values.items():
        if index >= 0:
            getattr(block, path)[index] = value
        else:
            setattr(block, path, value)
        block.keyframe_insert(path, index=index, frame=frame)
    owner = block.id_data if block.id_data.animation_data else block
    for curve in owner.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def architecture(detail: int) -> None:
    mesh = bpy.ops.mesh
    stone, wall = material("stone", (0.62, 0.58, 0.5)), material("wall", (0.55, 0.35, 0.25), 0.95)
    add(mesh.primitive_plane_add, of=tiles("tiles"), size=16, name="ground")
    for index, (place, size) in enumerate((((0, 6, 2), (12, 0.4, 4)), ((-6, 0, 2), (0.4, 12, 4)))):
        made = add(mesh.primitive_cube_add, place, wall, size=1, name=f"wall {index}")
        made.scale = size
    shaft = None
    for index in range(10):
        place = (-4.5 + index, 4.6, 1.5) if index < 6 else (-4.6, 3.2 - 1.4 * (index - 5), 1.5)
        if shaft is None:
            shaft = add(mesh.primitive_cylinder_add, place, stone, True, radius=0.16, depth=3, vertices=16 * detail, name="column")
            shaft.data.use_auto_smooth = True
            continue
        copy = bpy.data.objects.new(f"column {index}", shaft.data)   # an instance of its mesh
        copy.location = place
        bpy.context.collection.objects.link(copy)
    dial = add(mesh.primitive_cylinder_add, (0, 0, 0.2), stone, radius=1.2, depth=0.4, vertices=32 * detail, name="dial")
    gnomon = add(mesh.primitive_cone_add, (0, 0, 0.9), material("bronze", (0.7, 0.45, 0.2), 0.3, 1.0), radius1=0.15,
                 depth=1.2, vertices=8, name="gnomon")
    gnomon.rotation_euler = (math.radians(-30), 0, 0)
    dial.modifiers.new("edge", "BEVEL").width = 0.05


def mobile(detail: int) -> None:
    mesh = bpy.ops.mesh
    brass = material("brass", (0.8, 0.6, 0.3), 0.25, 1.0)
    colors = [material(f"paint {i}", c, 0.5) for i, c in enumerate(((0.7, 0.1, 0.1), (0.1, 0.2, 0.6), (0.8, 0.7, 0.1)))]
    hub = add(mesh.primitive_uv_sphere_add, (0.3, -0.2, 3), brass, True, radius=0.12, segments=16 * detail,
              ring_count=8 * detail, name="hub")
    hub.rotation_mode = "XYZ"
    key_linear(hub, "rotation_euler", {1: 0, FRAMES: math.radians(150)}, 2)
    for index in range(3):
        angle = 2 * math.pi * index / 3
        arm = add(mesh.primitive_cylinder_add, (0.7 * math.cos(angle), 0.7 * math.sin(angle), 0), brass, parent=hub,
                  radius=0.02, depth=1.4, vertices=8, name=f"arm {index}")
        arm.rotation_euler = (0, math.radians(90), angle)
        ball = add(mesh.primitive_ico_sphere_add, (1.4 * math.cos(angle), 1.4 * math.sin(angle), -0.4), colors[index], True,
                   parent=hub, radius=0.28, subdivisions=1 + detail, name=f"ball {index}")
        ball.data.use_auto_smooth = False


def what_moves(detail: int) -> None:
    mesh = bpy.ops.mesh
    ball = add(mesh.primitive_uv_sphere_add, (2.4, -1.5, 0.35), material("rubber", (0.15, 0.5, 0.25), 0.4), True, radius=0.35,
               segments=16 * detail, ring_count=8 * detail, name="rolling")
    key_linear(ball, "location", {1: 2.4, FRAMES: -2.0}, 0)
    flag = add(mesh.primitive_grid_add, (-5.5, 1, 2.4), material("cloth", (0.6, 0.55, 0.2), 0.9), True, size=1.4,
               x_subdivisions=8 * detail, y_subdivisions=8 * detail, name="flag")
    flag.rotation_euler = (0, math.radians(80), 0)
    flag.shape_key_add(name="rest")
    waved = flag.shape_key_add(name="waved")
    for point in waved.data:
        point.co.z += 0.15 * math.sin(4 * point.co.x + 2 * point.co.y)
    key_linear(waved, "value", {1: 0.0, FRAMES // 2: 1.0, FRAMES: 0.0})


def sky() -> np.ndarray:
    """(height, width, 3): the radiance of a sky that is brighter on one side, its upper row first."""
    width, height = SKY
    up = np.linspace(1, -1, height)[:, None, None] * np.ones((1, width, 1))
    around = np.cos(np.linspace(0, 2 * np.pi, width, endpoint=False))[None, :, None]
    above = np.array([0.25, 0.4, 0.7]) * (0.5 + 0.5 * up)
    return np.where(up > 0, above, np.array([0.2, 0.18, 0.15])) * (1 + 0.3 * around)


def write_hdr(path: str, pixels: np.ndarray) -> None:
    """Writes a Radiance image, without compression."""
    largest = np.maximum(pixels.max(axis=-1), 1e-30)
    mantissa, exponent = np.frexp(largest)
    rgbe = np.empty((*pixels.shape[:2], 4), dtype=np.uint8)
    rgbe[..., :3] = np.clip(np.round(pixels * (mantissa * 256 / largest)[..., None]), 0, 255)
    rgbe[..., 3] = exponent + 128
    height, width = pixels.shape[:2]
    with open(path, "wb") as file:
        file.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
        file.write(rgbe.tobytes())


def light_and_camera(folder: str) -> None:
    scene = bpy.context.scene
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.rotation_euler = (math.radians(50), math.radians(10), math.radians(25))
    sun.data.energy, sun.data.color, sun.data.angle = 3.0, (1, 0.93, 0.8), 0
    scene.collection.objects.link(sun)
    for index, place in enumerate(((-4, 4, 2.6), (3.5, 5, 2.6))):
        light = bpy.data.objects.new(f"light {index}", bpy.data.lights.new(f"light {index}", "POINT"))
        light.location, light.data.energy, light.data.color, light.data.shadow_soft_size = place, 60, (1, 0.7, 0.4), 0
        scene.collection.objects.link(light)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.data.lens = 30
    camera.rotation_euler = (math.radians(72), 0, math.radians(38))
    key_linear(camera, "location", {1: 6.0, FRAMES: 5.4}, 0)
    camera.location = (6.0, -6.6, 3.4)

    path = os.path.join(folder, "sky.hdr")
    write_hdr(path, sky())
    image = bpy.data.images.load(path)
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    world.node_tree.links.new(node.outputs["Color"], world.node_tree.nodes["Background"].inputs["Color"])
    scene.world = world


def make(folder: str, detail: int = 2) -> None:
    """Makes the scene in the open file. Its sky is written to the folder."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, FRAMES, 24
    architecture(detail)
    mobile(detail)
    what_moves(detail)
    light_and_camera(folder)
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = True
    scene.frame_set(1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="courtyard.py", description="makes an animated scene for Blender")
    parser.add_argument("blend", help="the file to write")
    parser.add_argument("--detail", type=int, default=2, help="triangles of round things grow with its square")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    target = os.path.abspath(arguments.blend)
    make(os.path.dirname(target), arguments.detail)
    bpy.ops.wm.save_as_mainfile(filepath=target)
