# SPDX-License-Identifier: Apache-2.0
"""Viewports without a screen: what their thread renders while the scene changes."""
import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import *  # noqa: E402, F403

from gnomon_render import viewport  # noqa: E402


class FakeEngine:
    """What a viewport asks of the engine."""

    def __init__(self):
        self.redraws = 0
        self.warnings = []

    def tag_redraw(self):
        self.redraws += 1

    def warn(self, what):
        self.warnings.append(what)


class FakeRegion3D:
    """A view from the scene's camera."""

    view_perspective = "PERSP"

    def __init__(self, size):
        scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
        camera = scene.camera.evaluated_get(depsgraph)
        self.view_matrix = camera.matrix_world.inverted()
        self.window_matrix = camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1])


class Progressive(unittest.TestCase):
    size = (48, 32)

    def setUp(self):
        new_scene(self.size)
        add_plane(12, diffuse(), "floor")
        add_ball((0, 0, 0.5), 0.5, shader("paint", "ShaderNodeBsdfPrincipled"))
        add_light("POINT", (2, -2, 4), energy=400, shadow_soft_size=0)
        set_world((0.1, 0.1, 0.1))
        look_at(add_camera((0, -6, 3)), (0, 0, 0.5))
        self.engine = FakeEngine()
        self.viewport = viewport.Viewport(self.engine)
        self.viewport.update(None, bpy.context.evaluated_depsgraph_get())
        # Updates are listed while a dependency graph tells of them.
        bpy.app.handlers.depsgraph_update_post.append(self.told)

    def told(self, scene, depsgraph):
        self.viewport.update(None, depsgraph)

    def tearDown(self):
        bpy.app.handlers.depsgraph_update_post.clear()
        self.viewport.close()

    def step(self):
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.viewport.look(FakeRegion3D(self.size), None, self.size, depsgraph)

    def finest(self) -> np.ndarray:
        self.assertTrue(self.viewport.progressive.wait(60), self.viewport.progressive.error)
        self.assertEqual(self.viewport.progressive.error, "")
        image = self.viewport.progressive.image()
        self.assertEqual(image.shape, (self.size[1], self.size[0], 4))
        return image

    def test_ends_with_the_final_image(self):
        self.step()
        image = self.finest()
        self.assertGreaterEqual(self.engine.redraws, 4)
        self.assertLess(np.abs(image - render()).mean(), 5e-3)

    def test_coarse_images_come_first(self):
        sizes = []
        tell = self.viewport.progressive._tell
        self.viewport.progressive._tell = lambda: (sizes.append(self.viewport.progressive.image().shape[1]), tell())
        self.step()
        self.finest()
        self.assertEqual(sizes, [6, 24, 48, 48])

    def test_follows_what_moves(self):
        self.step()
        before = self.finest()
        bpy.data.objects["ball"].location.x = 1
        self.step()
        after = self.finest()
        self.assertGreater(np.abs(after - before).max(), 0.05)
        self.assertLess(np.abs(after - render()).mean(), 5e-3)

    def test_many_changes_in_a_row(self):
        for index in range(20):
            bpy.data.objects["ball"].location.x = 0.05 * index
            self.step()
            time.sleep(0.01 * (index % 4))
        self.assertLess(np.abs(self.finest() - render()).mean(), 5e-3)

    def test_objects_come_and_go(self):
        self.step()
        self.finest()
        add_ball((1, 0, 0.5), 0.4, name="second")
        self.step()
        with_both = self.finest()
        bpy.data.objects.remove(bpy.data.objects["second"])
        self.step()
        alone = self.finest()
        self.assertGreater(np.abs(with_both - alone).max(), 0.05)
        self.assertLess(np.abs(alone - render()).mean(), 5e-3)

    def test_same_view_renders_nothing(self):
        self.step()
        self.finest()
        redraws = self.engine.redraws
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.viewport.look(FakeRegion3D(self.size), None, self.size, depsgraph)
        time.sleep(0.1)
        self.assertEqual(self.engine.redraws, redraws)


class Stopping(unittest.TestCase):
    def test_escape_stops_the_render(self):
        new_scene((640, 360))
        for index in range(30):
            add_ball((index % 6 - 3, index // 6, 0.5), 0.4)
        add_plane(12, diffuse())
        set_world((1, 1, 1))
        look_at(add_camera((0, -8, 4)), (0, 0, 0.5))
        tested = []

        class Pressed:
            """The engine, to which someone presses Escape."""

            def __init__(self, engine):
                self._engine = engine

            def __getattr__(self, name):
                return getattr(self._engine, name)

            def test_break(self):
                tested.append(0)
                return len(tested) > 3

        update = final.LayerRender.update

        def pressed_update(self, depsgraph):
            self.engine = Pressed(self.engine)
            update(self, depsgraph)

        final.LayerRender.update = pressed_update
        try:
            begin = time.monotonic()
            image = render()
            seconds = time.monotonic() - begin
        finally:
            final.LayerRender.update = update
        self.assertGreater(len(tested), 3)
        self.assertEqual(image[..., :3].max(), 0)
        self.assertLess(seconds, 10)


main(Progressive, Stopping)
