#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a minimal Debian 12 to a video: a debootstrap system in a folder, this repository's HEAD in it, then `./dev demo`
# and `./dev test` as in the README. ./dev itself must install everything else.
#
# Needs root, debootstrap, git and the package archive of this machine's apt configuration; exits with 77 (skipped)
# otherwise.
# Mounts are in a separate mount namespace and end with it, in all cases.
#
# GNOMON_DEMO_ARGS: options for the demo's video (default: a short and small one).
set -euo pipefail
source_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

skip() { echo "bare_debian: skipped: $*"; exit 77; }
fail() { echo "bare_debian: FAILED: $*"; exit 1; }

source "$source_folder/tests/full/debian_mirror.sh"

# This part runs in the mount namespace.
in_namespace() {
    local root=$1
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    enter() {
        env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb GNOMON_DEMO_ARGS="$GNOMON_DEMO_ARGS" \
            ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
            chroot "$root" "$@"
    }
    ! enter sh -c 'command -v g++ || command -v cmake || command -v python3' || fail "the system is not bare"

    echo "bare_debian: ./dev demo, with nothing installed"
    time enter /gnomon/dev demo
    [[ -s $root/gnomon/out/kinetic.mp4 ]] || fail "no video"
    [[ -s $root/gnomon/out/kinetic.png ]] || fail "no contact sheet"
    enter ffmpeg -v error -i /gnomon/out/kinetic.mp4 -f null - || fail "the video does not play"

    local turn
    for turn in 1 2; do
        echo "bare_debian: ./dev test, turn $turn"
        enter /gnomon/dev test -R '^(layers|machine_paths|Texture\..*|Builtin.*)$' >"$root/log" 2>&1 || { cat "$root/log"; fail "./dev test"; }
        tail -n 4 "$root/log"
        grep -q '^100% tests passed' "$root/log" || fail "no closing line"
        ! grep -q 'dev: installing' "$root/log" || fail "installs again what is there"
    done
    echo "bare_debian: ok"
}

if [[ ${1:-} == --in-namespace ]]; then
    in_namespace "$2"
    exit
fi

[[ $EUID -eq 0 ]] || skip "needs root"
command -v debootstrap >/dev/null || skip "needs debootstrap"
command -v git >/dev/null || skip "needs git"
git -C "$source_folder" rev-parse HEAD >/dev/null 2>&1 || skip "not a git checkout"
unshare --mount true 2>/dev/null || skip "may not mount"
mirror=$(debian_mirror) || true
[[ -n $mirror ]] || skip "no Debian mirror in /etc/apt"

scratch=$(mktemp -d)
trap 'rm -rf --one-file-system "$scratch"' EXIT
trap 'exit 130' INT TERM
root=$scratch/root

more=()
[[ $mirror != https:* ]] || more+=(--include=ca-certificates)
if ! debootstrap --variant=minbase "${more[@]}" bookworm "$root" "$mirror" >"$scratch/debootstrap.log" 2>&1; then
    tail -n 5 "$scratch/debootstrap.log"
    skip "debootstrap could not make a system from $mirror"
fi
# Copy this machine's access to the archive: sources, options, keys, names, certificates.
rm -rf "$root/etc/apt"
cp -a /etc/apt "$root/etc/apt"
cp -a /usr/share/keyrings/. "$root/usr/share/keyrings/"
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
if [[ $mirror == https:* && -d /usr/local/share/ca-certificates ]]; then
    cp -a /usr/local/share/ca-certificates "$root/usr/local/share/"
    chroot "$root" update-ca-certificates >/dev/null
fi

mkdir "$root/gnomon"
git -C "$source_folder" archive HEAD | tar -x -C "$root/gnomon"
export GNOMON_DEMO_ARGS="${GNOMON_DEMO_ARGS:---frames 1-12 --size 320x180}"
unshare --mount --propagation private "${BASH_SOURCE[0]}" --in-namespace "$root"
