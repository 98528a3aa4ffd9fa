#!/usr/bin/env python3
"""No test: takes the images of the page for renderer/view/README.md, in headless Chromium.

    page_images.py KINDLING [SCENE] [-o renderer/view/images] [--spp 64]

page.webp: a picked surface and the path of a sample, dark; false_colors.webp: light; phone.webp. The denoiser must be
installed (cmake/get_oidn.sh), and oiiotool.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from view_process import View
from webdriver import Driver

ROOT = Path(__file__).resolve().parent.parent.parent
COMPLETE = "document.querySelector('#connection').dataset.state === 'complete'"
CHOOSE = """const select = document.getElementById(arguments[0]); select.add(new Option(arguments[1], arguments[1]));
select.value = arguments[1]; select.dispatchEvent(new Event("change"));"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scene", nargs="?", default=str(ROOT / "scenes" / "interior.glb"))
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "renderer" / "view" / "images", help="folder")
    parser.add_argument("--spp", default="64", help="samples per pixel (64)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, Driver() as driver, View(os.path.abspath(options.program), options.scene) as view:
        def open_page(width, height, **more):
            browser = driver.browser(width, height, **more)
            browser.open(view.link)
            browser.wait("document.querySelector('#samples').textContent")
            time.sleep(5.0)  # the page asks for the size of its window, and a new image begins
            browser.script(CHOOSE, "spp", options.spp)
            if not browser.script("return document.querySelector('#denoise').checked"):
                browser.click("#denoise")
            return browser

        def take_image(browser, name, width=0, quality=85):
            browser.wait(COMPLETE, seconds=1200)
            time.sleep(8.0)  # the denoised image
            png = Path(folder) / "page.png"
            browser.screenshot(png)
            shrink = ["--resize", f"{width}x0"] if width else []
            subprocess.run(["oiiotool", "-q", str(png), "--ch", "R,G,B", *shrink, "--compression", f"webp:{quality}", "-o", str(options.output / name)],
                           check=True)
            print(f"{name}: {(options.output / name).stat().st_size // 1024} KiB", flush=True)

        with open_page(1280, 760) as browser:
            browser.wait(COMPLETE, seconds=1200)
            x, y, width, height = browser.box("#canvas")
            browser.pointer(("move", x + width * 0.62, y + height * 0.88, 0), "down", "up")
            browser.wait("!document.querySelector('#path-actions').hidden")
            browser.click("#path-show")
            longest = max(range(int(options.spp)), key=lambda sample: len(json.loads(view.get(f"path?x=0.62&y=0.88&sample={sample}")[2])["vertices"]))
            for sample in range(longest + 1):
                browser.wait(f"document.querySelector('#path-note').textContent.startsWith('Sample {sample} of')", seconds=120)
                if sample < longest:
                    browser.click("#path-next")
            take_image(browser, "page.webp")
            browser.click("#path-clear")
        with open_page(1280, 760, dark=False) as browser:
            browser.click("#false-color")
            take_image(browser, "false_colors.webp", 760, 60)
            browser.click("#false-color")
            view.wait_for(lambda header: not header["state"]["false_color"])
        with open_page(390, 844, touch=True) as browser:
            browser.click("#panel-toggle")
            take_image(browser, "phone.webp")
    return 0


if __name__ == "__main__":
    sys.exit(main())
