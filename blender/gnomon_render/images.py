# SPDX-License-Identifier: Apache-2.0
"""Images of Blender as arrays, and as textures of Gnomon."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional

import numpy as np


def to_linear(encoded: np.ndarray) -> np.ndarray:
    """Linear light of sRGB-encoded values."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0) + 0.055) / 1.055) ** 2.4)


def to_srgb(linear: np.ndarray) -> np.ndarray:
    """sRGB-encoded values of linear light."""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


@dataclass(frozen=True)
class Mapping:
    """How a texture lies on a surface: coordinates, as Blender has them, are scaled, rotated, then moved."""

    uv: str = ""
    """The name of the layer of coordinates; "": the one that is active for rendering."""
    offset: tuple = (0.0, 0.0)
    scale: tuple = (1.0, 1.0)
    rotation: float = 0.0
    """Radians, counter-clockwise."""
    wrap: str = "repeat"
    filter: str = "linear"

    def to_gltf(self) -> tuple:
        """(offset, scale, rotation) for coordinates whose v is from the upper edge.

        Blender reads at u' = R S u + T with v from below. With v = 1 - w, that is w' = 1 - v'."""
        c, s = float(np.cos(self.rotation)), float(np.sin(self.rotation))
        (sx, sy), (tx, ty) = self.scale, self.offset
        # u' = c sx u - s sy (1 - w) + tx;  w' = 1 - (s sx u + c sy (1 - w) + ty)
        # glTF: u' = c sx u + s sy w + ox;  w' = -s sx u + c sy w + oy
        return (tx - s * sy, 1 - c * sy - ty), (sx, sy), self.rotation


@dataclass(frozen=True, eq=False)
class ImageMap:
    """An image as a material uses it: linear RGBA, its rows from the top."""

    pixels: np.ndarray
    """(height, width, 4) of float32."""
    mapping: Mapping
    key: tuple
    """Equal for equal pixels."""

    def channel(self, index: int, name: str) -> ImageMap:
        """One channel as a grey image."""
        grey = np.repeat(self.pixels[..., index:index + 1], 4, axis=-1)
        return replace(self, pixels=grey, key=(*self.key, name))

    def mean(self) -> tuple:
        return tuple(float(c) for c in self.pixels.reshape(-1, 4).mean(axis=0))


class ImageCache:
    """Pixels of images, read once and again where an image has changed."""

    def __init__(self) -> None:
        self._pixels: dict = {}

    def forget(self, name: str) -> None:
        for key in [key for key in self._pixels if key[0] == name]:
            del self._pixels[key]

    def image_map(self, image, mapping: Mapping, frame: int) -> Optional[ImageMap]:
        """The image at a frame; None if it has no pixels.

        Image sequences and videos are read as the dependency graph has set them."""
        moving = image.source in {"SEQUENCE", "MOVIE"}
        key = (image.name_full, frame if moving else 0)
        if key not in self._pixels:
            pixels = read(image)
            if moving:
                self.forget(image.name_full)
            self._pixels[key] = pixels
        pixels = self._pixels[key]
        return None if pixels is None else ImageMap(pixels, mapping, key)


def read(image) -> Optional[np.ndarray]:
    """(height, width, 4): linear values, the upper row first; None if there is nothing to read."""
    width, height = image.size
    if width == 0 or height == 0:
        return None
    count = image.channels
    values = np.empty(width * height * count, dtype=np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, count)[::-1]
    pixels = np.ones((height, width, 4), dtype=np.float32)
    if count >= 3:
        pixels[..., :count] = values[..., :4]
    else:
        pixels[..., :3] = values[..., :1]
        if count == 2:
            pixels[..., 3] = values[..., 1]
    # Bytes come as they are stored, floats as linear light.
    if not image.is_float and image.colorspace_settings.name in {"sRGB", "Filmic sRGB"}:
        pixels[..., :3] = to_linear(pixels[..., :3])
    if image.alpha_mode == "NONE":
        pixels[..., 3] = 1
    return pixels


def bytes_of(image_map: ImageMap, srgb: bool, alpha: bool) -> np.ndarray:
    """(height, width, 3 or 4): the values as textures store them."""
    color = image_map.pixels[..., :3]
    color = to_srgb(color) if srgb else np.clip(color, 0, 1)
    values = np.concatenate([color, np.clip(image_map.pixels[..., 3:], 0, 1)], axis=-1) if alpha else color
    return np.ascontiguousarray(np.round(values * 255).astype(np.uint8))


def resized(pixels: np.ndarray, height: int, width: int) -> np.ndarray:
    """The nearest pixels, in another size."""
    if pixels.shape[:2] == (height, width):
        return pixels
    rows = (np.arange(height) * pixels.shape[0] // height)
    columns = (np.arange(width) * pixels.shape[1] // width)
    return pixels[rows][:, columns]
