# SPDX-License-Identifier: Apache-2.0
"""Cameras against closed forms: a point is seen at the pixel that the conventions of its camera say."""
import math
import unittest

import numpy as np

import gnomon
from support import EIGHT_TRIANGLES, OCTAHEDRON

SIZE = (160, 120)
K = np.array([[150.0, 0, 71.3], [0, 140.0, 66.9], [0, 0, 1]])
POINTS = np.array([[0.31, 0.22, -0.4], [-0.52, 0.1, 0.3], [0.15, -0.4, 0.1], [-0.2, -0.25, -0.6], [0.6, 0.45, 0.2]])


def scene_of_points(radius=0.03):
    """A small ball of its own material at each of the points."""
    with gnomon.SceneBuilder() as builder:
        mesh = builder.mesh(OCTAHEDRON, EIGHT_TRIANGLES)
        for i, point in enumerate(POINTS):
            builder.instance(mesh, None, gnomon.compose(gnomon.translation(*point), gnomon.scaling(radius)), name=str(i))
        builder.light(gnomon.Light(color=(10, 10, 10)), gnomon.translation(0, 0, 4))
        return builder.finish()


def centres(frame, scene):
    """The mean of the pixels that show each ball, with pixel centres at 0.5; and the nearest depth."""
    found = {}
    ids = frame.object_ids
    for value in np.unique(ids[ids > 0]):
        y, x = np.nonzero(ids == value)
        found[int(scene.name(scene.instance_of(int(value))))] = (x.mean() + 0.5, y.mean() + 0.5, frame.depth[y, x].min())
    return found


