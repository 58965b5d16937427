# SPDX-License-Identifier: Apache-2.0
# Sourced by the tests that make a bare Debian in a chroot.

# The first Debian mirror of this machine's apt, in either of its two file formats.
debian_mirror() {
    { cat /etc/apt/sources.list.d/*.sources 2>/dev/null | sed -n 's/^URIs: *\([^ ]*\).*/\1/p'
      cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list 2>/dev/null |
          sed -n 's/^deb  *\(\[[^]]*\]  *\)\?\([^ ]*\)  *bookworm .*/\2/p'; } |
        grep -v -e security | grep '/debian/*$' | head -n 1
}
