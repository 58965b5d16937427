# SPDX-License-Identifier: Apache-2.0
"""Meshes of evaluated objects, as arrays of triangles.

Blender stores normals and texture coordinates at the corners of faces, Gnomon at vertices. Corners that agree share a
vertex. Of what deforms, corners are joined by what stays the same while it does: vertex, texture coordinates, and the
face where it is flat; so all its frames have the same triangles, and only positions and normals are handed over.
"""
from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Optional

import numpy as np

WITH_SURFACE = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
"""The types of objects that have a surface."""


@dataclass
class Geometry:
    """The triangles of an object, in its own space."""

    positions: np.ndarray
    triangles: np.ndarray
    normals: Optional[np.ndarray] = None
    """None: faces are flat."""
    uvs: list = field(default_factory=list)
    colors: Optional[np.ndarray] = None
    runs: list = field(default_factory=list)
    """(slot of the material, number of triangles), in the order of the triangles."""
    deforms: bool = False
    sources: Optional[np.ndarray] = None
    """The vertex of the evaluated mesh that each vertex is."""

    def topology(self) -> bytes:
        """A hash of all but positions and normals."""
        h = hashlib.blake2b(digest_size=16)
        for array in (self.triangles, *self.uvs, self.colors):
            h.update(b"none" if array is None else np.ascontiguousarray(array))
        h.update(repr((self.runs, self.normals is None, len(self.positions))).encode())
        return h.digest()

    def shape(self) -> bytes:
        """A hash of positions and normals."""
        h = hashlib.blake2b(digest_size=16)
        for array in (self.positions, self.normals):
            h.update(b"none" if array is None else np.ascontiguousarray(array))
        return h.digest()


def _read(collection, name: str, dtype, columns: int = 1) -> np.ndarray:
    values = np.empty(len(collection) * columns, dtype=dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, columns) if columns > 1 else values


def _unique(keys: np.ndarray) -> tuple:
    """(one row of each value, the value of each row), of rows of integers."""
    rows = np.ascontiguousarray(keys).view(np.dtype((np.void, keys.dtype.itemsize * keys.shape[1])))
    _, first, inverse = np.unique(rows.ravel(), return_index=True, return_inverse=True)
    # Vertices come in the order in which faces use them first.
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]


def _bits(values: np.ndarray) -> np.ndarray:
    """Floats as integers that are equal where the values are."""
    return (np.ascontiguousarray(values, dtype=np.float32) + np.float32(0)).view(np.int32)


def _flip_v(uv: np.ndarray) -> np.ndarray:
    """Texture coordinates from the upper edge instead of the lower one."""
    return np.stack([uv[:, 0], 1 - uv[:, 1]], axis=-1)


@dataclass(frozen=True)
class Layers:
    """What a material reads of a mesh."""

    uvs: tuple = ()
    """Names of up to two layers of texture coordinates; "": the one that is active for rendering."""
    color: Optional[str] = None
    """The layer of colours that multiplies the base colour; "": the active one."""


