#!/usr/bin/env python3
"""Tests of bench/equal_noise.py on images with known noise, and whole runs on a tiny scene.

test_equal_noise.py BENCH_FOLDER SCENES_FOLDER [kindling]
"""
# SPDX-License-Identifier: Apache-2.0
import array
import io
import json
import random
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom
from pathlib import Path
from unittest import mock

BENCH, SCENES = Path(sys.argv[1]), Path(sys.argv[2])
PROGRAM = sys.argv[3] if len(sys.argv) > 3 else ""
sys.path.insert(0, str(BENCH))
import equal_noise
import image_files
import pixels
import renderers


def constant(value, size=64):
    return pixels.Image(size, size, array.array("f", [value]) * (size * size * 3))


def noisy(value, deviation, seed, size=64):
    generator = random.Random(seed)
    return pixels.Image(size, size, array.array("f", (generator.gauss(value, deviation) for _ in range(size * size * 3))))


class Noise(unittest.TestCase):
    """Gaussian noise of standard deviation 0.5 around 2, as a relative variance 0.0625 / 1.01."""
    EXPECTED = 0.25 / 4.0 / 1.01
    # The relative standard error of a variance from n numbers is sqrt(2 / n); an image has 64 x 64
    # x 3 numbers.
    TOLERANCE = 4.5 * (2 / (3 * 64 * 64 * 3)) ** 0.5

    def test_noise_between_seeds(self):
        images = [noisy(2.0, 0.5, seed) for seed in range(4)]
        found = pixels.rel_mse(pixels.noise(images, constant(2.0)), dropped=0.0)
        self.assertLess(abs(found / self.EXPECTED - 1.0), self.TOLERANCE)

    def test_bias_is_error_but_not_noise(self):
        images = [noisy(3.0, 0.5, seed) for seed in range(4)]
        noise = pixels.rel_mse(pixels.noise(images, constant(2.0)), dropped=0.0)
        error = pixels.rel_mse(pixels.error(images, constant(2.0)), dropped=0.0)
        self.assertLess(abs(noise / self.EXPECTED - 1.0), self.TOLERANCE)
        bias = 1.0 / 4.0 / 1.01
        self.assertLess(abs(error / (self.EXPECTED + bias) - 1.0), 4 * self.TOLERANCE)

    def test_worst_pixels_are_dropped(self):
        images = [constant(1.0), constant(1.0)]
        images[0].rgb[0:9] = array.array("f", [1e6] * 9)  # three of 4096 pixels
        ascending = pixels.noise(images, constant(1.0))
        self.assertEqual(pixels.rel_mse(ascending), 0.0)
        self.assertGreater(pixels.rel_mse(ascending, dropped=0.0), 1e6)


    def test_differences_between_renderers_are_more_than_their_noise(self):
        """Images around 2 and 3 differ by a half."""
        dark, bright = ([noisy(value, 0.5, seed) for seed in range(first, first + 2)] for value, first in ((2.0, 0), (3.0, 10)))
        found = pixels.difference(dark, bright, constant(2.0)) ** 2
        # A difference of two means has an expectation of 1 and a variance v of 0.25, its square
        # one of 4 v + 2 v^2.
        deviation = (4 * 0.25 + 2 * 0.25 ** 2) ** 0.5 / 4.0 / 1.01 / (64 * 64 * 3) ** 0.5
        self.assertLess(abs(found - 1.0 / 4.0 / 1.01), 5 * deviation)
        self.assertLess(pixels.difference(dark, [noisy(2.0, 0.5, seed) for seed in (20, 21)], constant(2.0)) ** 2, 5 * deviation)


class ImageFiles(unittest.TestCase):
    """Files that are read without oiiotool."""

    def read(self, data):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "image"
            path.write_bytes(data)
            return image_files.read(path)

    @staticmethod
    def exr(compression, chunks, flags=0):
        """A file of 2 x 1 pixels: halves named B and R, floats named G."""
        attributes = [("channels", "chlist", b"".join(name + b"\0" + struct.pack("<iIii", kind, 0, 1, 1) for name, kind in
                                                      ((b"B", 1), (b"G", 2), (b"R", 1))) + b"\0"),
                      ("compression", "compression", bytes([compression])), ("dataWindow", "box2i", struct.pack("<4i", 3, 5, 4, 5))]
        header = b"\x76\x2f\x31\x01" + struct.pack("<I", 2 | flags) + b"".join(
            f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value for name, kind, value in attributes) + b"\0"
        return header + struct.pack("<Q", len(header) + 8) + struct.pack("<ii", 5, len(chunks)) + chunks

    def test_exr(self):
        row = struct.pack("<2e2f2e", 0.5, 2.0, 1e-3, 7.0, 0.25, 1.0)
        self.assertEqual(self.read(self.exr(0, row))[:3], (2, 1, 3))
        expected = array.array("f", [0.25, 1e-3, 0.5, 1.0, 7.0, 2.0])
        self.assertEqual(self.read(self.exr(0, row))[3], expected)
        self.assertEqual(self.read(self.exr(3, row))[3], expected)  # compression would make it longer

    def test_pfm(self):
        file = b"PF\n1 2\n-1\n" + struct.pack("<6f", 4, 5, 6, 1, 2, 3)  # the lower row first
        self.assertEqual(self.read(file), (1, 2, 3, array.array("f", [1, 2, 3, 4, 5, 6])))

    def test_other_files(self):
        for data, message in ((b"GIF89a", "neither EXR nor PFM"), (self.exr(4, b""), "compression 4"), (self.exr(0, b"", 0x200), "of tiles"),
                              (b"PF\n1 2\n1\n", "big-endian"), (b"PF\n1 2\n-1\n" + bytes(12), "ends early")):
            with self.assertRaisesRegex(image_files.Unsupported, message + ".*oiiotool"):
                self.read(data)


