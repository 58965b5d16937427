#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the pictures of docs/guide/README.md.
#
#     tools/guide_pictures.sh [PROGRAM [FOLDER]]
#
# PROGRAM: build/release/gnomon; FOLDER: docs/pictures. The one of what was redrawn needs Vulkan.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${1:-$here/build/release/gnomon}
out=${2:-$here/docs/pictures}
box=(builtin:cornell --frame 20 --size 320x320)
"$program" render "${box[@]}" --samples 4 --indirect off -o "$out/tour-direct.png" --quiet
"$program" render "${box[@]}" --samples 4 -o "$out/tour-visible.png" --quiet
"$program" render "${box[@]}" --indirect quadtree --overlay clusters -o "$out/tour-clusters.png" --quiet
"$program" render builtin:kinetic --frame 60 --size 480x270 --renderer raster --overlay redrawn --warm-up 4 \
    -o "$out/tour-redrawn.png" --quiet
