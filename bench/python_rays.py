#!/usr/bin/env python3
"""Races the Python package against embreex on the same rays.

Run it with the Python of an environment that has both, such as build/python/venv/bin/python (renderer/python/test.sh).
Rounds alternate between the two; printed are the medians of rays per second, in wall time, and the median of the ratios
of neighboring rounds. embreex uses one thread.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import statistics
import time

import embreex.mesh_construction
import embreex.rtcore_scene
import kindling.accel
import numpy as np


def bumpy_sphere(cells):
    """Vertices and faces of a closed sphere with bumps: 2 cells^2 triangles."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, cells + 1), np.linspace(0, 2 * np.pi, cells, endpoint=False), indexing="ij")
    radius = 1 + 0.05 * np.sin(17 * theta) * np.sin(13 * phi)
    points = np.stack([radius * np.sin(theta) * np.cos(phi), radius * np.sin(theta) * np.sin(phi), radius * np.cos(theta)], -1)
    row, column = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    a, b = row * cells + column, row * cells + (column + 1) % cells
    faces = np.concatenate([np.stack([a, a + cells, b + cells], -1).reshape(-1, 3), np.stack([a, b + cells, b], -1).reshape(-1, 3)])
    return points.reshape(-1, 3).astype(np.float32), faces.astype(np.int32)


def ray_sets(count, seed):
    """(name, origins, directions): camera rays, and rays between random points."""
    rng = np.random.default_rng(seed)
    side = int(np.sqrt(count))
    x, y = np.meshgrid(np.linspace(-0.35, 0.35, side), np.linspace(-0.35, 0.35, side))
    camera = np.stack([x, y, np.full_like(x, -1)], -1).reshape(-1, 3).astype(np.float32)
    yield "camera", np.tile(np.float32([0, 0, 3]), (side * side, 1)), camera
    yield "random", *rng.normal(size=(2, count, 3)).astype(np.float32)


def main():
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=int, default=300_000, help="rays of each kind (300000)")
    parser.add_argument("--cells", type=int, default=600, help="the mesh has 2 N^2 triangles (600)")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each query (7)")
    parser.add_argument("--threads", type=int, default=0, help="also with so many threads of Kindling; 0: all (0)")
    options = parser.parse_args()
    vertices, faces = bumpy_sphere(options.cells)
    kdtree = kindling.accel.Scene(vertices, faces)
    other = embreex.rtcore_scene.EmbreeScene()
    embreex.mesh_construction.TriangleMesh(scene=other, vertices=vertices, indices=faces)
    print(f"{len(faces)} triangles; {kindling.accel.description('kdtree')} with {kdtree.statistics['kernels']}, embreex {embreex.__version__}")
    for name, origins, directions in ray_sets(options.rays, 1):
        hits, found = kdtree.intersect(origins, directions).triangle, other.run(origins, directions)
        print(f"{name}: {len(origins)} rays, {np.mean(hits >= 0):.0%} hit; hit or miss differs for {np.count_nonzero((hits >= 0) != (found >= 0))}")
        for threads in (1, options.threads):
            speeds, ratios = ([], []), []
            for _ in range(options.rounds):
                times = []
                for query in (lambda: kdtree.intersect(origins, directions, threads=threads), lambda: other.run(origins, directions)):
                    start = time.perf_counter()
                    query()
                    times.append(time.perf_counter() - start)
                for of_query, seconds in zip(speeds, times):
                    of_query.append(len(origins) / seconds * 1e-6)
                ratios.append(times[1] / times[0])
            print(f"  {threads or 'all'} threads: {statistics.median(speeds[0]):.2f} against {statistics.median(speeds[1]):.2f} Mrays/s, "
                  f"ratio {statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")
        start = time.perf_counter()
        crossings = kdtree.all_hits(origins, directions)
        print(f"  every hit, all threads: {len(origins) / (time.perf_counter() - start) * 1e-6:.2f} Mrays/s, {len(crossings.t) / len(origins):.2f} hits a ray")


if __name__ == "__main__":
    main()
