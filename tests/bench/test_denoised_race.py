#!/usr/bin/env python3
"""Tests of bench/denoised_race.py, with renderers whose images are known.

test_denoised_race.py BENCH_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import functools
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(sys.argv[1])))
sys.dont_write_bytecode = True
import with_numpy  # noqa: F401

import denoised_race
import pixels
import renderers
from peers import budget

SIZE = (24, 16)


@functools.cache
def constant(value):
    """The bytes of an EXR file."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([pixels.oiiotool(), "--pattern", f"constant:color={value},{value},{value}", f"{SIZE[0]}x{SIZE[1]}", "3",
                        "-d", "float", "-o", f"{folder}/a.exr"], check=True)
        return Path(folder, "a.exr").read_bytes()


class Budget(unittest.TestCase):
    """A renderer that takes 2 s, 0.5 s for each sample and 3 s for its filter; half as long on the other clock."""

    @staticmethod
    def render(samples, denoised):
        wall_s = 2.0 + 0.5 * samples + (3.0 if denoised else 0.0)
        return wall_s, 0.5 * wall_s

    def test_parts_of_the_time(self):
        for clock, factor in ((0, 1.0), (1, 0.5)):
            for found, wanted in zip(budget.measure(self.render, clock), (2.0, 0.5, 3.0)):
                self.assertAlmostEqual(found, factor * wanted)

    def test_samples_fill_the_time(self):
        self.assertEqual(budget.samples_within(10.0, 0.5, 3.0), 14)
        self.assertEqual(budget.samples_within(2.0, 0.5, 3.0), 1)


class Race(unittest.TestCase):
    """Converged images are .5, Kindling's denoised ones .55, those of Cycles .6."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        self.budgets, self.references = [], []
        self.job = renderers.Job("box", Path("box.glb"), SIZE, 4, threads=1)
        for name, replacement in (("denoised_race.renderers.run_kindling", self.run_kindling), ("denoised_race.peers.run", self.run_cycles),
                                  ("denoised_race.peers.run_denoised", self.run_cycles_denoised)):
            patch = mock.patch(name, replacement)
            patch.start()
            self.addCleanup(patch.stop)

    def run_kindling(self, binary, job, spp, seed, stem, flags=()):
        denoised = "--denoise" in flags
        image = Path(f"{stem}.exr")
        image.write_bytes(constant(0.55 if denoised else 0.5))
        if "reference" in image.name:
            self.references.append(image.name)
        cpu_s = 1.0 if job.size_px == (8, 8) else 6.0
        return renderers.Run(seed, image, 3.0, 0.1, 9.0, 50.0, cpu_s, denoise_s=2.0 if denoised else 0.0)

    def run_cycles(self, name, job, spp, seed, stem):
        Path(f"{stem}.exr").write_bytes(constant(0.5))
        self.references.append(Path(f"{stem}.exr").name)

    def run_cycles_denoised(self, name, job, budget_s, clock, seed, stem):
        self.budgets.append((budget_s, clock))
        Path(f"{stem}.exr").write_bytes(constant(0.6))
        return {"image": Path(f"{stem}.exr"), "spp": 7, "total_s": budget_s - 0.1, "filter_s": 1.5}

    def measure(self, clock, spp=(4,), seeds=1):
        options = argparse.Namespace(spp=spp, seeds=seeds, clock=clock, common=[], reference_spp=64, strips=self.folder / "strips")
        return denoised_race.measure_scene(self.job, options, "kindling", self.folder)

    def test_equal_time_and_errors(self):
        scene = self.measure("wall", (4, 16), 2)
        self.assertEqual(self.budgets, [(5.0, "wall")] * 4)  # path tracing and filter
        self.assertEqual([row["spp"] for row in scene["rows"]], [4, 16])
        for row in scene["rows"]:
            self.assertAlmostEqual(row["kindling"]["relmse"], 0.01 / 1.01, places=4)
            self.assertAlmostEqual(row["cycles"]["relmse"], 0.04 / 1.01, places=4)
            self.assertEqual((row["kindling"]["spp"], row["cycles"]["spp"]), (row["spp"], 7))
        self.assertTrue((self.folder / "strips" / "box.4.png").is_file())
        lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in denoised_race.table_of([scene]).splitlines()]
        self.assertEqual({len(line) for line in lines}, {11})
        self.assertEqual(lines[2][:8], ["box", "5.0", "4.9", "4", "7", "0.0099", "0.0396", "4.0"])
        self.assertEqual((lines[-1][0], lines[-1][7]), ("geometric mean", "4.0"))

    def test_processor_time_leaves_out_the_setup(self):
        self.measure("cpu")
        self.assertEqual(self.budgets, [(5.0, "cpu")])  # 6 s without the 1 s of a render of 8 x 8 pixels

    def test_references_are_rendered_once(self):
        self.measure("wall")
        self.measure("wall")
        self.assertEqual(sorted(self.references), ["box.cycles.reference.64.exr", "box.kindling.reference.64.exr"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
