#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints what adaptive samples cost and how far they are from many samples, by scene.

    sample_quality.py [--program PROGRAM] [--scenes DIR] [--size 320x180] [--truth 256] [--only WORD] [--keep DIR]
                      [--modes "auto|4|16"]

For each scene, a short clip is rendered with one sample a pixel and in each mode, on one thread. Times are those of the
frames after the first one, when caches are filled, from the stages that the program measures. The last frame is compared
with the same frame of --truth samples a pixel: FLIP of the images as they are shown, RMSE of linear light. The filter is
the same on both sides: --filter, blackman-harris by default. `box` compares with the truth of that many samples by the
box filter, which is what `--samples N` alone makes. `refined` is the share of pixels with more than one sample.

Modes are values of --samples, with further options behind blanks: "auto --filter box". With --keep, images stay in that
folder, and a truth that is there is used again.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import tempfile

k_root = pathlib.Path(__file__).resolve().parent.parent
k_frames = 4   # of a clip
# Scene, first frame, further options.
k_scenes = [
    ("bart/kitchen/aff/kitchen.aff", 121, []),
    ("bart/robots/aff/Robot.aff", 40, []),
    ("sponza/sponza.obj", 1, ["--turntable", "40"]),
    ("builtin:kinetic", 12, []),
    ("builtin:cornell", 1, []),
]


def render(program: str, scene: str, out: str, options: list[str]) -> dict:
    """The JSON document of a rendering."""
    result = subprocess.run([program, "render", scene, "-o", out, "--threads", "1", "--quiet", "--json", *options],
                            check=True, capture_output=True, text=True)
    return json.loads(result.stdout)


def compare(program: str, image: pathlib.Path, truth: pathlib.Path, metric: str) -> float:
    result = subprocess.run([program, "compare", str(image), str(truth), "--json", "--quiet"], check=True,
                            capture_output=True, text=True)
    return json.loads(result.stdout)[metric]


def milliseconds(document: dict) -> float:
    """Of the frames after the first, all stages together."""
    return sum(sum(frame["stages"].values()) for frame in document["frames"][1:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(k_root / "build/release/gnomon"))
    parser.add_argument("--scenes", default=os.environ.get("GNOMON_SCENES", ""))
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--truth", default="256")
    parser.add_argument("--filter", default="blackman-harris")
    parser.add_argument("--modes", default="auto")
    parser.add_argument("--exposure", default="0")
    parser.add_argument("--only", default="")
    parser.add_argument("--keep")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))

    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(options.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        print(f"{'scene':10} {'mode':>8} {'FLIP':>7} {'FLIP box':>8} {'RMSE':>7} {'time':>6} {'refined':>8} {'shaded':>7}")
        flips: dict[str, list[float]] = {}
        ratios: dict[str, list[float]] = {}
        for scene, first, more in k_scenes:
            path = scene if scene.startswith("builtin:") else os.path.join(options.scenes, scene)
            if options.only not in scene or (not scene.startswith("builtin:") and not os.path.exists(path)):
                continue
            name = pathlib.Path(scene).stem.removeprefix("builtin:").lower()
            last = first + k_frames - 1
            common = [*more, "--size", options.size]
            # One exposure for all images of a scene, so that they differ by their samples alone.
            exposed = ["--exposure", options.exposure]

            truths = {}
            for kind in (options.filter, "box"):
                for suffix in (".png", ".exr"):
                    truths[kind + suffix] = folder / f"{name}-{options.size}-{options.truth}-{kind}{suffix}"
                    if not truths[kind + suffix].exists():
                        render(options.program, path, str(truths[kind + suffix]),
                               [*common, *exposed, "--frame", str(last), "--samples", options.truth, "--filter", kind])
            for mode in ["1", *options.modes.split("|")]:
                words = mode.split()
                clip = render(options.program, path, str(folder / "clip-{frame:04}.exr"),
                              [*common, *exposed, "--frames", f"{first}-{last}", "--samples", *words])
                files = {}
                for suffix in (".png", ".exr"):
                    files[suffix] = folder / f"{name}-{options.size}-{'-'.join(words)}{suffix}"
                    render(options.program, path, str(files[suffix]),
                           [*common, *exposed, "--frame", str(last), "--samples", *words])
                flip = compare(options.program, files[".png"], truths[options.filter + ".png"], "flip")
                box = compare(options.program, files[".png"], truths["box.png"], "flip")
                rmse = compare(options.program, files[".exr"], truths[options.filter + ".exr"], "rmse")
                if mode == "1":
                    single = milliseconds(clip)
                samples = clip["frames"][-1].get("samples", {})
                refined = samples.get("pixels", 0) / (width * height)
                shaded = samples.get("shaded", 0) / (width * height)
                ratio = milliseconds(clip) / single
                flips.setdefault(mode, []).append(flip)
                ratios.setdefault(mode, []).append(ratio)
                print(f"{name:10} {mode:>8} {flip:7.4f} {box:8.4f} {rmse:7.4f} {ratio:6.2f} {refined:8.1%} {shaded:7.2f}",
                      flush=True)
        for mode, values in flips.items():
            print(f"median     {mode:>8} {statistics.median(values):7.4f} {'':8} {'':7} "
                  f"{statistics.median(ratios[mode]):6.2f}")


if __name__ == "__main__":
    main()
