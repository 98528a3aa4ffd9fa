#!/usr/bin/env bash
# Installs missing packages, builds Kindling and renders a scene to a PNG and an EXR.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

case "${1:-}" in
  "") ;;
  -h | --help)
    printf 'usage: cmake/demo.sh\nInstalls the missing Debian packages (root or sudo), builds Release into build/release and\nrenders scenes/interior.glb to out/interior.png and out/interior.exr.\n'
    exit 0
    ;;
  *) fail "unknown argument '$1'; it takes none" ;;
esac

install_packages
configure release
build release kindling

out=$kindling_root/out
mkdir -p "$out"
say "Rendering scenes/interior.glb"
"$kindling_root/build/release/kindling" render "$kindling_root/scenes/interior.glb" \
  --size 960x540 --spp 128 --time-limit 50s -o "$out/interior.png" -o "$out/interior.exr" ||
  fail "the render failed (its message is above)"
say "Done. The image: $out/interior.png"
say "The same, linear, with all its range: $out/interior.exr"
say "Your own scene: build/release/kindling render SCENE.glb -o image.png"
