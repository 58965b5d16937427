#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Debian package twice, in folders of different names, and compares the bytes. Then installs it on a bare
# Debian 12 (in a chroot) with apt alone, renders there, and checks the list of what is linked.
#
# Needs root, debootstrap, dpkg-dev, git, and the package archive of this machine's apt configuration;
# exits with 77 (skipped) otherwise. PACKAGE=FILE.deb takes a package that is built, with
# that of Python beside it, and leaves out the builds.
set -euo pipefail
source_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

skip() { echo "package: skipped: $*"; exit 77; }
fail() { echo "package: FAILED: $*"; exit 1; }

source "$source_folder/tests/full/debian_mirror.sh"

# This part runs in a mount namespace, so that mounts end with it in all cases.
in_namespace() {
    local root=$1 file
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    enter() {
        env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
            ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
            chroot "$root" "$@"
    }
    ! enter sh -c 'command -v gnomon || command -v ffmpeg || command -v g++' || fail "the system is not bare"
    enter apt-get -qq update >/dev/null
    enter apt-get -qq install --no-install-recommends -o Dpkg::Use-Pty=0 /gnomon.deb >"$root/log" 2>&1 ||
        { tail -n 20 "$root/log"; fail "apt cannot install the package"; }
    echo "package: installed with $(enter dpkg-query -W -f '${Package}\n' | wc -l) packages in all, $(enter gnomon --version)"

    # Render an image, and a chunk of a video; without ffmpeg, a video is refused in one line.
    enter gnomon render builtin:cornell -o /image.png --size 160x120 --quiet
    [[ $(head -c 4 "$root/image.png" | tail -c 3) == PNG ]] || fail "no image"
    enter gnomon render builtin:cornell -o /video.mp4 --size 160x120 --frames 1-4 --chunk 1/2 --quiet
    enter gnomon render builtin:cornell -o /video.mp4 --size 160x120 --frames 1-4 --chunk 2/2 --quiet
    local rc=0
    enter gnomon join /video.mp4 2>"$root/log" || rc=$?
    [[ $rc -eq 4 ]] && grep -q ffmpeg "$root/log" || fail "without ffmpeg: exit code $rc, $(cat "$root/log")"
    enter apt-get -qq install --no-install-recommends -o Dpkg::Use-Pty=0 ffmpeg >"$root/log" 2>&1 ||
        { tail -n 20 "$root/log"; fail "apt cannot install ffmpeg"; }
    enter gnomon join /video.mp4
    enter ffmpeg -v error -i /video.mp4 -f null - || fail "the video does not play"
    enter gnomon devices
    for file in usr/share/man/man1/gnomon.1 usr/share/doc/gnomon/copyright usr/share/doc/gnomon/examples/slurm/submit.sh \
        usr/include/gnomon/gnomon.h; do
        [[ -e $root/$file || -e $root/$file.gz ]] || fail "$file is missing"
    done
    [[ -n $(enter ldconfig -p | grep libgnomon.so.) ]] || fail "the dynamic linker does not know the library"

    # The Python package renders the same image.
    enter apt-get -qq install --no-install-recommends -o Dpkg::Use-Pty=0 /python3-gnomon.deb >"$root/log" 2>&1 ||
        { tail -n 20 "$root/log"; fail "apt cannot install the Python package"; }
    enter python3 -c 'import gnomon
renderer = gnomon.Renderer(size=(160, 120), samples="auto")
renderer.render(gnomon.load("builtin:cornell")).write("/by_python.png")' || fail "Python cannot render"
    cmp "$root/image.png" "$root/by_python.png" || fail "Python renders another image"
    enter apt-get -qq purge -o Dpkg::Use-Pty=0 python3-gnomon >"$root/log" 2>&1 || fail "apt cannot remove the Python package"
    [[ ! -e $root/usr/lib/python3/dist-packages/gnomon ]] || fail "files of the Python package are left"

    # Every library that the program loads from another package belongs to a package in the list.
    python3 -B - "$root" <<'PYTHON' || fail "the list of what is linked"
import json, sys
from pathlib import Path
document = json.loads(Path(sys.argv[1], "usr/share/doc/gnomon/gnomon.spdx.json").read_text())
assert document["spdxVersion"] == "SPDX-2.3" and document["dataLicense"] == "CC0-1.0"
names = {p["name"] for p in document["packages"]}
ids = {p["SPDXID"] for p in document["packages"]} | {"SPDXRef-DOCUMENT"}
assert len(ids) == len(document["packages"]) + 1, "an id is used twice"
for r in document["relationships"]:
    assert {r["spdxElementId"], r["relatedSpdxElement"]} <= ids, r
linked = {r["relatedSpdxElement"] for r in document["relationships"] if r["relationshipType"] == "DYNAMIC_LINK"}
assert ids >= linked and linked
# What apt was told to install for the program must be in the list.
status = Path(sys.argv[1], "var/lib/dpkg/status").read_text()
paragraph, = (p for p in status.split("\n\n") if p.startswith("Package: gnomon\n"))
depends, = (line for line in paragraph.splitlines() if line.startswith("Depends: "))
needed = {word.split()[0] for word in depends.removeprefix("Depends: ").split(", ")}
missing = needed - names
assert not missing, f"not listed: {missing}"
print(f"package: lists {len(names) - 1} packages, {len(linked)} of them linked dynamically; depends on {len(needed)}")
PYTHON
    enter apt-get -qq purge -o Dpkg::Use-Pty=0 gnomon >"$root/log" 2>&1 || fail "apt cannot remove the package"
    [[ ! -e $root/usr/share/doc/gnomon && ! -e $root/usr/bin/gnomon ]] || fail "files are left"
    echo "package: ok"
}

