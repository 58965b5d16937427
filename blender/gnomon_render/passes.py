# SPDX-License-Identifier: Apache-2.0
"""Passes of Blender's compositor from the layers of a frame."""
from __future__ import annotations

import numpy as np

from .units import LUMENS_PER_WATT, from_y_up

FAR = 1e10
"""Depth where nothing is seen, as Cycles has it."""

PASSES = (
    # property of a view layer, name, channels, type
    ("use_pass_z", "Depth", "Z", "VALUE"),
    ("use_pass_normal", "Normal", "XYZ", "VECTOR"),
    ("use_pass_vector", "Vector", "XYZW", "VECTOR"),
    ("use_pass_object_index", "IndexOB", "X", "VALUE"),
    ("use_pass_diffuse_color", "DiffCol", "RGB", "COLOR"),
    ("use_pass_shadow", "Shadow", "RGB", "COLOR"),
)


def register_passes(engine, scene, view_layer) -> None:
    """Tells Blender which passes a render of the layer has."""
    engine.register_pass(scene, view_layer, "Combined", 4, "RGBA", "COLOR")
    for flag, name, channels, kind in PASSES:
        if getattr(view_layer, flag):
            engine.register_pass(scene, view_layer, name, len(channels), channels, kind)


def wanted_options(view_layer) -> dict:
    """Members of gnomon.RenderOptions that the passes need."""
    layers = any(getattr(view_layer, flag) for flag in ("use_pass_z", "use_pass_normal", "use_pass_diffuse_color",
                                                        "use_pass_shadow"))
    return {"layers": layers, "ids": view_layer.use_pass_object_index or view_layer.use_pass_diffuse_color,
            "motion": view_layer.use_pass_vector}


def combined(frame) -> np.ndarray:
    """(height, width, 4): radiance as Cycles has it, with associated alpha."""
    color = frame.color
    result = np.empty((*color.shape[:2], 4), dtype=np.float32)
    np.multiply(color, np.float32(1 / LUMENS_PER_WATT), out=result[..., :3])
    result[..., 3] = frame.alpha if "alpha" in frame.layers else 1
    return result


def values_of(frame, name: str) -> np.ndarray:
    """(height, width, channels): depth, or normals of Blender's world."""
    if name == "Depth":
        depth = frame.depth
        return np.where(depth > 0, depth, np.float32(FAR))[..., None]
    if name == "Normal":
        return from_y_up(frame.normal)
    raise KeyError(name)


def vectors(frame, ahead: np.ndarray) -> np.ndarray:
    """(height, width, 4): where a point was minus where it is, and where it is minus where it will be, in pixels to the
    right and up."""
    behind = frame.motion
    return np.stack([-behind[..., 0], behind[..., 1], ahead[..., 0], -ahead[..., 1]], axis=-1)


def diffuse_color(frame, reflectances: dict) -> np.ndarray:
    """(height, width, 3): what diffuse reflection multiplies light by.

    reflectances  {value of the layer of materials: (share of metal, reflectance of what is not metal, share of glass)}"""
    ids = frame.material_ids
    values, index = np.unique(ids, return_inverse=True)
    table = np.array([reflectances.get(int(value), (0.0, 0.0, 0.0)) for value in values], dtype=np.float32)
    metal, specular, glass = (table[index].reshape(*ids.shape, 3)[..., i:i + 1] for i in range(3))
    # The albedo is base (1 - metal) + specular (1 - metal) + base metal.
    base = np.maximum(frame.albedo - specular * (1 - metal), 0)
    return base * (1 - metal) * (1 - glass)


def shadow(frame, channels: list) -> np.ndarray:
    """(height, width, 3): the share of lights that reach a point, of those without size."""
    values = frame.shadow
    if not channels:
        return np.ones((*values.shape[:2], 3), dtype=np.float32)
    return np.repeat(values[..., channels].mean(axis=-1, keepdims=True), 3, axis=-1)


def store(render_pass, values: np.ndarray) -> None:
    """Writes a pass, whose rows Blender has from the bottom."""
    flat = np.ascontiguousarray(values[::-1], dtype=np.float32).reshape(-1, values.shape[-1])
    render_pass.rect.foreach_set(flat)
