# SPDX-License-Identifier: Apache-2.0
"""Passes of Blender's compositor from the layers of a frame."""
from __future__ import annotations

from collections.abc import Callable

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


def register_passes(engine, view_layer) -> None:
    """Tells Blender which passes a render of the layer has."""
    scene = view_layer.id_data
    engine.register_pass(scene, view_layer, "Combined", 4, "RGBA", "COLOR")
    for flag, name, channels, kind in PASSES:
        if getattr(view_layer, flag):
            engine.register_pass(scene, view_layer, name, len(channels), channels, kind)


def wanted_options(view_layer) -> dict:
    """Members of gnomon.RenderOptions that the passes need."""
    layers = any(getattr(view_layer, flag) for flag in ("use_pass_z", "use_pass_normal", "use_pass_diffuse_color",
                                                        "use_pass_shadow"))
    return {"layers": layers, "ids": view_layer.use_pass_object_index, "motion": view_layer.use_pass_vector}


def combined(frame) -> np.ndarray:
    """(height, width, 4): radiance as Cycles has it, with associated alpha."""
    color = frame.color
    result = np.empty((*color.shape[:2], 4), dtype=np.float32)
    np.multiply(color, np.float32(1 / LUMENS_PER_WATT), out=result[..., :3])
    result[..., 3] = frame.alpha if "alpha" in frame.layers else 1
    return result


def values_of(frame, name: str, index_of: Callable) -> np.ndarray:
    """(height, width, channels): a pass. Normals are Blender's, and so are the signs of vectors.

    index_of(ids)  the indices of the objects that the layer of ids shows"""
    if name == "Depth":
        depth = frame.depth
        return np.where(depth > 0, depth, np.float32(FAR))[..., None]
    if name == "Normal":
        return from_y_up(frame.normal)
    if name == "Vector":
        # Where the point was minus where it is, upwards, and where it is minus where it will be if it goes on so.
        motion = frame.motion
        back = np.stack([-motion[..., 0], motion[..., 1]], axis=-1)
        return np.concatenate([back, back], axis=-1)
    if name == "IndexOB":
        return index_of(frame.object_ids)[..., None]
    if name == "DiffCol":
        return frame.albedo
    if name == "Shadow":
        shadow = frame.shadow
        lit = shadow.mean(axis=-1, keepdims=True) if shadow.shape[-1] else np.ones((*shadow.shape[:2], 1), np.float32)
        return np.repeat(lit, 3, axis=-1)
    raise KeyError(name)


def store(render_pass, values: np.ndarray) -> None:
    """Writes a pass, whose rows Blender has from the bottom."""
    flat = np.ascontiguousarray(values[::-1], dtype=np.float32).reshape(-1, values.shape[-1])
    render_pass.rect.foreach_set(flat)
