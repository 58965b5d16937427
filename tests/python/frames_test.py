# SPDX-License-Identifier: Apache-2.0
"""Layers of frames: what they hold, that they are views without a copy, and how long they live."""
import gc
import subprocess
import tempfile
import unittest
import weakref
from pathlib import Path

import numpy as np

import gnomon
from support import PROGRAM, make_room

LAYERS = {"layers": True, "ids": True, "motion": True}


class Layers(unittest.TestCase):
    def setUp(self):
        self.room = make_room()
        self.renderer = gnomon.Renderer(size=(48, 36), exposure=0, threads=1, **LAYERS)

    def test_shapes_and_types_are_as_documented(self):
        frame = self.renderer.render(self.room.scene)
        expected = {"color": (36, 48, 3), "depth": (36, 48), "normal": (36, 48, 3), "albedo": (36, 48, 3),
                    "direct": (36, 48, 3), "indirect": (36, 48, 3), "shadow": (36, 48, 1), "motion": (36, 48, 2),
                    "object_ids": (36, 48), "material_ids": (36, 48)}
        for name, shape in expected.items():
            array = getattr(frame, name)
            self.assertEqual(array.shape, shape, name)
            self.assertEqual(array.dtype, np.uint32 if name.endswith("ids") else np.float32, name)
        self.assertEqual(frame.layer("").shape, (36, 48, 3))
        self.assertEqual(sorted(frame.layers), sorted(["", "depth", "normal", "albedo", "direct", "indirect", "shadow",
                                                       "motion", "id"]))
        self.assertEqual(frame.size, (48, 36))

    def test_depth_is_in_metres_along_the_axis(self):
        frame = self.renderer.render(self.room.scene)
        wall = frame.object_ids != frame.object_ids[18, 24]
        # The camera is at z = 4, the wall at z = -1: 5 metres at every pixel, also at the edges.
        np.testing.assert_allclose(frame.depth[wall], 5, rtol=1e-6)
        self.assertAlmostEqual(float(frame.depth.min()), 3.7, delta=0.1)   # the tip of the octahedron

    def test_ids_name_instances_and_materials(self):
        frame = self.renderer.render(self.room.scene)
        scene = self.room.scene
        self.assertEqual(scene.instance_of(int(frame.object_ids[18, 24])), self.room.ball)
        self.assertEqual(scene.instance_of(int(frame.object_ids[0, 0])), self.room.wall)
        self.assertEqual(scene.material_of(int(frame.material_ids[18, 24])), self.room.paint)
        self.assertIsNone(scene.instance_of(0))
        pick = self.renderer.pick(24, 18)
        self.assertEqual(pick.instance, self.room.ball)
        self.assertAlmostEqual(pick.depth, float(frame.depth[18, 24]), places=5)

    def test_normals_face_the_camera_and_albedo_is_the_paint(self):
        frame = self.renderer.render(self.room.scene)
        np.testing.assert_allclose(frame.normal[0, 0], [0, 0, 1], atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(frame.normal, axis=-1), 1, atol=1e-5)
        self.assertGreater(float(frame.albedo[18, 24, 0]), 2 * float(frame.albedo[18, 24, 1]))
        self.assertTrue(((frame.shadow >= 0) & (frame.shadow <= 1)).all())
        self.assertTrue((frame.shadow == 0).any() and (frame.shadow == 1).any())

    def test_motion_is_where_a_host_moved_things(self):
        camera = gnomon.Camera(transform=gnomon.translation(0, 0, 4), orthographic_height=3.6)   # 10 pixels a metre
        self.renderer.render(self.room.scene, camera=camera)
        moved = gnomon.compose(gnomon.translation(0.2, 0.1, 0), gnomon.scaling(0.3))
        frame = self.renderer.render(self.room.scene, camera=camera, transforms={self.room.ball: moved})
        ball = frame.object_ids == frame.object_ids[17, 26]
        np.testing.assert_allclose(frame.motion[ball], [[2, -1]] * int(ball.sum()), atol=1e-4)
        self.assertEqual(float(np.abs(frame.motion[~ball]).max()), 0)

    def test_a_missing_layer_is_named_with_the_option_that_makes_it(self):
        frame = gnomon.Renderer(size=(8, 6), threads=1).render(self.room.scene)
        for name, option in (("depth", "layers"), ("motion", "motion"), ("object_ids", "ids"), ("alpha", "background")):
            with self.assertRaises(gnomon.UsageError) as raised:
                getattr(frame, name)
            self.assertIn(f"RenderOptions.{option}", str(raised.exception))
        with self.assertRaises(gnomon.UsageError):
            frame.layer("smell")

    def test_the_image_is_the_command_lines_to_the_byte(self):
        if not PROGRAM:
            self.skipTest("GNOMON_PROGRAM is not set")
        with tempfile.TemporaryDirectory() as folder:
            of_program, of_python = Path(folder, "program.png"), Path(folder, "python.png")
            for number, samples in ((1, "1"), (5, "auto")):
                subprocess.run([PROGRAM, "render", "builtin:cornell", "-o", of_program, "--size", "64x48", "--frame",
                                str(number), "--samples", samples, "--quiet"], check=True)
                with gnomon.Renderer(size=(64, 48), samples=1 if samples == "1" else "auto") as renderer:
                    frame = renderer.render(gnomon.load("builtin:cornell"), number)
                    frame.write(of_python)
                self.assertEqual(of_program.read_bytes(), of_python.read_bytes(), samples)
            self.assertEqual(gnomon.compare(of_program, of_python).pixels_different, 0)

    def test_shown_colours_follow_exposure(self):
        frame = self.renderer.render(self.room.scene)
        self.assertEqual((frame.srgb8().shape, frame.srgb8().dtype), ((36, 48, 3), np.dtype(np.uint8)))
        self.assertEqual((frame.srgb16(alpha=True).shape, frame.srgb16().dtype), ((36, 48, 4), np.dtype(np.uint16)))
        self.renderer.set_options(exposure=1)
        self.assertGreater(self.renderer.render(self.room.scene).srgb8().mean(), frame.srgb8().mean())


