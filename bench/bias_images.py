#!/usr/bin/env python3
"""Renders the effect of options that trade bias for less noise, for the READMEs.

Each image shows the full render, the render with the option, and their difference.

    bench/bias_images.py [-o scenes/images] [--spp 128] [--kindling PATH]

A window of scenes/interior.glb in which sunlight on a kettle throws caustics. The difference is signed: gray is none, darker
is light that the option has lost. All renders have the same seed, so that what is different is so by the option alone.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import subprocess
import tempfile
from pathlib import Path

import pixels
import renderers

OPTIONS = {
    "bias_clamp_indirect": ["--clamp-indirect", "10"],
    "bias_caustics_regularized": ["--caustics", "regularized"],
    "bias_caustics_off": ["--caustics", "off"],
    "bias_outliers_trim": ["--outliers", "trim"],
}
SIZE, WINDOW = "960x540", "250,180,490,330"
DIFFERENCE_GAIN = 2.0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=renderers.ROOT / "scenes" / "images", help="folder (scenes/images)")
    parser.add_argument("--spp", default="128", help="(128)")
    parser.add_argument("--kindling", type=Path, help="the program (build/release/kindling)")
    arguments = parser.parse_args()
    kindling = renderers.find_kindling(arguments.kindling)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)

        def render(name, flags):
            subprocess.run([kindling, "render", renderers.ROOT / "scenes" / "interior.glb", "--size", SIZE, "--crop", WINDOW,
                            "--spp", arguments.spp, "--exr-float", "-q", "-o", folder / f"{name}.exr", *flags],
                           check=True, stdout=subprocess.DEVNULL)
            return folder / f"{name}.exr"

        full = render("full", [])
        for name, flags in OPTIONS.items():
            compose(full, render(name, flags), folder, arguments.output / f"{name}.png")
            print(arguments.output / f"{name}.png")


def compose(full, option, folder, output):
    def oiiotool(*words):
        subprocess.run([pixels.oiiotool(), "-q", *map(str, words)], check=True)

    whole = ["--origin", "+0+0", "--fullpixels"]  # the window alone
    shown = ["--ch", "R,G,B", *whole, "--clamp:min=0:max=1", "--colorconvert", "linear", "sRGB"]
    panels = [folder / "left.tif", folder / "middle.tif", folder / "right.tif"]
    oiiotool(full, *shown, "-o", panels[0])
    oiiotool(option, *shown, "-o", panels[1])
    oiiotool(option, "--ch", "R,G,B", *whole, full, "--ch", "R,G,B", *whole, "--sub", "--mulc", DIFFERENCE_GAIN,
             "--addc", 0.5, "--clamp:min=0:max=1", "-o", panels[2])
    oiiotool(*panels, "--mosaic:pad=4", "3x1", "-d", "uint8", "-o", output)


if __name__ == "__main__":
    main()
