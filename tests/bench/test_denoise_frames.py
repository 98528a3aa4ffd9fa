#!/usr/bin/env python3
"""Tests of bench/denoise_frames.py: its figures on motion whose answer is known.

test_denoise_frames.py BENCH_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(sys.argv[1])))
sys.dont_write_bytecode = True
import with_numpy  # noqa: F401
import numpy as np

import denoise_frames


def moved(to_previous, from_next):
    """Channels of two frames of 20 x 10 pixels in which everything moves alike; y upwards."""
    layers = {("before", ("Vector.Z", "Vector.W")): from_next, ("image", ("Vector.X", "Vector.Y")): to_previous}
    with mock.patch.object(denoise_frames, "channels", lambda path, names: np.broadcast_to(layers[path, names], (10, 20, 2)).astype(float)):
        return denoise_frames.motion_from_before("before", "image")


class Flicker(unittest.TestCase):
    def test_errors_that_move_along_do_not_flicker(self):
        error = np.random.default_rng(2).random((10, 20, 3))
        later = np.roll(error, (-2, 3), (0, 1))  # 3 pixels to the right, 2 up
        there, known = moved((-3, -2), (-3, -2))
        self.assertEqual(known.sum(), (10 - 2) * (20 - 3))
        self.assertEqual(denoise_frames.change(error, later, there, known), 0.0)
        self.assertGreater(denoise_frames.change(error, error, there, known), 10.0)

    def test_a_change_is_of_255(self):
        there, known = moved((0, 0), (0, 0))
        self.assertTrue(known.all())
        self.assertAlmostEqual(denoise_frames.change(np.zeros((10, 20, 3)), np.full((10, 20, 3), 0.1), there, known), 25.5)

    def test_hidden_points_do_not_count(self):
        self.assertFalse(moved((0, 0), (2, 0))[1].any())

    def test_means(self):
        image = np.zeros((12, 20, 3))
        image[5, 7] = 81.0
        means = denoise_frames.means(image, 4)
        self.assertEqual({means[1, 3, 0], means[9, 11, 2]}, {1.0})
        self.assertEqual({means[0, 3, 0], means[5, 12, 0]}, {0.0})
        self.assertTrue(np.allclose(denoise_frames.means(np.full((12, 20, 3), 0.25), 4), 0.25))

    def test_table(self):
        row = {"name": "a", "spp": 4, "treatment": "noisy", "relmse": 0.5, "flip": 0.25, "flicker": 3.0, "boiling": 1.0}
        self.assertEqual(denoise_frames.table_of([row]).splitlines()[-1], "| a | 4 | noisy | 0.5000 | 0.250 | 3.00 | 1.00 |")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
