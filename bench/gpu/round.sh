#!/usr/bin/env bash
# Carries Kindling to a machine with a GPU and measures there: bits, times and images, in one round.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
usage='usage: round.sh pack FILE.tar.xz [--wheels FOLDER] [SCENE_FOLDER]...   on the machine that built Kindling
       round.sh run FILE.tar.xz OUT [FLAG]...       on the machine with the GPU; flags go to round.py
pack takes build/release/kindling, the libraries that it needs, the scenes of the project, and folders with a scenes.json.
--wheels adds Python packages, unpacked, for the part peer: 40 MB. They must fit the Python of the other machine, here 3.12:
  python3 -m pip download --no-deps --only-binary=:all: --python-version 3.12 --platform manylinux_2_28_x86_64 \
    -d FOLDER mitsuba==3.9.1 drjit==1.5.0
run needs Python 3.10, xz, and an NVIDIA driver; it writes OUT/round.md, OUT/round.json and OUT/images.tar. The parts kernels and
sanitizer need ncu and compute-sanitizer of a CUDA toolkit, paper NumPy and Pillow, peer NumPy; without them they are skipped.'
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
  local file=$1 program=$root/build/release folder library wheels= wheel level=3
  shift
  if [ "${1:-}" = --wheels ]; then
    [ $# -ge 2 ] || refuse "$usage"
    wheels=$2
    shift 2
    compgen -G "$wheels/*.whl" >/dev/null || refuse "$wheels: no .whl in it"
  fi
  [ -x "$program/kindling" ] || refuse "there is no $program/kindling; build it: cmake --preset release && cmake --build --preset release"
  work=$(mktemp -d)
  mkdir -p "$work"/round/{build/release,libraries,bench/{gpu,paper,peers},tests/device,measured,wheels}
  cp "$program"/{kindling,kindling_oiio.so} "$work/round/build/release"
  strip "$work/round/build/release/kindling"
  ldd "$program/kindling" | sed -n 's/.* => \(\/[^ ]*\) .*/\1/p' | while read -r library; do
    [[ $(basename "$library") =~ $system_libraries ]] || cp -L "$library" "$work/round/libraries"
  done
  for folder in bench/gpu bench/paper bench/peers; do
    cp "$root/$folder"/*.py "$work/round/$folder"
  done
  cp "$root/bench/gpu/round.sh" "$work/round/bench/gpu"
  cp "$root"/bench/*.py "$work/round/bench"
  cp "$root/tests/device/same_images.py" "$work/round/tests/device"
  (cd "$root" && git ls-files -z scenes | grep -zE '\.(glb|gltf|bin|hdr|exr|png|jpg|webp|ktx2|ies)$' | grep -zvE '/(broken|images)/' | tar --null -T - -c) |
    tar -x -C "$work/round"
  if [ -n "$wheels" ]; then
    for wheel in "$wheels"/*.whl; do
      python3 -m zipfile -e "$wheel" "$work/round/wheels"
    done
    find "$work/round/wheels" \( -name '*.pyi' -o -name '*.h' \) -delete
    level=6 # a minute longer, 5 MB less
  fi
  for folder in "$@"; do
    [ -f "$folder/scenes.json" ] || refuse "$folder: no scenes.json in it"
    python3 "$root/bench/gpu/round.py" --collect "$folder" "$work/round/measured"
  done
  tar -C "$work" -c round | xz -T0 "-$level" >"$file"
  printf '%s: %s MiB\n' "$file" "$(($(stat -c %s "$file") >> 20))"
}

run() {
  local file=$1 out=$2
  shift 2
  mkdir -p "$out"
  out=$(cd "$out" && pwd)
  work=$(mktemp -d)
  tar -xJf "$file" -C "$work"
  LD_LIBRARY_PATH=$work/round/libraries PYTHONPATH=$work/round/wheels${PYTHONPATH:+:$PYTHONPATH} \
    python3 "$work/round/bench/gpu/round.py" --out "$out" "$@"
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
