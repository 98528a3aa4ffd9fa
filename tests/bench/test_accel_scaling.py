#!/usr/bin/env python3
"""Tests of bench/accel_scaling.py on tables with known answers, and of bench_scaling's columns.

test_accel_scaling.py BENCH_FOLDER [bench_scaling]
"""
# SPDX-License-Identifier: Apache-2.0
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom
from pathlib import Path

sys.path.insert(0, sys.argv[1])
import accel_scaling

PROGRAM = sys.argv[2] if len(sys.argv) > 2 else ""


def table(shape="hall", sizes=(1000, 10000, 100000, 1000000)):
    """Builds take 5 ns N log2 N (kdtree) or 1e-9 N^2 s (embree high); a doubling costs a tenth of the camera rays' speed."""
    rows = []
    for n in sizes:
        for accelerator, build_s in (("kdtree", 5e-9 * n * math.log2(n)), ("embree high", 1e-9 * n * n)):
            rows.append({"shape": shape, "triangles": float(n), "accelerator": accelerator, "build_1_thread_s": build_s,
                         "build_threads": 2.0, "build_all_s": build_s / 2, "memory_bytes": 64.0 * n,
                         "camera_single_mrays_s": 10 * 0.9 ** math.log2(n)})
    return rows


class Fits(unittest.TestCase):
    def test_known_laws_are_found(self):
        tree, other = accel_scaling.fit_all(table())
        for value in tree["quotients_ns"]:
            self.assertAlmostEqual(value, 5.0)
        self.assertAlmostEqual(tree["exponent"], tree["n_log_n_exponent"])
        self.assertAlmostEqual(other["exponent"], 2.0)
        self.assertAlmostEqual(tree["loss_percent"]["camera_single_mrays_s"], 10.0)
        self.assertNotIn("bounce1_batch_mrays_s", tree["loss_percent"])
        text = accel_scaling.format_fits([tree, other])
        self.assertIn("5.00", text)
        self.assertIn("2.000", text)

    def test_small_sizes_do_not_rule_the_exponent(self):
        rows = table()
        rows[0]["build_1_thread_s"] = 1.0  # of 1000 triangles
        self.assertAlmostEqual(accel_scaling.fit_all(rows)[0]["exponent"], accel_scaling.fit_all(table())[0]["exponent"])

    def test_a_scene_has_no_fit(self):
        self.assertEqual(accel_scaling.fit_all(table("room.glb", sizes=(5000,))), [])


class Files(unittest.TestCase):
    def test_table_is_read_back(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.csv"
            accel_scaling.write_csv(path, table())
            self.assertEqual(accel_scaling.parse(path.read_text()), table())

    def test_page_is_complete_in_itself(self):
        rows = table() + table("a <b>.glb", sizes=(5000,))
        page = accel_scaling.page(rows, accel_scaling.fit_all(rows))
        plots = re.findall(r"<svg.*?</svg>", page, re.S)
        self.assertEqual(len(plots), 4)  # build, quotient, memory, and one kind of rays
        for plot in plots:
            self.assertEqual(xml.dom.minidom.parseString(plot).getElementsByTagName("circle").length, 10)
        self.assertIn("a &lt;b&gt;.glb", page)
        for word in ("http:", "https:", "<script", "<link"):
            self.assertFalse(word in page, word)
        self.assertIsNone(re.search(r"\bnan\b", page))

    def test_shootouts_become_points(self):
        report = {"build_threads": 2, "scenes": [{"file": "x/room.glb", "triangles": 7, "accelerators": [
            {"name": name, "memory_bytes": 9,
             "build": {"one_thread": {"median_s": 1.5}, "many_threads": {"median_s": 1.0}},
             "traversal": [{"rays": "bounce1", "call": "batch", "mega_rays_per_s": 3.5},
                           {"rays": "shadow1", "call": "batch", "mega_rays_per_s": 4.5}]}
            for name in ("embree:non-robust", "kdtree:best")]}]}
        self.assertEqual(accel_scaling.rows_of_shootout(report),
                         [{"shape": "room.glb", "triangles": 7, "accelerator": "embree medium", "build_threads": 2,
                           "build_1_thread_s": 1.5, "build_all_s": 1.0, "memory_bytes": 9, "bounce1_batch_mrays_s": 3.5}])


@unittest.skipUnless(os.path.exists(PROGRAM), "bench_scaling is not built")
class Program(unittest.TestCase):
    def test_columns(self):
        for shape in ("hall", "sphere", "soup"):
            rows = accel_scaling.parse(subprocess.run([PROGRAM, shape, "500", "1"], check=True, stdout=subprocess.PIPE,
                                                      text=True).stdout)
            self.assertEqual([row["accelerator"] for row in rows], list(dict.fromkeys(accel_scaling.SHOOTOUT.values())))
            for row in rows:
                self.assertEqual(row["shape"], shape)
                for column in ("triangles", "build_1_thread_s", "build_all_s", "memory_bytes", "camera_single_mrays_s",
                               "camera_coherent_mrays_s", "bounce1_batch_mrays_s", "ambient_batch_mrays_s"):
                    self.assertGreater(row[column], 0, column)

    def test_wrong_usage(self):
        for arguments in ([], ["cube", "100"], ["hall", "0"], ["hall", "1e3"], ["hall", "100", "0"]):
            self.assertEqual(subprocess.run([PROGRAM, *arguments], stderr=subprocess.DEVNULL).returncode, 2, arguments)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
