# SPDX-License-Identifier: Apache-2.0
"""An animated scene gives the same images through the add-on as through glTF, at the cost of a known scene.

    blender ... -P tests/blender/gltf_test.py [-- FRAMES]    48 without it"""
import os
import resource
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import *  # noqa: E402, F403

import courtyard  # noqa: E402

import gnomon  # noqa: E402
from gnomon_render import units  # noqa: E402

SIZE = (160, 90)
FRAME_COUNT = int(sys.argv[sys.argv.index("--") + 1]) if "--" in sys.argv else courtyard.FRAMES


def processor_seconds() -> float:
    return sum(resource.getrusage(resource.RUSAGE_SELF)[:2])


class ByGltf(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        courtyard.make(cls.folder, detail=1)
        scene = bpy.context.scene
        scene.render.engine = "GNOMON"
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.render.resolution_percentage = 100
        cls.export()

    @classmethod
    def export(cls):
        # The exporter applies either modifiers or shape keys.
        for ob in [each for each in bpy.data.objects if each.type == "MESH"]:
            bpy.context.view_layer.objects.active = ob
            for modifier in list(ob.modifiers):
                bpy.ops.object.modifier_apply(modifier=modifier.name)
        cls.scene_file = os.path.join(cls.folder, "scene.glb")
        bpy.ops.export_scene.gltf(filepath=cls.scene_file, export_cameras=True, export_lights=True)
        width, _ = courtyard.SKY
        cls.sky_file = os.path.join(cls.folder, "gltf.hdr")
        # What is in the middle of Blender's image is towards +X, of Gnomon's towards -Z; and Blender's radiance is in watts.
        sky = read_image(os.path.join(cls.folder, "sky.hdr"))[..., :3]
        courtyard.write_hdr(cls.sky_file, np.roll(sky, width // 4, axis=1) * units.LUMENS_PER_WATT)

    def test_images_are_the_same_and_the_second_frame_costs_what_a_known_scene_does(self):
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAME_COUNT
        bpy.context.scene.render.filepath = os.path.join(self.folder, "blender_####")
        bpy.context.scene.render.image_settings.file_format = "PNG"
        seconds, begun = [], [processor_seconds()]
        store = final.LayerRender._store

        def stored(layer, depsgraph, at, size):
            number = bpy.context.scene.frame_current
            layer.frame.write(os.path.join(self.folder, f"ours-{number:04}.png"))
            store(layer, depsgraph, at, size)
            seconds.append(processor_seconds() - begun[0])
            begun[0] = processor_seconds()

        final.LayerRender._store = stored
        try:
            bpy.ops.render.render(animation=True)
        finally:
            final.LayerRender._store = store
        anew = [frame.counters["began_anew"] for frame, _ in FRAMES]
        self.assertEqual(anew, [1] + [0] * (FRAME_COUNT - 1))

        scene = gnomon.load(self.scene_file, ground=False).with_environment(self.sky_file)
        theirs = []
        with gnomon.Renderer(size=SIZE, samples="auto", exposure=units.STOPS, tonemap="none") as renderer:
            for number in range(1, FRAME_COUNT + 1):
                before = processor_seconds()
                frame = renderer.render(scene, number)
                theirs.append(processor_seconds() - before)
                frame.write(os.path.join(self.folder, f"theirs-{number:04}.png"))
        for number in range(1, FRAME_COUNT + 1):
            files = [os.path.join(self.folder, f"{name}-{number:04}.png") for name in ("ours", "theirs")]
            flip = gnomon.compare(*files).flip
            self.assertLessEqual(flip, 0.01, f"frame {number}")
            if number == 1:
                print(f"FLIP of frame 1: {flip:.5f}")
        others = f"others {np.mean(seconds[2:]):.2f} and {np.mean(theirs[2:]):.2f} s" if FRAME_COUNT > 2 else ""
        print(f"processor time of frame 1: {seconds[0]:.2f} s; by glTF {theirs[0]:.2f} s; frame 2: {seconds[1]:.2f} s; by glTF "
              f"{theirs[1]:.2f} s; {others}")


main(ByGltf)
