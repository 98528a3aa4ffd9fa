#!/usr/bin/env python3
"""Tests of bench/gpu: a round on the host device, a program whose bits differ, the packed scenes.

Small programs stand in for NVIDIA's tools and for Mitsuba.

test_gpu_round.py BENCH_FOLDER KINDLING
"""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

BENCH, PROGRAM = Path(sys.argv[1]), Path(sys.argv[2])
ROUND = BENCH / "gpu" / "round.py"
SCENES = BENCH.parent / "scenes"

sys.path.insert(0, str(ROUND.parent))
sys.dont_write_bytecode = True
round_script = __import__("round")
import kernels  # noqa: E402
import one_round  # noqa: E402
import round_page  # noqa: E402
import sanitizer  # noqa: E402

PACKED = ("bench/gpu/*.py", "bench/paper/*.py", "bench/peers/*.py", "bench/*.py", "tests/device/same_images.py")

# It runs the program behind its flags; counters of three launches follow, as ncu prints them.
NCU = """#!/usr/bin/env python3
import csv, subprocess, sys
words = sys.argv[1:]
metrics = words[words.index("--metrics") + 1].split(",")
assert words[:5] == ["--csv", "--page", "raw", "--print-units", "base"], words
code = subprocess.run(words[words.index("--metrics") + 2:]).returncode
print("==PROF== Connected to process 7 (kindling)")
print('==PROF== Profiling "kindling_shade" - 0: 0%....50%....100% - 3 passes')
table = csv.writer(sys.stdout, quoting=csv.QUOTE_ALL)
table.writerow(["ID", "Process ID", "Process Name", "Host Name", "Kernel Name", "Context", "Stream", "Block Size", "Grid Size", *metrics])
table.writerow([""] * 9 + ["ns" if "time" in name else "%" if "pct" in name else "" for name in metrics])
for number, (kernel, *values) in enumerate((("kindling_shade", "3,000,000", "96", "80", "40", "30", "25", "10"),
                                            ("kindling_intersect(const PathWave *, unsigned int)", "1000000", "40", "20", "70.5", "n/a", "50", "32"),
                                            ("kindling_shade", "1,000,000", "96", "60", "20", "10", "45", "30"))):
    table.writerow([number, 7, "kindling", "host", kernel, 1, 7, "(256, 1, 1)", "(2, 1, 1)", *values])
print("==PROF== Disconnected from process 7")
sys.exit(code)
"""

# It prints REPORT of the tool instead of a clean one where the program's flags have WORD.
SANITIZER = """#!/usr/bin/env python3
import subprocess, sys
words = sys.argv[1:]
tool, code = words[words.index("--tool") + 1], int(words[words.index("--error-exitcode") + 1])
print("========= COMPUTE-SANITIZER", flush=True)
result = subprocess.run(words[words.index("--error-exitcode") + 2:]).returncode
bad = tool == "TOOL" and "WORD" in words
if bad:
    print("========= Invalid __global__ read of size 4 bytes\\n=========     at kindling_take_node+0x90\\n=========")
if tool == "memcheck":
    print("========= ERROR SUMMARY:", "1 error" if bad else "0 errors")
else:
    print("========= RACECHECK SUMMARY:", "2 hazards displayed (1 error, 1 warning)" if bad else "0 hazards displayed (0 errors, 0 warnings)")
sys.exit(code if bad else result)
"""

EQUAL_NOISE = """import json, sys
words = sys.argv[1:]
assert words[words.index("--clock") + 1] == "wall" and "--device host" in words[-1]
rows = [{"setting": name, "mpaths_per_s": rate, "noise": noise, "noise_x_s": noise / rate}
        for name, rate, noise in (("kindling", 200.0, 0.25), ("without_reuse", 400.0, 1.0), ("mitsuba", 100.0, 2.0))]
json.dump({"scenes": [{"rows": rows}]}, open(words[words.index("--json") + 1], "w"))
"""


def run_round(folder, *flags, program=PROGRAM, script=ROUND, environment=None):
    result = subprocess.run([sys.executable, "-B", script, "--out", folder, "--device", "host", "--program", program, *flags],
                            check=False, capture_output=True, text=True, env=dict(os.environ, **(environment or {})))
    return result, json.loads((folder / "round.json").read_text(encoding="utf-8"))


