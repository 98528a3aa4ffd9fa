"""Processes whose memory and time are watched: of bounds.py."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import re
import signal
import subprocess
import threading
import time
from pathlib import Path


class Process:
    """A process with its peak of resident memory, killed beyond a limit of memory or time."""

    def __init__(self, command, folder, limit_bytes, limit_s):
        self.started = time.monotonic()
        self.killed = ""
        self.process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.out, self.err = [], []
        self.readers = [threading.Thread(target=self.read, args=pair, daemon=True)
                        for pair in ((self.process.stdout, self.out), (self.process.stderr, self.err))]
        for reader in self.readers:
            reader.start()
        self.limit_bytes, self.limit_s = limit_bytes, limit_s
        self.peak = 0

    @staticmethod
    def read(stream, lines):
        lines.extend(iter(stream.readline, ""))

    def poll(self):
        """Returns False once the process has ended."""
        if self.process.poll() is not None:
            return False
        self.watch()
        return True

    def watch(self):
        """Kills the process if it is beyond a limit."""
        try:
            status = Path(f"/proc/{self.process.pid}/status").read_text()
            self.peak = max(self.peak, *(int(value) * 1024 for value in re.findall(r"VmHWM:\s*(\d+)", status)), 0)
        except (OSError, ProcessLookupError):
            pass
        if self.peak > self.limit_bytes:
            self.kill(f"killed at {size(self.limit_bytes)}")
        elif time.monotonic() - self.started > self.limit_s:
            self.kill(f"killed after {self.limit_s:.0f} s")

    def kill(self, reason):
        self.killed = self.killed or reason
        self.process.kill()

    def processor_seconds(self):
        """Processor time of all threads so far; also after has_ended(), until poll()."""
        try:
            fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        except (OSError, ProcessLookupError):
            return 0.0
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def has_ended(self):
        """True once the process has ended, without forgetting its processor time."""
        return self.process.returncode is not None or os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def finish(self):
        while self.poll():
            time.sleep(0.02)
        for reader in self.readers:
            reader.join()
        self.seconds = time.monotonic() - self.started
        return self

    def phase(self):
        """The last phase that was begun; from --progress json."""
        found = [json.loads(line)["phase"] for line in list(self.err) if line.startswith("{") and '"phase"' in line]
        return found[-1] if found else ""


def size(count):
    return f"{count / 2**30:.2f} GiB" if count >= 2**30 else f"{count / 2**20:.0f} MiB"


def render(program, path, accelerator, options, spp="1"):
    return Process([program, "render", path, "--accel", accelerator, "--size", "64x36", "--spp", spp, "--threads", "2", "-o", "a.exr",
                    "--stats", "stats.json", "--progress", "json"], path.parent, options.limit, options.seconds)


def end_by_signal(run):
    """Sends SIGTERM. Returns the seconds to the end, how the process ended, and the seconds of a processor that it took to end."""
    sent, before = time.monotonic(), run.processor_seconds()
    run.process.send_signal(signal.SIGTERM)
    while not run.has_ended():
        run.watch()
        time.sleep(0.005)
    seconds, after = time.monotonic() - sent, run.processor_seconds()
    run.finish()
    return seconds, run.killed or f"exit code {run.process.returncode}", after - before


def time_to_end(program, path, accelerator, phase, delay, options):
    """Seconds from a SIGTERM in a phase to the end, or None if the phase ended before."""
    run = render(program, path, accelerator, options, "100000")
    while run.poll() and run.phase() != phase:
        time.sleep(0.01)
    time.sleep(delay)
    if not run.poll() or run.phase() != phase:
        run.kill("not needed")
        run.finish()
        return None
    return end_by_signal(run)
