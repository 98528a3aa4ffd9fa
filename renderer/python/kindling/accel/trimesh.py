# SPDX-License-Identifier: Apache-2.0
"""A drop-in for trimesh's ray queries with Embree, which finds every hit.

    import trimesh, kindling.accel.trimesh

    mesh = trimesh.load_mesh("part.stl")
    mesh.ray = kindling.accel.trimesh.RayMeshIntersector(mesh)

trimesh steps past each hit by an offset to find the next, which loses hits that are closer. Here one query finds all.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from trimesh import caching, util
from trimesh.ray.ray_util import contains_points

from kindling.accel import Scene

__all__ = ["RayMeshIntersector"]


class RayMeshIntersector:
    """Ray queries of a trimesh.Trimesh; methods, arguments and results are those of trimesh.ray.ray_pyembree.

    Hits are sorted by ray, then by distance. As with embreex, a ray that begins on the surface hits it: rays begin
    earlier by the rounding of their origins in float32. The scene is built by the first query, and again if the mesh
    has changed.
    scale_to_box: scales the mesh to about 100 units, so that neither tiny nor large meshes meet the limits of float32.
    accelerator: see kindling.accel.Scene.
    """

    def __init__(self, geometry: Any, scale_to_box: bool = True, accelerator: str = "kdtree") -> None:
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._accelerator = accelerator
        self._cache: Any = _new_cache(self.mesh)

    @property
    def _scale(self) -> float:
        return 100.0 / float(self.mesh.scale) if self._scale_to_box and self.mesh.scale > 0.0 else 1.0

    @property
    def _scene(self) -> tuple[Scene, NDArray[np.float64], float]:
        """The scene, and what its coordinates are: (x - origin) * scale."""
        cached: tuple[Scene, NDArray[np.float64], float] | None = self._cache["scene"]
        if cached is None:
            vertices = np.asarray(self.mesh.vertices, dtype=np.float64)
            scale, origin = self._scale, vertices.min(axis=0)
            faces = np.asarray(self.mesh.faces, dtype=np.int64)
            cached = (Scene((vertices - origin) * scale, faces, accelerator=self._accelerator), origin, scale)
            self._cache["scene"] = cached
        return cached

    def _rays(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> tuple[Scene, NDArray[np.float64], NDArray[np.float64]]:
        """The scene, and the rays in its coordinates, begun a little earlier, with unit directions."""
        origins = np.asarray(ray_origins, dtype=np.float64)
        directions = np.asarray(ray_directions, dtype=np.float64)
        if origins.shape != directions.shape:
            raise ValueError(
                f"Ray origin and direction don't match! ray_origins has shape {origins.shape}, "
                f"ray_directions {directions.shape}"
            )
        scene, origin, scale = self._scene
        origins, directions = (origins - origin) * scale, util.unitize(directions)
        return scene, origins - directions * self._rounding(origins), directions

    def _rounding(self, origins: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 1) length by which rays begin earlier: a few units in the last place of float32, in the scene's coordinates."""
        extent = float(np.ptp(self.mesh.bounds)) * self._scene[2]
        x, y, z = np.abs(origins).T  # max(axis=1) takes several times as long
        reach: NDArray[np.float64] = np.maximum(np.maximum(x, y), z)[:, None] + extent
        return reach * 2.0**-22

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int = 100,
        return_locations: bool = False,
    ) -> Any:
        """Find the triangles hit by rays.

        ray_origins, ray_directions: (n, 3) float. multiple_hits: all hits instead of the first. max_hits: of each ray.
        Returns index_tri (m,), index_ray (m,) and, if return_locations, the points (m, 3) in the units of the mesh.
        """
        scene, origins, directions = self._rays(ray_origins, ray_directions)
        if multiple_hits:
            crossings = scene.all_hits(origins, directions, limit=max_hits)
            index_tri, index_ray, t = crossings.triangle.astype(np.int64), crossings.ray, crossings.t
        else:
            hits = scene.intersect(origins, directions)
            index_ray = np.flatnonzero(hits.is_hit)
            index_tri, t = hits.triangle[index_ray].astype(np.int64), hits.t[index_ray]
        if not return_locations:
            return index_tri, index_ray
        return index_tri, index_ray, self._locations(ray_origins, directions, index_tri, index_ray, t)

    def _locations(
        self,
        ray_origins: ArrayLike,
        directions: NDArray[np.float64],
        index_tri: NDArray[np.int64],
        index_ray: NDArray[np.int64],
        t: NDArray[np.float32],
    ) -> NDArray[np.float64]:
        """Where the rays meet the planes of the triangles, in double precision."""
        origins, directions = np.asarray(ray_origins, dtype=np.float64)[index_ray], directions[index_ray]
        normals = self.mesh.face_normals[index_tri]
        corners = self.mesh.triangles[index_tri, 0]
        cosines = np.einsum("ij,ij->i", normals, directions)
        heights = np.einsum("ij,ij->i", normals, corners - origins)
        flat = np.abs(cosines) <= 1e-6  # there the distance in single precision is the better one
        distances = heights / np.where(flat, 1.0, cosines)
        if flat.any():
            in_scene = (origins[flat] - self._scene[1]) * self._scene[2]
            distances[flat] = (t[flat] - self._rounding(in_scene)[:, 0]) / self._scene[2]
        locations: NDArray[np.float64] = origins + directions * distances[:, None]
        return locations

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Return the points (m, 3) where rays hit the surface, index_ray (m,) and index_tri (m,)."""
        index_tri, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits=multiple_hits, return_locations=True
        )
        return locations, index_ray, index_tri

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> NDArray[np.int64]:
        """Return (n,) the triangle that each ray hits first, or -1."""
        scene, origins, directions = self._rays(ray_origins, ray_directions)
        return scene.intersect(origins, directions).triangle.astype(np.int64)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> NDArray[np.bool_]:
        """Return (n,) whether each ray hits the surface."""
        scene, origins, directions = self._rays(ray_origins, ray_directions)
        return scene.occluded(origins, directions)

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return (n,) whether points (n, 3) are inside of the mesh, as trimesh decides by rays."""
        contained: NDArray[np.bool_] = contains_points(self, points)
        return contained

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        state.pop("_cache", None)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._cache = _new_cache(self.mesh)

    def __copy__(self, *args: Any) -> RayMeshIntersector:
        return RayMeshIntersector(self.mesh, self._scale_to_box, self._accelerator)

    def __deepcopy__(self, *args: Any) -> RayMeshIntersector:
        return self.__copy__()


def _new_cache(mesh: Any) -> Any:
    """A cache that is emptied when the mesh changes."""
    make: Any = caching.Cache
    return make(id_function=mesh.__hash__)