def extract(mesh, layers_of: list, deforms: bool) -> Optional[Geometry]:
    """The triangles of an evaluated mesh; None if it has none.

    layers_of  Layers by slot of the material; slots beyond have the last one's
    deforms    its vertices may move in later frames"""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    corners = _read(mesh.loop_triangles, "loops", np.int32, 3)
    slots = _read(mesh.loop_triangles, "material_index", np.int32)
    smooth = _read(mesh.loop_triangles, "use_smooth", bool)
    polygons = _read(mesh.loop_triangles, "polygon_index", np.int32)
    positions = _read(mesh.vertices, "co", np.float32, 3)
    vertex_of = _read(mesh.loops, "vertex_index", np.int32)

    # Order the triangles by material.
    if slots.any():
        order = np.argsort(slots, kind="stable")
        corners, slots, smooth, polygons = corners[order], slots[order], smooth[order], polygons[order]
    ends = np.flatnonzero(np.diff(slots)) + 1
    bounds = np.concatenate([[0], ends, [count]])
    runs = [(int(slots[a]), int(b - a)) for a, b in zip(bounds[:-1], bounds[1:])]

    loops = corners.ravel()
    used_by = [layers_of[min(slot, len(layers_of) - 1)] if layers_of else Layers() for slot, _ in runs]
    layers = _uv_layers(mesh, used_by, loops, bounds)
    colors = _colors(mesh, used_by, loops, bounds, vertex_of)
    vertices = vertex_of[loops]
    faceted = not smooth.any() and not mesh.has_custom_normals
    normals = None
    if not faceted:
        mesh.calc_normals_split()
        normals = _read(mesh.loops, "normal", np.float32, 3)

    # Join the corners that agree.
    keys = [vertices.astype(np.int32)[:, None]]
    keys += [_bits(layer)[loops] for layer in layers]
    if colors is not None:
        keys.append(_bits(colors)[loops])
    if normals is not None and not deforms:
        keys.append(_bits(normals)[loops])
    elif normals is not None:
        keys.append(_fans(mesh, smooth, polygons, normals, loops))
    if len(keys) == 1:
        used, inverse = np.unique(vertices, return_inverse=True)
        pick = None
        geometry = Geometry(positions[used], inverse.reshape(-1, 3).astype(np.uint32), sources=used)
    else:
        pick, inverse = _unique(np.concatenate(keys, axis=1))
        sources = vertices[pick]
        geometry = Geometry(positions[sources], inverse.reshape(-1, 3).astype(np.uint32), sources=sources)
    if pick is not None:
        at = loops[pick]
        geometry.normals = None if normals is None else normals[at]
        geometry.uvs = [_flip_v(layer[at]) for layer in layers]
        geometry.colors = None if colors is None else colors[at]
    geometry.runs = runs
    geometry.deforms = deforms
    return geometry


def at_rest(made: Geometry, original) -> np.ndarray:
    """The positions of what deforms before it does: those of the object's own mesh, where that has the same vertices."""
    data = original.data
    if original.type == "MESH" and made.sources is not None and len(data.vertices) > made.sources.max():
        rest = _read(data.vertices, "co", np.float32, 3)[made.sources]
        if not np.array_equal(rest.min(axis=0), rest.max(axis=0)):
            return rest
    return made.positions


def _fans(mesh, smooth, polygons, normals, loops) -> np.ndarray:
    """What keeps corners of one vertex apart whatever moves: the face, where normals are not those of the vertex."""
    if mesh.use_auto_smooth or mesh.has_custom_normals:
        return polygons.repeat(3)[:, None].astype(np.int32)
    return np.where(smooth, -1, polygons).repeat(3)[:, None].astype(np.int32)


def _uv_layers(mesh, used_by: list, loops: np.ndarray, bounds: np.ndarray) -> list:
    """By texture coordinates 0 and 1: those of each corner, (number of loops, 2), by the material of its face."""
    results = []
    for index in range(max(len(each.uvs) for each in used_by)):
        result = np.zeros((len(mesh.loops), 2), dtype=np.float32)
        read = {}
        for layers, begin, end in zip(used_by, bounds[:-1], bounds[1:]):
            if index >= len(layers.uvs):
                continue
            name = layers.uvs[index]
            if name not in read:
                layer = mesh.uv_layers.get(name) if name else None
                layer = layer or next((each for each in mesh.uv_layers if each.active_render), None)
                read[name] = None if layer is None else _read(layer.data, "uv", np.float32, 2)
            at = loops[3 * begin:3 * end]
            if read[name] is not None:
                result[at] = read[name][at]
        results.append(result)
    return results


def _colors(mesh, used_by: list, loops: np.ndarray, bounds: np.ndarray, vertex_of: np.ndarray) -> Optional[np.ndarray]:
    """(number of loops, 4): linear colours, white where a material reads none; None: no material does."""
    if all(each.color is None for each in used_by):
        return None
    result = np.ones((len(mesh.loops), 4), dtype=np.float32)
    for layers, begin, end in zip(used_by, bounds[:-1], bounds[1:]):
        if layers.color is None:
            continue
        layer = mesh.color_attributes.get(layers.color) if layers.color else mesh.color_attributes.active_color
        if layer is None or len(layer.data) == 0:
            continue
        colors = _read(layer.data, "color", np.float32, 4)
        at = loops[3 * begin:3 * end]
        result[at] = colors[vertex_of[at]] if layer.domain == "POINT" else colors[at]
    return result
