# Bare Debian systems in folders, for the tests here; sourced after cmake/setup.sh.
# SPDX-License-Identifier: Apache-2.0

root=
# Removes the root at the end; nothing is mounted in it by then.
remove_root() {
  [ -z "$root" ] || rm -rf --one-file-system "$root"
}

# make_root SUITE [PACKAGE...]: a minimal system of that suite with these packages; its folder is
# $root.
make_root() {
  local suite=$1
  shift
  [ "$(id -u)" -eq 0 ] || fail "a bare root needs root"
  command -v mmdebstrap >/dev/null || fail "mmdebstrap is not installed"
  root=$(mktemp -d)
  trap remove_root EXIT
  chmod 755 "$root"
  local include=ca-certificates
  local package
  for package in "$@"; do include+=,$package; done
  # Lists of a mirror that lags behind have expired.
  mmdebstrap --quiet --variant=minbase --aptopt='Acquire::Check-Valid-Until "false"' --include="$include" "$suite" "$root" || fail "mmdebstrap could not make a root of $suite (its message is above)"
}

in_root() {
  chroot "$root" "$@"
}
