# SPDX-License-Identifier: Apache-2.0
"""tools/same_bytes.py finds frames that differ under one instruction set, and does not pass without a comparison."""
import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

k_tool = pathlib.Path(__file__).resolve().parents[2] / "tools/same_bytes.py"

# Renders a word that depends on the limit, as a program that uses wider instructions would.
k_program = """#!/bin/sh
if [ "$1" = devices ]; then echo '{"cpu": {"instruction_set": "%(best)s"}}'; exit; fi
out=; while [ $# -gt 0 ]; do [ "$1" = -o ] && out=$2; shift; done
echo "frame of %(word)s" > "$(dirname "$out")/f-0001.exr"
exit %(code)s
"""


class SameBytes(unittest.TestCase):
    def run_with(self, *arguments, best="avx512", word="any", code="0"):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder, "program")
            program.write_text(k_program % {"best": best, "word": word, "code": code})
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            return subprocess.run([sys.executable, str(k_tool), "--program", str(program), "--only", "cornell", *arguments],
                                  capture_output=True, text=True, env=os.environ | {"GNOMON_ISA": "avx"})

    def test_equal_frames_pass(self):
        result = self.run_with()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("under sse4.2, avx, avx2, avx512: 0 different", result.stdout)
        self.assertNotIn("DIFFERENT", result.stdout)

    def test_frames_of_one_instruction_set_that_differ_are_found(self):
        result = self.run_with(word='$([ "$GNOMON_ISA" = avx ] && echo avx || echo others)')
        self.assertEqual(result.returncode, 1)
        for line in result.stdout.splitlines()[:-1]:
            self.assertRegex(line, r"^DIFFERENT  sse4.2=(\w+) avx=(?!\1)\w+ avx2=\1 avx512=\1 ")
        self.assertRegex(result.stdout, r"(\d+) cases .*: \1 different")

    def test_one_instruction_set_is_no_comparison(self):
        self.assertEqual(self.run_with(best="sse4.2").returncode, 77)

    def test_a_program_that_fails_is_named(self):
        result = self.run_with(code="5")
        self.assertEqual(result.returncode, 1)
        self.assertIn("exit 5", result.stderr)

    def test_rows_that_are_not_there_are_no_pass(self):
        result = self.run_with("--only", "no such row")
        self.assertEqual(result.returncode, 1)
        self.assertIn("no case", result.stderr)


if __name__ == "__main__":
    unittest.main()
