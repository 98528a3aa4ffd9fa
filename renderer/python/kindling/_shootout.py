# SPDX-License-Identifier: Apache-2.0
"""A race of the accelerators on one mesh and the same rays."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kindling.accel import Hits, Scene, description

__all__ = ["shootout"]


def shootout(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    rays: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    accelerators: Sequence[str] = ("kdtree", "embree"),
    rounds: int = 5,
    threads: int = 1,
) -> Any:
    """Race accelerators on a mesh; return a pandas.DataFrame, or a list of dicts without pandas.

    rays: origins and directions (n, 3) by name; by default 200,000 each from a camera outside, and between random points
    of the bounds. Accelerators take turns in each round. One row for each set of rays and accelerator:

    nearest, any_hit: million rays per second of intersect() and occluded(), the best of all rounds.
    build_s, memory_mb: of the build, by all threads, and what it holds.
    differs: rays that hit or miss otherwise than with the first accelerator, or at a distance that differs by 0.1 %.
    """
    if rounds < 1:
        raise ValueError(f"rounds: {rounds}, expected at least 1")
    scenes = {name: Scene(vertices, faces, accelerator=name) for name in accelerators}
    first = next(iter(scenes.values()), None)
    if first is None:
        raise ValueError("accelerators: none, expected some of 'kdtree', 'embree' and 'brute-force'")
    rows = []
    for rays_name, (origins, directions) in (_default_rays(first.bounds) if rays is None else rays).items():
        expected = first.intersect(origins, directions)
        speeds: dict[tuple[str, str], float] = {}
        for _ in range(rounds):
            for name, scene in scenes.items():
                for query in ("intersect", "occluded"):
                    seconds = _seconds(getattr(scene, query), origins, directions, threads)
                    speed = len(expected.t) / seconds * 1e-6
                    speeds[name, query] = max(speed, speeds.get((name, query), 0.0))
        for name, scene in scenes.items():
            statistics = scene.statistics
            rows.append(
                {
                    "rays": rays_name,
                    "accelerator": description(name),
                    "nearest": speeds[name, "intersect"],
                    "any_hit": speeds[name, "occluded"],
                    "build_s": statistics["build_s"],
                    "memory_mb": statistics["memory_bytes"] * 1e-6,
                    "differs": _differing(expected, scene.intersect(origins, directions)),
                }
            )
    try:
        return importlib.import_module("pandas").DataFrame(rows)
    except ImportError:
        return rows


def _seconds(query: Callable[..., Any], origins: ArrayLike, directions: ArrayLike, threads: int) -> float:
    start = time.perf_counter()
    query(origins, directions, threads=threads)
    return time.perf_counter() - start


def _differing(expected: Hits, found: Hits) -> int:
    both = expected.is_hit & found.is_hit
    far = np.zeros(len(both), dtype=bool)
    far[both] = np.abs(found.t[both] - expected.t[both]) > 1e-3 * expected.t[both]
    return int(np.count_nonzero(far | (expected.is_hit != found.is_hit)))


def _default_rays(bounds: NDArray[np.float32]) -> dict[str, tuple[NDArray[np.float32], NDArray[np.float32]]]:
    center, size = bounds.mean(axis=0), float(np.linalg.norm(bounds[1] - bounds[0]))
    x, y = np.meshgrid(np.linspace(-0.25, 0.25, 447), np.linspace(-0.25, 0.25, 447))
    camera = np.stack([x, y, np.full_like(x, -1.0)], -1).reshape(-1, 3).astype(np.float32)
    rng = np.random.default_rng(1)
    ends = rng.uniform(bounds[0], bounds[1], (2, 200_000, 3)).astype(np.float32)
    eye = np.tile(center + np.array([0.0, 0.0, 1.5 * size]), (len(camera), 1)).astype(np.float32)
    return {"camera": (eye, camera), "random": (ends[0], ends[1] - ends[0])}
