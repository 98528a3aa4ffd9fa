#!/usr/bin/env python3
"""Counts what kernels execute in a render, by their PTX, and models an H100.

usage: count_instructions.py KINDLING DRIVER SCENE [flags of render]
DRIVER is libptx_counted.so (cmake --build build/release --target ptx_counted). Prints a line for each kernel, of all
samples together: threads for each sample, and for each thread its instructions, the share of a warp's lanes that are
active, and bytes of global and of local memory, loaded and stored. The last two columns are bounds for an H100, in
nanoseconds for each sample: 132 multiprocessors issue 4 instructions of warps at 1.7 GHz, and memory moves 3.35 TB/s.
Each access counts as one of memory, as if there were no caches; each PTX instruction counts as one of the processor,
although a division takes a dozen. Nothing is measured."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ISSUED_PER_NS = 132 * 4 * 1.7
BYTES_PER_NS = 3350.0


def counts_of(kindling, driver, scene, flags):
    """Samples, and a list of kernels with their eight counts (count_steps.h)."""
    with tempfile.TemporaryDirectory() as folder:
        places = {"KINDLING_CUDA_DRIVER": driver, "PTX_COUNTS": f"{folder}/counts", "XDG_CACHE_HOME": folder}
        command = [kindling, "render", scene, "--device", "gpu", "-o", f"{folder}/image.exr", "--stats", f"{folder}/stats.json", "--quiet", *flags]
        subprocess.run(command, check=True, env=os.environ | places, stdout=subprocess.DEVNULL)
        lines = [line.split() for line in pathlib.Path(f"{folder}/counts").read_text(encoding="utf-8").splitlines()]
        stats = json.loads(pathlib.Path(f"{folder}/stats.json").read_text(encoding="utf-8"))
    return stats["rays"]["camera"], [(name, *map(int, values)) for name, *values in lines]


def rows(samples, counts):
    """A row for each kernel, the one with the largest bounds first."""
    found = []
    for name, _, threads, instructions, issued, *memory in counts:
        if threads == 0:
            continue
        share = instructions / (32 * issued)
        issue_ns, memory_ns = issued / samples / ISSUED_PER_NS, sum(memory) / samples / BYTES_PER_NS
        each = [value / threads for value in memory]
        cells = [f"`{name.removeprefix('kindling_')}`", f"{threads / samples:.2f}", f"{instructions / threads:,.0f}", f"{share:.0%}"]
        cells += [f"{value:,.0f}" for value in each] + [f"{issue_ns:.3f}", f"{memory_ns:.3f}"]
        found.append((max(issue_ns, memory_ns), cells))
    return [cells for _, cells in sorted(found, reverse=True)]


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    kindling, driver, scene, *flags = sys.argv[1:]
    print("| kernel | threads per sample | instructions | active lanes | global: loaded | stored | local: loaded | stored | issue, ns | memory, ns |")
    print("|---" * 10 + "|")
    for cells in rows(*counts_of(kindling, driver, scene, flags)):
        print(f"| {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
