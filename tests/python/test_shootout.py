# SPDX-License-Identifier: Apache-2.0
"""Tests of kindling.shootout: rows, agreement, rays of the caller."""
import kindling
import numpy as np
import pytest
from test_accel import sphere


def rows_of(table):
    return table if isinstance(table, list) else table.to_dict("records")


def test_rows_for_rays_and_accelerators():
    rows = rows_of(kindling.shootout(*sphere(), rounds=1))
    assert [(row["rays"], row["accelerator"].split()[0]) for row in rows] == [
        ("camera", "Kindling"), ("camera", "Embree"), ("random", "Kindling"), ("random", "Embree")]
    for row in rows:
        assert row["nearest"] > 0 and row["any_hit"] > 0 and row["build_s"] > 0 and row["memory_mb"] > 0
        assert row["differs"] <= 20


def test_rays_of_the_caller():
    rng = np.random.default_rng(2)
    rays = {"mine": (rng.normal(size=(500, 3)), rng.normal(size=(500, 3)))}
    rows = rows_of(kindling.shootout(*sphere(), rays=rays, accelerators=["brute-force", "kdtree"], rounds=2, threads=2))
    assert [row["rays"] for row in rows] == ["mine", "mine"]
    assert [row["differs"] for row in rows] == [0, 0]


@pytest.mark.parametrize("settings, text", [({"rounds": 0}, "rounds: 0"), ({"accelerators": []}, "accelerators: none"),
                                            ({"accelerators": ["bvh"]}, "'bvh', expected")])
def test_errors(settings, text):
    with pytest.raises(ValueError, match=text):
        kindling.shootout(*sphere(), **settings)
