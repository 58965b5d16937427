# SPDX-License-Identifier: Apache-2.0
"""What a change costs, and memory over many frames.

    changes_test.py [FRAMES]    frames of the test of memory: 2,000 without it
"""
import gc
import sys
import unittest

import numpy as np

import gnomon
from support import EIGHT_TRIANGLES, OCTAHEDRON, SQUARE, TWO_TRIANGLES, make_room, resident_bytes

FRAMES = 2000


class Changes(unittest.TestCase):
    def test_one_of_hundreds_that_moves_is_one_change(self):
        with gnomon.SceneBuilder() as builder:
            builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES), None, gnomon.compose(gnomon.translation(0, 0, -1),
                                                                                      gnomon.scaling(9)))
            ball = builder.mesh(OCTAHEDRON, EIGHT_TRIANGLES)
            balls = [builder.instance(ball, None, gnomon.compose(gnomon.translation(0.3 * (i % 20) - 3, 0.3 * (i // 20) - 3, 0),
                                                                 gnomon.scaling(0.1)), mobility="may_move")
                     for i in range(400)]
            builder.light(gnomon.Light(color=(30, 30, 30)), gnomon.translation(0, 2, 5))
            builder.camera(gnomon.Camera(transform=gnomon.translation(0, 0, 9)))
            scene = builder.finish()
        with gnomon.Renderer(size=(64, 48), exposure=0, indirect="off", threads=1, report_changes=True) as renderer:
            self.assertTrue(renderer.render(scene).counters["began_anew"])
            still = renderer.render(scene)
            self.assertEqual((still.counters["updated_nodes"], still.counters["began_anew"]), (0, False))
            self.assertEqual(renderer.report().rectangles, [])
            moved = gnomon.compose(gnomon.translation(0, 0, 0.5), gnomon.scaling(0.1))
            frame = renderer.render(scene, transforms={balls[7]: moved})
            self.assertLessEqual(frame.counters["updated_nodes"], 2)
            self.assertEqual(frame.counters["updated_instances"], 1)
            self.assertEqual(renderer.report().instances, [balls[7]])
            same = renderer.render(scene, transforms={balls[7]: moved})
            self.assertEqual(same.counters["updated_instances"], 0)
            self.assertEqual(renderer.report().instances, [])
            with gnomon.Renderer(size=(64, 48), exposure=0, indirect="off", threads=1) as fresh:
                np.testing.assert_array_equal(same.color, fresh.render(scene, transforms={balls[7]: moved}).color)
            back = renderer.render(scene, released=[balls[7]])
            np.testing.assert_array_equal(back.color, still.color)

    def test_values_stay_in_force_until_they_are_released(self):
        room = make_room()
        with gnomon.Renderer(size=(32, 24), exposure=0, threads=1) as renderer:
            first = renderer.render(room.scene).color.copy()
            dim, blue = gnomon.Light(color=(3, 3, 3)), gnomon.Material(base_color=(0, 0, 1))
            changed = renderer.render(room.scene, lights={room.light: dim}, materials={room.paint: blue},
                                      visibility={room.ball: False}).color.copy()
            report = renderer.report()
            self.assertEqual((report.lights, report.materials), ([room.light], [room.paint]))
            self.assertFalse(renderer.visible(room.ball))
            self.assertFalse(np.array_equal(first, changed))
            np.testing.assert_array_equal(renderer.render(room.scene).color, changed)
            np.testing.assert_array_equal(
                renderer.render(room.scene, released=[room.light, room.paint, room.ball]).color, first)

    def test_values_change_while_the_shutter_is_open(self):
        with gnomon.SceneBuilder() as builder:
            glow = gnomon.Material(model="unlit", base_color=(1, 0, 0))
            paint = builder.material(glow)
            builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES), paint)
            light = builder.light(gnomon.Light())
            builder.camera(gnomon.Camera(transform=gnomon.translation(0, 0, 1)))
            scene = builder.finish()
        with gnomon.Renderer(size=(16, 16), exposure=0, shutter=180, samples=64, indirect="off") as renderer:
            frame = renderer.render(scene, materials={paint: glow}, closing=gnomon.Closing(
                materials={paint: gnomon.Material(model="unlit", base_color=(0, 0, 1))}))
            np.testing.assert_allclose(frame.color[8, 8], (0.5, 0, 0.5), atol=0.01)
            spot = gnomon.Closing(lights={light: gnomon.Light(type="spot")})
            with self.assertRaisesRegex(gnomon.UsageError, "gets none of the shutter's opening"):
                renderer.render(scene, closing=spot)
            with self.assertRaisesRegex(gnomon.UsageError, "cannot change while the shutter is open"):
                renderer.render(scene, lights={light: gnomon.Light()}, closing=spot)

    def test_deformed_vertices_are_shown_and_read_from_any_array(self):
        room = make_room()
        with gnomon.Renderer(size=(33, 25), exposure=0, threads=1, layers=True) as renderer:
            renderer.render(room.scene)
            longer = OCTAHEDRON * [1, 1, 3]
            frame = renderer.render(room.scene, vertices={room.ball: longer})
            self.assertAlmostEqual(float(frame.depth[12, 16]), 3.1, places=5)
            again = renderer.render(room.scene, vertices={room.ball: gnomon.Vertices(longer.astype(np.float32))})
            np.testing.assert_array_equal(again.depth, frame.depth)
            self.assertEqual(again.counters["updated_instances"], 0)

    def test_options_can_change_between_frames(self):
        room = make_room()
        with gnomon.Renderer(gnomon.RenderOptions(size=(16, 12)), threads=1) as renderer:
            renderer.render(room.scene)
            renderer.set_options(size=(8, 6), layers=True)
            frame = renderer.render(room.scene)
            self.assertEqual((frame.size, frame.counters["began_anew"]), ((8, 6), False))
            self.assertEqual((renderer.options.size, renderer.options.threads), ((8, 6), 1))
            with self.assertRaises(gnomon.UsageError):
                renderer.set_options(samples=-1)
            self.assertEqual(renderer.options.samples, 1)


