#!/usr/bin/env python3
"""Tests of `kindling farm` on a Slurm cluster of three nodes on this machine, with faults.

usage: slurm_farm.py KINDLING SCENES [-v] [SlurmFarm.test_...]

Each node has one processor. KINDLING is the program, SCENES the folder of the scenes. Needs Debian's
packages munge, slurmctld, slurmd and slurm-client, and idiff of openimageio-tools. Takes about six
minutes on two processors.
"""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from slurm_bed import SlurmBed  # pylint: disable=wrong-import-position

PROGRAM = SCENES = None
IN_PROGRESS, INCOMPLETE, SCENE_INVALID = 6, 5, 3
# An image that takes about 15 processor seconds, training included.
FLAGS = ["--size", "320x180", "--spp", "192", "--seed", "5", "--exr-float", "--checkpoint-every", "1"]


class SlurmFarm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bed = SlurmBed(nodes=3, cpus=1)
        cls.bed.__enter__()
        cls.addClassCleanup(cls.bed.stop)
        cls.references = Path(tempfile.mkdtemp(prefix="kindling-references-"))
        cls.addClassCleanup(shutil.rmtree, cls.references, ignore_errors=True)

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="kindling-farm-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.farm = self.folder / "farm"
        self.start = time.monotonic()

    # Helpers.

    def kindling(self, *arguments, code=0):
        result = subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.bed.environment, capture_output=True, text=True,
                                stdin=subprocess.DEVNULL, timeout=300, check=False)
        if code is not None:
            self.assertEqual(result.returncode, code, f"{arguments}: {result.stdout}{result.stderr}")
        return result

    def submit(self, scene, parts, flags, *more, outputs=("out.exr",)):
        names = [word for name in outputs for word in ("-o", name)]
        text = self.kindling("farm", "submit", scene, "--parts", parts, "--folder", self.farm, *names, *more, "--", *flags).stdout
        return dict(line.split("\t") for line in text.splitlines() if "\t" in line)

    def status(self):
        result = self.kindling("farm", "status", self.farm, "--json", code=None)
        self.assertTrue(result.stdout, result.stderr)
        return json.loads(result.stdout)

    def wait_until(self, what, condition, seconds=120):
        """Returns the first status for which condition(status) holds; prints the farm's logs if none comes in time."""
        found = []

        def asked():
            found[:] = [self.status()]
            return condition(found[0])
        try:
            self.bed.wait_until(what, asked, seconds)
        except Exception:
            logs = "".join(f"--- {path.name}\n{path.read_text(errors='replace')[-2000:]}" for path in sorted(self.farm.glob("logs/*")))
            print(json.dumps(found[-1:], indent=1), logs, file=sys.stderr)
            raise
        return found[0]

    def wait_for_end(self, seconds=150):
        return self.wait_until("the end of the farm", lambda status: not status["goes_on"], seconds)

    @staticmethod
    def tasks(status):
        return [task for frame in status["frames"] for task in frame["tasks"]]

    def running(self, status, low=0.2, high=0.8):
        return [task for task in self.tasks(status) if task["state"] == "running" and low <= task["progress"] <= high]

    def saved(self, status):
        """The running tasks that have a checkpoint."""
        return [task for task in self.running(status) if (self.farm / f"parts/part-{task['part']:03}.checkpoint.kacc").exists()]

    def reference(self, scene, flags):
        """The image rendered by one process with all threads; rendered once."""
        path = self.references / (re.sub(r"\W+", "-", " ".join([Path(scene).stem, *flags])) + ".exr")
        if not path.exists():
            words = [flag for flag in flags if flag not in ("--checkpoint-every", "1")]
            self.kindling("render", scene, *words, "-o", path)
        return path

    def expect_same_pixels(self, path, reference):
        result = subprocess.run(["idiff", "-a", "-fail", "0", "-warn", "0", str(reference), str(path)], capture_output=True, text=True,
                                stdin=subprocess.DEVNULL, check=False)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def exit_code_of_job(self, job):
        found = re.search(r"ExitCode=(\d+):(\d+)", self.bed.run("scontrol", "show", "job", job))
        return int(found[1])

    def log(self, text):
        print(f"    {time.monotonic() - self.start:5.1f} s  {text}", file=sys.stderr, flush=True)

    # Tests.

    def lose_a_node(self, accelerator):
        scene, flags = SCENES / "interior.glb", [*FLAGS, "--accel", accelerator]
        reference = self.reference(scene, flags)
        self.log("reference rendered")
        self.submit(scene, 4, flags)
        # A lost part loses the samples after its last save, so there must have been one.
        status = self.wait_until("two parts in their middle that have been saved", lambda status: len(self.saved(status)) >= 2)
        victim = self.saved(status)[0]
        self.log(f"kill -9 of {victim['host']}, part {victim['part']} at {100 * victim['progress']:.0f} %: "
                 f"{self.bed.kill_node(victim['host'])} processes")
        self.addCleanup(self.restart, victim["host"])
        status = self.wait_for_end()
        self.log("the farm has ended")
        self.assertEqual(status["exit_code"], 0, status)
        attempts = self.tasks(status)[victim["task"]]["attempts"]
        self.assertEqual([attempt["outcome"] for attempt in attempts], ["lost", "done"])
        self.assertNotEqual(attempts[0]["host"], attempts[1]["host"])
        self.assertTrue(attempts[1]["resumed"])  # from the last checkpoint
        self.expect_same_pixels(self.folder / "out.exr", reference)

    def restart(self, node):
        if node not in self.bed.daemons:
            self.bed.start_node(node)
        self.bed.wait_until(f"{node} idle", lambda: self.bed.node_states().get(node) == "idle", 60)

    def test_lost_node_costs_no_pixel_kdtree(self):
        self.lose_a_node("kdtree")

    def test_lost_node_costs_no_pixel_embree(self):
        self.lose_a_node("embree")

    def test_preempted_part_resumes_from_its_checkpoint(self):
        scene, flags = SCENES / "interior.glb", [*FLAGS, "--accel", "kdtree"]
        reference = self.reference(scene, flags)
        # An hour between checkpoints, so the only one comes from the signal.
        rare = [flag if flag != "1" else "1h" for flag in flags]
        jobs = self.submit(scene, 2, rare)
        status = self.wait_until("a part in its middle", lambda status: self.running(status, 0.3))
        task = self.running(status, 0.3)[0]
        self.bed.run("scontrol", "requeue", f"{jobs['jobs']}_{task['task']}")
        self.log(f"part {task['part']} requeued at {100 * task['progress']:.0f} %")
        status = self.wait_for_end()
        self.assertEqual(status["exit_code"], 0, status)
        attempts = self.tasks(status)[task["task"]]["attempts"]
        self.assertEqual([attempt["outcome"] for attempt in attempts], ["interrupted", "done"])
        self.assertEqual([attempt["resumed"] for attempt in attempts], [False, True])
        self.expect_same_pixels(self.folder / "out.exr", reference)

    def test_bad_scene_is_not_retried(self):
        scene = self.folder / "bad.gltf"
        scene.write_text('{"asset": {"version": "3.0"}}')
        self.kindling("farm", "submit", scene, "--parts", 6, "--folder", self.farm, "-o", "out.exr", code=SCENE_INVALID)
        self.assertFalse(self.farm.exists())  # nothing was started
        jobs = self.submit(scene, 6, [], "--no-check")
        status = self.wait_for_end()
        self.assertEqual(status["exit_code"], SCENE_INVALID, status)
        self.assertIn("bad.gltf", status["refusal"]["message"])
        counts = [len(task["attempts"]) for task in self.tasks(status)]
        self.assertLessEqual(max(counts), 1)
        self.assertLessEqual(sum(counts), 3)  # those that started before the first one ended
        self.assertEqual(self.exit_code_of_job(jobs["merge"]), SCENE_INVALID)
        self.assertFalse((self.folder / "out.exr").exists())

    @staticmethod
    def processes_with(words):
        """Ids of the processes that have these words in their command lines."""
        found = []
        for folder in Path("/proc").iterdir():
            try:
                if folder.name.isdigit() and words <= set((folder / "cmdline").read_bytes().split(b"\0")):
                    found.append(int(folder.name))
            except OSError:
                continue  # ended meanwhile
        return found

    def renders_of(self, part):
        return self.processes_with({b"render", bytes(self.farm / f"parts/part-{part:03}.unfinished.kacc")})

    def crash_always(self, part, stop):
        """Ends every render of this part by SIGSEGV, until `stop` is set."""
        while not stop.wait(0.1):
            for process in self.renders_of(part):
                try:
                    os.kill(process, signal.SIGSEGV)
                except ProcessLookupError:
                    continue

    @staticmethod
    def waits_for(process, number):
        """True if this signal is pending for the process, which is stopped."""
        try:
            lines = Path(f"/proc/{process}/status").read_text().splitlines()
        except OSError:
            return False
        pending = next(int(line.split()[1], 16) for line in lines if line.startswith("ShdPnd:"))
        return bool(pending >> (number - 1) & 1)

    def test_part_out_of_time_resumes_by_itself(self):
        scene, flags = SCENES / "interior.glb", [*FLAGS, "--accel", "kdtree"]
        reference = self.reference(scene, flags)
        # An hour between checkpoints, so the only one comes from Slurm's warning. Slurm's shortest
        # time limit is a minute; the render is stopped for the rest of it.
        rare = [flag if flag != "1" else "1h" for flag in flags]
        self.submit(scene, 2, rare, "--time", "1")
        status = self.wait_until("a part in its middle", lambda status: self.running(status))
        task = self.running(status)[0]
        render = self.renders_of(task["part"])[0]
        os.kill(render, signal.SIGSTOP)
        self.addCleanup(subprocess.run, ["kill", "-CONT", str(render)], stderr=subprocess.DEVNULL, check=False)
        self.log(f"part {task['part']} stopped at {100 * task['progress']:.0f} %")
        self.bed.wait_until("Slurm's warning", lambda: self.waits_for(render, signal.SIGINT), 70)
        self.log("Slurm has warned the render, which continues")
        os.kill(render, signal.SIGCONT)
        status = self.wait_for_end()
        self.log("the farm has ended")
        self.assertEqual(status["exit_code"], 0, status)
        attempts = self.tasks(status)[task["task"]]["attempts"]
        # On a busy machine one more minute may not be enough.
        more = len(attempts) - 1
        self.assertGreaterEqual(more, 1)
        self.assertEqual([attempt["outcome"] for attempt in attempts], ["out of time"] * more + ["done"])
        self.assertEqual([attempt["resumed"] for attempt in attempts], [False] + [True] * more)
        saved = [attempt["saved"] for attempt in attempts]
        self.assertEqual(saved, sorted(set(saved)))  # each attempt makes progress
        self.assertGreater(saved[0], 0.0)
        self.expect_same_pixels(self.folder / "out.exr", reference)

    def test_part_without_progress_is_poisoned(self):
        scene, flags = SCENES / "interior.glb", [*FLAGS, "--accel", "kdtree"]
        jobs = self.submit(scene, 2, flags)
        # The signal that Slurm sends before the end of --time, each time before the render's first
        # sample.
        for attempt in (1, 2):
            render = self.bed.wait_until(f"attempt {attempt}", lambda: self.renders_of(2), 60, every=0.001)[0]
            os.kill(render, signal.SIGSTOP)
            self.bed.run("scancel", "--batch", "--signal=USR1", f"{jobs['jobs']}_1")
            self.bed.wait_until("the warning", lambda process=render: self.waits_for(process, signal.SIGINT), 10)
            os.kill(render, signal.SIGCONT)
            self.bed.wait_until("the end of the attempt", lambda process=render: process not in self.renders_of(2), 60)
            self.log(f"attempt {attempt} of part 2 was out of time")
        status = self.wait_for_end()
        self.assertEqual(status["exit_code"], INCOMPLETE, status)
        self.assertEqual([task["state"] for task in self.tasks(status)], ["done", "poisoned"])
        poisoned = self.tasks(status)[1]
        self.assertEqual([attempt["outcome"] for attempt in poisoned["attempts"]], ["out of time"] * 2)
        self.assertIn("out of time 2 times in a row without progress, 0.0 %", poisoned["reason"])
        self.assertEqual(self.exit_code_of_job(jobs["merge"]), INCOMPLETE)

        self.kindling("farm", "retry", self.farm)
        self.assertEqual(self.wait_for_end()["exit_code"], 0)
        self.expect_same_pixels(self.folder / "out.exr", self.reference(scene, flags))

    def test_poisoned_part_is_reported_and_retried(self):
        scene, flags = SCENES / "interior.glb", [*FLAGS, "--accel", "kdtree"]
        stop = threading.Event()
        crashes = threading.Thread(target=self.crash_always, args=(2, stop))
        crashes.start()
        self.addCleanup(crashes.join)
        self.addCleanup(stop.set)
        jobs = self.submit(scene, 3, flags, "--retries", 1)
        status = self.wait_for_end()
        stop.set()
        self.log("the farm has ended")
        self.assertEqual(status["exit_code"], INCOMPLETE, status)
        self.assertEqual([task["state"] for task in self.tasks(status)], ["done", "poisoned", "done"])
        poisoned = self.tasks(status)[1]
        self.assertEqual([attempt["signal"] for attempt in poisoned["attempts"]], [11, 11])
        self.assertIn("failed 2 times", poisoned["reason"])
        self.assertTrue(Path(poisoned["log"]).exists())
        self.assertEqual(self.exit_code_of_job(jobs["merge"]), INCOMPLETE)
        self.assertIn("part 2/3 poisoned", (self.farm / f"logs/merge_{jobs['merge']}.log").read_text())
        self.assertFalse((self.folder / "out.exr").exists())
        table = self.kindling("farm", "status", self.farm, code=INCOMPLETE).stdout
        self.assertIn("poisoned", table)

        self.kindling("farm", "retry", self.farm)  # one part; the others are done
        status = self.wait_for_end()
        self.assertEqual(status["exit_code"], 0, status)
        self.expect_same_pixels(self.folder / "out.exr", self.reference(scene, flags))

    def test_each_frame_is_merged(self):
        scene, flags = SCENES / "cornell_box.glb", ["--size", "64x48", "--spp", "8", "--exr-float"]
        self.submit(scene, 2, flags, "--frames", "1-5x4", outputs=("out.####.exr", "out.####.png"))
        self.kindling("farm", "status", self.farm, code=IN_PROGRESS)
        self.assertEqual(self.wait_for_end()["exit_code"], 0)
        self.kindling("render", scene, *flags, "--frames", "1-5x4", "-o", "one.####.exr")
        for frame in (1, 5):
            self.expect_same_pixels(self.folder / f"out.{frame:04}.exr", self.folder / f"one.{frame:04}.exr")
            self.assertTrue((self.folder / f"out.{frame:04}.png").exists())


def main():
    global PROGRAM, SCENES  # pylint: disable=global-statement
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    PROGRAM, SCENES = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    for program in ("munged", "slurmctld", "slurmd", "sbatch", "idiff"):
        if not shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin"):
            sys.exit(f"slurm_farm.py: {program} is not installed; see the usage text at the head of this script")
    # SIGTERM exits like SIGINT, so that the cluster is torn down.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)


if __name__ == "__main__":
    main()
