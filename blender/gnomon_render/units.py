# SPDX-License-Identifier: Apache-2.0
"""Units and axes: Blender measures light in watts and has Z up; Gnomon has candela, lux and nits, and Y up.

Blender's watts are radiant power. Gnomon's quantities are photometric; 683 lumens per watt, which is also the factor of
Blender's glTF exporter, relates the two. Rendered images are divided by it again, so that their values are the ones that
Cycles has: 1 is the radiance of a background of strength 1.

What a light of power P emits (in W, as Cycles has it):
    point, spot   radiant intensity P / (4 pi); with a radius r, radiance P / (4 pi^2 r^2)
    sun           irradiance P
    area          radiance P / (4 A)
"""
from __future__ import annotations

import math

import numpy as np

LUMENS_PER_WATT = 683.0
STOPS = -math.log2(LUMENS_PER_WATT)
"""The exposure at which Gnomon shows what Blender shows at 0."""

# Blender's (x, y, z) is Gnomon's (x, z, -y). Only signs and places change, so nothing is rounded.
Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)


def to_y_up(matrix) -> np.ndarray:
    """(4, 4): the matrix to Gnomon's world of one to Blender's."""
    return Y_UP @ np.array(matrix, dtype=float)


def from_y_up(vectors: np.ndarray) -> np.ndarray:
    """(..., 3): vectors of Gnomon's world in Blender's."""
    return np.stack([vectors[..., 0], -vectors[..., 2], vectors[..., 1]], axis=-1)


def point_intensity(color, watts: float) -> tuple:
    """Candela of a point or spot light."""
    return tuple(c * watts * LUMENS_PER_WATT / (4 * math.pi) for c in color)


def sphere_radiance(color, watts: float, radius: float) -> tuple:
    """Nits of a point light with a radius."""
    return tuple(c * watts * LUMENS_PER_WATT / (4 * math.pi * math.pi * radius * radius) for c in color)


def sun_irradiance(color, strength: float) -> tuple:
    """Lux of a sun."""
    return tuple(c * strength * LUMENS_PER_WATT for c in color)


def area_radiance(color, watts: float, area: float) -> tuple:
    """Nits of an area light."""
    return tuple(c * watts * LUMENS_PER_WATT / (4 * area) for c in color)


def emitted(color) -> tuple:
    """Nits of what Blender gives as radiance, such as emission and the world's colour."""
    return tuple(c * LUMENS_PER_WATT for c in color)
