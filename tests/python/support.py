# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python package share: a room with a ball, and memory in use."""
from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gnomon

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("GNOMON_PROGRAM", "")

# A square of side 2 in the plane z = 0, seen from +Z.
SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32)
TWO_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
# An octahedron, which has a front on every side.
OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
EIGHT_TRIANGLES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


@dataclass
class Room:
    """A wall at z = -1, a ball before it that may deform, and a light."""

    builder: gnomon.SceneBuilder
    scene: gnomon.Scene
    wall: gnomon.InstanceId
    ball: gnomon.InstanceId
    light: gnomon.LightId
    paint: gnomon.MaterialId
    camera: gnomon.Camera


def make_room(mobility="may_deform") -> Room:
    builder = gnomon.SceneBuilder()
    paint = builder.material(gnomon.Material(name="paint", base_color=(0.5, 0.1, 0.1)))
    wall = builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES), None,
                            gnomon.compose(gnomon.translation(0, 0, -1), gnomon.scaling(4)), name="wall")
    ball = builder.instance(builder.mesh(OCTAHEDRON, EIGHT_TRIANGLES), paint, gnomon.scaling(0.3), mobility=mobility,
                            name="ball")
    light = builder.light(gnomon.Light(name="bulb", color=(30, 30, 30)), gnomon.translation(1.2, 2, 3))
    camera = gnomon.Camera(transform=gnomon.translation(0, 0, 4), vertical_fov=0.8)
    builder.camera(camera)
    return Room(builder, builder.finish(), wall, ball, light, paint, camera)


def resident_bytes() -> int:
    """Memory of this process that is in use, without what is mapped and was not touched."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