class Views(unittest.TestCase):
    def setUp(self):
        self.room = make_room()
        self.renderer = gnomon.Renderer(size=(48, 36), exposure=0, threads=1, **LAYERS)

    def move(self, x):
        return {self.room.ball: gnomon.compose(gnomon.translation(x, 0, 0), gnomon.scaling(0.3))}

    def test_two_views_of_a_layer_show_one_memory(self):
        frame = self.renderer.render(self.room.scene)
        for name in ("color", "depth", "object_ids", "motion"):
            one, other = getattr(frame, name), getattr(frame, name)
            self.assertEqual(one.ctypes.data, other.ctypes.data, name)
            self.assertTrue(np.shares_memory(one, other), name)
            self.assertFalse(one.flags.owndata, name)
        self.assertTrue(np.shares_memory(frame.object_ids, frame.layer("id")))

    def test_a_view_cannot_be_written_to(self):
        depth = self.renderer.render(self.room.scene).depth
        with self.assertRaises(ValueError):
            depth[0, 0] = 1
        with self.assertRaises(ValueError):
            depth.flags.writeable = True
        depth.copy()[0, 0] = 1

    def test_a_view_keeps_its_values_while_later_frames_are_rendered(self):
        views, copies = [], []
        for i in range(6):
            frame = self.renderer.render(self.room.scene, transforms=self.move(0.1 * i))
            views.append((frame.color, frame.depth, frame.object_ids, frame.motion))
            copies.append([view.copy() for view in views[-1]])
            del frame
        gc.collect()
        for view, copy in zip(views, copies):
            for a, b in zip(view, copy):
                np.testing.assert_array_equal(a, b)
        self.assertEqual(len({view[1].ctypes.data for view in views}), 6)

    def test_a_view_outlives_frame_renderer_and_scene(self):
        room, renderer = make_room(), gnomon.Renderer(size=(32, 24), layers=True, threads=1)
        depth = renderer.render(room.scene).depth[::2, ::2]   # a view of a view
        expected = depth.copy()
        renderer.close()
        del room, renderer
        gc.collect()
        filler = [np.full((24, 32), -1, np.float32) for _ in range(200)]
        np.testing.assert_array_equal(depth, expected)
        del filler

    def test_memory_is_used_again_once_nothing_shows_it(self):
        places = set()
        for i in range(8):
            frame = self.renderer.render(self.room.scene, transforms=self.move(0.05 * i))
            places.add(frame.depth.ctypes.data)
            del frame
        self.assertEqual(len(places), 1)

    def test_a_frame_is_freed_with_its_last_view(self):
        frame = self.renderer.render(self.room.scene)
        gone = weakref.ref(frame)
        depth = frame.depth
        del frame
        gc.collect()
        self.assertIsNone(gone())
        self.assertGreater(float(depth.max()), 0)


class Outputs(unittest.TestCase):
    """Arrays of the caller's."""

    def setUp(self):
        self.room = make_room()
        self.renderer = gnomon.Renderer(size=(48, 36), exposure=0, threads=1, **LAYERS)

    def test_layers_are_written_into_arrays_of_any_layout(self):
        wide = np.zeros((36, 100, 2), np.float32)
        out = {"depth": wide[:, :96:2, 0], "normal": np.zeros((36, 48, 3), np.float16), "": np.zeros((36, 48, 4), np.uint8),
               "id.object": np.zeros((36, 48), np.uint32), "normal.Z": np.zeros((36, 48), np.float32)[::-1]}
        frame = self.renderer.render(self.room.scene, out=out)
        np.testing.assert_array_equal(out["depth"], frame.depth)
        np.testing.assert_array_equal(wide[..., 1], 0)
        np.testing.assert_array_equal(wide[:, 96:], 0)
        np.testing.assert_array_equal(out["normal"], frame.normal.astype(np.float16))
        np.testing.assert_array_equal(out[""][..., :3], frame.srgb8())
        np.testing.assert_array_equal(out["id.object"], frame.object_ids)
        np.testing.assert_array_equal(out["normal.Z"], frame.normal[..., 2])

    def test_arrays_that_do_not_fit_are_refused_and_left_alone(self):
        frozen = np.zeros((36, 48), np.float32)
        frozen.flags.writeable = False
        for array, error in ((np.zeros((36, 47), np.float32), gnomon.UsageError), (np.zeros(5, np.float32), gnomon.UsageError),
                             (np.zeros((36, 48)), TypeError), (frozen, gnomon.UsageError), ([1.0], TypeError),
                             (np.zeros((36, 48), np.float32)[:, ::-1], gnomon.UsageError),
                             (np.zeros((48, 36), np.float32), gnomon.UsageError)):
            with self.assertRaises(error):
                self.renderer.render(self.room.scene, out={"depth": array})
            self.assertEqual(np.abs(np.asarray(array)).max() if not isinstance(array, list) else 0, 0)


if __name__ == "__main__":
    unittest.main()
