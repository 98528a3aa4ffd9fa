# SPDX-License-Identifier: Apache-2.0
"""Tests of kindling.accel: known hits, types and strides of arrays, threads, errors."""
import threading

import numpy as np
import pytest
from kindling import accel

KINDS = ["kdtree", "embree", "brute-force"]


def sphere(rings=24, segments=48):
    """Vertices and faces of a closed sphere of radius 1, corners counter-clockwise from outside."""
    theta = np.pi * np.arange(1, rings) / rings
    phi = 2 * np.pi * np.arange(segments) / segments
    around = np.stack(np.broadcast_arrays(np.sin(theta)[:, None] * np.cos(phi), np.sin(theta)[:, None] * np.sin(phi), np.cos(theta)[:, None]), -1)
    vertices = np.concatenate([[[0, 0, 1]], around.reshape(-1, 3), [[0, 0, -1]]])
    faces = []
    for s in range(segments):
        def at(ring, k):
            return 1 + (ring - 1) * segments + k % segments
        faces.append((0, at(1, s), at(1, s + 1)))
        faces.append((len(vertices) - 1, at(rings - 1, s + 1), at(rings - 1, s)))
        for r in range(1, rings - 1):
            faces += [(at(r, s), at(r + 1, s), at(r + 1, s + 1)), (at(r, s), at(r + 1, s + 1), at(r, s + 1))]
    return vertices, np.array(faces)


