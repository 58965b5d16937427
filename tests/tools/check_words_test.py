# SPDX-License-Identifier: Apache-2.0
"""The check of retired words finds each of them, in prose and in identifiers, and nothing else."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

k_tool = pathlib.Path(__file__).resolve().parents[2] / "tools" / "check_words.py"
sys.path.insert(0, str(k_tool.parent))
import check_words  # noqa: E402


def found(line: str) -> list[str]:
    return [word for word, _ in check_words.faults_of(line)]


class CheckWords(unittest.TestCase):
    def test_finds_every_word_with_its_plural_and_in_identifiers(self):
        for word in check_words.k_words:
            for line in (f"// The {word} is here.", f"// {word.capitalize()}: so", f"int {word}_count;",
                         f"void find{word.capitalize()}At();", f"k_{word}", word.upper(), f'"a {word} message"'):
                self.assertEqual(found(line), [word], line)
            self.assertEqual(found(f"// All {word}s."), [word + "s"])
        for stem in check_words.k_stems:
            self.assertEqual(found(f"// It {stem}s."), [stem + "s"])
            self.assertEqual(found(f"{stem}ed_at"), [stem + "ed"])
        for phrase in check_words.k_phrases:
            self.assertEqual(found(f"// It is {phrase} there."), [phrase])
            self.assertEqual(found(phrase.replace(" ", "_") + "_"), [phrase])

    def test_leaves_other_words_and_exceptions(self):
        for line in ("// verbose, filmic, removers, clamp, twine, shares, lift, put it off", "GNOMON_CLAMP(x)",
                     "--movers M", 'json["movers"]', '{"picture", 1}', "median_picture_ms", "remove_r"):
            self.assertEqual(found(line), [], line)
        self.assertTrue(all(reason for _, reason in check_words.k_exceptions))

    def test_prints_file_line_word_and_what_to_say(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.cpp"
            file.write_text("int a;\nint mover_count;\n")
            result = subprocess.run([sys.executable, k_tool, "--root", folder], capture_output=True, text=True)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stdout, "a.cpp:2: retired word 'mover': say 'dynamic object'\n")
            file.write_text("int a;\n")
            result = subprocess.run([sys.executable, k_tool, "--root", folder], capture_output=True, text=True)
            self.assertEqual(result.returncode, 0, result.stdout)


if __name__ == "__main__":
    unittest.main()
