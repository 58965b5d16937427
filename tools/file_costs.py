#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints what rendering each file of a folder costs: processor time, peak memory, exit code, number of warnings.

    file_costs.py FOLDER [--program PROGRAM] [--size WxH] [--limit-s SECONDS] [--only WORD] [--slowest N]
                  [--images DIR] [--list FILE] [--most-s SECONDS] [--most-mb MB] [-- OPTION ...]

Renders the first frame of every .gltf, .glb, .obj, .ply, .stl and .aff file below FOLDER, one after the other, with the
program's default options but for the size; options after -- are passed on. Files whose parts lie in several files of
one folder (a .gltf and its .bin) count once. A file that takes longer than the limit, by wall time, is stopped.

The table is in the order of the cost, and holds
  cpu_s    processor time of the program, user and system, of all threads
  mb       its peak memory (maximum resident set size), in units of 10^6 bytes
  exit     its exit code; "limit" where it was stopped
  warns    how many lines of warnings it printed
Exits with 1 if a file was stopped, failed by a bug or a signal, or cost more than --most-s or --most-mb allows. Files
that the program refuses (exit code 3) do not count as failures.
"""
import argparse
import dataclasses
import os
import pathlib
import subprocess
import sys
import tempfile
import threading

k_root = pathlib.Path(__file__).resolve().parent.parent
k_endings = {".gltf", ".glb", ".obj", ".ply", ".stl", ".aff"}
k_refused = 3   # the program's exit code for a file that it cannot read


@dataclasses.dataclass
class Cost:
    name: str
    cpu_s: float
    mb: float
    exit: str
    warnings: int

    def row(self) -> str:
        return f"{self.cpu_s:8.2f} {self.mb:7.0f}  {self.exit:>5} {self.warnings:6}  {self.name}"


def scene_files(folder: pathlib.Path, only: str) -> list[pathlib.Path]:
    files = [f for f in folder.rglob("*") if f.suffix.lower() in k_endings and f.is_file()]
    return sorted(f for f in files if only in str(f.relative_to(folder)))


def cost_of(program: str, file: pathlib.Path, name: str, image: pathlib.Path, size: str, limit_s: float,
            options: list[str]) -> Cost:
    """Renders one file, and measures the process."""
    with tempfile.TemporaryFile() as messages:
        process = subprocess.Popen([program, "render", str(file), "-o", str(image), "--size", size, *options],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=messages)
        stopped = threading.Event()

        def stop():
            stopped.set()
            process.kill()

        timer = threading.Timer(limit_s, stop)
        timer.start()
        try:
            _, status, usage = os.wait4(process.pid, 0)
        finally:
            timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        text = messages.read().decode(errors="replace")
    code = "limit" if stopped.is_set() else str(process.returncode)
    warnings = sum("warning" in line for line in text.splitlines())
    return Cost(name, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6, code, warnings)


def split_at_dashes(arguments: list[str]) -> tuple[list[str], list[str]]:
    """The arguments before and after --."""
    at = arguments.index("--") if "--" in arguments else len(arguments)
    return arguments[:at], arguments[at + 1:]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default=str(k_root / "build/release/gnomon"))
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--limit-s", type=float, default=300, help="wall time that a file may take")
    parser.add_argument("--only", default="", help="files whose path contains this word")
    parser.add_argument("--list", type=pathlib.Path, help="only files whose path contains a line of this file")
    parser.add_argument("--slowest", type=int, help="print these alone")
    parser.add_argument("--images", type=pathlib.Path, help="keep the images in this folder")
    parser.add_argument("--most-s", type=float, help="processor time from which on a file counts as a failure")
    parser.add_argument("--most-mb", type=float, help="likewise, memory")
    # Apart, because argparse takes what follows -- for options of its own if others stand between.
    own, options = split_at_dashes(sys.argv[1:])
    args = parser.parse_args(own)

    files = scene_files(args.folder, args.only)
    if args.list:
        words = args.list.read_text().split()
        files = [f for f in files if any(word in str(f.relative_to(args.folder)) for word in words)]
    if not files:
        print(f"no scene files in {args.folder}", file=sys.stderr)
        return 2
    costs = []
    with tempfile.TemporaryDirectory() as scratch:
        images = args.images or pathlib.Path(scratch)
        images.mkdir(parents=True, exist_ok=True)
        for file in files:
            name = str(file.relative_to(args.folder))
            image = images / (name.replace("/", "__") + ".png")
            costs.append(cost_of(args.program, file, name, image, args.size, args.limit_s, options))
            if sys.stderr.isatty():
                print(costs[-1].row(), file=sys.stderr)
    costs.sort(key=lambda cost: -cost.cpu_s)
    print(f"{'cpu_s':>8} {'mb':>7}  {'exit':>5} {'warns':>6}  file")
    for cost in costs[:args.slowest]:
        print(cost.row())

    good = {"0", str(k_refused)}
    bad = [c for c in costs if c.exit not in good or (args.most_s is not None and c.cpu_s >= args.most_s) or
           (args.most_mb is not None and c.mb >= args.most_mb)]
    print(f"{len(costs)} files, {sum(c.cpu_s for c in costs):.1f} s; "
          f"{sum(c.exit == str(k_refused) for c in costs)} refused, {len(bad)} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
