#!/usr/bin/env python3
"""Renders the material gallery, scenes/gallery/, with the name of each sphere below it.

    bench/gallery_images.py [-o scenes/images] [--only ior,sheen] [--spp 128] [--kindling PATH] [--sheet sheet.png]

Images are denoised, so Open Image Denoise must be installed (cmake/get_oidn.sh).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pixels
import renderers
from peers import gltf_json

GALLERY = renderers.ROOT / "scenes" / "gallery"
ROW_SIZE, WHOLE_SIZE = (686, 156), (728, 410)  # pixels
LABEL_HEIGHT = 22
FONT = Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")  # Debian: fonts-dejavu-core


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=renderers.ROOT / "scenes" / "images", help="folder (scenes/images)")
    parser.add_argument("--only", type=lambda text: text.split(","), help="names of scenes, without .glb")
    parser.add_argument("--spp", type=int, default=128, help="samples per pixel (128)")
    parser.add_argument("--scale", type=float, default=1.0, help="factor of the images' size (1)")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--flag", action="append", default=[], help="handed to every render")
    parser.add_argument("--sheet", type=Path, help="also write all rows on one sheet")
    arguments = parser.parse_args()
    kindling = renderers.find_kindling(arguments.kindling)
    scenes = [path for path in sorted(GALLERY.glob("*.glb")) if not arguments.only or path.stem in arguments.only]
    if not scenes:
        sys.exit(f"{GALLERY}: no such scene")
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            row = scene.stem != "material_gallery"
            width, height = (round(arguments.scale * pixels_) for pixels_ in (ROW_SIZE if row else WHOLE_SIZE))
            raw, output = Path(folder) / f"{scene.stem}.png", arguments.output / f"gallery_{scene.stem}.webp"
            started = time.perf_counter()
            subprocess.run([kindling, "render", scene, "-o", raw, "--size", f"{width}x{height}", "--spp", str(arguments.spp),
                            "--light-paths", "0.25", "--denoise", "best", "-q", *arguments.flag],
                           check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            if row:
                name_spheres(scene, raw, width, height)
                rows.append(raw)
            subprocess.run([pixels.oiiotool(), "-q", raw, "--compression", "webp:90", "-o", output], check=True)
            print(f"{output}: {time.perf_counter() - started:.1f} s, {output.stat().st_size // 1024} KiB", flush=True)
        if arguments.sheet and rows:
            subprocess.run([pixels.oiiotool(), "-q", *rows, "--mosaic:pad=2", f"1x{len(rows)}", "-o", arguments.sheet], check=True)


def name_spheres(scene, image, width, height):
    """Writes the names of the spheres' materials below them, into the image."""
    if not FONT.is_file():
        print(f"{FONT} is missing (Debian: apt-get install fonts-dejavu-core): the spheres have no names", file=sys.stderr)
        return
    words = ["--create", f"{width}x{height + LABEL_HEIGHT}", "3", "--fill:color=0.96,0.96,0.96", f"{width}x{height + LABEL_HEIGHT}",
             image, "--ch", "R,G,B", "--swap", "--paste", "+0+0"]
    for x, name in spheres(scene):
        words.append(f"--text:x={round(width * x)}:y={height + 16}:size=12:xalign=center:color=0.1,0.1,0.1:font={FONT}")
        words.append(name)
    subprocess.run([pixels.oiiotool(), "-q", *map(str, words), "-d", "uint8", "-o", image], check=True)


def spheres(scene):
    """(place across the image, 0 to 1; name) of each sphere of a row: the nodes on the x axis, seen along z."""
    document = gltf_json.read_json(scene)
    nodes = document["nodes"]
    camera = next(node for node in nodes if "camera" in node)
    lens = document["cameras"][camera["camera"]]["perspective"]
    half = math.tan(lens["yfov"] / 2) * lens["aspectRatio"] * math.dist(camera["translation"][1:], (0.455, 0.0))
    for node in nodes:
        at = node.get("translation", [0, 0, 1])
        if "mesh" in node and at[2] == 0 and node["name"] not in ("lamp",):
            yield 0.5 + at[0] / (2 * half), node["name"]


if __name__ == "__main__":
    main()
