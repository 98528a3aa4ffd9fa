"""Build, memory and rays of difficult meshes, over those of a typical one: of bounds.py."""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import random
import statistics
import struct
import tempfile
from pathlib import Path

from bounds_process import Process
from bounds_shapes import SHAPES, write_shape

# Bounds of the factors of a build by one thread, of its peak of memory, and of the time of a ray:
# about three times what was measured, see README.md.
BOUNDS = {
    ("needles", "kdtree"): (54, 8, 2600), ("needles", "embree"): (5, 3, 3300),
    ("soup", "kdtree"): (22, 7, 12), ("soup", "embree"): (5, 3, 60),
    ("large_soup", "kdtree"): (22, 5, 150), ("large_soup", "embree"): (5, 3, 160),
    ("nested_boxes", "kdtree"): (13, 9, 165), ("nested_boxes", "embree"): (3, 3, 11),
    ("nested_spheres", "kdtree"): (22, 6, 108), ("nested_spheres", "embree"): (4, 3, 60),
    ("one_cell", "kdtree"): (12, 11, 12), ("one_cell", "embree"): (5, 3, 24),
    ("coincident", "kdtree"): (3, 3, 1100), ("coincident", "embree"): (4, 3, 4500),
}
MEASURES = ("build", "memory", "rays")
RAYS = 1024  # of each kind
CUBE = ((0, 0, 0), (1, 1, 1))
REGIONS = {"bumpy": ((0, -0.5, 0), (1, 0.5, 1)), "needles": ((-1,) * 3, (1,) * 3), "soup": CUBE, "large_soup": CUBE, "coincident": CUBE,
           "nested_boxes": ((-2,) * 3, (2,) * 3), "nested_spheres": ((-2,) * 3, (2,) * 3), "one_cell": ((0,) * 3, (1e-4,) * 3)}


HEADER, SET = "<8sIIQii", "<32sIIQ"  # of a file of rays; renderer/session/README.md


def run_shootout(options, folder, path, *arguments):
    """The process, ended."""
    return Process([options.program, "shootout", path, "--build-repeat", "1", "--clock", "cpu", "--no-embree-calls", "--threads", "2", "--size", "16x16", "-q",
                    *arguments], folder, options.limit, options.seconds).finish()


def write_rays(file, geometry_hash, region):
    """Lines between random points of a box: nearest hits, and whether anything lies between the points."""
    rng, (low, high) = random.Random(5), region
    rays = ([], [])
    for _ in range(RAYS):
        a, b = ([rng.uniform(*ends) for ends in zip(low, high)] for _ in range(2))
        length = math.dist(a, b)
        direction = [(q - p) / length for p, q in zip(a, b)]
        for kind, end in enumerate((math.inf, length)):
            rays[kind].append(struct.pack("<3ff3ffIfII", *a, 0.0, *direction, end, 0, 0.0, 0, 0))
    with file.open("wb") as out:
        out.write(struct.pack(HEADER, b"KNDLRAYS", 1, 2, geometry_hash, 64, 64))
        for kind, name in enumerate((b"nearest", b"between")):
            out.write(struct.pack(SET, name, kind, 0, RAYS))
        for kind in rays:
            out.write(b"".join(kind))


def measure(options, shape, folder):
    """{accelerator: {build: s, memory: bytes, rays: {kind: s}}}, or how a process ended"""
    path, report, rays_file = write_shape(folder, shape, options.triangles), folder / "shootout.json", folder / "lines.rays"
    first = run_shootout(options, folder, path, "--accel", "embree", "--rays-per-kind", "1", "--repeat", "1", "--rays", rays_file)
    if not rays_file.exists():
        return how_it_ended(first)
    write_rays(rays_file, struct.unpack_from(HEADER, rays_file.read_bytes())[3], REGIONS[shape.__name__])
    run = run_shootout(options, folder, path, "--accel", options.accel, "--repeat", "3", "--rays", rays_file, "--json", report)
    if run.killed or run.process.returncode != 0:
        return how_it_ended(run)
    found = {}
    for accelerator in json.loads(report.read_text())["scenes"][0]["accelerators"]:
        rays = {}
        for row in accelerator["traversal"]:
            if row["mega_rays_per_s"]:
                rays[row["rays"]] = min(rays.get(row["rays"], math.inf), 1e-6 / row["mega_rays_per_s"])
        found[accelerator["name"]] = {"build": accelerator["build"]["one_thread"]["median_s"],
                                      "memory": max(accelerator["build_peak_bytes"] or 0, accelerator["memory_bytes"]), "rays": rays}
    return found


def how_it_ended(run):
    return run.killed or f"exit code {run.process.returncode}: {''.join(run.err)[-300:].strip()}"


def factors_of(found, typical):
    """The factor of each measure; that of rays is the geometric mean over their kinds, each by its fastest call."""
    kinds = [kind for kind in found["rays"] if kind in typical["rays"]]
    return {"build": found["build"] / typical["build"], "memory": found["memory"] / typical["memory"],
            "rays": statistics.geometric_mean([found["rays"][kind] / typical["rays"][kind] for kind in kinds]) if kinds else math.nan}


def measure_factors(options):
    """Prints a table. Returns 1 if a factor is beyond its bound."""
    typical, beyond = None, []
    print(f"| {options.triangles} triangles | accelerator | build | memory | time of a ray |\n|---|---|---|---|---|")
    for shape in SHAPES:
        if shape is not SHAPES[0] and options.names and shape.__name__ not in options.names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            found = measure(options, shape, Path(folder))
        if isinstance(found, str):
            print(f"| {shape.__doc__} | {found} |", flush=True)
            beyond.append(shape.__name__)
            continue
        typical = typical or found
        for name, values in found.items():
            if shape is SHAPES[0]:
                seconds = statistics.geometric_mean(values["rays"].values())
                print(f"| {shape.__doc__} | {name} | {values['build']:.2f} s | {values['memory'] / 2**20:.0f} MiB | {seconds * 1e6:.2f} us |")
                continue
            factors = factors_of(values, typical[name])
            print(f"| {shape.__doc__} | {name} | " + " | ".join(f"{factors[of]:.2g}" for of in MEASURES) + " |", flush=True)
            bounds = BOUNDS[shape.__name__, name.split(":")[0]]
            beyond += [f"{shape.__name__}, {name}: {of} {factors[of]:.1f}, bound {bound}" for of, bound in zip(MEASURES, bounds)
                       if not factors[of] <= bound]
    print("".join(f"BEYOND ITS BOUND: {row}\n" for row in beyond), end="")
    return 1 if beyond else 0
