"""A `kindling view` of its own, and requests to it."""
# SPDX-License-Identifier: Apache-2.0
import http.client
import json
import signal
import struct
import subprocess
import threading
import time
from urllib.parse import urlsplit


class View:
    """The program while it serves a scene. `link` is the page's address."""

    def __init__(self, program, scene, *flags, cwd=None):
        self.process = subprocess.Popen([program, "view", str(scene), "--port", "0", *flags], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, cwd=cwd)
        self.messages = []
        self.reader = threading.Thread(target=lambda: self.messages.extend(self.process.stderr), daemon=True)
        self.reader.start()
        self.link = self.process.stdout.readline().strip()
        if not self.link:
            self.process.wait()
            self.reader.join()
            raise RuntimeError("".join(self.messages))
        parts = urlsplit(self.link)
        self.host, self.port, self.path = parts.hostname, parts.port, parts.path
        self.token = self.path.strip("/")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.reader.join()
        self.process.stdout.close()
        self.process.stderr.close()

    def request(self, target, method="GET", body=None, headers=None, timeout=20):
        """Status, headers and body of the answer to one request."""
        connection = http.client.HTTPConnection(self.host, self.port, timeout=timeout)
        try:
            connection.request(method, target, body=body, headers=headers or {})
            response = connection.getresponse()
            return response.status, dict(response.getheaders()), response.read()
        finally:
            connection.close()

    def get(self, name, **more):
        return self.request(self.path + name, **more)

    def change(self, **members):
        status, _, body = self.get("change", method="POST", body=json.dumps(members), headers={"Content-Type": "application/json"})
        return status, json.loads(body)

    def frame(self, after=0, image=0):
        """Header and JPEG of the next frame after a version; None if there is none in time."""
        status, _, body = self.get(f"frame?after={after}&image={image}")
        if status == 204:
            return None
        assert status == 200, (status, body)
        length, = struct.unpack("<I", body[:4])
        return json.loads(body[4:4 + length]), body[4 + length:]

    def wait_for(self, condition, seconds=60):
        """The first frame whose header meets the condition."""
        after, end, last = 0, time.monotonic() + seconds, None
        while time.monotonic() < end:
            frame = self.frame(after)
            if frame is None:
                continue
            if condition(frame[0]):
                return frame
            after, last = frame[0]["version"], frame[0]
        raise AssertionError("no such frame in time; the last header: " + json.dumps(last)[:2000])

    def interrupt(self):
        """Seconds from SIGINT to the end of the process, and its exit code."""
        start = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(timeout=10)
        return time.monotonic() - start, code


def complete(header):
    return header["status"] == "complete" and header["frame"]["complete"] and not header["frame"]["moving"]
