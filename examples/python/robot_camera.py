#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The camera of a robot: calibrated as OpenCV does it, it drives along a shelf and lists what it sees.

    robot_camera.py [--frames N] [--width PIXELS] [--out FOLDER]

Writes robot-N.png (colour), robot-N-depth.png and robot-N-ids.png. Depth is in metres along the camera's axis, so that a
pixel and its depth give a point in space by the intrinsics alone.
"""
import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt

import gnomon
import images
import shapes

# As calibrated for images of 640 x 480 pixels.
k_size = (640, 480)
k_matrix = np.array([[525.0, 0, 319.2], [0, 525.0, 236.8], [0, 0, 1]])


def make_scene() -> gnomon.Scene:
    with gnomon.SceneBuilder() as builder:
        block, ball = shapes.add(builder, shapes.box()), shapes.add(builder, shapes.sphere())
        tin, cone = shapes.add(builder, shapes.cylinder()), shapes.add(builder, shapes.cone())
        ring = shapes.add(builder, shapes.torus())
        wood = shapes.paint(builder, 0.42, 0.26, 0.14, 0.5)
        wall, floor = shapes.paint(builder, 0.62, 0.6, 0.55, 0.9), shapes.paint(builder, 0.3, 0.3, 0.31, 0.35)
        red, blue = shapes.paint(builder, 0.65, 0.07, 0.05, 0.35), shapes.paint(builder, 0.05, 0.16, 0.5, 0.4)
        green, yellow = shapes.paint(builder, 0.08, 0.36, 0.12, 0.5), shapes.paint(builder, 0.75, 0.5, 0.06, 0.45)
        steel, white = shapes.paint(builder, 0.6, 0.6, 0.62, 0.3, 1), shapes.paint(builder, 0.75, 0.74, 0.7, 0.6)

        def put(name: str, mesh: gnomon.MeshId, material: gnomon.MaterialId, place: tuple[float, float, float],
                size: tuple[float, float, float], turn: float = 0.0) -> None:
            builder.instance(mesh, material, gnomon.compose(gnomon.translation(*place), gnomon.rotation((0, 1, 0), turn),
                                                            gnomon.scaling(*size)), name=name)

        put("floor", block, floor, (0, -0.05, 0), (9, 0.1, 6))
        put("wall", block, wall, (0, 1.5, -1.1), (9, 3, 0.1))
        for level, height in enumerate((0.35, 0.85, 1.35)):
            put(f"board {level + 1}", block, wood, (0, height, -0.8), (3.2, 0.04, 0.4))
        for side in (-1.6, 0.0, 1.6):
            put("post", block, wood, (side, 0.75, -0.8), (0.04, 1.5, 0.4))
        put("red ball", ball, red, (-1.15, 1.0, -0.72), (0.13, 0.13, 0.13))
        put("tin", tin, steel, (-0.72, 0.87, -0.75), (0.09, 0.26, 0.09))
        put("yellow cone", cone, yellow, (-0.35, 0.87, -0.7), (0.12, 0.3, 0.12))
        put("blue box", block, blue, (0.4, 1.02, -0.76), (0.34, 0.3, 0.24), 0.3)
        put("green ring", ring, green, (0.86, 0.915, -0.7), (0.13, 0.15, 0.13))
        put("white vase", tin, white, (1.25, 0.87, -0.76), (0.1, 0.34, 0.1))
        put("small box", block, yellow, (-1.2, 0.46, -0.72), (0.3, 0.18, 0.2), -0.2)
        put("blue ball", ball, blue, (-0.6, 0.5, -0.7), (0.13, 0.13, 0.13))
        put("crate", block, wood, (0.75, 0.53, -0.75), (0.5, 0.32, 0.3), 0.08)
        put("parcel", block, shapes.paint(builder, 0.5, 0.34, 0.2, 0.8), (0.55, 0.2, 0.1), (0.5, 0.4, 0.36), 0.6)
        put("cone on the floor", cone, red, (-0.55, 0, 0.2), (0.16, 0.42, 0.16))

        # Two windows behind the robot, and a ceiling light: soft shadows without noise.
        for x in (-1.6, 1.4):
            builder.area_light(gnomon.AreaLight(width=1.2, height=1.4, radiance=(9, 9.5, 10.5)),
                               gnomon.look_at((x, 1.9, 2.9), (0.5 * x, 0.7, -1)))
        builder.area_light(gnomon.AreaLight(shape="disc", width=0.5, radiance=(16, 14, 11)),
                           gnomon.look_at((0, 2.9, 0.3), (0, 0, 0.3), (0, 0, 1)))
        builder.background((0.02, 0.02, 0.025))
        return builder.finish()


def pose_at(step: float) -> npt.NDArray[np.float64]:
    """From the world to the camera, as OpenCV has it: 3 x 4, +X right, +Y down, +Z forward."""
    camera_to_world = gnomon.look_at((-1.2 + 2.2 * step, 0.95, 1.75 - 0.3 * step), (-0.5 + 0.9 * step, 0.72, -0.8))
    return gnomon.inverse(camera_to_world * [1.0, -1.0, -1.0, 1.0])[:3]


def main() -> None:
    parser = argparse.ArgumentParser(description="the camera of a robot, with ids and depth")
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--out", type=Path, default=Path("."))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    scene = make_scene()
    scale = arguments.width / k_size[0]
    size = (arguments.width, round(k_size[1] * scale))
    with gnomon.Renderer(size=size, samples="auto", layers=True, ids=True, exposure=0.4) as renderer:
        for number in range(1, arguments.frames + 1):
            world_to_camera = pose_at((number - 1) / max(1, arguments.frames - 1))
            camera = gnomon.Camera.from_opencv(k_matrix, world_to_camera=world_to_camera, size=k_size)
            frame = renderer.render(scene, camera=camera)
            depth, ids = frame.depth, frame.object_ids   # numpy, without a copy

            name = f"robot-{number}"
            frame.write(arguments.out / f"{name}.png")
            images.write_png(arguments.out / f"{name}-depth.png", images.show_depth(depth, 1.0, 4.5))
            images.write_png(arguments.out / f"{name}-ids.png", images.show_ids(ids))

            print(f"frame {number}: {frame.milliseconds:.0f} ms\n  object               pixels   nearest    right     down")
            for value in np.unique(ids[ids > 0]):
                seen = scene.instance_of(int(value))
                assert seen is not None
                y, x = np.unravel_index(np.argmin(np.where(ids == value, depth, np.inf)), ids.shape)
                # The point in the camera's space, from a pixel and its depth. OpenCV's pixel centres are whole numbers.
                z = float(depth[y, x])
                u, v = (x + 0.5) / scale - 0.5, (y + 0.5) / scale - 0.5
                right, down = (u - k_matrix[0, 2]) / k_matrix[0, 0] * z, (v - k_matrix[1, 2]) / k_matrix[1, 1] * z
                print(f"  {scene.name(seen):20} {np.count_nonzero(ids == value):6}  {z:6.3f} m {right:+7.3f} m {down:+7.3f} m")


if __name__ == "__main__":
    main()
