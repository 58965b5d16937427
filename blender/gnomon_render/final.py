# SPDX-License-Identifier: Apache-2.0
"""Final renders of one view layer, frame after frame."""
from __future__ import annotations

from typing import Any, Optional

import gnomon
import numpy as np

from . import passes, units
from .cameras import MadeCamera, read_camera, render_region, render_size
from .properties import render_options
from .sync import Changes, SceneSync, Updates


class LayerRender:
    """The renderer of a view layer, and the scene that it renders."""

    def __init__(self, engine) -> None:
        self.engine = engine
        self.sync = SceneSync(engine.warn, may_change=False)
        self.renderer: Any = None
        self.frame: Any = None
        """The last frame, for tests."""
        self._depsgraph: Optional[int] = None
        self._number: Optional[float] = None   # of the last frame
        self._changes = Changes()   # that no frame has shown yet

    def close(self) -> None:
        self.frame = None
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
        if depsgraph.view_layer.use_pass_vector and self._number != number - 1:
            self._render_before(depsgraph, number - 1, region)
        self.frame = None   # its memory is used again
        self.frame = self._render_blurred(depsgraph, number, region, size)
        self._number = number
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

    def _render_before(self, depsgraph, number: float, region: Optional[tuple]) -> None:
        """Lets the renderer know the frame before, from which vectors lead."""
        here = depsgraph.scene_eval.frame_current + depsgraph.scene_eval.frame_subframe
        self._go_to(depsgraph, number)
        self._render(depsgraph, number, self._camera(depsgraph, region), (16, 16),
                     {"samples": 1, "indirect": "off", "layers": False, "ids": False})
        self._go_to(depsgraph, here)

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
        frame = self.renderer.render(
            self.sync.scene, time=number * render.fps_base / render.fps, camera=camera.camera(),
            transforms=changes.transforms, visibility=changes.visibility, vertices=changes.vertices, lights=changes.lights,
            materials=changes.materials, closing=closing, progress=self._progress)
        self._changes = Changes()
        return frame

    def _progress(self, stage: str, done: float) -> bool:
        self.engine.update_progress(done)
        self.engine.update_stats("", f"Gnomon: {stage}")
        return not self.engine.test_break()

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
                    passes.store(each, passes.values_of(self.frame, each.name, lambda ids: self._indices(depsgraph, ids)))
        finally:
            self.engine.end_result(result)
        self.engine.update_progress(1.0)

    def _indices(self, depsgraph, ids: np.ndarray) -> np.ndarray:
        """Pass indices of the objects of a layer of ids."""
        result = np.zeros(ids.shape, dtype=np.float32)
        for value, name in self.sync.names_of(ids).items():
            block = depsgraph.objects.get(name)
            if block is not None and block.pass_index:
                result[ids == value] = block.pass_index
        return result