class Cameras(unittest.TestCase):
    def setUp(self):
        self.scene = scene_of_points()
        self.renderer = gnomon.Renderer(size=SIZE, layers=True, ids=True, indirect="off", exposure=0, threads=1)

    def check(self, camera, expected):
        """`expected`: x, y (pixel centres at 0.5) and depth of each point. Balls have a radius of 1 to 2 pixels."""
        frame = self.renderer.render(self.scene, camera=camera)
        projected = frame.project(POINTS)
        np.testing.assert_allclose(projected, expected, atol=2e-4)
        found = centres(frame, self.scene)
        self.assertEqual(sorted(found), list(range(len(POINTS))))
        for i, (x, y, depth) in found.items():
            self.assertAlmostEqual(x, expected[i][0], delta=0.75, msg=f"point {i}")
            self.assertAlmostEqual(y, expected[i][1], delta=0.75, msg=f"point {i}")
            self.assertAlmostEqual(depth, expected[i][2], delta=0.035, msg=f"point {i}")

    def test_an_opencv_camera_sees_points_where_its_matrix_says(self):
        rotation = gnomon.rotation((0.3, 1, -0.2), 0.4)[:3, :3] @ np.diag([1.0, -1, -1])
        pose = np.column_stack([rotation, [0.05, -0.1, 2.6]])   # 3 x 4
        camera = gnomon.Camera.from_opencv(K, world_to_camera=pose, size=SIZE)
        in_camera = POINTS @ pose[:, :3].T + pose[:, 3]
        pixels = in_camera @ K.T
        pixels /= pixels[:, 2:]
        # OpenCV's first pixel has its centre at (0, 0).
        self.check(camera, np.column_stack([pixels[:, :2] + 0.5, in_camera[:, 2]]))

    def test_both_directions_of_an_opencv_pose_are_one_camera(self):
        pose = gnomon.compose(gnomon.rotation((1, 2, 3), 0.7), gnomon.translation(0.2, -0.3, 3))
        one = gnomon.Camera.from_opencv(K, world_to_camera=pose)
        other = gnomon.Camera.from_opencv(K, camera_to_world=np.linalg.inv(pose))
        np.testing.assert_allclose(one.transform, other.transform, atol=1e-12)

    def test_pixel_centers_at_a_half_shift_the_principal_point(self):
        whole = gnomon.Camera.from_opencv(K).intrinsics
        half = gnomon.Camera.from_opencv(K, pixel_centers="half").intrinsics
        self.assertEqual((whole.cx - half.cx, whole.cy - half.cy), (0.5, 0.5))

    def test_intrinsics_of_another_size_are_scaled(self):
        pose = gnomon.compose(gnomon.translation(0, 0, 3), np.diag([1.0, -1, -1, 1]))
        at_double = gnomon.Camera.from_opencv(K, world_to_camera=pose, size=(2 * SIZE[0], 2 * SIZE[1]), pixel_centers="half")
        in_camera = POINTS @ pose[:3, :3].T + pose[:3, 3]
        pixels = in_camera @ K.T
        self.check(at_double, np.column_stack([pixels[:, :2] / pixels[:, 2:] / 2, in_camera[:, 2]]))

    def test_a_gltf_camera_sees_points_where_its_field_of_view_says(self):
        pose = gnomon.look_at((0.8, 0.6, 2.4), (0, 0, 0))
        camera = gnomon.Camera.from_gltf(0.6, camera_to_world=pose[:3])
        in_camera = POINTS @ np.linalg.inv(pose)[:3, :3].T + np.linalg.inv(pose)[:3, 3]
        depth = -in_camera[:, 2]
        scale = SIZE[1] / 2 / math.tan(0.3)
        self.check(camera, np.column_stack([SIZE[0] / 2 + scale * in_camera[:, 0] / depth,
                                            SIZE[1] / 2 - scale * in_camera[:, 1] / depth, depth]))

    def test_an_orthographic_camera_sees_points_by_its_height(self):
        camera = gnomon.Camera(transform=gnomon.translation(0.1, 0, 3), orthographic_height=1.8)
        scale = SIZE[1] / 1.8
        self.check(camera, np.column_stack([SIZE[0] / 2 + scale * (POINTS[:, 0] - 0.1),
                                            SIZE[1] / 2 - scale * POINTS[:, 1], 3 - POINTS[:, 2]]))

    def test_points_are_what_pixels_show(self):
        for camera in (gnomon.Camera(transform=gnomon.look_at((0.5, 0.4, 2), (0, 0, 0)), vertical_fov=0.7),
                       gnomon.Camera(transform=gnomon.look_at((0.5, 0.4, 2), (0, 0, 0)), orthographic_height=1.6)):
            frame = self.renderer.render(self.scene, camera=camera)
            points = frame.points()
            seen = frame.depth > 0
            self.assertTrue(np.isnan(points[~seen]).all() and np.isfinite(points[seen]).all())
            y, x = np.nonzero(seen)
            np.testing.assert_allclose(frame.project(points[seen]), np.column_stack([x + 0.5, y + 0.5, frame.depth[seen]]),
                                       atol=1e-3)
            for i in range(len(x)):
                pick = self.renderer.pick(int(x[i]), int(y[i]))
                np.testing.assert_allclose(points[y[i], x[i]], pick.position, atol=1e-5)

    def test_points_behind_a_perspective_camera_have_no_pixel(self):
        frame = self.renderer.render(self.scene, camera=gnomon.Camera(transform=gnomon.translation(0, 0, 3)))
        x, y, depth = frame.project((0, 0, 5))
        self.assertTrue(math.isnan(x) and math.isnan(y))
        self.assertAlmostEqual(depth, -2)

    def test_wrong_cameras_are_refused_with_what_is_wrong(self):
        skewed = K.copy()
        skewed[0, 1] = 1
        for call, words in (
            (lambda: gnomon.Camera.from_opencv(skewed), "skewed"),
            (lambda: gnomon.Camera.from_opencv(K[:2]), "(2, 3)"),
            (lambda: gnomon.Camera.from_opencv(K, world_to_camera=np.eye(3)), "(3, 3)"),
            (lambda: gnomon.Camera.from_opencv(K, world_to_camera=np.zeros((3, 4))), "singular"),
            (lambda: gnomon.Camera.from_opencv(K, world_to_camera=np.eye(4), camera_to_world=np.eye(4)), "either"),
            (lambda: gnomon.Camera.from_opencv(K, pixel_centers="corner"), "corner"),
            (lambda: gnomon.look_at((0, 0, 0), (0, 1, 0)), "parallel"),
        ):
            with self.assertRaises(gnomon.UsageError) as raised:
                call()
            self.assertIn(words, str(raised.exception))

    def test_matrices_are_those_of_column_vectors(self):
        np.testing.assert_allclose(gnomon.rotation((0, 0, 2), math.pi / 2) @ [1, 0, 0, 1], [0, 1, 0, 1], atol=1e-15)
        moved = gnomon.compose(gnomon.translation(1, 2, 3), gnomon.scaling(2))
        np.testing.assert_array_equal(moved, gnomon.translation(1, 2, 3) @ gnomon.scaling(2, 2, 2))
        np.testing.assert_allclose(gnomon.inverse(moved) @ moved, np.eye(4), atol=1e-15)
        pose = gnomon.look_at((1, 2, 3), (1, 2, 0))
        np.testing.assert_allclose(pose, gnomon.translation(1, 2, 3), atol=1e-15)


if __name__ == "__main__":
    unittest.main()
