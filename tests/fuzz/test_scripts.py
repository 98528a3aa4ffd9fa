#!/usr/bin/env python3
"""Tests of the fuzzing scripts: seeds are valid, and run.py counts executions and findings."""
# SPDX-License-Identifier: Apache-2.0
import contextlib
import io
import json
import struct
import sys
import tempfile
import unittest
import zlib
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parent))
import make_seeds
import run

LOG = """INFO: Loaded 1 modules   (100 inline 8-bit counters): 100 [0x1, 0x2),
INFO: Loaded 1 PC tables (4000 PCs): 4000 [0x1,0x2),
#2	INITED cov: 900 ft: 901 corp: 1/1b exec/s: 0 rss: 40Mb
#2048	pulse  cov: 1000 ft: 3000 corp: 30/1b lim: 4 exec/s: 682 rss: 45Mb
stat::number_of_executed_units: 2500
"""
CRASH = """#2048	pulse  cov: 1000 ft: 3000 corp: 30/1b lim: 4 exec/s: 682 rss: 45Mb
==1==ERROR: AddressSanitizer: heap-buffer-overflow on address 0x1
SUMMARY: AddressSanitizer: heap-buffer-overflow a.cpp:7:3 in f()
stat::number_of_executed_units: 2222
"""

# A harness that finds something in its first run, as libFuzzer reports it, and nothing later.
HARNESS = """#!/bin/sh
for word; do case $word in -artifact_prefix=*) prefix=${word#*=};; esac; done
[ -d "$1" ] || exit 9
if [ -e "$1/new" ]; then echo "stat::number_of_executed_units: 5" >&2; exit 0; fi
touch "$1/new" "${prefix}crash-1"
echo "SUMMARY: AddressSanitizer: SEGV a.cpp:1 in f()" >&2
echo "stat::number_of_executed_units: 7" >&2
exit 1
"""

# The same with an input that takes too long; SECOND_RUN is what it does with that input alone.
SLOW_HARNESS = """#!/bin/sh
for word; do case $word in -artifact_prefix=*) prefix=${word#*=};; esac; done
if [ -f "$1" ]; then SECOND_RUN; fi
if [ -e "$1/new" ]; then echo "stat::number_of_executed_units: 5" >&2; exit 0; fi
touch "$1/new" "${prefix}timeout-1"
echo "SUMMARY: libFuzzer: timeout" >&2
echo "stat::number_of_executed_units: 7" >&2
exit 70
"""


class Logs(unittest.TestCase):
    def test_counts_executions_and_edges(self):
        outcome = run.Outcome("png")
        self.assertEqual(run.read_log(outcome, LOG), "")
        self.assertEqual((outcome.executions, outcome.covered, outcome.edges), (2500, 1000, 4000))
        outcome.seconds, outcome.processor_seconds = 5.0, 2.0
        self.assertEqual(outcome.row(), "| png | 5 | 2 | 2500 | 500 | 1000 of 4000 (25 %) | 0 | 0 |")

    def test_adds_runs_and_finds_the_summary(self):
        outcome = run.Outcome("png")
        run.read_log(outcome, LOG)
        self.assertEqual(run.read_log(outcome, CRASH), "SUMMARY: AddressSanitizer: heap-buffer-overflow a.cpp:7:3 in f()")
        self.assertEqual(outcome.executions, 2500 + 2222)

    def test_killed_harness_counts_up_to_its_last_line(self):
        outcome = run.Outcome("png")
        run.read_log(outcome, CRASH.split("==1==")[0])
        self.assertEqual(outcome.executions, 2048)


