#!/usr/bin/env python3
"""Tests of bench/paper: sentences of its page for known measurements, and one quick run.

test_paper.py BENCH_FOLDER [kindling]
"""
# SPDX-License-Identifier: Apache-2.0
import json
import re
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom
from pathlib import Path

BENCH = Path(sys.argv[1])
PROGRAM = sys.argv[2] if len(sys.argv) > 2 else ""
sys.path[:0] = [str(BENCH / "paper"), str(BENCH)]
import with_numpy  # noqa: F401
import cores
import figures
import page
import plots
import tracers

TIMES = {"none": {1: 4.0, 4: 8.0}, "kdtree": {1: 0.10, 2: 0.20, 4: 0.40}, "optimized": {1: 0.10, 2: 0.15, 4: 0.10}}


class Words(unittest.TestCase):
    """Sentences follow the numbers."""

    def test_verdicts(self):
        self.assertEqual(tracers.verdict((0.18, 0.20, 0.22)), "saves 20 %")
        self.assertEqual(tracers.verdict((0.02, 0.03, 0.04)), "saves 3.0 %")
        self.assertEqual(tracers.verdict((-0.06, -0.05, -0.04)), "costs 5.0 %")
        for unclear in ((-0.02, 0.004, 0.03), (0.001, 0.002, 0.003), (-0.005, 0.05, 0.06)):
            self.assertIn("brings nothing", tracers.verdict(unclear))

    def test_improvements(self):
        saved = tracers.improvements(TIMES)
        for depth, percent in ((1, 0.0), (2, 25.0), (4, 75.0)):
            self.assertAlmostEqual(saved[depth], percent)

    def test_findings(self):
        text = page.findings(TIMES)
        self.assertIn("more than 5 % from depth 2 on", text)
        self.assertIn("75 %, at depth 4", text)
        self.assertIn("a factor of 20.0", text)  # none / kdtree at 4
        self.assertIn("one of 4.00", text)
        self.assertIn("the opposite", text)
        same = {tracer: {1: 1.0, 2: 1.0} for tracer in TIMES}
        self.assertIn("at no depth", page.findings(same))

    def test_figures_are_found_or_named(self):
        self.assertEqual([f.number for f in figures.find(["7", "5"])], ["5", "7"])
        with self.assertRaisesRegex(SystemExit, "no figure 99.*1, 5, 6"):
            figures.find(["5", "99"])


class Regions(unittest.TestCase):
    def test_crops_cover_each_row_once(self):
        for count in (1, 2, 3, 7):
            parts = cores.crops((90, 68), count)
            self.assertEqual(len(parts), count)
            self.assertEqual([y for _, top, _, bottom in parts for y in range(top, bottom)], list(range(68)))
            self.assertEqual({(left, right) for left, _, right, _ in parts}, {(0, 90)})

    def test_thread_counts(self):
        self.assertEqual(cores.thread_counts(1), [1])
        self.assertEqual(cores.thread_counts(6), [1, 2, 3, 4, 6])
        self.assertEqual(cores.thread_counts(16), [1, 2, 3, 4, 8, 16])


