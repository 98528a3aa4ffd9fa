#!/usr/bin/env bash
# Tests the Python package as users get it: the wheel, installed into a fresh virtual environment.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
usage='usage: renderer/python/test.sh [--render] [FOLDER [PYTHON]...]
Builds the wheel, installs it into a new virtual environment FOLDER/venv (build/python) of PYTHON (python3), and runs the
tests. Of several Pythons each has its own folder, such as FOLDER-3.13. --render builds the renderer too, with all its
dependencies. Needs PyPI.'
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
only_accel=ON
render=()
if [ "${1:-}" = --render ]; then
  only_accel=OFF
  render=(--render)
  shift
fi
if [[ "${1:-}" == -* ]]; then
  printf '%s\n' "$usage"
  [[ "${1:-}" == -h || "${1:-}" == --help ]] && exit 0
  exit 2
fi
if [ $# -gt 2 ]; then
  folder=$1
  shift
  for python in "$@"; do
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    printf '== Python %s\n' "$version"
    "${BASH_SOURCE[0]}" "${render[@]}" "$folder-$version" "$python"
  done
  exit
fi
mkdir -p "${1:-$root/build/python}"
folder=$(cd "${1:-$root/build/python}" && pwd)
rm -rf "$folder/venv" "$folder/dist" "$folder/trimesh"
"${2:-python3}" -m venv "$folder/venv"
bin=$folder/venv/bin
"$bin/pip" -q wheel "$root/renderer/python" --no-deps -w "$folder/dist" --config-settings cmake.define.KINDLING_ONLY_ACCEL=$only_accel \
  --config-settings build-dir="$folder/build_$only_accel" # kept, for the next time
"$bin/pip" -q install "$folder"/dist/kindling-*.whl
"$bin/pip" -q install pytest mypy trimesh embreex scipy rtree networkx shapely manifold3d matplotlib nbclient ipykernel
# trimesh's tests come with its source.
version=$("$bin/python" -c 'import trimesh; print(trimesh.__version__)')
"$bin/pip" -q download "trimesh==$version" --no-deps --no-binary trimesh -d "$folder/trimesh"
tar xzf "$folder/trimesh/trimesh-$version.tar.gz" -C "$folder/trimesh"
"$root/tests/python/run_tests.sh" "$folder"
