#!/usr/bin/env python3
"""Tests the server of `kindling view`, with clients that misbehave, and its command lines.

    server_test.py KINDLING SCENES_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import shlex
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zlib
from pathlib import Path

from view_process import View, complete

PROGRAM, SCENES = "", Path()


def png_rows(data):
    """The pixels of an 8-bit PNG with its filters undone, as width, height and bytes."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, _, color = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    channels = {2: 3, 6: 4}[color]
    raw, stride, rows = zlib.decompress(packed), width * channels, []
    above = bytearray(stride)
    for y in range(height):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left = line[i - channels] if i >= channels else 0
            corner = above[i - channels] if i >= channels else 0
            if kind == 1:
                line[i] = (line[i] + left) & 255
            elif kind == 2:
                line[i] = (line[i] + above[i]) & 255
            elif kind == 3:
                line[i] = (line[i] + (left + above[i]) // 2) & 255
            elif kind == 4:
                p = left + above[i] - corner
                nearest = min((abs(p - left), 0, left), (abs(p - above[i]), 1, above[i]), (abs(p - corner), 2, corner))[2]
                line[i] = (line[i] + nearest) & 255
        rows.append(bytes(line))
        above = line
    return width, height, b"".join(rows)


class Gate(unittest.TestCase):
    """Requests that are refused, and what they cost."""

    @classmethod
    def setUpClass(cls):
        cls.view = View(PROGRAM, SCENES / "cornell_box.glb", "--size", "64x48", "--spp", "4")

    @classmethod
    def tearDownClass(cls):
        cls.view.__exit__()

    def status(self, target=None, **more):
        return self.view.request(target or self.view.path, **more)[0]

    def test_page_and_its_files(self):
        for name, kind in (("", "text/html"), ("view.css", "text/css"), ("main.js", "text/javascript")):
            status, headers, body = self.view.get(name)
            self.assertEqual(status, 200, name)
            self.assertTrue(headers["Content-Type"].startswith(kind))
            self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
            self.assertNotIn(b"http://", body.replace(b"http://www.w3.org", b""), "nothing from elsewhere")
        self.assertEqual(self.status("/" + self.view.token), 301)

    def test_nothing_of_the_disc(self):
        for name in ("../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "cornell_box.glb", "..%2fpasswd", "page/main.js", "//etc/passwd"):
            self.assertEqual(self.view.get(name)[0], 404, name)

    def test_wrong_tokens(self):
        token = self.view.token
        for wrong in ("", "x", token[:-1], token + "0", token[::-1], "0" * 32, token.upper() + " "):
            if wrong == token:
                continue
            for name in ("", "frame?after=0", "scene", "save.png"):
                status = self.status(f"/{wrong.strip()}/{name}")
                self.assertEqual(status, 403, wrong)
        self.assertEqual(self.status("/"), 403)

    def test_hosts(self):
        for host in ("localhost", "localhost:1", "127.0.0.1:9999", "[::1]:80", "LOCALHOST:8600"):
            self.assertEqual(self.status(headers={"Host": host}), 200, host)
        for host in ("evil.example", "evil.example:8600", "localhost.evil.example", "127.0.0.1.evil.example", "", "192.168.1.2", "127.evil.example"):
            self.assertEqual(self.status(headers={"Host": host}), 421, host)

    def test_origins(self):
        host = f"127.0.0.1:{self.view.port}"
        self.assertEqual(self.status(headers={"Origin": f"http://{host}"}), 200)
        self.assertEqual(self.status(headers={"Host": "localhost:9000", "Origin": "http://localhost:9000"}), 200)
        for origin in ("http://evil.example", "null", "http://localhost:1", f"https://{host}", f"http://{host}.evil.example"):
            self.assertEqual(self.status(headers={"Origin": origin}), 403, origin)
        self.assertEqual(self.status(headers={"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"}), 403)

    def test_methods_and_bodies(self):
        self.assertEqual(self.status(method="PUT"), 405)
        change = self.view.path + "change"
        as_json = {"Content-Type": "application/json"}
        self.assertEqual(self.status(change, method="POST", body="{}"), 415)
        self.assertEqual(self.status(change, method="POST", body="{}", headers={**as_json, "Content-Encoding": "gzip"}), 411)
        self.assertEqual(self.status(change, method="POST", body="{}", headers=as_json), 200)
        for body in ("", "[]", "{", '{"orbit":[1,2]}', '{"orbit":[1e400,0,1]}', '{"size":[1,1]}', '{"size":[100000,100000]}',
                     '{"spp":0}', '{"unknown":1}', '{"shown":"nothing"}', '{"fov":"wide"}', '{"camera":' + "[" * 5000 + "]" * 5000 + "}"):
            self.assertEqual(self.status(change, method="POST", body=body, headers=as_json), 400, body[:40])
        self.assertEqual(self.status(self.view.path + "pixel?x=2&y=0"), 400)

    def test_sizes(self):
        self.assertEqual(self.status(self.view.path + "x" * 2000), 414)
        for request in (f"POST {self.view.path}change HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                        "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n".encode(),
                        b"GET / HTTP/1.1\r\n" + b"X: " + b"y" * 100000,  # one header without an end
                        b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 20000,     # many headers
                        b"GET /" + b"x" * 100000,                        # a request line without an end
                        f"POST {self.view.path}change HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                        f"Content-Length: 10000000\r\n\r\n".encode() + b" " * 200000):
            with socket.create_connection((self.view.host, self.view.port), timeout=10) as client:
                try:
                    client.sendall(request)
                    answer = client.recv(65536)
                except (ConnectionResetError, BrokenPipeError):
                    answer = b""
                self.assertFalse(answer.startswith(b"HTTP/1.1 2"), answer[:100])
        self.assertEqual(self.status(), 200)

    def test_slow_clients_are_dropped(self):
        """A byte now and then does not hold a connection, and its neighbors do not wait."""
        with socket.create_connection((self.view.host, self.view.port), timeout=20) as client:
            start = time.monotonic()
            try:
                for byte in f"GET {self.view.path} HTTP/1.1\r\nHost: localhost\r\nX-Slow: yyyyyyyyyyyyyyyyyyyyyyyyyyyyyyyyyyyy":
                    client.sendall(byte.encode())
                    time.sleep(0.1)
                    self.assertEqual(self.status(), 200)
            except (ConnectionResetError, BrokenPipeError):
                pass
            client.settimeout(10)
            try:
                self.assertFalse(client.recv(1000).startswith(b"HTTP/1.1 200"))
            except ConnectionResetError:
                pass
            self.assertLess(time.monotonic() - start, 12)

    def test_many_connections(self):
        """Those beyond the limit are closed; later ones are served again."""
        clients = [socket.create_connection((self.view.host, self.view.port), timeout=10) for _ in range(80)]
        time.sleep(0.3)
        for client in clients:
            client.close()
        time.sleep(0.3)
        self.assertEqual(self.status(), 200)


class Frames(unittest.TestCase):
    """Images, and what renders them again."""

    def test_refines_and_moves(self):
        with View(PROGRAM, SCENES / "cornell_box.glb", "--size", "96x64", "--spp", "16") as view:
            header, jpeg = view.wait_for(complete)
            self.assertEqual(header["frame"]["samples"], 16)
            self.assertTrue(jpeg.startswith(b"\xff\xd8"))
            same, nothing = view.frame(header["version"] - 1, header["image"])
            self.assertEqual((same["image"], nothing), (header["image"], b""), "an image that the page has is not sent again")
            theta, phi, radius = header["camera"]["orbit"]
            self.assertEqual(view.change(orbit=[theta + 10, phi, radius], target=header["camera"]["target"], fov=header["camera"]["fov"])[0], 200)
            moved, other = view.wait_for(lambda h: h["frame"]["moving"] and h["version"] > header["version"])
            self.assertNotEqual(other, jpeg)
            self.assertAlmostEqual(moved["state"]["orbit"][0], theta + 10, places=3)
            view.wait_for(lambda h: complete(h) and h["version"] > moved["version"])

    def test_pixels_and_surfaces(self):
        with View(PROGRAM, SCENES / "cornell_box.glb", "--size", "64x64", "--spp", "4") as view:
            view.wait_for(complete)
            values = json.loads(view.get("pixel?x=0.1&y=0.5")[2])
            self.assertEqual(values["pixel"], [6, 32])
            self.assertTrue(values["surface"]["material"])
            self.assertGreater(values["surface"]["depth_m"], 0)
            red, green, _ = values["surface"]["values"]["base color"]
            self.assertNotAlmostEqual(red, green, places=2, msg="the walls at the sides are colored")

    def test_two_pages_share_the_state(self):
        with View(PROGRAM, SCENES / "cornell_box.glb", "--size", "48x32", "--spp", "2") as view:
            header, _ = view.wait_for(complete)
            seen = []
            page = threading.Thread(target=lambda: seen.append(view.frame(header["version"])))
            page.start()
            view.change(exposure=1.5)
            page.join(timeout=20)
            self.assertEqual(seen[0][0]["state"]["exposure"], 1.5)

    def test_changed_file_is_loaded_again(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "scene.glb"
            shutil.copy(SCENES / "cornell_box.glb", scene)
            with View(PROGRAM, scene, "--size", "48x32", "--spp", "2") as view:
                header, jpeg = view.wait_for(complete)
                scene.write_bytes(b"broken")
                view.wait_for(lambda h: h["error"], seconds=20)
                self.assertEqual(view.frame()[1], jpeg, "the last image stays")
                shutil.copy(SCENES / "material_grid.glb", scene)
                changed, other = view.wait_for(lambda h: h["scene"] > header["scene"] and complete(h), seconds=120)
                self.assertNotEqual(other, jpeg)
                self.assertEqual(changed["error"], "")


class Commands(unittest.TestCase):
    """The command line of a frame renders its pixels, to the bit."""

    def check(self, view, folder):
        header, _ = view.wait_for(complete)
        line = header["command"]
        words = shlex.split(line)
        self.assertEqual(words[:2], ["kindling", "render"])
        status, headers, shown = view.get("save.png")
        self.assertEqual(status, 200)
        self.assertIn("attachment", headers["Content-Disposition"])
        subprocess.run([PROGRAM, *words[1:], "-o", "line.png", "-q"], check=True, cwd=folder, stdout=subprocess.DEVNULL)
        self.assertEqual(png_rows((Path(folder) / "line.png").read_bytes()), png_rows(shown), line)
        return header

    def test_cameras_lenses_and_display(self):
        with tempfile.TemporaryDirectory() as folder, View(
                PROGRAM, SCENES / "cornell_box.glb", "--size", "72x48", "--spp", "8", "--max-bounces", "3", "--env-color", "0.1,0.2,0.3", cwd=folder) as view:
            header = self.check(view, folder)
            theta, phi, radius = header["camera"]["orbit"]
            view.change(orbit=[-theta - 7.123456789, phi - 11.1, radius * 0.77], target=header["camera"]["target"], fov=37.7)
            view.wait_for(lambda h: h["frame"]["moving"])
            self.check(view, folder)
            depth = json.loads(view.get("pixel?x=0.4&y=0.6")[2])["surface"]["depth_m"]
            view.change(f_stop=1.4, focus=depth, exposure=-1.3, view="AgX", guiding=False)
            view.wait_for(lambda h: h["state"]["f_stop"] == 1.4 and h["frame"]["moving"])
            header = self.check(view, folder)
            self.assertIn("--guiding off", header["command"])
            self.assertIn("--max-bounces 3", header["command"])
            view.change(spp=5, size=[80, 40])
            view.wait_for(lambda h: h["frame"]["moving"])
            self.check(view, folder)
            view.change(roll=-33.3, f_stop=None, focus=None)
            view.wait_for(lambda h: h["frame"]["moving"])
            header = self.check(view, folder)
            self.assertAlmostEqual(header["camera"]["roll"], -33.3, places=3)
            view.change(orthographic=1.7, fov=None)
            view.wait_for(lambda h: h["frame"]["moving"])
            header = self.check(view, folder)
            self.assertIn("--orthographic 1.7", header["command"])
            self.assertAlmostEqual(header["camera"]["orthographic"], 1.7, places=4)

    def test_scenes_with_decisions(self):
        """Decisions on studio and backs of faces are flags of the line."""
        for name in ("interior.glb", "material_grid.glb", "instancing.glb"):
            with tempfile.TemporaryDirectory() as folder, View(PROGRAM, SCENES / name, "--size", "64x36", "--spp", "4", cwd=folder) as view:
                header = self.check(view, folder)
                theta, phi, radius = header["camera"]["orbit"]
                view.change(orbit=[theta + 33, phi, radius * 1.2], target=header["camera"]["target"], fov=header["camera"]["fov"])
                view.wait_for(lambda h: h["frame"]["moving"])
                self.check(view, folder)

    def test_aovs(self):
        with tempfile.TemporaryDirectory() as folder, View(PROGRAM, SCENES / "cornell_box.glb", "--size", "48x32", "--spp", "4", cwd=folder) as view:
            for name in ("normal", "depth", "position", "variance", "alpha"):
                view.change(shown=name)
                view.wait_for(lambda h, name=name: h["state"]["shown"] == name and complete(h))
                self.assertEqual(view.get("save.exr")[0], 200)
                self.check(view, folder)


class Ends(unittest.TestCase):
    def test_sigint_ends_within_two_seconds(self):
        for delay in (0.0, 1.5):
            with View(PROGRAM, SCENES / "cornell_box.glb", "--size", "1920x1080", "--spp", "65536") as view:
                waiting = threading.Thread(target=lambda view=view: self.ignore_loss(view), daemon=True)
                waiting.start()
                time.sleep(delay)
                seconds, code = view.interrupt()
                self.assertEqual(code, 130)
                self.assertLess(seconds, 2.0)
                waiting.join(timeout=5)

    @staticmethod
    def ignore_loss(view):
        try:
            view.frame(10**9)
        except (OSError, AssertionError):
            pass
        except Exception:  # http.client has several for a closed connection
            pass

    def test_errors_have_exit_codes(self):
        for words, code in ((["missing.glb"], 4), ([], 2), ([str(SCENES / "cornell_box.glb"), "--listen", "203.0.113.7"], 4),
                            ([str(SCENES / "cornell_box.glb"), "--exposure", "auto"], 2)):
            done = subprocess.run([PROGRAM, "view", *words], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual(done.stdout, "")

    def test_taken_port(self):
        with socket.create_server(("127.0.0.1", 0)) as other:
            done = subprocess.run([PROGRAM, "view", str(SCENES / "cornell_box.glb"), "--port", str(other.getsockname()[1])],
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 4)
            self.assertIn("in use", done.stderr)


if __name__ == "__main__":
    PROGRAM, SCENES = os.path.abspath(sys.argv[1]), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
