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

# Kernels for GPUs are a fifth of the build: only where a driver could run them.
gpu=ON
if [[ $(/sbin/ldconfig -p) != *libcuda.so.1* ]]; then
  say "No NVIDIA driver on this machine: building without kernels for GPUs (cmake/check.sh builds them)"
  gpu=OFF
  kindling_optional_packages=()
fi
kindling_optional_packages+=(python3-pip) # for get_oidn.sh
install_packages
configure release "-DKINDLING_GPU=$gpu"
build release kindling

out=$kindling_root/out
mkdir -p "$out"
# A denoised image needs a fraction of the samples. Without the denoiser the demo does without.
quality=(--spp 128 --time-limit 50s)
"$kindling_root/cmake/get_oidn.sh" --if-missing || say "Rendering without a denoiser"
if "$kindling_root/build/release/kindling" --version | grep '^OIDN' | grep -qv none; then
  quality=(--spp 32 --time-limit 10s --denoise best)
fi
say "Rendering scenes/interior.glb"
"$kindling_root/build/release/kindling" render "$kindling_root/scenes/interior.glb" \
  --size 960x540 "${quality[@]}" -o "$out/interior.png" -o "$out/interior.exr" ||
  fail "the render failed (its message is above)"
say "Done. The image: $out/interior.png"
say "The same, linear, with all its range: $out/interior.exr"
say "Your own scene: build/release/kindling render SCENE.glb -o image.png"
