# SPDX-License-Identifier: Apache-2.0
"""Light in Blender's units: what arrives is what Cycles has, which is what the formulas say."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import *  # noqa: E402, F403

RHO = 0.5


class Lights(unittest.TestCase):
    """A plane below a light, seen from above at its foot."""

    def below(self, make_light, at=(0.0, 0.0)) -> float:
        new_scene((4, 4))
        add_plane(material=diffuse(RHO))
        make_light()
        add_camera((*at, 1), ortho=0.01)
        bpy.context.scene.gnomon.indirect = "off"
        return float(render()[..., :3].mean())

    def assert_close(self, value: float, expected: float, tolerance: float = 0.005) -> None:
        self.assertLess(abs(value / expected - 1), tolerance, f"{value} instead of {expected}")

    def test_point_light_has_watts(self):
        value = self.below(lambda: add_light("POINT", energy=100, shadow_soft_size=0))
        self.assert_close(value, RHO / math.pi * 100 / (4 * math.pi) / 4)

    def test_point_light_with_a_radius_has_the_same_power(self):
        value = self.below(lambda: add_light("POINT", energy=100, shadow_soft_size=0.1))
        self.assert_close(value, RHO / math.pi * 100 / (4 * math.pi) / 4, 0.01)

    def test_spot_has_the_intensity_of_a_point_light_on_its_axis(self):
        value = self.below(lambda: add_light("SPOT", energy=100, shadow_soft_size=0, spot_size=1, spot_blend=0.2))
        self.assert_close(value, RHO / math.pi * 100 / (4 * math.pi) / 4)

    def test_spot_has_the_profile_of_cycles(self):
        for angle in (0.25, 0.42, 0.475, 0.49):
            spot = lambda: add_light("SPOT", energy=100, shadow_soft_size=0, spot_size=1, spot_blend=0.2)  # noqa: E731
            value = self.below(spot, (2 * math.tan(angle), 0))
            truth = float(render("CYCLES")[..., :3].mean())
            self.assert_close(value, truth, 0.02)
        self.assertEqual(self.below(spot, (2 * math.tan(0.52), 0)), 0)

    def test_spot_with_a_radius_has_soft_edges_as_in_cycles(self):
        for angle in (0.0, 0.42, 0.5, 0.53):
            spot = lambda: add_light("SPOT", energy=100, shadow_soft_size=0.2, spot_size=1, spot_blend=0.2)  # noqa: E731
            value = self.below(spot, (2 * math.tan(angle), 0))
            truth = float(render("CYCLES")[..., :3].mean())
            self.assert_close(value, truth, 0.04)

    def test_sun_has_watts_per_square_metre(self):
        self.assert_close(self.below(lambda: add_light("SUN", energy=3, angle=0)), RHO / math.pi * 3)
        self.assert_close(self.below(lambda: add_light("SUN", energy=3, angle=0.1)), RHO / math.pi * 3, 0.01)

    def test_area_lights_have_watts_of_cycles(self):
        # Of a rectangle and a disc that are small against their distance: radiance P / (4 A).
        expected = RHO / math.pi * 100 / 4 / 4
        for shape, more in (("SQUARE", {}), ("RECTANGLE", {"size_y": 0.02}), ("DISK", {}), ("ELLIPSE", {"size_y": 0.02})):
            with self.subTest(shape):
                value = self.below(lambda: add_light("AREA", energy=100, shape=shape, size=0.01, **more))
                self.assert_close(value, expected, 0.01)

    def test_wide_disc_lights_by_its_solid_angle(self):
        value = self.below(lambda: add_light("AREA", energy=100, shape="DISK", size=2))
        self.assert_close(value, RHO * (100 / (4 * math.pi)) * 1 / (1 + 4), 0.01)

    def test_scaled_area_light_keeps_its_power(self):
        def make():
            add_light("AREA", energy=100, shape="SQUARE", size=0.01).scale = (2, 3, 1)

        self.assert_close(self.below(make), RHO / math.pi * 100 / 4 / 4, 0.01)

    def test_world_lights_by_its_radiance(self):
        self.assert_close(self.below(lambda: set_world((0.3, 0.3, 0.3))), RHO * 0.3, 0.01)

    def test_emission_has_its_radiance(self):
        new_scene((4, 4))
        add_plane(1, shader("glow", "ShaderNodeEmission", Color=(1, 0.5, 0.25, 1), Strength=3))
        add_camera(ortho=0.01)
        self.assertTrue(np.allclose(render()[0, 0, :3], (3, 1.5, 0.75), rtol=1e-5))

    def test_emission_lights_what_it_faces(self):
        def make():
            add_plane(0.02, shader("glow", "ShaderNodeEmission", Strength=100000.0), "light").location = (0, 0, 2)

        self.assert_close(self.below(make), RHO / math.pi * 100000 * 0.02 * 0.02 / 4, 0.01)

    def test_cameras_do_not_see_lights(self):
        new_scene((8, 8))
        add_light("AREA", energy=100, shape="SQUARE", size=1)
        add_light("POINT", (0, 0, 3), energy=100, shadow_soft_size=0.5)
        add_camera((0, 0, 0), (math.pi, 0, 0))
        for engine in ("GNOMON", "CYCLES"):
            self.assertEqual(render(engine)[..., :3].max(), 0, engine)

    def test_mirrors_see_lights(self):
        new_scene((8, 8))
        add_plane(material=shader("mirror", "ShaderNodeBsdfGlossy", Color=(1, 1, 1, 1), Roughness=0.0))
        add_light("AREA", energy=100, shape="SQUARE", size=1)
        add_camera((0, 0, 1), ortho=0.1)
        self.assertTrue(np.allclose(render()[..., :3], 25, rtol=0.01))


class Worlds(unittest.TestCase):
    def test_environment_images_have_the_directions_of_cycles(self):
        scene = new_scene((4, 4))
        image = bpy.data.images.new("directions", 64, 32, float_buffer=True)
        pixels = np.ones((32, 64, 4), dtype=np.float32)
        pixels[..., 0], pixels[..., 1] = np.arange(64)[None], np.arange(32)[:, None]
        image.pixels.foreach_set(pixels.ravel())
        world = set_world((0, 0, 0))
        tree = world.node_tree
        node = tree.nodes.new("ShaderNodeTexEnvironment")
        node.image = image
        tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
        camera = add_camera((0, 0, 0))
        camera.data.angle = 0.1
        for turn in (0.0, 1.0):
            if turn:
                mapping, place = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
                mapping.inputs["Rotation"].default_value = (0.3, 0.2, turn)
                tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
                tree.links.new(mapping.outputs[0], node.inputs["Vector"])
            for target in ((1, 0, 0), (0, 1, 0), (0, -1, 0.2), (1, 1, 1), (-0.9, 0.3, -0.5)):
                look_at(camera, target)
                ours, theirs = render()[..., :2].mean(axis=(0, 1)), render("CYCLES")[..., :2].mean(axis=(0, 1))
                self.assertTrue(np.allclose(ours, theirs, atol=0.6), f"{target}: {ours} instead of {theirs}")
        self.assertEqual(scene.render.engine, "CYCLES")


main(Lights, Worlds)
