#!/usr/bin/env python3
"""Measures the flicker of denoised frames, with and without blending, on a turntable.

    bench/denoise_frames.py scenes/interior.glb --spp 4,16 --size 320x180 --reference-spp 256
    bench/denoise_frames.py FOLDER --only hotel,lambo --size 240x135

The first seven frames of a turn are rendered with few samples, and some in the middle with many. `kindling denoise --frames` denoises
the noisy ones, each alone and blended with its neighbors along the motion vectors. relMSE and FLIP are those of bench/denoise.py, means
over three frames. Flicker is the mean change of a pixel's error from the frame before, along its motion: an object that moves
without an error counts nothing (sRGB, of 255; the error is that against the reference, denoised too). Boiling is the same of
means over 9 x 9 pixels: the eye sees patches that change, while edges, which each frame samples differently, cancel out. Open Image
Denoise must be installed (cmake/get_oidn.sh).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True

import with_numpy  # noqa: F401  (first: another Python may have to take over)

import numpy as np

import denoise
import flip
import pixels
import renderers

FRAMES = 7  # 0 to 6
MEASURED = (2, 3, 4)  # have two neighbors on either side
BOILING_RADIUS_PX = 4
MAX_RETURN_PX = 1.0  # distance from a pixel at which the motion to the frame before and back may end


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=Path, help="folders (scenes.json and its scenes, or just glTF files) and glTF files")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="NAME,...", help="these scenes alone")
    parser.add_argument("--spp", default=[4], type=denoise.parse_counts, metavar="N,...", help="samples per pixel (4)")
    parser.add_argument("--neighbors", default=[1, 2], type=denoise.parse_counts, metavar="N,...", help="frames on either side (1,2)")
    parser.add_argument("--turn", type=int, default=180, metavar="FRAMES", help="frames of the full turn (180: 2 degrees each)")
    parser.add_argument("--quality", choices=denoise.QUALITIES, default="best", help="of the filter (best)")
    parser.add_argument("--size", type=renderers.parse_size, metavar="WxH", help="pixels (as scenes.json says, else 640x360)")
    parser.add_argument("--threads", type=int, default=2, help="of the renders and the filter (2)")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    parser.add_argument("--reference-spp", type=int, default=256, metavar="N", help="samples of the references (256)")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep images there; renders that are there are used again")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write all figures there")
    return parser.parse_args()


def main():
    options = parse_arguments()
    rows = [row for scene in denoise.measure_scenes(options, measure) for row in scene]
    print(table_of(rows))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


def measure(job, kindling, options, folder):
    """The figures of one scene: a row for each number of samples and treatment."""
    referred = range(MEASURED[0] - 1, MEASURED[-1] + 1)
    references = render(job, kindling, options, folder, options.reference_spp, denoise.REFERENCE_SEED, referred)
    wanted = {i: denoise.read(image) for i, image in references.items()}
    clean = {i: denoise.read(image) for i, image in denoised(kindling, references, 0, options).items()}
    rows = []
    for spp in options.spp:
        noisy = render(job, kindling, options, folder, spp, 1, range(FRAMES))
        ways = {i: motion_from_before(noisy[i - 1], noisy[i]) for i in MEASURED}

        def figures(treatment, images):
            shown = {i: denoise.read(images[i]) for i in referred}
            errors = {i: denoise.srgb(shown[i]) - denoise.srgb(clean[i]) for i in referred}
            patches = {i: means(errors[i], BOILING_RADIUS_PX) for i in referred}
            return {"name": job.name, "spp": spp, "treatment": treatment,
                    "relmse": float(np.mean([denoise.rel_mse(shown[i], wanted[i]) for i in MEASURED])),
                    "flip": float(np.mean([flip.flip(denoise.srgb(wanted[i]), denoise.srgb(shown[i])).mean() for i in MEASURED])),
                    "flicker": float(np.mean([change(errors[i - 1], errors[i], *ways[i]) for i in MEASURED])),
                    "boiling": float(np.mean([change(patches[i - 1], patches[i], *ways[i]) for i in MEASURED]))}

        rows.append(figures("noisy", noisy))
        for neighbors in (0, *options.neighbors):
            rows.append(figures("denoised alone" if neighbors == 0 else f"{neighbors} on either side",
                                denoised(kindling, noisy, neighbors, options)))
    return rows


def render(job, kindling, options, folder, spp, seed, frames):
    """Frames of the turn by number, with guides and motion vectors."""
    pattern = folder / f"{job.name}.{spp}.####.exr"
    flags = ["--turntable", options.turn, "--frames", f"{frames[0]}-{frames[-1]}", "--aov", "denoising_albedo,denoising_normal,vector", "--quiet"]
    command = renderers.kindling_command(kindling, job, spp, seed, pattern, flags)
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode} from kindling render: {done.stderr.strip()}")
    return {frame: Path(str(pattern).replace("####", f"{frame:04d}")) for frame in frames}


def denoised(kindling, images, neighbors, options):
    pattern = str(next(iter(images.values()))).rsplit(".", 2)[0] + ".####.exr"
    output = pattern.replace(".####", f".{options.quality}.{neighbors}.####")
    done = subprocess.run([str(kindling), "denoise", pattern, "--frames", f"{min(images)}-{max(images)}", "--neighbors", str(neighbors), "-o", output,
                           "--denoise", options.quality, "--exr-float", "--threads", str(options.threads), "--quiet"],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode} from kindling denoise: {done.stderr.strip()}")
    return {frame: Path(output.replace("####", f"{frame:04d}")) for frame in images}


def motion_from_before(before, image):
    """Of each pixel its place in the frame before (rows, columns), and whether that shows the same point."""
    vectors = channels(image, ("Vector.X", "Vector.Y"))
    rows, columns = np.indices(vectors.shape[:2])
    there = np.rint(np.stack((rows - vectors[..., 1], columns + vectors[..., 0]), -1)).astype(int)
    inside = ((there >= 0) & (there < vectors.shape[:2])).all(-1)
    there = np.clip(there, 0, np.array(vectors.shape[:2]) - 1)
    back = channels(before, ("Vector.Z", "Vector.W"))[there[..., 0], there[..., 1]]
    return there, inside & (np.hypot(*np.moveaxis(vectors - back, -1, 0)) < MAX_RETURN_PX)


def change(earlier, later, there, known):
    """Mean change of errors along the motion, of 255."""
    return 255.0 * float(np.abs(later - earlier[there[..., 0], there[..., 1]])[known].mean())


def means(image, radius):
    """Of each pixel the mean over the square around it; edges count as their nearest pixels."""
    for axis in (0, 1):
        padded = np.pad(image, [(radius + 1, radius) if i == axis else (0, 0) for i in range(image.ndim)], mode="edge")
        sums, side = np.cumsum(padded, axis=axis), 2 * radius + 1
        begin, end = (np.take(sums, range(first, first + image.shape[axis]), axis=axis) for first in (0, side))
        image = (end - begin) / side
    return image


def channels(path, names):
    with tempfile.NamedTemporaryFile(suffix=".tif") as flat:
        subprocess.run([pixels.oiiotool(), "-q", str(path), "--ch", ",".join(names), "-d", "float", "--scanline", "--planarconfig", "contig",
                        "--compression", "none", "-o", flat.name], check=True)
        width, height, count, values = pixels.float_tiff(Path(flat.name).read_bytes())
    return np.array(values, np.float64).reshape(height, width, count)


def table_of(rows):
    lines = ["| scene | samples | frames | relMSE | FLIP | flicker | boiling |", "|---|---|---|---|---|---|---|"]
    lines += [f"| {row['name']} | {row['spp']} | {row['treatment']} | {row['relmse']:.4f} | {row['flip']:.3f} | {row['flicker']:.2f} | {row['boiling']:.2f} |"
              for row in rows]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
