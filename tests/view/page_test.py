#!/usr/bin/env python3
"""Tests the page of `kindling view` in headless Chromium.

    page_test.py KINDLING SCENES_FOLDER [TEST...]

Skipped (exit code 77) without chromium and chromium-driver.
"""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from server_test import png_rows
from view_process import View, complete
from webdriver import Driver, browser_programs

PROGRAM, SCENES = "", Path()
COMPLETE = "document.querySelector('#connection').dataset.state === 'complete'"
SMALL = ("--size", "320x180", "--spp", "8")


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.driver = Driver()

    @classmethod
    def tearDownClass(cls):
        cls.driver.__exit__()

    def view(self, *flags, scene="cornell_box.glb", **more):
        view = View(PROGRAM, SCENES / scene, *(flags or SMALL), **more)
        self.addCleanup(view.__exit__)
        return view

    def browser(self, *size, **more):
        browser = self.driver.browser(*size, **more)
        self.addCleanup(browser.__exit__)
        return browser

    def opened(self, view, *size, **more):
        browser = self.browser(*size, **more)
        browser.open(view.link)
        self.small(browser)
        browser.wait(COMPLETE)
        return browser

    @staticmethod
    def small(browser):
        """Samples and a size that take no time."""
        browser.wait("document.querySelector('#samples').textContent")
        browser.script("for (const [id, value] of [['size', '640x360'], ['spp', '16']]) {"
                       "const select = document.getElementById(id); select.value = value; select.dispatchEvent(new Event('change')); }")
        browser.wait("document.querySelector('#size-value').textContent.startsWith('640')")

    def test_orbit_pan_dolly_and_keys(self):
        view = self.view()
        browser = self.opened(view)
        x, y, width, height = browser.box("#canvas")
        middle = (x + width / 2, y + height / 2)
        start = view.frame()[0]["camera"]

        def after(action, text):
            before = view.frame()[0]
            action()
            moved = view.wait_for(lambda h: h["version"] > before["version"] and h["frame"]["moving"])[0]
            browser.wait(COMPLETE, of=text)
            now = view.frame()[0]["state"]
            self.assertEqual(now["orbit"] is None, False, text)
            return now, moved

        now, _ = after(lambda: browser.pointer(("move", *middle, 0), "down", ("move", middle[0] + 90, middle[1] + 30, 120), "up"), "orbit")
        self.assertLess(now["orbit"][0], start["orbit"][0])
        self.assertLess(now["orbit"][1], start["orbit"][1])
        self.assertAlmostEqual(now["orbit"][2], start["orbit"][2], places=4)
        earlier = now
        now, _ = after(lambda: browser.pointer(("move", *middle, 0), "down", ("move", middle[0] + 60, middle[1], 80), "up", button=1), "pan")
        self.assertEqual(now["orbit"], earlier["orbit"])
        self.assertNotEqual(now["target"], earlier["target"])
        earlier = now
        now, _ = after(lambda: browser.wheel(*middle, -200), "dolly")
        self.assertLess(now["orbit"][2], earlier["orbit"][2])
        browser.script("document.querySelector('#canvas').focus()")
        earlier = now
        now, _ = after(lambda: browser.key("\ue014", 150), "the right arrow")
        self.assertGreater(now["orbit"][0], earlier["orbit"][0])
        earlier = now
        now, _ = after(lambda: browser.key("w", 150), "fly")
        self.assertNotEqual(now["target"], earlier["target"])
        browser.key("r")
        browser.wait("document.querySelector('#camera').value !== 'moved'")
        self.assertIsNone(view.wait_for(lambda h: h["state"]["orbit"] is None)[0]["state"]["orbit"])
        self.assertEqual(browser.messages(), [])

    def test_pick_and_focus(self):
        view = self.view()
        browser = self.opened(view)
        x, y, width, height = browser.box("#canvas")
        browser.pointer(("move", x + width * 0.5, y + height * 0.7, 0), "down", "up")
        browser.wait("document.querySelector('#pixel').textContent.includes('material')")
        self.assertIn("depth", browser.text("#pixel"))
        browser.click("#focus-here")
        header = view.wait_for(lambda h: h["state"]["focus"])[0]
        self.assertEqual(header["state"]["f_stop"], 2.8)
        browser.wait("document.querySelector('#focus-value').textContent.endsWith(' m')")
        browser.wait(COMPLETE)
        self.assertEqual(browser.messages(), [])

    def test_path_of_a_sample(self):
        view = self.view()
        browser = self.opened(view)
        x, y, width, height = browser.box("#canvas")
        self.assertTrue(browser.script("return document.querySelector('#path-actions').hidden"))
        browser.pointer(("move", x + width * 0.5, y + height * 0.8, 0), "down", "up")
        browser.wait("!document.querySelector('#path-actions').hidden")
        seen = "getComputedStyle(document.querySelector('#path')).display !== 'none'"
        self.assertFalse(browser.script(f"return {seen}"))
        browser.click("#path-show")
        browser.wait("document.querySelectorAll('#path-events li').length > 1")
        self.assertTrue(browser.script(f"return {seen}"), "the drawing is visible")
        self.assertIn("Sample 0 of pixel", browser.text("#path-note"))
        events = browser.text("#path-events")
        self.assertIn("camera", events)
        self.assertIn("surface", events)
        lines, colors = browser.script("""
            const lines = [...document.querySelectorAll("#path line:not(.below)")];
            return [lines.length, lines.map((line) => getComputedStyle(line).stroke)];""")
        answer = json.loads(view.get("path?x=0.5&y=0.8&sample=0")[2])
        self.assertEqual(lines, sum(1 for vertex in answer["vertices"] if vertex.get("way") and vertex["step"] != "camera"))
        self.assertTrue(all(color.startswith("rgb") for color in colors), colors)
        # The path is that of the replay on the command line.
        where = ",".join(str(n) for n in answer["pixel"])
        words = shlex.split(view.frame()[0]["command"])[1:]
        replay = subprocess.run([PROGRAM, *words[:words.index("-o")], "--pixel", where, "--sample", "0", "-q"], check=True, capture_output=True, text=True).stdout
        self.assertEqual(len(replay.splitlines()), 2 + len(answer["vertices"]), replay)
        browser.click("#path-next")
        browser.wait("document.querySelector('#path-note').textContent.startsWith('Sample 1 of')")
        browser.wheel(x + width / 2, y + height / 2, -200)
        browser.wait(f"!({seen}) && document.querySelectorAll('#path line').length === 0", of="a moved camera hides the path")
        self.assertEqual(browser.messages(), [])

    def test_copied_command_renders_the_image(self):
        with tempfile.TemporaryDirectory() as folder:
            view = self.view(cwd=folder)
            browser = self.opened(view)
            x, y, width, height = browser.box("#canvas")
            browser.pointer(("move", x + width / 2, y + height / 2, 0), "down", ("move", x + width / 2 - 50, y + height / 2, 60), "up")
            view.wait_for(lambda h: h["state"]["orbit"] and complete(h))
            browser.wait(COMPLETE)
            browser.click("#copy")
            browser.wait("document.querySelector('#command').open && document.querySelector('#command-note').textContent")
            self.assertIn("Copied", browser.text("#command-note"))
            line = browser.script("return document.querySelector('#command-text').value")
            words = shlex.split(line)
            subprocess.run([PROGRAM, *words[1:], "-o", "copied.png", "-q"], check=True, cwd=folder, stdout=subprocess.DEVNULL)
            shown = view.get("save.png")[2]
            self.assertEqual(png_rows((Path(folder) / "copied.png").read_bytes()), png_rows(shown), line)

    def test_settings_reach_the_server(self):
        view = self.view()
        browser = self.opened(view)
        for name, value, member, expected in (("shown", "normal", "shown", "normal"), ("shown", "beauty", "shown", "beauty"), ("view", "AgX", "view", "AgX"),
                                              ("exposure", "1.5", "exposure", 1.5), ("fov", "60", "fov", 60)):
            browser.script("const input = document.getElementById(arguments[0]); input.value = arguments[1];"
                           "input.dispatchEvent(new Event('input', { bubbles: true })); input.dispatchEvent(new Event('change', { bubbles: true }))", name, value)
            view.wait_for(lambda h, member=member, expected=expected: h["state"][member] == expected, seconds=20)
        browser.click("#false-color")
        browser.wait("!document.querySelector('#legend').hidden")
        self.assertEqual(browser.messages(), [])

    def test_reload_and_two_browsers(self):
        view = self.view()
        first, second = self.opened(view), self.opened(view)
        x, y, width, height = first.box("#canvas")
        first.pointer(("move", x + width / 2, y + height / 2, 0), "down", ("move", x + width / 2 + 70, y + height / 2, 60), "up")
        second.wait("document.querySelector('#camera').value === 'moved'", of="the second browser follows the first")
        second.wait(COMPLETE)
        orbit = view.frame()[0]["state"]["orbit"]
        first.open(view.link)
        first.wait("document.querySelector('#camera').value === 'moved'", of="the camera after a reload")
        first.wait(COMPLETE)
        self.assertEqual(view.frame()[0]["state"]["orbit"], orbit)

    def test_wrong_token(self):
        view = self.view()
        browser = self.browser()
        browser.open(view.link.replace(view.token, "0" * 32))
        self.assertIn("not valid", browser.text("body"))

    def test_lost_connection(self):
        view = self.view()
        browser = self.opened(view)
        view.process.send_signal(signal.SIGSTOP)
        view.process.send_signal(signal.SIGCONT)
        browser.wait(COMPLETE)
        browser.devtools("Network.enable")
        browser.devtools("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=-1, uploadThroughput=-1)
        browser.script("document.querySelector('#false-color').click()")
        browser.wait("document.querySelector('#connection').dataset.state === 'lost'", seconds=30)
        browser.devtools("Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=-1, uploadThroughput=-1)
        browser.wait(COMPLETE, seconds=30, of="the connection comes back")
        browser.wait("!document.querySelector('#false-color').checked", of="what was lost is not shown")
        view.interrupt()
        browser.wait("document.querySelector('#connection').dataset.state === 'lost'", seconds=30)

    def test_memory_is_bounded(self):
        """A page that shows hundreds of images holds no more memory than after the first ones."""
        view = self.view("--size", "320x180", "--spp", "8")
        browser = self.opened(view)
        browser.script("document.querySelector('#canvas').focus()")

        def used():
            browser.devtools("HeapProfiler.collectGarbage")
            return browser.script("return performance.memory.usedJSHeapSize"), resident(view.process.pid)

        browser.key("\ue014", 3000)
        page_before, server_before = used()
        first = view.frame()[0]["version"]
        for _ in range(4):
            browser.key("\ue014", 4000)
        frames = view.frame()[0]["version"] - first
        page_after, server_after = used()
        self.assertGreater(frames, 50)
        self.assertLess(page_after - page_before, 3e6, "bytes of the page")
        self.assertLess(server_after - server_before, 60e6, "bytes of the server")

    def test_phone_width_and_names(self):
        view = self.view()
        browser = self.opened(view, 390, 844, touch=True)
        self.assertLessEqual(browser.script("return document.documentElement.scrollWidth"), 390)
        x, y, width, height = browser.box("#canvas")
        before = view.frame()[0]["camera"]["orbit"]
        browser.pointer(("move", x + width / 2, y + height / 2, 0), "down", ("move", x + width / 2 + 60, y + height / 2, 100), "up", kind="touch")
        moved = view.wait_for(lambda h: h["state"]["orbit"])[0]["state"]["orbit"]
        self.assertNotEqual(moved[0], before[0])
        nameless = browser.script("""
            return [...document.querySelectorAll("button, a, input, select, textarea, canvas, dialog, [role]")].filter((element) =>
              !(element.getAttribute("aria-label") || element.getAttribute("aria-labelledby") || element.labels?.length ||
                element.textContent.trim() || element.getAttribute("role") === "alert" || element.getAttribute("role") === "status")).map((element) => element.outerHTML)""")
        self.assertEqual(nameless, [])


def resident(process_id):
    with open(f"/proc/{process_id}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


if __name__ == "__main__":
    if None in browser_programs():
        print("skipped: chromium and chromium-driver are not installed")
        sys.exit(77)
    PROGRAM, SCENES = os.path.abspath(sys.argv[1]), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
