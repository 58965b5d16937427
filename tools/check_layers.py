#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails on an include that points upward or sideways.

    check_layers.py [ROOT]

Reads every #include "..." below ROOT's src, include and examples, and compares folder by folder with the table below.
Prints one line a fault, `file:line: what`; exit code 1 if there is any. Cost: one read of every source file.
"""
import pathlib
import re
import sys

# Who may include whom, besides itself and the plain types of include/gnomon, which are open to everybody.
k_may_include = {
    "base": set(),
    "scene": {"base"},
    "io": {"base", "scene"},
    "ray": {"base", "scene"},
    "vk": {"base"},
    "gpu_scene": {"base", "scene", "vk"},
    "light_views": {"base", "scene", "ray", "vk", "gpu_scene"},
    "shadow_culling": {"base", "scene", "ray"},
    "shadow_textures": {"base", "scene", "vk", "gpu_scene", "light_views"},
    "light_quadtree": {"base", "scene", "ray", "vk", "gpu_scene", "light_views"},
    "render": {"base", "scene", "io", "ray", "vk", "gpu_scene", "light_views",
               "shadow_culling", "shadow_textures", "light_quadtree"},
}
k_may_include["app"] = k_may_include["render"] | {"render"}

# Sources that must make do with the public interface and their own folder: what they lack is missing from it.
k_public_only = re.compile(r"src/app/verb_(render|info)[^/]*\.(cpp|h)")

k_extensions = {".h", ".cpp", ".inl", ".glsl", ".comp", ".vert", ".frag", ".rgen", ".rmiss", ".rahit"}
k_include = re.compile(r'^\s*#\s*include\s*"([^"]+)"')


def fault(file: pathlib.PurePosixPath, included: str) -> str | None:
    """What is wrong with `file` (relative to the root) including `included`, or None."""
    target, has_folder, _ = included.partition("/")
    if ".." in included.split("/"):
        return f'"{included}" walks up the tree: name it from src/ or include/'
    if target == "gnomon":
        return None
    if file.parts[0] == "include":
        return f'"{included}": the public headers include each other alone'
    if file.parts[0] == "examples":
        return f'"{included}": an example uses include/gnomon alone'
    if not has_folder:
        return f'"{included}" lacks its folder: write "folder/{included}"'
    own = file.parts[1]
    if own not in k_may_include:
        return f"src/{own} is not a folder of the table in tools/check_layers.py"
    if target == own:
        return None
    if k_public_only.fullmatch(str(file)):
        return f'"{included}": this verb uses include/gnomon alone'
    if target not in k_may_include:
        return f'"{included}": no such folder in the table in tools/check_layers.py'
    if target in k_may_include[own]:
        return None
    return f'"{included}": {own} must not know {target}'


def faults(root: pathlib.Path) -> tuple[list[str], int]:
    found, read = [], 0
    for top in ("src", "include", "examples"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix not in k_extensions:
                continue
            read += 1
            file = pathlib.PurePosixPath(path.relative_to(root).as_posix())
            for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), 1):
                match = k_include.match(line)
                if match and (what := fault(file, match[1])):
                    found.append(f"{file}:{number}: {what}")
    return found, read


def main() -> int:
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    found, read = faults(root)
    print("\n".join(found) if found else f"layers: {read} files, no fault")
    if read == 0:
        print(f"layers: no source below {root}", file=sys.stderr)
    return 1 if found or read == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
