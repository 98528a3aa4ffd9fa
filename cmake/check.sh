#!/usr/bin/env bash
# Installs missing packages, builds Kindling with its tests and benchmarks, and runs all tests.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

usage='usage: cmake/check.sh [-DNAME=VALUE]...
Installs the missing Debian packages (root or sudo), builds Release into build/release and runs all tests.
-D options go to CMake, e.g. -DKINDLING_WARNINGS_AS_ERRORS=ON'
for argument in "$@"; do
  case "$argument" in
    -h | --help)
      printf '%s\n' "$usage"
      exit 0
      ;;
    -D*=*) ;;
    *) fail "unknown argument '$argument'; it takes CMake's -DNAME=VALUE" ;;
  esac
done

install_packages
stage "Building"
configure release "$@"
build release
stage "Running all tests"
(cd "$kindling_root" && ctest --preset release --parallel "$(nproc)") || fail "tests failed (their output is above)"
report_stages
say "All tests passed"
