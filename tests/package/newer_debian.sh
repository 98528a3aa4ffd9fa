#!/usr/bin/env bash
# Builds the program in a newer Debian and compares its images with those of this machine.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/setup.sh"
source "$kindling_root/tests/package/roots.sh"
usage='usage: newer_debian.sh SUITE PROGRAM [--scene SCENE]... [--race SCENE]...
SUITE is trixie (Debian 13), forky or sid, PROGRAM the kindling of this machine. --scene compares one more image, --race prints the shootout of a scene against
Embree 4.'
[ $# -ge 2 ] && [ -x "$2" ] || fail "$usage"
case $1 in
  trixie) debian="Debian 13" ;;
  forky | sid) debian="Debian $1" ;;
  *) fail "$usage" ;;
esac
suite=$1
program=$(realpath "$2")
shift 2
scenes=()
races=()
while [ $# -gt 0 ]; do
  [ -f "${2:-}" ] || fail "$usage"
  case $1 in
    --scene) scenes+=("$(realpath "$2")") ;;
    --race) races+=("$(realpath "$2")") ;;
    *) fail "$usage" ;;
  esac
  shift 2
done

say "Making a $debian with $(printf '%s\n' "${kindling_packages[@]}" | wc -l) packages"
make_root "$suite" "${kindling_packages[@]}"
mkdir "$root/kindling"
(cd "$kindling_root" && git ls-files -z | tar --null --files-from=- --create) | tar -x -C "$root/kindling"

say "Building there with $(build_jobs) jobs"
in_root sh -c "cd /kindling && cmake --preset release -DKINDLING_WARNINGS_AS_ERRORS=ON -DKINDLING_BUILD_TESTS=OFF -DKINDLING_BUILD_BENCH=OFF &&
  cmake --build --preset release --parallel $(build_jobs) --target kindling" >"$root/build.log" 2>&1 || {
  tail -n 60 "$root/build.log"
  fail "Kindling does not build in $debian"
}
there=/kindling/build/release/kindling
in_root $there --version
in_root python3 /kindling/scenes/generate.py --check || fail "scenes/generate.py writes other files in $debian"

# Images follow from the source alone: not from the compiler (GCC 12 here, 14 or newer there), nor
# from the C library. Embree 4 and 3 are two libraries, so the kd-tree is compared.
mkdir "$root/here" "$root/there" "$root/more"
hash_of() {
  oiiotool --info -v --hash "$1" | sed -n 's/.*SHA-1: //p'
}
differ=()
compared=0
# compare SCENE PLACE [FLAG]...: PLACE is that of the scene in the root.
compare() {
  local arguments=(--size 64x48 --spp 4 --exr-float --aov albedo,normal,depth,position,emission,direct,indirect,variance,samples --quiet "${@:3}")
  "$program" render "$1" "${arguments[@]}" -o "$root/here/image.exr" >/dev/null
  in_root $there render "$2" "${arguments[@]}" -o /there/image.exr >/dev/null
  compared=$((compared + 1))
  [ "$(hash_of "$root/here/image.exr")" = "$(hash_of "$root/there/image.exr")" ] || differ+=("$1 ${*:3}")
}
while IFS= read -r -d '' scene; do
  compare "$kindling_root/$scene" "/kindling/$scene"
done < <(cd "$kindling_root" && find scenes -not -path '*/broken/*' -not -path '*/images/*' \( -name '*.glb' -o -name '*.gltf' \) -print0 | sort -z)
for scene in cornell_box interior material_grid; do
  compare "$kindling_root/scenes/$scene.glb" "/kindling/scenes/$scene.glb" --integrator whitted
  compare "$kindling_root/scenes/$scene.glb" "/kindling/scenes/$scene.glb" --device host
done
for scene in "${scenes[@]}"; do
  rm -rf "$root/more" && cp -rL "$(dirname "$scene")" "$root/more"
  compare "$scene" "/more/$(basename "$scene")"
done
for scene in "${races[@]}"; do
  cp "$scene" "$root/tmp/"
  in_root $there shootout "/tmp/$(basename "$scene")" --clock cpu --rays-per-kind 65536 --repeat 3 --build-repeat 3
done
if [ ${#differ[@]} -gt 0 ]; then
  printf '%s\n' "${differ[@]}"
  fail "${#differ[@]} of $compared images differ between Debian 12 and $debian"
fi
say "$debian gives the $compared images of this machine, bit for bit"
