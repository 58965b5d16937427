# SPDX-License-Identifier: Apache-2.0
"""The check of targets finds those that link each other, however far around."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

k_tool = pathlib.Path(__file__).resolve().parents[2] / "tools" / "check_targets.py"


def check(graph: str) -> subprocess.CompletedProcess:
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "link_graph.txt"
        file.write_text(graph)
        return subprocess.run([sys.executable, k_tool, file], capture_output=True, text=True)


class CheckTargets(unittest.TestCase):
    def test_layers_pass(self):
        result = check("base: fmt::fmt\nscene: base glm::glm\nray: scene base $<LINK_ONLY:embree>\n")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("3 with 3 links", result.stdout)

    def test_cycles_are_named(self):
        for graph, cycle in [
            ("a: b\nb: a\n", "a links b links a"),
            ("a: b\nb: c\nc: d\nd: b\n", "b links c links d links b"),
            ("a: $<LINK_ONLY:b>\nb: a\n", "a links b links a"),
            ("a: a\n", "a links a"),
        ]:
            result = check(graph)
            self.assertEqual(result.returncode, 1, graph)
            self.assertIn(f"targets: {cycle}\n", result.stdout)

    def test_empty_graph_is_no_pass(self):
        self.assertEqual(check("").returncode, 1)


if __name__ == "__main__":
    unittest.main()
