#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A short fuzzer run for every target; ./dev fuzz runs longer. Skipped without clang.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v clang++-14 >/dev/null || { echo "SKIPPED: no clang++-14"; exit 77; }
exec ./dev fuzz all "${GNOMON_FUZZ_SECONDS:-20}"
