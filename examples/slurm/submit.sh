#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Renders a video on a Slurm cluster: an array job of N chunks, and a job that encodes the video after them.
#
#     submit.sh N SCENE OUT.mp4 [options of gnomon render]
#
# Options of sbatch come from its environment variables, such as SBATCH_PARTITION=farm and SBATCH_TIMELIMIT=60.
set -euo pipefail
[[ $# -ge 3 && $1 =~ ^[1-9][0-9]*$ ]] || { echo "usage: submit.sh N SCENE OUT.mp4 [options of gnomon render]" >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
chunks=$1 out=$3
# With --parsable, sbatch prints the number of the job, and the cluster's name after a semicolon if there are several.
render=$(sbatch --parsable --array="1-$chunks" "$here/render.sbatch" "$@")
encode=$(sbatch --parsable --dependency="afterok:${render%%;*}" --kill-on-invalid-dep=yes "$here/encode.sbatch" "$out")
echo "job ${render%%;*}: $chunks chunks; job ${encode%%;*}: the video"