if [[ ${1:-} == --in-namespace ]]; then
    in_namespace "$2"
    exit
fi

[[ $EUID -eq 0 ]] || skip "needs root"
command -v debootstrap >/dev/null || skip "needs debootstrap"
command -v dpkg-shlibdeps >/dev/null || skip "needs dpkg-dev"
command -v git >/dev/null || skip "needs git"
git -C "$source_folder" rev-parse HEAD >/dev/null 2>&1 || skip "not a git checkout"
unshare --mount true 2>/dev/null || skip "may not mount"
mirror=$(debian_mirror) || true
[[ -n $mirror ]] || skip "no Debian mirror in /etc/apt"

scratch=$(mktemp -d)
trap 'rm -rf --one-file-system "$scratch"' EXIT
trap 'exit 130' INT TERM

if [[ -n ${PACKAGE:-} ]]; then
    cp "$PACKAGE" "$scratch/first.deb"
    cp "$(dirname "$PACKAGE")"/python3-gnomon_*.deb "$scratch/first-python.deb"
else
    # Build without a compiler cache, because it would compare the first build with itself.
    export CCACHE_DISABLE=1
    commit=$(git -C "$source_folder" rev-parse HEAD)   # for both builds, even if somebody commits in between
    SOURCE_DATE_EPOCH=$(git -C "$source_folder" log -1 --format=%ct "$commit")
    export SOURCE_DATE_EPOCH
    for build in first another/name; do
        mkdir -p "$scratch/$build"
        git -C "$source_folder" archive "$commit" | tar -x -C "$scratch/$build"
        (cd "$scratch/$build" && ./dev package >"$scratch/log" 2>&1) || { tail -n 20 "$scratch/log"; fail "./dev package"; }
        cp "$scratch/$build"/build/package/gnomon_*.deb "$scratch/$(basename "$build").deb"
        cp "$scratch/$build"/build/package/python3-gnomon_*.deb "$scratch/$(basename "$build")-python.deb"
        sha256sum "$scratch/$(basename "$build").deb"
    done
    cmp "$scratch/first.deb" "$scratch/name.deb" || fail "two builds differ"
    cmp "$scratch/first-python.deb" "$scratch/name-python.deb" || fail "two builds of the Python package differ"
    echo "package: two builds, the same bytes"
fi

root=$scratch/root
make=(debootstrap --variant=minbase)
[[ $mirror != https:* ]] || make+=(--include=ca-certificates)
if ! "${make[@]}" bookworm "$root" "$mirror" >"$scratch/log" 2>&1; then
    tail -n 5 "$scratch/log"
    skip "could not make a system from $mirror"
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
cp "$scratch/first.deb" "$root/gnomon.deb"
cp "$scratch/first-python.deb" "$root/python3-gnomon.deb"
unshare --mount --propagation private "${BASH_SOURCE[0]}" --in-namespace "$root"
