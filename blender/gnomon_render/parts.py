# SPDX-License-Identifier: Apache-2.0
"""What a scene of Gnomon has of a dependency graph, and what changes from frame to frame."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import gnomon
import numpy as np

from . import geometry, lights
from .materials import Made


@dataclass
class MaterialPart:
    id: Any
    made: Made
    signature: tuple
    textures: set


@dataclass
class MeshPart:
    id: Any
    topology: bytes
    shape: bytes
    deforms: bool
    vertices: Optional[gnomon.Vertices] = None
    """Those in force, if it deforms."""
    users: set = field(default_factory=set)

    def holds(self, made: geometry.Geometry) -> bool:
        return made.topology() == self.topology and made.shape() == self.shape


@dataclass
class InstancePart:
    id: Any
    mesh: tuple
    source: str
    """The object, by name."""
    matrix: np.ndarray
    visible: bool = True


@dataclass
class LightPart:
    node: Any
    made: lights.MadeLight
    fixed: tuple
    light: Any = None
    material: Any = None
    matrix: Optional[np.ndarray] = None
    visible: bool = True


@dataclass
class Changes:
    """What the next frame hands over to the renderer."""

    transforms: dict = field(default_factory=dict)
    visibility: dict = field(default_factory=dict)
    vertices: dict = field(default_factory=dict)
    lights: dict = field(default_factory=dict)
    materials: dict = field(default_factory=dict)

    def each(self) -> tuple:
        return self.transforms, self.visibility, self.vertices, self.lights, self.materials

    def count(self) -> int:
        return sum(len(each) for each in self.each())

    def drop(self, removed: set) -> None:
        """Forgets what belongs to parts that are gone."""
        for values in self.each():
            for key in [key for key in values if key in removed]:
                del values[key]


@dataclass
class Updates:
    """Names of what a dependency graph has evaluated again; None in place of them: everything."""

    transforms: set = field(default_factory=set)
    geometry: set = field(default_factory=set)
    shading: set = field(default_factory=set)
    images: set = field(default_factory=set)
    world: bool = False
    everything: bool = False

    @classmethod
    def of(cls, depsgraph) -> Updates:
        made = cls()
        for update in depsgraph.updates:
            block = update.id
            kind, name = type(block).__name__, block.name_full
            if kind == "Object":
                if update.is_updated_transform:
                    made.transforms.add(name)
                if update.is_updated_geometry:
                    made.geometry.add(("Object", name))
                if update.is_updated_shading:
                    made.shading.add(name)
            elif kind == "World":
                made.world = True
            elif kind == "Image":
                made.images.add(name)
            elif kind in {"Material", "PointLight", "SpotLight", "SunLight", "AreaLight"}:
                made.shading.add(name)
            elif update.is_updated_geometry:
                made.geometry.add(("Data", name))
        return made
