# SPDX-License-Identifier: Apache-2.0
"""Cameras, and the conventions by which they are described.

Matrices are for column vectors, as numpy arrays of 4 x 4: a point p of the inner space is at `(matrix @ [*p, 1])[:3]` in
the outer one, and `outer @ inner` (or compose(outer, inner)) applies `inner`
first. Wherever a matrix is taken, the last row 0 0 0 1 may be left out.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Optional

import numpy as np
import numpy.typing as npt

from ._errors import UsageError
from ._gnomon import inverse
from ._parts import Size

Matrix = npt.ArrayLike
"""(4, 4) or (3, 4) numbers."""


def _pose(matrix: Matrix, name: str) -> npt.NDArray[np.float64]:
    """A matrix of 3 x 4 or 4 x 4 as one of 4 x 4."""
    rows = np.asarray(matrix, dtype=float)
    if rows.shape not in ((3, 4), (4, 4)):
        raise UsageError(f"{name} has the shape {rows.shape}; expected (3, 4) or (4, 4)")
    whole = np.eye(4)
    whole[: rows.shape[0]] = rows
    return whole


def _camera_to_world(world_to_camera: Optional[Matrix], camera_to_world: Optional[Matrix]) -> npt.NDArray[np.float64]:
    if world_to_camera is not None and camera_to_world is not None:
        raise UsageError("a camera has either world_to_camera or camera_to_world")
    if world_to_camera is not None:
        pose = _pose(world_to_camera, "world_to_camera")
        return inverse(pose)
    return np.eye(4) if camera_to_world is None else _pose(camera_to_world, "camera_to_world")


@dataclass(slots=True)
class Intrinsics:
    """Focal lengths and principal point in pixels. Pixel centres are at (0.5, 0.5) from the upper left corner."""

    fx: float
    fy: float
    cx: float
    cy: float
    size: Size = (0, 0)
    """(width, height) of the image that these pixels belong to; (0, 0): of the rendered image."""


@dataclass(slots=True, eq=False)
class Camera:
    """A camera. It looks along the -Z of its space, with +Y up, as glTF's and OpenGL's cameras do; from_opencv() takes the
    other common convention.

    The first of `matrix`, `intrinsics` and `orthographic_height` that is given decides the projection; otherwise it is a
    perspective by `vertical_fov`."""

    name: str = ""
    transform: Optional[Matrix] = None
    """(4, 4) or (3, 4): from camera space to the world, or to its node's parent in a scene. None: the identity."""
    vertical_fov: float = 0.8
    """Whole angle in radians; the width follows from the image."""
    orthographic_height: Optional[float] = None
    """Metres."""
    intrinsics: Optional[Intrinsics] = None
    matrix: Optional[Matrix] = None
    """(4, 4): from camera space to clip space, as OpenGL has it; also decides `near` and `far`."""
    shift_x: float = 0.0
    """Moves the image plane to the right, as a fraction of the image's height."""
    shift_y: float = 0.0
    """The same, up."""
    near: float = 0.01
    """Metres along the view axis."""
    far: float = 0.0
    """Metres along the view axis; 0: unlimited."""
    resolution: Size = (0, 0)
    """(width, height) at which it is rendered if RenderOptions.size gives none; (0, 0): 1280 x 720."""

    @classmethod
    def from_opencv(cls, camera_matrix: npt.ArrayLike, *, world_to_camera: Optional[Matrix] = None,
                    camera_to_world: Optional[Matrix] = None, size: Size = (0, 0),
                    pixel_centers: Literal["integer", "half"] = "integer", **more: Any) -> Camera:
        """A camera by OpenCV's conventions: it looks along +Z, with +X to the right and +Y down.

        camera_matrix    (3, 3): [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels; distortion is not supported
        world_to_camera  (3, 4) or (4, 4): the extrinsics [R | t]
        camera_to_world  its inverse, instead of it; neither: the camera is at the origin
        size             (width, height) of the image that these pixels belong to, which is also rendered if
                         RenderOptions.size gives none; an image of another size has the same view, scaled
        pixel_centers    'integer': the centre of the first pixel is (0, 0), as OpenCV has it; 'half': it is (0.5, 0.5)
        more             other fields: name, near, far

        A point p of the world is seen at `camera_matrix @ ([R | t] @ [*p, 1])`, divided by its third coordinate."""
        k = np.asarray(camera_matrix, dtype=float)
        if k.shape != (3, 3):
            raise UsageError(f"camera_matrix has the shape {k.shape}; expected (3, 3)")
        if not np.allclose(k[2], [0, 0, 1]) or k[1, 0] != 0:
            raise UsageError("camera_matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        if k[0, 1] != 0:
            raise UsageError("camera_matrix must not be skewed")
        if pixel_centers not in ("integer", "half"):
            raise UsageError(f"pixel_centers: no value '{pixel_centers}'; there are 'integer', 'half'")
        half = 0.5 if pixel_centers == "integer" else 0.0
        # OpenCV's camera is turned by half a turn about X: y down and z forward become y up and z back.
        pose = _camera_to_world(world_to_camera, camera_to_world) * [1.0, -1.0, -1.0, 1.0]
        lens = Intrinsics(float(k[0, 0]), float(k[1, 1]), float(k[0, 2]) + half, float(k[1, 2]) + half, size)
        fields: dict[str, Any] = {"resolution": size, **more}
        return cls(transform=pose, intrinsics=lens, **fields)

    @classmethod
    def from_gltf(cls, yfov: float, *, camera_to_world: Optional[Matrix] = None,
                  world_to_camera: Optional[Matrix] = None, znear: float = 0.01, zfar: Optional[float] = None,
                  **more: Any) -> Camera:
        """A perspective camera by glTF's conventions: it looks along -Z, with +X to the right and +Y up.

        yfov             the whole vertical angle, radians; the width follows from the image
        camera_to_world  (3, 4) or (4, 4): the global matrix of the camera's node; None: the identity
        world_to_camera  its inverse (the view matrix), instead of it
        znear, zfar      metres along the view axis; zfar=None: unlimited
        more             other fields: name, resolution"""
        return cls(transform=_camera_to_world(world_to_camera, camera_to_world), vertical_fov=yfov, near=znear,
                   far=zfar or 0.0, **more)
