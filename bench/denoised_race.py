"""Denoised images of Kindling and Cycles in equal time, for `equal_noise.py --denoise`.

Errors are those against a converged image of each. The time is that of path tracing and of the filter together. Kindling renders a number of samples and denoises them
(`--denoise best`); Cycles gets that time, measures itself, and takes as many samples as fit in beside its own filter.
"""
# SPDX-License-Identifier: Apache-2.0
import statistics
import subprocess
import sys
from dataclasses import replace

import with_numpy  # noqa: F401  (first: another Python may have to take over)

import denoise
import flip
import pixels
import renderers
from peers import run as peers

REFERENCE_SEED = 1_000_003  # not among the measured seeds
CONTESTANTS = ("kindling", "cycles")
FILTER_FLAGS = ["--denoise", "best"]


def measure_scene(job, options, kindling, folder):
    """The figures of one scene: a row for each number of Kindling's samples."""
    references = {name: reference_of(name, job, options, kindling, folder) for name in CONTESTANTS}
    wanted = {name: denoise.read(path) for name, path in references.items()}
    rows = []
    for spp in options.spp:
        results = {name: [] for name in CONTESTANTS}
        images = {}
        for seed in range(1, options.seeds + 1):
            ours = run_kindling(job, spp, seed, options, kindling, folder)
            theirs = peers.run_denoised("cycles", job, ours["total_s"], options.clock, seed, folder / f"{job.name}.cycles.{spp}.{seed}")
            for name, result in (("kindling", ours), ("cycles", theirs)):
                image = denoise.read(result["image"])
                results[name].append(result | {"relmse": denoise.rel_mse(image, wanted[name]),
                                               "flip": float(flip.flip(denoise.srgb(wanted[name]), denoise.srgb(image)).mean())})
                images.setdefault(name, result["image"])
        print(f"{job.name}: {spp} samples of Kindling done", file=sys.stderr, flush=True)
        rows.append({name: summary(results[name]) for name in CONTESTANTS} | {"spp": spp})
        if options.strips:
            write_strip([(images[name], references[name]) for name in CONTESTANTS], options.strips / f"{job.name}.{spp}.png")
    return {"name": job.name, "size_px": list(job.size_px), "reference_spp": options.reference_spp, "rows": rows}


def run_kindling(job, spp, seed, options, kindling, folder):
    """One denoised render; its time has training, path tracing and filter."""
    stem = folder / f"{job.name}.kindling.{spp}.{seed}"
    run = renderers.run_kindling(kindling, job, spp, seed, stem, options.common + FILTER_FLAGS)
    total_s = run.path_tracing_s + run.denoise_s
    if options.clock == "cpu":
        small = renderers.run_kindling(kindling, replace(job, size_px=(8, 8)), 1, seed, folder / f"{job.name}.setup", options.common)
        total_s = max(run.cpu_s - small.cpu_s, 1e-3)
    return {"image": run.image, "spp": spp, "total_s": total_s, "filter_s": run.denoise_s}


def reference_of(name, job, options, kindling, folder):
    """A converged image without a filter; one that is in the folder is used again."""
    stem = folder / f"{job.name}.{name}.reference.{options.reference_spp}"
    image = stem.with_name(stem.name + ".exr")
    if not image.is_file():
        if name == "kindling":
            renderers.run_kindling(kindling, job, options.reference_spp, REFERENCE_SEED, stem, options.common)
        else:
            peers.run(name, job, options.reference_spp, REFERENCE_SEED, stem)
    return image


def summary(results):
    """Medians of times and means of errors over the seeds."""
    return {"spp": statistics.median(result["spp"] for result in results)} | \
        {key: statistics.median(result[key] for result in results) for key in ("total_s", "filter_s")} | \
        {key: statistics.fmean(result[key] for result in results) for key in ("relmse", "flip")}


def write_strip(pairs, output):
    """Of each renderer the denoised image and the converged one, side by side, through the sRGB curve."""
    output.parent.mkdir(parents=True, exist_ok=True)
    images = [str(image) for pair in pairs for image in pair]
    shown = [part for image in images for part in (image, "--ch", "R,G,B", "--clamp:min=0:max=1", "--colorconvert", "linear", "sRGB")]
    subprocess.run([pixels.oiiotool(), "-q", *shown, "--mosaic:pad=2", f"{len(images)}x1", "-d", "uint8", "-o", str(output)], check=True)


def table_of(scenes):
    """Markdown: a line for each scene and number of samples; geometric means of the ratios last."""
    header = ["scene", "seconds: Kindling", "Cycles", "samples: Kindling", "Cycles", "relMSE: Kindling", "Cycles", "Cycles / Kindling",
              "FLIP: Kindling", "Cycles", "Cycles / Kindling"]
    lines, ratios = [header, ["---"] * len(header)], []
    for scene in scenes:
        for row in scene["rows"]:
            ours, theirs = row["kindling"], row["cycles"]
            ratios.append(tuple(max(theirs[key], 1e-9) / max(ours[key], 1e-9) for key in ("relmse", "flip")))
            lines.append([scene["name"], f"{ours['total_s']:.1f}", f"{theirs['total_s']:.1f}", f"{ours['spp']:g}", f"{theirs['spp']:g}",
                          f"{ours['relmse']:.4f}", f"{theirs['relmse']:.4f}", f"{ratios[-1][0]:.1f}",
                          f"{ours['flip']:.3f}", f"{theirs['flip']:.3f}", f"{ratios[-1][1]:.1f}"])
    means = [statistics.geometric_mean(column) for column in zip(*ratios)]
    lines.append(["geometric mean"] + [""] * 6 + [f"{means[0]:.1f}", "", "", f"{means[1]:.1f}"])
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines) + "\n"
