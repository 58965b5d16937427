#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A data set: images of things on a table, with random poses of the things and of the camera, and their labels.

    dataset.py [--images N] [--size WxH] [--seed S] [--soft] [--out FOLDER]

For each image, writes NAME.png (colour), NAME-depth.png (16 bits, millimetres) and NAME-ids.png (16 bits, 0: nothing), and
a line of poses.jsonl: the intrinsics and the pose of the camera by OpenCV's conventions, and the poses of the things.
--soft lights the table by a window and a sky, which takes about 15 times as long. Prints the time per image, and one hash of all images: it is the same in every run and on every processor.
"""
import argparse
import hashlib
import json
import math
import random
import sys
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

import gnomon
import images
import shapes

k_names = ("ball", "tin", "cone", "ring", "box")
k_copies = 3   # of each thing


def make_scene(soft: bool = False) -> tuple[gnomon.Scene, dict[str, gnomon.InstanceId]]:
    """A table with things that may move, under a spot and a bulb, or under a window's light and a sky."""
    with gnomon.SceneBuilder() as builder:
        meshes = (shapes.sphere(0.1), shapes.cylinder(0.07, 0.2), shapes.cone(0.1, 0.24), shapes.torus(0.09, 0.035),
                  shapes.box(0.2, 0.16, 0.14))
        colors = ((0.6, 0.08, 0.06), (0.07, 0.2, 0.5), (0.75, 0.5, 0.08))
        block = shapes.add(builder, shapes.box())
        builder.instance(block, shapes.paint(builder, 0.45, 0.3, 0.18, 0.5),
                         gnomon.compose(gnomon.translation(0, -0.02, 0), gnomon.scaling(1.6, 0.04, 1.6)), name="table")
        builder.instance(block, shapes.paint(builder, 0.5, 0.5, 0.52, 0.8),
                         gnomon.compose(gnomon.translation(0, -0.79, 0), gnomon.scaling(14, 0.1, 14)), name="floor")
        things = {}
        for name, arrays in zip(k_names, meshes):
            mesh = shapes.add(builder, arrays)
            for copy in range(k_copies):
                color = shapes.paint(builder, *colors[copy], 0.35)
                label = f"{name} {copy + 1}"
                things[label] = builder.instance(mesh, color, mobility="may_move", name=label,
                                                 reach=((-1, -0.1, -1), (1, 0.5, 1)))
        if soft:
            builder.area_light(gnomon.AreaLight(width=1.4, height=1.4, radiance=(11, 11, 11.5)),
                               gnomon.look_at((-1.2, 2.2, 1.0), (0, 0, 0)))
            shapes.sky(builder, 0.3)
        else:
            builder.light(gnomon.Light(type="spot", color=(26, 24, 21), inner_angle=0.3, outer_angle=0.8),
                          gnomon.look_at((-1.4, 2.6, 1.2), (0, 0, 0)))
            builder.light(gnomon.Light(color=(17, 18, 20)), gnomon.translation(1.8, 3.2, -1.6))
            builder.background((0.1, 0.11, 0.13))
        return builder.finish(), things


def pose_of(turn: float, x: float, y: float, z: float) -> npt.NDArray[np.float64]:
    return gnomon.compose(gnomon.translation(x, y, z), gnomon.rotation((0, 1, 0), turn))


def main() -> None:
    parser = argparse.ArgumentParser(description="images with random poses")
    parser.add_argument("--images", type=int, default=1000)
    parser.add_argument("--size", default="320x240", metavar="WxH")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--soft", action="store_true", help="a window and a sky instead of a spot and a bulb")
    parser.add_argument("--out", type=Path, default=Path("dataset"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    width, height = (int(side) for side in arguments.size.split("x"))
    camera_matrix = np.array([[1.1 * width, 0, width / 2 - 0.5], [0, 1.1 * width, height / 2 - 0.5], [0, 0, 1]])

    # Python's own generator gives the same numbers everywhere. Poses are rounded, because the sines and cosines of numpy
    # and of the C library may differ in the last bit from processor to processor.
    chance = random.Random(arguments.seed)

    def draw(low: float, high: float) -> float:
        return round(chance.uniform(low, high), 6)

    scene, things = make_scene(arguments.soft)
    all_bytes = hashlib.sha256()
    began = time.perf_counter()
    with gnomon.Renderer(size=(width, height), layers=True, ids=True, exposure=0) as renderer, \
            open(arguments.out / "poses.jsonl", "w") as poses:
        for number in range(arguments.images):
            # The things stand in a shuffled grid, so that none is within another.
            places = [(0.36 * (i % 4 - 1.5), 0.36 * (i // 4 - 1.5)) for i in range(16)]
            chance.shuffle(places)
            transforms = {}
            for (label, thing), (x, z) in zip(things.items(), places):
                lift = {"ball": 0.1, "ring": 0.035, "box": 0.08}.get(label.split()[0], 0.0)
                transforms[thing] = pose_of(draw(0, 2 * math.pi), x + draw(-0.06, 0.06), lift, z + draw(-0.06, 0.06))
            turn, distance, rise = draw(0, 2 * math.pi), draw(1.3, 2.1), draw(0.5, 1.4)
            eye = (round(distance * math.sin(turn), 6), rise, round(distance * math.cos(turn), 6))
            camera_to_world = gnomon.look_at(eye, (draw(-0.2, 0.2), 0.05, draw(-0.2, 0.2)))
            world_to_camera = gnomon.inverse(camera_to_world * [1.0, -1.0, -1.0, 1.0])[:3]
            camera = gnomon.Camera.from_opencv(camera_matrix, world_to_camera=world_to_camera)

            frame = renderer.render(scene, camera=camera, transforms=transforms)

            name = f"{number:05}"
            color, depth, ids = frame.srgb8(), frame.depth, frame.object_ids
            images.write_png(arguments.out / f"{name}.png", color)
            images.write_png(arguments.out / f"{name}-depth.png", np.minimum(1000 * depth + 0.5, 65535).astype(np.uint16))
            images.write_png(arguments.out / f"{name}-ids.png", ids.astype(np.uint16))
            for array in (color, depth, ids):
                all_bytes.update(np.ascontiguousarray(array).tobytes())
            poses.write(json.dumps({
                "image": name, "camera_matrix": camera_matrix.tolist(), "world_to_camera": world_to_camera.tolist(),
                "objects": {label: transforms[thing].tolist() for label, thing in things.items()},
                "ids": {scene.name(seen): int(value) for value in np.unique(ids)
                        if (seen := scene.instance_of(int(value)))}}) + "\n")
            print(f"image {number + 1}: {frame.milliseconds:.0f} ms", file=sys.stderr)
    seconds = time.perf_counter() - began
    print(f"{arguments.images} images of {width} x {height}, {1000 * seconds / max(1, arguments.images):.0f} ms per image")
    print(f"sha256 of all colours, depths and ids: {all_bytes.hexdigest()}")


if __name__ == "__main__":
    main()
