# SPDX-License-Identifier: Apache-2.0
"""Final renders of one view layer, frame after frame."""
from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any, Optional

import bpy
import gnomon
import numpy as np

from . import passes, units
from .cameras import MadeCamera, read_camera, render_region, render_size
from .properties import render_options
from .parts import Changes, Updates
from .sync import SceneSync

_ANSWER_SECONDS = 0.05
"""How often progress is shown, and Escape is looked for."""


class LayerRender:
    """The renderer of a view layer, and the scene that it renders."""

    def __init__(self, engine) -> None:
        self.engine = engine
        self.sync = SceneSync(engine.warn, may_change=False)
        self.renderer: Any = None
        self._thread = ThreadPoolExecutor(1, "gnomon")
        self.frame: Any = None
        """The last frame, for tests."""
        self._depsgraph: Optional[int] = None
        self.motion_ahead: Optional[np.ndarray] = None
        """(height, width, 2): pixels to the right and down, from where a point will be a frame later to where it is."""
        self._changes = Changes()   # that no frame has shown yet

    def close(self) -> None:
        self.frame = None
        self._thread.shutdown()
        if self.renderer is not None:
            self.renderer.close()
            self.renderer = None
        self.sync.close()

    def update(self, depsgraph) -> None:
        """Reads what has changed."""
        updates = Updates.of(depsgraph)
        # Another dependency graph has evaluated everything anew.
        if self._depsgraph != depsgraph.as_pointer():
            updates.everything = True
            self._depsgraph = depsgraph.as_pointer()
        self.engine.update_stats("", "Gnomon: reading the scene")
        self.sync.update(depsgraph, updates, self._changes)

    def options(self, depsgraph, camera: MadeCamera, size: tuple, more: dict) -> gnomon.RenderOptions:
        scene = depsgraph.scene
        exposure = scene.view_settings.exposure + units.STOPS
        values: dict = {"size": size, "exposure": float(np.clip(exposure, -100, 100)),
                        "sun_size": min(45.0, float(np.degrees(self.sync.sun_angle)))}
        values.update(render_options(scene.gnomon, scene.render), **camera.options)
        values.update(passes.wanted_options(depsgraph.view_layer))
        return gnomon.RenderOptions(**{**values, **more})

    def render(self, depsgraph) -> None:
        scene = depsgraph.scene_eval
        render = scene.render
        if scene.camera is None:
            raise gnomon.UsageError("the scene has no camera")
        region = render_region(render)
        size = render_size(render) if region is None else region[2:]
        at = (0, 0) if region is None or render.use_crop_to_border else region[:2]
        number = scene.frame_current + scene.frame_subframe
        self.motion_ahead = None
        if depsgraph.view_layer.use_pass_vector:
            self._find_motion(depsgraph, number, region, size)
        self.frame = None   # its memory is used again
        self.frame = self._render_blurred(depsgraph, number, region, size)
        self._store(depsgraph, at, size)

    def _render_blurred(self, depsgraph, number: float, region: Optional[tuple], size: tuple):
        """The frame of a number, whose shutter opens before it and closes after it."""
        render = depsgraph.scene_eval.render
        width = float(render.motion_blur_shutter) if render.use_motion_blur else 0.0
        if width <= 0:
            return self._render(depsgraph, number, self._camera(depsgraph, region), size, {})
        if width > 1:
            self.engine.warn("the shutter is open for one frame at most")
            width = 1.0
        # Read the scene at the shutter's opening, then at its closing.
        self._go_to(depsgraph, number - 0.5 * width)
        opening, changes = self._camera(depsgraph, region), self._changes
        self._changes = Changes()
        self._go_to(depsgraph, number + 0.5 * width)
        camera, later = self._camera(depsgraph, region), self._changes
        changes.drop(self.sync.removed)
        later.drop(self.sync.removed)
        closing = gnomon.Closing(camera=camera.camera())
        closing.transforms = {key: value for key, value in later.transforms.items()}
        closing.vertices = {key: value.positions for key, value in later.vertices.items()}
        # What moves only while the shutter is open begins where it was.
        for key in later.transforms:
            if key not in changes.transforms:
                changes.transforms[key] = self.sync.transform_before(key)
        for key in later.vertices:
            if key not in changes.vertices:
                changes.vertices[key] = self.sync.vertices_before(key)
        self._changes = changes
        try:
            frame = self._render(depsgraph, number, opening, size, {"shutter": 360.0 * width}, closing)
        finally:
            self._changes = later   # the values from which the next frame goes on
            self._set_frame(depsgraph, number)
        return frame

    def _find_motion(self, depsgraph, number: float, region: Optional[tuple], size: tuple) -> None:
        """Finds the motion to the frame after, and lets the renderer know the frame before, from which vectors lead."""
        quick = {"samples": 1, "indirect": "off", "layers": False, "ids": False}
        self._go_to(depsgraph, number + 1)
        self._render(depsgraph, number + 1, self._camera(depsgraph, region), (16, 16), quick)
        self._go_to(depsgraph, number)
        frame = self._render(depsgraph, number, self._camera(depsgraph, region), size, quick)
        self.motion_ahead = frame.motion.copy()
        self._go_to(depsgraph, number - 1)
        self._render(depsgraph, number - 1, self._camera(depsgraph, region), (16, 16), quick)
        self._go_to(depsgraph, number)

    def _go_to(self, depsgraph, number: float) -> None:
        """Evaluates the scene at another time, and reads it."""
        self._set_frame(depsgraph, number)
        self.update(depsgraph)

    def _set_frame(self, depsgraph, number: float) -> None:
        whole = int(np.floor(number))
        self.engine.frame_set(whole, float(number - whole))

    def _camera(self, depsgraph, region: Optional[tuple]) -> MadeCamera:
        scene = depsgraph.scene_eval
        return read_camera(scene.camera.evaluated_get(depsgraph), scene.render, depsgraph, region, self.engine.warn)

    def _render(self, depsgraph, number: float, camera: MadeCamera, size: tuple, more: dict, closing=None):
        options = self.options(depsgraph, camera, size, more)
        if self.renderer is None:
            self.renderer = gnomon.Renderer(options)
        else:
            self.renderer.set_options(options)
        changes = self._changes
        render = depsgraph.scene_eval.render
        frame = self._wait(
            self.sync.scene, time=number * render.fps_base / render.fps, camera=camera.camera(),
            transforms=changes.transforms, visibility=changes.visibility, vertices=changes.vertices, lights=changes.lights,
            materials=changes.materials, closing=closing)
        self._changes = Changes()
        return frame

    def _wait(self, scene, **frame):
        """Renders in a thread of its own, because Blender must be told of progress by the thread that it has called."""
        told = ["", 0.0]
        stops = threading.Event()

        def progress(stage: str, done: float) -> bool:
            told[:] = stage, done
            return not stops.is_set()

        work = self._thread.submit(self.renderer.render, scene, progress=progress, **frame)
        while not wait((work,), _ANSWER_SECONDS).done:
            self.engine.update_stats("", f"Gnomon: {told[0]}")
            self.engine.update_progress(told[1])
            if self.engine.test_break():
                stops.set()
        return work.result()

    def store_nothing(self, depsgraph) -> None:
        """Leaves an empty image, because Blender may write it to a file all the same."""
        self.engine.end_result(self.engine.begin_result(0, 0, *render_size(depsgraph.scene_eval.render),
                                                        layer=depsgraph.view_layer.name))

    def _store(self, depsgraph, at: tuple, size: tuple) -> None:
        layer_name = depsgraph.view_layer.name
        for flag, name, channels, _ in passes.PASSES:
            if getattr(depsgraph.view_layer, flag):
                self.engine.add_pass(name, len(channels), channels, layer=layer_name)
        result = self.engine.begin_result(*at, *size, layer=layer_name)
        try:
            for each in result.layers[0].passes:
                if each.name == "Combined":
                    passes.store(each, passes.combined(self.frame))
                elif any(each.name == row[1] for row in passes.PASSES):
                    passes.store(each, self._values_of(each.name))
        finally:
            self.engine.end_result(result)
        self.engine.update_progress(1.0)

    def _values_of(self, name: str) -> np.ndarray:
        if name == "Vector":
            return passes.vectors(self.frame, self.motion_ahead)
        if name == "IndexOB":
            return self._indices(self.frame.object_ids)[..., None]
        if name == "DiffCol":
            return passes.diffuse_color(self.frame, self.sync.reflectances(self.frame.material_ids))
        if name == "Shadow":
            return passes.shadow(self.frame, self.sync.light_channels())
        return passes.values_of(self.frame, name)

    def _indices(self, ids: np.ndarray) -> np.ndarray:
        """Pass indices of the objects of a layer of ids."""
        result = np.zeros(ids.shape, dtype=np.float32)
        for value, name in self.sync.names_of(ids).items():
            block = bpy.data.objects.get(name)   # objects of instances are not among the graph's own
            if block is not None and block.pass_index:
                result[ids == value] = block.pass_index
        return result
