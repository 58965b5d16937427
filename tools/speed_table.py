#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the table of whole frames in docs/decisions/whole-frame.md: the median of frames, in milliseconds.

    speed_table.py [PROGRAM] [--only WORDS] [--scenes FOLDER]

All cores should be free, for some 20 minutes; `--only` runs the rows that contain its words. A row is measured with one
sample a pixel and one bounce, and with the defaults: samples where something ends, all bounces.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

KITCHEN = "bart/kitchen/aff/kitchen.aff"
CORNELL = "builtin:cornell"
STILL = "builtin:spheres?objects=40&dynamic=0"


def row(name, scene, frames, size, first):
    """first: only the first frame counts; else all but the first two, of which the first is cold."""
    return {"name": name, "scene": scene, "frames": frames, "size": size, "first": first}


ROWS = [
    row("Kitchen, camera moves", KITCHEN, "121-150", "512x512", False),
    row("Kitchen, first frame", KITCHEN, "121-121", "512x512", True),
    row("Sponza, first frame", "sponza/sponza.obj", "1-1", "512x512", True),
    row("kinetic, first frame", "builtin:kinetic", "1-1", "1280x720", True),
    row("kinetic, later frames", "builtin:kinetic", "1-8", "1280x720", False),
    row("Cornell's box, the ball moves", CORNELL, "1-12", "1920x1080", False),
    row("spheres, nothing moves", STILL, "1-6", "1920x1080", False),
    row("Kitchen, 256", KITCHEN, "161-166", "256x256", False),
    row("Kitchen, 512", KITCHEN, "161-166", "512x512", False),
    row("Kitchen, 1024", KITCHEN, "161-166", "1024x1024", False),
    row("Kitchen, 2048", KITCHEN, "161-164", "2048x2048", False),
]


def milliseconds(program, scenes, of, options):
    scene = of["scene"] if of["scene"].startswith("builtin:") else str(Path(scenes) / of["scene"])
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "render", scene, "-o", f"{folder}/{{frame:04}}.png", "--frames", of["frames"], "--size",
                   of["size"], "--json", *options]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"speed_table: {' '.join(command)}: {done.stderr.strip()}")
    times = [frame["ms"] for frame in json.loads(done.stdout)["frames"]]
    times = times[:1] if of["first"] else times[2:]
    return statistics.median(times), min(times), max(times)


def text(number):
    return f"{number:,.0f}" if number >= 10 else f"{number:.2g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="build/release/gnomon")
    parser.add_argument("--only", default="", help="rows whose names contain this")
    parser.add_argument("--scenes", default=os.environ.get("GNOMON_SCENES", "../shared/scenes"))
    arguments = parser.parse_args()
    print("| median ms (least, most) | one sample, one bounce | the defaults |\n|---|---|---|")
    for of in ROWS:
        if arguments.only not in of["name"]:
            continue
        if not of["scene"].startswith("builtin:") and not (Path(arguments.scenes) / of["scene"]).exists():
            print(f"| {of['name']} | skipped: the scene is missing | |")
            continue
        cells = [milliseconds(arguments.program, arguments.scenes, of, options)
                 for options in (["--samples", "1", "--bounces", "1"], [])]
        shown = " | ".join(f"{text(median)} ({text(least)}, {text(most)})" for median, least, most in cells)
        print(f"| {of['name']}, {of['size']}, frames {of['frames']} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
