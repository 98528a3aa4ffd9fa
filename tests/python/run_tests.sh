#!/usr/bin/env bash
# Tests the Python package in the environment that renderer/python/test.sh has made.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
tests=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$1
if [ ! -x "$folder/venv/bin/pytest" ]; then
  printf 'skipped: there is no %s/venv; run renderer/python/test.sh\n' "$folder"
  exit 77
fi
export KINDLING_SOURCE_DIR=$tests/../.. PYTHONDONTWRITEBYTECODE=1
cd "$folder" # not in the sources, where a folder is called kindling
"$folder/venv/bin/pytest" -q -p no:cacheprovider "$tests"/test_*.py
for source in "$folder"/trimesh/trimesh-*/; do
  PYTHONPATH=$tests "$folder/venv/bin/pytest" -q -p no:cacheprovider -p trimesh_with_kindling --rootdir "$source" "$source"/tests/test_ray*.py
done
"$folder/venv/bin/mypy" --strict --cache-dir "$folder/mypy" -p kindling
