# SPDX-License-Identifier: Apache-2.0
"""Tests of kindling.accel.trimesh against trimesh's own intersectors, and where those lose hits."""
import copy
import pickle

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")
from kindling.accel.trimesh import RayMeshIntersector  # noqa: E402


def rays(mesh, count=2000, seed=3):
    rng = np.random.default_rng(seed)
    origins = mesh.bounds.mean(0) + 2 * mesh.scale * trimesh.unitize(rng.normal(size=(count, 3)))
    targets = mesh.bounds.mean(0) + mesh.scale * rng.uniform(-0.3, 0.3, (count, 3))
    return origins, targets - origins


@pytest.fixture(params=["torus", "box", "tiny torus", "far torus"])
def mesh(request):
    made = trimesh.creation.box() if request.param == "box" else trimesh.creation.torus(2, 0.7)
    if request.param == "tiny torus":
        made.apply_scale(1e-3)
    if request.param == "far torus":
        made.apply_translation([1e5, -1e5, 1e5])
    return made


def test_first_hits_are_those_of_trimesh(mesh):
    embree = pytest.importorskip("trimesh.ray.ray_pyembree")
    origins, directions = rays(mesh)
    ours, theirs = RayMeshIntersector(mesh), embree.RayMeshIntersector(mesh)
    first = ours.intersects_first(origins, directions)
    assert first.dtype == np.int64 and (first >= 0).sum() > 500
    expected = np.full(len(origins), -1)  # theirs rounds origins before it moves them, unlike intersects_id()
    tri, ray = theirs.intersects_id(origins, directions, multiple_hits=False)
    expected[ray] = tri
    assert (first == expected).mean() > 0.998
    np.testing.assert_array_equal(ours.intersects_any(origins, directions), first >= 0)
    locations, index_ray, index_tri = ours.intersects_location(origins, directions, multiple_hits=False)
    other_locations, other_ray, _ = theirs.intersects_location(origins, directions, multiple_hits=False)
    order = np.argsort(other_ray)
    both, a, b = np.intersect1d(index_ray, other_ray[order], return_indices=True)
    assert len(both) > 500
    np.testing.assert_allclose(locations[a], other_locations[order][b], atol=2e-5 * mesh.scale)
    np.testing.assert_array_equal(index_tri, first[index_ray])


def test_all_hits_are_those_of_trimesh(mesh):
    embree = pytest.importorskip("trimesh.ray.ray_pyembree")
    origins, directions = rays(mesh)
    index_tri, index_ray, locations = RayMeshIntersector(mesh).intersects_id(origins, directions, return_locations=True)
    ours = set(zip(index_ray.tolist(), index_tri.tolist()))
    theirs = set(zip(*[i.tolist() for i in embree.RayMeshIntersector(mesh).intersects_id(origins, directions)[::-1]]))
    assert len(ours ^ theirs) <= 0.003 * len(ours)
    assert (np.bincount(index_ray, minlength=len(origins)) % 2 == 0).all()  # theirs need not be
    assert (np.diff(index_ray) >= 0).all()
    distances = np.einsum("ij,ij->i", locations - origins[index_ray], directions[index_ray])
    assert (np.diff(distances)[np.diff(index_ray) == 0] >= -1e-6 * mesh.scale**2).all()
    if mesh.scale > 0.1:  # trimesh's own tolerance is absolute
        _, from_surface, _ = trimesh.proximity.closest_point_naive(mesh, locations[:50])
        assert from_surface.max() < 1e-5 * mesh.scale


def test_layers_closer_than_any_offset():
    """Sheets one part in a million of the size apart: stepping past a hit by an offset skips some."""
    sheet = trimesh.creation.box([1, 1, 1e-6])
    sheets = trimesh.util.concatenate([sheet.copy().apply_translation([0, 0, 3e-6 * i]) for i in range(5)])
    mesh = trimesh.util.concatenate([sheets, trimesh.creation.box([1, 1, 1]).apply_translation([0, 0, -1])])
    hits = RayMeshIntersector(mesh).intersects_id([[0.1, 0.2, 5]], [[0, 0, -1]])[0]
    assert len(hits) == 12


def test_contains_points():
    mesh = trimesh.creation.icosphere(3)
    points = np.random.default_rng(9).uniform(-1.1, 1.1, (3000, 3))
    radius = np.linalg.norm(points, axis=1)
    clear = (radius < 0.98) | (radius > 1.0)
    inside = RayMeshIntersector(mesh).contains_points(points)
    np.testing.assert_array_equal(inside[clear], radius[clear] < 0.99)


def test_follows_changes_of_the_mesh():
    mesh = trimesh.creation.box()
    ray = RayMeshIntersector(mesh)
    assert ray.intersects_any([[5, 0, 0.1]], [[0, 0, 1]]).tolist() == [False]
    mesh.apply_translation([5, 0, 0])
    assert ray.intersects_any([[5, 0, 0.1]], [[0, 0, 1]]).tolist() == [True]
    for other in (copy.copy(ray), copy.deepcopy(ray), pickle.loads(pickle.dumps(ray))):
        assert other.intersects_first([[5, 0, 0.1]], [[0, 0, 1]])[0] >= 0


def test_no_hits_and_limits():
    mesh = trimesh.creation.icosphere(2)
    ray = RayMeshIntersector(mesh)
    tri, index, locations = ray.intersects_id([[9, 9, 9]], [[1, 0, 0]], return_locations=True)
    assert (tri.shape, index.shape, locations.shape) == ((0,), (0,), (0, 3))
    assert len(ray.intersects_id([[0.1, 0.2, 9]], [[0, 0, -1]], max_hits=1)[0]) == 1
    with pytest.raises(ValueError, match=r"don't match! ray_origins has shape \(1, 3\), ray_directions \(2, 3\)"):
        ray.intersects_first([[0, 0, 0]], [[0, 0, 1], [0, 0, 1]])


def test_locations_on_triangles_seen_edge_on():
    sliver = trimesh.Trimesh([[-1, -1, 0], [1, -1, 0], [0, 1, 2e-7]], [[0, 1, 2]], process=False)  # a slope of 1e-7
    origins, directions = [[0, -3, 5e-8], [0.1, 0, 1]], [[0, 1, 0], [0, 0, -1]]
    locations, index_ray, _ = RayMeshIntersector(sliver).intersects_location(origins, directions)
    np.testing.assert_array_equal(index_ray, [0, 1])
    np.testing.assert_allclose(locations, [[0, -0.5, 5e-8], [0.1, 0, 1e-7]], atol=1e-5)
