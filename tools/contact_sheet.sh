#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders every available scene with `gnomon render FILE -o image.png` and no other option, for visual inspection.
#
#     tools/contact_sheet.sh DIR [PROGRAM [RENDER-OPTION...]]
#
# Writes one DIR/*.png per scene, named after it, and sheets of 48 of them, DIR/sheet.png, DIR/sheet-2.png, ..., in the
# order of DIR/sheet.txt. The scenes are the built-in ones and those in GNOMON_SCENES (default ../shared/scenes) except
# broken files; some are parts of scenes without light and camera. Options are passed on, such as --size 256x256. A file
# that the program refuses (exit code 3) is named, and left out. Needs ffmpeg. Exits with 1 if another one could not be
# rendered.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
[[ $# -ge 1 ]] || { sed -n '3,12s/^# \{0,1\}//p' "$0"; exit 2; }
out=$1
program=${2:-$here/build/release/gnomon}
options=("${@:3}")
scenes=${GNOMON_SCENES:-$here/../shared/scenes}
mkdir -p "$out"

list=(builtin:kinetic builtin:cornell 'builtin:spheres?objects=300&dynamic=10')
for file in bart/kitchen/aff/kitchen.aff bart/robots/aff/Robot.aff sponza/sponza.obj stanford/*.obj cornell/*/*.gltf \
    cornell/*/*.obj cornell/mitsuba/meshes/cbox_{large,small}box.obj gltf/*.glb \
    bart/kitchen/aff/{car,china,dragon,fridge_box,table}.aff bart/robots/aff/Robot1.aff \
    hostile/obj/{cube,cornell_box,catmark_torus_creases0,smoothing-normal,issue-138}.obj real/*/*.{gltf,glb}; do
    for found in "$scenes"/$file; do [[ -f $found ]] && list+=("$found"); done
done

failed=0
images=()
: >"$out/sheet.txt"
for scene in "${list[@]}"; do
    name=${scene#"$scenes"/}
    name=${name#builtin:}
    name=${name%%\?*}
    name=${name%.*}
    name=${name//\//-}
    rc=0
    "$program" render "$scene" -o "$out/$name.png" --quiet "${options[@]}" || rc=$?
    if [[ $rc -eq 0 ]]; then
        echo "$name" >>"$out/sheet.txt"
        images+=("$out/$name.png")
    else
        echo "$scene could not be rendered" >&2
        [[ $rc -eq 3 ]] || failed=1
    fi
done

# Arrange the images in rows of four, each 480 x 270 with a dark border.
[[ ${#images[@]} -gt 1 ]] || exit 1
per_sheet=48
for ((begin = 0, number = 1; begin < ${#images[@]}; begin += per_sheet, ++number)); do
    of_sheet=("${images[@]:begin:per_sheet}")
    count=${#of_sheet[@]} inputs=() filter='' layout=''
    sheet=$out/sheet.png
    [[ $number -eq 1 ]] || sheet=$out/sheet-$number.png
    for ((i = 0; i < count; ++i)); do
        inputs+=(-i "${of_sheet[i]}")
        filter+="[$i]scale=472:262:force_original_aspect_ratio=decrease:flags=area,"
        filter+="pad=480:270:-1:-1:color=0x181818[v$i];"
        layout+="$((i % 4 * 480))_$((i / 4 * 270))|"
    done
    for ((i = 0; i < count; ++i)); do filter+="[v$i]"; done
    if [[ $count -gt 1 ]]; then filter+="xstack=inputs=$count:layout=${layout%|}:fill=0x181818"; else filter+="copy"; fi
    ffmpeg -loglevel error -y "${inputs[@]}" -filter_complex "$filter" -frames:v 1 -update 1 "$sheet"
    echo "$sheet: $count images, from number $((begin + 1)) of $out/sheet.txt on"
done
exit "$failed"
