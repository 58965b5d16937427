# SPDX-License-Identifier: Apache-2.0
"""The examples in Python run, at small sizes; the data set has the same bytes in every run and under every instruction set.

    examples_test.py [IMAGES]    images of the data set: 4 without it
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import gnomon
from support import ROOT

IMAGES = 4


class Examples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_example(self, name, *arguments, out="out", instruction_set=None):
        environment = {k: v for k, v in os.environ.items() if k != "GNOMON_ISA"}
        environment["PYTHONPATH"] = str(Path(gnomon.__file__).parents[1])
        if instruction_set:
            environment["GNOMON_ISA"] = instruction_set
        result = subprocess.run([sys.executable, "-B", str(ROOT / "examples/python" / name), "--out", str(self.folder / out),
                                 *map(str, arguments)], capture_output=True, text=True, env=environment)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_the_robots_camera_lists_what_it_sees(self):
        text = self.run_example("robot_camera.py", "--frames", 1, "--width", 128)
        for name in ("red ball", "blue box", "cone on the floor"):
            self.assertIn(name, text)
        self.assertEqual(sorted(f.name for f in (self.folder / "out").iterdir()),
                         ["robot-1-depth.png", "robot-1-ids.png", "robot-1.png"])

    def test_the_pendulum_hands_over_two_transforms(self):
        text = self.run_example("pendulum.py", "--frames", 3, "--width", 96)
        self.assertEqual(len(list((self.folder / "out").glob("pendulum-*.png"))), 3)
        skipped = [int(line.split()[3]) for line in text.splitlines()[1:]]
        self.assertEqual(len(skipped), 3)
        self.assertGreater(skipped[2], 0)   # shadows are remembered

    def test_the_turntable_turns_a_model_or_a_file(self):
        self.run_example("turntable.py", "--frames", 2, "--width", 64)
        first, second = ((self.folder / "out" / f"turntable-000{i}.png").read_bytes() for i in (1, 2))
        self.assertNotEqual(first, second)
        self.run_example("turntable.py", "builtin:cornell", "--frames", 1, "--width", 64, out="cornell")

    def test_the_data_set_has_the_same_bytes_in_every_run_and_under_every_instruction_set(self):
        sets = ["sse4.2", "avx", "avx2", "avx512"]
        sets = sets[: sets.index(gnomon.instruction_set()) + 1]
        def files(out):
            return {f.name: f.read_bytes() for f in sorted((self.folder / out).iterdir())}

        texts = []
        for run, isa in enumerate([None, None, sets[0], sets[-2] if len(sets) > 1 else None]):
            texts.append(self.run_example("dataset.py", "--images", IMAGES, "--size", "96x72", out=f"run{run}",
                                          instruction_set=isa).splitlines()[-1])
            self.assertEqual(files(f"run{run}"), files("run0"), isa)
        self.assertEqual(len(set(texts)), 1)
        self.assertEqual(len(files("run0")), 3 * IMAGES + 1)

    def test_the_data_sets_labels_are_true(self):
        self.run_example("dataset.py", "--images", 1, "--size", "96x72")
        line = json.loads((self.folder / "out/poses.jsonl").read_text())
        self.assertLessEqual({"table", "floor"}, set(line["ids"]))
        # Things stand before the camera, and most are in the image.
        k, pose = np.array(line["camera_matrix"]), np.array(line["world_to_camera"])
        inside = 0
        for matrix in line["objects"].values():
            in_camera = pose @ np.array(matrix)[:, 3]
            x, y, z = k @ in_camera
            self.assertGreater(z, 0)
            inside += 0 <= x / z < 96 and 0 <= y / z < 72
        self.assertGreater(inside, len(line["objects"]) // 2)

    def scenario(self, *arguments, code=0):
        environment = {**os.environ, "PYTHONPATH": str(Path(gnomon.__file__).parents[1])}
        result = subprocess.run([sys.executable, "-B", str(ROOT / "examples/python/khronos_scenario.py"), *arguments],
                                capture_output=True, text=True, env=environment, cwd=self.folder)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr

    def write_scenario(self):
        """A square in the plane z = 0, red to the right of the middle and green to the left, and an even environment."""
        corners = np.array([[-1, -1, 0], [0, -1, 0], [0, 1, 0], [-1, 1, 0], [0, -1, 0], [1, -1, 0], [1, 1, 0], [0, 1, 0]],
                           dtype="<f4")
        indices = np.array([0, 1, 2, 0, 2, 3, 0, 1, 2, 0, 2, 3], dtype="<u2")
        (self.folder / "model.bin").write_bytes(corners.tobytes() + indices.tobytes())
        def accessor(view, start, kind, count, of):
            return {"bufferView": view, "byteOffset": start, "componentType": kind, "count": count, "type": of,
                    **({"min": [-1, -1, 0], "max": [1, 1, 0]} if of == "VEC3" else {})}

        primitives = [{"attributes": {"POSITION": i}, "indices": 2 + i, "material": i} for i in (0, 1)]
        materials = [{"pbrMetallicRoughness": {"baseColorFactor": [*c, 1], "metallicFactor": 0}, "doubleSided": True}
                     for c in ([0, 1, 0], [1, 0, 0])]
        (self.folder / "model.gltf").write_text(json.dumps({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": primitives}], "materials": materials,
            "buffers": [{"uri": "model.bin", "byteLength": corners.nbytes + indices.nbytes}],
            "bufferViews": [{"buffer": 0, "byteLength": corners.nbytes},
                            {"buffer": 0, "byteOffset": corners.nbytes, "byteLength": indices.nbytes}],
            "accessors": [accessor(0, 0, 5126, 4, "VEC3"), accessor(0, 48, 5126, 4, "VEC3"),
                          accessor(1, 0, 5123, 6, "SCALAR"), accessor(1, 12, 5123, 6, "SCALAR")]}))
        sky = np.zeros((8, 16, 4), dtype=np.uint8)
        sky[...] = (128, 128, 128, 129)
        (self.folder / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + sky.tobytes())
        return {"name": "square", "model": "model.gltf", "lighting": "sky.hdr", "dimensions": {"width": 16, "height": 12},
                "target": {"x": 0, "y": 0, "z": 0}, "orbit": {"theta": 0, "phi": 90, "radius": 4}, "verticalFoV": 45,
                "renderSkybox": False}

    def pixels(self, name):
        result = subprocess.run(["ffmpeg", "-v", "error", "-i", str(self.folder / name), "-f", "rawvideo", "-pix_fmt",
                                 "rgba", "-"], capture_output=True, check=True)
        return np.frombuffer(result.stdout, np.uint8)

    def test_khronos_scenarios_are_rendered_as_the_comparison_calls(self):
        scenario = self.write_scenario()
        self.scenario(json.dumps({"scenario": scenario, "outputFile": "out/a.png"}))
        image = self.pixels("out/a.png").reshape(24, 32, 4)
        self.assertEqual(image[0, 0, 3], 0)
        left, right = image[12, 12].astype(int), image[12, 19].astype(int)
        self.assertGreater(left[1], left[0] + 50)
        self.assertGreater(right[0], right[1] + 50)
        # From behind, left and right change; the sky is shown if the scenario says so.
        (self.folder / "config.json").write_text(json.dumps({"scenarios": [
            {**scenario, "orbit": {"theta": 180, "phi": 90, "radius": 4}, "renderSkybox": True}]}))
        self.scenario("config.json", "--name", "square", "--out", "b.png", "--pixel-ratio", "1")
        behind = self.pixels("b.png").reshape(12, 16, 4)
        self.assertEqual(behind[0, 0, 3], 255)
        self.assertGreater(int(behind[6, 6, 0]), int(behind[6, 6, 1]) + 50)

    def test_khronos_scenarios_that_cannot_be_used_are_one_line(self):
        scenario = self.write_scenario()
        for document in ("{", json.dumps({"scenario": {**scenario, "model": "none.glb"}, "outputFile": "a.png"}),
                         json.dumps({"scenario": {}, "outputFile": "a.png"}), "none.json"):
            error = self.scenario(document, code=3)
            self.assertEqual(error.count("\n"), 1, error)


if __name__ == "__main__":
    if len(sys.argv) > 1 and sys.argv[1].isdigit():
        IMAGES = int(sys.argv.pop(1))
    unittest.main()
