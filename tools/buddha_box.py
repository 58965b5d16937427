#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a glTF scene with a model in a Cornell box, for bench indirect: the "Buddha in the box" of Ki and Oh (2007).

    tools/buddha_box.py $GNOMON_SCENES/stanford/buddha_50k_decimated.obj buddha.glb

The model is an OBJ file, of which only positions and faces are read. It is scaled to a height of 1.3 and stands on the
floor in place of the two blocks of builtin:cornell. A ball moves past in front of it for 40 frames at 24 frames per
second. The spot light and the camera are those of builtin:cornell.
"""

import array
import json
import math
import struct
import sys

HEIGHT = 1.3   # of the model
FRAMES, RATE = 40, 24
BALL, BALL_START, BALL_STEP = 0.12, (-0.6, 0.1, 0.62), (0.03, -0.012, 0.0)
WHITE, RED, GREEN, BLUE, CLAY = (0.75,) * 3, (0.75, 0.1, 0.1), (0.1, 0.75, 0.1), (0.3, 0.3, 0.8), (0.72, 0.65, 0.5)
LIGHT, TOWARD, CONE, CANDELA = (0.6, 0.8, 0.9), (-1.1, -1.0, -1.1), 0.7, 8


def read_obj(path):
    """Returns positions and triangles; polygons are split into fans."""
    points, triangles = [], []
    with open(path, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if not words:
                continue
            if words[0] == "v":
                points.append(tuple(float(w) for w in words[1:4]))
            elif words[0] == "f":
                face = [int(w.split("/")[0]) for w in words[1:]]
                face = [i - 1 if i > 0 else len(points) + i for i in face]
                triangles += [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)]
    return points, triangles


def normals_of(points, triangles):
    """Returns vertex normals: means over the adjacent triangles, weighted by area."""
    sums = [[0.0, 0.0, 0.0] for _ in points]
    for a, b, c in triangles:
        u = [points[b][i] - points[a][i] for i in range(3)]
        v = [points[c][i] - points[a][i] for i in range(3)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        for corner in (a, b, c):
            for i in range(3):
                sums[corner][i] += n[i]
    out = []
    for s in sums:
        length = math.sqrt(sum(x * x for x in s)) or 1.0
        out.append(tuple(x / length for x in s) if any(s) else (0.0, 1.0, 0.0))
    return out


def box(low, high):
    """Returns points, normals and triangles of an axis-aligned box."""
    points, normals, triangles = [], [], []
    for axis in range(3):
        for side in (0, 1):
            s, t = (axis + 1) % 3, (axis + 2) % 3
            corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
            base = len(points)
            for a, b in corners if side else reversed(corners):
                p = [0.0] * 3
                p[axis] = (low, high)[side][axis]
                p[s], p[t] = (low, high)[a][s], (low, high)[b][t]
                points.append(tuple(p))
                normals.append(tuple(float(2 * side - 1) if i == axis else 0.0 for i in range(3)))
            triangles += [(base, base + 1, base + 2), (base, base + 2, base + 3)]
    return points, normals, triangles


def ball(radius, rings=24, segments=48):
    """Returns points, normals and triangles of a sphere around the origin."""
    points, normals, triangles = [], [], []
    for r in range(rings + 1):
        for s in range(segments + 1):
            polar, around = math.pi * r / rings, 2 * math.pi * s / segments
            n = (math.sin(polar) * math.cos(around), math.cos(polar), math.sin(polar) * math.sin(around))
            normals.append(n)
            points.append(tuple(radius * x for x in n))
    for r in range(rings):
        for s in range(segments):
            a = r * (segments + 1) + s
            b = a + segments + 1
            if r > 0:
                triangles.append((a, a + 1, b + 1))
            if r + 1 < rings:
                triangles.append((a, b + 1, b))
    return points, normals, triangles


class File:
    """A glTF file that is built in memory."""

    def __init__(self):
        self.data = bytearray()
        self.document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                         "materials": [], "accessors": [], "bufferViews": []}

    def accessor(self, rows, kind, code, component):
        """Appends values to the buffer and returns the index of their accessor."""
        flat = [x for row in rows for x in (row if isinstance(row, tuple) else (row,))]
        values = array.array(code, flat)
        if sys.byteorder == "big":
            values.byteswap()
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(values) * values.itemsize}
        self.data += values.tobytes()
        self.document["bufferViews"].append(view)
        entry = {"bufferView": len(self.document["bufferViews"]) - 1, "componentType": component, "type": kind,
                 "count": len(rows) if kind != "SCALAR" else len(flat)}
        if kind != "SCALAR" or code == "f":
            wide = [row if isinstance(row, tuple) else (row,) for row in rows]
            as_float = [struct.unpack("<f", struct.pack("<f", x))[0] for row in wide for x in row]
            width = len(wide[0])
            entry["min"] = [min(as_float[i::width]) for i in range(width)]
            entry["max"] = [max(as_float[i::width]) for i in range(width)]
        self.document["accessors"].append(entry)
        return len(self.document["accessors"]) - 1

    def node(self, node):
        """Adds a root node and returns its index."""
        self.document["nodes"].append(node)
        self.document["scenes"][0]["nodes"].append(len(self.document["nodes"]) - 1)
        return len(self.document["nodes"]) - 1

    def mesh(self, name, shape, color, **place):
        """Adds a mesh with a diffuse material as a node and returns the node's index."""
        points, normals, triangles = shape
        d = self.document
        d["materials"].append({"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}})
        d["meshes"].append({"name": name, "primitives": [{
            "attributes": {"POSITION": self.accessor(points, "VEC3", "f", 5126),
                           "NORMAL": self.accessor(normals, "VEC3", "f", 5126)},
            "indices": self.accessor(triangles, "SCALAR", "I", 5125), "material": len(d["materials"]) - 1}]})
        return self.node({"name": name, "mesh": len(d["meshes"]) - 1, **place})

    def write(self, path):
        """Writes the file as binary glTF."""
        while len(self.data) % 4:
            self.data.append(0)
        self.document["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as out:
            out.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(self.data)))
            out.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
            out.write(struct.pack("<II", len(self.data), 0x004E4942) + self.data)


def turn_to(direction):
    """Returns the quaternion that rotates -Z, the direction of a light, to a direction."""
    length = math.sqrt(sum(x * x for x in direction))
    x, y, z = (c / length for c in direction)
    q = (y, -x, 0.0, 1 - z)   # (0, 0, -1) x direction, 1 + their dot product
    size = math.sqrt(sum(c * c for c in q))
    return [c / size for c in q]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)

    # Scale the model and place it on the floor.
    points, triangles = read_obj(sys.argv[1])
    low = [min(p[i] for p in points) for i in range(3)]
    high = [max(p[i] for p in points) for i in range(3)]
    scale = HEIGHT / (high[1] - low[1])
    points = [(scale * (p[0] - (low[0] + high[0]) / 2), scale * (p[1] - low[1]) - 1,
               scale * (p[2] - (low[2] + high[2]) / 2) - 0.2) for p in points]

    # Add the walls, the model and the moving ball.
    file = File()
    for name, wall_low, wall_high, color in (
            ("floor", (-1.1, -1.1, -1.1), (1.1, -1.0, 1.0), WHITE), ("ceiling", (-1.1, 1.0, -1.1), (1.1, 1.1, 1.0), WHITE),
            ("back", (-1.0, -1.0, -1.1), (1.0, 1.0, -1.0), WHITE), ("left", (-1.1, -1.0, -1.1), (-1.0, 1.0, 1.0), RED),
            ("right", (1.0, -1.0, -1.1), (1.1, 1.0, 1.0), GREEN)):
        file.mesh(name, box(wall_low, wall_high), color)
    file.mesh("model", (points, normals_of(points, triangles), triangles), CLAY)
    ball_node = file.mesh("ball", ball(BALL), BLUE, translation=list(BALL_START))
    times = [0.0, (FRAMES - 1) / RATE]
    end = tuple(a + (FRAMES - 1) * b for a, b in zip(BALL_START, BALL_STEP))
    file.document["animations"] = [{
        "samplers": [{"input": file.accessor(times, "SCALAR", "f", 5126),
                      "output": file.accessor([BALL_START, end], "VEC3", "f", 5126)}],
        "channels": [{"sampler": 0, "target": {"node": ball_node, "path": "translation"}}]}]

    # Add the camera and the light.
    file.document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.62, "aspectRatio": 1.0, "znear": 0.01}}]
    file.node({"camera": 0, "translation": [0.0, 0.0, 3.6]})
    file.document["extensionsUsed"] = ["KHR_lights_punctual"]
    file.document["extensions"] = {"KHR_lights_punctual": {"lights": [{
        "type": "spot", "intensity": CANDELA, "spot": {"innerConeAngle": CONE - 0.1, "outerConeAngle": CONE}}]}}
    file.node({"translation": list(LIGHT), "rotation": turn_to(TOWARD),
               "extensions": {"KHR_lights_punctual": {"light": 0}}})
    file.write(sys.argv[2])


if __name__ == "__main__":
    main()
