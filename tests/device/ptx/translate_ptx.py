#!/usr/bin/env python3
"""Translates PTX to C++ that executes it, instruction by instruction.

usage: translate_ptx.py PTX FOLDER PARTS
FOLDER gets tables.cpp with the variables and the entry points, and part_0.cpp to part_(PARTS - 1).cpp with the functions,
each of which stays in its part as long as it keeps its name. machine.h has the memory of a thread, operations.h what
instructions compute; an instruction that is neither there nor in translate_function.py is an error with its text.
Exit code 0, or 1 with a line for what is not known."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import sys
import zlib

from ptx_text import Memory, PtxError, parse
from translate_function import FunctionWriter, cpp_name

HEAD = """// Made by translate_ptx.py.
#include "tests/device/ptx/machine.h"
#include "tests/device/ptx/operations.h"

using namespace ptx;
"""


def declaration(symbol):
    """Of a Function or of a variable, as a Memory, which is aligned as in the PTX and no better."""
    if isinstance(symbol, Memory):
        return f"u8 {cpp_name(symbol.name)} alignas({symbol.align})[{symbol.size}]"
    memory = [f"char* {cpp_name(one.name)}" for one in symbol.results + symbol.parameters]
    return f"void {cpp_name(symbol.name)}({', '.join(['Thread& t', *memory])})"


def part(functions, symbols):
    """The text of functions, with declarations of what they refer to."""
    mentioned, texts = set(), []
    for function in functions:
        writer = FunctionWriter(function, symbols.keys())
        texts.append(writer.text(declaration(function)))
        mentioned |= writer.mentioned
    return HEAD + "\n".join([*(f"extern {declaration(symbols[name])};" for name in sorted(mentioned)), *texts])


def tables(variables, functions):
    """Definitions of the variables, and the lists of them and of the entry points."""
    entries = [one for one in functions if one.is_entry]
    for one in entries:
        if [memory.size for memory in one.parameters] != [8, 4]:
            raise PtxError(f"{one.name}: entry points have an address and a number as parameters")
    lines = [HEAD] + [f"{declaration(one)} = {{{one.values or 0}}};" for one in variables]
    lines += [f"{declaration(one)};" for one in entries]
    rows = ", ".join(f"{{u64({cpp_name(one.name)}), {one.size}}}" for one in variables)
    lines.append(f"extern const std::vector<Region> ptx_variables{{{rows}}};")
    rows = ", ".join(f'{{"{one.name}", {one.max_threads}, {cpp_name(one.name)}}}' for one in entries)
    lines.append(f"extern const std::vector<Entry> ptx_entries{{{rows}}};")
    return "\n".join(lines) + "\n"


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    folder, count = pathlib.Path(sys.argv[2]), int(sys.argv[3])
    try:
        variables, functions = parse(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
        symbols = {one.name: one for one in variables + functions}
        parts = [[] for _ in range(count)]
        for one in functions:
            parts[zlib.crc32(one.name.encode()) % count].append(one)
        files = {f"part_{number}.cpp": part(some, symbols) for number, some in enumerate(parts)}
        files["tables.cpp"] = tables(variables, functions)
    except PtxError as error:
        sys.exit(f"{sys.argv[1]}: {error}")
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
