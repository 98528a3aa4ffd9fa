#!/usr/bin/env python3
"""Runs renders of a sanitizer build: several threads, checkpoints, an interruption, a resume.

usage: interrupted_renders.py PROGRAM SCENE
A finding of a sanitizer ends the program with another exit code, which fails the test.
"""
# SPDX-License-Identifier: Apache-2.0
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TIMEOUT_S = 120


def run(arguments, code=0):
    done = subprocess.run(arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=TIMEOUT_S)
    if done.returncode != code:
        sys.exit(f"{arguments}: exit code {done.returncode}, expected {code}:\n{done.stderr}")


def interrupt(arguments, checkpoint):
    """Sends SIGTERM after the first save."""
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors)
        until = time.monotonic() + TIMEOUT_S
        while not checkpoint.exists() and process.poll() is None and time.monotonic() < until:
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        code = process.wait(TIMEOUT_S)
        errors.seek(0)
        if code != 143:
            sys.exit(f"{arguments}: exit code {code}, expected 143:\n{errors.read().decode(errors='replace')}")


def main():
    program, scene = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for accel, spp in (("embree", 64), ("kdtree", 16)):
            common = [program, "render", scene, "--size", "64x64", "--accel", accel, "--quiet", "--spp"]
            for threads in ("1", "2", "7"):
                run([*common, "4", "--threads", threads, "-o", folder / f"{accel}{threads}.exr"])
            checkpoint = folder / f"{accel}.kacc"
            interrupt([*common, str(spp), "--threads", "7", "-o", folder / f"{accel}.exr", "--checkpoint", checkpoint,
                       "--checkpoint-every", "0.1s"], checkpoint)
            run([program, "resume", checkpoint, "--threads", "2"])


main()
