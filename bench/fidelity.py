#!/usr/bin/env python3
"""Renders scenarios of a folder of glTF models and compares them with other renderers.

    bench/fidelity.py FOLDER [-o fidelity.html] [--only PATTERN] [--spp 16] [--size 512]
    bench/fidelity.py FOLDER --compare fidelity.old.json     # exit code 1 if a scenario has moved away from its goldens

Writes one page that needs nothing else, sorted by difference, and all figures beside it as JSON. What a folder holds:
fidelity_scenarios.py; the figures: fidelity_images.py, flip.py, color_difference.py. How to read them: README.md.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import with_numpy  # noqa: F401
import fidelity_page
import fidelity_images
import fidelity_scenarios
import renderers

WORSE_BY = 0.005  # growth of the median FLIP that --compare calls a regression


def main():
    arguments = parse_arguments()
    scenarios = [scenario for scenario in fidelity_scenarios.read_folder(arguments.folder, arguments.scenarios, arguments.env)
                 if not arguments.only or any(fidelity_scenarios.matches(scenario, pattern) for pattern in arguments.only)]
    if not scenarios:
        sys.exit(f"{arguments.folder}: no scenario or model" + (" of that name" if arguments.only else ""))
    old = read_old(arguments.compare) if arguments.compare else {}
    kindling = renderers.find_kindling(arguments.renderer)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        jobs = [pool.submit(run, kindling, scenario, arguments, Path(temporary) / f"{number}.exr")
                for number, scenario in enumerate(scenarios)]
        records, images = [], {}
        for job in jobs:
            record, shown = job.result()
            if record["name"] in old:
                record["before"] = old[record["name"]]
            records.append(record)
            images[record["name"]] = shown
            print(line(record), flush=True)
    records.sort(key=order)
    result = {"settings": {"folder": arguments.folder.name, "spp": arguments.spp, "width": arguments.size, "oversample": arguments.oversample,
                           "flags": arguments.flag},
              "scenarios": records}
    arguments.output.write_text(fidelity_page.page(result, images), encoding="utf-8")
    figures = arguments.output.with_suffix(".json")
    figures.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"{len(records)} scenarios on {arguments.output}, figures in {figures}")
    return report(records, old)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("fidelity.html"), help="page; figures go beside it (fidelity.html)")
    parser.add_argument("--scenarios", type=Path, metavar="FILE.json", help="list of scenarios (render-fidelity.json of the folder)")
    parser.add_argument("--only", action="append", metavar="PATTERN", help="scenarios or models with this in their name; with *, ?: a whole name")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel (16)")
    parser.add_argument("--size", type=int, default=512, metavar="WIDTH", help="of images, pixels; goldens are resized to it (512)")
    parser.add_argument("--oversample", type=int, default=3, metavar="N", help="render N times as wide and scale the tone-mapped image down, "
                        "as goldens were made (3)")
    parser.add_argument("--renderer", "--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--env", type=Path, help="environment for models without a scenario (lightroom_14b.hdr, else the first)")
    parser.add_argument("--jobs", type=int, default=1, help="scenarios at once (1)")
    parser.add_argument("--threads", type=int, help="of each render (processors / jobs)")
    parser.add_argument("--timeout", type=float, default=1800, metavar="SECONDS", help="for one render (1800)")
    parser.add_argument("--flag", action="append", default=[], help="handed to every render, e.g. --flag=--caustics=off")
    parser.add_argument("--images", type=Path, metavar="FOLDER", help="also write our images there, tone-mapped, as PNG")
    parser.add_argument("--compare", type=Path, metavar="OLD.json", help="figures of an earlier run; exit code 1 if any grew by more than "
                        f"{WORSE_BY}")
    arguments = parser.parse_args()
    if arguments.oversample < 1:
        parser.error("--oversample: at least 1")
    arguments.jobs = max(arguments.jobs, 1)
    arguments.threads = arguments.threads or max((os.cpu_count() or 1) // arguments.jobs, 1)
    if arguments.images:
        arguments.images.mkdir(parents=True, exist_ok=True)
    return arguments


def run(kindling, scenario, arguments, image):
    """Renders and compares one scenario: (its record, its images). A render that fails is a record without figures."""
    width, height = arguments.size, max(round(arguments.size / scenario.aspect), 1)
    started = time.perf_counter()
    messages = render(kindling, scenario, arguments, (width * arguments.oversample, height * arguments.oversample), image)
    record = {"name": scenario.name, "model": scenario.model, "file": scenario.file.name, "aspect": width / height,
              "seconds": time.perf_counter() - started, "failed": not image.is_file(), "messages": messages, "goldens": {}}
    images = {"goldens": {}}
    if image.is_file():
        ours = fidelity_images.tone_mapped(fidelity_images.read(image))
        if arguments.oversample > 1:
            ours = fidelity_images.resized(ours, (width, height))
        image.unlink()
        alpha = None if scenario.skybox else ours.alpha
        images["ours"] = fidelity_images.encode(ours.rgb, alpha)
        if arguments.images:
            (arguments.images / f"{scenario.name}.png").write_bytes(fidelity_images.png(ours.rgb, alpha))
        for renderer, path in scenario.goldens.items():
            golden = fidelity_images.read(path, (width, height))
            record["goldens"][renderer], error = fidelity_images.compare(ours, golden, scenario.skybox)
            mime = "image/png" if path.suffix == ".png" else "image/webp"
            images["goldens"][renderer] = (mime, path.read_bytes(), fidelity_images.difference_png(error))
    record["summary"] = summarize(record["goldens"])
    return record, images


def render(kindling, scenario, arguments, size, image):
    """Writes the image; returns the renderer's warnings, or its whole output if it failed."""
    command = [kindling, "render", scenario.file, "-o", image, "--size", f"{size[0]}x{size[1]}", "--spp", arguments.spp, "--exr-float",
               "--threads", arguments.threads, "--progress", "none", *scenario.flags, *arguments.flag]
    try:
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL, timeout=arguments.timeout, check=False)
    except subprocess.TimeoutExpired:
        image.unlink(missing_ok=True)
        return f"not done after {arguments.timeout:g} s"
    output = done.stderr.replace(str(scenario.file), scenario.file.name).strip()
    if done.returncode != 0:
        image.unlink(missing_ok=True)
        return f"{output}\nexit code {done.returncode}".strip()
    return "\n".join(line for line in output.splitlines() if "warning:" in line)


