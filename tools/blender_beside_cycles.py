# SPDX-License-Identifier: Apache-2.0
"""Measures the add-on for Blender beside Cycles, on the courtyard of examples/blender:

    GNOMON_PYTHON=build/release/python blender -b --factory-startup -P tools/blender_beside_cycles.py -- [--size 160x90]

Prints the processor time of frames, the samples with which Cycles errs as little, and flicker. Errors are root mean squares
of 8-bit levels as shown, each against the engine's own converged frame; Cycles' are fitted to its samples, because they fall
with the square root. Flicker is the mean of |(b - a) - (b' - a')| over two frames a and b and the converged ones, in levels,
with a new seed in each frame."""
from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile

import bpy
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path[:0] = [os.path.join(ROOT, "blender"), os.path.join(ROOT, "examples", "blender")]

import courtyard  # noqa: E402
import gnomon_render  # noqa: E402

gnomon_render.register()


def processor_seconds() -> float:
    return sum(resource.getrusage(resource.RUSAGE_SELF)[:2])


def shown(path: str) -> np.ndarray:
    """8-bit levels of an image of linear light, as Blender's standard view shows it."""
    image = bpy.data.images.load(path, check_existing=False)
    pixels = np.empty(image.size[0] * image.size[1] * image.channels, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    pixels = np.clip(pixels.reshape(-1, image.channels)[:, :3], 0, 1)
    bpy.data.images.remove(image)
    return 255 * np.where(pixels <= 0.0031308, pixels * 12.92, 1.055 * pixels ** (1 / 2.4) - 0.055)


def animate(engine: str, first: int, last: int) -> tuple:
    """(images, processor seconds of each frame)"""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.frame_start, scene.frame_end = first, last
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    times = [processor_seconds()]

    def note(*_):
        times.append(processor_seconds())

    bpy.app.handlers.render_post.append(note)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "image_####")
        bpy.ops.render.render(animation=True)
        images = [shown(os.path.join(folder, f"image_{number:04}.exr")) for number in range(first, last + 1)]
    bpy.app.handlers.render_post.remove(note)
    return images, np.diff(times)


def error(image: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.mean((image - truth) ** 2)))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--cycles-truth", type=int, default=1024, help="samples of Cycles' converged frames")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    with tempfile.TemporaryDirectory() as folder:
        courtyard.make(folder)
        scene = bpy.context.scene
        scene.render.resolution_x, scene.render.resolution_y = map(int, arguments.size.split("x"))
        scene.render.resolution_percentage = 100
        last = arguments.frames

        images, seconds = animate("GNOMON", 1, last)
        scene.gnomon.adaptive, scene.gnomon.samples, scene.gnomon.filter = False, 256, "blackman-harris"
        truth, _ = animate("GNOMON", last - 1, last)
        ours = error(images[-1], truth[-1])
        flicker = np.mean(np.abs((images[-1] - images[-2]) - (truth[-1] - truth[-2])))
        print(f"RESULT Gnomon: frame 1 {seconds[0]:.2f} s, others {np.mean(seconds[1:]):.2f} s; error {ours:.2f}, flicker {flicker:.2f}")

        cycles = scene.cycles
        cycles.use_denoising, cycles.use_adaptive_sampling, cycles.use_animated_seed = False, False, True
        cycles.samples = arguments.cycles_truth
        truth, _ = animate("CYCLES", last - 1, last)
        for samples in (16, 64, 256):
            cycles.samples = samples
            cycles.seed = 1
            images, seconds = animate("CYCLES", last - 1, last)
            flicker = np.mean(np.abs((images[-1] - images[-2]) - (truth[-1] - truth[-2])))
            # The truth has an error of its own, of the same kind.
            measured = error(images[-1], truth[-1])
            own = measured / np.sqrt(1 + samples / arguments.cycles_truth)
            needed = samples * (own / ours) ** 2
            print(f"RESULT Cycles, {samples} samples: {seconds[-1]:.2f} s; error {own:.2f}, flicker {flicker:.2f}; "
                  f"as little error with {needed:.0f} samples, {seconds[-1] * needed / samples:.1f} s")


main()
