#!/usr/bin/env python3
"""Measures how fast `kindling view` answers, in headless Chromium.

    measure_page.py KINDLING SCENE... [--size 320x180] [--flags "..."] [--seconds 5] [--inputs 10] [--minutes 0]

For each scene: the time from opening the page to its first image; images per second while the camera orbits, with the sizes they
have; the time from a key press, while the whole image renders, to the first image of the moved camera on the page. With --minutes the
memory of page, browser tab and server instead, of a page that stays open for this time: the camera moves in half of each ten seconds.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import shlex
import statistics
import time

from view_process import View
from webdriver import Driver

LISTEN = """
window.frames_seen = [];
document.addEventListener("frame", ({ detail }) => { if (detail.frame) frames_seen.push({ at: performance.now(), image: detail.image,
  moving: detail.frame.moving, size: detail.frame.size, orbit: String(detail.state.orbit) }); });
document.querySelector("#canvas").focus();"""
PRESS = """
const event = (kind) => document.querySelector("#canvas").dispatchEvent(new KeyboardEvent(kind, { key: "ArrowRight", bubbles: true }));
if (arguments[0]) { frames_seen.length = 0; window.pressed = performance.now(); event("keydown"); } else event("keyup");"""


def measure(driver, program, scene, options):
    with View(program, scene, "--size", options.size, *shlex.split(options.flags)) as view, driver.browser() as browser:
        time.sleep(options.wait)
        browser.open(view.link)
        browser.wait("window.first_image ?? (document.querySelector('#samples').textContent && (window.first_image = performance.now()))")
        first = browser.script("return performance.getEntriesByName('first-image')[0]?.startTime ?? window.first_image")
        width, height = options.size.split("x")
        time.sleep(1.0)  # the page has asked for the size of its window
        browser.script("const s = document.querySelector('#size'); s.add(new Option(arguments[0], arguments[0])); s.value = arguments[0];"
                       "s.dispatchEvent(new Event('change'))", options.size)
        browser.wait(f"document.querySelector('#size-value').textContent === '{width} × {height}' && "
                     "/rendering|complete/.test(document.querySelector('#connection').dataset.state)", seconds=120)
        browser.script(LISTEN)
        delays = []
        for _ in range(options.inputs):
            time.sleep(1.0)
            browser.script(PRESS, True)
            browser.wait("frames_seen.some((frame) => frame.moving)")
            browser.script(PRESS, False)
            delays.append(browser.script("return frames_seen.find((frame) => frame.moving).at - pressed"))
        browser.script(PRESS, True)
        time.sleep(options.seconds)
        seen = browser.script("return { now: performance.now() - pressed, frames: frames_seen.filter((frame) => frame.moving) }")
        browser.script(PRESS, False)
        images = {frame["image"] for frame in seen["frames"]}
        pixels = [frame["size"][0] * frame["size"][1] for frame in seen["frames"]]
        print(f"{scene}: first image {first:.0f} ms; {1000 * len(images) / seen['now']:.1f} images/s of {statistics.median(pixels) ** 0.5 * 4 / 3:.0f} pixels' width (16:9); "
              f"input answered in {statistics.median(delays):.0f} ms (median of {len(delays)}, slowest {max(delays):.0f})", flush=True)


def resident_mb(process_id):
    with open(f"/proc/{process_id}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6


def measure_memory(driver, program, scene, options):
    with View(program, scene, "--size", options.size, *shlex.split(options.flags)) as view, driver.browser() as browser:
        browser.open(view.link)
        browser.wait("document.querySelector('#samples').textContent")
        browser.script(LISTEN)
        print(f"{scene}: minutes, images so far, MB of the page's heap, nodes of its document, MB of the server")
        start, images = time.monotonic(), 0
        while time.monotonic() - start < 60 * options.minutes:
            for _ in range(3):
                browser.script(PRESS, True)
                time.sleep(5.0)
                browser.script(PRESS, False)
                images += browser.script("return new Set(frames_seen.map((frame) => frame.image)).size")
                time.sleep(5.0)
            browser.devtools("HeapProfiler.collectGarbage")
            heap = browser.script("return performance.memory.usedJSHeapSize") / 1e6
            nodes = browser.script("return document.querySelectorAll('*').length")
            print(f"{(time.monotonic() - start) / 60:5.1f} {images:7d} {heap:7.2f} {nodes:5d} {resident_mb(view.process.pid):8.1f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--flags", default="", help="more flags of kindling view")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--inputs", type=int, default=10)
    parser.add_argument("--wait", type=float, default=3.0, help="seconds between the link and the page")
    parser.add_argument("--minutes", type=float, default=0.0, help="measure memory for this time instead")
    options = parser.parse_args()
    with Driver() as driver:
        for scene in options.scenes:
            (measure_memory if options.minutes > 0 else measure)(driver, options.program, scene, options)


if __name__ == "__main__":
    main()
