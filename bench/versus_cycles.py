#!/usr/bin/env python3
"""Renders the scenes of a folder with Kindling and, where Blender is installed, with Cycles in the same run, and compares.

Both get the same camera, environment, samples, bounces and threads, a box filter and no denoising, clamps or adaptive
sampling. Repetitions are interleaved (Kindling, Cycles, Kindling, ...), each with a seed of its own; figures are medians.
Only the time of path tracing counts for samples per second: not import, texture decoding or building.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import math
import platform
import statistics
import sys
import tempfile
from pathlib import Path

import pixels
import renderers

REFERENCE_TOLERANCE = 0.005  # largest relative difference of a channel's mean that --check-reference accepts


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="scenes.json and its scenes, or just .glb and .gltf files")
    parser.add_argument("--scenes", type=lambda text: text.split(","), help="only these, comma-separated")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel (16)")
    parser.add_argument("--size", type=renderers.parse_size, metavar="WxH", help="pixels (as scenes.json says, else 640x360)")
    parser.add_argument("--repeat", type=int, default=3, help="renders by each, at least 2 (3)")
    parser.add_argument("--threads", type=int, default=2, help="of each renderer (2)")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--accel", default="embree", help="Kindling's accelerator (embree)")
    parser.add_argument("--only", choices=("kindling", "cycles"), help="one side alone")
    parser.add_argument("--check-reference", action="store_true",
                        help="compare the mean of each channel with the scene's reference picture; exit 1 beyond 0.5 %%")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write all figures there")
    parser.add_argument("--markdown", type=Path, metavar="OUT", help="write the table there")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep pictures and logs there")
    arguments = parser.parse_args()
    if arguments.repeat < 2:
        parser.error("--repeat: the noise needs at least 2 renders")
    return arguments


def summarize(job, runs, reference):
    """The figures of one renderer on one scene."""
    pictures = [pixels.read_rgb(run.picture) for run in runs.runs]
    path_tracing_s = runs.median("path_tracing_s")
    noise = pixels.noise(pictures, reference)
    means = [picture.mean() for picture in pictures]
    return {
        "mpaths_per_s": job.paths() / path_tracing_s / 1e6,
        "path_tracing_s": path_tracing_s,
        "noise": noise,  # relMSE at equal samples
        "noise_x_s": noise * path_tracing_s,  # the time that equal noise costs, up to a factor common to both
        "peak_mb": runs.median("peak_mb"),
        "first_sample_s": runs.median("first_sample_s"),
        "process_s": runs.median("process_s"),
        "mean": [statistics.fmean(channel) for channel in zip(*means)],
        "mean_standard_error": [statistics.stdev(channel) / math.sqrt(len(means)) for channel in zip(*means)],
        "path_tracing_s_of_runs": [run.path_tracing_s for run in runs.runs],
    }


def compare_scene(job, arguments, kindling, blender, folder):
    """Renders one scene by both, interleaved, and returns {"kindling": figures, "cycles": figures}."""
    all_runs = {}
    for seed in range(1, arguments.repeat + 1):
        if kindling:
            run = renderers.run_kindling(kindling, job, seed, folder, arguments.accel)
            all_runs.setdefault("kindling", renderers.Runs()).runs.append(run)
        if blender:
            run = renderers.run_cycles(blender, job, seed, folder)
            all_runs.setdefault("cycles", renderers.Runs()).runs.append(run)
        print(f"{job.name}: repetition {seed} of {arguments.repeat} done", file=sys.stderr)
    reference = pixels.read_rgb(job.reference) if job.reference else None
    if not reference or (reference.width, reference.height) != tuple(job.size_px):
        reference = pixels.mean_picture([pixels.read_rgb(run.picture) for runs in all_runs.values() for run in runs.runs])
    return {name: summarize(job, runs, reference) for name, runs in all_runs.items()}


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def table_of(results):
    """A Markdown table: one line a scene, Kindling / Cycles in each cell, then ratios (above 1: Kindling is better)."""
    sides = [side for side in ("kindling", "cycles") if any(side in result for result in results.values())]
    both = len(sides) == 2
    columns = [("Mpaths/s", "mpaths_per_s", "{:.2f}"), ("relMSE", "noise", "{:.4f}"), ("relMSE x s", "noise_x_s", "{:.4f}"),
               ("peak MB", "peak_mb", "{:.0f}"), ("first sample s", "first_sample_s", "{:.2f}")]
    header = ["scene"] + [title for title, _, _ in columns] + (["faster", "less noise x s", "less memory"] if both else [])
    rows = [header, ["---"] * len(header)]
    ratios = []
    for name, result in results.items():
        row = [name] + [" / ".join(form.format(result[side][key]) for side in sides) for _, key, form in columns]
        if both:
            k, c = result["kindling"], result["cycles"]
            ratios.append([k["mpaths_per_s"] / c["mpaths_per_s"], c["noise_x_s"] / k["noise_x_s"], c["peak_mb"] / k["peak_mb"]])
            row += [f"{ratio:.2f}x" for ratio in ratios[-1]]
        rows.append(row)
    if both and len(ratios) > 1:
        rows.append(["geometric mean"] + [""] * len(columns) + [f"{geometric_mean(column):.2f}x" for column in zip(*ratios)])
    title = " / ".join(side.capitalize() for side in sides)
    return f"Cells: {title}\n\n" + "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n"


def check_references(jobs, results):
    """Prints the relative difference of each channel's mean from the reference. Returns whether all are within the limit."""
    good = True
    for job in jobs:
        if not job.reference:
            print(f"{job.name}: no reference picture, not checked")
            continue
        expected = pixels.read_rgb(job.reference).mean()
        for side, figures in results[job.name].items():
            differences = [found / wanted - 1.0 for found, wanted in zip(figures["mean"], expected)]
            errors = [error / wanted for error, wanted in zip(figures["mean_standard_error"], expected)]
            within = all(abs(difference) <= REFERENCE_TOLERANCE for difference in differences)
            text = ", ".join(f"{channel} {100 * difference:+.2f} % (standard error {100 * error:.2f} %)"
                             for channel, difference, error in zip("RGB", differences, errors))
            print(f"{job.name}: {side} against {job.reference.name}: {text}{'' if within else '  BEYOND 0.5 %'}")
            good = good and (within or side != "kindling")
    return good


def main():
    arguments = parse_arguments()
    jobs = renderers.load_jobs(arguments.folder, scenes=arguments.scenes, spp=arguments.spp, size_px=arguments.size,
                               threads=arguments.threads)
    kindling = renderers.find_kindling(arguments.kindling) if arguments.only != "cycles" else None
    blender = renderers.find_blender() if arguments.only != "kindling" else None
    if not blender and arguments.only == "cycles":
        sys.exit("blender is not installed (Debian: apt-get install blender)")
    if not blender and not arguments.only:
        print("blender is not installed (Debian: apt-get install blender): Kindling alone", file=sys.stderr)
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        results = {job.name: compare_scene(job, arguments, kindling, blender, folder) for job in jobs}
    table = table_of(results)
    print(f"\n{arguments.spp} samples per pixel, {arguments.threads} threads, medians of {arguments.repeat}. " + table)
    if arguments.markdown:
        arguments.markdown.write_text(table, encoding="utf-8")
    if arguments.json:
        arguments.json.write_text(json.dumps({
            "machine": platform.processor() or platform.machine(), "spp": arguments.spp, "threads": arguments.threads,
            "repeat": arguments.repeat, "accelerator": arguments.accel, "scenes": results}, indent=1) + "\n", encoding="utf-8")
    if arguments.check_reference and not check_references(jobs, results):
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
