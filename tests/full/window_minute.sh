#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Uses the viewer's window for a minute: drags, zooms, flights, every option of the panel, scrubbing, an object frozen
# and one moved by the user, another size, a second file by drag and drop. Real input events, on a separate X server.
#
#     window_minute.sh PROGRAM DROP_FILE [FOLDER]
#
# With LEAKS=1, leaks are checked at the end: by the program's own sanitizer if it was built with AddressSanitizer, else
# by gcc's leak sanitizer, which is preloaded. Libraries are then never unloaded, so that memory they keep is not
# reported as lost, and Vulkan's validation, which leaks, is off.
#
# Fails if the program fails, if Vulkan's validation or a sanitizer reports a message, if an option could not be set, or
# if a window frame took more than LONGEST_MS (250; not checked with a sanitizer, for which PACE makes pauses longer).
# Prints the figures; leaves screenshots in FOLDER if one is given. Exits with 77 if Xvfb or xdotool is missing.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$(realpath "$1")
GNOMON_DROP_FILE=$(realpath "$2")
export GNOMON_DROP_FILE GNOMON_SCREEN=1200x1000 GNOMON_VULKAN_VALIDATION=1
command -v Xvfb >/dev/null && command -v xdotool >/dev/null || { echo "skipped: no Xvfb or no xdotool"; exit 77; }
folder=${3:-$(mktemp -d)}
mkdir -p "$folder"
[[ $# -ge 3 ]] || trap 'rm -rf "$folder"' EXIT

# Two scenes, one of them to be dropped, and an environment image.
printf 'v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$folder/second.obj"
"$program" render "$folder/second.obj" -o "$folder/sky.png" --size 64x32 --quiet 2>/dev/null

# The panel's rows in pixels, with the default font and no object picked. The panel is 286 pixels wide, and the view
# stands beside it.
first_row=348 row=23 first_entry=28 entry=17

declare -a steps=()
step() { steps+=("$*"); }
pause() { step "sleep $(awk "BEGIN { print $1 * ${PACE:-1} }")"; }
click() { step "mousemove $1 $2"; step "click ${3:-1}"; pause 0.1; }
drag() { step "mousemove $2 $3"; step "mousedown $1"; for i in 1 2 3 4 5 6; do
    step "mousemove $(($2 + ($4 - $2) * i / 6)) $(($3 + ($5 - $3) * i / 6))"; pause 0.05; done; step "mouseup $1"; }
# A click on a group's header opens it, with its options below; a second click closes it.
group=0
header() { click 150 $((first_row + row * group)); pause 0.2; option=0; }
place() { echo $((first_row + row * (group + 1) + row * option)); }
typed() { click 60 "$(place)"; pause 0.1; step "key End"; step "key shift+Home"; step "key BackSpace"; [[ -z $1 ]] || step "type $1"
    step "key Return"; pause 0.3; option=$((option + 1)); }
chosen() { click 60 "$(place)"; pause 0.4; click 60 $(($(place) + first_entry + entry * $1)); pause 0.4
    option=$((option + 1)); }
flagged() { click 17 "$(place)"; pause 0.3; click 17 "$(place)"; pause 0.3; option=$((option + 1)); }
again() { option=$((option - 1)); }
skip() { option=$((option + 1)); }
close() { click 150 $((first_row + row * group)); group=$((group + 1)); }

pause 2
drag 1 600 500 700 420
drag 3 600 500 520 560
drag 2 600 500 640 480
for _ in 1 2 3; do click 600 500 4; click 600 500 5; done
for k in w a s d e q; do step "keydown $k"; pause 0.25; step "keyup $k"; done
step "key h"; pause 0.3; step "key h"
step "key space"; drag 1 40 60 270 60; pause 0.3; step "key Home"; step "key End"; step "key Left"; step "key Right"
step "key space"

header; chosen 1; pause 2; step "shot raster.png"; again; chosen 0; close                              # output: renderer
header; typed 12; again; typed 24; skip; close                                                        # frames: fps
header; typed 0; typed 8; again; typed ''; typed 1; again; typed ''                                   # camera and lights
typed 'point 0 0.5 0 1 1 1'; again; typed ''; typed "$folder/sky.png"; pause 1; step "shot environment.png"
again; typed ''; typed off; pause 0.5; again; typed ''; skip; close                                   # ground
header; typed 2; again; typed 1; chosen 1; again; chosen 0; typed 180; again; typed ''                # rays: samples
typed 2.8; typed 2; again; typed ''; again; again; typed ''; skip                                     # aperture, focus
typed 1024; again; typed ''; typed 4; chosen 1; pause 1; again; chosen 0; chosen 1; again; chosen 0; close
header; typed 1; again; typed auto; chosen 2; again; chosen 1; typed white; again; typed ''           # look
chosen 1; pause 1; step "shot states.png"; typed 0; again; typed ''; again; again; chosen 0; close
header; chosen 1; again; chosen 0; again; chosen 2; typed 0.5; again; typed ''                        # shadows
chosen 1; again; chosen 2; typed 2; close
header; chosen 1; pause 1; again; chosen 2; pause 1; again; chosen 0; again; chosen 3                 # indirect light
typed 1; again; typed all; typed 8; chosen 2; typed 64; typed 4; typed 0.1; typed 0.8; typed 0.1; flagged; flagged
chosen 1; close

# The ball at its first position: picked, frozen, and moved by the user while the clip plays.
step "key c"; step "key space"; step "key Home"; pause 3
click 601 430; pause 4; click 17 344; pause 0.5; step "key space"; drag 1 50 369 90 369; pause 1; step "shot moved.png"

step "resize 500 400"; pause 1; step "resize 850 950"; pause 1
step "drop second.obj"; pause 2; step "shot second.png"; click 600 600
pause 0.5; step "key f"; drag 1 600 500 660 520; pause 0.5; step "key p"; step "await gnomon-0001.png"
step "key Escape"

# Preload into the program only: otherwise leaks of Xvfb would be checked too.
run=("$program")
if [[ -n ${LEAKS:-} ]]; then
    # No libraries of its own, because a sanitizer's runtime in the program must be loaded first.
    echo 'int dlclose(void* library) { return library == 0; }' | gcc -shared -fPIC -nostdlib -x c -o "$folder/keep.so" -
    preload=$folder/keep.so
    grep -q __asan_init "$program" || preload="$(gcc -print-file-name=liblsan.so) $preload"
    # Without this, a sanitizer that is not active would find no leak either.
    echo '#include <stdlib.h>
        static void* volatile kept;
        int main(void) { for (int i = 0; i < 64; ++i) kept = malloc(100); return 0; }' | gcc -x c -o "$folder/loses" -
    if LD_PRELOAD="$(gcc -print-file-name=liblsan.so) $folder/keep.so" "$folder/loses" 2>/dev/null; then
        echo "the leak sanitizer finds no leak"; exit 1
    fi
    run=(env "LD_PRELOAD=$preload" ASAN_OPTIONS=verify_asan_link_order=0 GNOMON_VULKAN_VALIDATION=0 "$program")
fi

began=$(date +%s.%N)
code=0
printf '%s\n' "${steps[@]}" | "$here/../cli/drive_window.sh" "$folder" "${run[@]}" view builtin:cornell --size 850x950 \
    --json=seen.json >"$folder/out" 2>"$folder/err" || code=$?
ended=$(date +%s.%N)
[[ $code -eq 0 ]] || { echo "exit code $code"; cat "$folder/err"; exit 1; }

python3 - "$folder" "$began" "$ended" "${LONGEST_MS:-250}" "$program" <<'PYTHON'
import json, os, sys
folder, began, ended, longest, program = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4]), sys.argv[5]
seen = json.load(open(folder + "/seen.json"))
err = open(folder + "/err", errors="replace").read()
images, median = seen["pictures"], seen["median_picture_ms"]
print(f"{ended - began:.0f} s of input, {seen['window_frames']} window frames, the longest {seen['longest_frame_ms']:.0f} ms; "
      f"{images} images, median {median:.0f} ms; {seen['loads']} loads; "
      f"options set: {len(seen['options_set'])}")
