# SPDX-License-Identifier: Apache-2.0
"""Every structure of a *_shared.h has a GNOMON_MEMBERS list that names its members, in order."""
import pathlib
import re
import unittest

k_root = pathlib.Path(__file__).resolve().parents[2]


def structures(text: str) -> dict[str, list[str]]:
    """The members of every structure, by its name."""
    found = {}
    for match in re.finditer(r"^struct (\w+)\s*\{(.*?)^\};", re.sub(r"//.*", "", text), re.DOTALL | re.MULTILINE):
        members = []
        for declaration in filter(None, (part.strip() for part in match[2].split(";"))):
            names = declaration.split(None, 1)[1].split(",")
            members += [re.sub(r"\[.*?\]", "", name).strip() for name in names]
        found[match[1]] = members
    return found


def lists(text: str) -> dict[str, list[str]]:
    return {names[0]: names[1:] for names in (re.split(r",\s*", " ".join(match.split()))
            for match in re.findall(r"^GNOMON_MEMBERS\((.*?)\)", text, re.DOTALL | re.MULTILINE))}


class SharedLists(unittest.TestCase):
    def test_every_shared_structure_lists_its_members(self):
        count = 0
        for path in sorted((k_root / "src").rglob("*_shared.h")):
            text = path.read_text()
            self.assertEqual(text.count("struct "), len(structures(text)), f"{path}: a structure that is not read here")
            self.assertEqual(lists(text), structures(text), path)
            count += len(structures(text))
        self.assertGreater(count, 30)

    def test_reads_structures_and_lists(self):
        text = "struct A {\n    uint a, b[2];   // of c;\n    vec3 d;\n};\nGNOMON_MEMBERS(A, a,\n               b, d)\n"
        self.assertEqual(structures(text), {"A": ["a", "b", "d"]})
        self.assertEqual(lists(text), structures(text))
        self.assertNotEqual(lists(text.replace(", d)", ")")), structures(text))


if __name__ == "__main__":
    unittest.main()
