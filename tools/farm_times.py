#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what a chunk of a video costs, and prints the tables of docs/guide/farm.md.

Each chunk is a run of its own with one thread; times are processor time, which other work on the machine hardly
affects. A chunk of L frames costs cold + L * steady. `cold` is the start of the program, the scene, the trees of rays and
the caches that the first frame fills; `steady` is a frame whose caches are full.

    farm_times.py [--program PATH] [--size WxH] [NAME=SCENE[,option...] ...]
"""
import argparse
import json
import math
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

LENGTHS = (1, 2, 4, 16)
MACHINES = (1, 2, 10, 100, 1000)
OVERHEAD = 0.1   # of a chunk's time, at most, for the best length


def processor_seconds(command):
    """Runs a command; returns the processor time of it and its children, in seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(program, scene, options, size, folder):
    """Times of chunks in the middle of the clip by their length, of joining a frame, and the number of frames."""
    info = subprocess.run([program, "info", scene, "--json", "--quiet"] + [o for o in options if "fps" in o], check=True,
                          stdout=subprocess.PIPE)
    frames = json.loads(info.stdout)["frames"]
    if "--turntable" in options:
        frames = round(24 * float(options[options.index("--turntable") + 1]))
    first = max(1, frames // 2)
    render = [program, "render", scene, *options, "--size", size, "--threads", "1", "--quiet"]
    times = {}
    for length in LENGTHS:
        out = str(Path(folder) / f"{length}.mp4")
        whole = ["--frames", f"{first}-{first + length - 1}"]
        times[length] = processor_seconds(render + ["-o", out, *whole, "--chunk", f"{first}-{first + length - 1}"])
    join = processor_seconds([program, "join", str(Path(folder) / f"{LENGTHS[-1]}.mp4"), "--quiet"])
    return times, join / LENGTHS[-1], frames


def chunk_time(cost, length):
    return cost["cold"] + length * cost["steady"]


def video_time(cost, length, machines):
    """Seconds until the video is there: rounds of chunks on all machines, then the encoder on one."""
    rounds = math.ceil(math.ceil(cost["frames"] / length) / machines)
    return rounds * chunk_time(cost, min(length, cost["frames"])) + cost["frames"] * cost["join"]


def best_length(cost):
    """The shortest chunk of which the cold start is at most a tenth."""
    length = cost["cold"] * (1 - OVERHEAD) / OVERHEAD / cost["steady"]
    return min(cost["frames"], max(1, math.ceil(length)))


def shown(seconds):
    if seconds < 100:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/gnomon")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("scenes", nargs="*", default=["kinetic=builtin:kinetic"])
    arguments = parser.parse_args()

    costs = {}
    for word in arguments.scenes:
        name, scene = word.split("=", 1)
        scene, *options = scene.split(",")
        with tempfile.TemporaryDirectory() as folder:
            times, join, frames = measure(arguments.program, scene, options, arguments.size, folder)
        longest, middle = LENGTHS[-1], LENGTHS[-2]
        steady = (times[longest] - times[middle]) / (longest - middle)
        costs[name] = {"frames": frames, "steady": steady, "cold": max(0.0, times[middle] - middle * steady), "join": join}
        print(f"# {name}: " + ", ".join(f"{length}: {t:.2f} s" for length, t in times.items()), file=sys.stderr, flush=True)

    print("| scene | frames | cold start | a frame after it | join, a frame | shortest chunk with 10 % overhead |")
    print("|---|--:|--:|--:|--:|--:|")
    for name, cost in costs.items():
        print(f"| {name} | {cost['frames']} | {shown(cost['cold'])} | {shown(cost['steady'])} | "
              f"{1000 * cost['join']:.0f} ms | {best_length(cost)} |")
    print("\n| scene | chunks of | " + " | ".join(f"{n:,} machine{'s' if n > 1 else ''}" for n in MACHINES) + " |")
    print("|---|--:|" + "--:|" * len(MACHINES))
    for name, cost in costs.items():
        for length in sorted({1, best_length(cost), 10 * best_length(cost)}):
            if length > cost["frames"]:
                continue
            cells = " | ".join(shown(video_time(cost, length, n)) for n in MACHINES)
            print(f"| {name} | {length} | {cells} |")
        even = [max(1, math.ceil(cost["frames"] / n)) for n in MACHINES]
        cells = " | ".join(f"{shown(video_time(cost, length, n))} ({length})" for n, length in zip(MACHINES, even))
        print(f"| {name} | one for each machine | {cells} |")


if __name__ == "__main__":
    main()
