#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails on an include that points upward or sideways.

    check_layers.py [ROOT]

Reads every #include "..." below ROOT's src, include, examples, bench, viewer, python and cli, and compares folder by
folder with the table below.
Prints one line a fault, `file:line: what`; exit code 1 if there is any. Cost: one read of every source file.
"""
import pathlib
import re
import sys

# Who may include whom, besides itself and the plain types of include/gnomon, which are open to everybody. Folders of
# src/ first, from the lowest layer up; then those beside src/.
k_scene = {"base", "scene"}
k_rays = k_scene | {"ray"}
k_techniques = {"shadow_culling", "area_light", "shadow_textures", "light_quadtree", "irradiance_cache"}
k_frame = k_rays | k_techniques | {"io", "image", "vk", "gpu_scene", "lighting", "visibility", "environment_light", "shading",
                                   "patches", "light_views", "trace", "raster", "reference"}
k_may_include = {
    "base": set(),
    "image": {"base"},
    "scene": {"base"},
    "io": k_scene,
    "ray": k_scene,
    "vk": {"base"},
    "lighting": k_rays,
    "visibility": k_rays,
    "environment_light": k_rays | {"visibility"},
    "shading": k_rays | {"lighting"},
    "patches": k_rays | {"lighting", "visibility", "shading"},
    "gpu_scene": k_scene | {"vk"},
    "ray/vulkan": k_rays | {"vk", "gpu_scene"},
    "light_views": k_rays | {"vk", "gpu_scene"},
    "shadow_culling": k_rays | {"visibility"},
    "area_light": k_rays | {"visibility"},
    "shadow_textures": k_rays | {"vk", "gpu_scene", "light_views"},
    "light_quadtree": k_rays | {"vk", "gpu_scene", "light_views", "lighting", "visibility"},
    "irradiance_cache": k_rays | {"vk", "gpu_scene", "light_views", "lighting", "visibility",
                                  "environment_light", "ray/vulkan", "patches"},
    "reference": k_rays | {"lighting", "visibility", "shading"},
    "trace": k_rays | {"image", "lighting", "visibility", "environment_light", "shading", "shadow_culling", "area_light",
                       "light_quadtree", "irradiance_cache"},
    "raster": k_rays | {"image", "vk", "gpu_scene", "lighting", "visibility", "shading", "light_views", "area_light",
                        "shadow_textures", "light_quadtree", "irradiance_cache"},
    "frame": k_frame,
    "api": k_frame | {"frame"},
    "video": k_frame | {"frame", "api"},
    "options": {"base"},
}
k_inside = k_frame | {"frame", "api", "video", "options"}
k_may_include["bench"] = k_inside
k_may_include["viewer"] = {"base", "io", "options"}
k_may_include["python"] = set()
k_may_include["cli"] = k_inside | {"bench", "viewer"}
k_beside_src = ("bench", "viewer", "python", "cli")

# Sources that must make do with the public interface, the options, base, files that are written whole and their own
# folder: what else they lack is missing from it. The benches look inside.
k_public_only = re.compile(r"viewer/.*|cli/(?!subcommand_bench_).*")
k_public_also = ("options/", "base/", "io/file/")
k_opens_viewer = "cli/subcommand_view.cpp"

k_extensions = {".h", ".cpp", ".inl", ".glsl", ".comp", ".vert", ".frag", ".rgen", ".rmiss", ".rahit"}
k_include = re.compile(r'^\s*#\s*include\s*"([^"]+)"')


def room_of(path: str) -> str:
    """The folder of the table that a path below src/, or beside it, lies in: the longest that is named there."""
    parts = path.split("/")
    deep = "/".join(parts[:2])
    return deep if len(parts) > 2 and deep in k_may_include else parts[0]


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
        # A header without a folder is the examples' own.
        return f'"{included}": an example uses include/gnomon alone' if has_folder else None
    if not has_folder:
        return f'"{included}" lacks its folder: write "folder/{included}"'
    own = room_of(file.as_posix() if file.parts[0] in k_beside_src else "/".join(file.parts[1:]))
    if own not in k_may_include:
        return f"src/{own} is not a folder of the table in tools/check_layers.py"
    target = room_of(included)
    if target == own:
        return None
    if k_public_only.fullmatch(str(file)):
        if included.startswith(k_public_also) or (target == "viewer" and str(file) == k_opens_viewer):
            return None
        return f'"{included}": this file uses include/gnomon, src/options, src/base and src/io/file alone'
    if target not in k_may_include:
        return f'"{included}": no such folder in the table in tools/check_layers.py'
    if target in k_may_include[own]:
        return None
    return f'"{included}": {own} must not know {target}'


def faults(root: pathlib.Path) -> tuple[list[str], int]:
    found, read = [], 0
    for top in ("src", "include", "examples", *k_beside_src):
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
