#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures how long inputs wait until the viewer's window shows them: a minute of drags, flights, steps, playing and an
# option of the panel, as real input events on a separate X server.
#
#     window_latency.sh PROGRAM SCENE [SECONDS [WAIT]]
#
# SECONDS: of input (60); WAIT: before it, until the scene is loaded (20). Prints the median and the longest latency.
# They are figures of the machine: let nothing else run. Fails if the median is above MEDIAN_MS or the longest above
# LONGEST_MS, where these are set. Exits with 77 if Xvfb or xdotool is missing.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$(realpath "$1")
scene=$2 seconds=${3:-60} wait=${4:-20}
[[ $scene == builtin:* ]] || scene=$(realpath "$scene")
command -v Xvfb >/dev/null && command -v xdotool >/dev/null || { echo "skipped: no Xvfb or no xdotool"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# The panel's rows in pixels. A scene with one frame has a line of text in place of the player's two rows.
frames=$("$program" info "$scene" --json 2>/dev/null | python3 -c 'import json, sys; print(json.load(sys.stdin)["frames"])')
row=23 first_row=$((frames > 1 ? 348 : 319)) look=4

declare -a steps=()
step() { steps+=("$*"); }
pause() { step "sleep $1"; }
drag() { step "mousemove $2 $3"; step "mousedown $1"; for i in $(seq 20); do
    step "mousemove $(($2 + ($4 - $2) * i / 20)) $(($3 + ($5 - $3) * i / 20))"; pause 0.025; done; step "mouseup $1"; }
click() { step "mousemove $1 $2"; step "click ${3:-1}"; pause 0.15; }
exposure() { click 150 $((first_row + row * look)); pause 0.2; click 60 $((first_row + row * (look + 1)))
    step "key End"; step "key shift+Home"; step "key BackSpace"; step "type $1"; step "key Return"; pause 0.4
    click 150 $((first_row + row * look)); step "mousemove 900 500"; }

pause "$wait"
for round in $(seq $(((seconds + 9) / 10))); do   # each takes about ten seconds
    drag 1 700 400 820 330; pause 0.3
    drag 3 700 400 640 430
    step "keydown w"; pause 0.6; step "keyup w"
    step "key space"; pause 0.2
    drag 1 800 400 700 460
    click 800 400 4; click 800 400 5
    step "key Right"; pause 0.3; step "key Right"; pause 0.2
    step "keydown d"; pause 0.4; step "keyup d"
    exposure $((round % 3))
    step "key space"; pause 0.4
    drag 2 700 400 740 420
    step "key c"; pause 0.3
done
step "key Escape"

printf '%s\n' "${steps[@]}" | GNOMON_SCREEN=1600x760 "$here/../cli/drive_window.sh" "$folder" "$program" view "$scene" \
    --json=seen.json >/dev/null 2>"$folder/err" || { echo "exit code $?"; cat "$folder/err"; exit 1; }
python3 - "$folder/seen.json" "${MEDIAN_MS:-inf}" "${LONGEST_MS:-inf}" <<'PYTHON'
import json, sys
seen, median, longest = json.load(open(sys.argv[1])), float(sys.argv[2]), float(sys.argv[3])
images, median_ms = seen["pictures"], seen["median_picture_ms"]
print(f"{seen['inputs']} inputs, shown after {seen['median_latency_ms']:.0f} ms in the median and "
      f"{seen['longest_latency_ms']:.0f} ms at most, by an image rendered for them after "
      f"{seen['median_rendered_latency_ms']:.0f} and {seen['longest_rendered_latency_ms']:.0f} ms; {images} images, median "
      f"{median_ms:.0f} ms; {seen['window_frames']} window frames; options set: "
      f"{', '.join(seen['options_set']) or 'none'}")
sys.exit(seen["inputs"] == 0 or seen["median_latency_ms"] > median or seen["longest_latency_ms"] > longest)
PYTHON