class Runs(unittest.TestCase):
    def test_continues_after_a_finding_and_fails(self):
        with tempfile.TemporaryDirectory() as name:
            build = Path(name)
            (build / "tests/fuzz").mkdir(parents=True)
            harness = build / "tests/fuzz/fuzz_ies"
            harness.write_text(HARNESS)
            harness.chmod(0o755)
            out = io.StringIO()
            with mock.patch.object(sys, "argv", ["run.py", name, "--seconds", "5"]), contextlib.redirect_stdout(out):
                self.assertEqual(run.main(), 1)
            self.assertRegex(out.getvalue(), r"\| ies \| \d+ \| \d+ \| 12 \| .* \| 1 \| 1 \|")
            self.assertIn("FINDING ies: SUMMARY: AddressSanitizer: SEGV", out.getvalue())
            self.assertTrue((build / "findings/ies-0-crash-1").exists())
            self.assertTrue((build / "findings/ies-0-log.txt").exists())

    def run_slow(self, second_run):
        """Runs a harness that reports a timeout at first, and ends `second_run` with that input. Returns its Outcome and files of findings."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            harness = folder / "fuzz_ies"
            harness.write_text(SLOW_HARNESS.replace("SECOND_RUN", second_run))
            harness.chmod(0o755)
            (folder / "findings").mkdir()
            outcome = run.run_harness(harness, "ies", folder / "corpus", folder / "none", folder / "findings", 5, folder)
            return outcome, [file.name for file in sorted((folder / "findings").iterdir())]

    def test_input_that_waited_for_a_processor_is_no_finding(self):
        outcome, files = self.run_slow("exit 0")
        self.assertEqual((outcome.findings, outcome.executions, files), ([], 12, []))

    def test_input_that_is_slow_again_is_a_finding(self):
        with mock.patch.object(run, "INPUT_SECONDS", 0.3):
            outcome, files = self.run_slow(f"exec {sys.executable} -c 'import time\nwhile time.process_time() < 0.5: pass'")
        self.assertEqual((len(outcome.findings), outcome.executions, files), (1, 12, ["ies-0-log.txt", "ies-0-timeout-1"]))

    def test_input_that_fails_when_it_runs_again_is_a_finding(self):
        self.assertEqual(len(self.run_slow("exit 70")[0].findings), 1)

    def test_harness_that_cannot_run_is_no_finding(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            harness = folder / "fuzz_ies"
            harness.write_text("#!/bin/sh\necho cannot start >&2\nexit 127\n")
            harness.chmod(0o755)
            outcome = run.run_harness(harness, "ies", folder / "corpus", folder / "none", folder, 5, folder)
            self.assertEqual((outcome.error, outcome.findings), ("cannot start", []))


    def test_processor_time_is_counted_and_a_process_that_does_not_end_is_killed(self):
        with tempfile.TemporaryDirectory() as folder:
            busy = "import time\nwhile time.process_time() < 0.3: pass\nraise SystemExit(7)"
            code, log, seconds = run.run_process([sys.executable, "-c", busy], None, 60, folder)
            self.assertEqual((code, log), (7, ""))
            self.assertGreaterEqual(seconds, 0.3)
            code, log, seconds = run.run_process(["sh", "-c", "echo begun >&2; exec sleep 60"], None, 1, folder)
            self.assertEqual((code, log), (None, "begun\n"))
            self.assertLess(seconds, 0.5)


class Seeds(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.seeds = make_seeds.Seeds(Path(self.folder.name), [])

    def tearDown(self):
        self.folder.cleanup()

    def made(self, kind):
        return [file.read_bytes() for file in sorted(Path(self.folder.name, kind).iterdir())]

    def test_png_chunks_have_their_checksums(self):
        make_seeds.pngs(self.seeds)
        for content in self.made("png"):
            self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n")
            at = 8
            while at < len(content):
                size, = struct.unpack_from(">I", content, at)
                body = content[at + 4:at + 8 + size]
                self.assertEqual(struct.unpack_from(">I", content, at + 8 + size)[0], zlib.crc32(body))
                at += 12 + size
            self.assertEqual(body, b"IEND")

    def test_scenes_are_json_and_containers_of_their_length(self):
        document = make_seeds.scene_of_extensions()
        self.assertEqual(json.loads(json.dumps(document)), document)
        self.assertIn("KHR_animation_pointer", document["extensionsUsed"])
        content = make_seeds.glb_of(document, b"12345")
        self.assertEqual(struct.unpack_from("<I", content, 8)[0], len(content))
        make_seeds.scenes(self.seeds)
        self.assertGreater(len(self.made("gltf")), 30)

    def test_ktx2_compressed_by_zlib_has_its_level(self):
        make_seeds.ktx2(self.seeds)
        levels = []
        for content in self.made("ktx2"):
            if struct.unpack_from("<I", content, 44)[0] == 3:
                offset, length, inflated = struct.unpack_from("<QQQ", content, 80)
                levels.append(len(zlib.decompress(content[offset:offset + length])) == inflated)
        self.assertEqual(set(levels), {True})

    def test_only_wanted_kinds_are_written(self):
        seeds = make_seeds.Seeds(Path(self.folder.name), ["ies"])
        for make in (make_seeds.ies, make_seeds.flags, make_seeds.records, make_seeds.oiio_images):
            make(seeds)
        self.assertEqual([path.name for path in Path(self.folder.name).iterdir()], ["ies"])

    def test_dictionaries_are_those_of_harnesses_and_quoted(self):
        for file in (make_seeds.ROOT / "tests/fuzz/dictionaries").iterdir():
            self.assertTrue((make_seeds.ROOT / f"tests/fuzz/fuzz_{file.stem}.cpp").exists(), file)
            for line in file.read_text(encoding="utf-8").splitlines():
                self.assertRegex(line, r'^(#.*|"([^"\\]|\\\\|\\"|\\x[0-9a-f]{2})+")$', file)


if __name__ == "__main__":
    unittest.main()
