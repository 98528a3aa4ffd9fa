#!/usr/bin/env python3
"""Renders scenes made to exhaust memory and patience, and compares the measured with the estimated.

    bounds.py KINDLING [NAME...] [--accel kdtree,embree] [--list] [--limit-gb N] [--json FILE]
    bounds.py KINDLING [NAME...] --factors [--triangles N]
    bounds.py KINDLING NAME... --signals N

For each scene and accelerator: the peak that `info` estimates, the peak that a render takes, the time of its
build, and for each phase the time from the first SIGTERM to the end of the process. With --factors: build, memory and
rays of each shape over those of a typical mesh with as many triangles. With --signals: the time to the end after SIGTERM at
N moments, evenly spread over loading, building and three seconds of rendering. The scenes are
written into a temporary folder. A process beyond --limit-gb is killed.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import sys
import tempfile
from pathlib import Path

from bounds_factors import measure_factors
from bounds_process import Process, render, size, time_to_end
from bounds_scenes import FILES, SCENES
from bounds_signals import measure_signals

END_S = 2.0  # bound of the time to the end


def estimated_peaks(program, path, options):
    """The estimates of `info`, by accelerator, its process, and its error."""
    info = Process([program, "info", path, "--json", "--threads", "2", "--size", "64x36"], path.parent, options.limit, options.seconds).finish()
    if info.process.returncode != 0 or info.killed:
        return {}, info
    report = json.loads("".join(info.out))
    return {of["name"]: of["peak_bytes"] for of in report["memory"]["accelerators"]}, info


def measure_scene(program, scene, path, options, rows):
    estimated, info = estimated_peaks(program, path, options)
    for accelerator in options.accel.split(","):
        run = render(program, path, accelerator, options).finish()
        stats = path.parent / "stats.json"
        build = json.loads(stats.read_text())["accelerator"]["build_s"] if run.process.returncode == 0 else None
        stats.unlink(missing_ok=True)
        row = {"scene": scene.__name__, "about": scene.__doc__, "file_bytes": sum(f.stat().st_size for f in path.parent.glob(path.stem + ".*")),
               "accelerator": accelerator, "estimated": estimated.get(accelerator), "took": run.peak, "seconds": run.seconds, "build_s": build,
               "end": run.killed or f"exit code {run.process.returncode}", "info_s": info.seconds, "ends": {}}
        for phase, delay in (("load", 0.3), ("build", 0.5), ("render", 1.0)):
            if row["seconds"] > 3.0 * delay:
                row["ends"][phase] = time_to_end(program, path, accelerator, phase, delay, options)
        rows.append(row)
        signals = ", ".join(f"{phase} {end[0]:.2f} s, {end[2]:.2f} s of a processor ({end[1]})" for phase, end in row["ends"].items() if end)
        print(f"{row['scene']:30} {accelerator:7} estimated {size(row['estimated']) if row['estimated'] else '-':>10}  took {size(row['took']):>10}  "
              f"{row['seconds']:6.1f} s  build {build if build is None else round(build, 2)} s  {row['end']}  SIGTERM: {signals}", flush=True)


def measure_file(program, scene, path, options, rows):
    _, info = estimated_peaks(program, path, options)
    row = {"scene": scene.__name__, "about": scene.__doc__, "file_bytes": sum(f.stat().st_size for f in path.parent.glob(path.stem + ".*")),
           "info_s": info.seconds, "info_peak": info.peak, "end": info.killed or f"exit code {info.process.returncode}"}
    rows.append(row)
    print(f"{row['scene']:30} info of {row['file_bytes']:>9} bytes: {row['info_s']:6.2f} s, {size(row['info_peak']):>10}  {row['end']}  "
          f"{''.join(info.err)[-200:].strip()}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda text: str(Path(text).resolve()))
    parser.add_argument("names", nargs="*", help="scenes; default: all")
    parser.add_argument("--accel", default="kdtree,embree")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--limit-gb", type=float, default=6.0)
    parser.add_argument("--seconds", type=float, default=60.0, help="limit of each process")
    parser.add_argument("--factors", action="store_true", help="compare shapes with a typical mesh")
    parser.add_argument("--triangles", type=int, default=50_000, help="of --factors [%(default)s]")
    parser.add_argument("--signals", type=int, metavar="N", help="of each scene and accelerator")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    options.limit = int(options.limit_gb * 2**30)
    rows = []
    if options.factors:
        sys.exit(measure_factors(options))
    if options.signals:
        sys.exit(measure_signals(options, [scene for scene in SCENES if scene.__name__ in options.names], END_S))
    for scene in SCENES + FILES:
        if options.list:
            print(f"{scene.__name__:30} {scene.__doc__}")
        if options.list or (options.names and scene.__name__ not in options.names):
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = scene(Path(folder))
            (measure_scene if scene in SCENES else measure_file)(options.program, scene, path, options, rows)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))
    slow = [row["scene"] for row in rows for end in row.get("ends", {}).values() if end and end[0] > END_S]
    if slow:
        sys.exit(f"ended later than {END_S} s after the signal: {', '.join(slow)}")


if __name__ == "__main__":
    main()
