#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes of this folder; with --check compares them with the generator's output."""
import argparse
import pathlib
import sys

sys.dont_write_bytecode = True  # a checkout stays as it is

from generator import broken, cornell_box, gallery, glassware, instancing, interior, material_grid, paper, pool, tiny, white_furnace

SCENES = [cornell_box, white_furnace, material_grid, interior, instancing, pool, glassware, gallery, paper, tiny, broken]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file differs from what would be written")
    parser.add_argument("names", nargs="*", help="only these: " + ", ".join(scene.__name__.split(".")[-1] for scene in SCENES))
    options = parser.parse_args()

    folder = pathlib.Path(__file__).resolve().parent
    stale = []
    for scene in SCENES:
        if options.names and scene.__name__.split(".")[-1] not in options.names:
            continue
        for name, data in scene.build().items():
            path = folder / name
            if options.check:
                if not path.is_file() or path.read_bytes() != data:
                    stale.append(name)
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            print("%9d  %s" % (len(data), name))
    if stale:
        print("differ from the output of scenes/generate.py: " + ", ".join(stale) + "\nrun: python3 scenes/generate.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
