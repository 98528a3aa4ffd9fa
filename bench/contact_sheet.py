#!/usr/bin/env python3
"""Renders every glTF file of a folder at a small size and lays the images out on one sheet.

Where the folder has a render-fidelity.json (as glTF-Render-Fidelity-Generator's), a model's first scenario gives camera, size
and environment, and a golden of another renderer, where there is one, is laid beside the image. Other models are rendered
as they come: their own camera or one fitted to them.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import math
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import fidelity_scenarios
import renderers

TILE_WIDTH = 256
TILE_HEIGHT = 256
LABEL_HEIGHT = 18
FONT = Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")  # Debian: fonts-dejavu-core


@dataclass
class Entry:
    name: str
    scene: Path
    flags: list = field(default_factory=list)  # camera, environment and background for `kindling render`
    aspect: float = 4 / 3
    golden: Path | None = None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("contact_sheet.png"), help="(contact_sheet.png)")
    parser.add_argument("--only", type=lambda text: text.lower().split(","), help="models with one of these in their name")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel (16)")
    parser.add_argument("--columns", type=int, default=8, help="images in a row (8)")
    parser.add_argument("--env", type=Path, help="environment for models without a scenario (the folder's first)")
    parser.add_argument("--golden", default="blender-cycles", metavar="RENDERER", help="renderer of the goldens beside the images (blender-cycles); none: no goldens")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--flag", action="append", default=[], help="handed to every render, e.g. --flag=--integrator=normal")
    arguments = parser.parse_args()
    if not shutil.which("oiiotool"):
        sys.exit("oiiotool is not installed (Debian: apt-get install openimageio-tools)")
    if not FONT.is_file():
        print(f"{FONT} is missing (Debian: apt-get install fonts-dejavu-core): the sheet has no names", file=sys.stderr)
    kindling = renderers.find_kindling(arguments.kindling)
    entries = [entry for entry in find_entries(arguments)
               if not arguments.only or any(word in entry.name.lower() for word in arguments.only)]
    if not entries:
        sys.exit(f"{arguments.folder}: no glTF file to render")
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        tiles = []
        for number, entry in enumerate(entries):
            new_tiles = render_entry(kindling, entry, arguments, Path(temporary), number, failed)
            if len(tiles) % arguments.columns + len(new_tiles) > arguments.columns:  # an image and its golden stay side by side
                tiles.append(make_tile(None, "", Path(temporary) / f"{number}.empty.png"))
            tiles += new_tiles
        rows = math.ceil(len(tiles) / arguments.columns)
        subprocess.run(["oiiotool", *tiles, "--mosaic:pad=4", f"{min(arguments.columns, len(tiles))}x{rows}", "--ch", "R,G,B",
                        "-d", "uint8", "-o", arguments.output], check=True)
    print(f"{len(entries)} models on {arguments.output}")
    for name, message in failed:
        print(f"not rendered: {name}: {message}")
    return 1 if failed else 0


def find_entries(arguments):
    """One entry for each model: a .glb, or a .gltf (of several the one named after its folder)."""
    folder = arguments.folder
    environments = fidelity_scenarios.find_environments(folder)
    default_env = arguments.env or environments.get(fidelity_scenarios.DEFAULT_ENVIRONMENT) or next(iter(environments.values()), None)
    scenarios = {}
    for entry in fidelity_scenarios.read_list(folder):
        scenarios.setdefault(fidelity_scenarios.model_of(entry["model"]), entry)
    for scene in sorted(path for path in folder.rglob("*") if path.suffix.lower() in (".glb", ".gltf")):
        relative = scene.relative_to(folder)
        name = relative.parts[0] if len(relative.parts) > 1 else scene.stem
        scenario = scenarios.get(name)
        golden = None
        if scenario:
            flags, aspect = fidelity_scenarios.scenario_flags(scenario, environments, default_env)
            golden = fidelity_scenarios.find_goldens(folder / name / "goldens" / scenario["name"]).get(arguments.golden)
            name = scenario["name"]
        else:
            flags, aspect = (["--env", default_env] if default_env else []), 4 / 3
        yield Entry(name, scene, flags, aspect, golden)


def render_entry(kindling, entry, arguments, folder, number, failed):
    """The tile of one model and, if it has a golden, that of the golden. A failure becomes a dark tile."""
    width, height = TILE_WIDTH, round(TILE_WIDTH / entry.aspect)
    if height > TILE_HEIGHT:
        width, height = round(TILE_HEIGHT * entry.aspect), TILE_HEIGHT
    image = folder / f"{number}.png"
    started = time.perf_counter()
    try:
        result = subprocess.run([kindling, "render", entry.scene, "-o", image, "--size", f"{width}x{height}", "--spp", str(arguments.spp),
                                 "--quiet", *entry.flags, *arguments.flag], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                                timeout=600, check=False)
        message = "" if result.returncode == 0 else (result.stderr.strip().splitlines() or ["no message"])[-1] + \
            f" (exit code {result.returncode})"
    except subprocess.TimeoutExpired:
        message = "not done after 600 s"
    print(f"{entry.name}: {message or f'{time.perf_counter() - started:.1f} s'}", flush=True)
    if message:
        failed.append((entry.name, message))
        image = None
    tiles = [make_tile(image, entry.name if not message else entry.name + ": FAILED", folder / f"{number}.tile.png")]
    if entry.golden:
        tiles.append(make_tile(entry.golden, arguments.golden, folder / f"{number}.golden.png"))
    return tiles


def make_tile(image, label, path):
    """An image over gray, fitted and centered, with its name below."""
    size = f"{TILE_WIDTH}x{TILE_HEIGHT + LABEL_HEIGHT}"
    label = label if len(label) <= 36 else label[:35] + "~"
    command = ["oiiotool", "--pattern", "constant:color=0.25,0.25,0.25,1", size, "4"]
    if image:
        # Straight alpha becomes premultiplied for "over"; images without alpha get one.
        command += [image, "--ch", "R,G,B,A=1.0" if not has_alpha(image) else "R,G,B,A", "--premult",
                    "--fit", f"{TILE_WIDTH}x{TILE_HEIGHT}", "--fullpixels", "--swap", "--over"]
    if label and FONT.is_file():
        command += [f"--text:x=4:y={TILE_HEIGHT + 13}:size=13:color=1,1,1,1:font={FONT}", label.encode("ascii", "replace").decode()]
    command += ["-d", "uint8", "-o", path]
    subprocess.run(command, check=True, capture_output=True)
    return path


def has_alpha(image):
    info = subprocess.run(["oiiotool", "--info", "-v", image], capture_output=True, text=True, check=True).stdout
    return "R, G, B, A" in info


if __name__ == "__main__":
    sys.exit(main())