class Memory(unittest.TestCase):
    # One frame that is never freed is 24 * 18 pixels of 4 bytes in 18 channels: 31 kB.
    k_limit = 3 << 20

    def growth(self, frames, keep=None):
        """Bytes that the second half of the frames adds to the memory in use."""
        room = make_room()
        used = []
        with gnomon.Renderer(size=(24, 18), exposure=0, indirect="off", threads=1, layers=True, ids=True) as renderer:
            for i in range(frames):
                place = gnomon.compose(gnomon.translation(0.5 * np.sin(0.1 * i), 0, 0), gnomon.scaling(0.3))
                frame = renderer.render(room.scene, transforms={room.ball: place}, progress=lambda stage, done: None,
                                        vertices={room.ball: OCTAHEDRON * (1 + 0.1 * np.cos(0.1 * i))},
                                        lights={room.light: gnomon.Light(color=(30 + i % 2, 30, 30))})
                views = frame.depth, frame.color, frame.object_ids
                if keep is not None:
                    keep.append(views)
                if i in (frames // 2, frames - 1):
                    gc.collect()
                    used.append(resident_bytes())
        return used[1] - used[0]

    def test_thousands_of_frames_do_not_grow(self):
        self.assertLess(self.growth(FRAMES), self.k_limit)

    def test_frames_that_are_kept_would_be_seen_to_grow(self):
        self.assertGreater(self.growth(2500, keep=[]), 4 * self.k_limit)

    def test_scenes_and_renderers_do_not_grow(self):
        def once():
            room = make_room()
            with gnomon.Renderer(size=(16, 12), exposure=0, indirect="off", threads=1, layers=True) as renderer:
                renderer.render(room.scene).srgb8()
            for call in (lambda: room.builder.mesh([[1, 2]]), lambda: renderer.render(room.scene)):
                with self.assertRaises(gnomon.UsageError):
                    call()

        used = []
        for _ in range(6):
            for _ in range(25):
                once()
            gc.collect()
            used.append(resident_bytes())
        self.assertLess(used[-1] - used[2], 4 << 20, used)


if __name__ == "__main__":
    if len(sys.argv) > 1 and sys.argv[1].isdigit():
        FRAMES = int(sys.argv.pop(1))
    unittest.main()
