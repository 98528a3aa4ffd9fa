#!/usr/bin/env python3
"""Checks the PTX of the kernels, and with --ptxas what NVIDIA's assembler makes of it.

usage: check_kernels.py PTX [--ptxas PROGRAM] [--arch sm_90]
Checked are
 - arithmetic: every operation rounds to nearest, none is approximate or flushes denormal numbers; products and sums are
   fused where the triangle test asks for it, nowhere else;
 - symbols: nothing is declared outside, no call is through a pointer, no function calls itself on any way, so the depth
   of the stack is known;
 - stack: the arrays of a kernel and of what it calls, on the deepest way, have at most the bytes of STACK_BYTES.
ptxas (of PyPI's nvidia-cuda-nvcc; minutes) adds registers, and the stack with spilled values; checked are
 - that a driver's linker takes kernels with launch bounds, which compiles functions by themselves;
 - the stack: at most an eighth and 256 bytes above STACK_BYTES;
 - registers: at most those of REGISTERS, so that enough threads fit a multiprocessor.
Exit code 0 if all hold, 1 with a line for each finding."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import functools
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "accel"))
from check_ptx import ARITHMETIC, functions, local_bytes  # noqa: E402

# Bytes of stack by kernel.
STACK_BYTES = {
    "kindling_begin_path": 128,
    "kindling_intersect": 6400,
    "kindling_intersect_opaque": 1024,
    "kindling_shade": 7168,
    "kindling_shade_beside_light_paths": 7168,
    "kindling_shade_beside_photons": 7168,
    "kindling_shade_reused": 7168,
    "kindling_shade_with_manifolds": 14848,
    "kindling_trace_shadow": 7680,
    "kindling_place_kinds": 128,
    "kindling_sort_paths": 128,
    "kindling_trace_shadow_opaque": 1024,
    "kindling_add_shadows": 128,
    "kindling_start_sharing": 128,
    "kindling_link_paths": 2304,
    "kindling_trace_link": 7680,
    "kindling_trace_link_opaque": 1024,
    "kindling_share_light": 128,
    "kindling_receive_light": 128,
    "kindling_finish_pixel": 128,
    "kindling_begin_split": 128,
    "kindling_shade_split": 7168,
    "kindling_split_shadow": 128,
    "kindling_split_tail": 128,
    "kindling_split_shared": 2304,
    "kindling_finish_split_pixel": 256,
    "kindling_begin_light_path": 128,
    "kindling_scatter_light_path": 9728,
    "kindling_scatter_split_light_path": 10752,
    "kindling_begin_photon_path": 128,
    "kindling_leave_photon": 9728,
    "kindling_trace_sight": 6400,
    "kindling_trace_sight_opaque": 1024,
    "kindling_begin_tree": 256,
    "kindling_take_node": 128,
    "kindling_trace_node": 12288,
    "kindling_finish_tree_pixel": 128,
    "kindling_show_first_hit": 6656,
    "kindling_finish_first_hit_pixel": 128,
    "kindling_nearest_hit": 1024,
    "kindling_any_hit": 1024,
}
# Registers of kernels that have few; others take all 255 of a thread.
REGISTERS = {
    "kindling_begin_path": 64,
    "kindling_intersect_opaque": 80,
    "kindling_trace_shadow_opaque": 80,
    "kindling_finish_pixel": 96,
    "kindling_place_kinds": 32,
    "kindling_sort_paths": 32,
    "kindling_add_shadows": 48,
    "kindling_begin_split": 32,
    "kindling_split_shadow": 48,
    "kindling_split_tail": 48,
    "kindling_finish_split_pixel": 128,
    "kindling_begin_light_path": 80,
    "kindling_begin_photon_path": 80,
    "kindling_trace_sight_opaque": 80,
    "kindling_start_sharing": 32,
    "kindling_link_paths": 128,
    "kindling_trace_link_opaque": 80,
    "kindling_share_light": 96,
    "kindling_receive_light": 64,
    "kindling_begin_tree": 64,
    "kindling_take_node": 32,
    "kindling_finish_tree_pixel": 96,
    "kindling_finish_first_hit_pixel": 96,
    "kindling_nearest_hit": 80,
    "kindling_any_hit": 80,
}
# Functions into which the triangle test is compiled, by their names.
TESTS_TRIANGLES = re.compile(r"kd7compact|^kindling_(?:(?:intersect|trace_shadow|trace_sight|trace_link)_opaque|nearest_hit|any_hit)$|9WorldView(?:9probe_hit|16(?:probe|sight)_is_blocked)|compact_(?:probe_hit|(?:probe|sight)_is_blocked)")
CALL = re.compile(r"\bcall(?:\.uni)?\s+(?:\([^)]*\),\s*)?([\w$%]+)")


def findings(ptx, stack_of):
    """A line for each rule that is broken."""
    for operation in sorted(set(ARITHMETIC.findall(ptx))):
        if ".rn." not in operation or ".ftz" in operation:
            yield f"{operation}: arithmetic must round to nearest and keep denormal numbers"
    for name, body in functions(ptx).items():
        if re.search(r"\b(?:fma|mad)\.[a-z0-9.]*f(?:32|64)\b", body) and not TESTS_TRIANGLES.search(name):
            yield f"{name}: has a fused operation, and should not test triangles"
    for word in (".approx", ".ftz", ".callprototype", ".extern"):
        if word in ptx:
            yield f"{word} occurs"
    entries = set(re.findall(r"\.entry\s+([\w$]+)\(", ptx))
    for name in sorted(entries ^ STACK_BYTES.keys()):
        yield f"{name}: is in the PTX or in STACK_BYTES, not in both"
    for name in sorted(entries & STACK_BYTES.keys()):
        if stack_of(name) > STACK_BYTES[name]:
            yield f"{name}: {stack_of(name)} bytes of stack, more than {STACK_BYTES[name]}"


def deepest_stack(bodies):
    """A function: name to bytes of arrays on the deepest way from it. Ends the program where one calls itself."""
    on_the_way = []

    @functools.cache
    def stack_of(name):
        if name in on_the_way:
            sys.exit(f"{name} calls itself: {' '.join(on_the_way)}")
        on_the_way.append(name)
        body = bodies.get(name, "")  # none: declared outside, a finding by itself
        deepest = max((stack_of(called) for called in CALL.findall(body)), default=0)
        on_the_way.pop()
        return local_bytes(body) + deepest

    return stack_of


def assembled(ptxas, arch, ptx):
    """By kernel: registers, bytes of stack and of spilled values."""
    report = subprocess.run([ptxas, f"-arch={arch}", "-v", ptx, "-o", "/dev/null"], check=True, capture_output=True, text=True)
    text = report.stdout + report.stderr
    found = {}
    for part in text.split("Compiling entry function")[1:]:
        name = re.search(r"'(\w+)'", part)[1]
        registers = int(re.search(r"Used (\d+) registers", part)[1])
        stack = re.search(r"(\d+) bytes cumulative stack size", part)
        found[name] = (registers, int(stack[1]) if stack else 0)
    return found


def refused_by_linkers(ptxas, arch, ptx):
    """ptxas's errors where it compiles functions by themselves, with the registers of max_registers() (ptx_modules.h)."""
    bounds = re.findall(r"\.maxntid (\d+), 1, 1\s+\.minnctapersm (\d+)", ptx.read_text(encoding="utf-8"))
    for threads, blocks in sorted(set(bounds)):
        registers = 65536 // (int(threads) * int(blocks)) // 8 * 8
        result = subprocess.run([ptxas, f"-arch={arch}", "-c", "--maxrregcount", str(registers), ptx, "-o", "/dev/null"],
                                check=False, capture_output=True, text=True)
        yield from (line for line in (result.stdout + result.stderr).splitlines() if "error" in line)


