#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders frames under each instruction set that this machine has, and compares their bytes.

    same_bytes.py [--program PROGRAM] [--scenes DIR] [--only WORDS] [--full | --valgrind]

The environment variable GNOMON_ISA limits the program. With --valgrind, each case of a list of small ones is also
rendered by a program that runs in valgrind, which hides AVX-512 and computes approximate reciprocals in a way of its own:
a third make of processor. --full renders the long list, and --only the rows that contain WORDS. Scenes that are not
there are left out, with a line on standard error. The exit code is 1 if a frame differs or no case was compared, and 77
if the machine has one instruction set only.
"""
import argparse
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

k_root = pathlib.Path(__file__).resolve().parent.parent
k_sets = ["sse4.2", "avx", "avx2", "avx512"]
k_skipped = 77

# Rendering kinetic costs most in its first frame, and grows with its size: the rows are as small as shows what they are
# about.
k_short = [
    ["builtin:cornell", "--size", "96x96", "--frames", "1-5"],
    ["builtin:kinetic", "--size", "48x27", "--frames", "45-46"],
    ["builtin:kinetic", "--size", "32x18", "--frames", "45-45", "--samples", "4", "--sun-size", "2"],
    ["builtin:spheres?objects=30&dynamic=20", "--size", "96x96", "--frames", "1-3", "--indirect", "off"],
    ["builtin:cornell", "--size", "64x64", "--frames", "2-2", "--indirect", "quadtree"],
    ["builtin:cornell", "--size", "64x64", "--frames", "2-2", "--indirect", "rsm"],
    ["builtin:cornell", "--size", "48x48", "--frames", "2-2", "--reference", "--spp", "4"],
]
k_long = k_short + [
    # A cold frame and seven warm ones, in which objects and the camera move.
    ["builtin:kinetic", "--size", "96x54", "--frames", "42-49"],
    ["builtin:kinetic", "--size", "64x36", "--frames", "45-45", "--samples", "4", "--sun-size", "2"],
    ["builtin:kinetic", "--size", "48x27", "--frames", "45-46", "--shadow-culling", "off"],
    ["builtin:kinetic", "--size", "32x18", "--frames", "45-46", "--shadow-culling", "paper"],
    ["builtin:kinetic", "--size", "96x54", "--frames", "45-46", "--indirect", "quadtree", "--receivers", "full"],
    ["builtin:kinetic", "--size", "64x36", "--frames", "45-45", "--reference", "--spp", "8"],
    ["builtin:kinetic", "--size", "32x18", "--frames", "45-46", "--accelerator", "kdtree"],
    ["builtin:kinetic", "--size", "32x18", "--frames", "45-46", "--environment", "builtin:studio"],
    ["bart/kitchen/aff/kitchen.aff", "--size", "512x512", "--frames", "300-302"],
    ["bart/kitchen/aff/kitchen.aff", "--size", "256x256", "--frames", "121-132"],
    ["bart/robots/aff/Robot.aff", "--size", "320x240", "--frames", "1-8"],
    ["sponza/sponza.obj", "--size", "384x216", "--frames", "1-1"],
    ["stanford/stanford-bunny.obj", "--size", "256x256", "--frames", "1-1"],
    ["gltf/CesiumMilkTruck.glb", "--size", "256x256", "--frames", "1-4"],
    ["real/RiggedFigure/RiggedFigure.glb", "--size", "256x256", "--frames", "1-6"],
    ["gltf/InterpolationTest.glb", "--size", "256x256", "--frames", "1-6"],
]
# For valgrind, which takes some 50 times as long.
k_in_valgrind = [
    ["builtin:cornell", "--size", "32x32", "--frames", "1-3"],
    ["builtin:kinetic", "--size", "16x9", "--frames", "45-45"],
    ["builtin:kinetic", "--size", "48x27", "--frames", "45-46", "--indirect", "off"],
    ["builtin:spheres?objects=30&dynamic=20", "--size", "96x96", "--frames", "1-3", "--indirect", "off"],
    ["builtin:cornell", "--size", "64x64", "--frames", "2-2", "--indirect", "quadtree"],
    ["builtin:cornell", "--size", "64x64", "--frames", "2-2", "--indirect", "rsm"],
    ["builtin:cornell", "--size", "48x48", "--frames", "2-2", "--reference", "--spp", "4"],
]


# Highway's library reads the processor's clock while it is loaded, by an instruction that valgrind lacks on some
# processors. Nothing here needs the result.
k_timer = """namespace hwy { namespace platform {
double TimerResolution();
double TimerResolution() { return 1e-8; }
} }
"""


def timer_library(folder: str) -> str | None:
    """A library that replaces that function, to be loaded first; None without a compiler."""
    compiler = shutil.which(os.environ.get("CXX", "c++"))
    if not compiler:
        return None
    source, library = pathlib.Path(folder, "timer.cpp"), f"{folder}/libtimer.so"
    source.write_text(k_timer)
    subprocess.run([compiler, "-shared", "-fPIC", str(source), "-o", library], check=True)
    return library


def sets_of_processor(program: str) -> list[str]:
    last = json.loads(subprocess.run([program, "devices", "--json"], capture_output=True, check=True,
                                     env=environment(None)).stdout)["cpu"]["instruction_set"]
    return k_sets[:k_sets.index(last) + 1]


def environment(limit: str | None) -> dict:
    variables = {name: value for name, value in os.environ.items() if name != "GNOMON_ISA"}
    return variables | ({"GNOMON_ISA": limit} if limit else {})


def hash_of(command: list[str], arguments: list[str], limit: str | None) -> str:
    with tempfile.TemporaryDirectory() as folder:
        result = subprocess.run([*command, "render", *arguments, "-o", f"{folder}/f-{{frame:04}}.exr", "--quiet"],
                                capture_output=True, text=True, stdin=subprocess.DEVNULL, env=environment(limit))
        if result.returncode:
            raise SystemExit(f"{' '.join(arguments)} under {limit}: exit {result.returncode}: {result.stderr.strip()}")
        content = hashlib.sha256()
        for file in sorted(pathlib.Path(folder).iterdir()):
            content.update(file.name.encode() + b"\0" + file.read_bytes())
        return content.hexdigest()[:16]


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=str(k_root / "build/release/gnomon"))
    parser.add_argument("--scenes", default=os.environ.get("GNOMON_SCENES", str(k_root.parent / "shared/scenes")))
    parser.add_argument("--only", default="")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--full", action="store_true")
    which.add_argument("--valgrind", action="store_true")
    options = parser.parse_args()

    sets = sets_of_processor(options.program)
    if len(sets) < 2:
        print(f"this processor has {sets[0]} alone", file=sys.stderr)
        return k_skipped
    runs = [(name, [options.program], name) for name in sets]
    if options.valgrind and not shutil.which("valgrind"):
        print("left out: valgrind is not installed", file=sys.stderr)
    elif options.valgrind:
        timer = timer_library(tempfile.mkdtemp())
        preload = ["env", f"LD_PRELOAD={timer}"] if timer else []
        runs.append(("valgrind", [*preload, "valgrind", "--tool=none", "-q", options.program], None))

    cases = differ = 0
    for arguments in k_long if options.full else k_in_valgrind if options.valgrind else k_short:
        if options.only not in " ".join(arguments):
            continue
        if not arguments[0].startswith("builtin:"):
            file = pathlib.Path(options.scenes) / arguments[0]
            if not file.exists():
                print(f"left out: {file} is not there", file=sys.stderr)
                continue
            arguments = [str(file), *arguments[1:]]
        start = time.monotonic()
        hashes = {name: hash_of(command, arguments, limit) for name, command, limit in runs}
        same = len(set(hashes.values())) == 1
        cases += 1
        differ += not same
        text = hashes[sets[0]] if same else " ".join(f"{name}={value}" for name, value in hashes.items())
        print(f"{'same' if same else 'DIFFERENT'}  {text}  {' '.join(arguments)}  ({time.monotonic() - start:.0f} s)",
              flush=True)
    print(f"{cases} cases under {', '.join(name for name, _, _ in runs)}: {differ} different")
    if cases == 0:
        raise SystemExit("no case was compared")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
