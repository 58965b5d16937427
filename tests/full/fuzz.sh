#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A short run of the fuzzer for every target; longer ones by hand (./dev fuzz). Skips where clang is not there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v clang++-14 >/dev/null || { echo "SKIPPED: no clang++-14"; exit 77; }
exec ./dev fuzz all "${GNOMON_FUZZ_SECONDS:-20}"
