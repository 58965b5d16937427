#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the build, builds the examples against the installed copy only, by CMake and by pkg-config, and runs them.
#
#     installed_package.sh SOURCE BUILD
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# What is installed must be built first; a build of the tests alone leaves it out.
cmake --build "$build" --target gnomon gnomon_shared documents python >/dev/null
cmake --install "$build" --prefix "$scratch/installed" >/dev/null
cp -r "$source/examples" "$scratch/examples"
cmake -G Ninja -S "$scratch/examples" -B "$scratch/build" -DCMAKE_PREFIX_PATH="$scratch/installed" \
    -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$scratch/build" >/dev/null
cd "$scratch"
build/example_render_one_frame builtin:cornell 1 frame.png
[[ $(head -c 4 frame.png | tail -c 3) == PNG ]]
build/example_reused_lighting builtin:cornell 3
installed/bin/gnomon render builtin:cornell --size 512x512 --samples 1 -o program.png --quiet
cmp frame.png program.png   # the library and the program make the same bytes

differ() { if cmp -s "$1" "$2"; then echo "$1 and $2 are the same"; return 1; fi; }
# A host's own scene: no value is handed over for the first frame, and a hundred for the second.
build/example_host_driven 3 160 balls >balls.txt
differ balls-0001.png balls-0002.png
differ balls-0002.png balls-0003.png
awk 'NR == 2 && $2 == 0 { first = 1 } NR == 3 && $2 == 100 { second = 1 } END { exit !(first && second && NR == 4) }' \
    balls.txt || { cat balls.txt; exit 1; }
# Depth and ids: in the second frame, the camera is 3 m in front of the centre of a ball with a radius of 0.3 m.
build/example_robot_camera 2 160 >robot.txt
[[ -s robot-1.exr && -s robot-2.exr ]]
awk '$1 == "frame" { frame = $2 } frame == 2 && $1 == "ball" && $3 > 2.6 && $3 < 2.8 { found = 1 }
    END { exit !found }' robot.txt ||
    { cat robot.txt; exit 1; }
# An edited scene: six boxes more than before, and another image.
build/example_edit_scene builtin:cornell 160 >edited.txt
differ before.png after.png
awk '{ objects[NR] = $2 } END { exit objects[2] - objects[1] != 6 }' edited.txt || { cat edited.txt; exit 1; }

# The same by pkg-config: the copy is moved first, because its paths are relative.
if command -v pkg-config >/dev/null; then
    mv installed moved
    export PKG_CONFIG_LIBDIR=$scratch/moved/lib/pkgconfig   # instead of the system's folders
    [[ $(pkg-config --modversion gnomon) == "$(moved/bin/gnomon --version | grep -o '[0-9][0-9.]*' | head -n 1)" ]]
    read -r -a extra <<<"${CXXFLAGS:-}"
    read -r -a flags <<<"$(pkg-config --cflags --libs gnomon)"
    "${CXX:-g++}" -std=c++20 "${extra[@]}" examples/render_one_frame.cpp "${flags[@]}" -Wl,-rpath,"$scratch/moved/lib" \
        -o by_pkg_config
    ./by_pkg_config builtin:cornell 1 by_pkg_config.png
    cmp frame.png by_pkg_config.png
    mv moved installed
else
    echo "pkg-config is not installed: its part is skipped"
fi
# The Python package finds its library by a relative path, too.
site=$(cd installed && echo lib/python3*/*-packages)
if [[ -d installed/$site ]]; then
    mv installed moved
    python=$(sed -n 's/^_\?Python_EXECUTABLE:[A-Z]*=//p' "$build/CMakeCache.txt" | head -n 1)
    PYTHONPATH=moved/$site PYTHONDONTWRITEBYTECODE=1 "$python" - <<'PYTHON'
import gnomon
assert gnomon.__file__.startswith(__import__("os").getcwd() + "/moved/"), gnomon.__file__
with gnomon.Renderer(size=(512, 512)) as renderer:
    renderer.render(gnomon.load("builtin:cornell")).write("by_python.png")
PYTHON
    cmp frame.png by_python.png
    mv moved installed
else
    echo "the Python package was not built: its part is skipped"
fi
bash -n installed/share/bash-completion/completions/gnomon
# The completion offers the program's options.
. installed/share/bash-completion/completions/gnomon
completed() {
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
    _gnomon
    printf '%s\n' "${COMPREPLY[@]}"
}
completed gnomon ren | grep -qx render
completed gnomon bench cul | grep -qx culling
completed gnomon render --shadow-cu | grep -qx -- --shadow-culling
completed gnomon render --tonemap ag | grep -qx agx
grep -q '^.TH GNOMON 1' installed/share/man/man1/gnomon.1
if command -v man >/dev/null; then
    # groff reports what it cannot read.
    complaints=$(man --warnings -l installed/share/man/man1/gnomon.1 2>&1 >/dev/null)
    [[ -z $complaints ]] || { echo "$complaints"; exit 1; }
fi
