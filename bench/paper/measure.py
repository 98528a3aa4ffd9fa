"""Runs Kindling for the page of the paper's figures and reads its --stats."""
# SPDX-License-Identifier: Apache-2.0
import itertools
import json
import os
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import renderers

SCENES = renderers.ROOT / "scenes" / "paper"
NEEDED = ["--integrator", "--trace-depth", "--max-reflections", "--whitted-cache", "--whitted-form", "--tracer", "--light-samples",
          "--glossy-samples", "--ambient", "--schedule", "--sampler"]


@dataclass
class Result:
    image: Path
    render_s: float  # wall time of the render phase
    cost_s: float  # the compared cost: that, or with --clock cpu the process's time less that of a render of 8 x 8 pixels
    process_s: float  # wall time of the whole process
    cpu_s: float
    stats: dict
    warnings: list
    command: list

    @property
    def idle_share(self):
        """The part of its threads' time in the render phase that was spent without work."""
        return self.stats["idle_s"] / (self.stats["threads"] * self.render_s) if self.render_s > 0 else 0.0


class Bench:
    """The program, its working folder and its measurements. `flags`: passed to every render."""

    def __init__(self, binary, folder, scale=1.0, flags=(), clock="wall"):
        self.binary, self.folder, self.scale, self.flags, self.clock = Path(binary), Path(folder), scale, list(flags), clock
        self.overheads = {}  # CPU seconds before the first ray and after the last one, by scene
        self.cores = len(os.sched_getaffinity(0))
        self.started = time.perf_counter()
        self.version = ""
        self.counter = itertools.count(1)  # of renders; next() of it is safe among threads

    def check(self):
        """Exits if the program is too old for the page."""
        done = subprocess.run([self.binary, "render", "--help"], capture_output=True, text=True, check=False)
        if missing := [flag for flag in NEEDED if flag + " " not in done.stdout]:
            sys.exit(f"{self.binary}: 'kindling render' has no {', '.join(missing)}; rebuild it (cmake --build --preset release)")

    def elapsed_s(self):
        return time.perf_counter() - self.started

    def say(self, text):
        print(f"[{self.elapsed_s():5.0f} s] {text}", file=sys.stderr, flush=True)

    def render(self, scene, size_px, spp, flags=(), threads=0, kind="png"):
        """Renders scenes/paper/SCENE.glb; `threads` 0: all cores."""
        path = SCENES / f"{scene}.glb"
        if not path.is_file():
            sys.exit(f"{path} does not exist; make it: python3 scenes/generate.py paper")
        stem = self.folder / f"{next(self.counter):04d}"
        image, stats = stem.with_suffix("." + kind), stem.with_suffix(".json")
        command = [self.binary, "render", path, "-o", image, "--size", f"{size_px[0]}x{size_px[1]}", "--spp", str(spp), "--threads",
                   str(threads or self.cores), "--stats", stats, "--progress", "none", *flags, *self.flags]
        if kind == "exr":
            command.append("--exr-float")
        lines, wall_s, _, cpu_s = renderers.run_measured(command, stem.with_suffix(".log"))
        data = json.loads(stats.read_text(encoding="utf-8"))
        self.version = data["version"]
        warnings = [line.replace(str(path), path.name) for _, line in lines if "warning:" in line]
        shown = ["kindling", "render", f"scenes/paper/{scene}.glb", *map(str, command[5:command.index("--stats")]), *map(str, flags), *self.flags]
        render_s = data["phases"]["render"]
        return Result(image, render_s, render_s, wall_s, cpu_s, data, warnings, shown)

    def timed(self, scene, size_px, spp, flags, threads=1, kind="exr"):
        """A render whose cost is compared."""
        result = self.render(scene, size_px, spp, flags, threads, kind)
        if self.clock == "cpu":
            if scene not in self.overheads:
                self.overheads[scene] = statistics.median(self.render(scene, (8, 8), 1, ["--accel", "kdtree"], 1, "exr").cpu_s for _ in range(3))
            result.cost_s = max(result.cpu_s - self.overheads[scene], 1e-4)
        return result

    def scaled(self, size_px):
        return tuple(max(round(self.scale * n), 8) for n in size_px)

    def interleaved(self, variants, repeats, name):
        """{key: [Result, ...]} of variants {key: function that renders}, one of each in turn, so that disturbances of the
        machine affect all of them alike."""
        results = {key: [] for key in variants}
        for repeat in range(repeats):
            self.say(f"{name}: round {repeat + 1} of {repeats}, {len(variants)} renders")
            for key, render in variants.items():
                results[key].append(render())
        return results


def median_s(results):
    return statistics.median(result.cost_s for result in results)


def quartiles(values):
    """(lower quartile, median, upper quartile); of one value: three times that."""
    if len(values) == 1:
        return (values[0],) * 3
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, middle, high
