# SPDX-License-Identifier: Apache-2.0
"""The world: a colour or an environment image around the scene."""
from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Optional

import numpy as np

from .images import ImageCache, Mapping
from .nodes import Evaluator, followed
from .units import LUMENS_PER_WATT


@dataclass
class MadeWorld:
    pixels: Optional[np.ndarray]
    """(height, width, 3): radiance in nits, its centre towards Gnomon's -Z; None: it is dark."""


def read_world(world, images: ImageCache, frame: int, warn: Callable[[str], None]) -> MadeWorld:
    """The light of a world of Blender, or of None."""
    if world is None:
        return MadeWorld(None)
    if not world.use_nodes or world.node_tree is None:
        return _even(np.array(world.color))
    end = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
    if end is None:
        return MadeWorld(None)
    if end.inputs["Volume"].is_linked:
        warn("the world's volume is left out")
    node, _ = followed(end.inputs["Surface"])
    if node is None:
        return MadeWorld(None)
    if node.type == "MIX_SHADER":
        warn("of a world that mixes, the second shader is taken")
        node, _ = followed(node.inputs[2])
    if node is None or node.type not in {"BACKGROUND", "EMISSION"}:
        warn("a world without a background shader is dark")
        return MadeWorld(None)
    evaluator = Evaluator(images, frame, warn)
    strength = evaluator.scalar(node.inputs["Strength"])
    source, _ = followed(node.inputs["Color"])
    if source is not None and source.type == "TEX_ENVIRONMENT" and source.image is not None:
        if source.projection != "EQUIRECTANGULAR":
            warn("an environment image that is a mirror ball is taken as equirectangular")
        image_map = images.image_map(source.image, Mapping(), frame)
        if image_map is not None:
            turned = _turned(image_map.pixels[..., :3], _rotation(source, evaluator))
            return MadeWorld(np.ascontiguousarray(turned * (strength * LUMENS_PER_WATT), dtype=np.float32))
        warn(f"the image '{source.image.name}' cannot be read")
    if source is not None and source.type == "TEX_SKY":
        warn("a sky texture is taken as an even sky; an environment image has its effect")
        return _even(np.array([0.3, 0.45, 0.7]) * strength)
    return _even(evaluator.plain(node.inputs["Color"])[:3] * strength)


def _even(color: np.ndarray) -> MadeWorld:
    if not color.any():
        return MadeWorld(None)
    return MadeWorld(np.broadcast_to(np.maximum(color, 0) * LUMENS_PER_WATT, (4, 8, 3)).astype(np.float32))


def _rotation(node, evaluator: Evaluator) -> np.ndarray:
    """(3, 3): from directions of the world to those at which the image is read."""
    source, _ = followed(node.inputs["Vector"])
    if source is None or source.type == "TEX_COORD":
        return np.eye(3)
    if source.type != "MAPPING":
        evaluator.warn(f"the node '{source.bl_label}' of the world is left out")
        return np.eye(3)
    import mathutils

    turn = mathutils.Euler(evaluator.plain(source.inputs["Rotation"])[:3], "XYZ").to_matrix()
    if "Scale" in source.inputs and not np.allclose(evaluator.plain(source.inputs["Scale"])[:3], 1):
        evaluator.warn("the world's image is turned, not scaled")
    matrix = np.array(turn)
    return matrix.T if source.vector_type == "TEXTURE" else matrix


def _turned(pixels: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """An image of Blender (its centre towards +X) as Gnomon has it (towards -Z, which is Blender's +Y)."""
    height, width, _ = pixels.shape
    about_z = np.allclose(rotation[2], [0, 0, 1], atol=1e-6)
    angle = math.atan2(rotation[1, 0], rotation[0, 0])
    columns = (angle / (2 * math.pi)) * width + width / 4
    if about_z and abs(columns - round(columns)) < 1e-4:
        return np.roll(pixels, round(columns), axis=1)
    # Read the image in each direction, between four pixels.
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    around, up = (x - 0.5) * 2 * np.pi, (0.5 - y) * np.pi
    direction = np.stack([np.sin(around) * np.cos(up), np.cos(around) * np.cos(up), np.sin(up)], axis=-1)
    d = direction @ rotation.T
    u = 0.5 - np.arctan2(d[..., 1], d[..., 0]) / (2 * np.pi)
    v = 0.5 - np.arcsin(np.clip(d[..., 2], -1, 1)) / np.pi
    px, py = u * width - 0.5, np.clip(v * height - 0.5, 0, height - 1)
    x0, y0 = np.floor(px).astype(int), np.floor(py).astype(int)
    fx, fy = (px - x0)[..., None], (py - y0)[..., None]
    y1 = np.minimum(y0 + 1, height - 1)
    left, right = x0 % width, (x0 + 1) % width
    return ((pixels[y0, left] * (1 - fx) + pixels[y0, right] * fx) * (1 - fy)
            + (pixels[y1, left] * (1 - fx) + pixels[y1, right] * fx) * fy)
