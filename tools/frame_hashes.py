#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints a hash of the frames of every scene, renderer and method: what must not change when code only moves.

    frame_hashes.py [--program PROGRAM] [--scenes DIR] [--only WORD] [--list] > hashes.txt

Renders short clips, so that what is remembered from frame to frame takes part, as OpenEXR with all layers. A line holds
the SHA-256 of the frames of one case, in order, and the case's arguments. Compare two lists made on the same machine
with diff. Scenes that are not there are left out, with a line on standard error; so is the rasteriser without a device.
"""
import argparse
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

k_root = pathlib.Path(__file__).resolve().parent.parent
k_no_device = 4   # the program's exit code where something is missing

k_trace_methods = [
    ["--shadow-culling", "off"], ["--shadow-culling", "paper"], ["--shadow-culling", "certified"],
    ["--indirect", "off"], ["--indirect", "rsm"], ["--indirect", "rsm", "--rsm-samples", "2040"],
    ["--indirect", "quadtree", "--indirect-level", "4"], ["--indirect", "quadtree", "--receivers", "full"],
    ["--indirect", "visible", "--indirect-memory", "1"], ["--samples", "4"], ["--accelerator", "kdtree"],
    ["--reference", "--spp", "4"], ["--overlay", "shadow-states"],
    ["--indirect", "quadtree", "--overlay", "clusters"],
]
k_raster_methods = [
    ["--shadow-textures", "per-caster"], ["--shadow-textures", "depth"], ["--shadow-textures", "coherent"],
    ["--shadow-filter", "0"], ["--shadow-filter", "4"], ["--indirect", "off"], ["--indirect", "rsm"],
    ["--indirect", "quadtree"], ["--indirect", "visible"], ["--indirect", "visible", "--indirect-on", "vulkan"],
    ["--samples", "4"], ["--overlay", "redrawn"],
]
# Scene, size, frames; the first two are rendered by all methods.
k_scenes = [
    ("builtin:cornell", "128x128", "1-6"),
    ("builtin:kinetic", "192x108", "1-6"),
    ("builtin:spheres?objects=60&dynamic=20", "128x128", "1-4"),
    ("bart/kitchen/aff/kitchen.aff", "160x160", "121-125"),
    ("bart/kitchen/aff/kitchen.aff", "160x160", "300-302"),
    ("bart/robots/aff/Robot.aff", "160x120", "1-4"),
    ("sponza/sponza.obj", "192x108", "1-1"),
    ("stanford/stanford-bunny.obj", "128x128", "1-1"),
    ("gltf/BoxAnimated.glb", "128x128", "1-6"),
    ("gltf/CesiumMilkTruck.glb", "128x128", "1-4"),
    ("gltf/InterpolationTest.glb", "128x128", "1-4"),
    ("gltf/cannon.glb", "128x128", "1-2"),
]


def cases():
    for i, (scene, size, frames) in enumerate(k_scenes):
        common = [scene, "--size", size, "--frames", frames]
        for method in k_trace_methods if i < 2 else [[], ["--shadow-culling", "off", "--indirect", "off"]]:
            yield common + method
        for method in k_raster_methods if i < 2 else [[], ["--shadow-textures", "depth", "--indirect", "off"]]:
            yield common + ["--renderer", "raster"] + method
    yield ["builtin:kinetic", "--size", "160x90", "--turntable", "1", "--frames", "1-3"]
    yield ["builtin:cornell", "--size", "96x96", "--frames", "1-3", "--threads", "1"]
    yield ["builtin:cornell", "--size", "96x96", "--frames", "1-3", "--light", "point 0 0.5 0 4 4 4"]


def hash_of(program: str, arguments: list[str]) -> str | None:
    """Of all frames that the program writes; None where the device is missing."""
    with tempfile.TemporaryDirectory() as folder:
        result = subprocess.run([program, "render", *arguments, "-o", f"{folder}/f-{{frame:04}}.exr", "--quiet"],
                                capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if result.returncode == k_no_device and "raster" in arguments:
            print(f"left out: {' '.join(arguments)}: {result.stderr.strip()}", file=sys.stderr)
            return None
        if result.returncode:
            return f"exit {result.returncode}: {result.stderr.strip()}"
        content = hashlib.sha256()
        for file in sorted(pathlib.Path(folder).iterdir()):
            content.update(file.name.encode() + b"\0" + file.read_bytes())
        return content.hexdigest()[:24]


def main() -> int:
    parser = argparse.ArgumentParser(description="hashes of frames by all methods")
    parser.add_argument("--program", default=str(k_root / "build" / "release" / "gnomon"))
    parser.add_argument("--scenes", type=pathlib.Path,
                        default=pathlib.Path(os.environ.get("GNOMON_SCENES", k_root.parent / "shared" / "scenes")))
    parser.add_argument("--only", default="", help="cases whose arguments hold this word")
    parser.add_argument("--list", action="store_true", help="the cases alone")
    options = parser.parse_args()
    for case in cases():
        name = " ".join(case)
        if options.only not in name:
            continue
        if options.list:
            print(name)
            continue
        if not case[0].startswith("builtin:"):
            if not (options.scenes / case[0]).is_file():
                print(f"left out: {name}: not there", file=sys.stderr)
                continue
            case = [str(options.scenes / case[0]), *case[1:]]
        if (found := hash_of(options.program, case)) is not None:
            print(found, name, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
