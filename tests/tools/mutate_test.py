#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/mutate.py: what of its table it refuses, and how it judges."""
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
import mutate  # noqa: E402
from mutations import row  # noqa: E402


def one(name="a", file="code.cpp", original="1 + 2", replacement="1 - 2", tests=("unit:Sum.*",)):
    return row(name, "shading", "a sum is a difference", file, original, replacement, *tests)


class FakeCopy:
    """Runs no compiler: tests fail where they are told to."""

    def __init__(self, tree, builds=True, failing=None, passed=1):
        self.tree, self.builds, self.failing, self.passed, self.seen = tree, builds, failing, passed, []

    def make(self, programs):
        self.seen.append((self.tree / "code.cpp").read_text())
        return self.builds, "code.cpp:1: error: no such thing"

    def run(self, test):
        return self.failing, self.passed


class Table(unittest.TestCase):
    def faults(self, *rows):
        with tempfile.TemporaryDirectory() as folder:
            tests = Path(folder) / "tests/unit"
            tests.mkdir(parents=True)
            (tests / "sum_test.cpp").write_text("TEST(Sum, OfTwo)\n{\n}\n")
            (Path(folder) / "code.cpp").write_text("int sum() { return 1 + 2; }\nint two() { return 2 + 2; }\n")
            with mock.patch.object(mutate, "MUTATIONS", rows), mock.patch.object(mutate, "SOURCE", Path(folder)):
                return mutate.faults_of_table()

    def test_accepts_what_fits(self):
        self.assertEqual(self.faults(one()), [])

    def test_refuses_what_does_not(self):
        for fault, rows in {
            "found once but 0 times": [one(original="1 + 3")],
            "found once but 2 times": [one(original="+ 2")],
            "changes nothing": [one(replacement="1 + 2")],
            "does not exist": [one(file="other.cpp")],
            "no test program 'units'": [one(tests=("units:Sum.*",))],
            "no test of unit is named Product.*": [one(tests=("unit:Sum.*:Product.*",))],
            "names no test": [one(tests=())],
            "a second row": [one(), one()],
        }.items():
            found = self.faults(*rows)
            self.assertEqual(len(found), 1, fault)
            self.assertIn(fault, found[0])


class Judgement(unittest.TestCase):
    def judge(self, **how):
        with tempfile.TemporaryDirectory() as folder:
            code = Path(folder) / "code.cpp"
            code.write_text("return 1 + 2;\n")
            copy = FakeCopy(Path(folder), **how)
            state = mutate.judge(copy, one(), wide=False)
            self.assertEqual(copy.seen[0], "return 1 - 2;\n")
            self.assertEqual(code.read_text(), "return 1 + 2;\n", "the copy is as it was")
            return state

    def test_of_a_failing_test(self):
        self.assertEqual(self.judge(failing="Sum.OfTwo"), (mutate.KILLED, "Sum.OfTwo"))

    def test_of_passing_tests(self):
        self.assertEqual(self.judge(), (mutate.SURVIVED, ""))

    def test_of_skipped_tests(self):
        self.assertEqual(self.judge(passed=0), (mutate.SKIPPED, ""))

    def test_of_code_that_does_not_compile(self):
        self.assertEqual(self.judge(builds=False), (mutate.NO_BUILD, "error: no such thing"))


class Report(unittest.TestCase):
    def test_counts_and_marks_survivors(self):
        rows = (one("a"), one("b"))
        results = {"a": {"state": mutate.KILLED, "found": "Sum.OfTwo"}, "b": {"state": mutate.SURVIVED, "found": ""}}
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(mutate, "MUTATIONS", rows):
            page = Path(folder) / "page.md"
            page.write_text("# Title\n<!-- begin of the table -->\nold\n<!-- end of the table -->\nrest\n")
            mutate.report(results, page)
            text = page.read_text()
        self.assertIn("1 of 2 mistakes are found.", text)
        self.assertIn("`Sum.OfTwo`", text)
        self.assertIn("**survived**", text)
        self.assertNotIn("old", text)
        self.assertTrue(text.startswith("# Title\n") and text.endswith("rest\n"))


if __name__ == "__main__":
    unittest.main()
