# SPDX-License-Identifier: Apache-2.0
"""Stands in for the module of trimesh's tests that reads models: some of them, made here."""
import logging
import time

import numpy as np
import trimesh

__all__ = ["get_mesh", "log", "np", "random", "time", "trimesh"]

log = logging.getLogger("trimesh")
_rng = np.random.default_rng(0)


def random(shape):
    """Numbers in [0, 1)."""
    return _rng.random(shape)


def get_mesh(name, use_embree=True):
    """A mesh in the place of a model."""
    mesh = {
        "unit_sphere.STL": lambda: trimesh.creation.icosphere(3, radius=0.5),
        "unit_cube.STL": trimesh.creation.box,
        "featuretype.STL": lambda: trimesh.creation.torus(2, 0.7),
    }[name]()
    ray = trimesh.ray.ray_pyembree if use_embree else trimesh.ray.ray_triangle
    mesh.ray = ray.RayMeshIntersector(mesh)
    return mesh