def pack(folder):
    """The scripts beside each other, as round.sh packs them, with one measured scene."""
    for pattern in PACKED:
        for source in sorted(BENCH.parent.glob(pattern)):
            target = folder / source.relative_to(BENCH.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(source.read_bytes())
    measured = folder / "measured"
    measured.mkdir()
    (measured / "dragon.glb").write_bytes((SCENES / "cornell_box.glb").read_bytes())
    (measured / "scenes.json").write_text(json.dumps({"dragon": {"file": "dragon.glb", "max_bounces": 2}}))
    return folder / "bench/gpu/round.py"


def write_tool(folder, name, text):
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(text)
    (folder / name).chmod(0o755)
    return {"PATH": f"{folder}:{os.environ['PATH']}"}


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
        out = self.folder / "out"
        result, found = run_round(out, "--parts", "speed,shootout,scaling", "--size", "64x36", "--rounds", "1", "--rays", "500", "--spp", "8",
                                  "--seconds", "60", script=pack(self.folder / "round"))
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        race, shared = found["shootout"]["dragon"], found["scaling"]["dragon"]
        self.assertEqual((race["answers"], race["different"], shared["different images"]), (3500, 0, 0))
        for name in ("kdtree on host, bounce1", "embree, shadow1", "kdtree on host to kdtree"):
            self.assertGreater(race[name], 0, name)
        for name in ("1 thread", "device", "both, start included"):
            self.assertGreater(shared[name], 0, name)
        self.assertGreater(found["speed"]["dragon"]["CPU, two threads"], 0)
        times = found["times"]["dragon"]
        self.assertAlmostEqual(times["all"], sum(value for name, value in times.items() if name != "all"))
        self.assertGreater(times["shade"], 0)
        page = (out / "round.md").read_text(encoding="utf-8")
        self.assertIn("| scene | kdtree on host, camera |", page)
        self.assertIn("| dragon | ", page)

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


class Tools(unittest.TestCase):
    """Parts that run Kindling below another program, or another script."""
    setUp = HostDevice.setUp

    def test_kernels_have_sums_and_weighted_averages(self):
        tools = write_tool(self.folder / "bin", "ncu", NCU)
        result, found = run_round(self.folder / "out", "--parts", "kernels", script=pack(self.folder / "round"), environment=tools)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        rows = found["kernels"]["dragon"]
        self.assertEqual(list(rows), ["shade", "intersect", "all"])
        shade = rows["shade"]
        self.assertEqual((shade["launches"], shade["registers"], shade["bound"]), (2, 96, "arithmetic"))
        for name, value in (("ms", 4.0), ("share, %", 80.0), ("multiprocessors, %", 75.0), ("memory, %", 25.0), ("lanes of 32", 15.0)):
            self.assertAlmostEqual(shade[name], value)
        self.assertEqual((rows["intersect"]["memory, %"], rows["intersect"]["bound"]), (None, "caches"))
        self.assertAlmostEqual(rows["all"]["ms"], 5.0)
        page = (self.folder / "out" / "round.md").read_text(encoding="utf-8")
        self.assertIn("### dragon\n\n| kernel | launches | ms | share, % |", page)
        self.assertIn("| shade | 2 | 4.00 | 80.00 |", page)

    def test_counters_that_are_forbidden_skip_the_part(self):
        forbidden = write_tool(self.folder / "bin", "ncu", "#!/bin/sh\necho '==ERROR== ERR_NVGPUCTRPERM - no permission'; exit 1\n")
        result, found = run_round(self.folder / "out", "--parts", "kernels,machine", environment=forbidden)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("ERR_NVGPUCTRPERM", found["kernels"]["skipped"])
        self.assertIn("program", found["machine"])

    def test_a_render_that_fails_below_a_profiler_fails_its_part(self):
        tools = write_tool(self.folder / "bin", "ncu", NCU) | write_tool(self.folder / "bin", "compute-sanitizer", SANITIZER)
        broken = self.folder / "broken"
        broken.write_text("#!/bin/sh\necho 'no memory' >&2; exit 3\n")
        broken.chmod(0o755)
        result, found = run_round(self.folder / "out", "--parts", "kernels,sanitizer", program=broken, environment=tools)
        self.assertEqual(result.returncode, 1)
        self.assertIn("exit code 3", found["kernels"]["failed"])
        self.assertIn("no memory", found["sanitizer"]["failed"])

    def test_absent_tools_skip_their_parts(self):
        with mock.patch.object(one_round, "TOOL_FOLDERS", (f"{self.folder}/cuda*",)):
            with self.assertRaisesRegex(one_round.Skipped, "ncu_x is neither in PATH"):
                one_round.find_tool("ncu_x")
            write_tool(self.folder / "cuda-13", "ncu_x", "")
            self.assertEqual(one_round.find_tool("ncu_x"), f"{self.folder}/cuda-13/ncu_x")

    def test_clean_renders_have_no_errors(self):
        tools = write_tool(self.folder / "bin", "compute-sanitizer", SANITIZER)
        result, found = run_round(self.folder / "out", "--parts", "sanitizer", environment=tools)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("paged textures", found["sanitizer"])
        for row in found["sanitizer"].values():
            self.assertEqual((row["memcheck"], row["racecheck"]), (0, 0))
        self.assertFalse((self.folder / "out" / "sanitizer.txt").exists())

    def test_errors_of_memory_and_races_fail_the_round(self):
        for tool, count in (("memcheck", 1), ("racecheck", 2)):
            tools = write_tool(self.folder / "bin", "compute-sanitizer", SANITIZER.replace("TOOL", tool).replace("WORD", "whitted"))
            out = self.folder / tool
            result, found = run_round(out, "--parts", "sanitizer", environment=tools)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(found["sanitizer"]["Whitted"][tool], count)
            self.assertEqual(found["sanitizer"]["paths"][tool], 0)
            self.assertIn("Invalid __global__ read of size 4 bytes; at kindling_take_node", found["sanitizer"]["Whitted"][f"first of {tool}"])
            self.assertIn("kindling_take_node", (out / "sanitizer.txt").read_text(encoding="utf-8"))

    def test_figures_of_the_paper_until_the_time_is_over(self):
        result, found = run_round(self.folder, "--parts", "paper", "--paper-flags", "--scale 0.05 --spp-scale 0.05", "--seconds", "1")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        row = found["paper"]["9, path traced"]
        self.assertEqual((row["paper"], row["same bits"]), ("4.525 s", True))
        self.assertRegex(found["paper"]["ended early after"], r"^figure \d+$")
        self.assertIn("| 9, path traced | 4.525 s |", (self.folder / "round.md").read_text(encoding="utf-8"))
        self.assertTrue((self.folder / "paper.html").is_file())

    def test_figures_with_other_bits_fail_the_round(self):
        other = self.folder / "other"
        other.write_text(f'#!/bin/sh\ncase "$*" in *"--device host"*) exec {PROGRAM} "$@" --seed 5;; esac\nexec {PROGRAM} "$@"\n')
        other.chmod(0o755)
        result, found = run_round(self.folder / "out", "--parts", "paper", "--paper-flags", "--scale 0.05 --spp-scale 0.05", "--seconds", "1",
                                  program=other)
        self.assertEqual(result.returncode, 1)
        self.assertNotIn("failed", found["paper"])
        self.assertFalse(found["paper"]["9, path traced"]["same bits"])

    def test_figures_are_skipped_where_no_image_can_be_read(self):
        modules, empty = self.folder / "modules" / "PIL", self.folder / "empty"
        modules.mkdir(parents=True)
        (modules / "__init__.py").write_text("raise ImportError\n")
        empty.mkdir()
        result, found = run_round(self.folder / "out", "--parts", "paper", "--seconds", "30",
                                  environment={"PATH": str(empty), "PYTHONPATH": str(modules.parent)})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertRegex(found["paper"]["skipped"], "neither oiiotool nor Pillow is installed|NumPy is not installed")

    def test_a_packed_peer_is_raced(self):
        script, modules = pack(self.folder / "round"), self.folder / "modules"
        (self.folder / "round/bench/equal_noise.py").write_text(EQUAL_NOISE)
        (modules / "mitsuba-3.9.1.dist-info").mkdir(parents=True)
        (modules / "mitsuba-3.9.1.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: mitsuba\nVersion: 3.9.1\n")
        for name in ("numpy.py", "mitsuba.py"):
            (modules / name).touch()
        result, found = run_round(self.folder / "out", "--parts", "peer", script=script, environment={"PYTHONPATH": str(modules)})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        row = found["peer"]["dragon"]
        self.assertEqual((row["M samples/s, Kindling"], row["relMSE, Mitsuba"]), (200.0, 2.0))
        self.assertAlmostEqual(row["cost, Mitsuba / Kindling"], 16.0)
        self.assertAlmostEqual(row["cost, Mitsuba / without path reuse"], 8.0)
        (self.folder / "round/bench/equal_noise.py").write_text("import sys; sys.exit('no OptiX')")
        result, found = run_round(self.folder / "out", "--parts", "peer", script=script, environment={"PYTHONPATH": str(modules)})
        self.assertEqual(result.returncode, 1)
        self.assertIn("no OptiX", found["peer"]["failed"])
        (modules / "mitsuba.py").write_text("raise ImportError('for another Python')")
        result, found = run_round(self.folder / "out", "--parts", "peer", script=script, environment={"PYTHONPATH": str(modules)})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("mitsuba: ImportError: for another Python", found["peer"]["skipped"])

    def test_an_absent_peer_is_skipped(self):
        result, found = run_round(self.folder / "out", "--parts", "peer", environment={"XDG_CACHE_HOME": str(self.folder), "PYTHONPATH": ""})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("mitsuba==3.9.1 is absent", found["peer"]["skipped"])

    def test_all_parts_end_where_the_time_is_over(self):
        tools = write_tool(self.folder / "bin", "ncu", NCU) | write_tool(self.folder / "bin", "compute-sanitizer", SANITIZER)
        result, found = run_round(self.folder / "out", "--parts", "kernels,sanitizer,paper,bits", "--seconds", "0", environment=tools)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        for part, place in (("kernels", "interior"), ("sanitizer", "memcheck, paths"), ("paper", "figure 9")):
            self.assertEqual(found[part], {"ended early before": place})


    def test_wheels_are_looked_for_before_packing(self):
        for wheels, message in (([], "usage: round.sh pack"), ([self.folder], "no .whl in it")):
            result = subprocess.run(["bash", ROUND.with_name("round.sh"), "pack", self.folder / "a.tar.xz", "--wheels", *wheels], check=False,
                                    capture_output=True, text=True)
            self.assertEqual(result.returncode, 2)
            self.assertIn(message, result.stderr)


class Summaries(unittest.TestCase):
    def test_errors_and_hazards(self):
        for tool, code, text, expected in (("memcheck", 0, "========= ERROR SUMMARY: 0 errors\n", 0),
                                           ("memcheck", 99, "========= ERROR SUMMARY: 12 errors\n", 12),
                                           ("memcheck", 1, "kindling: error\n========= ERROR SUMMARY: 1 error\n", 1),
                                           ("racecheck", 99, "========= RACECHECK SUMMARY: 3 hazards displayed (2 errors, 1 warning)\n", 3)):
            self.assertEqual(sanitizer.errors_of(tool, subprocess.CompletedProcess([], code, text)), expected)

    def test_summaries_that_are_missing(self):
        for code, text, kind in ((0, "", RuntimeError), (3, "========= ERROR SUMMARY: 0 errors\n", RuntimeError),
                                 (1, "========= Error: Device not supported\n", one_round.Skipped)):
            with self.assertRaisesRegex(kind, f"exit code {code}"):
                sanitizer.errors_of("memcheck", subprocess.CompletedProcess([], code, text))


class Profiles(unittest.TestCase):
    def test_units_of_time(self):
        for unit, expected in (("ns", 2e-9), ("usecond", 2e-6), ("msecond", 2e-3)):
            text = f'"ID","Kernel Name","gpu__time_duration.sum"\n"","","{unit}"\n"0","a","2.00"\n'
            self.assertAlmostEqual(kernels.launches_of(text)[0]["_s"], expected, delta=1e-12)
        with self.assertRaisesRegex(ValueError, "in 'cycle'"):
            kernels.launches_of('"ID","Kernel Name","gpu__time_duration.sum"\n"","","cycle"\n"0","a","2.00"\n')

    def test_output_without_a_table(self):
        for text in ("", "==WARNING== No kernels were profiled.\n", '"ID","Kernel Name"\n"0","a"\n', "kindling: error: a, b\n"):
            self.assertEqual(kernels.launches_of(text), [])

    def test_bounds(self):
        for figures, expected in (((90.0, 40.0, 30.0), "arithmetic"), ((50.0, 81.0, 80.0), "memory"), ((50.0, 90.0, 70.0), "caches"),
                                  ((59.0, 50.0, 40.0), "latency"), ((None, None, None), None), ((70.0, None, None), "arithmetic")):
            row = dict(zip(("multiprocessors, %", "caches and memory, %", "memory, %"), figures))
            self.assertEqual(kernels.bound(row), expected, figures)


class Page(unittest.TestCase):
    def test_scenes_have_rows_and_failures_are_named(self):
        page = round_page.markdown({"shootout": {"a": {"gpu": 1.5, "different": 0}, "b": {"gpu": 2.0}, "failed": "lost"}}, "gpu")
        self.assertIn("- failed: lost\n\n| scene | gpu | different |\n|---|---|---|\n| a | 1.50 | 0 |\n| b | 2.00 | - |", page)
        self.assertIn("- failed: lost", round_page.markdown({"speed": {"failed": "lost"}}, "gpu"))

    def test_speeds_have_their_ratios(self):
        page = round_page.markdown({"speed": {"dragon": {"gpu": 260.0, "CPU, two threads": 3.25}}}, "gpu")
        self.assertIn("| dragon | 260.00 | 3.25 | 80.00 |", page)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
