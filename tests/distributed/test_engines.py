#!/usr/bin/env python3
"""Runs the commands of renderer/distributed/engines and compares the merged images.

The numbers that Kubernetes and OpenCue would insert are inserted here; the images must equal those of one process.
"""
# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import runpy
import subprocess
import sys
import tempfile
import types
import unittest

import yaml

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
SCENE = pathlib.Path(sys.argv.pop(1)).resolve()
ENGINES = pathlib.Path(__file__).resolve().parents[2] / "renderer/distributed/engines"
SIZE = ["--size", "24x16", "--exr-float"]
SAMPLES = "8"


class EngineTest(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.scratch.name)
        # The snippets call `kindling`; this wrapper adds only a small image size.
        wrapper = self.folder / "bin/kindling"
        wrapper.parent.mkdir()
        wrapper.write_text('#!/bin/sh\ncommand=$1\nshift\n'
                           f'[ $command = render ] && set -- "$@" {" ".join(SIZE)}\n'
                           f'exec "{PROGRAM}" $command "$@" --png-bits 16 --quiet\n')
        wrapper.chmod(0o755)
        self.environment = dict(os.environ, PATH=f"{wrapper.parent}:{os.environ['PATH']}")
        self.run_shell(f'kindling render "{SCENE}" --spp {SAMPLES} -o whole.png >/dev/null')

    def tearDown(self):
        self.scratch.cleanup()

    def run_shell(self, command, expected=0, **variables):
        done = subprocess.run(["sh", "-c", command], cwd=self.folder, env=dict(self.environment, **variables),
                              capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, expected, f"{command}\n{done.stdout}{done.stderr}")
        return done

    def assert_same_pixels(self, name):
        self.assertEqual(pixels(self.folder / "whole.png"), pixels(self.folder / name))

    def test_kubernetes(self):
        parts, merge = yaml.safe_load_all((ENGINES / "kubernetes.yaml").read_text())
        for job in parts, merge:
            self.assertEqual((job["apiVersion"], job["kind"]), ("batch/v1", "Job"))
            spec = job["spec"]["template"]["spec"]
            self.assertEqual(spec["restartPolicy"], "Never")  # required by podFailurePolicy
            names = {container["name"] for container in spec["containers"]}
            volumes = {volume["name"] for volume in spec["volumes"]}
            for rule in job["spec"]["podFailurePolicy"]["rules"]:
                self.assertIn(rule["action"], ("Ignore", "FailJob", "FailIndex", "Count"))
                self.assertEqual(("onExitCodes" in rule) + ("onPodConditions" in rule), 1)
                if "onExitCodes" in rule:
                    self.assertIn(rule["onExitCodes"]["containerName"], names)
                    self.assertEqual(rule["onExitCodes"]["operator"], "In")
                    self.assertNotIn(0, rule["onExitCodes"]["values"])
            for container in spec["containers"]:
                self.assertLessEqual({mount["name"] for mount in container["volumeMounts"]}, volumes)
        self.assertEqual(parts["spec"]["completionMode"], "Indexed")
        count = parts["spec"]["completions"]
        changed = {"SCENE": str(SCENE), "FOLDER": "parts", "SPP": SAMPLES, "THREADS": "1", "OUTPUT": "merged.png",
                   "WAIT_S": "0", "POLL_S": "1"}

        def run_job(job, expected=0, **more):
            container = job["spec"]["template"]["spec"]["containers"][0]
            self.assertEqual(container["command"], ["sh", "-c"])
            variables = {entry["name"]: entry["value"] for entry in container["env"]}
            self.assertLessEqual(set(variables) - {"PARTS"}, set(changed))
            if job is parts:
                self.assertEqual(variables["PARTS"], str(count))
            variables.update({name: value for name, value in changed.items() if name in variables}, **more)
            self.run_shell(container["args"][0], expected, **variables)

        run_job(merge, expected=4)  # no parts yet
        for index in range(count):
            if index == 5:
                run_job(merge, expected=5)
            run_job(parts, JOB_COMPLETION_INDEX=str(index))
        run_job(parts, JOB_COMPLETION_INDEX="0")  # a superfluous attempt
        run_job(merge)
        self.assert_same_pixels("merged.png")

    def test_opencue(self):
        launched = run_with_stand_in(ENGINES / "opencue_frame.py", [
            str(SCENE), "merged.png", "--folder", str(self.folder / "two words"), "--parts", "3", "--cores", "1", "--",
            "--spp", SAMPLES])
        job, options = launched
        self.assertIs(options["use_pycuerun"], False)
        parts, merge = job.layers
        self.assertEqual((parts.options["range"], merge.options["range"]), ("1-3", "1-1"))
        self.assertEqual(merge.depends, [parts])
        for number in (3, 1, 2):
            self.run_shell(" ".join(parts.options["command"]).replace("#IFRAME#", str(number)))
        self.run_shell(" ".join(merge.options["command"]))
        self.assert_same_pixels("merged.png")


class StandIn:
    """Records the calls of pyoutline's Outline and Shell."""

    def __init__(self, name, **options):
        self.name, self.options, self.layers, self.depends = name, options, [], []

    def add_layer(self, layer):
        self.layers.append(layer)

    def depend_all(self, layer):
        self.depends.append(layer)


def run_with_stand_in(script, arguments):
    launched = []
    outline, cuerun, modules, shell = (types.ModuleType(name) for name in (
        "outline", "outline.cuerun", "outline.modules", "outline.modules.shell"))
    outline.Outline, shell.Shell = StandIn, StandIn
    cuerun.launch = lambda job, **options: launched.append((job, options))
    outline.cuerun, outline.modules, modules.shell = cuerun, modules, shell
    sys.modules.update({module.__name__: module for module in (outline, cuerun, modules, shell)})
    before = sys.argv
    sys.argv = [str(script), *arguments]
    try:
        runpy.run_path(str(script), run_name="__main__")
    finally:
        sys.argv = before
    (only,) = launched
    return only


def pixels(path):
    """Returns the compressed pixels of a PNG without its text chunks, which contain the command."""
    data, chunks, at = path.read_bytes(), [], 8
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        if kind in (b"IHDR", b"IDAT"):
            chunks.append(data[at + 8:at + 8 + length])
        at += 12 + length
    return b"".join(chunks)


if __name__ == "__main__":
    unittest.main()
