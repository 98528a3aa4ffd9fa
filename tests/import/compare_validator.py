#!/usr/bin/env python3
"""Compares strict loads with Khronos' glTF validator, which get_validator.sh installs.

    compare_validator.py LOAD_CHECK VALIDATOR [--slips WRITE_SLIPS] [--table] PATH...

VALIDATOR is the folder of the npm package, PATH a file or a folder. WRITE_SLIPS writes the corpus of slips, which is compared as well.
Fails if a strict load accepts a file with errors that check_assets.py does not list as harmless, or refuses one without errors for a
reason that is not listed below. --table prints the files by outcome, and the codes and reasons of all differences.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import check_assets

# Reasons of a strict load to refuse what the validator accepts or only warns about, by its message.
STRICTER = {
    "a required extension that Kindling does not support": r"is required but not supported",
    "a required extension without which Kindling shows something else": r"is required, but",
    "data that no buffer has": r"\(BUFFER_MISSING_GLB_DATA\)",
    "a word that glTF does not define (a warning of the validator)": r"\(VALUE_NOT_IN_LIST\)",
    "a number that no double holds": r"number overflow",
    "a version above 2.0": r"\(UNKNOWN_ASSET_MAJOR_VERSION\)",
    "a field of view of pi or more (a warning of the validator)": r"\(CAMERA_YFOV_GEQUAL_PI\)",
}


def validate(validator, files):
    """The messages of the validator for each file."""
    script = Path(__file__).with_name("validate.mjs")
    done = subprocess.run(["node", str(script), str(validator), *files], capture_output=True, text=True, timeout=20 + 2 * len(files), check=False)
    lines = done.stdout.splitlines()
    if done.returncode != 0 or len(lines) != len(files):
        sys.exit(f"the validator stopped after {len(lines)} of {len(files)} files with exit code {done.returncode}: {done.stderr[-2000:]}")
    return [json.loads(line)["messages"] for line in lines]


def scenes_of(paths):
    for path in map(Path, paths):
        yield from sorted(f for f in path.rglob("*") if f.suffix in (".gltf", ".glb")) if path.is_dir() else [path]


def compare(load_check, validator, files):
    """Returns the numbers of files by outcome, the differences by reason, and the problems."""
    outcomes, differences, problems = Counter(), Counter(), []
    strict = check_assets.run(load_check, files)
    for file, line, messages in zip(files, strict, validate(validator, files)):
        errors = [message for message in messages if message["severity"] == 0]
        accepted = line.startswith("OK ")
        outcomes[accepted, not errors] += 1
        if accepted:
            differences.update({"accepted: " + message["code"] for message in errors})
            known = any(file.endswith(name) for name in check_assets.HARMLESS_FILES)
            bad = sorted({message["code"] for message in errors if not known and not check_assets.is_harmless(message)})
            if bad:
                problems.append(f"{file}: accepted although {', '.join(bad)}")
        elif not errors:
            reason = next((name for name, pattern in STRICTER.items() if re.search(pattern, line)), None)
            differences.update(["refused: " + (reason or line)])
            if reason is None:
                problems.append(f"{file}: refused although the validator finds no error: {line}")
    return outcomes, differences, problems


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("load_check")
    parser.add_argument("validator")
    parser.add_argument("paths", nargs="+", metavar="PATH")
    parser.add_argument("--slips", metavar="WRITE_SLIPS")
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = list(options.paths)
        if options.slips:
            subprocess.run([options.slips, folder], check=True, stdout=subprocess.DEVNULL)
            paths.append(folder)
        files = [os.fspath(file) for file in scenes_of(paths)]
        if not files:
            sys.exit(f"no .gltf or .glb in {', '.join(paths)}")
        outcomes, differences, problems = compare(options.load_check, options.validator, files)
    print(f"{len(files)} files: {outcomes[True, True]} accepted by both, {outcomes[False, False]} refused by both, "
          f"{outcomes[True, False]} only accepted by a strict load, {outcomes[False, True]} only accepted by the validator")
    for name, count in sorted(differences.items()) if options.table else []:
        print(f"{count:5} {name}")
    for problem in problems:
        print("PROBLEM", problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
