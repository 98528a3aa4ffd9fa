#!/usr/bin/env bash
# Installs the .deb in a bare Debian 12 as cmake/Dockerfile does, and runs it.
# SPDX-License-Identifier: Apache-2.0
source "$(dirname "${BASH_SOURCE[0]}")/../../cmake/setup.sh"
source "$kindling_root/tests/package/roots.sh"
[ $# -eq 1 ] && [ -f "$1" ] || fail "usage: package_test.sh FILE.deb"
deb=$(realpath "$1")

make_root bookworm
cp "$deb" "$root/tmp/"
say "Installing $(basename "$deb") in a bare Debian 12"
install=$(sed -n 's/^RUN //p' "$kindling_root/cmake/Dockerfile")
in_root env DEBIAN_FRONTEND=noninteractive sh -c "$install" >"$root/install.log" 2>&1 || {
  cat "$root/install.log"
  fail "the package could not be installed"
}

say "Running it"
version=$(in_root kindling --version | head -n 1)
[ "$version" = "kindling $(sed -n 's/^project(kindling VERSION \([0-9.]*\).*/\1/p' "$kindling_root/CMakeLists.txt")" ] ||
  fail "kindling --version begins with '$version'"
scene=/usr/share/kindling/scenes/cornell_box.glb
in_root kindling render $scene --size 64x64 --spp 4 -o /tmp/a.png -o /tmp/a.exr -o /tmp/a.jpg --quiet >/dev/null
for file in a.png a.exr a.jpg; do [ -s "$root/tmp/$file" ] || fail "no $file was rendered"; done
# The module with OpenImageIO is found where the package put it.
in_root kindling render $scene --size 16x16 --spp 1 --texture-memory 16M -o /tmp/b.png --quiet >/dev/null
in_root kindling shootout $scene --rays-per-kind 256 --repeat 1 --build-repeat 1 --quiet >/dev/null

say "Opening the page of its view"
chroot "$root" kindling view $scene --port 0 --size 64x36 --spp 1 >"$root/view.link" 2>"$root/view.log" &
view=$!
trap 'kill $view 2>/dev/null; remove_root' EXIT
for _ in $(seq 100); do [ -s "$root/view.link" ] && break || sleep 0.2; done
link=$(head -n 1 "$root/view.link")
[ -n "$link" ] || fail "kindling view printed no link: $(cat "$root/view.log")"
# The page, with its token, a file that it names, and the first image.
python3 - "$link" <<'END' || fail "kindling view does not serve its page"
import sys, time, urllib.error, urllib.request

link = sys.argv[1].rstrip("/") + "/"
def get(name):
    with urllib.request.urlopen(link + name, timeout=30) as response:
        return response.read()
assert b"<title>Kindling</title>" in get(""), "no page"
assert b"import" in get("main.js"), "no script"
for _ in range(50):
    if b"\xff\xd8\xff" in get("frame?after=0&image=0"):
        break
    time.sleep(0.2)
else:
    raise AssertionError("no image")
try:
    urllib.request.urlopen(link[:-33] + "0" * 32 + "/", timeout=30)
except urllib.error.HTTPError as error:
    assert error.code == 403, error
else:
    raise AssertionError("a wrong token is accepted")
END
kill $view
code=0
wait $view || code=$?
[ "$code" -eq 143 ] || fail "kindling view ended with $code instead of 143"
trap remove_root EXIT

say "Looking at its documentation"
in_root sh -c 'zcat /usr/share/man/man1/kindling.1.gz' | grep -q '^\.SH EXIT STATUS' || fail "there is no manual page"
in_root bash -c 'source /usr/share/bash-completion/completions/kindling
  COMP_WORDS=(kindling render --noise-t); COMP_CWORD=2; _kindling; [ "${COMPREPLY[*]}" = --noise-threshold ]' || fail "bash does not complete"
[ -s "$root/usr/share/zsh/vendor-completions/_kindling" ] || fail "there is no completion for zsh"
[ -s "$root/usr/share/doc/kindling/copyright" ] || fail "there is no copyright file"

if command -v qemu-x86_64-static >/dev/null; then
  say "Running it on a processor of 2008"
  message=$(qemu-x86_64-static -cpu Nehalem -L "$root" "$root/usr/bin/kindling" --version 2>&1) && fail "it ran"
  [[ $message == *"kindling: error: this processor lacks "*AVX2*"compiled for x86-64-v3"* ]] || fail "it printed: $message"
  [ "$(wc -l <<<"$message")" -eq 1 ] || fail "it printed more than a line: $message"
fi
say "The package works"
