#!/usr/bin/env python3
"""Tests of bench/gpu: a round on the host device, a program whose bits differ, and what is packed.

test_gpu_round.py BENCH_FOLDER KINDLING
"""
# SPDX-License-Identifier: Apache-2.0
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BENCH, PROGRAM = Path(sys.argv[1]), Path(sys.argv[2])
ROUND = BENCH / "gpu" / "round.py"
SCENES = BENCH.parent / "scenes"

sys.path.insert(0, str(ROUND.parent))
sys.dont_write_bytecode = True
round_script = __import__("round")


def run_round(folder, *flags, program=PROGRAM):
    result = subprocess.run([sys.executable, "-B", ROUND, "--out", folder, "--device", "host", "--program", program, *flags],
                            check=False, capture_output=True, text=True)
    return result, json.loads((folder / "round.json").read_text(encoding="utf-8"))


class HostDevice(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_bits_are_those_of_the_cpu(self):
        result, found = run_round(self.folder, "--parts", "bits", "--seconds", "3")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertGreater(found["bits"]["compared"], 0)
        self.assertEqual(found["bits"]["different"], [])

    def test_split_frames_have_the_bits_of_the_whole(self):
        result, found = run_round(self.folder, "--parts", "machine,start,split")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(list(found["split"].values()), [True] * 3)
        self.assertEqual(set(found["start"]), {"kernels compiled", "kernels from the cache", "again", "CPU"})
        self.assertIn("## split", (self.folder / "round.md").read_text(encoding="utf-8"))

    def test_races_and_shared_frames_are_measured(self):
        round_folder = self.folder / "round"  # as round.sh packs it: the scripts beside the scenes
        for name in ("bench/gpu/round.py", "bench/renderers.py", "tests/device/same_images.py"):
            (round_folder / name).parent.mkdir(parents=True, exist_ok=True)
            (round_folder / name).write_bytes((BENCH.parent / name).read_bytes())
        measured = round_folder / "measured"
        measured.mkdir()
        (measured / "box.glb").write_bytes((SCENES / "cornell_box.glb").read_bytes())
        (measured / "scenes.json").write_text(json.dumps({"box": {"file": "box.glb", "max_bounces": 2}}))
        out = self.folder / "out"
        result = subprocess.run([sys.executable, "-B", round_folder / "bench/gpu/round.py", "--out", out, "--device", "host", "--program", PROGRAM,
                                 "--parts", "shootout,scaling", "--rays", "500", "--spp", "8", "--seconds", "60"],
                                check=False, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        found = json.loads((out / "round.json").read_text(encoding="utf-8"))
        race, shared = found["shootout"]["box"], found["scaling"]["box"]
        self.assertEqual((race["answers"], race["different"], shared["different images"]), (3500, 0, 0))
        for name in ("kdtree on host, bounce1", "embree, shadow1", "kdtree on host to kdtree"):
            self.assertGreater(race[name], 0, name)
        for name in ("1 thread", "device", "both, start included"):
            self.assertGreater(shared[name], 0, name)
        page = (out / "round.md").read_text(encoding="utf-8")
        self.assertIn("| scene | kdtree on host, camera |", page)
        self.assertIn("| box | ", page)

    def test_other_bits_are_found(self):
        other = self.folder / "other"
        other.write_text(f'#!/bin/sh\ncase "$*" in *"--device host"*) exec {PROGRAM} "$@" --max-bounces 1;; esac\nexec {PROGRAM} "$@"\n')
        other.chmod(0o755)
        result, found = run_round(self.folder / "out", "--parts", "bits", "--seconds", "3", program=other)
        self.assertEqual(result.returncode, 1)
        self.assertIn("cornell_box.glb 64x48", " ".join(found["bits"]["different"]))

    def test_a_device_that_fails_ends_its_part_alone(self):
        broken = self.folder / "broken"
        broken.write_text(f'#!/bin/sh\ncase "$*" in *"--device host"*) echo "no GPU" >&2; exit 1;; esac\nexec {PROGRAM} "$@"\n')
        broken.chmod(0o755)
        result, found = run_round(self.folder / "out", "--parts", "start,machine", program=broken)
        self.assertEqual(result.returncode, 1)
        self.assertIn("no GPU", found["start"]["failed"])
        self.assertIn("kindling", found["machine"]["program"])

    def test_scenes_are_collected_with_their_environments(self):
        source, to = self.folder / "source", self.folder / "to"
        source.mkdir()
        to.mkdir()
        (source / "a.glb").write_bytes((SCENES / "cornell_box.glb").read_bytes())
        (source / "sky.hdr").write_bytes(b"any")
        (source / "scenes.json").write_text(json.dumps({"a": {"file": "a.glb", "hdr": "sky.hdr", "max_bounces": 4, "ref": {"file": "x.exr"}}}))
        round_script.collect(source, to)
        self.assertEqual(json.loads((to / "scenes.json").read_text()), {"a": {"file": "a.glb", "hdr": "sky.hdr", "max_bounces": 4}})
        self.assertTrue((to / "a.glb").is_file() and (to / "sky.hdr").is_file())


class Page(unittest.TestCase):
    def test_scenes_have_rows_and_failures_are_named(self):
        page = round_script.markdown({"shootout": {"a": {"gpu": 1.5, "different": 0}, "b": {"gpu": 2.0}, "failed": "lost"}}, "gpu")
        self.assertIn("- failed: lost\n| scene | gpu | different |\n|---|---|---|\n| a | 1.50 | 0 |\n| b | 2.00 | - |", page)
        self.assertIn("- failed: lost", round_script.markdown({"speed": {"failed": "lost"}}, "gpu"))

    def test_speeds_have_their_ratios(self):
        page = round_script.markdown({"speed": {"dragon": {"gpu": 260.0, "CPU, two threads": 3.25}}}, "gpu")
        self.assertIn("| dragon | 260.00 | 3.25 | 80.0 |", page)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
