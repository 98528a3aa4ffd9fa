#!/usr/bin/env bash
# Installs Khronos' glTF validator into build/validator, for the test import.khronos_validator.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
version=2.0.0-dev.3.10
folder=$(cd "$(dirname "$0")/../.." && pwd)/build/validator
command -v npm >/dev/null || {
  echo "get_validator.sh: npm is missing; on Debian: apt-get install npm" >&2
  exit 1
}
mkdir -p "$folder"
npm install --prefix "$folder" --no-audit --no-fund --save-exact "gltf-validator@$version"
echo "The validator is in $folder; configure again to have its test: cmake --preset release"
