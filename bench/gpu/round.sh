#!/usr/bin/env bash
# Carries Kindling to a machine with a GPU and measures there: bits, times and images, in one round.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
usage='usage: round.sh pack FILE.tar.xz [SCENE_FOLDER]...   on the machine that built Kindling
       round.sh run FILE.tar.xz OUT [FLAG]...       on the machine with the GPU; flags go to round.py
pack takes build/release/kindling, the libraries that it needs, the scenes of the project, and folders with a scenes.json.
run needs Python 3.10, xz, and an NVIDIA driver; it writes OUT/round.md, OUT/round.json and OUT/images.tar.'
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

work=
trap '[ -z "$work" ] || rm -rf "$work"' EXIT

refuse() {
  printf '%s\n' "$1" >&2
  exit 2
}

# Libraries that come with every system, and must be those of the system whose driver is opened.
system_libraries='^(ld-linux.*|libc|libm|libdl|librt|libpthread|libresolv)\.so'

pack() {
  local file=$1 program=$root/build/release folder library
  shift
  [ -x "$program/kindling" ] || refuse "there is no $program/kindling; build it: cmake --preset release && cmake --build --preset release"
  work=$(mktemp -d)
  mkdir -p "$work/round/build/release" "$work/round/libraries" "$work/round/bench/gpu" "$work/round/tests/device" "$work/round/measured"
  cp "$program"/{kindling,kindling_oiio.so} "$work/round/build/release"
  strip "$work/round/build/release/kindling"
  ldd "$program/kindling" | sed -n 's/.* => \(\/[^ ]*\) .*/\1/p' | while read -r library; do
    [[ $(basename "$library") =~ $system_libraries ]] || cp -L "$library" "$work/round/libraries"
  done
  cp "$root"/bench/gpu/{round.sh,round.py} "$work/round/bench/gpu"
  cp "$root/bench/renderers.py" "$work/round/bench"
  cp "$root/tests/device/same_images.py" "$work/round/tests/device"
  (cd "$root" && git ls-files -z scenes | grep -zE '\.(glb|gltf|bin|hdr|exr|png|jpg|webp|ktx2|ies)$' | grep -zvE '/(broken|images)/' | tar --null -T - -c) |
    tar -x -C "$work/round"
  for folder in "$@"; do
    [ -f "$folder/scenes.json" ] || refuse "$folder: no scenes.json in it"
    python3 "$root/bench/gpu/round.py" --collect "$folder" "$work/round/measured"
  done
  tar -C "$work" -c round | xz -T0 -3 >"$file"
  printf '%s: %s MiB\n' "$file" "$(($(stat -c %s "$file") >> 20))"
}

run() {
  local file=$1 out=$2
  shift 2
  mkdir -p "$out"
  out=$(cd "$out" && pwd)
  work=$(mktemp -d)
  tar -xJf "$file" -C "$work"
  LD_LIBRARY_PATH=$work/round/libraries python3 "$work/round/bench/gpu/round.py" --out "$out" "$@"
}

case ${1:-} in
  pack) [ $# -ge 2 ] || refuse "$usage" ;;
  run) [ $# -ge 3 ] || refuse "$usage" ;;
  -h | --help)
    printf '%s\n' "$usage"
    exit
    ;;
  *) refuse "$usage" ;;
esac
"$@"
