# SPDX-License-Identifier: Apache-2.0
"""What the tests of the add-on share. They run inside Blender:

    GNOMON_PYTHON=build/release/python blender -b --factory-startup --python-exit-code 1 -P tests/blender/lights_test.py
"""
from __future__ import annotations

import math
import os
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, Optional

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "blender"), str(ROOT / "examples" / "blender")]
PROGRAM = os.environ.get("GNOMON_PROGRAM", "")

import gnomon_render  # noqa: E402

gnomon_render.register()
assert gnomon_render.engine.library.find() is not None, gnomon_render.engine.library.problem()

from gnomon_render import final  # noqa: E402

FRAMES: list = []
"""(gnomon.Frame, LayerRender) of each final frame, since the list was cleared."""
WARNINGS: list = []


def _watch() -> None:
    store, warn = final.LayerRender._store, gnomon_render.engine.GnomonRenderEngine.warn

    def watched_store(self, depsgraph, at, size):
        FRAMES.append((self.frame, self))
        return store(self, depsgraph, at, size)

    def watched_warn(self, what):
        WARNINGS.append(what)
        return warn(self, what)

    final.LayerRender._store = watched_store
    gnomon_render.engine.GnomonRenderEngine.warn = watched_warn


_watch()


def new_scene(size=(16, 16)):
    """An empty scene without light."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "GNOMON"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.dither_intensity = 0
    scene.view_settings.view_transform = "Standard"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.samples = 64
    FRAMES.clear()
    WARNINGS.clear()
    return scene


def link(name: str, data) -> Any:
    ob = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def add_plane(side: float = 100.0, material=None, name: str = "plane") -> Any:
    half = side / 2
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    if material is not None:
        mesh.materials.append(material)
    return link(name, mesh)


def add_ball(place=(0, 0, 0), radius: float = 1.0, material=None, name: str = "ball") -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=place, segments=24, ring_count=12)
    ob = bpy.context.object
    bpy.ops.object.shade_smooth()
    ob.name = name
    if material is not None:
        ob.data.materials.append(material)
    return ob


def shader(name: str, kind: str, **inputs) -> Any:
    """A material of one shader node."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    end, node = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    return material


def diffuse(value: float = 0.5) -> Any:
    return shader("diffuse", "ShaderNodeBsdfDiffuse", Color=(value, value, value, 1))


def add_camera(place=(0, 0, 1), rotation=(0, 0, 0), ortho: Optional[float] = None) -> Any:
    data = bpy.data.cameras.new("camera")
    if ortho is not None:
        data.type, data.ortho_scale = "ORTHO", ortho
    ob = link("camera", data)
    ob.location, ob.rotation_euler = place, rotation
    bpy.context.scene.camera = ob
    return ob


def look_at(ob, target) -> None:
    import mathutils

    ob.rotation_euler = (mathutils.Vector(target) - ob.location).to_track_quat("-Z", "Y").to_euler()


def add_light(kind: str, place=(0, 0, 2), rotation=(0, 0, 0), **values) -> Any:
    data = bpy.data.lights.new("light", kind)
    for key, value in values.items():
        setattr(data, key, value)
    ob = link("light", data)
    ob.location, ob.rotation_euler = place, rotation
    return ob


def set_world(color) -> Any:
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*color, 1)
    bpy.context.scene.world = world
    return world


def render(engine: str = "GNOMON", frame: Optional[int] = None) -> np.ndarray:
    """(height, width, 4): the combined pass as Blender has it, the upper row first."""
    scene = bpy.context.scene
    scene.render.engine = engine
    if frame is not None:
        scene.frame_set(frame)
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
        scene.render.filepath = os.path.join(folder, "image.exr")
        bpy.ops.render.render(write_still=True)
        return read_image(scene.render.filepath)


def read_image(path: str) -> np.ndarray:
    image = bpy.data.images.load(path, check_existing=False)
    try:
        width, height = image.size
        pixels = np.empty(width * height * image.channels, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        return pixels.reshape(height, width, image.channels)[::-1].copy()
    finally:
        bpy.data.images.remove(image)


def render_passes(engine: str) -> dict:
    """{pass: (height, width, channels)} of what the view layer has, by the compositor."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    scene.update_render_engine()   # the node's sockets are the engine's passes
    source, sink = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeOutputFile")
    with tempfile.TemporaryDirectory() as folder:
        sink.base_path = folder
        sink.format.file_format, sink.format.color_depth = "OPEN_EXR", "32"
        sink.file_slots.clear()
        names = [out.name for out in source.outputs if out.enabled and out.name not in {"Alpha", "Noisy Image"}]
        for name in names:
            sink.file_slots.new(name)
            tree.links.new(source.outputs[name], sink.inputs[name])
        bpy.ops.render.render()
        made = {name: read_image(os.path.join(folder, f"{name}{scene.frame_current:04}.exr")) for name in names}
    scene.use_nodes = False
    return made


def animate(frames: int, engine: str = "GNOMON", persistent: bool = True) -> list:
    """The combined passes of frames 1 to that, by Render Animation."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.frame_start, scene.frame_end = 1, frames
    scene.render.use_persistent_data = persistent
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
        scene.render.filepath = os.path.join(folder, "image_####")
        bpy.ops.render.render(animation=True)
        return [read_image(os.path.join(folder, f"image_{number:04}.exr")) for number in range(1, frames + 1)]


def main(*cases) -> None:
    """Runs test cases, and ends Blender with 1 if one failed."""
    suite = unittest.TestSuite(unittest.defaultTestLoader.loadTestsFromTestCase(case) for case in cases)
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    sys.stdout.flush()
    if not result.wasSuccessful():
        raise SystemExit(1)


__all__ = [name for name in dir() if not name.startswith("_")] + ["math", "np", "bpy", "unittest"]
