# SPDX-License-Identifier: Apache-2.0
"""Meshes that the examples share, as arrays of numpy: each function returns (positions, triangles, normals)."""
import math

import numpy as np
import numpy.typing as npt

import gnomon

Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64], npt.NDArray[np.float64]]


def lathe(profile: list[tuple[float, float, float, float]], around: int = 48) -> Arrays:
    """Turns a profile of (radius, height, normal outwards, normal upwards) about the Y axis, from the bottom up.

    Where the radius is 0, triangles of a row meet in a point, and those without an area are left out."""
    rows, columns = len(profile), around + 1
    turn = [2 * math.pi * k / around for k in range(columns)]
    directions = np.array([[math.cos(t), 0, -math.sin(t)] for t in turn])
    up = np.array([0.0, 1.0, 0.0])
    positions = np.array([r * d + y * up for r, y, _, _ in profile for d in directions])
    normals = np.array([n * d + m * up for _, _, n, m in profile for d in directions])
    corner = np.arange(rows * columns).reshape(rows, columns)
    low, next_low, high, next_high = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
    quads = np.stack([low, next_low, next_high, low, next_high, high], axis=-1)
    a, b, c = (positions[quads.reshape(-1, 3)[:, k]] for k in range(3))
    has_area = (a != b).any(axis=1) & (b != c).any(axis=1) & (c != a).any(axis=1)
    return positions, quads.reshape(-1, 3)[has_area], normals


def sphere(radius: float = 1.0, rings: int = 24) -> Arrays:
    """A smooth sphere about the origin."""
    angles = [-math.pi / 2 + math.pi * i / rings for i in range(rings + 1)]
    profile = [(radius * math.cos(a), radius * math.sin(a), math.cos(a), math.sin(a)) for a in angles[1:-1]]
    return lathe([(0, -radius, 0, -1), *profile, (0, radius, 0, 1)], 2 * rings)


def cylinder(radius: float = 1.0, height: float = 1.0, around: int = 48) -> Arrays:
    """A cylinder that stands on the origin, with flat ends."""
    return lathe([(0, 0, 0, -1), (radius, 0, 0, -1), (radius, 0, 1, 0), (radius, height, 1, 0),
                  (radius, height, 0, 1), (0, height, 0, 1)], around)


def cone(radius: float = 1.0, height: float = 1.0, around: int = 48) -> Arrays:
    """A cone that stands on the origin."""
    slant = math.hypot(radius, height)
    side = (height / slant, radius / slant)
    return lathe([(0, 0, 0, -1), (radius, 0, 0, -1), (radius, 0, *side), (0, height, *side)], around)


def torus(radius: float = 1.0, tube: float = 0.3, around: int = 64) -> Arrays:
    """A torus about the Y axis, around the origin."""
    angles = [2 * math.pi * i / 32 for i in range(33)]
    return lathe([(radius + tube * math.cos(a), tube * math.sin(a), math.cos(a), math.sin(a)) for a in angles], around)


def box(width: float = 1.0, height: float = 1.0, depth: float = 1.0) -> Arrays:
    """A box about the origin, with flat faces."""
    positions, normals = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                corner = [0.0, 0.0, 0.0]
                corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = side, a * side, b
                positions.append(corner)
                normal = [0.0, 0.0, 0.0]
                normal[axis] = side
                normals.append(normal)
    first = 4 * np.arange(6)[:, None, None]
    triangles = first + np.array([[0, 1, 2], [0, 2, 3]])
    return np.array(positions) * [width / 2, height / 2, depth / 2], triangles.reshape(-1, 3), np.array(normals)


def add(builder: gnomon.SceneBuilder, arrays: Arrays, name: str = "") -> gnomon.MeshId:
    """Adds such a mesh to a scene."""
    positions, triangles, normals = arrays
    return builder.mesh(positions, triangles, normals=normals, name=name)


def paint(builder: gnomon.SceneBuilder, red: float, green: float, blue: float, roughness: float = 0.6,
          metallic: float = 0.0) -> gnomon.MaterialId:
    """A surface of one linear colour."""
    return builder.material(gnomon.Material(base_color=(red, green, blue), roughness=roughness, metallic=metallic))


def sky(builder: gnomon.SceneBuilder, brightness: float = 1.0) -> None:
    """A plain sky, brightest at the horizon, above a ground of warm grey."""
    height = np.linspace(1, -1, 64)[:, None, None]
    above = np.array([0.35, 0.5, 0.8]) * (1 - height) + np.array([0.16, 0.3, 0.62]) * height + 0.25 * (1 - height) ** 4
    below = np.array([0.22, 0.2, 0.18])
    builder.environment(np.repeat(brightness * np.where(height > 0, above, below), 128, axis=1), lights=32)
