"""Figures 2, 3 and 4: three tracers by trace depth, the gain of each optimization.

Figure 2 shows the effect of the limit of reflections on the image.
"""
# SPDX-License-Identifier: Apache-2.0
import statistics
from dataclasses import dataclass

import numpy as np

import fidelity_images
import figures
import flip
from measure import median_s, quartiles

SCENE, SIZE = "figure_01", (301, 246)
AMBIENT = ["--ambient", figures.AMBIENT_1]
TRACERS = {"none": "no accelerator", "kdtree": "kd-tree", "optimized": "kd-tree, optimized"}
PLAIN = ["--integrator", "whitted", "--accel", "kdtree", "--whitted-form", "recursive", "--whitted-cache", "off", "--max-reflections", "64", *AMBIENT]
OPTIMIZATIONS = {"bounce limit (3)": ["--max-reflections", "3"], "cache": ["--whitted-cache", "on"], "iteration": ["--whitted-form", "iterative"]}
CONTRIBUTION_SPP = 4
NOTHING = 0.01  # a relative saving below this is called none


@dataclass
class Contribution:
    """Relative saving of time, paired render by render: lower quartile, median, upper quartile."""
    name: str
    alone: tuple  # switched on alone on top of the plain tracer
    left_out: tuple  # saving of the full set over the set without it


def by_depth(bench, depths, repeats, slow_depths):
    """{threads: {tracer: {depth: median seconds}}} of the render phase. Without an accelerator only slow_depths, once."""
    found = {}
    for threads in [1] if bench.clock == "cpu" else sorted({1, bench.cores}):  # CPU time cannot show the gain of threads
        variants = {}
        for depth in depths:
            for tracer in ("kdtree", "optimized"):
                variants[tracer, depth] = lambda t=tracer, d=depth: _render(bench, ["--tracer", t, "--trace-depth", str(d), *AMBIENT], threads)
        times = {key: median_s(results) for key, results in bench.interleaved(variants, repeats, f"figure 3, {threads} threads").items()}
        slow = {("none", depth): lambda d=depth: _render(bench, ["--tracer", "none", "--trace-depth", str(d), *AMBIENT], threads)
                for depth in slow_depths}
        times |= {key: median_s(results) for key, results in bench.interleaved(slow, 1, f"figure 3, no accelerator, {threads} threads").items()}
        found[threads] = {tracer: {depth: seconds for (t, depth), seconds in times.items() if t == tracer} for tracer in TRACERS}
    return found


def _render(bench, flags, threads=1, spp=1):
    return bench.timed(SCENE, bench.scaled(SIZE), spp, flags, threads)


def improvements(times):
    """{depth: percent of the kd-tree tracer's time that the optimizations save}."""
    return {depth: 100.0 * (1.0 - times["optimized"][depth] / seconds) for depth, seconds in times["kdtree"].items()}


def contributions(bench, depth, repeats):
    """Each optimization on top of the plain tracer, and the full set without each; single thread. Also the full set's saving."""
    flags = {"plain": PLAIN, "full": PLAIN + [flag for more in OPTIMIZATIONS.values() for flag in more]}
    for name, more in OPTIMIZATIONS.items():
        flags["+" + name] = PLAIN + more
        flags["-" + name] = PLAIN + [flag for other, extra in OPTIMIZATIONS.items() if other != name for flag in extra]
    variants = {key: lambda f=f: _render(bench, [*f, "--trace-depth", str(depth)], spp=CONTRIBUTION_SPP) for key, f in flags.items()}
    results = bench.interleaved(variants, repeats, f"each optimization at depth {depth}")
    seconds = {key: [result.cost_s for result in found] for key, found in results.items()}

    def saving(before, after):
        return quartiles([1.0 - b / a for a, b in zip(seconds[before], seconds[after])])

    found = [Contribution(name, saving("plain", "+" + name), saving("-" + name, "full")) for name in OPTIMIZATIONS]
    return {"depth": depth, "repeats": repeats, "spp": CONTRIBUTION_SPP, "plain_s": statistics.median(seconds["plain"]), "full_s": statistics.median(seconds["full"]),
            "full": saving("plain", "full"), "each": found, "rays": {key: runs[0].stats["rays"]["total"] for key, runs in results.items()},
            "cache": results["full"][0].stats.get("whitted", {})}


def verdict(saving):
    """The meaning of a saving (quartiles) in words."""
    low, middle, high = saving
    if low > NOTHING:
        return f"saves {100 * middle:.0f} %" if middle >= 0.1 else f"saves {100 * middle:.1f} %"
    if high < -NOTHING:
        return f"costs {-100 * middle:.1f} %"
    return f"brings nothing on this machine ({100 * middle:+.1f} %, quartiles {100 * low:+.1f} to {100 * high:+.1f} %)"


def quality(bench, depth, spp):
    """Figure 2: unlimited reflections beside three."""
    images, times = {}, {}
    for name, limit in (("unlimited", "64"), ("3", "3")):
        result = bench.render(SCENE, bench.scaled(SIZE), spp, ["--integrator", "whitted", "--trace-depth", str(depth), "--max-reflections", limit, *AMBIENT])
        images[name], times[name] = fidelity_images.read(result.image).rgb, result.render_s
    error = flip.flip(images["unlimited"].astype(float), images["3"].astype(float))
    square = float(np.mean((images["unlimited"] - images["3"]) ** 2))
    return {"depth": depth, "spp": spp, "seconds": times, "flip_mean": float(error.mean()), "flip_max": float(error.max()),
            "psnr_db": 10.0 * float(np.log10(1.0 / square)) if square > 0 else None,
            "changed": float(np.mean(np.abs(images["unlimited"] - images["3"]).max(axis=-1) > 2.5 / 255.0)),
            "images": {name: encode(rgb) for name, rgb in images.items()}, "difference": fidelity_images.difference_png(error)}


def encode(rgb, quality=90):
    return fidelity_images.encode(np.round(np.clip(rgb, 0.0, 1.0) * 255.0).astype(np.uint8), quality=quality)
