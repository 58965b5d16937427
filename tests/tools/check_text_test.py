# SPDX-License-Identifier: Apache-2.0
"""Each text check finds its fault, and a clean file passes all of them."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

k_tool = pathlib.Path(__file__).resolve().parents[2] / "tools" / "check_text.py"
k_first = "// SPDX-License-Identifier: Apache-2.0\n"


def check(text: str, *checks: str) -> subprocess.CompletedProcess:
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "a.cpp").write_bytes(text.encode())
        return subprocess.run([sys.executable, k_tool, "--root", folder, *checks], capture_output=True, text=True)


class CheckText(unittest.TestCase):
    def test_clean(self):
        for text in [k_first + "int a = 0;   // see other/wo" + "rk/notes, $TMP/wo" + "rk/x\n",
                     k_first + "// LONG: a table\n" + "int a;\n" * 600,
                     k_first + "void f()\n{\n" + "    f();\n" * 98 + "}\n",
                     k_first + "// LONG: a sequence\nvoid f()\n{\n" + "    f();\n" * 300 + "}\n",
                     k_first + "// Not build/release/gnomon.h, https://example.org/src/x.cpp, /usr/include/a.h, a.cpp.\n"
                     + '#include "other/made.h"\n']:
            result = check(text)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_faults(self):
        for name, text, line in [
            ("paths", k_first + "// in /" + "work/here\n", 2),
            ("paths", k_first + "// in /home/" + "somebody/here\n", 2),
            ("paths", k_first + "// in /tmp/" + "bash_jobs\n", 2),
            ("spdx", "int a;\n", 1),
            ("ascii", k_first + "// \u00d7\n", 2),
            ("length", k_first + "int a;\n" * 600, 1),
            ("functions", k_first + "void f()\n{\n" + "    f();\n" * 99 + "}\n", 3),
            ("functions", k_first + "struct A {\n    void f()\n    {\n" + "        f();\n" * 99 + "    }\n};\n", 4),
            ("references", k_first + "// As in src" + "/elsewhere/gone.cpp.\n", 2),
            ("references", k_first + "int a;   // elsewhere/" + "gone.glsl has it\n", 2),
            ("references", k_first + "// See tests/" + "gone.\n", 2),
            ("subranges", k_first + "auto last = std::ranges::" + "unique(list);\n", 2),
            ("newline", k_first + "int a; \n", 2),
            ("newline", k_first + "\tint a;\n", 2),
            ("newline", k_first + "int a;\r\n", 2),
            ("newline", k_first + "int a;\n\n", 3),
        ]:
            with self.subTest(name=name, text=text[-30:]):
                for checks in ([name], []):
                    result = check(text, *checks)
                    self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                    self.assertIn(f"a.cpp:{line}: ", result.stdout)

    def test_unknown_check_is_refused(self):
        self.assertEqual(check(k_first, "nonsense").returncode, 2)


if __name__ == "__main__":
    unittest.main()
