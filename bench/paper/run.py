#!/usr/bin/env python3
"""Renders the figures of "Research on ray tracing", repeats its measurements and writes a page.

    bench/paper/run.py                                    # out/paper.html, images at the paper's sizes
    bench/paper/run.py --figures 5,7 --scale 2 --out big.html
    bench/paper/run.py --parts tracers,cores --repeat 9
    bench/paper/run.py --figures 9,10,11,12,13,14,15,16 --device gpu     # the images of the paper's GPU, by one
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import datetime
import json
import math
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # the modules that all scripts share
import with_numpy  # noqa: F401  (starts a Python that has NumPy)

import cores
import edges
import fidelity_images
import figures
import page
import pixels
import renderers
import tracers
from measure import Bench

PARTS = ["figures", "tracers", "bounces", "antialiasing", "cores"]
SHEET_PX, SHEET_COLUMNS = (228, 187), 5
IMAGE_QUALITY, THUMBNAIL_PX = 80, 180  # of WebP; the page holds some thirty images
ONE_CORE_PART = 8  # one core renders this part of the samples, at least one, and its time is multiplied


def main():
    arguments = parse_arguments()
    chosen = figures.find(arguments.figures) if arguments.figures else figures.FIGURES
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(renderers.find_kindling(arguments.kindling), folder, arguments.scale, arguments.flag, arguments.clock)
        bench.check()
        result = measure(bench, arguments, chosen)
        if arguments.sheet and result.get("figures"):
            contact_sheet(result["figures"], Path(folder), arguments.sheet)
    save(result, arguments.out)
    bench.say(f"{arguments.out} ({arguments.out.stat().st_size / 1e6:.1f} MB), figures in {arguments.out.with_suffix('.json')}")
    renders = [render for figure in result.get("figures", ()) for scene in figure["scenes"] for render in scene["renders"]]
    same = all(render["device"]["same"] for render in renders if render["device"])
    return 0 if same and result.get("processes", {"same": True})["same"] else 1


def save(result, out):
    """Writes the page and, beside it, its figures as JSON."""
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(page.page(result), encoding="utf-8")
    data = json.dumps(result, indent=1, default=lambda value: None if isinstance(value, bytes) else vars(value))
    out.with_suffix(".json").write_text(data + "\n", encoding="utf-8")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--out", type=Path, default=Path("out/paper.html"), help="page to write; its figures go beside it as JSON (default: out/paper.html)")
    parser.add_argument("--figures", type=words, metavar="N,N", help="only these images, and no other part unless --parts names it")
    parser.add_argument("--parts", type=words, metavar="NAME,NAME", help=f"of {', '.join(PARTS)} (all)")
    parser.add_argument("--scale", type=positive, default=1.0, help="of all images' sizes (1)")
    parser.add_argument("--spp-scale", type=positive, default=1.0, help="of all numbers of samples (1)")
    parser.add_argument("--repeat", type=int, default=5, help="interleaved rounds of what is timed (5)")
    parser.add_argument("--seconds", type=float, default=math.inf, help="no figure begins after that time (no limit)")
    parser.add_argument("--clock", choices=["wall", "cpu"], default="wall", help="kind of times; cpu: for busy machines, on one core only (wall)")
    parser.add_argument("--quick", action="store_true", help="small images, few samples, few depths, one round: a test of the script")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--device", help="also render the figures there, as kindling render --device does: times, and whether the images are the same")
    parser.add_argument("--flag", action="append", default=[], help="passed to every render, e.g. --flag=--accel=embree")
    parser.add_argument("--images", type=Path, metavar="FOLDER", help="also write the figures' images there, as WebP")
    parser.add_argument("--sheet", type=Path, metavar="FILE.webp", help="also lay the last image of each scene on one sheet")
    arguments = parser.parse_args()
    arguments.parts = arguments.parts or (["figures"] if arguments.figures else PARTS)
    if unknown := [part for part in arguments.parts if part not in PARTS]:
        parser.error(f"--parts: no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    if arguments.repeat < 1:
        parser.error(f"--repeat {arguments.repeat}: at least 1 was expected")
    if arguments.quick:
        arguments.scale, arguments.spp_scale, arguments.repeat = min(arguments.scale, 0.15), min(arguments.spp_scale, 0.05), 1
    return arguments


def words(text):
    return [word.strip() for word in text.split(",") if word.strip()]


def positive(text):
    value = float(text)
    if not 0.0 < value <= 100.0:
        raise argparse.ArgumentTypeError(f"{text}: a number above 0, at most 100, was expected")
    return value


def measure(bench, arguments, chosen):
    result = {"about": {"machine": processor(), "cores": bench.cores, "version": "", "when": datetime.date.today().isoformat(), "clock": arguments.clock,
                        "note": "Quick run: small images and few samples; the figures mean nothing." if arguments.quick else ""}}
    quick, repeats = arguments.quick, arguments.repeat
    if "tracers" in arguments.parts:
        depths = [1, 2, 4] if quick else list(range(1, 13))
        by_depth = tracers.by_depth(bench, depths, min(repeats, 3), depths[::2] if quick else [1, 4, 12])
        result["tracers"] = {"by_depth": by_depth, "contributions": [tracers.contributions(bench, depth, repeats) for depth in ([4] if quick else [5, 12])]}
    if "bounces" in arguments.parts:
        bench.say("figure 2")
        result["quality"] = tracers.quality(bench, 4 if quick else 12, 1 if quick else 16)
    if "antialiasing" in arguments.parts:
        result["edges"] = edges.compare(bench, 16 if quick else 1024)
    if "cores" in arguments.parts:
        result["threads"] = cores.by_threads(bench, min(repeats, 3))
        result["processes"] = cores.by_processes(bench)
    if "figures" in arguments.parts:
        result["figures"] = []
        for figure in chosen:
            if bench.elapsed_s() > arguments.seconds:
                bench.say(f"figures {figure.number} to {chosen[-1].number}: left out, {arguments.seconds:.0f} seconds are over")
                break
            result["figures"].append(render_figure(bench, arguments, figure))
            result["about"]["version"] = bench.version
            save(result, arguments.out)
    result["about"]["version"] = bench.version
    return result


def render_figure(bench, arguments, figure):
    scenes = []
    for scene, caption in figure.scenes:
        scenes.append({"caption": caption, "then": figure.then.get(scene, ""),
                       "renders": [render_way(bench, arguments, figure, scene, way) for way in figure.ways]})
    return {"number": figure.number, "title": figure.title, "paper": figure.paper, "machine": figure.machine, "size_stated": figure.size_stated,
            "shown_px": max(bench.scaled(figure.size_px)[0], 300), "scenes": scenes}


def render_way(bench, arguments, figure, scene, way):
    """Renders the image on all cores; on one core an eighth of the samples for the time, times eight."""
    size = bench.scaled(figure.size_px)
    spp = max(round(way.spp * arguments.spp_scale), 1)
    bench.say(f"figure {figure.number}: {scene}, {way.name}, {size[0]} x {size[1]}, {spp} samples")
    if bench.clock == "cpu":
        result = bench.timed(scene, size, spp, way.flags, bench.cores, "png")
        one_core_s, all_cores_s = result.cost_s, None
    else:
        result = bench.render(scene, size, spp, way.flags)
        part = max(spp // ONE_CORE_PART, 1)
        one = bench.render(scene, size, part, way.flags, threads=1)
        one_core_s, all_cores_s = one.render_s * spp / part, result.render_s
    rgb = fidelity_images.read(result.image).rgb
    device = on_device(bench, arguments.device, scene, size, spp, way, rgb) if arguments.device else None
    encoded = tracers.encode(rgb, IMAGE_QUALITY)
    if arguments.images:
        arguments.images.mkdir(parents=True, exist_ok=True)
        kind = "path" if "path" in way.flags else "whitted"
        (arguments.images / f"{scene}_{kind}{'_1' if spp == 1 else ''}.webp").write_bytes(encoded)
    return {"name": way.name, "spp": result.stats["spp_mean"], "size_px": size, "device": device, "all_cores_s": all_cores_s, "one_core_s": one_core_s,
            "rays_per_s": result.stats["rays"]["total"] / (all_cores_s or one_core_s), "image": encoded, "thumbnail": tracers.encode(thumbnail(rgb), IMAGE_QUALITY), "command": result.command,
            "warnings": result.warnings}


def on_device(bench, device, scene, size, spp, way, expected):
    """Renders the image on a device too."""
    result = bench.render(scene, size, spp, [*way.flags, "--device", device])
    return {"name": result.stats["device"]["name"], "render_s": result.render_s, "start_s": result.stats["device"]["start_s"],
            "same": bool((fidelity_images.read(result.image).rgb == expected).all())}


def thumbnail(rgb):
    """Every n-th pixel's surroundings averaged: for the page's list of figures."""
    step = max(rgb.shape[1] // THUMBNAIL_PX, 1)
    height, width = rgb.shape[0] // step * step, rgb.shape[1] // step * step
    return rgb[:height, :width].reshape(height // step, step, width // step, step, 3).mean(axis=(1, 3))


def contact_sheet(chosen, folder, output):
    """Five in a row, all of one size."""
    images = []
    for number, scene in enumerate(scene for figure in chosen for scene in figure["scenes"]):
        images.append(folder / f"sheet{number}.webp")
        images[-1].write_bytes(scene["renders"][-1]["image"])
    width, height = SHEET_PX
    words = [word for path in images for word in (path, "--resize", f"{width}x{height}")]
    rows = math.ceil(len(images) / SHEET_COLUMNS)
    output.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([pixels.oiiotool(), "-q", *map(str, words), "--mosaic:pad=4", f"{min(SHEET_COLUMNS, len(images))}x{rows}", "-d", "uint8",
                    "--compression", "webp:88", "-o", str(output)], check=True)


def processor():
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    sys.exit(main())