def findings_of_ptxas(found):
    """A line for each kernel that takes more registers or stack than it may; `found` from assembled()."""
    for name in sorted(STACK_BYTES.keys() - found.keys()):
        yield f"{name}: ptxas did not report it"
    for name, (registers, stack) in sorted(found.items()):
        if registers > REGISTERS.get(name, 255):
            yield f"{name}: {registers} registers, more than {REGISTERS[name]}"
        max_stack = STACK_BYTES[name] * 9 // 8 + 256
        if stack > max_stack:
            yield f"{name}: {stack} bytes of stack with spilled values, more than {max_stack}"


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("ptx", type=pathlib.Path)
    parser.add_argument("--ptxas")
    parser.add_argument("--arch", default="sm_90")
    arguments = parser.parse_args()
    ptx = arguments.ptx.read_text(encoding="utf-8")
    bodies = functions(ptx)
    stack_of = deepest_stack(bodies)
    found = list(findings(ptx, stack_of))
    by_ptxas = {}
    if arguments.ptxas:
        by_ptxas = assembled(arguments.ptxas, arguments.arch, arguments.ptx)
        found += [*findings_of_ptxas(by_ptxas), *refused_by_linkers(arguments.ptxas, arguments.arch, arguments.ptx)]
    print("| kernel | arrays on the stack, bytes | registers | stack with spills, bytes |\n|---|---|---|---|")
    for name in [name for name in STACK_BYTES if name in bodies]:
        registers, stack = by_ptxas.get(name, ("", ""))
        print(f"| {name.removeprefix('kindling_')} | {stack_of(name)} | {registers} | {stack} |")
    for line in found:
        print(line, file=sys.stderr)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
