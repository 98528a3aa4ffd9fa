"""Runs kindling processes and reads their results: the building blocks of faults.py."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import signal
import struct
import subprocess
import tempfile
import time
from pathlib import Path


class FaultError(AssertionError):
    """Work was lost, or a message is wrong."""


def require(condition, message):
    if not condition:
        raise FaultError(message)


def pixels(path):
    """The parts of an OpenEXR file that define its pixels: data window, channels, compression and the bytes of all chunks."""
    data = Path(path).read_bytes()
    require(data[:4] == b"v/1\x01", f"{path}: is not an OpenEXR file")
    at, attributes = 8, {}
    while data[at] != 0:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        value = type_end + 5
        attributes[data[at:name_end]] = data[value:value + size]
        at = value + size
    (first_chunk,) = struct.unpack_from("<q", data, at + 1)
    return attributes[b"dataWindow"], attributes[b"channels"], attributes[b"compression"], data[first_chunk:]


class Run:
    """A kindling process. Standard error goes to a file on a disk that is never filled: an unread pipe would block the process."""

    processes = []

    def __init__(self, program, arguments, folder, prefix=(), **options):
        self.log = tempfile.TemporaryFile()
        self.started = time.time()
        self.process = subprocess.Popen([*prefix, str(program), *map(str, arguments)], cwd=folder, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=self.log, **options)
        Run.processes.append(self)

    @classmethod
    def kill_all(cls):
        for run in cls.processes:
            if run.running():
                run.kill()
            run.log.close()
        cls.processes.clear()

    def error_text(self):
        descriptor = self.log.fileno()
        return os.pread(descriptor, os.fstat(descriptor).st_size, 0).decode("utf-8", errors="replace")

    def signal(self, number):
        self.process.send_signal(number)

    def running(self):
        return self.process.poll() is None

    def kill(self):
        self.process.kill()
        self.process.wait()

    def finish(self, code, timeout=300):
        try:
            found = self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.kill()
            raise FaultError(f"still running after {timeout} s:\n{self.error_text()}") from None
        require(found == code, f"exit code {found}, expected {code}:\n{self.error_text()}")
        return self.error_text()

    def wait_until(self, condition, what, timeout=120):
        """True if the condition came true while the process ran."""
        end = time.time() + timeout
        while not condition():
            if not self.running():
                return False
            require(time.time() < end, f"{what}: did not come within {timeout} s:\n{self.error_text()}")
            time.sleep(0.001)
        return True


class Job:
    """A render with a checkpoint in a folder of its own."""

    def __init__(self, program, folder, scene, flags, every_s):
        self.program, self.folder, self.every_s = program, Path(folder), every_s
        self.folder.mkdir(parents=True)
        self.image = ["render", str(scene), "--exr-float", "--progress", "none", *flags]
        self.checkpoint = self.folder / "c.kacc"
        self.previous = self.folder / "c.kacc.previous"

    def reference(self):
        """Pixels of the undisturbed render, and the seconds of its render phase."""
        whole = self.folder / "whole"
        whole.mkdir()
        Run(self.program, [*self.image, "-o", "whole.exr", "--stats", "stats.json"], whole).finish(0)
        stats = json.loads((whole / "stats.json").read_text())
        return pixels(whole / "whole.exr"), stats["phases"]["render"]

    def begin(self, *more, **options):
        return Run(self.program, [*self.image, "-o", "a.exr", "--checkpoint", self.checkpoint.name, "--checkpoint-every",
                                  self.every_s, *more], self.folder, **options)

    def resume(self, *more, **options):
        return Run(self.program, ["resume", self.checkpoint.name, *more], self.folder, **options)

    def begin_or_resume(self, *more, **options):
        there = self.checkpoint.exists() or self.previous.exists()
        return self.resume(*more, **options) if there else self.begin(*more, **options)

    def saved_at(self):
        """Time of the checkpoint that a resume would read; None without one."""
        for path in (self.checkpoint, self.previous):
            try:
                return path.stat().st_mtime
            except FileNotFoundError:
                pass
        return None

    def result(self):
        return pixels(self.folder / "a.exr")


def without_core_and_signals():
    """Run before exec: a write beyond the size limit fails instead of ending the process."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def is_root():
    return os.geteuid() == 0


class FullDisk:
    """A small disk: a tmpfs for root, which can be filled and emptied; else None."""

    def __init__(self, folder, size):
        self.folder = folder
        folder.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(folder)], capture_output=True, check=False)
        self.mounted = done.returncode == 0

    def fill(self):
        with open(self.folder / "filler", "wb", buffering=0) as file:
            try:
                while file.write(bytes(1 << 16)) == 1 << 16:
                    pass
            except OSError:
                pass

    def empty(self):
        (self.folder / "filler").unlink()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.mounted:
            Run.kill_all()
            subprocess.run(["umount", str(self.folder)], check=True)
