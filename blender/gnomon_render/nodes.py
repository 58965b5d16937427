# SPDX-License-Identifier: Apache-2.0
"""Values of node sockets: constants, and images with simple operations on them.

A socket has a constant, or an image map: the pixels of an image after what nodes between it and the socket do to them. Nodes
that compute patterns from coordinates have no image; their sockets are approximated by a constant, with a warning.
"""
from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Optional, Union

import numpy as np

from .images import ImageCache, Mapping, ImageMap, resized

Value = Union[np.ndarray, ImageMap]
"""(4,) of float: a linear colour with alpha, or a number in all channels; or an image map."""

LUMA = np.array([0.2126, 0.7152, 0.0722])


def constant(value: Any) -> np.ndarray:
    """A number or a colour as a value."""
    if isinstance(value, (int, float)):
        return np.array([value, value, value, 1.0])
    values = list(value)
    return np.array([*values[:3], values[3] if len(values) > 3 else 1.0], dtype=float)


def followed(socket) -> tuple:
    """(node, output socket) that an input comes from, past reroutes; (None, None) if it is not linked."""
    while socket.is_linked:
        link = socket.links[0]
        if not link.is_valid or link.is_muted:
            return None, None
        node, out = link.from_node, link.from_socket
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.mute and node.internal_links:
            inner = next((each for each in node.internal_links if each.to_socket == out), None)
            if inner is None:
                return None, None
            socket = inner.from_socket
        else:
            return node, out
    return None, None


def apply(operation: Callable, key: tuple, *values: Value) -> Value:
    """An operation on colours, for constants and images. Images with other coordinates than the first one's cannot
    be combined with it, and count as their mean."""
    image_maps = [value for value in values if isinstance(value, ImageMap)]
    if not image_maps:
        return np.asarray(operation(*values), dtype=float)
    first = image_maps[0]
    height = max(p.pixels.shape[0] for p in image_maps if p.mapping == first.mapping)
    width = max(p.pixels.shape[1] for p in image_maps if p.mapping == first.mapping)
    arguments, keys = [], []
    for value in values:
        if isinstance(value, ImageMap) and value.mapping == first.mapping:
            arguments.append(resized(value.pixels, height, width))
            keys.append(value.key)
        else:
            plain = np.array(value.mean()) if isinstance(value, ImageMap) else value
            arguments.append(plain)
            keys.append(tuple(np.round(plain, 9)))
    pixels = np.broadcast_to(operation(*arguments), (height, width, 4)).astype(np.float32)
    return replace(first, pixels=pixels, key=(*key, *keys))


def _grey(values: np.ndarray) -> np.ndarray:
    luma = (values[..., :3] @ LUMA)[..., None]
    return np.concatenate([luma, luma, luma, np.ones_like(luma)], axis=-1)


def _with_rgb(values: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    shape = np.broadcast_shapes(values.shape[:-1], rgb.shape[:-1])
    return np.concatenate([np.broadcast_to(rgb, (*shape, 3)), np.broadcast_to(values[..., 3:], (*shape, 1))], axis=-1)


BLENDS: dict = {
    "MIX": lambda a, b: b,
    "MULTIPLY": lambda a, b: a * b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
    "DIFFERENCE": lambda a, b: np.abs(a - b),
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "OVERLAY": lambda a, b: np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b)),
    "DIVIDE": lambda a, b: np.where(b != 0, a / np.where(b != 0, b, 1), 0),
}

MATHS: dict = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: np.where(b != 0, a / np.where(b != 0, b, 1), 0),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: np.where(a >= 0, np.abs(a) ** b, 0),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b).astype(float),
    "GREATER_THAN": lambda a, b, c: (a > b).astype(float),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
}


