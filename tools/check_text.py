#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that need no compiler, on every file of the repository.

    check_text.py [--root ROOT] [CHECK...]        all checks, or those named

    paths       no path of one machine
    spdx        every source begins with its licence line
    ascii       sources are plain ASCII
    length      no source above 600 lines that does not say why (a line with LONG: among its first 30)
    functions   no C++ or GLSL function above 100 lines that does not say why (LONG: among its first 5, or right above)
    references  every file of the repository that a document or a comment names exists
    subranges   no algorithm that returns a subrange, which clang 14 cannot compile with libstdc++ 12: the sanitizers' builds
    newline     no trailing blanks, no tabs, no carriage returns, one newline at the end

Prints one line a fault, `file:line: what`; exit code 1 if there is any.
"""
import argparse
import glob
import os
import pathlib
import re
import subprocess
import sys

k_line_limit = 600
k_reason_within = 30   # lines from the top in which a long file says why
k_function_limit = 100
k_sources = {".h", ".cpp", ".inl", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh", ".cmake"}
k_source_names = {"CMakeLists.txt", "dev", "run"}
k_braced = {".h", ".cpp", ".inl", ".glsl", ".comp", ".vert", ".frag", ".rgen", ".rmiss", ".rahit"}
k_not_ours = {"build", "out", ".git", ".cache", "__pycache__"}
k_machine_path = re.compile(r"(?<![\w.$}])/(?:work|home/\w+)/|/tmp/bash_\w")
# A file of ours as prose names it: from the root, from src/, include/ or tests/, or beside the file that names it.
k_reference = re.compile(r"(?<![\w./$}<>:~-])((?:[\w.*-]+/)+[\w.*-]+\.(?:h|cpp|inl|glsl|comp|vert|frag|rgen|rmiss|rahit|md|py|sh"
                         r"|cmake|js|css)|(?:src|tests|tools|docs|bench|cli|viewer|cmake|include|examples|microbench)"
                         r"(?:/[\w.*-]+)+/?)(?![\w/{])")
k_comment = re.compile(r"(?://|#|/\*)(?!include\b|\s*include\b)(.*)")
# Named, but not of the repository: what the build makes, other people's headers, examples of names.
k_elsewhere = re.compile(r"^(?:build|shared|installed|gl|GL|vulkan|glm|nlohmann|X11|sys|OpenEXR|embree3?|hwy|imgui|tbb)/"
                         r"|/(?:NAME|FILE|FOLDER|ROOM)|^(?:NAME|DIR|OUT|WHERE|ROOM|PATH|HERE|A|B)/|\.inc$")
k_subrange = re.compile(r"ranges::(unique|remove|remove_if|equal_range|partition|stable_partition|rotate|search|find_end)\(")
k_spdx = "SPDX-License-Identifier: Apache-2.0"


def repository_files(root: pathlib.Path) -> list[pathlib.Path]:
    """Tracked and new files, without ignored ones; without git, everything but the folders of builds."""
    try:
        listing = subprocess.run(["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                                 capture_output=True, check=True).stdout
        return sorted({root / os.fsdecode(name) for name in listing.split(b"\0") if name})
    except (OSError, subprocess.CalledProcessError):
        files = []
        for folder, folders, names in os.walk(root):
            folders[:] = [name for name in folders if name not in k_not_ours]
            files += [pathlib.Path(folder) / name for name in names]
        return sorted(files)


def is_source(path: pathlib.Path) -> bool:
    return path.suffix in k_sources or path.name in k_source_names


def check_paths(path, lines):
    for number, line in enumerate(lines, 1):
        if match := k_machine_path.search(line):
            yield number, f"'{match[0]}' is a path of one machine"


def check_spdx(path, lines):
    if is_source(path) and not any(k_spdx in line for line in lines[:2]):
        yield 1, f"must begin with '{k_spdx}'"


def check_ascii(path, lines):
    if is_source(path):
        for number, line in enumerate(lines, 1):
            if not line.isascii():
                yield number, f"not ASCII: {next(c for c in line if not c.isascii())!a}"


def check_length(path, lines):
    if is_source(path) and len(lines) > k_line_limit and not any("LONG:" in line for line in lines[:k_reason_within]):
        yield 1, f"{len(lines)} lines: split it, or say why near the top (LONG: ...)"


def check_functions(path, lines):
    """By braces alone: formatted code has a function's braces on lines of their own, below each other."""
    if path.suffix not in k_braced:
        return
    open_at: dict[int, int] = {}   # by indentation
    for number, line in enumerate(lines, 1):
        blanks = len(line) - len(line.lstrip(" "))
        if line.strip() == "{":
            open_at[blanks] = number
        elif line.startswith(" " * blanks + "}") and blanks in open_at:
            start = open_at.pop(blanks)
            length = number - start + 1
            if length > k_function_limit and not any("LONG:" in near for near in lines[max(0, start - 6):start + 5]):
                yield start, f"a function of {length} lines: split it, or say why at its beginning (LONG: ...)"


def names_a_file(root: pathlib.Path, path: pathlib.Path, name: str) -> bool:
    name = name.rstrip("/.")
    places = (root, root / "src", root / "include", root / "tests", root / "docs", path.parent, path.parent.parent)
    return any(glob.glob(glob.escape(str(place)) + "/" + name) for place in places)


def check_references(path, lines, root):
    if (path.suffix != ".md" and not is_source(path)) or path.name == "CHANGELOG.md":   # history keeps old names
        return
    for number, line in enumerate(lines, 1):
        text = line
        if path.suffix != ".md":
            comment = k_comment.search(line)
            text = comment[1] if comment else ""
        for match in k_reference.finditer(text):
            if not k_elsewhere.search(match[1]) and not names_a_file(root, path, match[1]):
                yield number, f"'{match[1]}': no such file"


def check_subranges(path, lines):
    if path.suffix in {".h", ".cpp", ".inl"}:
        for number, line in enumerate(lines, 1):
            if found := k_subrange.search(line):
                yield number, f"std::ranges::{found[1]} returns a subrange: use std::{found[1]} or bounds"


def check_newline(path, lines):
    if not is_source(path):
        return
    for number, line in enumerate(lines, 1):
        if line != line.rstrip() or "\t" in line:
            yield number, "tab, carriage return or trailing blank"
    if lines and not lines[-1]:
        yield len(lines), "blank line at the end"


k_checks = {"paths": check_paths, "spdx": check_spdx, "ascii": check_ascii, "length": check_length,
            "functions": check_functions, "references": check_references,
            "subranges": check_subranges, "newline": check_newline}


def main() -> int:
    parser = argparse.ArgumentParser(description="checks text files")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    parser.add_argument("checks", nargs="*", metavar="CHECK", help=f"of {', '.join(k_checks)}")
    arguments = parser.parse_args()
    if unknown := set(arguments.checks) - set(k_checks):
        parser.error(f"no such check: {', '.join(sorted(unknown))}")

    found, read = [], 0
    for path in repository_files(arguments.root):
        if path.is_symlink() or not path.is_file():
            continue
        data = path.read_bytes()
        if b"\0" in data:
            continue   # an image or the like
        read += 1
        lines = data.decode("utf-8", "replace").removesuffix("\n").split("\n")
        for name in arguments.checks or k_checks:
            more = (arguments.root,) if name == "references" else ()
            for number, what in k_checks[name](path, lines, *more):
                found.append(f"{path.relative_to(arguments.root)}:{number}: {what}")
    print("\n".join(found) if found else f"text: {read} files, no fault")
    if read == 0:
        print(f"text: no file below {arguments.root}", file=sys.stderr)
    return 1 if found or read == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
