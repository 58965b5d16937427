#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a program in a window on an X server of its own, with the folder given as the current one, and sends it real
# input events.
#
#     drive_window.sh FOLDER PROGRAM [ARGUMENT...] < STEPS
#
# Steps, a line each: xdotool commands (key p, mousemove 10 20, click 1, ...), "sleep S", "await FILE" (at most two
# minutes), "shot FILE" (of the whole screen), "resize W H", "drop FILE" (by drag and drop; GNOMON_DROP_FILE names the
# program that does it). GNOMON_SCREEN: its size (800x600). Exits with the program's code; 99: no window came; 98: a file
# did not; 96: the window did not take what was dropped; 95: no X server came.
set -u
screen=${GNOMON_SCREEN:-800x600}
cd "$1" || exit 97
shift
exec 3<&0
display_file=$(mktemp)
# A number of its own: one that another server has just given up may still be taken away with that one's socket.
# -noreset: xdotool, asking for a window before the program has connected, is the last client when it leaves, and a
# server that resets then throws out who is just connecting.
Xvfb :$((100 + $$ % 50000)) -displayfd 4 -screen 0 ${screen}x24 -nolisten tcp -noreset \
    4>"$display_file" >/dev/null 2>&1 3<&- &
server=$!
trap 'kill $server 2>/dev/null; rm -f "$display_file"' EXIT
for _ in $(seq 300); do [[ -s $display_file ]] && break; sleep 0.1; done
[[ -s $display_file ]] || { echo "drive_window.sh: no X server came" >&2; exit 95; }
DISPLAY=":$(cat "$display_file")"
export DISPLAY
"$@" 3<&- &
program=$!
window=
for _ in $(seq 300); do
    window=$(xdotool search --name '^Gnomon' 2>/dev/null | head -n 1)
    [[ -n $window ]] && break
    kill -0 $program 2>/dev/null || { wait $program; exit $?; }
    sleep 0.1
done
[[ -n $window ]] || { kill -9 $program; exit 99; }
xdotool windowfocus "$window" 2>/dev/null
while read -r subcommand rest <&3; do
    case $subcommand in
        sleep) sleep "$rest" ;;
        await)
            for _ in $(seq 1200); do [[ -e $rest ]] && break; sleep 0.1; done
            [[ -e $rest ]] || { kill -9 $program; exit 98; } ;;
        shot) ffmpeg -loglevel error -f x11grab -video_size $screen -i "$DISPLAY" -frames:v 1 -y "$rest" </dev/null ;;
        type) xdotool type --delay 30 -- "$rest" ;;
        drop) "$GNOMON_DROP_FILE" "$window" "$(realpath "$rest")" || { kill -9 $program; exit 96; } ;;
        resize) xdotool windowsize "$window" $rest ;;
        *) xdotool "$subcommand" $rest ;;
    esac
done
for _ in $(seq 600); do kill -0 $program 2>/dev/null || break; sleep 0.1; done
kill -9 $program 2>/dev/null
wait $program
