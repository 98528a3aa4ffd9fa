#!/usr/bin/env bash
# Builds the program in a Debian 13 and compares its images with those of this machine.
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
in_root python3 /kindling/scenes/generate.py --check || fail "scenes/generate.py writes other files in Debian 13"

# glibc 2.41 rounds acosf, asinf, atan2f and tanf correctly, glibc 2.36 does not: some last bits of
# images follow. So this machine's program renders with the C library of Debian 13, and nothing else
# of it.
mkdir "$root/glibc" "$root/here" "$root/there"
cp -L "$root"/lib/x86_64-linux-gnu/{libc.so.6,libm.so.6,ld-linux-x86-64.so.2} "$root/glibc/"
libraries=$root/glibc:/lib/x86_64-linux-gnu:/usr/lib/x86_64-linux-gnu

hash_of() {
  oiiotool --info -v --hash "$1" | sed -n 's/.*SHA-1: //p'
}
differ=0
for scene in cornell_box interior material_grid instancing; do
  for accelerator in kdtree embree; do
    arguments=(--accel $accelerator --size 96x64 --spp 4 --exr-float --quiet)
    in_root $there render "/kindling/scenes/$scene.glb" "${arguments[@]}" -o /there/a.exr >/dev/null
    scene_here=$kindling_root/scenes/$scene.glb
    "$program" render "$scene_here" "${arguments[@]}" -o "$root/here/plain.exr" >/dev/null
    "$root/glibc/ld-linux-x86-64.so.2" --library-path "$libraries" "$program" render "$scene_here" "${arguments[@]}" -o "$root/here/same.exr" >/dev/null
    expected=$(hash_of "$root/there/a.exr")
    plain=no same=no
    [ "$(hash_of "$root/here/plain.exr")" != "$expected" ] || plain=yes
    [ "$(hash_of "$root/here/same.exr")" != "$expected" ] || same=yes
    say "$scene, $accelerator: same bits: $plain, with the same C library: $same"
    # Embree 4 and 3 are two libraries; the kd-tree is one.
    [ $accelerator = embree ] || [ $same = yes ] || differ=1
  done
done
for scene in "${races[@]}"; do
  cp "$scene" "$root/tmp/"
  in_root $there shootout "/tmp/$(basename "$scene")" --clock cpu --rays-per-kind 65536 --repeat 3 --build-repeat 3
done
[ $differ -eq 0 ] || fail "images of the kd-tree differ between Debian 12 and 13 with the same C library"
say "Debian 13 gives the images of this machine, but for the C library"
