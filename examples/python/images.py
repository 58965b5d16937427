# SPDX-License-Identifier: Apache-2.0
"""Writes arrays of numpy as PNG, and shows depth and ids in colours; for the examples, without another package."""
import math
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt


def write_png(file: Path, image: npt.NDArray[Any]) -> None:
    """(height, width) or (height, width, 3), of uint8 or uint16."""
    height, width = image.shape[:2]
    bits = 8 * image.itemsize
    color = 2 if image.ndim == 3 else 0
    rows = image.astype(f">u{image.itemsize}").reshape(height, -1).view(np.uint8)
    data = zlib.compress(np.hstack([np.zeros((height, 1), np.uint8), rows]).tobytes(), 6)

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0)
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def show_depth(depth: npt.NDArray[np.float32], nearest: float, farthest: float) -> npt.NDArray[np.uint8]:
    """From yellow (near) through red to dark blue (far); black where nothing is."""
    stops = np.array([[252, 255, 164], [250, 160, 40], [210, 60, 70], [110, 25, 110], [20, 10, 60]], dtype=float)
    share = np.clip((depth - nearest) / (farthest - nearest), 0, 1) * (len(stops) - 1)
    low = np.minimum(share.astype(int), len(stops) - 2)
    mixed = stops[low] + (share - low)[..., None] * (stops[low + 1] - stops[low])
    return np.where(depth[..., None] > 0, mixed, 0).astype(np.uint8)


def show_ids(ids: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint8]:
    """A colour for each id: hues a golden angle apart; black for 0."""
    colors = np.zeros((int(ids.max()) + 1, 3))
    for i in range(1, len(colors)):
        for k in range(3):
            colors[i, k] = 150 + 90 * math.cos(2.39996 * i + 2.0944 * k)
    return colors[ids].astype(np.uint8)
