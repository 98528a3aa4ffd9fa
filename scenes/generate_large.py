#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes scenes that are not in this folder; needs NumPy.

7 million triangles, 10 million instances, cut-out foliage, a room that is lit through a window.
"""
import argparse
import pathlib
import sys

sys.dont_write_bytecode = True  # a checkout stays as it is
sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "bench"))

import with_numpy  # noqa: F401  (first: another Python may have to take over)

from generator import foliage, large, window

SCENES = {**large.SCENES, **foliage.SCENES, **window.SCENES}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("names", nargs="*", choices=[[], *SCENES], default=[], help="only these: " + ", ".join(SCENES))
    parser.add_argument("--count", type=int, help="triangles of heavy, instances of swarm, cards of foliage, windows of window [7000000, 10000000, 111000, 1]")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for name, (build, _, usual) in SCENES.items():
        if options.names and name not in options.names:
            continue
        data = build(options.count or usual)
        path = options.folder / (name + ".glb")
        path.write_bytes(data)
        print("%11d  %s" % (len(data), path))
    return 0


if __name__ == "__main__":
    sys.exit(main())
