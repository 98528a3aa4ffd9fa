"""A headless Chromium, driven by the WebDriver protocol without other packages."""
# SPDX-License-Identifier: Apache-2.0
import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the name of a reference to an element, by the standard


def browser_programs():
    """The paths of chromium and chromedriver; None for what is missing."""
    return (shutil.which("chromium") or shutil.which("google-chrome"),
            shutil.which("chromedriver") or next((p for p in ("/usr/lib/chromium/chromedriver",) if os.path.exists(p)), None))


class Driver:
    """chromedriver, which starts browsers."""

    def __init__(self):
        self.chromium, program = browser_programs()
        self.process = subprocess.Popen([program, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for line in self.process.stdout:  # "ChromeDriver was started successfully on port 40731."
            if "successfully on port" in line:
                port = int(line.rsplit(" ", 1)[1].strip().rstrip("."))
                self.address = f"http://127.0.0.1:{port}"
                break

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()

    def call(self, method, path, body=None):
        data = json.dumps(body if body is not None else {}).encode() if method == "POST" else None
        request = urllib.request.Request(self.address + path, data=data, method=method, headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=60) as response:
                return json.load(response)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def browser(self, width=1280, height=800, **more):
        return Browser(self, width, height, **more)


class Browser:
    """One window of a browser with a profile of its own."""

    def __init__(self, driver, width, height, dark=True, touch=False):
        self.driver = driver
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        arguments = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--force-color-profile=srgb", "--hide-scrollbars",
                     "--no-first-run", "--disable-extensions", "--disable-background-networking", f"--user-data-dir={self.profile.name}",
                     f"--window-size={width},{height}", "--js-flags=--expose-gc", "--enable-precise-memory-info"]
        if dark:
            arguments.append("--blink-settings=preferredColorScheme=0")
        if touch:
            arguments.append("--touch-events=enabled")
        options = {"binary": driver.chromium, "args": arguments, "prefs": {"profile.default_content_setting_values.clipboard": 1}}
        capabilities = {"alwaysMatch": {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}
        self.session = "/session/" + driver.call("POST", "/session", {"capabilities": capabilities})["sessionId"]
        self.devtools("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.call("DELETE", "")
        finally:
            self.profile.cleanup()

    def call(self, method, path, body=None):
        return self.driver.call(method, self.session + path, body)

    def devtools(self, command, **parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def open(self, link):
        self.call("POST", "/url", {"url": link})

    def script(self, text, *arguments):
        """The value that a function's body returns; promises are awaited."""
        return self.call("POST", "/execute/sync", {"script": text, "args": list(arguments)})

    def text(self, selector):
        return self.script("return document.querySelector(arguments[0])?.textContent ?? null", selector)

    def wait(self, condition, seconds=60, of=""):
        """Waits until a condition in JavaScript holds, and returns its value."""
        end = time.monotonic() + seconds
        while True:
            value = self.script(f"return {condition}")
            if value:
                return value
            if time.monotonic() > end:
                raise AssertionError(f"not in {seconds} s: {of or condition}; messages: {self.messages()}; page: {self.text('#bottom')}")
            time.sleep(0.03)

    def click(self, selector):
        self.script("document.querySelector(arguments[0]).scrollIntoView({ block: 'center' })", selector)
        element = self.call("POST", "/element", {"using": "css selector", "value": selector})
        self.call("POST", f"/element/{element[ELEMENT]}/click")

    def pointer(self, *steps, kind="mouse", button=0):
        """Steps: ("move", x, y, ms), "down", "up", of fractions of the window's pixels as they are."""
        actions = []
        for step in steps:
            if isinstance(step, tuple):
                actions.append({"type": "pointerMove", "x": int(step[1]), "y": int(step[2]), "duration": step[3], "origin": "viewport"})
            else:
                actions.append({"type": "pointerDown" if step == "down" else "pointerUp", "button": button})
        self.call("POST", "/actions", {"actions": [{"type": "pointer", "id": kind, "parameters": {"pointerType": kind}, "actions": actions}]})

    def wheel(self, x, y, delta):
        self.call("POST", "/actions", {"actions": [{"type": "wheel", "id": "wheel", "actions": [
            {"type": "scroll", "x": int(x), "y": int(y), "deltaX": 0, "deltaY": delta, "duration": 0, "origin": "viewport"}]}]})

    def key(self, key, ms=0):
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": [
            {"type": "keyDown", "value": key}, {"type": "pause", "duration": ms}, {"type": "keyUp", "value": key}]}]})

    def box(self, selector):
        return self.script("const b = document.querySelector(arguments[0]).getBoundingClientRect(); return [b.x, b.y, b.width, b.height]", selector)

    def screenshot(self, file):
        with open(file, "wb") as out:
            out.write(base64.b64decode(self.call("GET", "/screenshot")))

    def messages(self):
        """Errors that the console has had since the last call."""
        return [entry["message"] for entry in self.call("POST", "/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]
