#!/usr/bin/env python3
"""Measures denoising: errors against converged images, and flicker between frames.

    bench/denoise.py FOLDER --spp 4,16,64 --size 640x360 --reference-spp 2048
    bench/denoise.py scenes/interior.glb --spp 16 --flicker 4
    bench/denoise.py FOLDER --spp 16 --seeds 3 --setting alone="--path-reuse 1" --setting shared="--path-reuse 8"

Each scene is rendered with each seed for each --setting (flags of `kindling render`) and number of samples; `kindling denoise` filters
the same image by each quality. Figures are means over the seeds, times medians.
relMSE is the squared error relative to the squared radiance of the reference (bench/pixels.py); FLIP is the mean of
LDR-FLIP of the images through the sRGB curve (bench/flip.py), 0 for equal images. --flicker renders as many images that
differ in their seed alone, as frames of a scene in which nothing moves, and prints the mean standard deviation of a pixel
(sRGB, of 255). Open Image Denoise must be installed (cmake/get_oidn.sh).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True

import with_numpy  # noqa: F401  (first: another Python may have to take over)

import numpy as np

import flip
import pixels
import renderers
from settings import Setting, check_names, parse_setting

REFERENCE_SEED = 1_000_003  # not among the measured seeds
QUALITIES = ("fast", "best")
GUIDES = {"followed": "denoising_albedo,denoising_normal", "first": "albedo,normal"}


def parse_arguments(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=Path, help="folders (scenes.json and its scenes, or just glTF files) and glTF files")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="NAME,...", help="these scenes alone")
    parser.add_argument("--spp", default=[4, 16, 64], type=parse_counts, metavar="N,...", help="samples per pixel (4,16,64)")
    parser.add_argument("--size", type=renderers.parse_size, metavar="WxH", help="pixels (as scenes.json says, else 640x360)")
    parser.add_argument("--threads", type=int, default=2, help="of the renders and the filter (2)")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--reference-spp", type=int, metavar="N", help="render the references here (else those of scenes.json)")
    parser.add_argument("--guides", choices=GUIDES, default="followed",
                        help="albedo and normal of what mirrors and clear glass show, or of the first surfaces (followed)")
    parser.add_argument("--setting", action="append", default=[], metavar="NAME=FLAGS", type=parse_setting,
                        help="flags of `kindling render` (kindling=)")
    parser.add_argument("--seeds", type=int, default=1, help="renders by each (1)")
    parser.add_argument("--flicker", type=int, default=0, metavar="FRAMES", help="also measure flicker, with this many frames (0)")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep images there; references that are there are used again")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write all figures there")
    parser.add_argument("--markdown", type=Path, metavar="OUT", help="write the table there")
    options = parser.parse_args(arguments)
    if options.flicker == 1:
        parser.error("--flicker: one frame cannot flicker; use 2 or more")
    if options.seeds < 1:
        parser.error("--seeds: at least 1")
    options.setting = options.setting or [Setting("kindling", [])]
    check_names(parser, options.setting)
    return options


def parse_counts(text):
    counts = [int(word) for word in text.split(",")]
    if min(counts) < 1:
        raise argparse.ArgumentTypeError("samples per pixel must be at least 1")
    return counts


def measure_scenes(options, measure_scene):
    """The results of measure_scene(job, kindling, options, folder) for all chosen scenes; --keep names the folder of images."""
    jobs = renderers.load_jobs(options.scenes, scenes=options.only, size_px=options.size, threads=options.threads)
    kindling = renderers.find_kindling(options.kindling)
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for job in jobs:
            results.append(measure_scene(job, kindling, options, folder))
            print(f"{job.name}: done", file=sys.stderr, flush=True)
    return results


def main():
    options = parse_arguments()
    scenes = measure_scenes(options, measure)
    table = table_of(scenes)
    print(table)
    if options.markdown:
        options.markdown.write_text(table, encoding="utf-8")
    if options.json:
        options.json.write_text(json.dumps(scenes, indent=1) + "\n", encoding="utf-8")
    return 0


def measure(job, kindling, options, folder):
    """The figures of one scene: a row for each number of samples, setting and treatment. Seeds are the outermost loop, so that
    disturbances of the machine affect all settings."""
    reference = read(reference_of(job, kindling, options, folder))
    rows = {}
    for seed in range(1, options.seeds + 1):
        for spp in options.spp:
            for setting in options.setting:
                for row in measure_once(job, kindling, options, folder, reference, spp, setting, seed):
                    rows.setdefault((spp, setting.name, row["treatment"]), []).append(row)
    rows = [means(group) for group in rows.values()]
    if options.flicker:
        for i in range(0, len(rows), 3):
            setting = next(setting for setting in options.setting if setting.name == rows[i]["setting"])
            for row, value in zip(rows[i:i + 3], flicker(job, kindling, rows[i]["spp"], setting, options, folder)):
                row["flicker"] = value
    return {"name": job.name, "size_px": list(job.size_px), "rows": rows}


def measure_once(job, kindling, options, folder, reference, spp, setting, seed):
    """The rows of one render: noisy, and filtered by each quality."""
    run = render(job, kindling, spp, setting, seed, options, folder)
    images = {"noisy": (run.image, 0.0)}
    for quality in QUALITIES:
        images[quality] = denoise(kindling, run.image, quality, options.threads)
    for treatment, (image, filter_s) in images.items():
        shown = read(image)
        yield {"spp": spp, "setting": setting.name, "treatment": treatment, "relmse": rel_mse(shown, reference),
               "flip": float(flip.flip(srgb(reference), srgb(shown)).mean()), "render_s": run.path_tracing_s, "filter_s": filter_s}


def render(job, kindling, spp, setting, seed, options, folder):
    stem = folder / f"{job.name}.{spp}.{setting.name}.{seed}"
    return renderers.run_kindling(kindling, job, spp, seed, stem, ["--aov", GUIDES[options.guides], *setting.flags])


def means(rows):
    """One row for those of several seeds: means of errors, medians of times."""
    return rows[0] | {key: statistics.fmean(row[key] for row in rows) for key in ("relmse", "flip")} | {
        key: statistics.median(row[key] for row in rows) for key in ("render_s", "filter_s")}


def reference_of(job, kindling, options, folder):
    if not options.reference_spp:
        return job.reference or sys.exit(f"{job.name}: has no reference; add --reference-spp")
    stored = folder / f"{job.name}.reference.{options.reference_spp}.exr"
    if not stored.is_file():
        run = renderers.run_kindling(kindling, job, options.reference_spp, REFERENCE_SEED, folder / f"{job.name}.reference")
        run.image.rename(stored)
    return stored


def denoise(kindling, image, quality, threads):
    """Returns the denoised image, and the seconds that the filter took as `kindling denoise` reports them."""
    denoised = image.with_suffix(f".{quality}.exr")
    done = subprocess.run([str(kindling), "denoise", str(image), "-o", str(denoised), "--denoise", quality, "--exr-float",
                           "--threads", str(threads)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode} from kindling denoise: {done.stderr.strip()}")
    return denoised, seconds_of(done.stderr)


def seconds_of(report):
    """The time at the end of "denoised 640x360 with albedo and normal by Open Image Denoise 2.5.1, best in 1.23 s"."""
    lines = [line for line in report.splitlines() if line.startswith("denoised ")]
    number, unit = lines[-1].rsplit(" in ", 1)[1].split()
    return float(number) * {"ms": 1e-3, "s": 1.0, "min": 60.0}[unit]


def flicker(job, kindling, spp, setting, options, folder):
    """The mean standard deviation of a pixel over frames that differ in their seed, for each treatment."""
    frames = {name: [] for name in ("noisy", *QUALITIES)}
    for seed in range(options.seeds + 1, options.seeds + 1 + options.flicker):
        image = render(job, kindling, spp, setting, seed, options, folder).image
        frames["noisy"].append(srgb(read(image)))
        for quality in QUALITIES:
            frames[quality].append(srgb(read(denoise(kindling, image, quality, options.threads)[0])))
    return [float(255.0 * np.std(np.stack(group), axis=0, ddof=1).mean()) for group in frames.values()]


def read(path):
    image = pixels.read_rgb(path)
    return np.array(image.rgb, np.float64).reshape(image.height, image.width, 3)


def rel_mse(image, reference):
    """As pixels.error() and pixels.rel_mse(): the worst pixels are left out."""
    floor = pixels.RADIANCE_FLOOR * reference.mean() ** 2 + 1e-20
    errors = np.sort(((image - reference) ** 2 / (reference ** 2 + floor)).mean(axis=2), axis=None)
    return float(errors[:len(errors) - int(len(errors) * pixels.TRIMMED_FRACTION)].mean())


def srgb(linear):
    clamped = np.clip(linear, 0.0, 1.0)
    return np.where(clamped > 0.0031308, 1.055 * clamped ** (1.0 / 2.4) - 0.055, 12.92 * clamped)


def table_of(scenes):
    """Markdown: a line for each scene, number of samples and setting; settings are named if there are several."""
    flickers = any("flicker" in row for scene in scenes for row in scene["rows"])
    names = len({row["setting"] for scene in scenes for row in scene["rows"]}) > 1
    lines = ["| scene | samples |" + (" setting |" if names else "") + " relMSE noisy | fast | best | FLIP noisy | fast | best | render s | fast s | best s |" +
             (" flicker noisy | fast | best |" if flickers else ""),
             "|---|" + "---|" * (10 + 3 * flickers + names)]
    for scene in scenes:
        for i in range(0, len(scene["rows"]), 3):
            noisy, fast, best = rows = scene["rows"][i:i + 3]
            cells = [scene["name"], str(noisy["spp"])] + ([noisy["setting"]] if names else [])
            cells += [f"{row['relmse']:.4f}" for row in rows] + [f"{row['flip']:.3f}" for row in rows]
            cells += [f"{noisy['render_s']:.1f}", f"{fast['filter_s']:.2f}", f"{best['filter_s']:.2f}"]
            if flickers:
                cells += [f"{row['flicker']:.2f}" for row in rows]
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
