#!/usr/bin/env bash
# Profiles one render: time by stage (rays by kind, surfaces, BSDF, lights, film) and by folder.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
kindling=${KINDLING:-$root/build/profile/kindling}

usage() {
  cat <<'TEXT'
usage: bench/profile.sh SCENE [FLAGS OF kindling render]

Renders SCENE on one thread under perf, or under callgrind where perf is missing or not permitted, and prints what share of the
samples (instructions, with callgrind) each stage of the render and each folder of the source takes. Functions that
the compiler has inlined count where their source is. Wants an optimized build with debug information:

    cmake --preset profile && cmake --build --preset profile

or another one by KINDLING=PATH. PROFILER=perf|callgrind chooses. Under callgrind a render takes 50 times as long: give it a small one.
TEXT
}

fail() {
  printf 'profile.sh: %s\n' "$1" >&2
  exit 1
}

case "${1:-}" in
  "" | -h | --help) usage; [ $# -gt 0 ] && exit 0 || exit 2 ;;
esac
[ -f "$1" ] || fail "$1: no such file"
[ -x "$kindling" ] || fail "no Kindling at $kindling; build it (cmake --preset profile && cmake --build --preset profile) or name it: KINDLING=PATH"
command -v addr2line readelf >/dev/null || fail "addr2line is not installed (Debian: apt-get install binutils)"
readelf -S "$kindling" | grep -q '\.debug_info' ||
  fail "$kindling has no debug information; use the preset 'profile' (the release build with -g)"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
render=("$kindling" render "$@" -o "$scratch/image.exr" --threads 1 --quiet)

perf_works() {
  command -v perf >/dev/null && perf record -q -e cpu-clock:u -o "$scratch/probe.data" -- true >/dev/null 2>&1
}
profiler=${PROFILER:-}
if [ -z "$profiler" ]; then
  if perf_works; then
    profiler=perf
  elif command -v valgrind >/dev/null; then
    profiler=callgrind
    printf 'perf is not there (Debian: apt-get install linux-perf) or not permitted (/proc/sys/kernel/perf_event_paranoid): callgrind instead\n' >&2
  else
    fail "neither perf nor valgrind can be used (Debian: apt-get install linux-perf, or valgrind)"
  fi
fi

case $profiler in
  perf)
    # The kernel's timer, which virtual machines have too; stacks are unwound by debug information.
    perf record -q -e cpu-clock:u -F 499 --call-graph dwarf,32768 -o "$scratch/perf.data" -- "${render[@]}" >/dev/null
    perf script -i "$scratch/perf.data" --no-inline -F ip,sym,dso >"$scratch/perf.txt" 2>"$scratch/perf.log" ||
      fail "perf script: $(cat "$scratch/perf.log")"
    python3 "$root/bench/profile_rooms.py" --root "$root" --program "$kindling" --perf "$scratch/perf.txt"
    if perf stat -x, -e instructions:u,cycles:u -o "$scratch/stat" -- "${render[@]}" >/dev/null && ! grep -q 'not \(supported\|counted\)' "$scratch/stat"; then
      awk -F, '/instructions/ {n = $1} /cycles/ {c = $1} END {printf "\n%.0f million instructions, %.2f for each cycle\n", n / 1e6, n / c}' \
        "$scratch/stat"
    else
      printf '\nNo counts of instructions: this machine shows no hardware counters. PROFILER=callgrind counts them.\n'
    fi
    ;;
  callgrind)
    valgrind -q --tool=callgrind --callgrind-out-file="$scratch/callgrind.out" --compress-strings=no --compress-pos=no "${render[@]}" >/dev/null
    python3 "$root/bench/profile_rooms.py" --root "$root" --program "$kindling" --callgrind "$scratch/callgrind.out"
    ;;
  *) fail "PROFILER=$profiler: perf or callgrind" ;;
esac
