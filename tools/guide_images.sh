#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders the images of README.md, docs/guide and docs/papers.
#
#     tools/guide_images.sh [PROGRAM [FOLDER]]
#
# The defaults are build/release/gnomon and docs/images. tour-redrawn.png needs Vulkan. viewer.png needs Xvfb, xdotool
# and an otherwise idle machine, because it shows frame times.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${1:-$here/build/release/gnomon}
out=${2:-$here/docs/images}
"$program" render builtin:kinetic --size 960x540 --samples 16 -o "$out/kinetic.png" --quiet
box=(builtin:cornell --frame 20 --size 320x320)
"$program" render "${box[@]}" --samples 4 --indirect off -o "$out/tour-direct.png" --quiet
"$program" render "${box[@]}" --samples 4 -o "$out/tour-visible.png" --quiet
"$program" render "${box[@]}" --indirect quadtree --overlay clusters -o "$out/tour-clusters.png" --quiet
"$program" render builtin:kinetic --frame 60 --size 480x270 --renderer raster --overlay redrawn --warm-up 4 \
    -o "$out/tour-redrawn.png" --quiet
states=(builtin:kinetic --frame 60 --size 640x360 --overlay shadow-states --overlay-light 0 --quiet)
"$program" render "${states[@]}" -o "$out/shadow-states.png"
"$program" render "${states[@]}" --shadow-culling paper -o "$out/shadow-states-paper.png"
# Play the clip first, so that the counters are those of frames with filled caches, and pick the ball. The window is 286
# pixels wider than the view.
printf '%s\n' 'sleep 3' 'key space' 'sleep 6' 'key space' 'key Home' 'sleep 3' 'mousemove 553 300' 'click 1' 'sleep 3' \
    'mousemove 960 600' 'sleep 1' 'shot viewer.png' 'key Escape' |
    GNOMON_SCREEN=1024x640 "$here/tests/cli/drive_window.sh" "$out" "$(realpath "$program")" view builtin:cornell \
        --size 738x640
