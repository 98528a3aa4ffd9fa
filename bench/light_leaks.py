#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Light leaks: pixels that are not black inside closed white boxes that are lit from outside only.

Every box has a half-size of 1 m and its center at a distance D from the origin, so D is the distance over the half-size.
It stands in a constant environment of radiance 1, beside a sun and an emissive wall. A pinhole camera inside looks at
three walls. No light can enter, so the right image is black to the bit: each other pixel has at least one sample
that leaked. The table has one line per box and one column per D, with a count for each accelerator.
"""
import argparse
import math
import os
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "scenes"), str(ROOT / "bench")]

import pixels  # noqa: E402
from generator.gltf import Gltf, cross, look_at, normalize, subtract  # noqa: E402
from generator.shapes import Mesh, joined  # noqa: E402

DISTANCES = (0, 10, 100, 1000, 10000)
TOWARDS = (0.6, 0.48, 0.64)  # unit vector from the origin to the box; coordinates are whole numbers for D above 10
WIDTH, HEIGHT = 128, 96
GRID = (-1.0, -1.0 + 1e-5, -0.5, 0.3, 0.3 + 1e-5, 1.0)  # of walls with slivers
ROTATION = (0.2, 0.5, -0.3, 0.7852)  # quaternion: no edge is parallel to an axis


def wall(corner, u, v, us=(0.0, 1.0), vs=(0.0, 1.0)):
    """A parallelogram in rows and columns; rows and columns are fractions of its edges."""
    n = normalize(cross(u, v))
    points = [tuple(c + a * s + b * t for c, a, b in zip(corner, u, v)) for t in vs for s in us]
    indices, row = [], len(us)
    for j in range(len(vs) - 1):
        for i in range(len(us) - 1):
            k = j * row + i
            indices += [k, k + 1, k + row + 1, k, k + row + 1, k + row]
    return Mesh(points, [n] * len(points), [], indices)


def box(h=1.0, grid=(-1.0, 1.0), inside=True):
    """Six walls with vertices of their own: those of neighbors are equal to the bit."""
    walls = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            points, indices, row = [], [], len(grid)
            for b in grid:
                for a in grid:
                    p = [0.0] * 3
                    p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side * h, a * h, b * h
                    points.append(tuple(p))
            for j in range(row - 1):
                for i in range(row - 1):
                    k = j * row + i
                    indices += [k, k + 1, k + row + 1, k, k + row + 1, k + row]
            facing = side if not inside else -side
            n = [0.0] * 3
            n[axis] = facing
            if facing < 0.0:
                indices = [x for t in range(0, len(indices), 3) for x in (indices[t], indices[t + 2], indices[t + 1])]
            walls.append(Mesh(points, [tuple(n)] * len(points), [], indices))
    return joined(walls)


def t_junctions():
    """Walls that stand on the inside of floor, ceiling and of each other, at coordinates that are exact."""
    parts = [wall((-2, -1, -2), (0, 0, 4), (4, 0, 0)), wall((-2, 1, -2), (4, 0, 0), (0, 0, 4))]
    for x in (-1, 1):
        parts.append(wall((x, -1, -1.5), (0, 2, 0), (0, 0, 3)))
    for z in (-1, 1):
        parts.append(wall((-1, -1, z), (2, 0, 0), (0, 2, 0)))
    return joined(parts)


def wedge(degrees):
    """A closed prism over a triangle with a sharp edge."""
    t = 2.0 * math.tan(math.radians(degrees))
    low, high = [(-1, -1, 0), (1, -1, -t / 2), (1, -1, t / 2)], [(-1, 1, 0), (1, 1, -t / 2), (1, 1, t / 2)]
    parts = []
    for i in range(3):
        j = (i + 1) % 3
        n = normalize(cross(subtract(low[j], low[i]), (0, 1, 0)))
        parts.append(Mesh([low[i], low[j], high[j], high[i]], [n] * 4, [], [0, 1, 2, 0, 2, 3]))
    for points in (low, high):
        parts.append(Mesh(points, [(0, 1, 0)] * 3, [], [0, 1, 2]))
    return joined(parts)


def case(name):
    """{parts: [(mesh, kind of material)], and what else the scene of this name has}"""
    plain = {"parts": [(box(), "white")]}
    return {
        "box": plain,
        "light 1e6 times brighter": {**plain, "strength": 1e6},
        "rotated": {**plain, "rotation": ROTATION},
        "instanced": {"parts": [(box(grid=[i / 32.0 - 1.0 for i in range(65)]), "white")], "copies": 6},
        "instanced, rotated": {"parts": [(box(grid=[i / 32.0 - 1.0 for i in range(65)]), "white")], "copies": 6,
                               "rotation": ROTATION},
        "walls 1 mm thick": {"parts": [(box(), "white"), (box(1.001, inside=False), "white")]},
        "T-junctions": {"parts": [(t_junctions(), "white")]},
        "slivers": {"parts": [(box(grid=GRID), "white")]},
        "slivers, rotated": {"parts": [(box(grid=GRID), "white")], "rotation": ROTATION},
        "wedge of 30 degrees": {"parts": [(wedge(30), "white")], "eye": (0.7, 0.1, 0.05), "at": (-1, -0.3, 0)},
        "wedge of 5 degrees, rotated": {"parts": [(wedge(5), "white")], "eye": (0.7, 0.1, 0.05), "at": (-1, -0.3, 0),
                                        "rotation": ROTATION},
        "mirrors": {"parts": [(box(), "mirror")]},
        "glass inside": {"parts": [(box(), "white"), (wall((0, -1, -1), (0, 2, 0), (0, 0, 2)), "thin"),
                                   (wall((-1, -0.6, -1), (2, 0, 0), (0, 0, 2)), "glass"),
                                   (wall((-1, -0.8, -1), (0, 0, 2), (2, 0, 0)), "glass"),
                                   (wall((-1, -1, 0.4), (2, 0, 0), (0, 2, 0)), "veil")]},
        "moving": {**plain, "moves": True},
    }[name]


NAMES = ("box", "light 1e6 times brighter", "rotated", "instanced", "instanced, rotated", "walls 1 mm thick", "T-junctions",
         "slivers", "slivers, rotated", "wedge of 30 degrees", "wedge of 5 degrees, rotated", "mirrors", "glass inside", "moving")


def material(g, kind):
    if kind == "white":
        return g.add_material(kind, (1, 1, 1), diffuse_only=True, doubleSided=True)
    if kind == "mirror":
        return g.add_material(kind, (1, 1, 1), 1.0, 0.2, doubleSided=True)
    if kind == "veil":
        return g.add_material(kind, (1, 1, 1, 0.5), diffuse_only=True, doubleSided=True, alphaMode="BLEND")
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    if kind == "glass":
        extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    for name in extensions:
        g.use(name)
    return g.add_material(kind, (1, 1, 1), 0.0, 0.0, doubleSided=True, extensions=extensions)


def scene(what, distance):
    g = Gltf()
    center = tuple(round(d * distance, 6) for d in TOWARDS)
    strength = what.get("strength", 1.0)
    mesh = g.add_mesh("box", [(part, material(g, kind)) for part, kind in what["parts"]])
    eye, at = what.get("eye", (0.25, 0.125, 0.5)), what.get("at", (-1, -0.8, -1))
    camera = g.add("cameras", {"type": "perspective", "perspective": {"yfov": 1.4, "aspectRatio": WIDTH / HEIGHT, "znear": 0.01}})
    see = g.add_node("camera", camera=camera, translation=list(eye), rotation=look_at(eye, at))
    rotation = list(what["rotation"]) if "rotation" in what else None
    first = g.add_node("box", mesh=mesh, translation=list(center), rotation=rotation, children=[see])
    roots = [first]
    for i in range(1, what.get("copies", 1)):
        roots.append(g.add_node("copy", mesh=mesh, translation=[center[0] + 8.0 * i, center[1], center[2]]))
    lamp = g.add_mesh("lamp", [(wall((-3, -3, 3), (6, 0, 0), (0, 6, 0)), g.add_material("lamp", (0, 0, 0), emission=(strength,) * 3,
                                                                                       doubleSided=True))])
    roots.append(g.add_node("lamp", mesh=lamp, translation=list(center)))
    sun = g.add_light("sun", "directional", (1, 1, 1), strength)
    roots.append(g.add_node("sun", extensions=sun, rotation=look_at((0.3, 1, 0.4), (0, 0, 0))))
    if what.get("moves"):
        times = g.add_accessor([0.0, 1.0], "SCALAR", bounds=True)
        half = math.radians(20.0) / 2.0
        turns = g.add_accessor([(0, 0, 0, 1), (0, math.sin(half), 0, math.cos(half))], "VEC4")
        places = g.add_accessor([center, tuple(c + 0.5 for c in center)], "VEC3")
        samplers = [{"input": times, "output": turns}, {"input": times, "output": places}]
        channels = [{"sampler": 0, "target": {"node": first, "path": "rotation"}},
                    {"sampler": 1, "target": {"node": first, "path": "translation"}}]
        g.add("animations", {"samplers": samplers, "channels": channels})
    return g.finish(roots, "leak").to_glb()


def leaks(options, folder, name, distance, accelerator):
    """(pixels that are not black, mean radiance of all)"""
    what = case(name)
    path, image = folder / "leak.glb", folder / "leak.exr"
    path.write_bytes(scene(what, distance))
    light = ",".join(["%g" % what.get("strength", 1.0)] * 3)
    command = [options.kindling, "render", path, "-o", image, "--exr-float", "--size", f"{WIDTH}x{HEIGHT}", "--spp", str(options.spp),
               "--env-color", light, "--guiding", "off", "--accel", accelerator, "--integrator", options.integrator, "--seed",
               str(options.seed), *options.flag]
    if options.integrator == "whitted":
        command += ["--ambient", "sampled"]
    if what.get("moves"):
        command += ["--shutter", "0,1"]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{name}, D = {distance}: {done.stderr}")
    rgb = pixels.read_rgb(image).rgb
    return sum(1 for i in range(0, len(rgb), 3) if rgb[i] or rgb[i + 1] or rgb[i + 2]), sum(rgb) / len(rgb)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kindling", default=str(ROOT / "build/release/kindling"), help="program [build/release/kindling]")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel [64]")
    parser.add_argument("--seed", type=int, default=0, help="seed of the renders [0]")
    parser.add_argument("--accel", default="kdtree,embree", help="accelerators [kdtree,embree]; brute-force is slow")
    parser.add_argument("--integrator", default="path", choices=("path", "whitted"), help="[path]")
    parser.add_argument("--distances", default=",".join(map(str, DISTANCES)), help="values of D")
    parser.add_argument("--only", default="", help="only boxes whose name contains this")
    parser.add_argument("--write", metavar="FOLDER", help="writes the scenes there instead of rendering them")
    parser.add_argument("--flag", action="append", default=[], help="another argument of kindling render; may be repeated")
    options = parser.parse_args()
    names = [name for name in NAMES if options.only in name]
    distances = [float(d) for d in options.distances.split(",")]
    if options.write:
        os.makedirs(options.write, exist_ok=True)
        for name in names:
            for distance in distances:
                file = pathlib.Path(options.write) / ("%s_%g.glb" % (name.replace(", ", "_").replace(" ", "_"), distance))
                file.write_bytes(scene(case(name), distance))
        return
    kinds = options.accel.split(",")
    print(f"Pixels of {WIDTH * HEIGHT} that are not black, {options.spp} samples, {options.integrator}: {' / '.join(kinds)}\n")
    print("| box | " + " | ".join("%g" % d for d in distances) + " |\n|---" + "|---" * len(distances) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            print(f"| {name} ", end="")
            for distance in distances:
                counts = [str(leaks(options, pathlib.Path(folder), name, distance, kind)[0]) for kind in kinds]
                print("| " + " / ".join(counts), end=" ", flush=True)
            print("|", flush=True)


if __name__ == "__main__":
    main()