def summarize(goldens):
    """Minimum and median over the goldens of path tracers, or over all goldens without one of these."""
    chosen = [g for name, g in goldens.items() if name in fidelity_scenarios.PATH_TRACERS] or list(goldens.values())
    summary = {}
    for key in ("flip", "delta_e"):
        values = [g[key] for g in chosen if g[key] is not None]
        summary[key + "_min"] = min(values) if values else None
        summary[key + "_median"] = statistics.median(values) if values else None
    return summary


def order(record):
    """Sort key: failures, then by falling difference, then scenarios without goldens."""
    flip = record["summary"]["flip_median"]
    return (0 if record["failed"] else 1 if flip is not None else 2, -(flip or 0.0), record["name"])


def line(record):
    summary = record["summary"]
    result = record["messages"].splitlines()[-1] if record["failed"] else "no goldens" if summary["flip_median"] is None else \
        f"FLIP {summary['flip_min']:.3f} minimum, {summary['flip_median']:.3f} median; delta E {summary['delta_e_median']:.1f}"
    return f"{record['name']}: {record['seconds']:.1f} s, {result}"


def read_old(path):
    try:
        old = json.loads(path.read_text(encoding="utf-8"))
        return {scenario["name"]: scenario["summary"]["flip_median"] for scenario in old["scenarios"]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        sys.exit(f"{path}: no figures of an earlier run: {error}")


def report(records, old):
    """Prints failures and, with old figures, changes; returns the exit code."""
    failed = [record["name"] for record in records if record["failed"]]
    for name in failed:
        print(f"not rendered: {name}")
    changes = [(record["summary"]["flip_median"] - record["before"], record) for record in records
               if record.get("before") is not None and record["summary"]["flip_median"] is not None]
    for change, record in sorted(changes, key=lambda c: -c[0]):
        if abs(change) > WORSE_BY:
            print(f"{'worse' if change > 0 else 'better'}: {record['name']}: {record['before']:.3f} -> {record['summary']['flip_median']:.3f}")
    if old:
        print(f"{sum(c > WORSE_BY for c, _ in changes)} worse, {sum(c < -WORSE_BY for c, _ in changes)} better of {len(changes)} compared")
    return 1 if failed or any(change > WORSE_BY for change, _ in changes) else 0


if __name__ == "__main__":
    sys.exit(main())
