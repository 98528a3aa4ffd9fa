#!/usr/bin/env python3
"""Measures the gain of trees that persist between frames, on a landscape with turning boulders.

Renders frames in a sequence and alone. Prints a table (Markdown) of the accelerator's seconds per frame,
and of the cost for rays of separate trees for static and moving geometry.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import math
import statistics
import struct
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True

import with_numpy  # noqa: F401  (first: another Python may have to take over)

import pixels

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = ["--env-color", "0.25,0.32,0.42"]


def read_glb(path):
    data = path.read_bytes()
    length, _ = struct.unpack_from("<II", data, 12)
    return json.loads(data[20:20 + length]), data[20 + length + 8:]


def write_glb(path, document, binary):
    document["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)) + struct.pack("<II", len(text), 0x4E4F534A) +
                     text + struct.pack("<II", len(binary), 0x004E4942) + binary)


def turn_boulders(document, binary, count):
    """The first boulders turn half round in a second, and at time 0 are where they are at rest."""
    binary += b"\0" * (-len(binary) % 4)
    rows = {"SCALAR": (0.0, 1.0), "VEC4": (0.0, 0.0, 0.0, 1.0, 0.0, math.sin(1.5), 0.0, math.cos(1.5))}
    accessors = []
    for kind, values in rows.items():
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 4 * len(values)})
        binary += struct.pack("<%df" % len(values), *values)
        accessors.append(len(document["accessors"]))
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "type": kind, "count": 2})
    document["accessors"][accessors[0]].update({"min": [0.0], "max": [1.0]})
    nodes = [i for i, node in enumerate(document["nodes"]) if node.get("name", "").startswith("boulder")][:count]
    document["animations"] = [{"samplers": [{"input": accessors[0], "output": accessors[1]}],
                               "channels": [{"sampler": 0, "target": {"node": node, "path": "rotation"}} for node in nodes]}]
    return document, binary


def render(options, scene, flags, name):
    stats = options.folder / (name + ".json")
    command = [options.program, "render", scene, "--size", options.size, "--spp", options.spp, "--quiet", *ENVIRONMENT, "--stats", stats,
               *flags] + (["--threads", options.threads] if options.threads else [])
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("%s\n%s" % (" ".join(map(str, command)), done.stderr))
    return json.loads(stats.read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/kindling")
    parser.add_argument("--folder", type=Path, default=ROOT / "out/moving_frames", help="for scenes, images and statistics")
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--moving", nargs="*", type=int, default=[1, 8], help="boulders that turn, of 16")
    parser.add_argument("--accel", nargs="*", default=["kdtree", "embree"])
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--repeats", type=int, default=5, help="repetitions of the images whose times are compared")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--spp", type=int, default=8)
    parser.add_argument("--threads", type=int, default=0, help="0: all")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    still = options.folder / ("heavy_%d" % options.triangles) / "heavy.glb"
    if not still.is_file():
        subprocess.run([sys.executable, ROOT / "scenes/generate_large.py", still.parent, "heavy", "--count", str(options.triangles)], check=True)

    print("| accelerator | boulders | triangles built, first frame \\| others | accelerator, s: alone \\| in a sequence | whole build, s: alone \\| in a "
          "sequence | render, s: one tree \\| two | same pixels |\n|---|---|---|---|---|---|---|")
    for count in options.moving:
        moving = options.folder / ("moving_%d_%d.glb" % (options.triangles, count))
        write_glb(moving, *turn_boulders(*read_glb(still), count))
        for accelerator in options.accel:
            accel = ["--accel", accelerator]
            frames = render(options, moving, accel + ["--frames", "0-%d" % (options.frames - 1), "--fps", "24", "--force", "--exr-float", "-o",
                                                      options.folder / "frame_#.exr"], "frames")["frames"]
            alone, two, one = [], [], []
            for i in range(options.repeats):
                image = render(options, moving, accel + ["--time", 1 / 24, "--exr-float", "-o", options.folder / "alone.exr"], "alone")
                alone.append(image)
                flags = accel + ["--time", 0, "--exr-float", "-o"]
                two.append(render(options, moving, flags + [options.folder / "two.exr"], "two"))
                one.append(render(options, still, flags + [options.folder / "one.exr"], "one"))
            later = frames[1:]

            def median(runs, get):
                return statistics.median(get(run) for run in runs)

            def build_s(run):
                return run["accelerator"]["build_s"]

            def whole_s(run):
                return run["phases"]["build"]

            same = pixels.read_rgb(options.folder / "one.exr").rgb == pixels.read_rgb(options.folder / "two.exr").rgb
            print("| %s | %d | %d \\| %d | %.3f \\| %.3f | %.2f \\| %.2f | %.2f \\| %.2f (%+.1f %%) | %s |" % (
                accelerator, count, frames[0]["accelerator"]["built_triangles"], later[0]["accelerator"]["built_triangles"],
                median(alone, build_s), median(later, build_s), median(alone, whole_s), median(later, whole_s),
                median(one, lambda run: run["phases"]["render"]), median(two, lambda run: run["phases"]["render"]),
                100 * (median(two, lambda run: run["phases"]["render"]) / median(one, lambda run: run["phases"]["render"]) - 1),
                "yes" if same else "no"), flush=True)


if __name__ == "__main__":
    sys.exit(main())