class Page(unittest.TestCase):
    def result(self):
        saving = (0.1, 0.2, 0.3)
        render = {"name": "path <traced>", "spp": 4, "size_px": (30, 24), "one_core_s": 2.0, "all_cores_s": 1.0, "rays_per_s": 1e6, "device": {"name": "A <GPU>", "render_s": 0.05, "same": True}, "image": b"WEBP", "thumbnail": b"small",
                  "command": ["kindling", "render"], "warnings": ["warning: a & b"]}
        figure = {"number": "5", "title": "Depth", "paper": "What.", "machine": "A <machine>", "size_stated": False, "shown_px": 300,
                  "scenes": [{"caption": "", "then": "35.616 s", "renders": [render]}]}
        each = [tracers.Contribution("cache", saving, (-0.001, 0.0, 0.001))]
        contribution = {"depth": 12, "repeats": 3, "spp": 4, "plain_s": 1.0, "full_s": 0.8, "full": saving, "each": each, "rays": {"plain": 1000, "full": 800},
                        "cache": {"cache": {"hits": 30, "misses": 10, "bypasses": 60}}}
        entry = {"seconds": 1.0, "speedup": 1.9, "idle": 0.05}
        schedules = {name: {1: {**entry, "speedup": 1.0}, 2: entry} for name in ("regions", "tiles")}
        return {"about": {"machine": "A & B", "cores": 2, "version": "1", "when": "today", "clock": "wall", "note": "quick"}, "figures": [figure],
                "tracers": {"by_depth": {1: TIMES, 2: TIMES}, "contributions": [contribution]},
                "quality": {"depth": 12, "spp": 1, "seconds": {"unlimited": 2.0, "3": 1.0}, "flip_mean": 0.01, "flip_max": 0.5, "psnr_db": 40.0,
                            "changed": 0.02, "images": {"unlimited": b"A", "3": b"B"}, "difference": b"C"},
                "edges": [{"name": "one sample", "spp": 1, "seconds": 0.1, "rmse": 0.1, "crops": [b"D", b"E"], "image": b"F"}],
                "threads": {"Whitted": schedules}, "processes": {"count": 2, "whole_s": 2.0, "wall_s": 1.1, "render_s": [1.0, 0.9], "same": True}}

    def test_is_complete_in_itself(self):
        text = page.page(self.result())
        for word in ("http:", "https:", "<script", "<link"):
            self.assertNotIn(word, text)
        for expected in ("35.616 s", "path &lt;traced&gt;", "A &lt;machine&gt;", "a &amp; b", "the same to the bit",
                     "brings nothing on this machine", "saves 20 %", "states no size", "The cache answered 30 % of 100 look-ups; 60 %"):
            self.assertIn(expected, text)
        svgs = re.findall(r"<svg.*?</svg>", text, re.S)
        self.assertEqual(len(svgs), 5)  # figure 3 for one thread and for two, figure 4, speed-up, idle time
        for svg in svgs:
            xml.dom.minidom.parseString(svg)

    def test_parts_without_measurements_are_left_out(self):
        text = page.page({"about": self.result()["about"], "figures": self.result()["figures"]})
        self.assertNotIn("<svg", text)
        self.assertIn("figure-5", text)

    def test_devices_have_a_column_each(self):
        figures_on_gpu = self.result()["figures"]
        self.assertIn("<th>A &lt;GPU&gt;, s</th>", page.times_table(figures_on_gpu))
        self.assertIn("<td>0.050</td></tr>", page.times_table(figures_on_gpu))
        figures_on_gpu[0]["scenes"][0]["renders"][0]["device"]["same"] = False
        self.assertIn("<td>0.050 (another image)</td>", page.times_table(figures_on_gpu))
        figures_on_gpu[0]["scenes"][0]["renders"][0]["device"] = None
        self.assertNotIn("GPU", page.times_table(figures_on_gpu))

    def test_plot_of_whole_numbers(self):
        svg = plots.plot("t", "trace depth", "percent", [("a", "#000", False, [(1, -10.0), (12, 50.0)])], False, False)
        circles = [(float(c.getAttribute("cx")), float(c.getAttribute("cy")))
                   for c in xml.dom.minidom.parseString(svg).getElementsByTagName("circle")]
        self.assertAlmostEqual(circles[0][0], 64.0)  # the plot's left edge and its right one
        self.assertAlmostEqual(circles[1][0], 524.0)
        self.assertAlmostEqual(circles[0][1] - circles[1][1], 250.0, delta=0.2)  # -10 is the lowest tick, 50 the highest


@unittest.skipUnless(PROGRAM, "kindling is not built")
class Program(unittest.TestCase):
    def run_script(self, *arguments):
        return subprocess.run([sys.executable, str(BENCH / "paper" / "run.py"), "--kindling", PROGRAM, *map(str, arguments)],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)

    def test_quick_run_of_one_figure(self):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "page.html"
            done = self.run_script("--quick", "--figures", "7", "--scale", "0.1", "--device", "host", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("figure 7", done.stderr)
            text, data = out.read_text(), json.loads(out.with_suffix(".json").read_text())
        self.assertEqual([f["number"] for f in data["figures"]], ["7"])
        for render in data["figures"][0]["scenes"][0]["renders"]:
            self.assertEqual(render["size_px"], [30, 25])
            self.assertGreater(render["all_cores_s"], 0.0)
            self.assertEqual((render["device"]["name"], render["device"]["same"]), ("host", True))
        self.assertIn("data:image/webp;base64,", text)

    def test_no_figure_begins_after_the_time(self):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "page.html"
            done = self.run_script("--quick", "--figures", "9,16", "--seconds", "0", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("figures 9 to 16: left out, 0 seconds are over", done.stderr)
            self.assertEqual(json.loads(out.with_suffix(".json").read_text())["figures"], [])

    def test_errors_list_accepted_values(self):
        for arguments, message in ((["--figures", "99"], "there are 1, 5"), (["--parts", "all"], "there are figures"),
                                   (["--scale", "0"], "a number above 0")):
            done = self.run_script(*arguments)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(message, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
