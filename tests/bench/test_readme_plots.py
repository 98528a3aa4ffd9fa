#!/usr/bin/env python3
"""Tests of bench/readme_plots.py: its means, its reading of tables, and SVG that can be parsed.

test_readme_plots.py BENCH_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import json
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom
from pathlib import Path

BENCH = Path(sys.argv[1])
sys.path.insert(0, str(BENCH))
import readme_plots

KINDS = list(readme_plots.KINDS)
TABLE = """text
| file | what |
|---|---|
| `a` | b |

| scene | samples per pixel | efficiency, kd-tree | idle | efficiency, Embree | idle |
|---|---|---|---|---|---|
| room, small | 4 | 0.90 | 1 % | 0.80 | 2 % |
| | 8 | 0.95 | 1 % | 0.85 | 2 % |
| car | 4 | 1.00 | 0 % | 0.99 | 0 % |

| scene | efficiency, other |
|---|---|
| a | 0.1 |
"""


def accelerator(name, speed, build_s, memory):
    rows = [{"rays": kind, "call": call, "mega_rays_per_s": speed * factor} for kind in KINDS for call, factor in (("single", 1.0), ("batch", 2.0))]
    return {"name": name, "traversal": rows, "build": {"one_thread": {"median_s": build_s}}, "memory_bytes": memory}


def report():
    scenes = [{"accelerators": [accelerator("embree", 2.0 * f, 1.0, 100), accelerator("embree:non-robust", 3.0 * f, 1.0, 100),
                                accelerator("embree:best:non-robust", 2.5 * f, 4.0, 100), accelerator("kdtree", 4.0 * f, 3.0, 75)]} for f in (1.0, 4.0)]
    return {"processor": "A & B", "repeat": 5, "scenes": scenes}


class ReadmePlots(unittest.TestCase):
    def test_race_is_a_geometric_mean_of_fastest_calls(self):
        speeds, costs = readme_plots.race(report())
        self.assertAlmostEqual(speeds["camera"][readme_plots.EMBREE], 8.0)  # twice 2 and 8
        self.assertAlmostEqual(speeds["camera"][readme_plots.FASTEST], 12.0)
        self.assertAlmostEqual(speeds["shadow"][readme_plots.KDTREE], 16.0)
        self.assertAlmostEqual(costs["build time"][readme_plots.KDTREE], 3.0)
        self.assertAlmostEqual(costs["memory"][readme_plots.KDTREE], 0.75)

    def test_last_row_of_a_scene_counts(self):
        self.assertEqual(readme_plots.efficiencies(TABLE), {"room, small": {"kd-tree": 0.95, "Embree": 0.85}, "car": {"kd-tree": 1.0, "Embree": 0.99}})

    def test_reads_the_shipped_table(self):
        found = readme_plots.efficiencies((BENCH / "README.md").read_text(encoding="utf-8"))
        self.assertGreaterEqual(len(found), 5)
        for group in found.values():
            self.assertEqual(list(group), ["kd-tree", "Embree"])

    def test_writes_svg(self):
        with tempfile.TemporaryDirectory() as folder:
            race, table, out = Path(folder) / "race.json", Path(folder) / "table.md", Path(folder) / "out.svg"
            race.write_text(json.dumps(report()), encoding="utf-8")
            table.write_text(TABLE, encoding="utf-8")
            for plot, source, bars in (("shootout", race, 3 * len(KINDS) + 4), ("scaling", table, 4)):
                subprocess.run([sys.executable, BENCH / "readme_plots.py", plot, source, "-o", out], check=True)
                svg = xml.dom.minidom.parse(str(out))
                keys = 3 if plot == "shootout" else 2
                self.assertEqual(len(svg.getElementsByTagName("rect")), bars + keys + 1)

    def test_refuses_text_without_a_table(self):
        with self.assertRaisesRegex(SystemExit, "no table"):
            readme_plots.scaling_image("nothing", "")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
