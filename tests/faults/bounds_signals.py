"""Signals at moments spread over a whole render: of bounds.py."""
# SPDX-License-Identifier: Apache-2.0
import random
import tempfile
import time
from pathlib import Path

from bounds_process import render, end_by_signal

RENDER_S = 3.0  # of the render phase within which signals are sent
SAMPLES = "100000"  # more than any run has time for


def time_of_render(options, path, accelerator):
    """Seconds from the start of a process to that of its render phase."""
    run = render(options.program, path, accelerator, options, SAMPLES)
    while run.poll() and run.phase() != "render":
        time.sleep(0.01)
    seconds = time.monotonic() - run.started
    run.kill("not needed")
    run.finish()
    return seconds


def measure_signals(options, scenes, bound_s):
    """Prints the longest and mean time to the end for each phase, and the longest of a processor. Returns 1 if one was beyond the bound."""
    rng, slow = random.Random(options.signals), 0
    for scene in scenes:
        with tempfile.TemporaryDirectory() as folder:
            path = scene(Path(folder))
            for accelerator in options.accel.split(","):
                end = time_of_render(options, path, accelerator) + RENDER_S
                found = {}
                for i in range(options.signals):
                    run = render(options.program, path, accelerator, options, SAMPLES)
                    until = run.started + (i + rng.random()) / options.signals * end
                    while run.poll() and time.monotonic() < until:
                        time.sleep(0.01)
                    phase = run.phase() or "start"
                    seconds, how, processor_seconds = end_by_signal(run)
                    found.setdefault(phase, []).append((seconds, processor_seconds))
                    slow += seconds > bound_s
                    if seconds > bound_s:
                        print(f"  {scene.__name__} {accelerator}: {seconds:.2f} s, {processor_seconds:.2f} s of a processor, {phase}, {how}", flush=True)
                phases = ", ".join(f"{phase} {len(times)}: max {max(times)[0]:.2f} s, mean {sum(time[0] for time in times) / len(times):.2f} s, "
                                   f"of a processor max {max(time[1] for time in times):.2f} s" for phase, times in found.items())
                print(f"{scene.__name__:30} {accelerator:7} {phases}", flush=True)
    return 1 if slow else 0
