#!/usr/bin/env python3
"""Tests of bench/thread_scaling.py on a known report, and a whole run on a tiny scene.

test_thread_scaling.py BENCH_FOLDER SCENES_FOLDER [kindling]
"""
# SPDX-License-Identifier: Apache-2.0
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom
from pathlib import Path

BENCH, SCENES = Path(sys.argv[1]), Path(sys.argv[2])
PROGRAM = sys.argv[3] if len(sys.argv) > 3 else ""
sys.path.insert(0, str(BENCH))
import thread_scaling


def report(efficiency, peak):
    rows = [{"schedule": "tiles", "threads": n, "efficiency": 1.0 if n == 1 else efficiency, "idle_share": 0.05, "peak_rss_bytes": peak}
            for n in (1, 2, 4)]
    return {"thread_counts": [1, 2, 4], "cores": 2,
            "scenes": [{"spp": 8, "accelerators": [{"name": "kdtree", "amdahl": {"tiles": None}, "render": rows}],
                        "preparation": [{"phase": "all with kdtree", "threads": [{"threads": 2, "speedup": 1.5}]}]}]}


class Table(unittest.TestCase):
    def test_figures_of_as_many_threads_as_cores(self):
        text = thread_scaling.table_of({"a": report(0.9, 2 ** 21), "b": report(0.4, None)})
        lines = text.splitlines()
        self.assertIn("efficiency at 2: kdtree, tiles", lines[0])
        self.assertEqual(lines[2], "| a | 8 | 0.900 | 5.0 % | 1.50 | 2 |")
        self.assertTrue(lines[3].endswith("| unknown |"))
        self.assertIn("| geometric mean |  | 0.600 |", lines[4])
        self.assertEqual({line.count("|") for line in lines}, {lines[0].count("|")})


@unittest.skipUnless(PROGRAM, "no program to run")
class WholeRun(unittest.TestCase):
    def test_writes_all_reports(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = SCENES / "cornell_box.glb"
            run = subprocess.run([BENCH / "thread_scaling.py", scene, folder, "--kindling", PROGRAM, "--", "--spp", "1", "--size", "16x16",
                                  "--repeat", "1", "--threads", "1,2", "-q"], capture_output=True, text=True, check=False)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn("geometric mean", run.stdout)
            for name in ("cornell_box.json", "cornell_box.csv", "scaling.md"):
                self.assertTrue((Path(folder) / name).stat().st_size > 0, name)
            xml.dom.minidom.parse(str(Path(folder) / "cornell_box.svg"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
