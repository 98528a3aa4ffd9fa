#!/usr/bin/env bash
# Builds the program in a Debian 13, which has GCC 14 and Embree 4, renders with each accelerator there and here, and compares the pixels.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/setup.sh"
source "$kindling_root/tests/package/roots.sh"
usage='usage: debian13.sh PROGRAM [--race SCENE]...
PROGRAM is the kindling of this machine. --race also prints the shootout of a scene against Embree 4.'
[ $# -ge 1 ] && [ -x "$1" ] || fail "$usage"
program=$(realpath "$1")
shift
races=()
while [ $# -gt 0 ]; do
  [ "$1" = --race ] && [ -f "${2:-}" ] || fail "$usage"
  races+=("$(realpath "$2")")
  shift 2
done

say "Making a Debian 13 with $(printf '%s\n' "${kindling_packages[@]}" | wc -l) packages"
make_root trixie "${kindling_packages[@]}"
mkdir "$root/kindling"
(cd "$kindling_root" && git ls-files -z | tar --null --files-from=- --create) | tar -x -C "$root/kindling"

say "Building there with $(build_jobs) jobs"
in_root sh -c "cd /kindling && cmake --preset release -DKINDLING_WARNINGS_AS_ERRORS=ON -DKINDLING_BUILD_TESTS=OFF -DKINDLING_BUILD_BENCH=OFF &&
  cmake --build --preset release --parallel $(build_jobs) --target kindling" >"$root/build.log" 2>&1 || {
  tail -n 60 "$root/build.log"
  fail "Kindling does not build in Debian 13"
}
there=/kindling/build/release/kindling
in_root $there --version

hash_of() {
  oiiotool --info -v --hash "$1" | sed -n 's/.*SHA-1: //p'
}
mkdir "$root/here" "$root/there"
differ=0
for scene in cornell_box interior material_grid instancing; do
  for accelerator in kdtree embree; do
    arguments=(--accel $accelerator --size 96x64 --spp 4 --exr-float --quiet)
    "$program" render "$kindling_root/scenes/$scene.glb" "${arguments[@]}" -o "$root/here/a.exr" >/dev/null
    in_root $there render "/kindling/scenes/$scene.glb" "${arguments[@]}" -o /there/a.exr >/dev/null
    if [ "$(hash_of "$root/here/a.exr")" = "$(hash_of "$root/there/a.exr")" ]; then
      say "$scene, $accelerator: same bits"
    else
      say "$scene, $accelerator: bits differ"
      [ $accelerator = embree ] || differ=1
    fi
  done
done
for scene in "${races[@]}"; do
  cp "$scene" "$root/tmp/"
  in_root $there shootout "/tmp/$(basename "$scene")" --clock cpu --rays-per-kind 65536 --repeat 3 --build-repeat 3
done
[ $differ -eq 0 ] || fail "images of the kd-tree differ between Debian 12 and 13"
say "Debian 13 gives the images of this machine"
