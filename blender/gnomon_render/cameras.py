# SPDX-License-Identifier: Apache-2.0
"""Cameras of Blender: projection, lens and shutter."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Optional

import gnomon
import numpy as np

from . import units
from .lights import without_scale

LARGEST_APERTURE = 10000.0   # millimetres, of the option


@dataclass
class MadeCamera:
    """A camera, as Camera(matrix=projection, transform=to_world)."""

    projection: np.ndarray
    to_world: np.ndarray
    options: dict = field(default_factory=dict)
    """RenderOptions of its lens."""

    def camera(self) -> gnomon.Camera:
        return gnomon.Camera(transform=self.to_world, matrix=self.projection)


def render_size(render) -> tuple:
    """(width, height) of the whole image."""
    share = render.resolution_percentage / 100
    return max(1, int(render.resolution_x * share)), max(1, int(render.resolution_y * share))


def render_region(render) -> Optional[tuple]:
    """(x, y, width, height) of the region that is rendered, from the lower left; None: all."""
    if not render.use_border:
        return None
    width, height = render_size(render)
    x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
    y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
    return x0, y0, max(1, x1 - x0), max(1, y1 - y0)


def zoomed(projection: np.ndarray, size: tuple, region: Optional[tuple]) -> np.ndarray:
    """The projection of a region of the image."""
    if region is None:
        return projection
    (width, height), (x, y, w, h) = size, region
    zoom = np.eye(4)
    zoom[0, 0], zoom[1, 1] = width / w, height / h
    zoom[0, 3] = (width - 2 * x - w) / w
    zoom[1, 3] = (height - 2 * y - h) / h
    return zoom @ projection


def read_camera(camera, render, depsgraph, region: Optional[tuple], warn: Callable[[str], None]) -> MadeCamera:
    """The camera object of a final render."""
    width, height = render_size(render)
    data = camera.data
    if data.type == "PANO":
        warn(f"the camera '{camera.name}' is a panorama, and rendered as a perspective")
    projection = np.array(camera.calc_matrix_camera(depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x,
                                                    scale_y=render.pixel_aspect_y), dtype=float)
    matrix = without_scale(units.to_y_up(camera.matrix_world))
    made = MadeCamera(zoomed(projection, (width, height), region), matrix)
    made.options = lens_options(camera, warn)
    return made


def lens_options(camera, warn: Callable[[str], None]) -> dict:
    """Depth of field of a camera object."""
    data = camera.data
    none = {"aperture": 0.0, "focus": None}
    if not data.dof.use_dof:
        return none
    if data.dof.aperture_blades > 2 or data.dof.aperture_ratio != 1:
        warn("the aperture is a circle")
    focus = float(data.dof.focus_distance)
    if data.dof.focus_object is not None:
        to_camera = np.linalg.inv(np.array(camera.matrix_world.normalized(), dtype=float))
        place = np.array(data.dof.focus_object.matrix_world, dtype=float)[:, 3]
        focus = abs(float((to_camera @ place)[2]))
    # The lens's diameter is its focal length divided by the f-number, whatever the sensor. Cycles takes a focal length of
    # a metre for orthographic cameras.
    focal_length = 1000.0 if data.type == "ORTHO" else float(data.lens)
    return {"aperture": min(focal_length / max(float(data.dof.aperture_fstop), 1e-6), LARGEST_APERTURE),
            "focus": max(focus, 1e-4)}


def view_camera(region3d, size: tuple, space, depsgraph, warn: Callable[[str], None]) -> MadeCamera:
    """What a 3D viewport shows."""
    view = np.array(region3d.view_matrix, dtype=float)
    to_world = without_scale(units.Y_UP @ np.linalg.inv(view))
    made = MadeCamera(np.array(region3d.window_matrix, dtype=float), to_world, {"aperture": 0.0, "focus": None})
    if region3d.view_perspective == "CAMERA" and space.camera is not None and space.camera.type == "CAMERA":
        made.options = lens_options(space.camera.evaluated_get(depsgraph), warn)
    return made
