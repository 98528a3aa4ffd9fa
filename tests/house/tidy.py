#!/usr/bin/env python3
"""Runs clang-tidy over changed sources and a rotating share of the others, for a limited time.

usage: tidy.py BUILD_FOLDER [--since COMMIT] [--share K/N] [--seconds S] [--jobs N] [FILE...]
BUILD_FOLDER is configured with the preset `alone`. Checked are, in this order, the FILEs, sources
that changed since COMMIT (for a header its own source, else one that includes it) and every N-th
source, so that N runs check all of them. No source is begun after S seconds (150); those left out
are counted. The checks are those of .clang-tidy; each warning is an error. Exit code 0 if nothing
was found, 1 with clang-tidy's messages, 2 on bad usage.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from compile_alone import parse_share

PROGRAMS = ("clang-tidy-14", "clang-tidy")  # Debian 12 has version 14; others find other things


def changed_files(root, commit):
    """Paths from the root of files that differ from a commit; none, with a note, if the commit is unknown (a shallow clone)."""
    result = subprocess.run(["git", "-C", root, "diff", "--name-only", "--diff-filter=d", commit], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        print(f"tidy.py: commit {commit} is not known here; its changes are not checked", file=sys.stderr)
        return []
    return result.stdout.split("\n")[:-1]


def source_for(path, sources, root):
    """The source that checks a file: itself, for a header its own source or the first one that includes it; None if there is none.

    `sources`: paths from the root that have a compile command."""
    if path in sources:
        return path
    if not path.endswith(".h"):
        return None
    own = path[:-2] + ".cpp"
    if own in sources:
        return own
    include = f'#include "{path}"'
    near = sorted(sources, key=lambda source: (Path(source).parent != Path(path).parent, source))
    return next((source for source in near if include in (root / source).read_text(encoding="utf-8", errors="replace")), None)


def choose(files, changed, share, sources, root):
    """The sources to check, each once: given and changed files first, then the share. Tables of data are left out."""
    first, step = share or (1, 0)
    wanted = [source_for(path, sources, root) for path in [*files, *changed]]
    wanted += sorted(sources)[first - 1::step] if step else []
    return [source for source in dict.fromkeys(wanted) if source and not source.endswith("_tables.cpp")]


def check(program, build, source, deadline):
    """(source, messages, finished); a source whose turn comes after the deadline is not checked."""
    if time.monotonic() > deadline:
        return source, "", False
    result = subprocess.run([program, "-p", build, "--quiet", "--warnings-as-errors=*", source], capture_output=True, text=True,
                            stdin=subprocess.DEVNULL, check=False)
    # Its counts of suppressed warnings go to standard error, and so do its own failures.
    failed = result.returncode != 0
    return source, result.stdout + (result.stderr if not result.stdout.strip() else "") if failed else "", True


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("files", nargs="*", metavar="FILE", help="path from the root of the repository")
    parser.add_argument("--since", metavar="COMMIT")
    parser.add_argument("--share", type=parse_share)
    parser.add_argument("--seconds", type=float, default=150.0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parents[2], help=argparse.SUPPRESS)
    parser.add_argument("--program", default=next(filter(shutil.which, PROGRAMS), None), help="clang-tidy (clang-tidy-14)")
    options = parser.parse_intermixed_args(arguments)
    database = options.build / "compile_commands.json"
    if not database.is_file():
        parser.error(f"{database} does not exist; run: cmake --preset alone")
    if options.program is None:
        parser.error(f"none of {', '.join(PROGRAMS)} is installed (Debian: clang-tidy)")
    if not options.files and not options.since and not options.share:
        options.share = (1, 1)
    root = options.root.resolve()
    commands = json.loads(database.read_text(encoding="utf-8"))
    sources = {os.path.relpath(command["file"], root) for command in commands}
    sources = {source for source in sources if not source.startswith(("..", "build" + os.sep))}
    changed = changed_files(root, options.since) if options.since else []
    chosen = choose(options.files, changed, options.share, sources, root)
    deadline = time.monotonic() + options.seconds
    failed = left = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for source, messages, finished in pool.map(lambda s: check(options.program, options.build, root / s, deadline), chosen):
            left += not finished
            if messages:
                failed += 1
                print(f"{source}:\n{messages}", file=sys.stderr)
    late = f", {left} left out after {options.seconds:g} s" if left else ""
    print(f"clang-tidy: {len(chosen) - left} sources checked, {failed} with findings{late}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
