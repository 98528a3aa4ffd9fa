#!/usr/bin/env python3
"""Measures the cost of equal noise: several settings of Kindling, and other renderers, in one run.

    bench/equal_noise.py scenes/interior.glb --setting full= --setting "clamped=--clamp-indirect 10" --spp 4,16,64
    bench/equal_noise.py FOLDER --cycles --spp 16 --seeds 2 --check-reference
    bench/equal_noise.py FOLDER --peers cycles,mitsuba,luxcore --clock cpu
    bench/equal_noise.py FOLDER --peers mitsuba_cuda --setting "gpu=--device gpu" --spp 256
    bench/equal_noise.py FOLDER --denoise --reference-spp 1024 --spp 4,16 --size 320x180 --clock cpu

All get the same camera, environment, size, bounces and threads, and a box filter; none gets denoising, clamps or
adaptive sampling. --peers installs the renderers from PyPI where they are missing (peers/README.md) and leaves them out of scenes
that they cannot render; --cycles takes an installed Blender. Seeds are the outermost loop, so that disturbances of the machine
affect all settings; times are medians. Only path tracing counts as time: not import, texture decoding,
building or the start of a device. With --denoise both Kindling and Cycles denoise their images, in equal time (denoised_race.py).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import math
import platform
import re
import shlex
import statistics
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import equal_noise_page
import pixels
import plots
import renderers
from peers import install as peer_packages
from peers import run as peers
from settings import Setting, check_names, parse_setting

REFERENCE_TOLERANCE = 0.005  # largest relative difference of a channel's mean that --check-reference accepts
REFERENCE_SEED = 1_000_003  # for references that are rendered here; not among the measured seeds
CYCLES = "cycles"
ANOTHER_SCENE = 0.5  # relative difference of a renderer's image that other models of materials hardly explain


def parse_arguments(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=Path, help="folders (scenes.json and its scenes, or just glTF files) and glTF files")
    parser.add_argument("--setting", action="append", default=[], metavar="NAME=FLAGS", type=parse_setting,
                        help="flags of `kindling render`; ratios are relative to the first setting (kindling=)")
    parser.add_argument("--common", default=[], type=shlex.split, metavar="FLAGS", help="flags of all settings, and of references")
    parser.add_argument("--cycles", action="store_true", help="Cycles as well, where blender is installed")
    parser.add_argument("--peers", default=[], type=parse_peers, metavar="NAME,...",
                        help=f"other renderers, from PyPI: {', '.join(peer_packages.PACKAGES)}")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="NAME,...", help="these scenes alone")
    parser.add_argument("--spp", default=[16], type=parse_counts, metavar="N,...", help="samples per pixel (16)")
    parser.add_argument("--size", type=renderers.parse_size, metavar="WxH", help="pixels (as scenes.json says, else 640x360)")
    parser.add_argument("--seeds", type=int, default=3, help="renders by each, at least 2 (3)")
    parser.add_argument("--threads", type=int, default=2, help="of each renderer (2)")
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall",
                        help="cpu: time on all threads, for Kindling that of the process without that of a render of 8 x 8 pixels (wall)")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--reference-spp", type=int, metavar="N", help="render the references here, with the common flags alone")
    parser.add_argument("--denoise", action="store_true",
                        help="instead: images denoised by Open Image Denoise against those of Cycles in equal time, with errors against a "
                             "converged image of each (--reference-spp)")
    parser.add_argument("--strips", type=Path, metavar="FOLDER", help="with --denoise: write denoised and converged images of both, side by side, there")
    parser.add_argument("--check-reference", action="store_true",
                        help="exit 1 if the mean of a channel differs from the reference's by more than 0.5 %%")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write all figures there")
    parser.add_argument("--markdown", type=Path, metavar="OUT", help="write the table there")
    parser.add_argument("--html", type=Path, metavar="OUT", help="write a page with plots and images there")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep images and logs there")
    options = parser.parse_args(arguments)
    if options.denoise:
        check_denoise(parser, options)
    elif options.seeds < 2:
        parser.error("--seeds: noise needs at least 2 renders")
    elif options.strips:
        parser.error("--strips: has no meaning without --denoise")
    if options.clock == "cpu" and options.cycles:
        parser.error("--clock cpu: the CPU time of Blender includes more than Cycles; use --clock wall")
    if options.clock == "cpu" and "mitsuba_cuda" in options.peers:
        parser.error("--clock cpu: a GPU's work takes no CPU time; use --clock wall")
    if options.cycles and CYCLES in options.peers:
        parser.error("--cycles and --peers cycles: give one of them")
    options.setting = options.setting or [Setting("kindling", [])]
    check_names(parser, options.setting)
    return options


def check_denoise(parser, options):
    if not options.reference_spp:
        parser.error("--denoise: errors need converged images; add --reference-spp")
    if options.seeds < 1:
        parser.error("--seeds: at least 1")
    for flag in ("setting", "cycles", "peers", "check_reference", "html"):
        if getattr(options, flag):
            parser.error(f"--{flag.replace('_', '-')}: has no meaning with --denoise, a race of Kindling and Cycles from PyPI")


def parse_peers(text):
    names = text.split(",")
    if unknown := [name for name in names if name not in peer_packages.PACKAGES]:
        raise argparse.ArgumentTypeError(f"no renderer '{unknown[0]}'; there are {', '.join(peer_packages.PACKAGES)}")
    return list(dict.fromkeys(names))


def parse_counts(text):
    counts = [int(word) for word in text.split(",") if re.fullmatch(r"[1-9]\d*", word)]
    if not counts or len(counts) < len(text.split(",")):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of numbers, as in 4,16,64")
    return sorted(set(counts))


def main():
    options = parse_arguments()
    jobs = renderers.load_jobs(options.scenes, scenes=options.only, size_px=options.size, threads=options.threads)
    kindling = renderers.find_kindling(options.kindling)
    if options.denoise:
        return race_denoised(jobs, kindling, options)
    blender = renderers.find_blender() if options.cycles else None
    if options.cycles and not blender:
        print("blender is not installed (Debian: apt-get install blender): Kindling alone", file=sys.stderr)
    others = ([CYCLES] if blender else []) + (peers.prepare(options.peers) if options.peers else [])
    settings = options.setting + [Setting(name, []) for name in others]
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        scenes = [measure_scene(job, settings, options, kindling, blender, folder) for job in jobs]
    result = {"machine": platform.processor() or platform.machine(), "threads": options.threads, "seeds": options.seeds,
              "clock": options.clock, "common_flags": options.common, "settings": {s.name: s.flags for s in settings}, "scenes": scenes}
    table = table_of(result)
    print(f"\n{options.threads} threads, {options.seeds} seeds, median {options.clock} times.\n\n{table}")
    if options.markdown:
        options.markdown.write_text(table, encoding="utf-8")
    if options.html:
        options.html.write_text(equal_noise_page.page(result, table), encoding="utf-8")
    if options.json:
        for scene in scenes:
            scene.pop("images")
        options.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return 0 if not options.check_reference or check_references(scenes) else 1


def race_denoised(jobs, kindling, options):
    import denoised_race  # needs NumPy
    if peers.prepare(["cycles"]) != ["cycles"]:
        return 1
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        scenes = [denoised_race.measure_scene(job, options, kindling, folder) for job in jobs]
    table = denoised_race.table_of(scenes)
    print(f"\n{options.threads} threads, {options.seeds} seeds, {options.clock} times.\n\n{table}")
    if options.markdown:
        options.markdown.write_text(table, encoding="utf-8")
    if options.json:
        options.json.write_text(json.dumps({"threads": options.threads, "seeds": options.seeds, "clock": options.clock, "scenes": scenes}, indent=1) + "\n",
                                encoding="utf-8")
    return 0


# --- measuring

def measure_scene(job, settings, options, kindling, blender, folder):
    """The figures of one scene, a row for each setting and count of samples, and its small images if a page wants them."""
    runs = {(setting.name, spp): [] for setting in settings for spp in options.spp}

    def leave_out(name, reason):
        print(f"{job.name}: {name}: left out: {reason}", file=sys.stderr)
        for spp in options.spp:
            runs.pop((name, spp), None)

    for seed in range(1, options.seeds + 1):
        if options.clock == "cpu":
            small = replace(job, size_px=(8, 8))
            setup_s = {setting.name: renderers.run_kindling(kindling, small, 1, seed, folder / f"{job.name}.setup",
                                                            options.common + setting.flags).cpu_s for setting in options.setting}
        for spp in options.spp:
            for setting in settings:
                if (setting.name, spp) not in runs:
                    continue
                stem = folder / f"{job.name}.{setting.name}.{spp}.{seed}"
                try:
                    run = (peers.run(setting.name, job, spp, seed, stem) if setting.name in options.peers else
                           renderers.run_cycles(blender, job, spp, seed, stem) if setting.name == CYCLES else
                           renderers.run_kindling(kindling, job, spp, seed, stem, options.common + setting.flags))
                except renderers.Failed as error:
                    if setting.name not in options.peers:
                        raise
                    leave_out(setting.name, error)
                    continue
                if options.clock == "cpu":
                    run.path_tracing_s = run.path_tracing_cpu_s or max(run.cpu_s - setup_s[setting.name], 1e-3)
                runs[setting.name, spp].append(run)
        print(f"{job.name}: seed {seed} of {options.seeds} done", file=sys.stderr)

    reference_file = job.reference
    if options.reference_spp:
        reference_file = renderers.run_kindling(kindling, job, options.reference_spp, REFERENCE_SEED,
                                                folder / f"{job.name}.reference", options.common).image
    reference = pixels.read_rgb(reference_file) if reference_file else None
    if reference and (reference.width, reference.height) != tuple(job.size_px):
        print(f"{job.name}: {reference_file} is {reference.width}x{reference.height}: not compared", file=sys.stderr)
        reference = None
    images = {key: [pixels.read_rgb(run.image) for run in group] for key, group in runs.items()}
    for name in options.peers:
        if not all(math.isfinite(value) for spp in options.spp for image in images.get((name, spp), []) for value in image.rgb):
            leave_out(name, "its image has values that are not finite")
    images = {key: group for key, group in images.items() if key in runs}
    # The scale of relative errors is the same for all settings.
    scale = reference or pixels.mean_image([p for (_, spp), group in images.items() if spp == options.spp[-1] for p in group])
    rows = [figures(job, name, spp, group, images[name, spp], scale, reference) for (name, spp), group in runs.items()]
    compare_with_first(job, rows, images, scale, options)
    return {"name": job.name, "size_px": list(job.size_px), "reference": str(reference_file) if reference else None, "rows": rows,
            "images": small_images(runs, reference_file if reference else None, scale) if options.html else None}


def compare_with_first(job, rows, images, scale, options):
    """Adds to the rows of other renderers how much their images differ from those of the first setting; a warning where they may
    show another scene."""
    first, own = options.setting[0].name, {setting.name for setting in options.setting}
    for row in rows:
        if row["setting"] not in own:
            row["difference"] = pixels.difference(images[row["setting"], row["spp"]], images[first, row["spp"]], scale)
            if row["difference"] > ANOTHER_SCENE:
                print(f"{job.name}: {row['setting']}: its image differs from that of {first} by {100 * row['difference']:.0f} %: "
                      "look whether it shows the same scene", file=sys.stderr)


def figures(job, name, spp, runs, images, scale, reference):
    """The figures of one setting at one count of samples, for the table and the file."""
    path_tracing_s = statistics.median(run.path_tracing_s for run in runs)
    noise = pixels.noise(images, scale)
    means = list(zip(*(image.mean() for image in images)))
    row = {
        "setting": name, "spp": spp,
        "mpaths_per_s": (runs[0].samples or job.paths(spp)) / path_tracing_s / 1e6,
        "path_tracing_s": path_tracing_s, "path_tracing_s_of_runs": [run.path_tracing_s for run in runs],
        "noise": pixels.rel_mse(noise), "noise_all_pixels": pixels.rel_mse(noise, dropped=0.0),
        "noise_x_s": pixels.rel_mse(noise) * path_tracing_s,
        "peak_mb": statistics.median(run.peak_mb for run in runs),
        "first_sample_s": statistics.median(run.first_sample_s for run in runs),
        "process_s": statistics.median(run.process_s for run in runs),
        "mean": [statistics.fmean(channel) for channel in means],
        "mean_standard_error": [statistics.stdev(channel) / math.sqrt(len(runs)) for channel in means],
    }
    if reference:
        error = pixels.error(images, reference)
        row["error"] = pixels.rel_mse(error)
        row["error_all_pixels"] = pixels.rel_mse(error, dropped=0.0)
        row["mean_against_reference"] = [found / wanted - 1.0 if wanted > 0 else 0.0
                                         for found, wanted in zip(row["mean"], reference.mean())]
    return row


def small_images(runs, reference, scale):
    """[(caption, setting or None, spp or None, PNG)], all with one exposure."""
    mean = sum(scale.rgb) / len(scale.rgb)
    gain = 0.25 / mean if mean > 0 else 1.0
    width = equal_noise_page.IMAGE_WIDTH if scale.width > equal_noise_page.IMAGE_WIDTH else None
    images = [(f"{name}, {spp} sample{'s' if spp > 1 else ''}", name, spp, pixels.small_png(group[0].image, width, gain))
                for (name, spp), group in runs.items()]
    if reference:
        images.append(("reference", None, None, pixels.small_png(reference, width, gain)))
    return images


# --- reporting

def series(scene, setting):
    return [row for row in scene["rows"] if row["setting"] == setting]


def slope_of(rows, key):
    """Slope of log error against log time: -1 for pure noise, nearer to 0 where samples reduce the error less."""
    return plots.slope([(math.log(row["path_tracing_s"]), math.log(row[key])) for row in rows if row.get(key)])


def ratio(scene, row, first):
    """relMSE x s over that of the first setting at as many samples: below 1, equal noise costs less. None without noise."""
    base = next(other for other in series(scene, first) if other["spp"] == row["spp"])
    return row["noise_x_s"] / base["noise_x_s"] if row["noise_x_s"] > 0 and base["noise_x_s"] > 0 else None


def table_of(result):
    """A Markdown table, a line for each scene, setting and count of samples; geometric means of the ratios last."""
    names, scenes = list(result["settings"]), result["scenes"]
    with_reference = any(scene["reference"] for scene in scenes)
    header = ["scene", "setting", "spp", "M samples/s", "relMSE", "relMSE x s", f"over {names[0]}", "slope"]
    header += ["relMSE to reference", "mean"] if with_reference else []
    with_others = any("difference" in row for scene in scenes for row in scene["rows"])
    header += ["image differs"] if with_others else []
    lines = [header + ["peak MB", "first sample s"], ["---"] * (len(header) + 2)]
    for scene in scenes:
        for name in names:
            rows = series(scene, name)
            slope = slope_of(rows, "noise")
            for number, row in enumerate(rows):
                over_first = ratio(scene, row, names[0])
                cells = [scene["name"], name, str(row["spp"]), f"{row['mpaths_per_s']:.3g}", f"{row['noise']:.4g}",
                         f"{row['noise_x_s']:.4g}", f"{over_first:.3f}" if over_first else "",
                         f"{slope:.2f}" if slope is not None and number == len(rows) - 1 else ""]
                if with_reference:
                    cells += [f"{row['error']:.4g}", f"{100 * statistics.fmean(row['mean_against_reference']):+.2f} %"] \
                        if "error" in row else ["", ""]
                if with_others:
                    cells.append(f"{100 * row['difference']:.0f} %" if "difference" in row else "")
                lines.append(cells + [f"{row['peak_mb']:.0f}", f"{row['first_sample_s']:.2f}"])
    for name in names[1:]:
        values = [ratio(scene, row, names[0]) for scene in scenes for row in series(scene, name)]
        if values and all(values):
            mean = statistics.geometric_mean(values)
            lines.append(["geometric mean", name, "", "", "", "", f"{mean:.3f}"] + [""] * (len(header) - 5))
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines) + "\n"


def check_references(scenes):
    """Prints the relative difference of each channel's mean from the reference. Returns whether Kindling is within the limit."""
    good = True
    for scene in scenes:
        if not scene["reference"]:
            print(f"{scene['name']}: no reference image, not checked")
            continue
        for row in scene["rows"]:
            differences = row["mean_against_reference"]
            errors = [error / mean if mean > 0 else 0.0 for error, mean in zip(row["mean_standard_error"], row["mean"])]
            within = all(abs(difference) <= REFERENCE_TOLERANCE for difference in differences)
            text = ", ".join(f"{channel} {100 * difference:+.2f} % (standard error {100 * error:.2f} %)"
                             for channel, difference, error in zip("RGB", differences, errors))
            print(f"{scene['name']}: {row['setting']}, {row['spp']} samples: {text}{'' if within else '  BEYOND 0.5 %'}")
            good = good and (within or row["setting"] in peer_packages.PACKAGES)
    return good


if __name__ == "__main__":
    sys.exit(main())