class Evaluator:
    """Values of the sockets of a node tree."""

    def __init__(self, images: ImageCache, frame: int, warn: Callable[[str], None]) -> None:
        """warn(what)  is told of what is approximated"""
        self.images = images
        self.frame = frame
        self.warn = warn
        self.vertex_color: Optional[str] = None
        """The layer of colours that a socket reads, set by color(); "": the active one."""
        self._groups: list = []
        self._depth = 0

    def value(self, socket) -> Value:
        """The value of an input."""
        node, out = followed(socket)
        if node is None:
            plain = getattr(socket, "default_value", 0.0)
            return constant(plain)
        return self.output(node, out)

    def number(self, socket) -> Value:
        """The value of an input that is a number: of colours, the luminance."""
        value = self.value(socket)
        if socket.is_linked:
            _, out = followed(socket)
            if out is not None and out.type == "RGBA":
                value = apply(_grey, ("grey",), value)
        return value

    def plain(self, socket) -> np.ndarray:
        """The value of an input that must be a constant; an image map counts as its mean."""
        value = self.value(socket)
        if isinstance(value, ImageMap):
            self.warn(f"the image of '{socket.name}' is taken as its mean")
            return np.array(value.mean())
        return value

    def scalar(self, socket) -> float:
        value = self.number(socket)
        if isinstance(value, ImageMap):
            self.warn(f"the image of '{socket.name}' is taken as its mean")
            value = np.array(value.mean())
        return float(value[0])

    def output(self, node, out) -> Value:
        """The value of an output of a node."""
        self._depth += 1
        try:
            if self._depth > 64:
                return constant(0.0)
            act = getattr(self, "_" + node.type.lower(), None)
            if act is None:
                return self._unknown(node, out)
            value: Value = act(node, out)
            return value
        finally:
            self._depth -= 1

    def _unknown(self, node, out) -> Value:
        self.warn(f"the node '{node.bl_label}' is not known, and taken as a constant")
        for name in ("Color", "Color1", "Value", "Fac"):
            if name in node.inputs and not node.inputs[name].is_linked:
                return constant(node.inputs[name].default_value)
        return constant(0.5)

    # Inputs.

    def _rgb(self, node, out) -> Value:
        return constant(node.outputs[0].default_value)

    def _value(self, node, out) -> Value:
        return constant(float(node.outputs[0].default_value))

    def _tex_image(self, node, out) -> Value:
        image = node.image
        if image is None:
            return constant((0, 0, 0, 1))
        if node.projection != "FLAT":
            self.warn(f"the image '{image.name}' is not projected flat, and laid out by texture coordinates")
        image_map = self.images.image_map(image, self.mapping(node), self.frame)
        if image_map is None:
            self.warn(f"the image '{image.name}' cannot be read")
            return constant((1, 0, 1, 1))
        return image_map.channel(3, "alpha") if out.name == "Alpha" else image_map

    def _vertex_color(self, node, out) -> Value:
        if out.name == "Alpha":
            return constant(1.0)
        self.vertex_color = node.layer_name
        return constant((1, 1, 1, 1))

    def _attribute(self, node, out) -> Value:
        if node.attribute_type != "GEOMETRY" or out.name not in {"Color", "Vector"}:
            return self._unknown(node, out)
        self.vertex_color = node.attribute_name
        return constant((1, 1, 1, 1))

    # Operations.

    def _group(self, node, out) -> Value:
        if node.node_tree is None:
            return constant(0.0)
        end = next((each for each in node.node_tree.nodes if each.type == "GROUP_OUTPUT" and each.is_active_output), None)
        inner = end and next((each for each in end.inputs if each.identifier == out.identifier), None)
        if not inner:
            return constant(0.0)
        self._groups.append(node)
        try:
            return self.value(inner)
        finally:
            self._groups.pop()

    def _group_input(self, node, out) -> Value:
        if not self._groups:
            return constant(0.0)
        group = self._groups.pop()
        try:
            outer = next((each for each in group.inputs if each.identifier == out.identifier), None)
            return constant(0.0) if outer is None else self.value(outer)
        finally:
            self._groups.append(group)

    def _mix_rgb(self, node, out) -> Value:
        return self._mixed(node, node.blend_type, node.use_clamp, *(self.value(node.inputs[i]) for i in range(3)))

    def _mix(self, node, out) -> Value:
        sockets = [each for each in node.inputs if each.enabled]
        if node.data_type == "VECTOR" or len(sockets) < 3:
            return self._unknown(node, out)
        clamp = node.clamp_result and node.data_type == "RGBA"
        blend = node.blend_type if node.data_type == "RGBA" else "MIX"
        return self._mixed(node, blend, clamp, *(self.value(each) for each in sockets[:3]))

    def _mixed(self, node, blend: str, clamp: bool, factor: Value, a: Value, b: Value) -> Value:
        if blend not in BLENDS:
            self.warn(f"'{node.bl_label}' does not know {blend.lower()}, and mixes")
            blend = "MIX"

        def mix(f, x, y):
            share = np.clip(f[..., :1], 0, 1)
            rgb = (1 - share) * x[..., :3] + share * BLENDS[blend](x[..., :3], y[..., :3])
            return _with_rgb(x, np.clip(rgb, 0, 1) if clamp else rgb)

        return apply(mix, ("mix", blend, clamp), factor, a, b)

    def _math(self, node, out) -> Value:
        if node.operation not in MATHS:
            return self._unknown(node, out)
        inputs = [self.number(socket) for socket in node.inputs]
        inputs += [constant(0.0)] * (3 - len(inputs))

        def act(a, b, c):
            rgb = MATHS[node.operation](a[..., :3], b[..., :3], c[..., :3])
            return _with_rgb(a, np.clip(rgb, 0, 1) if node.use_clamp else rgb)

        return apply(act, ("math", node.operation, node.use_clamp), *inputs[:3])

    def _invert(self, node, out) -> Value:
        return apply(lambda f, x: _with_rgb(x, x[..., :3] + f[..., :1] * (1 - 2 * x[..., :3])), ("invert",),
                     self.value(node.inputs["Fac"]), self.value(node.inputs["Color"]))

    def _gamma(self, node, out) -> Value:
        return apply(lambda x, g: _with_rgb(x, np.maximum(x[..., :3], 0) ** g[..., :1]), ("gamma",),
                     self.value(node.inputs["Color"]), self.value(node.inputs["Gamma"]))

    def _brightcontrast(self, node, out) -> Value:
        def act(x, bright, contrast):
            a, b = 1 + contrast[..., :1], bright[..., :1] - contrast[..., :1] * 0.5
            return _with_rgb(x, np.maximum(a * x[..., :3] + b, 0))

        return apply(act, ("bright",), *(self.value(node.inputs[i]) for i in ("Color", "Bright", "Contrast")))

    def _valtorgb(self, node, out) -> Value:
        ramp = node.color_ramp
        places = np.linspace(0, 1, 257)
        table = np.array([ramp.evaluate(float(x)) for x in places])

        def act(x):
            at = np.clip(x[..., 0], 0, 1)
            return np.stack([np.interp(at, places, table[:, c]) for c in range(4)], axis=-1)

        value = apply(act, ("ramp", table.tobytes()), self.number(node.inputs[0]))
        return self._part(value, 3) if out.name == "Alpha" else value

    def _map_range(self, node, out) -> Value:
        if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
            return self._unknown(node, out)

        def act(x, a, b, to_a, to_b):
            span = b[..., :1] - a[..., :1]
            t = np.where(span != 0, (x[..., :3] - a[..., :1]) / np.where(span != 0, span, 1), 0)
            t = np.clip(t, 0, 1) if node.clamp else t
            return _with_rgb(x, to_a[..., :1] + t * (to_b[..., :1] - to_a[..., :1]))

        return apply(act, ("range", node.clamp), *(self.number(node.inputs[i]) for i in range(5)))

    def _rgbtobw(self, node, out) -> Value:
        return apply(_grey, ("grey",), self.value(node.inputs[0]))

    def _part(self, value: Value, index: int) -> Value:
        if isinstance(value, ImageMap):
            return value.channel(index, f"channel {index}")
        return constant(float(value[index]))

    def _separate_color(self, node, out) -> Value:
        if node.mode != "RGB":
            return self._unknown(node, out)
        return self._part(self.value(node.inputs[0]), [each.identifier for each in node.outputs].index(out.identifier))

    def _seprgb(self, node, out) -> Value:
        return self._part(self.value(node.inputs[0]), [each.identifier for each in node.outputs].index(out.identifier))

    def _combine_color(self, node, out) -> Value:
        if node.mode != "RGB":
            return self._unknown(node, out)
        return self._combrgb(node, out)

    def _combrgb(self, node, out) -> Value:
        return apply(lambda r, g, b: np.concatenate(np.broadcast_arrays(r[..., :1], g[..., :1], b[..., :1],
                                                                        np.ones_like(r[..., :1])), axis=-1),
                     ("combine",), *(self.number(node.inputs[i]) for i in range(3)))

    # Coordinates of images.

    def mapping(self, node) -> Mapping:
        """Where an image's pixels lie on surfaces."""
        wrap = {"REPEAT": "repeat", "MIRROR": "mirror"}.get(node.extension, "clamp")
        if node.extension == "CLIP":
            self.warn(f"'{node.bl_label}' does not clip, and extends its edge")
        interpolation = "nearest" if node.interpolation == "Closest" else "linear"
        found = Mapping(wrap=wrap, filter=interpolation)
        source, out = followed(node.inputs["Vector"])
        return found if source is None else self._coordinates(source, out, found)

    def _coordinates(self, node, out, found: Mapping) -> Mapping:
        if node.type == "UVMAP":
            return replace(found, uv=node.uv_map)
        if node.type == "TEX_COORD":
            if out.name != "UV":
                self.warn(f"texture coordinates '{out.name}' are not known, and taken as UV")
            return found
        if node.type == "ATTRIBUTE":
            return replace(found, uv=node.attribute_name)
        if node.type == "MAPPING":
            return self._mapped(node, found)
        self.warn(f"texture coordinates of the node '{node.bl_label}' are not known, and taken as UV")
        return found

    def _mapped(self, node, found: Mapping) -> Mapping:
        vector = lambda name: self.plain(node.inputs[name])[:3] if name in node.inputs else np.zeros(3)  # noqa: E731
        place, turn, scale = vector("Location"), vector("Rotation"), vector("Scale")
        if abs(turn[0]) > 1e-6 or abs(turn[1]) > 1e-6:
            self.warn("a mapping turns texture coordinates around X or Y, which is left out")
        angle = float(turn[2])
        if node.vector_type == "TEXTURE":
            # The inverse of move, rotate, scale: only without a rotation between scales does it have the same form.
            scale = 1 / np.where(scale != 0, scale, 1)
            if angle != 0 and abs(scale[0] - scale[1]) > 1e-6:
                self.warn("a mapping of the type 'Texture' turns and stretches, which is approximated")
            angle = -angle
            c, s = math.cos(angle), math.sin(angle)
            place = -np.array([scale[0] * (c * place[0] - s * place[1]), scale[1] * (s * place[0] + c * place[1]), 0])
        elif node.vector_type != "POINT":
            place = np.zeros(3)
        inner, out = followed(node.inputs["Vector"])
        if inner is not None:
            found = self._coordinates(inner, out, found)
            if found.rotation or found.offset != (0.0, 0.0) or found.scale != (1.0, 1.0):
                self.warn("of several mappings in a row, the first one is left out")
        return replace(found, offset=(float(place[0]), float(place[1])), scale=(float(scale[0]), float(scale[1])),
                       rotation=angle)
