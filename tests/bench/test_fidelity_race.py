#!/usr/bin/env python3
"""Tests of bench/fidelity_race.py: cameras of scenarios in copies of models.

test_fidelity_race.py BENCH_FOLDER SCENES_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import contextlib
import io
import json
import math
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

BENCH, SCENES = Path(sys.argv[1]), Path(sys.argv[2])
sys.path.insert(0, str(BENCH))
import fidelity_race
import renderers
from peers import gltf_json


def rotated(quaternion, vector):
    """v + 2 w (u x v) + 2 u x (u x v) of a unit quaternion (u, w)."""
    *u, w = quaternion
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    once = cross(u, vector)
    return [v + 2 * w * a + 2 * b for v, a, b in zip(vector, once, cross(u, once))]


class Camera(unittest.TestCase):
    def test_looks_at_the_target_with_a_level_horizon(self):
        """The eye by the generator's formula; the camera's -z points to the target, its x is level, its y is not upside down."""
        for azimuth, polar in ((0, 90), (35, 70), (-120, 100), (90, 10)):
            flags = {"--orbit": f"{azimuth},{polar},4", "--target": "1,2,3", "--fov": "30"}
            document = fidelity_race.with_camera({}, flags, 1.5)
            node, t, p = document["nodes"][-1], math.radians(azimuth), math.radians(polar)
            eye = [1 + 4 * math.sin(p) * math.sin(t), 2 + 4 * math.cos(p), 3 + 4 * math.sin(p) * math.cos(t)]
            for got, expected in zip(node["translation"], eye):
                self.assertAlmostEqual(got, expected)
            for got, expected in zip(rotated(node["rotation"], [0, 0, -4]), [c - e for c, e in zip((1, 2, 3), eye)]):
                self.assertAlmostEqual(got, expected)
            self.assertAlmostEqual(rotated(node["rotation"], [1, 0, 0])[1], 0)
            self.assertGreater(rotated(node["rotation"], [0, 1, 0])[1], 0)
            self.assertAlmostEqual(document["cameras"][0]["perspective"]["yfov"], math.pi / 6)

    def test_replaces_cameras_of_the_model(self):
        document = {"cameras": [{"type": "orthographic"}, {"type": "orthographic"}], "nodes": [{"camera": 1}, {"name": "mesh"}],
                    "scenes": [{"nodes": [1]}, {"nodes": [0]}], "scene": 1}
        document = fidelity_race.with_camera(document, {"--orbit": "0,90,1", "--target": "0,0,0", "--fov": "45"}, 1.0)
        self.assertEqual([c["type"] for c in document["cameras"]], ["perspective"])
        self.assertEqual([n.get("camera") for n in document["nodes"]], [None, None, 0])
        self.assertEqual(document["scenes"], [{"nodes": [1]}, {"nodes": [0, 2]}])


class Extensions(unittest.TestCase):
    def test_removes_the_named_ones_alone(self):
        film, sheen = "KHR_materials_iridescence", "KHR_materials_sheen"
        document = {"extensionsUsed": [film, sheen], "extensionsRequired": [film], "nodes": [{"mesh": 0}], "materials": [
            {"name": film, "extensions": {film: {"iridescenceFactor": 1}, sheen: {}}}, {"extensions": {film: {}}}, {"alphaCutoff": 0.5}]}
        self.assertEqual(fidelity_race.without_extensions(document, [film]), {
            "extensionsUsed": [sheen], "nodes": [{"mesh": 0}],
            "materials": [{"name": film, "extensions": {sheen: {}}}, {}, {"alphaCutoff": 0.5}]})
        self.assertEqual(fidelity_race.without_extensions(document, []), document)


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.models, self.out = Path(temporary.name) / "models", Path(temporary.name) / "out"
        for name, file in (("Text", SCENES / "tiny" / "external_files.gltf"), ("Binary", SCENES / "cornell_box.glb")):
            (self.models / name).mkdir(parents=True)
            shutil.copy(file, self.models / name)
        for file in ("büffer.bin", "checker board.png"):
            shutil.copy(SCENES / "tiny" / file, self.models / "Text")
        (self.models / "env").mkdir()
        (self.models / "env" / "sky.hdr").write_bytes(b"#?RADIANCE\n")
        (self.models / "render-fidelity.json").write_text(json.dumps({"scenarios": [
            {"name": f"own-{name}", "model": f"Models/{name}/{name}", "lighting": "sky.hdr", "orbit": {"radius": 3}} for name in ("Text", "Binary")]}))

    def run_program(self, *words):
        sys.argv, arguments_before = ["fidelity_race.py", str(self.models), str(self.out), *words], sys.argv
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                fidelity_race.main()
        finally:
            sys.argv = arguments_before

    def test_jobs_have_scenes_with_one_camera_and_their_environment(self):
        self.run_program()
        jobs = {job.name: job for job in renderers.load_jobs([self.out])}
        self.assertEqual(sorted(jobs), ["Binary", "Text"])
        for job in jobs.values():
            self.assertEqual(job.environment, self.out / "env" / "sky.hdr")
            document = gltf_json.read_json(job.scene)
            self.assertEqual([n["name"] for n in document["nodes"] if "camera" in n], ["camera of the scenario"])
        self.assertTrue((self.out / "Text" / "büffer.bin").is_file())
        original, copy = (path.read_bytes() for path in (SCENES / "cornell_box.glb", jobs["Binary"].scene))
        self.assertEqual(int.from_bytes(copy[8:12], "little"), len(copy))
        self.assertEqual(copy[-64:], original[-64:])

    def test_removes_extensions_from_the_copies(self):
        path = self.models / "Text" / "external_files.gltf"
        document = gltf_json.read_json(path)
        document["materials"][0]["extensions"] = {"KHR_materials_ior": {"ior": 2}}
        gltf_json.write_json(path, dict(document, extensionsUsed=["KHR_materials_ior"]))
        for words, expected in (((), True), (("--without", "KHR_materials_ior"), False)):
            self.run_program("--only", "text", *words)
            self.assertEqual("KHR_materials_ior" in (self.out / "Text" / path.name).read_text(encoding="utf-8"), expected)

    def test_copies_have_no_animations(self):
        path = self.models / "Text" / "external_files.gltf"
        gltf_json.write_json(path, dict(gltf_json.read_json(path), animations=[{"channels": [], "samplers": []}]))
        self.run_program("--only", "text")
        self.assertNotIn("animations", gltf_json.read_json(self.out / "Text" / path.name))

    def test_takes_a_part_and_refuses_unknown_names(self):
        self.run_program("--only", "text")
        self.assertEqual(list(json.loads((self.out / "scenes.json").read_text())), ["Text"])
        with self.assertRaisesRegex(SystemExit, "no scenario of that name"):
            self.run_program("--only", "nothing")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
