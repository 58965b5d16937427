#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the API reference of include/gnomon with Doxygen. Fails if Doxygen has a warning, such as a public function
# without a comment.
#
#     api_reference.sh [OUTPUT]     writes OUTPUT/html/index.html (default: build/docs)
#
# Exit code 77 if Doxygen is not installed.
set -euo pipefail
output=$(realpath -m "${1:-build/docs}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v doxygen >/dev/null || { echo "api_reference: doxygen is not installed"; exit 77; }
version=$(sed -n 's/^project(gnomon VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
rm -rf "$output/html"
mkdir -p "$output"
# Add the settings that depend on the build.
{
    cat docs/api/Doxyfile
    printf 'PROJECT_NUMBER = "%s"\nOUTPUT_DIRECTORY = "%s"\n' "$version" "$output"
} | doxygen -