class Reporting(unittest.TestCase):
    """A run of two settings: the second as fast, with half the noise. Noise falls as 1 / samples, time grows with them."""

    def setUp(self):
        rows = []
        for name, factor in (("plain", 1.0), ("better", 0.5)):
            for spp in (4, 16):
                rows.append({"setting": name, "spp": spp, "mpaths_per_s": 1.0, "path_tracing_s": spp * 0.1, "peak_mb": 50.0,
                             "noise": factor / spp, "noise_x_s": factor * 0.1, "first_sample_s": 0.2})
        scene = {"name": "a <b>", "rows": rows, "reference": None, "images": [("plain, 4 samples", "plain", 4, b"PNG")]}
        self.result = {"threads": 2, "seeds": 3, "clock": "wall", "common_flags": [], "settings": {"plain": [], "better": ["--x"]}, "scenes": [scene]}

    def test_table(self):
        table = equal_noise.table_of(self.result)
        lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()]
        self.assertEqual(lines[2][:8], ["a <b>", "plain", "4", "1", "0.25", "0.1", "1.000", ""])
        self.assertEqual(lines[5][:8], ["a <b>", "better", "16", "1", "0.03125", "0.05", "0.500", "-1.00"])
        self.assertEqual(lines[6][:7], ["geometric mean", "better", "", "", "", "", "0.500"])
        self.assertEqual(len({len(line) for line in lines}), 1)

    def test_page_is_complete_in_itself(self):
        page = equal_noise.equal_noise_page.page(self.result, equal_noise.table_of(self.result))
        plots = re.findall(r"<svg.*?</svg>", page, re.S)
        self.assertEqual(len(plots), 2)
        for plot in plots:
            self.assertEqual(xml.dom.minidom.parseString(plot).getElementsByTagName("circle").length, 4)
        self.assertIn("data:image/png;base64,UE5H", page)
        self.assertIn("a &lt;b&gt;", page)
        for word in ("http:", "https:", "<script", "<link"):
            self.assertNotIn(word, page)


