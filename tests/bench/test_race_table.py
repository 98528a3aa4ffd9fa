#!/usr/bin/env python3
"""Tests of bench/race_table.py: its ratios, means, empty cells and errors.

test_race_table.py BENCH_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BENCH = Path(sys.argv[1])
sys.path.insert(0, str(BENCH))
import race_table


def accelerator(name, seconds, differ=0):
    rows = [{"disagreements": {"hit_or_miss": differ, "distance": 0, "at_edge": 5}}]
    return {"name": name, "traversal": rows, "build": {"many_threads": {"median_s": seconds}}}


def scene(file, factor, fast=True, differ=0):
    """A scene whose ratios are `factor` to robust Embree and half of it to any."""
    measures = [*race_table.SPEEDS.values(), *race_table.SIZES.values()]
    lines = [{"ratio": measure, "to_robust_embree": factor, "to_any_embree": factor / 2} for measure in measures]
    accelerators = [accelerator("embree", 2.0), accelerator("embree:non-robust", 1.0), accelerator("kdtree", 9.0, differ)]
    if fast:
        accelerators.append(accelerator("kdtree:fast", 1.5))
    return {"file": file, "accelerators": accelerators, "against_embree": [{"name": "kdtree:fast", "lines": []}, {"name": "kdtree", "lines": lines}]}


def table_of(*scenes, flags=()):
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "race.json"
        report.write_text(json.dumps({"scenes": scenes}))
        return subprocess.run([sys.executable, str(BENCH / "race_table.py"), str(report), *flags], capture_output=True, text=True, check=False)


class RaceTable(unittest.TestCase):
    def test_speeds_have_two_ratios_and_builds_one(self):
        row = race_table.ratios(scene("a.glb", 3.0))
        self.assertEqual(row["bounces"], (3.0, 1.5))
        self.assertEqual(row["memory / medium"], (1.5,))
        self.assertEqual(row[race_table.FAST], (1.5,))  # 1.5 s over the faster of 2 s and 1 s

    def test_reports_of_one_instruction_set_have_the_same_table(self):
        limited = scene("a.glb", 3.0)
        for each in limited["accelerators"] + limited["against_embree"]:
            each["name"] += ":avx2"
        self.assertEqual(race_table.ratios(limited), race_table.ratios(scene("a.glb", 3.0)))

    def test_means_are_geometric_and_of_the_chosen_scenes(self):
        result = table_of(scene("x/a.glb", 1.0), scene("b.glb", 4.0), scene("c.glb", 50.0), flags=["--mean", "a,b"])
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = result.stdout.splitlines()
        self.assertTrue(lines[4].startswith("| **geometric mean** | **2.00 \\| 1.00** |"), lines[4])
        self.assertTrue(lines[5].startswith("| c | 50.00 \\| 25.00 |"), lines[5])

    def test_cells_without_a_figure_are_empty(self):
        result = table_of(scene("a.glb", 1.0, fast=False), scene("b.glb", 1.0))
        self.assertTrue(result.stdout.splitlines()[2].endswith("|  |"), result.stdout)
        self.assertTrue(result.stdout.splitlines()[4].endswith("|  |"), result.stdout)

    def test_counts_disagreements_but_not_those_at_edges(self):
        self.assertIn("\n0 disagreements", table_of(scene("a.glb", 1.0)).stdout)
        self.assertIn("\n3 disagreements", table_of(scene("a.glb", 1.0, differ=3)).stdout)

    def test_an_unknown_scene_is_an_error(self):
        result = table_of(scene("a.glb", 1.0), flags=["--mean", "b"])
        self.assertEqual(result.returncode, 1)
        self.assertIn("no scene 'b' in the reports; they have a", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
