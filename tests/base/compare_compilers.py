#!/usr/bin/env python3
"""Compiles a program that prints hashes with every installed compiler and compares the output.

usage: compare_compilers.py ROOT SOURCE COMPILER [--few] [--write] [INCLUDE]...
ROOT is the repository, SOURCE a program in it (tests/.../NAME.cpp) that needs no library, COMPILER that of the build.
Others are taken where they are installed: g++ and clang++ of several versions, and g++ for arm64, whose program
qemu-user-static runs. The results must be those of NAME.txt beside the source; --write stores those of COMPILER
there. --few: COMPILER, the newest clang++ and arm64 only. INCLUDE: folders of headers."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile

FLAGS = ["-std=c++20", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
LEVELS = [["-O0"], ["-O2"], ["-O3", "-fno-math-errno", "-fno-trapping-math"]]
# Vector units, and a fused multiply-add that must not be used.
X86_LEVELS = [["-O3", "-fno-math-errno", "-fno-trapping-math", "-march=x86-64-v3"]]
NEWER = [f"g++-{n}" for n in range(11, 17)] + [f"clang++-{n}" for n in range(14, 22)] + ["g++", "clang++"]


def compilers(own):
    """Each different compiler once: the path of its program, that of the build first."""
    found = {}
    for name in [own, *NEWER]:
        path = shutil.which(name)
        if path:
            found.setdefault(pathlib.Path(path).resolve(), path)
    return list(found.values())


def runs_avx2():
    try:
        return "avx2" in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return False


def hashes(source, includes, folder, compiler, flags, emulator=()):
    program = folder / "hashes"
    subprocess.run([compiler, *FLAGS, *flags, *includes, source, "-o", program], check=True)
    return subprocess.run([*emulator, program], check=True, capture_output=True, text=True).stdout


def variants(own, few):
    """(compiler, flags, emulator) of all programs."""
    x86 = platform.machine() == "x86_64"
    levels = LEVELS + (X86_LEVELS if x86 and runs_avx2() else [])
    own, *others = compilers(own)
    if few:
        others = [c for c in others if "clang" in pathlib.Path(c).name][-1:]
    for level in levels[1::2] if few else levels:
        yield own, level, ()
    for compiler in others:
        for level in levels[2:3] if few else levels[1::2]:
            yield compiler, level, ()
    cross, emulator = shutil.which("aarch64-linux-gnu-g++"), shutil.which("qemu-aarch64-static")
    if x86 and cross and emulator:
        yield cross, ["-O2", "-static"], (emulator,)


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    root, source, own = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[1]) / sys.argv[2], sys.argv[3]
    # Headers of the C library last: those of a cross compiler come first.
    include_after = [word for path in sys.argv[4:] if not path.startswith("--") for word in ("-idirafter", path)]
    includes = ["-I", root, *include_after]
    stored = source.with_suffix(".txt")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if "--write" in sys.argv:
            stored.write_text(hashes(source, includes, folder, own, LEVELS[1]), encoding="utf-8")
        expected = stored.read_text(encoding="utf-8")
        failed = False
        for compiler, flags, emulator in variants(own, "--few" in sys.argv):
            found = hashes(source, includes, folder, compiler, flags, emulator)
            differing = [line for line in found.splitlines() if line not in expected.splitlines()]
            same = found == expected
            print(f"{compiler} {' '.join(flags)}: {'same bits' if same else 'other bits: ' + '; '.join(differing)}", flush=True)
            failed = failed or not same
    sys.exit("results depend on the compiler" if failed else 0)


if __name__ == "__main__":
    main()
