# SPDX-License-Identifier: Apache-2.0
"""Lights of Blender as lights of Gnomon."""
from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from . import units
from .nodes import Evaluator, followed


@dataclass
class MadeLight:
    """A light: values of gnomon.Light, or of gnomon.AreaLight if it has a size."""

    kind: str
    """'light' or 'area'."""
    values: dict
    scale: tuple = (1.0, 1.0, 1.0)
    """Of its node, for ellipses."""
    sun_angle: float = 0.0

    def fixed(self) -> tuple:
        """What cannot change without another light."""
        shape = {k: v for k, v in self.values.items() if k not in {"radiance", "color", "inner_angle", "outer_angle"}}
        return self.kind, tuple(sorted((k, repr(v)) for k, v in shape.items())), self.scale


def _emission(light, evaluator: Evaluator) -> np.ndarray:
    """What the nodes of a light multiply its power by."""
    if not light.use_nodes or light.node_tree is None:
        return np.ones(3)
    end = light.node_tree.get_output_node("CYCLES") or light.node_tree.get_output_node("ALL")
    node = None if end is None else followed(end.inputs["Surface"])[0]
    if node is None:
        return np.zeros(3)
    if node.type != "EMISSION":
        evaluator.warn(f"the shader '{node.bl_label}' of a light is not known, and taken as its own colour")
        return np.ones(3)
    strength, _ = followed(node.inputs["Strength"])
    if strength is not None and strength.type == "LIGHT_FALLOFF":
        evaluator.warn("a light falls off by the square of the distance, whatever its nodes say")
        factor = evaluator.scalar(strength.inputs["Strength"])
    else:
        factor = evaluator.scalar(node.inputs["Strength"])
    return evaluator.plain(node.inputs["Color"])[:3] * factor


def read_light(light, evaluator: Evaluator, warn: Callable[[str], None]) -> Optional[MadeLight]:
    """What a light is in Gnomon; None: it gives no light."""
    color = np.array(light.color) * _emission(light, evaluator)
    watts = float(light.energy)
    if watts < 0 or (color < 0).any():
        warn("negative light is left out")
        return None
    name = light.name_full
    if light.type == "POINT":
        radius = float(light.shadow_soft_size)
        if radius <= 0:
            return MadeLight("light", {"name": name, "type": "point", "color": units.point_intensity(color, watts)})
        return MadeLight("area", {"name": name, "shape": "sphere", "width": 2 * radius, "height": 2 * radius,
                                  "radiance": units.sphere_radiance(color, watts, radius), "hidden_from_camera": True})
    if light.type == "SPOT":
        outer = 0.5 * float(light.spot_size)
        # Blender's smooth step ends at this share between the cosine of the cone's angle and 1.
        inner = math.acos(min(1.0, math.cos(outer) + (1 - math.cos(outer)) * max(float(light.spot_blend), 1e-4)))
        radius = float(light.shadow_soft_size)
        if radius > 0:
            return MadeLight("area", {"name": name, "shape": "sphere", "width": 2 * radius, "height": 2 * radius,
                                      "radiance": units.sphere_radiance(color, watts, radius), "hidden_from_camera": True,
                                      "inner_angle": inner, "outer_angle": outer})
        return MadeLight("light", {"name": name, "type": "spot", "color": units.point_intensity(color, watts),
                                   "profile": "smooth-cosine", "inner_angle": inner, "outer_angle": outer})
    if light.type == "SUN":
        return MadeLight("light", {"name": name, "type": "directional", "color": units.sun_irradiance(color, watts)},
                         sun_angle=float(light.angle))
    return _area(light, name, color, watts, warn)


def _area(light, name: str, color: np.ndarray, watts: float, warn: Callable[[str], None]) -> MadeLight:
    if getattr(light, "spread", math.pi) < 0.99 * math.pi:
        warn("the spread of an area light is left out")
    width = float(light.size)
    height = float(light.size_y) if light.shape in {"RECTANGLE", "ELLIPSE"} else width
    is_round = light.shape in {"DISK", "ELLIPSE"}
    area = width * height * (math.pi / 4 if is_round else 1)
    values: dict[str, Any] = {"name": name, "shape": "disc" if is_round else "rectangle", "width": width,
                              "height": width if is_round else height,
                              "radiance": units.area_radiance(color, watts, area), "hidden_from_camera": True}
    return MadeLight("area", values, (1.0, height / width, 1.0) if is_round else (1.0, 1.0, 1.0))


def stretched_area(made: MadeLight, matrix: np.ndarray) -> MadeLight:
    """The same light under the scale of its object, which changes the size and keeps the power."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if made.kind != "area" or np.allclose(lengths, 1, atol=1e-6):
        return made
    if made.values["shape"] == "sphere":
        return made   # Blender's point lights do not scale
    sx, sy = float(lengths[0]), float(lengths[1])
    values = dict(made.values)
    values["width"] = made.values["width"] * sx
    scale = made.scale
    if values["shape"] == "disc":
        scale = (1.0, made.scale[1] * sy / sx, 1.0)
        values["height"] = values["width"]
    else:
        values["height"] = made.values["height"] * sy
    values["radiance"] = tuple(c / (sx * sy) for c in made.values["radiance"])
    return MadeLight(made.kind, values, scale)


def without_scale(matrix: np.ndarray) -> np.ndarray:
    """A matrix whose axes have unit length."""
    result = matrix.copy()
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    result[:3, :3] /= np.where(lengths > 0, lengths, 1)
    return result
