#!/usr/bin/env python3
"""Prints the kd-tree against Embree as a table in Markdown, from reports of `kindling shootout`.

    build/release/kindling shootout SCENE... --clock cpu --rays-per-kind 65536 --repeat 3 --build-repeat 3 --json race.json
    bench/race_table.py race.json

A line for each scene, and the geometric mean of those that --mean names (file names without their
ending; all by default). A cell of a speed is the ratio to robust Embree, and behind the bar that to
the fastest of all that Embree has: larger is better. Builds (on all threads) and memory are compared
with the better of Embree's two of that quality, robust and not: smaller is better. `fast` needs
--accel embree,embree:non-robust,embree:best:non-robust,kdtree,kdtree:fast.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import sys
from pathlib import Path
from statistics import geometric_mean

SPEEDS = {
    "bounces": "speed, bounces, best call of each",
    "nearest, single": "speed, nearest hit, single calls",
    "camera": "speed, camera, best call of each",
    "any hit": "speed, any hit, best call of each",
}
SIZES = {
    "build / medium": "build time of medium quality (balanced)",
    "build / high": "build time of high quality (best)",
    "memory / medium": "memory of medium quality (balanced)",
}
FAST = "build, `fast` / medium"
COLUMNS = [*SPEEDS, *SIZES, FAST]
ISAS = ("sse2", "sse4.2", "avx", "avx2", "avx512", "portable")


def plain(name):
    """The name of an accelerator without the instruction set that --isa adds."""
    *first, last = name.split(":")
    return ":".join(first) if last in ISAS else name


def fast_build(scene):
    """Time of a build of `fast` over that of the faster of Embree's builds of medium quality; None if it was not in the race."""
    seconds = {plain(accelerator["name"]): accelerator["build"]["many_threads"]["median_s"] for accelerator in scene["accelerators"]}
    embree = [seconds[name] for name in ("embree", "embree:non-robust") if name in seconds]
    return seconds["kdtree:fast"] / min(embree) if embree and "kdtree:fast" in seconds else None


def ratios(scene):
    """{column: ratios, none if the race has no such figure}: of speeds to robust Embree and to any, else one."""
    own = next(each for each in scene["against_embree"] if plain(each["name"]) == "kdtree")
    lines = {line["ratio"]: line for line in own["lines"]}
    row = {title: (lines[measure]["to_robust_embree"], lines[measure]["to_any_embree"]) for title, measure in SPEEDS.items()}
    row |= {title: (lines[measure]["to_any_embree"],) for title, measure in SIZES.items()}
    row[FAST] = (fast_build(scene),)
    return {title: () if None in cell else cell for title, cell in row.items()}


def mean_of(rows):
    """The row of geometric means; a column without a figure in some row has none."""
    cells = {title: [row[title] for row in rows] for title in COLUMNS}
    return {title: tuple(map(geometric_mean, zip(*column))) if all(column) else () for title, column in cells.items()}


def text_of(name, row, mark=""):
    """A line of the table, each cell between `mark`s."""
    cells, bar = [], " \\| "
    for title in COLUMNS:
        text = bar.join(f"{value:.2f}" for value in row[title])
        cells.append(f"{mark}{text}{mark}" if text else "")
    return f"| {mark}{name}{mark} | " + " | ".join(cells) + " |"


def disagreements(scene):
    """Answers that differ, of all accelerators and calls."""
    return sum(count for accelerator in scene["accelerators"] for row in accelerator["traversal"] for kind, count in row["disagreements"].items() if kind != "at_edge")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reports", nargs="+", type=Path, help="reports of kindling shootout --json")
    parser.add_argument("--mean", metavar="NAME,...", help="scenes of the geometric mean [all]")
    arguments = parser.parse_args()
    scenes = [scene for path in arguments.reports for scene in json.loads(path.read_text())["scenes"]]
    rows = {Path(scene["file"]).stem: ratios(scene) for scene in scenes}
    chosen = arguments.mean.split(",") if arguments.mean else list(rows)
    for name in chosen:
        if name not in rows:
            sys.exit(f"race_table.py: --mean: no scene '{name}' in the reports; they have {', '.join(rows)}")
    print("| scene | " + " | ".join(COLUMNS) + " |")
    print("|---|" + "---|" * len(COLUMNS))
    for name in chosen:
        print(text_of(name, rows[name]))
    print(text_of("geometric mean", mean_of([rows[name] for name in chosen]), "**"))
    for name in rows:
        if name not in chosen:
            print(text_of(name, rows[name]))
    print(f"\n{sum(map(disagreements, scenes))} disagreements")
    for scene in scenes:
        if scene.get("warning"):
            print(f"{Path(scene['file']).stem}: {scene['warning']}")


if __name__ == "__main__":
    main()
