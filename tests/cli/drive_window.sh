#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a program in a window on a separate X server, in the given folder, and sends it real input events.
#
#     drive_window.sh FOLDER PROGRAM [ARGUMENT...] < STEPS
#
# Steps, one per line: xdotool commands (key p, mousemove 10 20, click 1, ...), "sleep S", "await FILE" (at most two
# minutes), "shot FILE" (a screenshot of the whole screen), "resize W H", "drop FILE" (by drag and drop, with the
# program GNOMON_DROP_FILE). GNOMON_SCREEN: the screen's size (800x600). Exits with the program's code, or with 99: no
# window appeared; 98: a file did not appear; 96: the window did not accept the dropped file; 95: the X server did not
# start.
set -u
screen=${GNOMON_SCREEN:-800x600}
cd "$1" || exit 97
shift
exec 3<&0
display_file=$(mktemp)
# Use an unused display number: the socket of a number that another server has just released may still be removed.
# -noreset: xdotool, which looks for a window before the program has connected, may be the last client to leave, and a
# server that resets then disconnects a client that is just connecting.
Xvfb :$((100 + $$ % 50000)) -displayfd 4 -screen 0 ${screen}x24 -nolisten tcp -noreset \
    4>"$display_file" >/dev/null 2>&1 3<&- &
server=$!
trap 'kill $server 2>/dev/null; rm -f "$display_file"' EXIT
for _ in $(seq 300); do [[ -s $display_file ]] && break; sleep 0.1; done
[[ -s $display_file ]] || { echo "drive_window.sh: the X server did not start" >&2; exit 95; }
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