faults = []
every = {"renderer", "fps", "camera", "turntable", "lights", "light", "environment", "ground", "samples", "filter", "shutter",
         "aperture", "focus", "memory", "max-depth", "accelerator", "isa", "exposure", "tonemap", "background", "overlay",
         "overlay-light", "shadow-culling", "sun-size", "shadow-textures", "shadow-filter", "indirect", "bounces",
         "indirect-memory", "indirect-on", "rsm-samples", "indirect-level", "depth-threshold", "normal-threshold",
         "validity-margin", "separate-trees", "cluster-shadows", "receivers"}
if missing := every - set(seen["options_set"]):
    faults.append("not set: " + ", ".join(sorted(missing)))
if seen["frozen"] != ["ball"] or seen["moved"] != ["ball"]:
    faults.append(f"frozen: {seen['frozen']}, moved: {seen['moved']}, and not the ball")
if seen["loads"] < 2:
    faults.append("the dropped file was not loaded")
if ended - began < 60:
    faults.append("less than a minute of input")
sanitized = b"__asan_init" in open(program, "rb").read() or "LEAKS" in os.environ
if seen["longest_frame_ms"] > longest and not sanitized:
    faults.append(f"a window frame of {seen['longest_frame_ms']:.0f} ms")
if err.strip():
    faults.append("on standard error:\n" + err)
print("\n".join(faults) or "no complaint")
sys.exit(bool(faults))
PYTHON
