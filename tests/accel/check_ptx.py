#!/usr/bin/env python3
"""Compiles a source for NVIDIA GPUs by clang alone and looks through the PTX.

usage: check_ptx.py CLANG ROOT SOURCE [INCLUDE]...
CLANG is clang++-19, ROOT the repository, SOURCE a file with entry points (extern "C", [[clang::nvptx_kernel]]), INCLUDE
folders of headers. No CUDA toolkit is needed: the headers are those of the host. Checked are
 - arithmetic: every operation rounds to nearest, none is approximate or flushes denormal numbers;
 - fused operations: only those that the source asks for. A second compilation replaces __builtin_fmaf by a product and
   a sum, and must contain none;
 - symbols: nothing is declared outside, and every call is to a function of the file;
 - local memory: each function has at most MAX_LOCAL_BYTES of arrays and spilled values.
Exit code 0 if all hold, 1 with a line for each finding, 2 if it does not compile."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import re
import subprocess
import sys
import tempfile

# The stacks of accel/kdtree/compact, 256 and 360 bytes, and one word of padding each.
MAX_LOCAL_BYTES = 640
FLAGS = ["--target=nvptx64-nvidia-cuda", "-Xclang", "-target-cpu", "-Xclang", "sm_70", "-O3", "-std=c++20", "-ffp-contract=off", "-fno-exceptions",
         "-fno-rtti", "-DNDEBUG", "-Wall", "-Wextra", "-Werror", "-S"]
# The host's C library asks for its processor. <iostream>, which Imath includes, has global objects;
# its parts have none.
HOST = ["-D__x86_64__", "-D_GNU_SOURCE", "-D_GLIBCXX_IOSTREAM", "-include", "istream"]
WITHOUT_FMA = ["-D__builtin_fmaf(a,b,c)=((a)*(b)+(c))"]
ARITHMETIC = re.compile(r"^\s*(?:@!?%p\d+ )?((?:add|sub|mul|mad|fma|div|rcp|sqrt|rsqrt|sin|cos|tanh|ex2|lg2)\.[a-z0-9.]*f(?:16|32|64))\b", re.M)


def host_includes(clang):
    """Options for the folders that the host's compiler searches."""
    report = subprocess.run([clang, "-E", "-x", "c++", "-v", "-"], input="", check=True, capture_output=True, text=True).stderr
    folders = report.split("search starts here:")[-1].split("End of search list")[0].split("\n")[1:]
    return ["-nostdinc"] + [word for folder in folders if folder.strip() for word in ("-isystem", folder.strip())]


def compile_ptx(clang, root, source, includes, more=()):
    with tempfile.TemporaryDirectory() as folder:
        ptx = pathlib.Path(folder) / "out.ptx"
        libraries = [word for path in includes for word in ("-isystem", path)]
        command = [clang, *FLAGS, *HOST, *more, *host_includes(clang), *libraries, "-I", root, source, "-o", str(ptx)]
        if subprocess.run(command, check=False).returncode != 0:
            sys.exit(2)
        return ptx.read_text(encoding="utf-8")


def functions(ptx):
    """The body of each function, entry points among them, by name."""
    return {match[1]: match[2] for match in re.finditer(r"\.(?:func|entry)\s[^{};]*?([\w$]+)\([^{};]*\)[^{};]*\n\{(.*?)^\}", ptx, re.M | re.S)}


def local_bytes(body):
    return sum(int(size) for size in re.findall(r"\.local .*__local_depot\d+\[(\d+)\]", body))


def findings(ptx, ptx_without_fma):
    """A line for each rule that is broken."""
    operations = ARITHMETIC.findall(ptx)
    for operation in sorted(set(operations)):
        if ".rn." not in operation or ".ftz" in operation:
            yield f"{operation}: arithmetic must round to nearest and keep denormal numbers"
    for word in (".approx", ".ftz"):
        if word in ptx:
            yield f"{word} occurs"
    if not any(operation.startswith("fma.") for operation in operations):
        yield "there is no fma, although the triangle test asks for it: is this the right source?"
    if re.search(r"\bfma\.", ptx_without_fma):
        yield "the compiler fuses products and sums by itself"
    for line in re.findall(r"^\.extern.*|^\s*\.callprototype.*|.*: \.callprototype.*", ptx, re.M):
        yield f"refers to the outside, or to unknown functions: {line.strip()}"
    bodies = functions(ptx)
    if len(re.findall(r"\.visible \.entry ", ptx)) == 0 or len(bodies) != len(re.findall(r"^\}", ptx, re.M)):
        yield "the file has no entry points, or functions that this script does not find"
    for name, body in bodies.items():
        for called in re.findall(r"\bcall(?:\.uni)?\s+(?:\([^)]*\),\s*)?([\w$%]+)", body):
            if called not in bodies:
                yield f"{name} calls {called}, which is not in the file"
        if local_bytes(body) > MAX_LOCAL_BYTES:
            yield f"{name} has {local_bytes(body)} bytes of local memory, more than {MAX_LOCAL_BYTES}"


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    clang, root, source, *includes = sys.argv[1:]
    ptx = compile_ptx(clang, root, source, includes)
    found = list(findings(ptx, compile_ptx(clang, root, source, includes, WITHOUT_FMA)))
    for name, body in functions(ptx).items():
        print(f"{name}: {local_bytes(body)} bytes of local memory, {len(re.findall(r';$', body, re.M))} lines")
    for line in found:
        print(line, file=sys.stderr)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
