#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders every available scene with `gnomon render FILE -o image.png` and no other option, for visual inspection.
#
#     tools/contact_sheet.sh DIR [PROGRAM]
#
# Writes one DIR/*.png per scene, named after it, and DIR/sheet.png with all of them in the order of DIR/sheet.txt. The
# scenes are the built-in ones and those in GNOMON_SCENES (default ../shared/scenes) except broken files; some are parts
# of scenes without light and camera. Needs ffmpeg. Exits with 1 if a scene could not be rendered.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
[[ $# -ge 1 ]] || { sed -n '3,9s/^# \{0,1\}//p' "$0"; exit 2; }
out=$1
program=${2:-$here/build/release/gnomon}
scenes=${GNOMON_SCENES:-$here/../shared/scenes}
mkdir -p "$out"

list=(builtin:kinetic builtin:cornell 'builtin:spheres?objects=300&dynamic=10')
for file in bart/kitchen/aff/kitchen.aff bart/robots/aff/Robot.aff sponza/sponza.obj stanford/*.obj cornell/*/*.gltf \
    cornell/*/*.obj cornell/mitsuba/meshes/cbox_{large,small}box.obj gltf/*.glb \
    bart/kitchen/aff/{car,china,dragon,fridge_box,table}.aff bart/robots/aff/Robot1.aff \
    hostile/obj/{cube,cornell_box,catmark_torus_creases0,smoothing-normal,issue-138}.obj; do
    for found in "$scenes"/$file; do [[ -f $found ]] && list+=("$found"); done
done

failed=0
inputs=()
: >"$out/sheet.txt"
for scene in "${list[@]}"; do
    name=${scene#"$scenes"/}
    name=${name#builtin:}
    name=${name%%\?*}
    name=${name%.*}
    name=${name//\//-}
    if "$program" render "$scene" -o "$out/$name.png" --quiet; then
        echo "$name" >>"$out/sheet.txt"
        inputs+=(-i "$out/$name.png")
    else
        echo "$scene could not be rendered" >&2
        failed=1
    fi
done

# Arrange the images in rows of four, each 480 x 270 with a dark border.
count=$((${#inputs[@]} / 2)) filter='' layout=''
[[ $count -gt 1 ]] || exit 1
for ((i = 0; i < count; ++i)); do
    filter+="[$i]scale=472:262:force_original_aspect_ratio=decrease:flags=area,pad=480:270:-1:-1:color=0x181818[v$i];"
    layout+="$((i % 4 * 480))_$((i / 4 * 270))|"
done
for ((i = 0; i < count; ++i)); do filter+="[v$i]"; done
ffmpeg -loglevel error -y "${inputs[@]}" -filter_complex \
    "${filter}xstack=inputs=$count:layout=${layout%|}:fill=0x181818" -frames:v 1 -update 1 "$out/sheet.png"
echo "$out/sheet.png: $count images, in the order of $out/sheet.txt"
exit "$failed"
