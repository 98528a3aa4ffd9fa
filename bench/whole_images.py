#!/usr/bin/env python3
"""Renders scenes with two accelerators in turn and prints how the times of path tracing compare.

usage: bench/whole_images.py SCENE... [--accel FIRST,SECOND] [--repeat N] [--spp N] [--size WxH] [--threads N] [--kindling FILE]
A ratio above 1 says that the second is faster. Medians; loading, building and writing are not counted.
Exit code 0, or that of the render that failed.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def render_seconds(arguments, scene, accelerator, folder):
    """Seconds that path tracing took in one render."""
    stats = folder / "stats.json"
    command = [arguments.kindling, "render", scene, "-o", folder / "image.exr", "--stats", stats, "--accel", accelerator,
               "--spp", arguments.spp, "--size", arguments.size, "--threads", arguments.threads, "-q"]
    done = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        sys.exit(done.returncode)
    return json.loads(stats.read_text(encoding="utf-8"))["phases"]["render"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--accel", default="embree,kdtree")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--spp", type=int, default=8)
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--kindling", default=ROOT / "build/release/kindling")
    arguments = parser.parse_args()
    first, second = arguments.accel.split(",")
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            times = {first: [], second: []}
            for _ in range(arguments.repeat):
                for accelerator in times:
                    times[accelerator].append(render_seconds(arguments, scene, accelerator, Path(folder)))
            medians = [statistics.median(seconds) for seconds in times.values()]
            ratios.append(medians[0] / medians[1])
            print(f"{Path(scene).name:30} {first} {medians[0]:8.3f} s  {second} {medians[1]:8.3f} s  {ratios[-1]:.3f}x", flush=True)
    print(f"geometric mean {statistics.geometric_mean(ratios):.3f}x")


if __name__ == "__main__":
    main()
