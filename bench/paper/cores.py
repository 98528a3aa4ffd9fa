"""Measurements of distribution: threads with regions or tiles, and processes with a region each."""
# SPDX-License-Identifier: Apache-2.0
import statistics
import sys
import threading
import time

import numpy as np

import fidelity_images
import tracers

SCENE, SIZE = "figure_01", (900, 675)
JOBS = {"Whitted, depth 12": (["--tracer", "optimized", "--trace-depth", "12", *tracers.AMBIENT], 4), "path traced": (["--integrator", "path"], 4)}


def thread_counts(cores):
    """1, 2, 3 and 4, then powers of two, and all cores."""
    return sorted({count for count in (1, 2, 3, 4, *(2 ** e for e in range(3, 12)), cores) if count <= cores})


def by_threads(bench, repeats):
    """{job: {schedule: {threads: {"seconds", "speedup", "idle"}}}}; medians; speed-ups over one thread with tiles."""
    found = {}
    for job, (flags, spp) in JOBS.items():
        variants = {(schedule, threads): lambda s=schedule, t=threads: bench.render(SCENE, bench.scaled(SIZE), spp, [*flags, "--schedule", s], t, "exr")
                    for schedule in ("regions", "tiles") for threads in thread_counts(bench.cores)}
        results = bench.interleaved(variants, repeats, f"cores: {job}")
        seconds = {key: statistics.median(r.render_s for r in rs) for key, rs in results.items()}
        one = seconds["tiles", 1]
        found[job] = {schedule: {threads: {"seconds": seconds[schedule, threads], "speedup": one / seconds[schedule, threads],
                                           "idle": statistics.median(r.idle_share for r in results[schedule, threads])}
                                 for s, threads in seconds if s == schedule} for schedule in ("regions", "tiles")}
    return found


def crops(size_px, count):
    """Contiguous regions of whole rows, as equal as can be: (x0, y0, x1, y1)."""
    width, height = size_px
    rows = [round(i * height / count) for i in range(count + 1)]
    return [(0, top, width, bottom) for top, bottom in zip(rows, rows[1:])]


def by_processes(bench, spp=4):
    """Renders one region in each process, all at once, and compares the composed image with the whole to the bit."""
    size, flags = bench.scaled(SIZE), [*JOBS["Whitted, depth 12"][0]]
    count = max(bench.cores, 2)
    bench.say(f"processes: the whole image, then {count} regions at once")
    whole = bench.render(SCENE, size, spp, flags, 1, "exr")
    parts, results, errors = crops(size, count), [None] * count, []

    def work(index):
        try:
            crop = ",".join(map(str, parts[index]))
            results[index] = bench.render(SCENE, size, spp, [*flags, "--crop", crop], 1, "exr")
        except SystemExit as error:  # raised in a thread, unnoticed by the process
            errors.append(str(error))

    workers = [threading.Thread(target=work, args=(index,)) for index in range(count)]
    started = time.perf_counter()
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    wall_s = time.perf_counter() - started
    if errors:
        sys.exit(errors[0])
    expected = fidelity_images.read(whole.image).rgb
    pieces = [fidelity_images.read(result.image).rgb for result in results]
    composed = np.concatenate([piece if piece.shape[0] == bottom - top else piece[top:bottom]
                               for piece, (_, top, _, bottom) in zip(pieces, parts)])
    return {"count": count, "whole_s": whole.process_s, "wall_s": wall_s, "render_s": [result.render_s for result in results],
            "same": composed.shape == expected.shape and composed.tobytes() == expected.tobytes()}
