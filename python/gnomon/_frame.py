# SPDX-License-Identifier: Apache-2.0
"""Rendered frames: what can be computed of their layers."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _gnomon
from ._errors import UsageError


class Frame(_gnomon.Frame):
    __doc__ = _gnomon.Frame.__doc__

    def project(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Where points of the world are in the image.

        points  (n, 3), or one point: (3,)

        Returns (n, 3) or (3,): x and y in pixels from the upper left corner (pixel centres are at 0.5), and the distance
        along the camera's axis in metres. Behind a perspective camera, x and y are NaN."""
        p = np.asarray(points, dtype=float)
        if p.ndim not in (1, 2) or p.shape[-1] != 3:
            raise UsageError(f"points has the shape {p.shape}; expected (n, 3) or (3,)")
        whole = np.concatenate([p, np.ones(p.shape[:-1] + (1,))], axis=-1)
        image = whole @ self.world_to_image.T
        w = np.where(image[..., 3:] > 0, image[..., 3:], np.nan)
        depth = -(whole @ self.world_to_camera.T)[..., 2:3]
        return np.concatenate([image[..., :2] / w * np.array(self.size, dtype=float), depth], axis=-1)

    def points(self) -> npt.NDArray[np.float64]:
        """(height, width, 3): what each pixel's centre shows, in world space, metres; NaN where it shows nothing.

        Needs RenderOptions.layers. It is computed from `depth`, in double precision."""
        depth = self.depth
        height, width = depth.shape
        x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
        # Two points on the ray through each pixel's centre, in the camera's space, whose depths differ.
        image_to_camera = self.world_to_camera @ np.linalg.inv(self.world_to_image)
        ends = []
        for z in (0.25, 0.75):
            end = np.stack([x, y, np.full_like(x, z), np.ones_like(x)], axis=-1) @ image_to_camera.T
            ends.append(end[..., :3] / end[..., 3:])
        first, second = ends
        share = (-depth.astype(float) - first[..., 2]) / (second[..., 2] - first[..., 2])
        in_camera = first + share[..., None] * (second - first)
        in_camera[depth == 0] = np.nan
        camera_to_world = np.linalg.inv(self.world_to_camera)
        points: npt.NDArray[np.float64] = in_camera @ camera_to_world[:3, :3].T + camera_to_world[:3, 3]
        return points
