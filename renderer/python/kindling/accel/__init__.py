# SPDX-License-Identifier: Apache-2.0
"""Rays against triangles: nearest hits, occlusion, and every hit of a ray.

    import numpy, kindling.accel

    scene = kindling.accel.Scene(vertices, faces)
    hits = scene.intersect(origins, directions)
    hits.t[hits.is_hit]

Arrays of rays may be float32 or float64 with any strides; other numbers are converted. Computation is in float32.
Queries use all processor cores and release the GIL; results are the same bits for any number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kindling import _accel

__all__ = ["Crossings", "Hits", "Scene", "description"]


class Hits(NamedTuple):
    """Nearest hits of n rays. Where a ray hits nothing, t is infinite and the ids are -1."""

    t: NDArray[np.float32]
    """(n,) distance in lengths of the ray's direction, which need not be normalized."""
    u: NDArray[np.float32]
    """(n,) barycentric coordinate: the point is (1 - u - v) p0 + u p1 + v p2."""
    v: NDArray[np.float32]
    """(n,) barycentric coordinate."""
    triangle: NDArray[np.int32]
    """(n,) row of the mesh's faces."""
    mesh: NDArray[np.int32]
    """(n,) index of the mesh."""
    instance: NDArray[np.int32]
    """(n,) index of the instance; that of the mesh in a scene without instances."""

    @property
    def is_hit(self) -> NDArray[np.bool_]:
        """(n,) true where the ray hits something."""
        return self.instance >= 0


class Crossings(NamedTuple):
    """Every hit of n rays, m in all: by ray, then by distance.

    Surfaces are crossed exactly once, also at edges and vertices: a line crosses a closed mesh as often at the front as
    at the back.
    """

    first: NDArray[np.int64]
    """(n + 1,) the hits of ray i are first[i] to first[i + 1] of the other arrays."""
    ray: NDArray[np.int64]
    """(m,) index of the ray."""
    t: NDArray[np.float32]
    """(m,) distance in lengths of the ray's direction."""
    u: NDArray[np.float32]
    """(m,) barycentric coordinate, see Hits."""
    v: NDArray[np.float32]
    """(m,) barycentric coordinate, see Hits."""
    triangle: NDArray[np.int32]
    """(m,) row of the mesh's faces."""
    mesh: NDArray[np.int32]
    """(m,) index of the mesh."""
    instance: NDArray[np.int32]
    """(m,) index of the instance."""
    front: NDArray[np.bool_]
    """(m,) the ray meets the side from which the corners run counter-clockwise: it enters a closed mesh."""

    @property
    def counts(self) -> NDArray[np.int64]:
        """(n,) number of hits of each ray."""
        return np.diff(self.first)

    @property
    def winding(self) -> NDArray[np.int64]:
        """(n,) hits at the back minus hits at the front.

        For rays without an end it is the winding number of their origins: 1 inside of a closed mesh, 0 outside.
        """
        signs = np.where(self.front, -1, 1)
        sums = np.concatenate([[0], np.cumsum(signs)])
        winding: NDArray[np.int64] = sums[self.first[1:]] - sums[self.first[:-1]]
        return winding


class Scene:
    """Triangle meshes in an accelerator. Immutable; queries may run in several threads at once.

    Scene(vertices, faces) has one mesh: vertices (v, 3) float, faces (f, 3) integer rows of vertices.
    Scene(meshes=[(vertices, faces), ...]) has several, Scene(meshes=..., instances=[(mesh, matrix), ...]) places them
    by affine (4, 4) matrices for column vectors, with the translation in the last column. The arrays are copied.

    accelerator: "kdtree" is watertight; "embree" is Intel Embree, whose hits may differ by rounding, and which may miss
    triangles at edges; "brute-force" is for tests. quality: "fast", "balanced" or "best", the effort of the build.
    robust: whether Embree takes the slower and safer of its tests. threads of the build: 0 for all.

    Triangles without area, or with a vertex that is not finite, are never hit. Raises ValueError or TypeError for
    arrays that do not fit, with their shapes and values.
    """

    def __init__(
        self,
        vertices: ArrayLike | None = None,
        faces: ArrayLike | None = None,
        *,
        meshes: Sequence[tuple[ArrayLike, ArrayLike]] | None = None,
        instances: Sequence[tuple[int, ArrayLike]] | None = None,
        accelerator: str = "kdtree",
        quality: str = "balanced",
        robust: bool = True,
        threads: int = 0,
    ) -> None:
        if meshes is None:
            if vertices is None or faces is None:
                raise TypeError("Scene() takes vertices and faces, or meshes")
            meshes = [(vertices, faces)]
        elif vertices is not None or faces is not None:
            raise TypeError("Scene() takes vertices and faces, or meshes, not both")
        arrays = [(_floats(v), _integers(f)) for v, f in meshes]
        placed = None if instances is None else [(int(mesh), _floats(matrix)) for mesh, matrix in instances]
        self._scene = _accel.Scene.make(arrays, placed, accelerator, quality, robust, threads)
        self._accelerator = accelerator

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        threads: int = 0,
    ) -> Hits:
        """Return the nearest hit of each ray with a distance above t_min and up to t_max.

        origins, directions: (n, 3), or (3,) for all rays; t_min, t_max: (n,) or a number, in lengths of the direction.
        threads: 0 for all.
        """
        return Hits(*self._scene.intersect(*_rays(origins, directions, t_min, t_max), threads))

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        threads: int = 0,
    ) -> NDArray[np.bool_]:
        """Return (n,) true where a ray hits anything. Faster than intersect(); the arguments are the same."""
        return self._scene.occluded(*_rays(origins, directions, t_min, t_max), threads)

    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        limit: int | None = None,
        threads: int = 0,
    ) -> Crossings:
        """Return every hit of each ray, or the nearest `limit` of them. The other arguments are those of intersect()."""
        if limit is not None and limit < 0:
            raise ValueError(f"limit: {limit}, expected None or a number of hits")
        max_hits = -1 if limit is None else limit
        return Crossings(*self._scene.all_hits(*_rays(origins, directions, t_min, t_max), max_hits, threads))

    @property
    def bounds(self) -> NDArray[np.float32]:
        """(2, 3) lower and upper corner of all that can be hit; infinite, and the wrong way round, if nothing can."""
        return np.array(self._scene.bounds(), dtype=np.float32)

    @property
    def statistics(self) -> dict[str, Any]:
        """Build time in seconds, memory in bytes, triangles, instances, and the instruction set in use."""
        return self._scene.statistics()

    def __repr__(self) -> str:
        s = self.statistics
        return f"<kindling.accel.Scene: {s['triangle_count']} triangles, {self._accelerator}>"


def description(accelerator: str) -> str:
    """Return the name and version of an accelerator, e.g. "Embree 3.13.5"."""
    return _accel.description(accelerator)


def _floats(array: ArrayLike) -> NDArray[Any]:
    """The array itself if it holds float32 or float64, else a float64 copy."""
    array = np.asarray(array)
    return array if array.dtype in (np.float32, np.float64) else array.astype(np.float64)


def _integers(array: ArrayLike) -> NDArray[Any]:
    """The array itself, or int64 for smaller integers. Others stay, and are refused with their type."""
    array = np.asarray(array)
    if array.dtype.kind in "iu" and array.dtype.itemsize < 4:
        return array.astype(np.int64)
    return array


def _rays(
    origins: ArrayLike, directions: ArrayLike, t_min: ArrayLike, t_max: ArrayLike
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    return _floats(origins), _floats(directions), _floats(t_min), _floats(t_max)
