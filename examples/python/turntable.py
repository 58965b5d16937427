#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A turntable: the camera circles a model once.

    turntable.py [FILE] [--frames N] [--width PIXELS] [--out FOLDER] [--video FILE.mp4]

Renders a scene file, or without one a little still life. Writes turntable-0001.png and so on, and with --video pipes them
to ffmpeg as well. Ctrl-C stops at once.
"""
import argparse
import math
import subprocess
import sys
from pathlib import Path

import gnomon
import shapes


def still_life() -> gnomon.Scene:
    with gnomon.SceneBuilder() as builder:
        ball, tin = shapes.add(builder, shapes.sphere()), shapes.add(builder, shapes.cylinder(around=96))
        ring, cone = shapes.add(builder, shapes.torus()), shapes.add(builder, shapes.cone(around=96))
        clay, slate = shapes.paint(builder, 0.6, 0.26, 0.15, 0.75), shapes.paint(builder, 0.25, 0.26, 0.28, 0.35)
        gold, blue = shapes.paint(builder, 0.95, 0.7, 0.3, 0.22, 1), shapes.paint(builder, 0.04, 0.13, 0.38, 0.25)
        glass = builder.material(gnomon.Material(base_color=(0.95, 0.98, 0.97), roughness=0, transmission=1, ior=1.5))

        def put(mesh: gnomon.MeshId, material: gnomon.MaterialId, x: float, y: float, z: float, *size: float) -> None:
            builder.instance(mesh, material, gnomon.compose(gnomon.translation(x, y, z), gnomon.scaling(*size)))

        put(tin, slate, 0, -0.08, 0, 1.25, 0.08, 1.25)
        put(tin, shapes.paint(builder, 0.55, 0.53, 0.5, 0.9), 0, -0.1, 0, 300, 0.02, 300)
        put(ball, clay, -0.42, 0.34, -0.2, 0.34)
        put(ring, gold, 0.42, 0.1, 0.42, 0.33)
        put(cone, blue, 0.42, 0, -0.42, 0.3, 0.8, 0.3)
        put(ball, glass, -0.22, 0.2, 0.55, 0.2)
        builder.area_light(gnomon.AreaLight(shape="disc", width=1.2, radiance=(24, 22, 19)),
                           gnomon.look_at((2.2, 3, 1.2), (0, 0.2, 0)))
        shapes.sky(builder, 0.7)
        builder.camera(gnomon.Camera(transform=gnomon.look_at((0, 1.35, 3.4), (0, 0.24, 0)), vertical_fov=0.6))
        return builder.finish()


def main() -> int:
    parser = argparse.ArgumentParser(description="the camera circles a model once")
    parser.add_argument("file", nargs="?", help="a scene file, or builtin:NAME")
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--out", type=Path, default=Path("."))
    parser.add_argument("--video", type=Path, help="also encode them by ffmpeg")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    width, height = arguments.width, arguments.width * 9 // 16

    def show(stage: str, done: float) -> None:
        if sys.stderr.isatty():
            print(f"\r{stage} {100 * done:3.0f} % ", end="", file=sys.stderr, flush=True)

    encoder = None
    try:
        scene = gnomon.load(arguments.file, progress=show) if arguments.file else still_life()
        for warning in scene.info.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        if arguments.video:
            encoder = subprocess.Popen(
                ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
                 "-r", "24", "-i", "-", "-pix_fmt", "yuv420p", str(arguments.video)], stdin=subprocess.PIPE)
        with gnomon.Renderer(size=(width, height), samples="auto", exposure=0.3) as renderer:
            for number in range(arguments.frames):
                frame = renderer.render(scene, turn=2 * math.pi * number / arguments.frames, progress=show)
                frame.write(arguments.out / f"turntable-{number + 1:04}.png")
                if encoder and encoder.stdin:
                    encoder.stdin.write(frame.srgb8().tobytes())
                print(f"frame {number + 1}: {frame.milliseconds:.0f} ms")
    except gnomon.InputError as error:
        print(f"{error.file}, {error.place or 'as a whole'}: {error.problem}", file=sys.stderr)
        return 3
    except gnomon.Error as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return 130
    finally:
        if encoder and encoder.stdin:
            encoder.stdin.close()
            encoder.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
