#!/usr/bin/env python3
"""Measures memory and times of large scenes with the kd-tree and with Embree.

Makes a landscape of 7 million triangles and a ring of 10 million instances, renders both, and prints
a table of times, peaks and budgets (Markdown).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import resource
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True

import with_numpy  # noqa: F401  (first: another Python may have to take over)

ROOT = Path(__file__).resolve().parent.parent
LIGHT = {"heavy": ["--env-color", "0.25,0.32,0.42"], "swarm": ["--env-color", "0.05,0.06,0.08", "--background", "0.004,0.005,0.008"]}
SIZE = "640x360"


def run(arguments, limit_bytes):
    """Runs a command with a limit of address space; returns its standard output."""
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (limit_bytes, limit_bytes))

    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, preexec_fn=limit)
    if done.returncode != 0:
        sys.exit("%s\n%s" % (" ".join(map(str, arguments)), done.stderr))
    return done.stdout


def render(program, folder, scene, accelerator, options, light, size=SIZE):
    """The report of --stats."""
    stats = folder / ("%s_%s.json" % (scene.stem, accelerator))
    image = folder / ("%s_%s.png" % (scene.stem, accelerator))
    run([program, "render", scene, "--size", size, "--spp", options.spp, "--accel", accelerator, "--quiet", "--stats", stats,
         "-o", image, *light] + (["--threads", options.threads] if options.threads else []), options.limit_gib << 30)
    return json.loads(stats.read_text())


def budget(program, scene, accelerator, options):
    predicted = json.loads(run([program, "info", scene, "--json", "--size", SIZE] +
                               (["--threads", options.threads] if options.threads else []), options.limit_gib << 30))
    return next(a for a in predicted["memory"]["accelerators"] if a["name"] == accelerator)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/kindling")
    parser.add_argument("--folder", type=Path, default=ROOT / "out/memory", help="for scenes, images and statistics [out/memory]")
    parser.add_argument("--triangles", type=int, default=7_000_000, help="triangles of heavy")
    parser.add_argument("--instances", type=int, default=10_000_000, help="instances of swarm")
    parser.add_argument("--scenes", nargs="*", type=Path, default=[], help="further files, rendered as they are")
    parser.add_argument("--accel", nargs="*", default=["kdtree", "embree"])
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--threads", type=int, default=0, help="0: all")
    parser.add_argument("--limit-gib", type=int, default=14, help="address space that a render may take")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)

    jobs = []
    for name, count in (("heavy", options.triangles), ("swarm", options.instances)):
        if count == 0:
            continue
        path = options.folder / ("%s_%d" % (name, count)) / (name + ".glb")
        if not path.is_file():
            subprocess.run([sys.executable, ROOT / "scenes/generate_large.py", path.parent, name, "--count", str(count)], check=True)
        jobs.append((path, LIGHT[name]))
    jobs += [(path, []) for path in options.scenes]

    # The program itself, by a scene of three dozen triangles.
    base = {a: render(options.program, options.folder, ROOT / "scenes/cornell_box.glb", a, options, [])["peak_rss_bytes"]
            for a in options.accel}
    print("| scene | accelerator | triangles | instances | load, s | build, s | render, s | peak, MB | budget, MB | above the program, bytes |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for scene, light in jobs:
        for accelerator in options.accel:
            stats = render(options.program, options.folder, scene, accelerator, options, light)
            predicted = budget(options.program, scene, accelerator, options)
            phases, a = stats["phases"], stats["accelerator"]
            # A single static instance is baked, so triangles count.
            of, count = ("instance", a["instances"]) if a["instances"] > 1000 else ("triangle", a["triangles"])
            print("| %s | %s | %d | %d | %.1f | %.1f | %.1f | %.0f | %.0f | %.0f for each %s |" % (
                scene.stem, accelerator, a["triangles"], a["instances"], phases["load"] + phases["textures"], phases["build"],
                phases["render"], stats["peak_rss_bytes"] / 1e6, predicted["peak_bytes"] / 1e6,
                (stats["peak_rss_bytes"] - base[accelerator]) / max(count, 1), of), flush=True)


if __name__ == "__main__":
    main()
