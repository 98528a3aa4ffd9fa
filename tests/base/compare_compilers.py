#!/usr/bin/env python3
"""Compiles a program that prints hashes with every installed compiler and compares the output.

usage: [KINDLING_ALL_FLOATS=1] compare_compilers.py ROOT SOURCE COMPILER [--few] [--write] [INCLUDE]...
ROOT is the repository, SOURCE a program in it (tests/.../NAME.cpp) that needs no library, COMPILER that of the build.
Others are taken where they are installed: g++ and clang++ of several versions, and g++ for arm64, whose program
qemu-user-static runs. The results must be those of NAME.txt beside the source; --write stores those of COMPILER
there. One more program ends where a float is cast to an integer type that does not reach so far. --few: COMPILER, the
newest clang++ and arm64 only. INCLUDE: folders of headers. KINDLING_ALL_FLOATS=1 is the long form: a million inputs for
each function, all compilers, and results are compared with those of COMPILER."""
# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile

FLAGS = ["-std=c++20", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Wno-psabi"]
LEVELS = [["-O0"], ["-O2"], ["-O3", "-fno-math-errno", "-fno-trapping-math"]]
# The program ends at undefined casts, so that it needs no run-time library.
CASTS = ["-O1", "-fsanitize=float-cast-overflow", "-fsanitize-undefined-trap-on-error"]
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


def hashes(source, includes, folder, compiler, flags, emulator=(), inputs=()):
    program = folder / "hashes"
    subprocess.run([compiler, *FLAGS, *flags, *includes, source, "-o", program], check=True)
    done = subprocess.run([*emulator, program, *inputs], check=False, capture_output=True, text=True)
    if done.returncode != 0:
        return f"the program ended with code {done.returncode}: {done.stderr.strip()}\n"
    return done.stdout


def variants(own, few):
    """(compiler, flags, emulator) of all programs."""
    x86 = platform.machine() == "x86_64"
    levels = LEVELS + (X86_LEVELS if x86 and runs_avx2() else [])
    own, *others = compilers(own)
    if few:
        others = [c for c in others if "clang" in pathlib.Path(c).name][-1:]
    for level in levels[1::2] if few else levels:
        yield own, level, ()
    yield own, CASTS, ()
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
        long_form = os.environ.get("KINDLING_ALL_FLOATS") == "1"
        inputs = ["1000000"] if long_form else []
        if "--write" in sys.argv:
            stored.write_text(hashes(source, includes, folder, own, LEVELS[1]), encoding="utf-8")
        expected = hashes(source, includes, folder, own, LEVELS[1], (), inputs) if long_form else stored.read_text(encoding="utf-8")
        failed = False
        for compiler, flags, emulator in variants(own, "--few" in sys.argv and not long_form):
            found = hashes(source, includes, folder, compiler, flags, emulator, inputs)
            differing = [line for line in found.splitlines() if line not in expected.splitlines()]
            same = found == expected
            print(f"{compiler} {' '.join(flags)}: {'same bits' if same else 'other bits: ' + '; '.join(differing)}", flush=True)
            failed = failed or not same
    sys.exit("results depend on the compiler" if failed else 0)


if __name__ == "__main__":
    main()
