# SPDX-License-Identifier: Apache-2.0
"""What Blender evaluates is what is seen: geometry and cameras beside Cycles, and materials."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import *  # noqa: E402, F403


class Geometry(unittest.TestCase):
    """The pass of object indices is the same as that of Cycles, but for pixels at edges."""

    def indices(self, engine: str) -> np.ndarray:
        view = bpy.context.view_layer
        view.use_pass_object_index = True
        bpy.context.scene.cycles.samples = 1
        return render_passes(engine)["IndexOB"][..., 0]

    def assert_same_shapes(self, least_seen: int = 30) -> None:
        ours, theirs = self.indices("GNOMON"), self.indices("CYCLES")
        self.assertGreater(np.count_nonzero(ours), least_seen)
        # With one sample, an edge may lie on either side of it.
        self.assertLess(np.count_nonzero(ours != np.round(theirs)), 0.03 * ours.size)

    def scene(self):
        scene = new_scene((64, 48))
        look_at(add_camera((3, -6, 4)), (0, 0, 0))
        set_world((1, 1, 1))
        return scene

    def test_modifiers_are_applied(self):
        self.scene()
        bpy.ops.mesh.primitive_cube_add(size=1)
        ob = bpy.context.object
        ob.pass_index = 3
        ob.modifiers.new("more", "ARRAY").count = 3
        ob.modifiers.new("round", "SUBSURF").levels = 2
        self.assert_same_shapes()

    def test_curves_texts_and_balls_are_surfaces(self):
        self.scene()
        bpy.ops.curve.primitive_bezier_circle_add(radius=1.5)
        bpy.context.object.data.bevel_depth = 0.3
        bpy.context.object.pass_index = 1
        bpy.ops.object.text_add(location=(-1, 0, 1), rotation=(1.2, 0, 0.4))
        bpy.context.object.data.extrude = 0.1
        bpy.context.object.pass_index = 2
        bpy.ops.object.metaball_add(location=(1, 1, 1))
        bpy.context.object.pass_index = 4
        self.assert_same_shapes()

    def test_instances_and_parents(self):
        self.scene()
        bpy.ops.mesh.primitive_cube_add(size=0.4)
        cube = bpy.context.object
        cube.pass_index = 5
        plane = add_plane(3)
        cube.parent, plane.instance_type = plane, "VERTS"
        plane.show_instancer_for_render = False
        group = bpy.data.collections.new("group")
        ball = add_ball((0, 0, 2), 0.4)
        ball.pass_index = 6
        bpy.context.scene.collection.objects.unlink(ball)
        group.objects.link(ball)
        for place in ((-1.5, 0, 0), (0.5, 0.2, 0.5)):
            empty = link("instancer", None)
            empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", group, place
            empty.scale = (1, 1, 1.5)
        self.assert_same_shapes()

    def test_cameras_shift_and_are_orthographic(self):
        for kind in ("PERSP", "ORTHO"):
            with self.subTest(kind):
                scene = self.scene()
                add_ball((0.4, 0, 0), 1.2).pass_index = 1
                data = scene.camera.data
                data.type, data.ortho_scale, data.sensor_fit = kind, 6, "VERTICAL"
                data.shift_x, data.shift_y = 0.2, -0.1
                scene.render.pixel_aspect_x = 1.5
                self.assert_same_shapes()

    def test_clipping(self):
        scene = self.scene()
        add_plane(20, name="floor").pass_index = 2
        scene.camera.data.clip_start, scene.camera.data.clip_end = 6, 9
        self.assert_same_shapes()

    def test_render_region(self):
        scene = self.scene()
        add_ball((0, 0, 0), 1.2).pass_index = 1
        whole = render()
        render_ = scene.render
        render_.use_border, render_.use_crop_to_border = True, True
        render_.border_min_x, render_.border_max_x, render_.border_min_y, render_.border_max_y = 0.25, 0.75, 0.25, 0.75
        part = render()
        self.assertEqual(part.shape, (24, 32, 4))
        self.assertLess(np.abs(part - whole[12:36, 16:48])[2:-2, 2:-2].mean(), 0.01)

    def test_hidden_objects_are_not_there(self):
        self.scene()
        add_ball().hide_render = True
        self.assertEqual(np.count_nonzero(self.indices("GNOMON")), 0)


class Materials(unittest.TestCase):
    def one(self, material, light: bool = False) -> np.ndarray:
        """The middle of a plane in front of the camera, under an even world."""
        scene = new_scene((8, 8))
        scene.gnomon.indirect = "visible"
        add_plane(2, material())
        set_world((1, 1, 1))
        add_camera((0, 0, 1), ortho=0.5)
        return render()[3:5, 3:5, :3].mean(axis=(0, 1))

    def test_images_have_the_colours_and_places_of_cycles(self):
        def material():
            made = shader("image", "ShaderNodeEmission")
            image = bpy.data.images.new("four", 2, 2)
            image.pixels.foreach_set(np.array([1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0.5, 0.5, 0.5, 1], dtype=np.float32))
            tree = made.node_tree
            node, mapping, uv = (tree.nodes.new(kind) for kind in ("ShaderNodeTexImage", "ShaderNodeMapping", "ShaderNodeUVMap"))
            node.image, node.interpolation = image, "Closest"
            mapping.inputs["Location"].default_value = (0.1, 0.3, 0)
            mapping.inputs["Rotation"].default_value = (0, 0, 0.6)
            mapping.inputs["Scale"].default_value = (1.5, 2.5, 1)
            emission = next(each for each in tree.nodes if each.type == "EMISSION")
            tree.links.new(uv.outputs[0], mapping.inputs["Vector"])
            tree.links.new(mapping.outputs[0], node.inputs["Vector"])
            tree.links.new(node.outputs["Color"], emission.inputs["Color"])
            return made

        new_scene((24, 24))
        add_plane(2, material())
        add_camera((0, 0, 1), ortho=2)
        ours, theirs = render(), render("CYCLES")
        self.assertLess(np.abs(ours - theirs).mean(), 0.03)
        self.assertLess(np.median(np.abs(ours - theirs)), 1e-3)

    def test_colours_through_nodes(self):
        def material():
            made = shader("chain", "ShaderNodeBsdfDiffuse")
            tree = made.node_tree
            mix, gamma = tree.nodes.new("ShaderNodeMixRGB"), tree.nodes.new("ShaderNodeGamma")
            mix.blend_type = "MULTIPLY"
            mix.inputs["Fac"].default_value = 1
            mix.inputs["Color1"].default_value, mix.inputs["Color2"].default_value = (0.8, 0.4, 0.6, 1), (0.5, 0.5, 1, 1)
            gamma.inputs["Gamma"].default_value = 2
            end = next(each for each in tree.nodes if each.type == "BSDF_DIFFUSE")
            tree.links.new(mix.outputs[0], gamma.inputs["Color"])
            tree.links.new(gamma.outputs[0], end.inputs["Color"])
            return made

        self.assertTrue(np.allclose(self.one(material), (0.16, 0.04, 0.36), rtol=0.02))

    def test_principled_is_close_to_cycles(self):
        for inputs in ({"Roughness": 1.0, "Specular": 0.0}, {"Metallic": 1.0, "Roughness": 0.3}, {"Roughness": 0.4}):
            with self.subTest(str(inputs)):
                scene = new_scene((24, 24))
                add_ball(material=shader("p", "ShaderNodeBsdfPrincipled", Base_Color=(0.6, 0.3, 0.2, 1), **inputs))
                set_world((0.7, 0.8, 1))
                look_at(add_camera((0, -4, 0)), (0, 0, 0))
                scene.cycles.samples = 128
                ours, theirs = render()[6:18, 6:18, :3], render("CYCLES")[6:18, 6:18, :3]
                self.assertLess(abs(ours.mean() / theirs.mean() - 1), 0.06)

    def test_glass_and_transparency_show_what_is_behind(self):
        for material in (lambda: shader("glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.45),
                         lambda: shader("clear", "ShaderNodeBsdfTransparent")):
            scene = new_scene((24, 24))
            add_ball(material=material())
            wall = add_plane(4, shader("glow", "ShaderNodeEmission", Color=(1, 0.2, 0.1, 1)), "wall")
            wall.location, wall.rotation_euler = (0, 3, 0), (math.pi / 2, 0, 0)
            look_at(add_camera((0, -4, 0)), (0, 0, 0))
            scene.cycles.samples = 128
            ours, theirs = render(), render("CYCLES")
            self.assertTrue(np.allclose(ours[11:13, 11:13].mean(axis=(0, 1)), theirs[11:13, 11:13].mean(axis=(0, 1)), rtol=0.1))

    def test_mix_of_shaders_is_told_with_its_material(self):
        def material():
            made = shader("veneer", "ShaderNodeMixShader", Fac=0.5)
            tree = made.node_tree
            mix = next(each for each in tree.nodes if each.type == "MIX_SHADER")
            for index, (kind, color) in enumerate((("ShaderNodeBsdfDiffuse", (0.8, 0, 0, 1)), ("ShaderNodeBsdfGlossy", (1, 1, 1, 1)))):
                node = tree.nodes.new(kind)
                node.inputs["Color"].default_value = color
                tree.links.new(node.outputs[0], mix.inputs[1 + index])
            return made

        self.one(material)
        self.assertTrue(any("veneer" in each and "mix" in each for each in WARNINGS), WARNINGS)

    def test_patterns_are_told_with_their_material(self):
        def material():
            made = shader("marble", "ShaderNodeBsdfDiffuse")
            node = made.node_tree.nodes.new("ShaderNodeTexNoise")
            end = next(each for each in made.node_tree.nodes if each.type == "BSDF_DIFFUSE")
            made.node_tree.links.new(node.outputs["Color"], end.inputs["Color"])
            return made

        self.one(material)
        self.assertTrue(any("marble" in each for each in WARNINGS), WARNINGS)

    def test_vertex_colours(self):
        def material():
            made = shader("painted", "ShaderNodeBsdfDiffuse")
            node = made.node_tree.nodes.new("ShaderNodeVertexColor")
            node.layer_name = "paint"
            end = next(each for each in made.node_tree.nodes if each.type == "BSDF_DIFFUSE")
            made.node_tree.links.new(node.outputs["Color"], end.inputs["Color"])
            return made

        new_scene((8, 8))
        plane = add_plane(2, material())
        layer = plane.data.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", [0.2, 0.5, 0.1, 1] * 4)
        set_world((1, 1, 1))
        add_camera((0, 0, 1), ortho=0.5)
        self.assertTrue(np.allclose(render()[4, 4, :3], (0.2, 0.5, 0.1), rtol=0.02))

    def test_background_is_transparent(self):
        scene = new_scene((16, 16))
        add_ball(radius=0.5, material=diffuse())
        set_world((1, 1, 1))
        add_camera((0, 0, 5), ortho=2)
        scene.render.film_transparent = True
        image = render()
        self.assertEqual(image[0, 0].tolist(), [0, 0, 0, 0])
        self.assertEqual(image[8, 8, 3], 1)


main(Geometry, Materials)
