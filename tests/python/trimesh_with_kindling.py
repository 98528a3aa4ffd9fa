# SPDX-License-Identifier: Apache-2.0
"""A pytest plugin: trimesh's tests of ray queries with Kindling in the place of Embree."""
import pytest
import trimesh.ray.ray_pyembree
from kindling.accel.trimesh import RayMeshIntersector

trimesh.ray.ray_pyembree.RayMeshIntersector = RayMeshIntersector

# Tests of models that PyPI's source package lacks.
MISSING = {"test_rays": "ray_data", "test_on_edge": "7_8ths_cube.stl", "test_contain_single": "teapot.stl"}


def pytest_collection_modifyitems(items):
    """Skips tests of missing models."""
    for item in items:
        if item.name in MISSING:
            item.add_marker(pytest.mark.skip(reason=f"PyPI's source has no {MISSING[item.name]}"))