def random_rays(count, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(-2, 2, (count, 3)), rng.normal(size=(count, 3))


TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize("kind", KINDS)
def test_known_hit(kind):
    scene = accel.Scene(*TRIANGLE, accelerator=kind)
    hits = scene.intersect([[0.25, 0.5, 2], [2, 2, 2]], [0, 0, -4])
    assert hits.is_hit.tolist() == [True, False]
    assert hits.t.tolist() == [0.5, np.inf]
    assert (hits.u[0], hits.v[0]) == (0.25, 0.5)
    assert hits.triangle.tolist() == hits.mesh.tolist() == hits.instance.tolist() == [0, -1]
    assert scene.occluded([[0.25, 0.5, 2], [2, 2, 2]], [0, 0, -4]).tolist() == [True, False]
    np.testing.assert_allclose(scene.bounds, [[0, 0, 0], [1, 1, 0]], atol=1e-5)
    assert scene.statistics["triangle_count"] == 1


@pytest.mark.parametrize("kind", KINDS)
def test_intervals(kind):
    scene = accel.Scene(*TRIANGLE, accelerator=kind)
    origins, down = np.tile([0.25, 0.25, 2.0], (4, 1)), [0, 0, -1]
    t_min, t_max = [0, 1.5, 2.5, 0], np.array([1.5, 2.5, 3.5, 2.5], dtype=np.float32)
    assert scene.intersect(origins, down, t_min=t_min, t_max=t_max).is_hit.tolist() == [False, True, False, True]
    assert scene.occluded(origins, down, t_min=t_min, t_max=t_max).tolist() == [False, True, False, True]
    assert scene.all_hits(origins, down, t_min=t_min, t_max=t_max).counts.tolist() == [0, 1, 0, 1]


def test_kinds_agree():
    vertices, faces = sphere()
    origins, directions = random_rays(20000)
    tree, embree, oracle = (accel.Scene(vertices, faces, accelerator=kind) for kind in KINDS)
    hits, expected = tree.intersect(origins, directions), oracle.intersect(origins[:2000], directions[:2000])
    for found, right in zip(hits, expected):
        np.testing.assert_array_equal(found[:2000], right)
    other = embree.intersect(origins, directions)
    assert np.count_nonzero(other.is_hit != hits.is_hit) <= 2
    both = other.is_hit & hits.is_hit
    assert 2000 < np.count_nonzero(both) < 18000
    np.testing.assert_allclose(other.t[both], hits.t[both], rtol=1e-3, atol=1e-4)
    np.testing.assert_array_equal(tree.occluded(origins, directions), hits.is_hit)


@pytest.mark.parametrize("kind", KINDS)
def test_points_of_hits(kind):
    vertices, faces = sphere()
    origins, directions = random_rays(1000)
    hits = accel.Scene(vertices, faces, accelerator=kind).intersect(origins, directions)
    m = hits.is_hit
    corners = vertices[faces[hits.triangle[m]]]
    u, v = hits.u[m, None], hits.v[m, None]
    on_triangle = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
    np.testing.assert_allclose(on_triangle, origins[m] + hits.t[m, None] * directions[m], atol=1e-5)


def test_any_strides_and_types():
    vertices, faces = sphere()
    origins, directions = random_rays(3000)
    expected = accel.Scene(vertices, faces).intersect(origins, directions)
    wide = np.zeros((3000, 9))
    wide[:, ::-3] = origins[:, [0, 1, 2]]
    columns = np.asfortranarray(directions)
    for v, f in [(vertices.astype(np.float32), faces.astype(np.uint16)), (np.asfortranarray(vertices), faces[:, ::-1].astype(np.int32)[:, ::-1]),
                 (vertices, faces.astype(np.uint64)), (vertices, faces.astype(np.uint32))]:
        found = accel.Scene(v, f).intersect(wide[:, ::-3], columns)
        for a, b in zip(found, expected):
            np.testing.assert_array_equal(a, b)
    backwards = accel.Scene(vertices, faces).intersect(origins[::-1], directions[::-1])
    np.testing.assert_array_equal(backwards.t[::-1], expected.t)
    single = accel.Scene(vertices, faces).intersect(origins.astype(np.float32), directions.astype(np.float32))
    np.testing.assert_array_equal(single.t, expected.t)  # the computation is in float32 anyway
    read_only = origins.copy()
    read_only.flags.writeable = False
    assert accel.Scene(vertices, faces).intersect(read_only, [0, 0, 1]).t.shape == (3000,)


def test_one_row_serves_all_rays():
    scene = accel.Scene(*sphere())
    _, directions = random_rays(500)
    many, one = scene.intersect(np.zeros((500, 3)), directions), scene.intersect([0, 0, 0], directions)
    np.testing.assert_array_equal(many.t, one.t)
    assert scene.intersect([0, 0, 0], [0, 0, 1]).t.shape == (1,)
    assert scene.intersect(np.zeros((0, 3)), [0, 0, 1]).t.shape == (0,)
    assert scene.all_hits(np.zeros((0, 3)), np.zeros((0, 3))).first.tolist() == [0]


@pytest.mark.parametrize("kind", ["kdtree", "embree"])
def test_bits_do_not_depend_on_threads(kind):
    vertices, faces = sphere()
    scenes = [accel.Scene(vertices, faces, accelerator=kind, threads=threads) for threads in (1, 3)]
    origins, directions = random_rays(10000)
    origins[3000:6000] = [0.1, 0.2, -3]  # and some that are traced as coherent rays
    directions[3000:6000] = [0, 0, 1] + 0.1 * directions[3000:6000]
    expected = scenes[0].intersect(origins, directions, threads=1)
    crossings = scenes[0].all_hits(origins, directions, threads=1)
    for scene in scenes:
        for threads in (0, 2, 5):
            for a, b in zip(scene.intersect(origins, directions, threads=threads), expected):
                np.testing.assert_array_equal(a, b)
            for a, b in zip(scene.all_hits(origins, directions, threads=threads), crossings):
                np.testing.assert_array_equal(a, b)
    if kind == "kdtree":  # nor on the rays beside them
        one = [scenes[0].intersect(origins[i], directions[i]).t[0] for i in range(2900, 3200)]
        np.testing.assert_array_equal(one, expected.t[2900:3200])


def test_all_hits_of_a_closed_mesh():
    vertices, faces = sphere()
    scene = accel.Scene(vertices, faces)
    rng = np.random.default_rng(5)
    targets = vertices[rng.integers(len(vertices), size=4000)]  # straight through vertices
    inside = rng.uniform(-0.4, 0.4, (4000, 3))
    out = scene.all_hits(inside, targets - inside)
    assert (out.winding == 1).all() and (out.counts % 2 == 1).all()
    outside = 5 * targets[::-1] + rng.normal(size=(4000, 3))
    through = scene.all_hits(outside, targets - outside)
    assert (through.winding == 0).all() and through.counts.max() >= 2
    assert (np.diff(through.t)[np.diff(through.ray) == 0] >= 0).all()
    nearest = scene.intersect(outside, targets - outside)
    hit = through.counts > 0
    # At a vertex the nearest hit may be that of a triangle beside the crossed one.
    np.testing.assert_allclose(through.t[through.first[:-1][hit]], nearest.t[hit], rtol=1e-6)
    np.testing.assert_array_equal(np.repeat(np.arange(4000), through.counts), through.ray)


@pytest.mark.parametrize("kind", KINDS)
def test_limit(kind):
    stack = np.concatenate([np.array(TRIANGLE[0]) + [0, 0, z] for z in range(10)])
    scene = accel.Scene(stack, np.arange(30).reshape(10, 3), accelerator=kind)
    up = dict(origins=[[0.2, 0.2, -1], [0.2, 0.2, 4.5]], directions=[0, 0, 1])
    assert scene.all_hits(**up).triangle.tolist() == [*range(10), *range(5, 10)]
    assert scene.all_hits(**up, limit=3).triangle.tolist() == [0, 1, 2, 5, 6, 7]
    assert scene.all_hits(**up, limit=0).counts.tolist() == [0, 0]
    assert not scene.all_hits(**up).front.any()


@pytest.mark.parametrize("kind", KINDS)
def test_instances(kind):
    def moved(x, scale):
        matrix = np.diag([scale, scale, scale, 1.0])
        matrix[0, 3] = x
        return matrix
    shell, triangle = sphere(), TRIANGLE
    scene = accel.Scene(meshes=[triangle, shell], instances=[(1, moved(0, 1)), (1, moved(10, -2)), (0, moved(20, 1))], accelerator=kind)
    hits = scene.intersect([[0, 0, 9], [10, 0, 9], [20.1, 0.1, 9], [30, 0, 9]], [0, 0, -1])
    assert hits.instance.tolist() == [0, 1, 2, -1]
    assert hits.mesh.tolist() == [1, 1, 0, -1]
    np.testing.assert_allclose(hits.t[:3], [8, 7, 9], atol=1e-4)
    through = scene.all_hits([10.01, 0.02, 9], [0, 0, -1])
    assert through.front.tolist() == [True, False]  # mirrored, and yet entered at the front
    assert accel.Scene(meshes=[triangle, shell]).intersect([0, 0, 9], [0, 0, -1]).instance.tolist() == [1]


def test_rays_that_cannot_hit():
    scene = accel.Scene(*sphere())
    hits = scene.intersect([[0, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]], [[0, 0, 0], [1, 0, 0], [1, 0, 0]])
    assert not hits.is_hit.any() and np.isinf(hits.t).all()
    empty = accel.Scene(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    assert not empty.occluded([0, 0, 0], [0, 0, 1]).any()


def test_other_threads_run_during_queries():
    """The GIL is released: several threads trace at once and get the same bits."""
    scene = accel.Scene(*sphere())
    origins, directions = random_rays(200000)
    expected = scene.intersect(origins, directions).t
    results = [None] * 4

    def trace(i):
        results[i] = scene.intersect(origins, directions).t
    threads = [threading.Thread(target=trace, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for found in results:
        np.testing.assert_array_equal(found, expected)


V, F = TRIANGLE


@pytest.mark.parametrize("call, error, text", [
    (lambda: accel.Scene(V, [[0, 1, 3]]), ValueError, r"meshes\[0\]: faces\[0\] is \(0, 1, 3\), but there are 3 vertices"),
    (lambda: accel.Scene(V, [[0, 1, -1]]), ValueError, r"faces\[0\] is \(0, 1, -1\)"),
    (lambda: accel.Scene([[0, 0]], F), ValueError, r"vertices: shape \(1, 2\), expected \(3,\) or \(n, 3\)"),
    (lambda: accel.Scene([0, 0, 0], F), ValueError, r"vertices: shape \(3,\), expected \(n, 3\)"),
    (lambda: accel.Scene(V, [0, 1, 2]), ValueError, r"faces: shape \(3,\), expected \(n, 3\)"),
    (lambda: accel.Scene(V, [[0.0, 1.0, 2.0]]), TypeError, r"faces: dtype float64, expected int32"),
    (lambda: accel.Scene(V, F, accelerator="bvh4"), ValueError, r"'bvh4', expected 'kdtree', 'embree' or 'brute-force'"),
    (lambda: accel.Scene(V, F, quality="good"), ValueError, r"quality: 'good', expected 'fast', 'balanced' or 'best'"),
    (lambda: accel.Scene(V, F, threads=-1), ValueError, r"threads: -1"),
    (lambda: accel.Scene(V), TypeError, r"vertices and faces, or meshes"),
    (lambda: accel.Scene(V, F, meshes=[(V, F)]), TypeError, r"not both"),
    (lambda: accel.Scene(meshes=[(V, F)], instances=[(1, np.eye(4))]), ValueError, r"instances\[0\]: mesh 1, but there are 1"),
    (lambda: accel.Scene(meshes=[(V, F)], instances=[(0, np.eye(3))]), ValueError, r"instances\[0\]: matrix: shape \(3, 3\)"),
    (lambda: accel.Scene(V, F).intersect(np.zeros((4, 2)), [0, 0, 1]), ValueError, r"origins: shape \(4, 2\), expected \(3,\) or \(n, 3\)"),
    (lambda: accel.Scene(V, F).intersect(np.zeros((4, 3)), np.ones((5, 3))), ValueError, r"directions has 5 rows, but origins has 4"),
    (lambda: accel.Scene(V, F).occluded(np.zeros((4, 3)), [0, 0, 1], t_max=[1, 2]), ValueError, r"t_max has 2 rows, but origins has 4"),
    (lambda: accel.Scene(V, F).all_hits([0, 0, 0], [0, 0, 1], limit=-1), ValueError, r"limit: -1"),
    (lambda: accel.Scene(V, F).intersect([0, 0, 0], ["a", "b", "c"]), ValueError, r"could not convert"),
])
def test_errors_name_shapes_and_values(call, error, text):
    with pytest.raises(error, match=text):
        call()


def test_descriptions():
    assert "kd-tree" in accel.description("kdtree")
    assert "Embree" in accel.description("embree")
    assert repr(accel.Scene(V, F)) == "<kindling.accel.Scene: 1 triangles, kdtree>"
