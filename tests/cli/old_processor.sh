#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# On a processor without SSE4.2 the program ends with one line and exit code 4, before any instruction that it lacks.
# An emulated processor, which refuses the instructions that it does not have; skips (exit code 77) without qemu-user.
#   old_processor.sh PROGRAM
set -euo pipefail
program=$1
command -v qemu-x86_64 >/dev/null || { echo "skipped: no qemu-x86_64: install the Debian package qemu-user"; exit 77; }
[[ $(uname -m) == x86_64 ]] || { echo "skipped: the test is for x86-64"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "FAILED: $*"; exit 1; }

# run PROCESSOR COMMAND...: sets `code`, `out`, `err`.
run() {
    local processor=$1
    shift
    code=0
    timeout 300 qemu-x86_64 -cpu "$processor" "$@" >"$work/out" 2>"$work/err" || code=$?
    out=$(<"$work/out") err=$(<"$work/err")
}

# Check that the emulation refuses an instruction of SSE4.2: else this test could not fail.
if command -v "${CXX:-g++}" >/dev/null; then
    printf '%s\n' '#include <nmmintrin.h>' 'int main(int n, char**) { return static_cast<int>(_mm_crc32_u32(n, 7)) & 1; }' \
        >"$work/crc.cpp"
    "${CXX:-g++}" -O1 -msse4.2 "$work/crc.cpp" -o "$work/crc"
    run core2duo "$work/crc"
    [[ $code -eq 132 ]] || fail "the emulated processor executed SSE4.2 (exit code $code)"   # 128 + SIGILL
    run Nehalem "$work/crc"
    [[ $code -le 1 ]] || fail "the emulated processor with SSE4.2 refused it (exit code $code)"
fi

# Processors without SSE4.2: of 2006, of 2008 (with SSE4.1), and a minimal one.
for processor in core2duo Penryn qemu64; do
    for arguments in "--version" "render builtin:cornell -o $work/never.png"; do
        run "$processor" "$program" $arguments
        [[ $code -eq 4 ]] || fail "$processor, $arguments: exit code $code, expected 4: $err"
        [[ -z $out ]] || fail "$processor, $arguments: wrote to standard output: $out"
        [[ $(wc -l <"$work/err") -eq 1 && $err == "gnomon: this processor lacks SSE4.2"* ]] ||
            fail "$processor, $arguments: unexpected message: $err"
        [[ ! -e $work/never.png ]] || fail "$processor: an image was written"
    done
done

# The oldest processor with SSE4.2 runs the program.
run Nehalem "$program" --version
[[ $code -eq 0 && $out == gnomon* ]] || fail "Nehalem: exit code $code: $out $err"
echo "passed"
