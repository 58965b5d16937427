#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what a chunk of a video costs, and prints the tables of docs/guide/farm.md.

Each chunk is a run of its own with one thread; times are processor time, which other work on the machine affects least. A
frame after the first ones costs `steady`: the difference of the two longest chunks. The `cold` start is what a chunk costs
beyond that: the start of the program, the scene, the trees of rays, and the caches that the first frames fill.

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
    """As measured, linearly between the lengths that were measured, and by `steady` frames beyond."""
    times, lengths = cost["times"], sorted(cost["times"])
    for a, b in zip(lengths, lengths[1:]):
        if a <= length <= b:
            return times[a] + (times[b] - times[a]) * (length - a) / (b - a)
    return times[lengths[-1]] + (length - lengths[-1]) * cost["steady"]


def video_time(cost, length, machines):
    """Seconds until the video is there: rounds of chunks on all machines, then the encoder on one."""
    rounds = math.ceil(math.ceil(cost["frames"] / length) / machines)
    return rounds * chunk_time(cost, min(length, cost["frames"])) + cost["frames"] * cost["join"]


def best_length(cost):
    """The shortest chunk of which the cold start is at most a tenth."""
    for length in range(1, cost["frames"]):
        if chunk_time(cost, length) - length * cost["steady"] <= OVERHEAD * chunk_time(cost, length):
            return length
    return cost["frames"]


def shown(seconds):
    value, unit = (seconds, "s") if seconds < 100 else (seconds / 60, "min") if seconds < 6000 else (seconds / 3600, "h")
    return f"{value:.1f} {unit}" if value < 10 else f"{value:.0f} {unit}"


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
        costs[name] = {"frames": frames, "times": times, "steady": steady, "cold": times[longest] - longest * steady,
                       "join": join}
        print(f"# {name}: " + ", ".join(f"{length}: {t:.2f} s" for length, t in times.items()), file=sys.stderr, flush=True)
    print_tables(costs)


def print_tables(costs):
    print("| scene | frames | " + " | ".join(f"chunk of {n}" for n in LENGTHS) +
          " | cold start | a later frame | join, a frame | best chunk |")
    print("|---|" + "--:|" * (len(LENGTHS) + 5))
    for name, cost in costs.items():
        chunks = " | ".join(shown(cost["times"][n]) for n in LENGTHS)
        print(f"| {name} | {cost['frames']} | {chunks} | {shown(cost['cold'])} | {shown(cost['steady'])} | "
              f"{1000 * cost['join']:.0f} ms | {best_length(cost)} |")
    print("\n| scene | chunks of | " + " | ".join(f"{n:,} machine{'s' if n > 1 else ''}" for n in MACHINES) + " |")
    print("|---|--:|" + "--:|" * len(MACHINES))
    for name, cost in costs.items():
        for length in sorted({1, best_length(cost)}):
            cells = " | ".join(shown(video_time(cost, length, n)) for n in MACHINES)
            print(f"| {name} | {length} | {cells} |")
        even = [max(1, math.ceil(cost["frames"] / n)) for n in MACHINES]
        cells = " | ".join(f"{shown(video_time(cost, length, n))} ({length})" for n, length in zip(MACHINES, even))
        print(f"| {name} | one for each machine | {cells} |")


if __name__ == "__main__":
    main()
