#!/usr/bin/env bash
# Tests the Python package with the Python, compiler and libraries of a newer Debian.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/setup.sh"
source "$kindling_root/tests/package/roots.sh"
usage='usage: newer_python.sh SUITE
SUITE is trixie (Debian 13), forky or sid. Builds the wheel there, without the renderer, and runs its tests in a fresh
virtual environment (renderer/python/test.sh). Needs PyPI.'
[ $# -eq 1 ] || fail "$usage"
case $1 in
  trixie | forky | sid) ;;
  *) fail "$usage" ;;
esac

say "Making a Debian $1"
make_root "$1" g++ cmake ninja-build libembree-dev libtbb-dev libimath-dev python3-dev python3-venv
mkdir "$root/kindling"
(cd "$kindling_root" && git ls-files -z | tar --null --files-from=- --create) | tar -x -C "$root/kindling"
# Names, and certificates of a proxy.
for file in /etc/resolv.conf /etc/pip.conf /etc/ssl/certs/ca-certificates.crt; do
  [ ! -f "$file" ] || cp -L "$file" "$root$file"
done

say "Building and testing the wheel there"
# mypy asks /proc for the number of processors; the mount ends with the command.
env -u PIP_FIND_LINKS CMAKE_BUILD_PARALLEL_LEVEL="$(build_jobs)" unshare --mount sh -c 'mount --rbind /proc "$1/proc" &&
  chroot "$1" sh -c "cd /kindling && python3 --version && renderer/python/test.sh /tmp/python"' sh "$root" ||
  fail "the Python package does not pass its tests in a Debian $1"
say "The Python package passes its tests in a Debian $1"
