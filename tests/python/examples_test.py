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


if __name__ == "__main__":
    if len(sys.argv) > 1 and sys.argv[1].isdigit():
        IMAGES = int(sys.argv.pop(1))
    unittest.main()
