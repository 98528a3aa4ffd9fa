#!/usr/bin/env python3
"""Measures the speed-up of a frame on two nodes of a Slurm cluster, both on this machine.

The time is that from the submission to the merged image.

usage: farm_speedup.py [SCENE] [--seconds 600] [--repeat 1] [-- FLAGS OF RENDER]

Starts a cluster of one node and one of two, each node with one processor of its own, hands the frame over with one part for each node, and
prints where the time went. The samples per pixel are chosen so that one node takes about --seconds. Needs what tests/farm needs; other
work on the machine spoils the figures.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "farm"))
from slurm_bed import BedError, SlurmBed  # pylint: disable=wrong-import-position


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", type=Path, default=ROOT / "scenes" / "interior.glb", help="(scenes/interior.glb)")
    parser.add_argument("--kindling", type=Path, default=ROOT / "build" / "release" / "kindling", help="(build/release/kindling)")
    parser.add_argument("--seconds", type=float, default=600.0, help="duration of the frame on one node (600)")
    parser.add_argument("--repeat", type=int, default=1, help="runs with one node and with two, in turn; medians count (1)")
    parser.add_argument("--json", type=Path, help="write the measurements")
    words = sys.argv[1:]
    flags = words[words.index("--") + 1:] if "--" in words else []
    options = parser.parse_args(words[:words.index("--")] if "--" in words else words)
    if not os.access(options.kindling, os.X_OK):
        parser.error(f"there is no program {options.kindling}; build it, or say --kindling")
    if "--size" not in flags:
        flags += ["--size", "960x540"]
    try:
        spp = choose_samples(options, flags)
        print(f"{options.scene.name}: {' '.join(flags)} --spp {spp}", flush=True)
        runs = []
        for repetition in range(options.repeat):
            for nodes in (1, 2) if repetition % 2 == 0 else (2, 1):
                runs.append(measure(options, [*flags, "--spp", str(spp)], nodes))
                print(f"  {nodes} node{'s' if nodes > 1 else ''}: {runs[-1]['wall']:.1f} s", flush=True)
    except (BedError, subprocess.CalledProcessError, OSError) as error:
        print(f"farm_speedup.py: {error}", file=sys.stderr)
        print(getattr(error, "stderr", "") or "", file=sys.stderr)
        return 1
    print(table(runs))
    if options.json:
        options.json.write_text(json.dumps(runs, indent=1) + "\n")
    return 0


def choose_samples(options, flags):
    """Samples per pixel for options.seconds of one thread, from two short renders, which separate the fixed costs."""
    def seconds(spp):
        with tempfile.TemporaryDirectory() as folder:
            stats = Path(folder) / "stats.json"
            subprocess.run([options.kindling, "render", options.scene, *flags, "--spp", str(spp), "--threads", "1", "--quiet",
                            "-o", f"{folder}/x.png", "--stats", stats], check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            return json.loads(stats.read_text())["phases"]["render"]
    few, more = 4, 8
    while True:
        short, longer = seconds(few), seconds(more)
        if longer - short > min(5.0, 0.05 * options.seconds) or more > 4096:
            break
        few, more = 2 * few, 4 * few
    slope = max((longer - short) / (more - few), 1e-6)
    return max(2, round(more + (options.seconds - longer) / slope))


def measure(options, flags, nodes):
    """Renders one frame on a cluster with this number of nodes; returns the seconds of each stage."""
    with tempfile.TemporaryDirectory(prefix="kindling-farm-") as folder, SlurmBed(nodes=nodes, cpus=1) as bed:
        farm = Path(folder) / "farm"
        program = options.kindling.resolve()
        start = time.time()
        bed.run(program, "farm", "submit", options.scene.resolve(), "--parts", nodes, "--folder", farm, "-o", f"{folder}/image.exr",
                "--", *flags)
        submitted = time.time()
        # The clock stops when the image is merged. Polling the farm takes a processor, so it is
        # rare.
        record = farm / "state" / "image.json"
        bed.wait_until("the merged image", record.exists, 20 * options.seconds + 600, every=0.5)
        status = json.loads(bed.run(program, "farm", "status", farm, "--json", check=False))
        frame = status["frames"][0]
        if frame["state"] != "merged":
            raise BedError(f"the farm did not merge its frame: {json.dumps(status, indent=1)}")
        attempts = [task["attempts"] for task in frame["tasks"]]
        if any(len(tried) != 1 for tried in attempts):
            raise BedError("a part was tried more than once; these are not the figures that were wanted")
        stats = [json.loads(path.read_text()) for path in sorted((farm / "state").glob("*.stats.json"))]
        last_end = max(tried[0]["end_s"] for tried in attempts)
        merged = frame["merged_s"]
        worst = max(stats, key=lambda one: one["total_s"])
        phases = worst["phases"]
        return {
            "nodes": nodes,
            "wall": merged - start,
            "submit": submitted - start,
            "queue": max(tried[0]["start_s"] for tried in attempts) - submitted,
            "load": phases["load"] + phases["build"],
            "training": phases["training"],
            "render": phases["render"] - phases["training"],
            "write": phases["write"],
            "merge": merged - last_end,
            "parts": [tried[0]["end_s"] - tried[0]["start_s"] for tried in attempts],
        }


def table(runs):
    """Medians of the stages for one node and two, and the speed-up."""
    stages = [("wall", "submission to merged image"), ("submit", "  submitting: reading the scene, sbatch"), ("queue", "  waiting for a node"),
              ("load", "  loading and building"), ("training", "  training of a guide"), ("render", "  path tracing"),
              ("write", "  writing the part"), ("merge", "  waiting for the merge, and it")]
    medians = {nodes: {stage: statistics.median(run[stage] for run in runs if run["nodes"] == nodes) for stage, _ in stages} for nodes in (1, 2)}
    lines = ["", f"{'seconds (of the longer part)':40} {'1 node':>9} {'2 nodes':>9}"]
    for stage, name in stages:
        lines.append(f"{name:40} {medians[1][stage]:9.2f} {medians[2][stage]:9.2f}")
    lines.append(f"{'speed-up':40} {'':9} {medians[1]['wall'] / medians[2]['wall']:9.3f}")
    lines.append(f"{'of path tracing alone':40} {'':9} {medians[1]['render'] / max(medians[2]['render'], 1e-9):9.3f}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
