# Functions and package lists that demo.sh, check.sh and .ci/run share; sourced, not run.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail

kindling_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Everything that a build, its tests and the demo need, as Debian 12 names it. The one list.
kindling_packages=(
  # tools
  cmake g++ ninja-build python3 python3-numpy python3-yaml
  # ray tracing, threads, vectors
  libembree-dev libtbb-dev libimath-dev
  # images and color (OpenImageIO's package file names the programs of openimageio-tools)
  libopenimageio-dev openimageio-tools libopenexr-dev libopencolorio-dev libjpeg-dev libpng-dev libwebp-dev libzstd-dev zlib1g-dev
  # glTF and its compressions
  libtinygltf-dev libmeshoptimizer-dev libdraco-dev nlohmann-json3-dev
  # the server of kindling view
  libcpp-httplib-dev
  # command line and messages
  libcli11-dev libspdlog-dev libfmt-dev
  # tests and benchmarks
  libgtest-dev libbenchmark-dev
)

# Kernels for GPUs; without it a build has none.
kindling_optional_packages=(clang-19)

# A Slurm cluster on one machine, for tests/farm and bench/farm_speedup.py.
kindling_farm_packages=(munge slurmctld slurmd slurm-client)

say() { printf '== %s\n' "$*"; }
fail() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# stage TITLE: what begins now. report_stages: how long each took, once the last one is over.
stage_titles=() stage_starts=()
stage() {
  say "$(date +%T) $1"
  stage_titles+=("$1")
  stage_starts+=("$SECONDS")
}
report_stages() {
  local i seconds
  for i in "${!stage_titles[@]}"; do
    seconds=$((${stage_starts[i + 1]:-$SECONDS} - stage_starts[i]))
    printf '== %3d:%02d  %s\n' $((seconds / 60)) $((seconds % 60)) "${stage_titles[i]}"
  done
}

# missing_packages PACKAGE...: those that are not installed, one a line.
missing_packages() {
  local package
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || printf '%s\n' "$package"
  done
}

kindling_apt=(env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)

# install_packages [PACKAGE...]: the list, these besides, and the optional ones where they can be.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    fail "this machine has no apt-get; this script knows Debian 12 only. Install what cmake/KindlingDependencies.cmake finds, then:" \
      "cmake --preset release && cmake --build --preset release"
  fi
  local missing as_root=()
  mapfile -t missing < <(missing_packages "${kindling_packages[@]}" "$@")
  if [ ${#missing[@]} -eq 0 ]; then
    say "All Debian packages are installed"
    install_optional_packages
    return
  fi
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "these packages are missing and there is no sudo; run this as root once: apt-get install ${missing[*]}"
    as_root=(sudo)
    # Without a terminal no password can be typed.
    [ -t 0 ] || sudo -n true 2>/dev/null ||
      fail "these packages are missing and sudo asks for a password; run this as root once: apt-get install ${missing[*]}"
  fi
  say "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  local apt=("${as_root[@]}" "${kindling_apt[@]}")
  # A foreign package source that does not answer is no reason to stop; what cannot be installed is.
  "${apt[@]}" update || say "apt-get update did not reach every package source; continuing with those that it reached"
  "${apt[@]}" install -y --no-install-recommends "${missing[@]}" ||
    fail "apt-get could not install all of: ${missing[*]} (see its lines above; is the network reachable, and is this Debian 12 or newer?)"
  install_optional_packages
}

# Those that the package lists know, if no password is needed. Their absence is no failure.
install_optional_packages() {
  local missing package known=() as_root=()
  mapfile -t missing < <(missing_packages "${kindling_optional_packages[@]}")
  for package in "${missing[@]}"; do
    if apt-cache show "$package" >/dev/null 2>&1; then known+=("$package"); fi
  done
  [ ${#known[@]} -gt 0 ] || return 0
  if [ "$(id -u)" -ne 0 ]; then
    sudo -n true 2>/dev/null || return 0
    as_root=(sudo)
  fi
  say "Installing optional Debian packages: ${known[*]}"
  "${as_root[@]}" "${kindling_apt[@]}" install -y --no-install-recommends "${known[@]}" || say "Continuing without them"
}

# As many compilers at once as there are processors, one for each 1.5 GB of memory at most.
build_jobs() {
  local processors memory_mb jobs
  processors=$(nproc)
  memory_mb=$(awk '/^MemAvailable:/ {print int($2 / 1024)}' /proc/meminfo)
  jobs=$((memory_mb / 1500))
  ((jobs > processors)) && jobs=$processors
  ((jobs < 1)) && jobs=1
  printf '%s\n' "$jobs"
}

# configure PRESET [cmake arguments...]: ccache is used where it is installed.
configure() {
  local preset=$1
  shift
  say "Configuring build/$preset"
  local launcher=()
  command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  (cd "$kindling_root" && cmake --preset "$preset" "${launcher[@]}" "$@") ||
    fail "CMake could not configure build/$preset (its message is above); an outdated build/$preset can be deleted"
}

# build PRESET [targets...]
build() {
  local preset=$1
  shift
  local jobs
  jobs=$(build_jobs)
  say "Building build/$preset with $jobs jobs (the first time takes minutes)"
  local targets=()
  [ $# -gt 0 ] && targets=(--target "$@")
  (cd "$kindling_root" && cmake --build --preset "$preset" --parallel "$jobs" "${targets[@]}") ||
    fail "the build of build/$preset failed (the first error is above)"
}
