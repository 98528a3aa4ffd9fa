#!/usr/bin/env bash
# Compares the bits of hot functions between the compilers of a newer Debian, in the long form.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/setup.sh"
source "$kindling_root/tests/package/roots.sh"
usage='usage: newer_compilers.sh SUITE COMPILER [NAME]...
SUITE is trixie (Debian 13), forky or sid, COMPILER its package with the newer g++ (g++-14). NAME is a folder of tests with a
program NAME_hashes.cpp; all of them without. First the hashes stored here, then a million inputs for each function, by
COMPILER, g++-12 and clang++-19: tests/base/compare_compilers.py.'
[ $# -ge 2 ] || fail "$usage"
case $1 in
  trixie | forky | sid) ;;
  *) fail "$usage" ;;
esac
suite=$1
compiler=$2
shift 2
names=("$@")
[ $# -gt 0 ] || mapfile -t names < <(cd "$kindling_root/tests" && printf '%s\n' */*_hashes.cpp | cut -d/ -f1)

say "Making a Debian $suite with $compiler"
make_root "$suite" "$compiler" g++-12 clang-19 python3 libimath-dev
mkdir "$root/kindling"
(cd "$kindling_root" && git ls-files -z | tar --null --files-from=- --create) | tar -x -C "$root/kindling"

failed=()
for name in "${names[@]}"; do
  source=(tests/"$name"/*_hashes.cpp)
  for all in 0 1; do
    say "$(date +%T) $name, $([ $all = 1 ] && printf 'a million inputs' || printf 'stored hashes')"
    # The script asks /proc for the processor's vector units; the mount ends with the command.
    # shellcheck disable=SC2016
    unshare --mount sh -c 'mount --rbind /proc "$1/proc" && chroot "$1" sh -c "cd /kindling && KINDLING_ALL_FLOATS=$2 python3 tests/base/compare_compilers.py . $3 $4 /usr/include/Imath"' \
      sh "$root" "$all" "${source[0]#"$kindling_root"/}" "$compiler" || failed+=("$name")
  done
done
[ ${#failed[@]} -eq 0 ] || fail "results depend on the compiler: ${failed[*]}"
say "The compilers of Debian $suite agree"
