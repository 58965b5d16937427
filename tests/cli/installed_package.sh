#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the build, builds the examples against the installed copy only, and runs them.
#
#     installed_package.sh SOURCE BUILD
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# What is installed must be built first; a build of the tests alone leaves it out.
cmake --build "$build" --target gnomon gnomon_shared documents >/dev/null
cmake --install "$build" --prefix "$scratch/installed" >/dev/null
cp -r "$source/examples" "$scratch/examples"
cmake -G Ninja -S "$scratch/examples" -B "$scratch/build" -DCMAKE_PREFIX_PATH="$scratch/installed" \
    -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$scratch/build" >/dev/null
cd "$scratch"
build/example_render_one_frame builtin:cornell 1 frame.png
[[ $(head -c 4 frame.png | tail -c 3) == PNG ]]
build/example_reused_lighting builtin:cornell 3
installed/bin/gnomon render builtin:cornell --size 512x512 -o program.png --quiet
cmp frame.png program.png   # the library and the program make the same bytes
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
