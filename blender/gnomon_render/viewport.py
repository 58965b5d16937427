# SPDX-License-Identifier: Apache-2.0
"""A viewport that is rendered progressively.

A thread renders what the viewport shows: first with few pixels and without indirect light, then with all of them, then with
samples. Whatever changes cancels the image in progress. The thread never touches Blender's data, which the main thread
reads for it.
"""
from __future__ import annotations

import threading
from typing import Any, Optional

import gnomon
import numpy as np

from . import units
from .cameras import MadeCamera, view_camera
from .passes import combined
from .properties import render_options
from .parts import Changes, Updates
from .sync import SceneSync


class ProgressiveRender:
    """Renders a scene in a thread, coarse to fine. All calls come from one other thread."""

    def __init__(self, tell) -> None:
        """tell()  is called, from the thread, when there is another image"""
        self._tell = tell
        self._renderer: Any = None
        self._wake = threading.Condition()
        self._wanted: Optional[dict] = None
        self._image: Optional[np.ndarray] = None
        self._shown = 0   # step of the image
        self._ends = False
        self._paused = False
        self._idle = True
        self.error = ""
        self._thread = threading.Thread(target=self._work, name="gnomon viewport", daemon=True)
        self._thread.start()

    def pause(self) -> None:
        """Returns when nothing is rendered; resume() or show() go on."""
        with self._wake:
            self._paused = True
            if self._renderer is not None:
                self._renderer.cancel()
            while not self._idle:
                if not self._wake.wait(0.02) and self._renderer is not None:
                    self._renderer.cancel()

    def show(self, scene, changes: Changes, camera: MadeCamera, size: tuple, options: dict, scale: int) -> None:
        """From now on renders this. Changes that were handed over and not rendered yet stay."""
        self.pause()
        with self._wake:
            if self._wanted is not None:
                for values, earlier in zip(changes.each(), self._wanted["changes"].each()):
                    for key, value in earlier.items():
                        values.setdefault(key, value)
            self._wanted = {"scene": scene, "changes": changes, "camera": camera, "size": size, "options": options,
                            "steps": _steps(scale, options)}
            self._paused = False
            self._wake.notify_all()

    def image(self) -> Optional[np.ndarray]:
        """(height, width, 4): the last image, of any size."""
        with self._wake:
            return self._image

    def wait(self, seconds: float) -> bool:
        """Waits until the finest image is there; for tests."""
        with self._wake:
            return self._wake.wait_for(lambda: self._idle and self._wanted is not None and not self._wanted["steps"], seconds)

    def close(self) -> None:
        self.pause()
        with self._wake:
            self._ends = True
            self._wake.notify_all()
        self._thread.join()
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _work(self) -> None:
        while True:
            with self._wake:
                self._idle = True
                self._wake.notify_all()
                self._wake.wait_for(lambda: self._ends or (not self._paused and self._wanted is not None
                                                           and self._wanted["steps"]))
                if self._ends:
                    return
                self._idle = False
                wanted = self._wanted
                assert wanted is not None
                step = wanted["steps"][0]
            try:
                image = self._render(wanted, step)
            except gnomon.Interrupted:
                continue
            except Exception as error:   # shown by the main thread
                self.error = str(error)
                with self._wake:
                    wanted["steps"].clear()
                self._tell()
                continue
            with self._wake:
                self._image = image
                self.error = ""
                wanted["steps"].pop(0)
                wanted["changes"] = Changes()
            self._tell()

    def _render(self, wanted: dict, step: dict) -> np.ndarray:
        scale = step["scale"]
        size = tuple(max(1, (side + scale - 1) // scale) for side in wanted["size"])
        options = gnomon.RenderOptions(size=size, **{**wanted["options"], **step["options"]})
        if self._renderer is None:
            self._renderer = gnomon.Renderer(options)
        else:
            self._renderer.set_options(options)
        changes: Changes = wanted["changes"]
        camera = wanted["camera"]
        frame = self._renderer.render(
            wanted["scene"], time=0.0, camera=camera.camera(),
            transforms=changes.transforms, visibility=changes.visibility, vertices=changes.vertices, lights=changes.lights,
            materials=changes.materials, progress=lambda stage, done: not self._paused)
        return combined(frame)


def _steps(scale: int, options: dict) -> list:
    """From what is shown at once to what a final image has."""
    coarse = {"samples": 1, "indirect": "off", "aperture": 0.0, "focus": None}
    steps = [{"scale": 4 * scale, "options": coarse}, {"scale": scale, "options": {"samples": 1}}]
    if scale > 1:
        steps.append({"scale": 1, "options": {"samples": 1}})
    if options.get("samples") != 1:
        steps.append({"scale": 1, "options": {}})
    return steps


class Viewport:
    """One 3D viewport: what it shows, and the renderer behind it."""

    def __init__(self, engine) -> None:
        self.engine = engine
        self.sync = SceneSync(engine.warn, may_change=True)
        self.progressive = ProgressiveRender(self._redraw)
        self._changes = Changes()
        self._known = False
        self._view: Any = None
        self._texture: Any = None
        self._drawn: Any = None

    def close(self) -> None:
        self.progressive.close()
        self.sync.close()

    def _redraw(self) -> None:
        try:
            self.engine.tag_redraw()
        except ReferenceError:
            pass   # the viewport was closed meanwhile

    def update(self, context, depsgraph) -> None:
        """Reads what has changed in the scene."""
        updates = Updates.of(depsgraph)
        updates.everything = not self._known
        self._known = True
        self.progressive.pause()
        self.sync.update(depsgraph, updates, self._changes)
        self._view = None
        self.engine.tag_redraw()

    def look(self, region3d, space, size: tuple, depsgraph) -> None:
        """Renders from another place, if it is one, or what has changed."""
        scene = depsgraph.scene
        camera = view_camera(region3d, size, space, depsgraph, self.engine.warn)
        options = {**render_options(scene.gnomon, scene.render), **camera.options,
                   "sun_size": min(45.0, float(np.degrees(self.sync.sun_angle))),
                   "exposure": float(np.clip(scene.view_settings.exposure + units.STOPS, -100, 100))}
        view = (camera.projection.tobytes(), camera.to_world.tobytes(), size, repr(sorted(options.items(), key=str)))
        if view == self._view or self.sync.scene is None:
            return
        self._view = view
        changes, self._changes = self._changes, Changes()
        self.progressive.show(self.sync.scene, changes, camera, size, options, scene.gnomon.viewport_scale)

    def draw(self, context, depsgraph) -> None:
        """Draws the last image, and looks for another view."""
        import gpu
        from gpu_extras.presets import draw_texture_2d

        region = context.region
        self.look(context.region_data, context.space_data, (region.width, region.height), depsgraph)
        if self.progressive.error:
            self.engine.update_stats("Gnomon", self.progressive.error)
        image = self.progressive.image()
        if image is None:
            return
        if image is not self._drawn:
            flipped = np.ascontiguousarray(image[::-1])
            height, width, _ = flipped.shape
            buffer = gpu.types.Buffer("FLOAT", flipped.size, flipped.ravel())
            self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
            self._drawn = image
        gpu.state.blend_set("ALPHA_PREMULT")
        self.engine.bind_display_space_shader(depsgraph.scene)
        draw_texture_2d(self._texture, (0, 0), region.width, region.height)
        self.engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