@unittest.skipUnless(PROGRAM, "kindling is not built")
class Program(unittest.TestCase):
    def run_script(self, *arguments):
        return subprocess.run([sys.executable, str(BENCH / "equal_noise.py"), "--kindling", PROGRAM, *map(str, arguments)],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def test_images_read_with_and_without_oiiotool_are_equal(self):
        with tempfile.TemporaryDirectory() as folder:
            for flags in (["--exr-float"], ["--aov", "depth,normal"]):
                image = Path(folder) / "image.exr"
                subprocess.run([PROGRAM, "render", SCENES / "cornell_box.glb", "--size", "37x21", "--spp", "1", "-o", image, "--quiet", *flags],
                               check=True, stdout=subprocess.DEVNULL)
                self.assertEqual(pixels.read_without_oiiotool(image), pixels.read_rgb(image), flags)

    def test_two_settings_of_a_tiny_scene(self):
        with tempfile.TemporaryDirectory() as folder:
            files = {kind: Path(folder) / f"out.{kind}" for kind in ("json", "html", "markdown")}
            done = self.run_script(SCENES / "cornell_box.glb", "--setting", "full=", "--setting", "dim=--clamp-direct 0 --clamp-indirect 0",
                                   "--spp", "1,4", "--seeds", "2", "--size", "24x16", "--reference-spp", "8", "--threads", "1", "--clock", "cpu",
                                   *(part for kind, path in files.items() for part in (f"--{kind}", path)))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(files["markdown"].read_text(), done.stdout)
            result = json.loads(files["json"].read_text())
            page = files["html"].read_text()
        self.assertEqual(list(result["settings"]), ["full", "dim"])
        rows = {(row["setting"], row["spp"]): row for row in result["scenes"][0]["rows"]}
        self.assertEqual(len(rows), 4)
        for row in rows.values():
            self.assertGreater(row["path_tracing_s"], 0.0)
            self.assertEqual(len(row["path_tracing_s_of_runs"]), 2)
        self.assertGreater(rows["full", 1]["noise"], rows["full", 4]["noise"])
        # Flags reach the renderer: without lit surfaces there is little noise, but a large error.
        self.assertLess(rows["dim", 4]["noise_all_pixels"], rows["full", 4]["noise_all_pixels"])
        self.assertLess(max(rows["dim", 4]["mean_against_reference"]), -0.3)
        self.assertEqual(page.count("data:image/png;base64,"), 5)  # two settings, two counts, the reference
        self.assertEqual(len(re.findall("<svg", page)), 2)

    def test_peers_are_left_out_of_scenes_that_they_cannot_render(self):
        """Mitsuba fails on the second seed, LuxCore's image is not finite, that of Cycles differs from Kindling's."""
        def render(name, job, spp, seed, stem):
            if name == "mitsuba" and seed == 2:
                raise renderers.Failed("requires EXT_unknown")
            image = Path(f"{stem}.pfm")
            values = [0.25 * seed] * 5 + [float("nan") if name == "luxcore" else 0.5]
            image.write_bytes(b"PF\n1 2\n-1\n" + struct.pack("<6f", *values))
            return renderers.Run(seed, image, 1.0, 1.0, 1.0, 10.0, 1.0, 1.0)

        def render_kindling(kindling, job, spp, seed, stem, flags):
            run = render("kindling", job, spp, seed, stem)
            run.image.write_bytes(b"PF\n1 2\n-1\n" + struct.pack("<6f", *[2.0] * 6))
            return run

        names = ["cycles", "mitsuba", "luxcore"]
        job = renderers.Job(name="box", scene=SCENES / "cornell_box.glb", size_px=(1, 2), max_bounces=8)
        options = equal_noise.parse_arguments([str(SCENES), "--peers", ",".join(names), "--seeds", "2"])
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(equal_noise.peers, "run", render), \
                mock.patch.object(renderers, "run_kindling", render_kindling), \
                mock.patch("sys.stderr", new_callable=io.StringIO) as messages:
            settings = options.setting + [equal_noise.Setting(name, []) for name in names]
            scene = equal_noise.measure_scene(job, settings, options, None, None, Path(folder))
        self.assertEqual([row["setting"] for row in scene["rows"]], ["kindling", "cycles"])
        self.assertNotIn("difference", scene["rows"][0])
        self.assertGreater(scene["rows"][1]["difference"], 0.5)
        self.assertRegex(messages.getvalue(), "box: cycles: its image differs from that of kindling by [0-9]+ %: look")
        table = equal_noise.table_of({"settings": {"kindling": [], "cycles": []}, "scenes": [scene]})
        self.assertIn("| image differs |", table)
        self.assertIn("box: mitsuba: left out: requires EXT_unknown", messages.getvalue())
        self.assertIn("box: luxcore: left out: its image has values that are not finite", messages.getvalue())

    def test_wrong_input(self):
        tiny = SCENES / "tiny" / "skin.gltf"
        for arguments, message in (
                ([tiny, "--setting", "--accel kdtree"], "is not NAME=FLAGS"),
                ([tiny, "--setting", "a=", "--setting", "a="], "two are called a"),
                ([tiny, "--cycles", "--clock", "cpu"], "--clock wall"),
                ([tiny, "--peers", "cycles,povray"], "no renderer 'povray'"),
                ([tiny, "--peers", "mitsuba_cuda", "--clock", "cpu"], "use --clock wall"),
                ([tiny, "--cycles", "--peers", "cycles"], "give one of them"),
                ([tiny, "--setting", "mitsuba="], "that is no other renderer"),
                ([tiny, "--denoise"], "add --reference-spp"),
                ([tiny, "--denoise", "--reference-spp", "64", "--peers", "cycles"], "--peers: has no meaning with --denoise"),
                ([tiny, "--denoise", "--reference-spp", "64", "--html", "a.html"], "--html: has no meaning with --denoise"),
                ([tiny, "--strips", "folder"], "--strips: has no meaning without --denoise"),
                ([tiny, "--spp", "4,0"], "is not a list of numbers"),
                (["nowhere.glb"], "nowhere.glb: no such file"),
                ([tiny, tiny], "two scenes are called skin"),
                ([tiny, "--only", "skim"], "no scene skim"),
                ([tiny, "--size", "8x8", "--setting", "a=--no-such-flag"], "--no-such-flag")):
            done = self.run_script(*arguments)
            self.assertNotEqual(done.returncode, 0, arguments)
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_broken_tables(self):
        for text in ("{", '{"a": {"hdr": null}}'):
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "scenes.json").write_text(text)
                done = self.run_script(folder)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("scenes.json", done.stderr)
            self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
