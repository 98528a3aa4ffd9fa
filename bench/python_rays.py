#!/usr/bin/env python3
"""Races the Python package against embreex and Open3D on the same rays.

Run it with the Python of an environment that has them, such as build/python/venv/bin/python (renderer/python/test.sh);
Open3D is another `pip install open3d`, and what is not installed is left out. The contestants take turns in every round.
Printed are medians over the rounds: million rays per second in wall time and in processor time of the whole process
(which work beside it on the machine disturbs less), and the ratios to Kindling within the rounds with their range.
embreex uses one thread.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import importlib
import statistics
import time

import kindling.accel
import numpy as np


def optional(module):
    """The module, or None if it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        return None


embreex, open3d, trimesh = optional("embreex"), optional("open3d"), optional("trimesh")
if embreex:
    import embreex.mesh_construction
    import embreex.rtcore_scene
if trimesh and embreex:
    import kindling.accel.trimesh
    import trimesh.ray.ray_pyembree


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


def race(title, queries, count, rounds):
    """Runs the queries, {name: function}, in turn, and prints a line for each; the first is the one that is compared."""
    times = {name: [] for name in queries}
    for number in range(rounds + 1):
        for name, query in queries.items():
            start, cpu = time.perf_counter(), time.process_time()
            query()
            if number > 0:  # the first round warms up
                times[name].append((time.perf_counter() - start, time.process_time() - cpu))
    first = next(iter(queries))
    for name, measured in times.items():
        wall, cpu = (count / statistics.median(column) * 1e-6 for column in zip(*measured))
        line = f"  {title:20} {name:26} {wall:6.2f} Mrays/s, {cpu:6.2f} by processor time"
        if name != first:
            ratios = sorted(theirs[0] / ours[0] for ours, theirs in zip(times[first], measured))
            by_cpu = statistics.median(theirs[1] / ours[1] for ours, theirs in zip(times[first], measured))
            line += f"; Kindling {statistics.median(ratios):.2f} times as fast ({ratios[0]:.2f} to {ratios[-1]:.2f}), {by_cpu:.2f} by processor time"
        print(line, flush=True)


class Contestants:
    """The scene in each library."""

    def __init__(self, vertices, faces):
        self.kdtree = kindling.accel.Scene(vertices, faces)
        self.embree = self.open3d = self.loop = self.drop_in = None
        if embreex:
            self.embree = embreex.rtcore_scene.EmbreeScene()
            embreex.mesh_construction.TriangleMesh(scene=self.embree, vertices=vertices, indices=faces)
        if open3d:
            self.open3d = open3d.t.geometry.RaycastingScene()
            self.open3d.add_triangles(open3d.core.Tensor(vertices), open3d.core.Tensor(faces.astype(np.uint32)))
        if trimesh and embreex:
            mesh = trimesh.Trimesh(vertices, faces, process=False)
            self.loop = trimesh.ray.ray_pyembree.RayMeshIntersector(mesh)
            self.drop_in = kindling.accel.trimesh.RayMeshIntersector(mesh)

    def check(self, origins, directions, packed):
        """Prints how many rays hit, and how many of them otherwise elsewhere."""
        hit = self.kdtree.intersect(origins, directions).is_hit
        line = f"{len(origins)} rays, {np.mean(hit):.0%} hit; hit or miss differs for"
        if self.embree:
            line += f" {np.count_nonzero(hit != (self.embree.run(origins, directions) >= 0))} (embreex)"
        if self.open3d:
            line += f" {np.count_nonzero(hit != np.isfinite(self.open3d.cast_rays(packed)['t_hit'].numpy()))} (Open3D)"
        print(line)

    def nearest(self, origins, directions, packed, threads):
        """{name: query} of nearest hits. Open3D takes rays packed into one array, and computes normals besides."""
        queries = {"Kindling": lambda: self.kdtree.intersect(origins, directions, threads=threads)}
        if self.embree:
            queries["embreex, one thread"] = lambda: self.embree.run(origins, directions)
        if self.open3d:
            queries["Open3D"] = lambda: self.open3d.cast_rays(packed, nthreads=threads)
        return queries

    def every(self, origins, directions, packed, threads):
        """{name: query} of every hit."""
        queries = {"Kindling": lambda: self.kdtree.all_hits(origins, directions, threads=threads)}
        if self.open3d:
            queries["Open3D list_intersections"] = lambda: self.open3d.list_intersections(packed, nthreads=threads)
        return queries

    def every_by_trimesh(self, origins, directions):
        """{name: query} of every hit and its location by trimesh's methods, all threads."""
        queries = {"Kindling's drop-in": lambda: self.drop_in.intersects_id(origins, directions, return_locations=True)}
        queries["loop over embreex"] = lambda: self.loop.intersects_id(origins, directions, return_locations=True)
        return queries


def main():
    """Prints a line for each race."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=int, default=300_000, help="rays of each kind (300000)")
    parser.add_argument("--cells", type=int, default=600, help="the mesh has 2 N^2 triangles (600)")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each query (7)")
    parser.add_argument("--threads", type=int, default=0, help="also with so many threads; 0: all (0)")
    options = parser.parse_args()
    vertices, faces = bumpy_sphere(options.cells)
    scenes = Contestants(vertices, faces)
    others = [f"{module.__name__} {module.__version__}" for module in (embreex, open3d, trimesh) if module]
    print(f"{len(faces)} triangles; {kindling.accel.description('kdtree')} with {scenes.kdtree.statistics['kernels']}; {', '.join(others) or 'nothing else is installed'}")
    for name, origins, directions in ray_sets(options.rays, 1):
        print(f"{name}: ", end="")
        packed = open3d.core.Tensor(np.hstack([origins, directions])) if open3d else None
        scenes.check(origins, directions, packed)
        for threads in dict.fromkeys((1, options.threads)):
            title = f"{threads or 'all'} thread{'' if threads == 1 else 's'}"
            race("nearest, " + title, scenes.nearest(origins, directions, packed, threads), len(origins), options.rounds)
            race("every, " + title, scenes.every(origins, directions, packed, threads), len(origins), options.rounds)
        if scenes.loop:
            race("every, trimesh", scenes.every_by_trimesh(origins, directions), len(origins), options.rounds)


if __name__ == "__main__":
    main()
