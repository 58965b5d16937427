# SPDX-License-Identifier: Apache-2.0
"""Animations: what is remembered from frame to frame changes no image."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import *  # noqa: E402, F403

from courtyard import key_linear as keyed  # noqa: E402


def make_stage():
    """A floor, a ball that rolls, a flag that waves, instances that turn, a light that dims, paint that changes."""
    scene = new_scene((48, 32))
    add_plane(12, diffuse(), "floor")
    ball = add_ball((-1.5, 0, 0.5), 0.5, shader("paint", "ShaderNodeBsdfPrincipled", Base_Color=(0.7, 0.2, 0.1, 1)))
    keyed(ball, "location", {1: -1.5, 5: 1.5}, 0)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4, size=1, location=(0, 1.5, 1), rotation=(1.3, 0, 0))
    flag = bpy.context.object
    flag.name = "flag"
    flag.shape_key_add(name="rest")
    waved = flag.shape_key_add(name="waved")
    for point in waved.data:
        point.co.z += 0.3 * math.sin(5 * point.co.x)
    keyed(waved, "value", {1: 0.0, 5: 1.0})
    bpy.ops.mesh.primitive_cube_add(size=0.3)
    cube = bpy.context.object
    ring = add_plane(2, name="ring")
    cube.parent, ring.instance_type, ring.show_instancer_for_render = ring, "VERTS", False
    ring.location = (0, 0, 1.8)
    keyed(ring, "rotation_euler", {1: 0.0, 5: 1.0}, 2)
    light = add_light("POINT", (2, -2, 4), energy=400, shadow_soft_size=0)
    keyed(light.data, "energy", {1: 400.0, 5: 200.0})
    color = bpy.data.materials["paint"].node_tree.nodes["Principled BSDF"].inputs["Roughness"]
    keyed(color, "default_value", {1: 0.2, 5: 0.9})
    gone = add_ball((1.5, -1, 0.3), 0.3, name="gone")
    keyed(gone, "hide_render", {1: False, 3: True, 5: False})
    set_world((0.1, 0.1, 0.15))
    look_at(add_camera((0, -6, 3)), (0, 0, 0.5))
    return scene


class Remembered(unittest.TestCase):
    def test_frames_are_those_of_fresh_renderers(self):
        make_stage()
        FRAMES.clear()
        kept = animate(5, persistent=True)
        self.assertEqual(len({id(layer) for _, layer in FRAMES}), 1)
        anew = [frame.counters["began_anew"] for frame, _ in FRAMES]
        self.assertEqual(anew, [1, 0, 0, 0, 0])
        FRAMES.clear()
        fresh = animate(5, persistent=False)
        self.assertEqual([frame.counters["began_anew"] for frame, _ in FRAMES], [1] * 5)
        for number, (a, b) in enumerate(zip(kept, fresh), 1):
            # The shape in which a mesh is first read bears on how its bounced light is divided, and on ties.
            self.assertLess(np.abs(a - b).max(), 2e-2, f"frame {number}")
            self.assertLess(np.abs(a - b).mean(), 1e-3, f"frame {number}")
        self.assertGreater(np.abs(kept[0] - kept[1]).max(), 0.01)

    def test_changes_of_the_scene_are_seen(self):
        """Frame 5 shows another image than frame 1 wherever something has changed."""
        make_stage()
        first, *_, last = animate(5)
        self.assertGreater(np.mean(np.abs(first - last)[..., :3].max(axis=-1) > 1e-3), 0.5)

    def test_only_what_changed_is_handed_over(self):
        scene = make_stage()
        counts = []
        render_ = final.LayerRender._render

        def counted(self, depsgraph, number, camera, size, more, closing=None):
            counts.append(self._changes.count())
            return render_(self, depsgraph, number, camera, size, more, closing)

        for index in range(50):
            ob = bpy.data.objects.new(f"still {index}", bpy.data.objects["floor"].data)
            ob.location.z = -1 - index
            scene.collection.objects.link(ob)
        final.LayerRender._render = counted
        try:
            animate(3)
        finally:
            final.LayerRender._render = render_
        # Ball, flag, four instances, light, paint, and what vanishes.
        self.assertTrue(all(count <= 9 for count in counts[1:]), counts)

    def test_what_was_taken_for_fixed_may_move_all_the_same(self):
        scene = make_stage()
        animate(1)

        def moved(scene_, *_):
            bpy.data.objects["floor"].location.z = -0.1 * (scene_.frame_current - 1)

        bpy.app.handlers.frame_change_pre.append(moved)
        try:
            kept, fresh = animate(3, persistent=True), animate(3, persistent=False)
        finally:
            bpy.app.handlers.frame_change_pre.remove(moved)
        self.assertLess(np.abs(kept[2] - fresh[2]).mean(), 5e-3)
        self.assertGreater(np.abs(kept[2] - kept[1]).mean(), 5e-3)
        self.assertEqual(scene.frame_end, 3)

    def test_other_topology(self):
        new_scene((24, 24))
        bpy.ops.mesh.primitive_cube_add(size=1)
        ob = bpy.context.object
        modifier = ob.modifiers.new("more", "ARRAY")
        keyed(modifier, "count", {1: 1, 2: 2, 3: 3})
        set_world((1, 1, 1))
        look_at(add_camera((2, -5, 2)), (1, 0, 0))
        kept, fresh = animate(3, persistent=True), animate(3, persistent=False)
        for a, b in zip(kept, fresh):
            self.assertLess(np.abs(a - b).max(), 1e-3)

    def test_several_view_layers(self):
        scene = make_stage()
        other = scene.view_layers.new("other")
        other.material_override = shader("white", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1))
        FRAMES.clear()
        animate(2)
        self.assertEqual(len(FRAMES), 4)
        self.assertEqual(len({id(layer) for _, layer in FRAMES}), 2)
        self.assertGreater(np.abs(FRAMES[0][0].color - FRAMES[1][0].color).max(), 1)


class Blur(unittest.TestCase):
    def test_motion_blur_of_objects_deformation_and_camera(self):
        for what in ("object", "vertices", "camera"):
            with self.subTest(what):
                scene = new_scene((48, 24))
                glow = shader("glow", "ShaderNodeEmission", Strength=1.0)
                plane = add_plane(1, glow)
                camera = add_camera((0, 0, 5), ortho=6)
                if what == "object":
                    keyed(plane, "location", {1: -2.0, 3: 2.0}, 0)
                    curves = plane.animation_data.action.fcurves
                elif what == "camera":
                    keyed(camera, "location", {1: -2.0, 3: 2.0}, 0)
                    curves = camera.animation_data.action.fcurves
                else:
                    plane.shape_key_add(name="rest")
                    moved = plane.shape_key_add(name="moved")
                    for point in moved.data:
                        point.co.x += 4
                    plane.location.x = -2
                    keyed(moved, "value", {1: 0.0, 3: 1.0})
                    curves = plane.data.shape_keys.animation_data.action.fcurves
                for point in curves[0].keyframe_points:
                    point.interpolation = "LINEAR"
                scene.render.use_motion_blur = True
                scene.render.motion_blur_shutter = 0.5
                scene.cycles.samples = 256
                ours, theirs = render(frame=2)[..., 0], render("CYCLES", frame=2)[..., 0]
                # A square of 8 pixels that moves by 8 while the shutter is open.
                self.assertLess(np.abs(ours - theirs).mean(), 0.02)
                self.assertGreater(np.count_nonzero((theirs > 0.2) & (theirs < 0.8)), 20)
                self.assertEqual(scene.frame_current, 2)

    def test_blurred_frames_in_turn_are_those_of_fresh_renderers(self):
        scene = make_stage()
        scene.render.use_motion_blur = True
        kept, fresh = animate(3, persistent=True), animate(3, persistent=False)
        for a, b in zip(kept, fresh):
            self.assertLess(np.abs(a - b).mean(), 2e-3)

    def test_depth_of_field(self):
        for kind, f_number in (("PERSP", 0.1), ("ORTHO", 2)):
            with self.subTest(kind):
                scene = new_scene((48, 24))
                glow = shader("glow", "ShaderNodeEmission", Strength=1.0)
                plane = add_plane(1, glow)
                camera = add_camera((0, 0, 5))
                data = camera.data
                data.type, data.ortho_scale = kind, 3.6
                data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = True, 2, f_number
                scene.cycles.samples = 256
                ours, theirs = render()[..., 0], render("CYCLES")[..., 0]
                self.assertLess(np.abs(ours - theirs).mean(), 0.02)
                self.assertGreater(np.count_nonzero((theirs > 0.2) & (theirs < 0.8)), 20)
                data.dof.focus_object = plane
                self.assertGreater(np.abs(render()[..., 0] - ours).max(), 0.3)


class Passes(unittest.TestCase):
    def test_passes_are_those_of_cycles(self):
        scene = make_stage()
        scene.frame_set(3)
        bpy.data.objects["ball"].pass_index = 7
        view = bpy.context.view_layer
        for name in ("z", "normal", "vector", "object_index", "diffuse_color", "shadow"):
            setattr(view, "use_pass_" + name, True)
        scene.cycles.samples = 64
        scene.cycles.pixel_filter_type = "BOX"
        ours, theirs = render_passes("GNOMON"), render_passes("CYCLES")
        self.assertEqual(set(ours), set(theirs))
        # Most pixels show one surface; those at edges are filtered otherwise.
        for name, tolerance, share in (("Depth", 0.05, 0.93), ("Normal", 0.05, 0.85), ("Vector", 0.35, 0.85),
                                       ("IndexOB", 0.01, 0.9), ("DiffCol", 0.03, 0.85), ("Shadow", 0.05, 0.8),
                                       ("Image", 0.05, 0.8)):
            with self.subTest(name):
                close = np.abs(ours[name] - theirs[name]).max(axis=-1) < tolerance
                self.assertGreater(close.mean(), share)
        self.assertEqual(scene.frame_current, 3)


main(Remembered, Blur, Passes)
