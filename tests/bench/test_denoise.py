#!/usr/bin/env python3
"""Tests of bench/denoise.py: its figures on images whose answer is known.

test_denoise.py BENCH_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import contextlib
import io
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[1])))
sys.dont_write_bytecode = True
import with_numpy  # noqa: F401
import numpy as np

import array

import denoise
import pixels


class Figures(unittest.TestCase):
    def test_rel_mse_is_that_of_pixels(self):
        random = np.random.default_rng(3)
        reference, image = random.random((20, 60, 3)).astype(np.float32), random.random((20, 60, 3)).astype(np.float32)
        as_image = lambda a: pixels.Image(60, 20, array.array("f", a.ravel()))
        wanted = pixels.rel_mse(pixels.error([as_image(image)], as_image(reference)))
        self.assertAlmostEqual(denoise.rel_mse(image.astype(float), reference.astype(float)), wanted, places=6)
        self.assertEqual(denoise.rel_mse(reference, reference), 0.0)

    def test_srgb_clamps(self):
        self.assertTrue(np.allclose(denoise.srgb(np.array([-1.0, 0.0, 0.0031308, 0.214, 1.0, 50.0])),
                                    [0, 0, 0.04045, 0.5, 1, 1], atol=1e-3))

    def test_seconds(self):
        report = "kindling: warning: something\ndenoised 8x8 with albedo and normal by Open Image Denoise 2.5.1, best in "
        self.assertEqual(denoise.seconds_of(report + "1.23 s\n"), 1.23)
        self.assertAlmostEqual(denoise.seconds_of(report + "45 ms\n"), 0.045)

    def test_table_has_a_line_for_each_count(self):
        rows = [{"spp": 4, "setting": "kindling", "treatment": t, "relmse": 0.5, "flip": 0.25, "render_s": 1.0, "filter_s": 0.5}
                for t in ("noisy", "fast", "best")]
        table = denoise.table_of([{"name": "a", "size_px": [8, 8], "rows": rows + [dict(r, spp=16) for r in rows]}])
        lines = table.splitlines()
        self.assertEqual(len(lines), 4)
        self.assertEqual({line.count("|") for line in lines}, {12})
        self.assertTrue(lines[2].startswith("| a | 4 | 0.5000 |"))
        self.assertNotIn("flicker", table)
        self.assertNotIn("setting", table)

    def test_table_names_settings_if_there_are_several(self):
        rows = [{"spp": 4, "setting": s, "treatment": t, "relmse": 0.5, "flip": 0.25, "render_s": 1.0, "filter_s": 0.5, "flicker": 2.0}
                for s in ("alone", "shared") for t in ("noisy", "fast", "best")]
        lines = denoise.table_of([{"name": "a", "size_px": [8, 8], "rows": rows}]).splitlines()
        self.assertEqual(len(lines), 4)
        self.assertEqual({line.count("|") for line in lines}, {16})
        self.assertTrue(lines[3].startswith("| a | 4 | shared | 0.5000 |"))

    def test_means_of_seeds(self):
        rows = [{"spp": 4, "setting": "a", "treatment": "best", "relmse": r, "flip": 2 * r, "render_s": s, "filter_s": s} for r, s in ((1, 5), (3, 6), (5, 100))]
        self.assertEqual(denoise.means(rows), {"spp": 4, "setting": "a", "treatment": "best", "relmse": 3, "flip": 6, "render_s": 6, "filter_s": 6})

    def test_arguments(self):
        self.assertEqual(denoise.parse_arguments(["a.glb"]).spp, [4, 16, 64])
        self.assertEqual(denoise.parse_arguments(["a.glb", "--setting", "x=--guiding off"]).setting[0].flags, ["--guiding", "off"])
        for wrong in (["a.glb", "--spp", "0"], ["a.glb", "--flicker", "1"], ["a.glb", "--seeds", "0"], [],
                      ["a.glb", "--setting", "x=", "--setting", "x=--guiding off"]):
            with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()):
                denoise.parse_arguments(wrong)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
