# SPDX-License-Identifier: Apache-2.0
"""Doxygen sees the comments of the public headers, and the API reference is not made if one is missing."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

k_root = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(k_root / "tools"))
from doxygen_filter import filtered, k_no_words  # noqa: E402


class DoxygenFilter(unittest.TestCase):
    def test_comment_below_pragma_describes_the_file(self):
        self.assertEqual(filtered("// SPDX\n#pragma once\n// What it is.\n//\n// More.\n\n// Else.\n"),
                         "// SPDX\n/// \\file\n/// What it is.\n///\n/// More.\n\n// Else.\n")
        self.assertEqual(filtered("#pragma once\n\n// Else.\n"), "#pragma once\n\n// Else.\n")

    def test_comment_behind_a_declaration_moves_before_it(self):
        self.assertEqual(filtered("struct A {\n    int x = 0;   // metres\n};"),
                         "struct A {\n/** metres */ int x = 0;\n};")
        self.assertEqual(filtered("    first,   // one\n    last   // two\n"), "/** one */ first,\n/** two */ last\n")
        self.assertEqual(filtered('    std::string s = "//";   // a path'), '/** a path */ std::string s = "//";')

    def test_comment_continues_on_lines_that_are_indented_more(self):
        self.assertEqual(filtered("    int x;   // one\n             // two\n    // three\n    int y;   // four"),
                         "/** one two */ int x;\n\n    // three\n/** four */ int y;")

    def test_every_variable_of_a_declaration_has_the_comment(self):
        self.assertEqual(filtered("    std::array<int, 2> a{1, 2}, b{};   // c"),
                         "/** c */ std::array<int, 2> a{1, 2}; /** c */ std::array<int, 2> b{};")
        self.assertEqual(filtered("    void f(int a, int b);   // c"), "/** c */ void f(int a, int b);")

    def test_members_and_copies_need_no_comment_but_functions_do(self):
        empty = f"/** {k_no_words} */"
        self.assertEqual(filtered("    int x = 0;"), f"{empty} int x = 0;")
        self.assertEqual(filtered("    } shadow;"), f"    }} shadow; ///< {k_no_words}")
        self.assertEqual(filtered("    A(A&&) noexcept;\n    A& operator=(const A&) = default;"),
                         f"{empty} A(A&&) noexcept;\n{empty} A& operator=(const A&) = default;")
        self.assertEqual(filtered("    friend bool operator==(const A&, const A&) = default;"), "")
        for kept in ("    int f() const;", "    explicit A(int x);", "    /// Said.\n    int x = 0;", "int x = 0;",
                     "    using std::runtime_error::runtime_error;", "    struct Impl;", "    return x;"):
            self.assertEqual(filtered(kept), kept)

    def test_lines_keep_their_numbers(self):
        for header in sorted((k_root / "include" / "gnomon").glob("*.h")):
            source = header.read_text()
            self.assertEqual(filtered(source).count("\n"), source.count("\n"), header.name)

    @unittest.skipUnless(shutil.which("doxygen"), "doxygen is not installed")
    def test_a_function_without_a_comment_is_named_and_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "copy"
            for part in ("include", "docs/api", "examples", "tools"):
                shutil.copytree(k_root / part, copy / part)
            shutil.copy(k_root / "CMakeLists.txt", copy)
            header = copy / "include" / "gnomon" / "version.h"
            begin = "namespace gnomon {\n"
            header.write_text(header.read_text().replace(begin, begin + "int unexplained();\n"))
            result = subprocess.run([copy / "tools" / "api_reference.sh", copy / "made"], capture_output=True,
                                    text=True)
            self.assertNotEqual(result.returncode, 0)
            self.assertIn("unexplained", result.stderr + result.stdout)


if __name__ == "__main__":
    unittest.main()
