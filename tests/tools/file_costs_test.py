# SPDX-License-Identifier: Apache-2.0
"""tools/file_costs.py measures programs: what it prints of some that behave in known ways."""
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

k_tool = pathlib.Path(__file__).resolve().parents[2] / "tools" / "file_costs.py"

# Stands in for `gnomon render FILE -o IMAGE --size WxH`.
k_program = """#!/bin/sh
case "$2" in
    *busy*) i=0; while [ $i -lt 20000 ]; do i=$((i + 1)); done ;;
    *hangs*) exec sleep 60 ;;
    *refused*) exit 3 ;;
    *crashes*) kill -SEGV $$ ;;
esac
[ "$7" = "" ] || [ "$7 $8" = "--threads 1" ] || exit 2
echo "warning: one" >&2
echo "a line" >&2
"""


class FileCosts(unittest.TestCase):
    def run_on(self, names: list[str], *options: str) -> tuple[int, list[str]]:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            program = root / "program"
            program.write_text(k_program)
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            for name in names:
                (root / "scenes" / name).parent.mkdir(parents=True, exist_ok=True)
                (root / "scenes" / name).touch()
            result = subprocess.run([sys.executable, k_tool, root / "scenes", "--program", program, *options],
                                    capture_output=True, text=True, check=False)
            return result.returncode, result.stdout.splitlines()

    def test_the_slowest_file_comes_first(self):
        code, lines = self.run_on(["a.gltf", "b/busy.glb", "a.bin", "refused.obj"])
        self.assertEqual(code, 0)
        self.assertTrue(lines[1].endswith("b/busy.glb"), lines)
        self.assertTrue(lines[-1].startswith("3 files,"), lines)
        self.assertIn("1 refused, 0 failed", lines[-1])
        self.assertEqual([line.split()[3] for line in lines[1:-1] if "refused" not in line], ["1", "1"])

    def test_a_file_that_hangs_is_stopped(self):
        code, lines = self.run_on(["hangs.gltf"], "--limit-s", "0.3")
        self.assertEqual((code, lines[1].split()[2]), (1, "limit"))

    def test_signals_and_costs_beyond_limits_are_failures(self):
        self.assertEqual(self.run_on(["crashes.gltf"])[0], 1)
        self.assertEqual(self.run_on(["busy.gltf"], "--most-s", "0.001")[0], 1)
        self.assertEqual(self.run_on(["busy.gltf"], "--most-mb", "0.001")[0], 1)
        self.assertEqual(self.run_on(["busy.gltf"], "--most-s", "60", "--most-mb", "500")[0], 0)

    def test_chooses_files(self):
        self.assertIn("1 files", self.run_on(["a.gltf", "busy.gltf"], "--only", "busy")[1][-1])
        self.assertEqual(len(self.run_on(["a.gltf", "busy.gltf"], "--slowest", "1")[1]), 3)

    def test_passes_options_on_behind_others(self):
        code, lines = self.run_on(["a.gltf"], "--size", "8x8", "--", "--threads", "1")
        self.assertEqual((code, lines[-1][:7]), (0, "1 files"))


if __name__ == "__main__":
    unittest.main()
