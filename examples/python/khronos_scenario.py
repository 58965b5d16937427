#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a scenario of Khronos' render comparison (model-viewer's render-fidelity-tools).

    khronos_scenario.py '{"scenario": {...}, "outputFile": "image.png"}'
    khronos_scenario.py FILE.json [--name SCENARIO] [--root FOLDER] [--out FILE.png] [--pixel-ratio 2]

The first form is how the comparison calls a renderer: in its config.json,

    {"name": "gnomon", "command": {"executable": "python3", "args": ["khronos_scenario.py"]}}

The second reads such a document, one scenario, or a config.json of scenarios, from a file. Paths are relative to --root, or
to the folder where the program is started. The camera is on an orbit around a target; the background is transparent unless
the scenario shows its sky. Exit codes: 0; 2: a wrong call; 3: a file or scenario that cannot be used.
"""
import argparse
import json
import math
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import gnomon
import numpy as np
import numpy.typing as npt


def read_hdr(data: bytes) -> npt.NDArray[np.uint8]:
    """(height, width, 4): the pixels of a Radiance image, as mantissas and exponents."""
    end = data.index(b"\n\n") + 2
    line_end = data.index(b"\n", end)
    words = data[end:line_end].split()
    if not data.startswith(b"#?") or len(words) != 4 or words[0] != b"-Y" or words[2] != b"+X":
        raise ValueError("not a Radiance image whose rows go from the top")
    height, width, at = int(words[1]), int(words[3]), line_end + 1
    pixels = np.zeros((height, width, 4), dtype=np.uint8)
    for row in pixels:
        if data[at:at + 2] != b"\x02\x02":
            row[:] = np.frombuffer(data, np.uint8, 4 * width, at).reshape(width, 4)
            at += 4 * width
            continue
        at += 4
        for channel in range(4):
            x = 0
            while x < width:
                count = data[at]
                if count > 128:
                    row[x:x + count - 128, channel] = data[at + 1]
                    x, at = x + count - 128, at + 2
                else:
                    row[x:x + count, channel] = np.frombuffer(data, np.uint8, count, at + 1)
                    x, at = x + count, at + 1 + count
    return pixels


def with_lighting(scene: gnomon.Scene, file: Path) -> gnomon.Scene:
    """The scene under an environment image. The comparison has the image's centre towards +X, Gnomon towards -Z."""
    if file.suffix.lower() != ".hdr":
        return scene.with_environment(file)
    pixels = read_hdr(file.read_bytes())
    height, width, _ = pixels.shape
    with tempfile.TemporaryDirectory() as folder:
        turned = Path(folder) / file.name
        header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
        turned.write_bytes(header + np.roll(pixels, width // 4, axis=1).tobytes())
        return scene.with_environment(turned)


def camera_of(scenario: dict[str, Any]) -> gnomon.Camera:
    """On a sphere around the target: theta from +Z to +X, phi from +Y, in degrees."""
    target, orbit = scenario["target"], scenario["orbit"]
    theta, phi, radius = math.radians(orbit["theta"]), math.radians(orbit["phi"]), float(orbit["radius"])
    # From straight above or below, what is up follows from theta.
    phi = min(max(phi, 1e-4), math.pi - 1e-4)
    middle = (float(target["x"]), float(target["y"]), float(target["z"]))
    eye = (middle[0] + radius * math.sin(phi) * math.sin(theta), middle[1] + radius * math.cos(phi),
           middle[2] + radius * math.sin(phi) * math.cos(theta))
    return gnomon.Camera(transform=gnomon.look_at(eye, middle), vertical_fov=math.radians(scenario["verticalFoV"]),
                         near=0.01, far=0)


# What a scenario leaves out.
DEFAULTS: dict[str, Any] = {
    "lighting": "", "dimensions": {"width": 768, "height": 768}, "target": {"x": 0, "y": 0, "z": 0},
    "orbit": {"theta": 0, "phi": 90, "radius": 1}, "verticalFoV": 45, "renderSkybox": False,
}


def render(scenario: dict[str, Any], out: Path, root: Path, ratio: float, tonemap: str, samples: str) -> None:
    """Renders a scenario to a PNG."""
    given = scenario
    scenario = dict(given)
    for key, value in DEFAULTS.items():
        scenario[key] = {**value, **given.get(key, {})} if isinstance(value, dict) else given.get(key, value)
    scene = gnomon.load(root / scenario["model"], ground=False)
    scene = with_lighting(scene, root / scenario["lighting"]) if scenario["lighting"] \
        else scene.with_environment("builtin:studio")
    size = (round(scenario["dimensions"]["width"] * ratio), round(scenario["dimensions"]["height"] * ratio))
    background = "environment" if scenario["renderSkybox"] else "transparent"
    with gnomon.Renderer(size=size, samples="auto" if samples == "auto" else int(samples), exposure=0.0, tonemap=tonemap,
                         background=background) as renderer:
        out.parent.mkdir(parents=True, exist_ok=True)
        renderer.render(scene, camera=camera_of(scenario)).write(out)


def chosen(document: dict[str, Any], name: str) -> tuple[dict[str, Any], str]:
    """(scenario, output file or '') of a document."""
    if "scenarios" in document:
        found = [each for each in document["scenarios"] if each["name"] == name]
        if not found:
            raise KeyError(f"no scenario '{name}'; there are {', '.join(each['name'] for each in document['scenarios'])}")
        return found[0], ""
    if "scenario" in document:
        return document["scenario"], document.get("outputFile", "")
    return document, ""


def main() -> int:
    parser = argparse.ArgumentParser(description="Renders a scenario of Khronos' render comparison.")
    parser.add_argument("scenario", help="a JSON document, or a file that contains one")
    parser.add_argument("--name", default="", help="of a config.json: the scenario")
    parser.add_argument("--root", type=Path, default=Path("."), help="folder to which the paths of the scenario are relative")
    parser.add_argument("--out", default="", help="instead of the document's outputFile")
    parser.add_argument("--pixel-ratio", type=float, default=2, help="pixels of the image per pixel of the scenario (2)")
    parser.add_argument("--tonemap", choices=["none", "neutral", "agx", "aces"], default="neutral")
    parser.add_argument("--samples", default="auto", help="per pixel, or auto")
    arguments = parser.parse_args()
    try:
        text = arguments.scenario
        if not text.lstrip().startswith("{"):
            text = Path(text).read_text(encoding="utf-8")
        scenario, out = chosen(json.loads(text), arguments.name)
        out = arguments.out or out
        if not out:
            parser.error("no output file: give --out, or outputFile in the document")
        render(scenario, Path(out), arguments.root, arguments.pixel_ratio, arguments.tonemap, arguments.samples)
    except (gnomon.Error, OSError, KeyError, TypeError, ValueError) as error:
        place = f"no member {error}" if isinstance(error, KeyError) else str(error)
        print(f"{os.path.basename(sys.argv[0])}: {place}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
