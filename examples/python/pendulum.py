#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A double pendulum from a loop of physics: each frame hands over two transforms, and nothing else.

    pendulum.py [--frames N] [--width PIXELS] [--out FOLDER]

Writes pendulum-0001.png and so on. The printed counters show what the renderer did: shadows and light that the pendulum
cannot reach are remembered from frame to frame.
"""
import argparse
import math
from pathlib import Path

import gnomon
import shapes

k_gravity = 9.81           # metres per second squared
k_lengths = (0.75, 0.6)    # of the two rods, metres
k_masses = (1.0, 0.7)      # of the two bobs, kilograms
k_fps = 24
k_substeps = 50            # steps of the integrator per frame
State = tuple[float, float, float, float]   # two angles from the vertical, and their speeds


def slope(state: State) -> State:
    """The derivative of a state: the equations of motion of a double pendulum."""
    a, b, va, vb = state
    (la, lb), (ma, mb) = k_lengths, k_masses
    below = 2 * ma + mb - mb * math.cos(2 * a - 2 * b)
    aa = (-k_gravity * (2 * ma + mb) * math.sin(a) - mb * k_gravity * math.sin(a - 2 * b)
          - 2 * math.sin(a - b) * mb * (vb * vb * lb + va * va * la * math.cos(a - b))) / (la * below)
    ab = 2 * math.sin(a - b) * (va * va * la * (ma + mb) + k_gravity * (ma + mb) * math.cos(a)
                                + vb * vb * lb * mb * math.cos(a - b)) / (lb * below)
    return va, vb, aa, ab


def step(state: State, seconds: float) -> State:
    """One step of the classical method of Runge and Kutta."""
    def moved(by: State, factor: float) -> State:
        a, b, va, vb = (s + factor * d for s, d in zip(state, by))
        return a, b, va, vb

    k1 = slope(state)
    k2 = slope(moved(k1, seconds / 2))
    k3 = slope(moved(k2, seconds / 2))
    k4 = slope(moved(k3, seconds))
    a, b, va, vb = (s + seconds / 6 * (d1 + 2 * d2 + 2 * d3 + d4)
                    for s, d1, d2, d3, d4 in zip(state, k1, k2, k3, k4))
    return a, b, va, vb


def make_scene() -> tuple[gnomon.Scene, gnomon.NodeId, gnomon.NodeId]:
    """The scene and the two arms. The second arm is below the first in the hierarchy, and moves with it."""
    with gnomon.SceneBuilder() as builder:
        block, ball = shapes.add(builder, shapes.box()), shapes.add(builder, shapes.sphere())
        rod = shapes.add(builder, shapes.cylinder(around=24))
        wall, oak = shapes.paint(builder, 0.66, 0.62, 0.55, 0.9), shapes.paint(builder, 0.36, 0.2, 0.1, 0.45)
        brass, red = shapes.paint(builder, 0.9, 0.62, 0.25, 0.25, 1), shapes.paint(builder, 0.6, 0.06, 0.05, 0.3)
        steel = shapes.paint(builder, 0.55, 0.56, 0.58, 0.3, 1)

        def place(mesh: gnomon.MeshId, material: gnomon.MaterialId, at: tuple[float, float, float],
                  size: tuple[float, float, float], parent: gnomon.NodeId | None = None) -> None:
            builder.instance(mesh, material, gnomon.compose(gnomon.translation(*at), gnomon.scaling(*size)), parent=parent)

        # A room's corner, and a stand: a foot, a column, and an axle at the origin.
        place(block, oak, (0, -1.65, 0), (8, 0.1, 8))
        place(block, wall, (0, 0.4, -0.95), (8, 4, 0.1))
        place(block, steel, (0, -1.57, -0.3), (0.9, 0.06, 0.5))
        place(rod, steel, (0, -1.6, -0.35), (0.035, 1.7, 0.035))
        builder.instance(rod, steel, gnomon.compose(gnomon.translation(0, 0, -0.4), gnomon.rotation((1, 0, 0), math.pi / 2),
                                                    gnomon.scaling(0.022, 0.5, 0.022)))
        place(ball, steel, (0, 0.1, -0.35), (0.06, 0.06, 0.06))
        place(ball, brass, (0.75, -1.42, 0.35), (0.18, 0.18, 0.18))
        place(block, shapes.paint(builder, 0.08, 0.2, 0.42, 0.5), (-0.8, -1.45, 0.1), (0.32, 0.3, 0.32))

        # An arm is a node that turns about its joint; a ball, a rod and a bob hang on it. Only the two nodes move.
        arms: list[gnomon.NodeId] = []
        for length, bob, radius in ((k_lengths[0], brass, 0.1), (k_lengths[1], red, 0.085)):
            arm = builder.node(mobility="may_move", parent=arms[0] if arms else None)
            place(ball, brass, (0, 0, 0), (0.04, 0.04, 0.04), arm)
            place(rod, steel, (0, -length, 0), (0.016, length, 0.016), arm)
            place(ball, bob, (0, -length, 0), (radius, radius, radius), arm)
            arms.append(arm)

        # The key light throws the pendulum's shadow on the wall; a weak one fills it.
        builder.light(gnomon.Light(type="spot", color=(75, 68, 56), inner_angle=0.25, outer_angle=0.55),
                      gnomon.look_at((1.5, 1.1, 3.4), (0, -0.6, -0.4)))
        builder.light(gnomon.Light(color=(4, 4.6, 6)), gnomon.translation(-2.2, 1.2, 2.2))
        builder.background((0.03, 0.035, 0.045))
        builder.camera(gnomon.Camera(transform=gnomon.look_at((0.55, -0.35, 4.1), (0, -0.62, 0)), vertical_fov=0.6))
        return builder.finish(), arms[0], arms[1]


def main() -> None:
    parser = argparse.ArgumentParser(description="a double pendulum")
    parser.add_argument("--frames", type=int, default=72)
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--out", type=Path, default=Path("."))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    scene, upper, lower = make_scene()
    state: State = (2.0, 2.4, 0.0, 0.0)
    with gnomon.Renderer(size=(arguments.width, arguments.width * 9 // 16), samples="auto", exposure=0.2) as renderer:
        print("frame  updated nodes  shadow rays  without a ray      ms")
        for number in range(1, arguments.frames + 1):
            # The second arm hangs at the end of the first, in whose space its transform is.
            frame = renderer.render(scene, transforms={
                upper: gnomon.rotation((0, 0, 1), state[0]),
                lower: gnomon.compose(gnomon.translation(0, -k_lengths[0], 0),
                                      gnomon.rotation((0, 0, 1), state[1] - state[0])),
            })
            frame.write(arguments.out / f"pendulum-{number:04}.png")
            work = frame.counters
            print(f"{number:5}  {work['updated_nodes']:13}  {work['shadow_rays']:11}  {work['shadow_rays_skipped']:13}  "
                  f"{frame.milliseconds:6.0f}")
            for _ in range(k_substeps):
                state = step(state, 1 / k_fps / k_substeps)


if __name__ == "__main__":
    main()
