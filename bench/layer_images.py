#!/usr/bin/env python3
"""Renders one sheet of layers for compositors: mattes, passes, relit images, motion, shadows.

    bench/layer_images.py [-o scenes/images/layers.webp] [--spp 256] [--kindling PATH]
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import with_numpy  # noqa: F401  (first: another Python may have to take over)

import numpy as np

import pixels
import renderers

SIZE = (320, 180)  # pixels of an image
LABEL_HEIGHT = 18
FONT = Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")  # Debian: fonts-dejavu-core
COLUMNS = 3
SCENES = renderers.ROOT / "scenes"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=SCENES / "images" / "layers.webp", help="(scenes/images/layers.webp)")
    parser.add_argument("--spp", type=int, default=256, help="samples per pixel (256)")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    options = parser.parse_args()
    kindling = renderers.find_kindling(options.kindling)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        tiles = [labeled(image, label, folder / f"tile{number}.png") for number, (image, label) in enumerate(images(kindling, options.spp, folder))]
        oiiotool(*tiles, "--mosaic:pad=4", f"{COLUMNS}x{-(-len(tiles) // COLUMNS)}", "--ch", "R,G,B", "-d", "uint8", "--compression", "webp:88",
                 "-o", options.output)
    print(f"{options.output}: {options.output.stat().st_size // 1024} KiB")
    return 0


def images(kindling, spp, folder):
    """(file, label) of each tile."""
    def render(scene, *flags):
        subprocess.run([kindling, "render", SCENES / scene, "--size", "x".join(map(str, SIZE)), "-q", *flags], check=True,
                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

    room, shown = folder / "room.exr", folder / "room.png"
    render("interior.glb", "-o", room, "-o", shown, "--spp", str(spp), "--cryptomatte", "object,material", "--light-groups", "name", "--aov",
           "diffuse_direct,diffuse_indirect,glossy_direct,glossy_indirect")
    yield shown, "image"
    for matte in ("Object", "Material"):
        yield matte_image(room, matte, folder / f"{matte}.ppm"), f"Cryptomatte: {matte.lower()}s"
    for name, layers in (("diffuse light, direct and indirect", ("DiffDir", "DiffInd")), ("glossy light, direct and indirect", ("GlossDir", "GlossInd")),
                         ("light group of the sun", ("Combined_sun",))):
        yield sum_of_layers(room, layers, folder / f"{layers[0]}.png"), name
    relit = folder / "relit.png"
    subprocess.run([kindling, "relight", room, "--group", "sun=0.02,0.03,0.06,outside=0.004,0.008,0.02,overcast=0.03,0.045,0.08", "-o", relit, "-q"],
                   check=True, stdout=subprocess.DEVNULL)
    yield relit, "kindling relight: the same samples at night"
    render("instancing.glb", "-o", folder / "turning-#.exr", "--spp", "4", "--turntable", "96", "--frames", "4", "--aov", "motion")
    yield motion_image(folder / "turning-4.exr", folder / "motion.ppm"), "motion vectors of a turntable"
    caught = folder / "caught.png"
    render("instancing.glb", "-o", caught, "--spp", str(spp), "--shadow-catcher", "ground", "--shadow-catcher", "pebbles")
    yield over_squares(caught, folder / "over.png"), "shadow catcher: the ground, but for shadows"


def oiiotool(*words):
    subprocess.run([pixels.oiiotool(), "-q", *map(str, words)], check=True)


def read_channels(exr, names, folder):
    """An array (height, width, channels) of floats."""
    flat = folder / "flat.tif"
    oiiotool(exr, "--ch", ",".join(names), "-d", "float", "--scanline", "--planarconfig", "contig", "--compression", "none", "-o", flat)
    width, height, channels, values = pixels.float_tiff(flat.read_bytes())
    return np.array(values, np.float32).reshape(height, width, channels)


def matte_image(exr, matte, output):
    """A color for each id, by its bits, times its coverage."""
    color = np.zeros((SIZE[1], SIZE[0], 3))
    for layer in range(3):
        pairs = read_channels(exr, [f"Crypto{matte}{layer:02}.{c}" for c in "rgba"], output.parent)
        for first in (0, 2):
            ids, coverage = np.ascontiguousarray(pairs[..., first]).view(np.uint32).astype(np.uint64), pairs[..., first + 1]
            hue, value = ((ids * 2654435761) >> 8) % 360, 0.55 + ((ids * 40503) >> 4) % 40 / 100.0
            color += hue_color(hue.astype(float)) * (value * coverage)[..., None]
    return write_ppm(color, output)


def motion_image(exr, output):
    """The direction of the way to the next frame as hue, its length as brightness."""
    way = read_channels(exr, ("forward.u", "forward.v"), output.parent)
    length = np.hypot(way[..., 0], way[..., 1])
    hue = np.degrees(np.arctan2(way[..., 1], way[..., 0])) % 360.0
    return write_ppm(hue_color(hue) * np.sqrt(length / np.percentile(length, 99)).clip(0, 1)[..., None], output)


def hue_color(hue_deg):
    """Saturated colors, of less contrast than those of HSV."""
    return 0.5 + 0.45 * np.cos(np.radians(hue_deg[..., None] - np.array([0.0, 120.0, 240.0])))


def write_ppm(color, output):
    output.write_bytes(b"P6 %d %d 255\n" % (color.shape[1], color.shape[0]) + (255.0 * color.clip(0, 1) + 0.5).astype(np.uint8).tobytes())
    return output


def sum_of_layers(exr, layers, output):
    parts = [word for number, layer in enumerate(layers)
             for word in (exr, "--ch", ",".join(f"{layer}.{c}" for c in "RGB"), "--chnames", "R,G,B", *(["--add"] if number else []))]
    oiiotool(*parts, "--clamp:min=0:max=1", "--colorconvert", "linear", "sRGB", "-d", "uint8", "-o", output)
    return output


def over_squares(png, output):
    size = "x".join(map(str, SIZE))
    oiiotool("--pattern", "checker:width=20:height=20:color1=0.42,0.47,0.52,1:color2=0.55,0.6,0.64,1", size, "4", png, "--premult", "--swap", "--over",
             "--ch", "R,G,B", "-d", "uint8", "-o", output)
    return output


def labeled(image, label, output):
    text = [f"--text:x=4:y={SIZE[1] + 13}:size=12:color=1,1,1,1:font={FONT}", label] if FONT.is_file() else []
    oiiotool("--pattern", "constant:color=0.2,0.2,0.2,1", f"{SIZE[0]}x{SIZE[1] + LABEL_HEIGHT}", "4", image, "--ch", "R,G,B,A=1.0", "--swap", "--over",
             *text, "-d", "uint8", "-o", output)
    return output


if __name__ == "__main__":
    sys.exit(main())
