#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders a video on a real Slurm cluster of two nodes on this machine: an array job of six chunks and a job that
# encodes the video, as examples/slurm submits them. One node is killed while it renders a chunk. The video must have
# the bytes of one undisturbed run.
#
#     slurm.sh PROGRAM
#
# Each node is a slurmd in a process namespace of its own, so that killing its first process kills all of the node at
# once, as a loss of power does. Needs root, slurmctld, slurmd and ffmpeg; exits with 77 (skipped) otherwise.
set -euo pipefail
program=$(readlink -f "$1")
examples=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../examples/slurm" && pwd)

skip() { echo "slurm: skipped: $*"; exit 77; }
[[ $EUID -eq 0 ]] || skip "needs root"
for needed in slurmctld slurmd sbatch ffmpeg unshare; do
    command -v "$needed" >/dev/null || skip "needs $needed (slurm-wlm, ffmpeg)"
done
unshare --mount --pid --fork --mount-proc true 2>/dev/null || skip "may not make process namespaces"

scratch=$(mktemp -d)
processes=()
end() {
    for process in "${processes[@]}"; do kill -9 "$process" 2>/dev/null || true; done
    wait 2>/dev/null || true
    rm -rf "$scratch"
}
trap end EXIT
trap 'exit 130' INT TERM
fail() {
    echo "slurm: FAILED: $*"
    tail -n 20 "$scratch"/*.log "$scratch"/logs/* 2>/dev/null
    exit 1
}
say() { printf '%(%T)T  %s\n' -1 "$*"; }

# Make a cluster of two nodes with one processor each. Without accounts, authentication or groups of processes, because
# all of it is one user on one machine.
port=$((20000 + RANDOM % 20000))
cat >"$scratch/slurm.conf" <<TEXT
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port
AuthType=auth/none
CredType=cred/none
SlurmUser=root
SlurmdUser=root
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=1,sched_interval=2
StateSaveLocation=$scratch/state
SlurmctldPidFile=$scratch/slurmctld.pid
SlurmctldLogFile=$scratch/slurmctld.log
SlurmdSpoolDir=$scratch/%n
SlurmdPidFile=$scratch/%n.pid
SlurmdLogFile=$scratch/%n.log
SlurmdParameters=config_overrides
SlurmdTimeout=10
MessageTimeout=5
KillWait=2
NodeName=node1 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1
NodeName=node2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1
PartitionName=farm Nodes=node1,node2 Default=YES MaxTime=INFINITE State=UP
TEXT
export SLURM_CONF=$scratch/slurm.conf
mkdir "$scratch/state" "$scratch/logs"
slurmctld -D -c >"$scratch/slurmctld.out" 2>&1 &
processes+=($!)
for node in node1 node2; do
    # The shell that starts the namespace is killed with it; its child is the namespace's first process.
    unshare --mount --pid --fork --kill-child --mount-proc slurmd -D -N "$node" >"$scratch/$node.out" 2>&1 &
    processes+=($!)
done
second=${processes[2]}
for ((i = 0; i < 60; ++i)); do
    [[ $(sinfo -h -N -t idle -o %N 2>/dev/null | wc -l) -eq 2 ]] && break
    sleep 0.5
done
[[ $(sinfo -h -N -t idle -o %N | wc -l) -eq 2 ]] || fail "the nodes did not come up"
say "$(slurmctld -V), nodes: $(sinfo -h -N -o '%N %t' | tr '\n' ';')"

# The same video by one undisturbed run.
options=(--frames 1-24 --size 512x512 --quiet)
"$program" render builtin:cornell -o "$scratch/whole.mp4" --threads 1 "${options[@]}"
say "one run: $(sha256sum <"$scratch/whole.mp4" | cut -c1-16)"

# Submit it.
cd "$scratch/logs"
export GNOMON=$program
say "submitted: $("$examples/submit.sh" 6 builtin:cornell "$scratch/video.mp4" "${options[@]}")"

# Kill the second node as soon as the chunk that it renders has its first frame.
frames=$scratch/video.mp4.frames
chunk='' killed=''
for ((i = 0; i < 1200; ++i)); do
    if [[ -z $killed ]]; then
        chunk=$(squeue -h -r -t running -w node2 -o %K | head -n 1)
        first=$(((chunk - 1) * 4 + 1))
        if [[ -n $chunk && -e $frames/frame-$(printf %06d "$first").png && ! -e $frames/frame-$(printf %06d $((first + 3))).png ]]; then
            kill -9 "$second"
            wait "$second" 2>/dev/null || true   # so that the shell does not report it
            killed=$chunk
            say "node2 killed in chunk $killed, frames there: $(find "$frames" -name 'frame-*.png' | wc -l)"
        fi
        sleep 0.05
        continue
    fi
    now="$(sinfo -h -N -o '%N %t' | tr '\n' ';') jobs: $(squeue -h -r -o '%K %T %N' | tr '\n' ';')"
    [[ $now == "${before:-}" ]] || say "$now"
    before=$now
    [[ -e $scratch/video.mp4 || -z $(squeue -h) ]] && break
    sleep 0.5
done
[[ -n $killed ]] || fail "no chunk was rendered on node2"
[[ -e $scratch/video.mp4 ]] || fail "no video"
for ((i = 0; i < 20; ++i)); do [[ -z $(squeue -h) ]] && break; sleep 0.5; done

echo "logs of the tasks:"
for log in gnomon-render-*.log gnomon-encode-*.log; do sed "s|$scratch/||g; s|^|    $log: |" "$log"; done
grep -q "chunk $killed/6 on node1, start 1" gnomon-render-*-"$killed".log || fail "the killed chunk was not started again"
cmp "$scratch/whole.mp4" "$scratch/video.mp4" || fail "the video differs from that of one run"
[[ ! -e $frames ]] || fail "frames are left"
say "six chunks on two nodes, one killed: $(sha256sum <"$scratch/video.mp4" | cut -c1-16), the same bytes"
