#!/usr/bin/env python3
"""Tests of bench/fidelity.py: metrics against papers, cameras, whole runs; and the gallery's names.

test_fidelity.py BENCH_FOLDER SCENES_FOLDER [kindling]
"""
# SPDX-License-Identifier: Apache-2.0
import contextlib
import io
import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BENCH, SCENES = Path(sys.argv[1]), Path(sys.argv[2])
PROGRAM = sys.argv[3] if len(sys.argv) > 3 else ""
sys.path.insert(0, str(BENCH))
import with_numpy  # noqa: F401
import numpy as np

import color_difference
import fidelity
import fidelity_images
import fidelity_scenarios
import flip
import gallery_images


def constant(color, size=32):
    return np.full((size, size, 3), color, float)


class Flip(unittest.TestCase):
    def test_same_is_zero(self):
        image = np.random.default_rng(1).random((24, 40, 3))
        self.assertEqual(flip.flip(image, image).max(), 0.0)

    def test_extremes(self):
        """Filters leave constant images as they are, so FLIP is the remapped HyAB distance alone. Green to blue is the farthest: 1.
        White to black is 100 in lightness alone; L* a* b* of sRGB's green and blue are (87.73, -86.18, 83.18), (32.30, 79.19, -107.86)."""
        green_blue = 87.73 - 32.30 + np.hypot(0.8773 * -86.18 - 0.3230 * 79.19, 0.8773 * 83.18 - 0.3230 * -107.86)
        largest, black_white = green_blue ** 0.7, 100 ** 0.7
        expected = 0.95 + (black_white - 0.4 * largest) / (0.6 * largest) * 0.05
        np.testing.assert_allclose(flip.flip(constant((0, 1, 0)), constant((0, 0, 1))), 1.0, atol=1e-9)
        np.testing.assert_allclose(flip.flip(constant(0.0), constant(1.0)), expected, atol=2e-4)
        # A small step of gray is in the first, proportional part. L* = 116 Y^(1/3) - 16.
        lightness = [116 * ((v + 0.055) / 1.055) ** (2.4 / 3) - 16 for v in (0.5, 0.52)]
        np.testing.assert_allclose(flip.flip(constant(0.5), constant(0.52)), 0.95 * (lightness[1] - lightness[0]) ** 0.7 / (0.4 * largest),
                                   rtol=2e-4)

    def test_features_raise_it(self):
        """A thin line that only one image has costs more than its filtered color does."""
        plain, line = constant(0.5, 48), constant(0.5, 48)
        line[:, 24] = 0.7
        opponent = [flip.rgb_to_opponent(flip.srgb_to_linear(p)) for p in (plain, line)]
        color = flip.color_difference(*opponent, flip.PIXELS_PER_DEGREE)
        whole = flip.flip(plain, line)
        self.assertGreater(whole[24, 24], 1.2 * color[24, 24])
        self.assertLess(whole[24, 0], 1e-6)
        np.testing.assert_allclose(whole, flip.flip(line, plain), atol=1e-12)
        np.testing.assert_allclose(whole.T, flip.flip(plain, np.swapaxes(line, 0, 1)), atol=1e-9)

    def test_against_its_authors_program(self):
        """What flip-evaluator 1.7 prints for the same formula; its single precision and rounded matrices leave 1e-5."""
        y, x = np.mgrid[0:120, 0:160]
        a = np.stack([0.5 + 0.5 * np.sin(x / 7), 0.5 + 0.5 * np.cos(y / 5 + x / 11), ((x // 8 + y // 8) % 2) * 0.8], -1)
        b = np.clip(a * 0.9 + 0.05 * np.sin(y / 3)[..., None], 0, 1)
        self.assertAlmostEqual(flip.flip(a, b).mean(), 0.374869, delta=3e-5)
        self.assertAlmostEqual(flip.flip(a, a[::-1]).mean(), 0.741981, delta=3e-5)


class Color(unittest.TestCase):
    def test_ciede2000(self):
        """Pairs 1, 4, 7, 9, 17, 21, 25 and 34 of table 1 of Sharma, Wu and Dalal, 2005."""
        pairs = [((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425), ((50.0, -1.3802, -84.2814), (50.0, 0.0, -82.7485), 1.0000),
                 ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669), ((50.0, 2.49, -0.001), (50.0, -2.49, 0.0009), 7.1792),
                 ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492), ((50.0, 2.5, 0.0), (50.0, 3.1736, 0.5854), 1.0000),
                 ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644), ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082)]
        for a, b, expected in pairs:
            self.assertAlmostEqual(float(color_difference.ciede2000(a, b)), expected, delta=6e-5)
            self.assertAlmostEqual(float(color_difference.ciede2000(b, a)), expected, delta=6e-5)

    def test_tone_mapping(self):
        """Black stays black, much light is white, and what was not clipped comes back."""
        self.assertEqual(color_difference.aces_8bit(np.zeros(3)).tolist(), [0, 0, 0])
        self.assertGreaterEqual(color_difference.aces_8bit(np.full(3, 1000.0)).min(), 254)
        # By hand for gray 0.6: c = 1, rows of the matrices sum to 1 (to 1e-4): (1.0245786 -
        # 0.000090537) / 1.654761 = 0.61911.
        self.assertLessEqual(abs(int(color_difference.aces_8bit(np.full(3, 0.6))[0]) - int(255 * 0.61911 ** (1 / 2.2))), 1)
        linear = np.array([[0.1, 0.2, 0.3], [0.5, 0.5, 0.5], [0.7, 0.4, 0.1], [0.05, 0.06, 0.04]])
        again = color_difference.inverse_aces((color_difference.aces_8bit(linear) + 0.5) / 255.0)
        np.testing.assert_allclose(again, linear, rtol=0.05)


class Compare(unittest.TestCase):
    def test_counts_opaque_pixels_alone(self):
        """Where either image is not opaque nothing counts; where both are, all of the difference does."""
        alpha = np.ones((32, 32))
        alpha[:, :16] = 0.5
        ours = fidelity_images.Image(np.full((32, 32, 3), 128, np.uint8), np.ones((32, 32)))
        wrong_outside = np.full((32, 32, 3), 128 / 255.0)
        wrong_outside[:, :16] = 1.0
        figures, error = fidelity_images.compare(ours, fidelity_images.Image(wrong_outside, alpha), False)
        self.assertEqual((figures["flip"], figures["delta_e"], figures["pixels"]), (0.0, 0.0, 512))
        self.assertEqual(figures["ratio"], [1.0, 1.0, 1.0])
        self.assertEqual(error.max(), 0.0)
        figures, _ = fidelity_images.compare(ours, fidelity_images.Image(wrong_outside, alpha), True)
        self.assertGreater(figures["flip"], 0.1)
        self.assertEqual(figures["pixels"], 1024)

    def test_silhouette(self):
        ours, golden = np.zeros((10, 10)), np.zeros((10, 10))
        ours[:, 2:6], golden[:, 3:8] = 1.0, 1.0
        gray = np.full((10, 10, 3), 128, np.uint8)
        figures, _ = fidelity_images.compare(fidelity_images.Image(gray, ours), fidelity_images.Image(gray / 255.0, golden), False)
        self.assertAlmostEqual(figures["silhouette"], 30 / 50)

    def test_exposure(self):
        linear = np.full((16, 16, 3), 0.2) * [1.0, 0.8, 1.2]
        ours, golden = color_difference.aces_8bit(1.1 * linear), color_difference.aces_8bit(linear)
        opaque = np.ones((16, 16))
        figures, _ = fidelity_images.compare(fidelity_images.Image(ours, opaque), fidelity_images.Image(golden / 255.0, opaque), False)
        np.testing.assert_allclose(figures["ratio"], 1.1, rtol=0.03)

    def test_scaling_averages_encoded_values(self):
        """Stripes of black and 200 become a gray of 100, not the brighter one of their mean radiance; colors are not multiplied by alpha."""
        stripes = np.zeros((32, 32, 3), np.uint8)
        stripes[:, ::2] = 200
        small = fidelity_images.resized(fidelity_images.Image(stripes, np.full((32, 32), 0.5)), (16, 8))
        self.assertEqual((small.rgb.shape, small.rgb.dtype, small.alpha.shape), ((8, 16, 3), np.uint8, (8, 16)))
        self.assertAlmostEqual(float(small.rgb[2:-2, 4:-4].mean()), 100.0, delta=1.0)
        np.testing.assert_allclose(small.alpha[2:-2, 4:-4], 0.5, atol=1 / 255)


class Scenarios(unittest.TestCase):
    def test_defaults(self):
        flags, aspect = fidelity_scenarios.scenario_flags({"name": "n", "model": "m"}, {"lightroom_14b.hdr": Path("l.hdr")}, None)
        self.assertEqual(flags, ["--orbit", "0,90,1", "--target", "0,0,0", "--fov", "45", "--env", Path("l.hdr"), "--background", "transparent"])
        self.assertEqual(aspect, 1.0)

    def test_eye_at_the_target(self):
        """Radius 0: the eye is the target, theta 90 and phi 90 look along -x."""
        flags, _ = fidelity_scenarios.scenario_flags({"orbit": {"radius": 0, "theta": 90}, "target": {"y": 2}, "renderSkybox": True}, {}, None)
        self.assertEqual(flags[:2], ["--orbit", "90,90,1"])
        np.testing.assert_allclose([float(v) for v in flags[3].split(",")], [-1.0, 2.0, 0.0], atol=1e-12)
        self.assertNotIn("--background", flags)

    def test_names_of_models(self):
        for path, name in (("../../Models/Box/glTF-Binary/Box.glb", "Box"), ("../x/Lamp/glTF/Lamp.gltf", "Lamp"), ("Duck.glb", "Duck")):
            self.assertEqual(fidelity_scenarios.model_of(path), name)

    def test_order(self):
        record = lambda name, median, failed=False: {"name": name, "failed": failed, "summary": {"flip_median": median}}
        records = [record("none", None), record("near", 0.1), record("far", 0.5), record("broken", None, True)]
        self.assertEqual([r["name"] for r in sorted(records, key=fidelity.order)], ["broken", "far", "near", "none"])

    def test_report_of_changes(self):
        for before, code, words in ((0.048, 0, "0 worse, 0 better of 1"), (0.01, 1, "worse: x: 0.010 -> 0.050"), (0.2, 0, "better: x")):
            with contextlib.redirect_stdout(io.StringIO()) as output:
                record = {"name": "x", "failed": False, "before": before, "summary": {"flip_median": 0.05}}
                self.assertEqual(fidelity.report([record], {"x": before}), code)
            self.assertIn(words, output.getvalue())

    def test_path_tracers_weigh(self):
        figures = {name: {"flip": f, "delta_e": 10 * f} for name, f in (("vray", 0.1), ("blender-cycles", 0.3), ("filament", 0.9))}
        self.assertEqual(fidelity.summarize(figures)["flip_median"], 0.2)
        self.assertEqual(fidelity.summarize({"filament": figures["filament"]})["delta_e_min"], 9.0)


class Gallery(unittest.TestCase):
    def test_names_stand_below_spheres(self):
        for scene in sorted((SCENES / "gallery").glob("*.glb")):
            if scene.stem != "material_gallery":
                places = list(gallery_images.spheres(scene))
                self.assertEqual(len(places), 7, scene)
                self.assertTrue(all(0.05 < x < 0.95 and name for x, name in places), scene)
                self.assertEqual(places, sorted(places, key=lambda place: place[0]))
                self.assertAlmostEqual(places[3][0], 0.5)


@unittest.skipUnless(PROGRAM and shutil.which("oiiotool"), "needs kindling and oiiotool")
class WholeRuns(unittest.TestCase):
    """A folder with one model that has goldens, our own render and that render darkened, one that has none, and one broken."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name) / "models"
        for name, file in (("Lit", "vertex_colors"), ("Bare", "triangle_fan")):
            (cls.folder / name / "glTF").mkdir(parents=True)
            shutil.copy(SCENES / "tiny" / f"{file}.gltf", cls.folder / name / "glTF" / f"{name}.gltf")
        (cls.folder / "Broken").mkdir()
        (cls.folder / "Broken" / "Broken.gltf").write_text("{}")
        (cls.folder / "environments").mkdir()
        subprocess.run(["oiiotool", "--pattern", "constant:color=0.6,0.6,0.6", "8x4", "3", "-o", cls.folder / "environments" / "gray.hdr"], check=True)
        (cls.folder / "render-fidelity.json").write_text(json.dumps({"scenarios": [
            {"name": "own-Lit", "model": "Models/Lit/glTF/Lit.gltf", "lighting": "gray.hdr", "orbit": {"radius": 3}, "dimensions": {"height": 384}},
            {"name": "own-Absent", "model": "Models/Absent/glTF/Absent.gltf"}]}))
        cls.run_program("--only", "own-Lit", "--images", cls.folder / "out")
        goldens = cls.folder / "Lit" / "goldens" / "own-Lit"
        goldens.mkdir(parents=True)
        shutil.copy(cls.folder / "out" / "own-Lit.png", goldens / "vray-golden.png")
        subprocess.run(["oiiotool", cls.folder / "out" / "own-Lit.png", "--mulc", "0.8,0.8,0.8,1", "-o", goldens / "filament-golden.png"], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def run_program(cls, *words):
        """(exit code, output, figures)."""
        arguments = [cls.folder, "-o", cls.folder / "page.html", "--spp", "4", "--size", "64", "--oversample", "1", "--renderer", PROGRAM,
                     "--threads", "1", *words]
        sys.argv, arguments_before, output = ["fidelity.py", *map(str, arguments)], sys.argv, io.StringIO()
        try:
            with contextlib.redirect_stdout(output):
                code = fidelity.main()
        finally:
            sys.argv = arguments_before
        return code, output.getvalue(), json.loads((cls.folder / "page.json").read_text(encoding="utf-8"))

    def test_all(self):
        code, output, result = self.run_program("--jobs", "2")
        self.assertEqual(code, 1)
        self.assertIn("not rendered: Broken", output)
        self.assertEqual([s["name"] for s in result["scenarios"]], ["Broken", "own-Lit", "Bare"])
        lit = result["scenarios"][1]
        self.assertEqual(lit["goldens"]["vray"]["flip"], 0.0)
        self.assertGreater(lit["goldens"]["vray"]["pixels"], 200)
        self.assertGreater(lit["goldens"]["filament"]["flip"], 0.03)
        self.assertEqual(lit["summary"]["flip_median"], lit["goldens"]["vray"]["flip"])
        self.assertEqual(lit["aspect"], 2.0)
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        self.assertEqual(re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', page), [])
        self.assertEqual(page.count('class="golden"'), 2)
        self.assertEqual(page.count('class="ours"'), 2)
        self.assertNotIn(self.temporary.name, page)

    def test_compare(self):
        _, _, result = self.run_program("--only", "own-*")
        old = self.folder / "old.json"
        result["scenarios"][0]["summary"]["flip_median"] = -0.1
        old.write_text(json.dumps(result))
        code, output, _ = self.run_program("--only", "Lit", "--compare", old)
        self.assertEqual((code, "worse: own-Lit: -0.100 -> 0.000" in output), (1, True))

    def test_oversampled_images_have_the_size_of_goldens(self):
        _, _, plain = self.run_program("--only", "own-Lit")
        _, _, result = self.run_program("--only", "own-Lit", "--oversample", "2", "--images", self.folder / "small")
        (whole,), (small,) = plain["scenarios"], result["scenarios"]
        self.assertEqual(result["settings"]["oversample"], 2)
        self.assertEqual(fidelity_images.read(self.folder / "small" / "own-Lit.png").rgb.shape, (32, 64, 3))
        self.assertLess(small["goldens"]["vray"]["flip"], small["goldens"]["filament"]["flip"])
        self.assertGreater(small["goldens"]["vray"]["pixels"], 0.5 * whole["goldens"]["vray"]["pixels"])  # edges are blurred

    def test_wrong_name(self):
        with self.assertRaisesRegex(SystemExit, "no scenario or model of that name"):
            self.run_program("--only", "nothing")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
