#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""White furnaces: how much of a uniform white environment a white sphere of each material returns.

One sphere per material fills an orthographic image, under an environment of radiance 1, with 300 bounces. The figure of a
channel is 1 - (1 - mean of the image) / covered fraction: pixels beside the sphere are exactly 1. The standard error is
that of the mean of the images of all seeds.
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "scenes"), str(ROOT / "bench")]

import pixels  # noqa: E402
from generator.gltf import Gltf  # noqa: E402
from generator.shapes import sphere  # noqa: E402

SIDE = 64  # pixels
EXTENT = 1.02  # half of the image's width over the sphere's radius
SEGMENTS = 256
COVERED = 0.5 * SEGMENTS * math.sin(2.0 * math.pi / SEGMENTS) / (2.0 * EXTENT) ** 2  # silhouette: a regular polygon


def glass(roughness, anisotropy=0.0, thin=False, **film):
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    if not thin:
        extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    if anisotropy:
        extensions["KHR_materials_anisotropy"] = {"anisotropyStrength": anisotropy}
    if film:
        extensions["KHR_materials_iridescence"] = iridescence(**film)
    return roughness, extensions


def iridescence(ior=1.3, nm=400.0):
    return {"iridescenceFactor": 1.0, "iridescenceIor": ior, "iridescenceThicknessMinimum": nm, "iridescenceThicknessMaximum": nm}


def film(roughness, ior, nm, coat=None, anisotropy=0.0):
    extensions = {"KHR_materials_iridescence": iridescence(ior, nm)}
    if coat is not None:
        extensions["KHR_materials_clearcoat"] = {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": coat}
    if anisotropy:
        extensions["KHR_materials_anisotropy"] = {"anisotropyStrength": anisotropy}
    return roughness, extensions


def sheen(sheen_roughness, roughness=1.0):
    return roughness, {"KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": sheen_roughness}}


def cases():
    """name: (roughness, extensions)"""
    result = {}
    for roughness in (0.2, 0.5):
        for anisotropy in (0.0, 0.5, 1.0):
            result[f"glass, roughness {roughness:g}, anisotropy {anisotropy:g}"] = glass(roughness, anisotropy)
    result["glass, roughness 0.05, anisotropy 1"] = glass(0.05, 1.0)
    result["thin glass, roughness 0.2, anisotropy 1"] = glass(0.2, 1.0, thin=True)
    for ior, nm in ((1.3, 250.0), (1.3, 400.0), (1.3, 800.0), (1.8, 250.0), (1.8, 400.0), (2.4, 300.0)):
        result[f"film of {ior:g} and {nm:g} nm, roughness 0.3"] = film(0.3, ior, nm)
    result["film of 1.8 and 400 nm, roughness 0"] = film(0.0, 1.8, 400.0)
    result["film of 1.8 and 400 nm, roughness 1"] = film(1.0, 1.8, 400.0)
    for roughness in (0.0, 0.3, 1.0):
        result[f"film of 1 and 400 nm, roughness {roughness:g}"] = film(roughness, 1.0, 400.0)
    for ior in (1.0, 1.8):
        for coat in (0.0, 1.0):
            result[f"film of {ior:g} and 400 nm, roughness 0.3, coat of roughness {coat:g}"] = film(0.3, ior, 400.0, coat)
    result["film of 1.8 and 400 nm, roughness 0.3, anisotropy 1"] = film(0.3, 1.8, 400.0, None, 1.0)
    result["film of 1.8 and 400 nm on glass, roughness 0.2"] = glass(0.2, ior=1.8, nm=400.0)
    for roughness in (0.1, 0.3, 0.5, 1.0):
        result[f"sheen of roughness {roughness:g}"] = sheen(roughness)
    result["sheen of roughness 0.5, roughness 0.2"] = sheen(0.5, 0.2)
    return result


def scene(roughness, extensions):
    g = Gltf()
    for name in extensions:
        g.use(name)
    material = g.add_material("white", (1, 1, 1), 0.0, roughness, extensions=extensions)
    mesh = g.add("meshes", {"primitives": [g.add_primitive(sphere(1.0, SEGMENTS, SEGMENTS // 2), material)]})
    roots = [g.add_node("sphere", mesh=mesh),
             g.add_camera_node("camera", (2, 1.5, 3), (0, 0, 0), xmag=EXTENT, ymag=EXTENT, znear=0.1, zfar=20)]
    return g.finish(roots, "furnace").to_glb()


def furnace(kindling, folder, material, spp, seeds):
    """[(figure, standard error)] of red, green and blue."""
    path = folder / "furnace.glb"
    path.write_bytes(scene(*material))
    means = []
    for seed in range(seeds):
        image = folder / "furnace.exr"
        subprocess.run([kindling, "render", path, "-o", image, "--exr-float", "--size", f"{SIDE}x{SIDE}", "--spp", str(spp), "--seed",
                        str(seed), "--env-color", "1,1,1", "--max-bounces", "300", "--max-transmission-bounces", "300", "--filter",
                        "box", "--guiding", "off"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        means.append(pixels.read_rgb(image).mean())
    result = []
    for values in zip(*means):
        mean = sum(values) / seeds
        error = math.sqrt(sum((v - mean) ** 2 for v in values) / (seeds * max(seeds - 1, 1)))
        result.append((1.0 - (1.0 - mean) / COVERED, error / COVERED))
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kindling", default=str(ROOT / "build/release/kindling"), help="program [build/release/kindling]")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel of each image [64]")
    parser.add_argument("--seeds", type=int, default=4, help="images of each material [4]")
    parser.add_argument("--only", default="", help="only materials whose name contains this")
    options = parser.parse_args()
    print("| white sphere | red | green | blue | standard error |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, material in cases().items():
            if options.only not in name:
                continue
            rgb = furnace(options.kindling, pathlib.Path(folder), material, options.spp, options.seeds)
            print(f"| {name} | " + " | ".join("%.4f" % figure for figure, _ in rgb) +
                  " | %.4f |" % max(error for _, error in rgb), flush=True)


if __name__ == "__main__":
    main()
