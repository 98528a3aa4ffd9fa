#!/usr/bin/env python3
"""Compiles each source by itself without precompiled headers, which finds missing includes.

usage: compile_alone.py BUILD_FOLDER [--share K/N] [--jobs N]
BUILD_FOLDER is configured with the preset `alone`. Only the syntax is checked, nothing is written. Generated sources, in
the build folder, are left out. --share takes every N-th source, so that N runs check all of them. Exit code 0 if all compile, 1 with the compiler's errors, 2 on bad usage.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path


def parse_share(text):
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    if not match or not 1 <= int(match[1]) <= int(match[2]):
        raise argparse.ArgumentTypeError(f"'{text}' is no share; use K/N with K from 1 to N")
    return int(match[1]), int(match[2])


def sources_of(database, build):
    """The commands of a database, without those of generated sources, which need not exist."""
    generated = build.resolve()
    return [command for command in json.loads(database.read_text(encoding="utf-8"))
            if generated not in Path(command["directory"], command["file"]).resolve().parents]


def check_syntax(command):
    """The compiler's output if the source does not compile, else an empty text."""
    words = shlex.split(command["command"])
    if "-o" in words:
        words[words.index("-o") + 1] = os.devnull
    result = subprocess.run([*words, "-fsyntax-only", "-O0"], cwd=command["directory"], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    return result.stderr if result.returncode != 0 else ""


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--share", type=parse_share, default=(1, 1))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args(arguments)
    database = options.build / "compile_commands.json"
    if not database.is_file():
        parser.error(f"{database} does not exist; run: cmake --preset alone")
    if subprocess.run(["cmake", "--build", options.build, "--target", "kindling_sources_hash"], stdout=subprocess.DEVNULL).returncode != 0:
        return 1
    first, step = options.share
    commands = sorted(sources_of(database, options.build), key=lambda command: command["file"])[first - 1::step]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for errors in pool.map(check_syntax, commands):
            if errors:
                failed += 1
                print(errors, file=sys.stderr)
    print(f"{len(commands)} sources compiled by themselves, {failed} of them failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
