#!/usr/bin/env python3
"""Disturbs renders with checkpoints and compares their pixels with those of an undisturbed render.

usage: faults.py PROGRAM SCENES [--quick] [--only NAME]... [--seed N] [--folder FOLDER]
Kills, stops and interrupts them, fills their disks, corrupts their files. Prints a Markdown table: the
fault, how often, the loss. Exit code 1 if more was lost than allowed.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from fault_render import FaultError, FullDisk, Job, Run, is_root, require, without_core_and_signals  # noqa: E402

FAULTS = {}


def fault(function):
    FAULTS[function.__name__.replace("_", "-")] = function
    return function


class Bench:
    """State that all faults share: program, scenes, folders, random numbers, references."""

    def __init__(self, program, scenes, folder, quick, seed):
        self.program, self.scenes, self.folder, self.quick = program, scenes, folder, quick
        self.random = random.Random(seed)
        self.references = {}
        self.jobs = 0

    def job(self, flags=(), scene=None, every_s=0.2, folder=None):
        """A render of about two seconds, or as the flags say."""
        self.jobs += 1
        scene = scene or self.scenes / "cornell_box.glb"
        size = ["--size", "96x96", "--spp", "128" if self.quick else "256"]
        return Job(self.program, (folder or self.folder) / f"job{self.jobs}", scene, [*size, *flags], every_s)

    def reference(self, job):
        key = tuple(job.image)
        if key not in self.references:
            self.references[key] = job.reference()
        return self.references[key]

    def must_be_whole(self, job):
        require(job.result() == self.reference(job)[0], f"{job.folder}: the pixels are not those of the undisturbed render")

    def finished(self, **options):
        """A job with a complete checkpoint and its previous generation."""
        job = self.job(**options)
        job.begin().finish(0)
        self.must_be_whole(job)
        return job


VARIANTS = {
    "kd-tree": ["--accel", "kdtree"],
    "Embree": ["--accel", "embree"],
    "kd-tree, adaptive": ["--accel", "kdtree", "--noise-threshold", "0.05"],
    "Embree, adaptive": ["--accel", "embree", "--noise-threshold", "0.05"],
}


def kill_and_resume(bench, job, times):
    """Kills with SIGKILL at random moments and resumes each time. Returns the largest loss of a kill in wall seconds, since the last save or the start."""
    _, render_s = bench.reference(job)
    worst_s, kills = 0.0, 0
    while kills < times:
        run = job.begin_or_resume()
        first = job.saved_at() or run.started
        alive_until = time.time() + bench.random.uniform(0.05, min(1.5, 0.5 * render_s) + 0.3)
        if run.wait_until(lambda: time.time() >= alive_until, "the moment of the kill"):
            now = time.time()
            run.kill()
            kills += 1
            saved = job.saved_at()
            worst_s = max(worst_s, now - (saved if saved is not None and saved != first else run.started))
        elif kills < times:  # the render has ended: start again
            run.finish(0)
            bench.must_be_whole(job)
            for path in (job.checkpoint, job.previous):
                path.unlink(missing_ok=True)
    job.begin_or_resume().finish(0)
    bench.must_be_whole(job)
    return worst_s


@fault
def kill(bench):
    """kill -9 at a random moment, then `resume`"""
    for name, flags in VARIANTS.items():
        if bench.quick and name not in ("kd-tree", "Embree, adaptive"):
            continue
        times = 2 if bench.quick else 20
        job = bench.job(flags)
        worst_s = kill_and_resume(bench, job, times)
        # The interval, and everything before the first save: start, scene, guide, current tiles,
        # writing.
        require(worst_s < job.every_s + 5.0, f"{worst_s:.2f} s of work were lost, the interval is {job.every_s} s")
        yield f"{name}: {times} times", f"at most {worst_s:.2f} s of work with --checkpoint-every {job.every_s}"


# The system calls of a save.
CALLS = ("write,writev,pwrite64", "fsync,fdatasync", "rename,renameat,renameat2")


def can_inject():
    if shutil.which("strace") is None:
        return False
    probe = subprocess.run(["strace", "-f", "-o", "/dev/null", "true"], capture_output=True, check=False)
    return probe.returncode == 0


@fault
def kill_while_saving(bench):
    """kill -9 in the middle of a save: in its writes, before and after it is synced, between its renames"""
    if can_inject():
        times = 0
        for call in CALLS:
            for when in (2, 3) if bench.quick else range(1, 9):
                job = bench.job(every_s=0.1)
                run = job.begin(prefix=["strace", "-f", "-o", "/dev/null", "-e", f"trace={call}",
                                        "-e", f"inject={call}:signal=SIGKILL:when={when}"])
                run.process.wait(300)
                if run.process.returncode != 0:
                    times += 1
                    job.begin().finish(0)  # 'resume' needs a complete checkpoint
                bench.must_be_whole(job)
        yield f"{times} system calls", "nothing that had been saved before"
        return
    job, times = bench.job(flags=["--size", "512x512", "--spp", "16"], every_s=0.05), 0
    for _ in range(3 if bench.quick else 20):
        run = job.begin_or_resume()
        before = set(job.folder.iterdir())
        if run.wait_until(lambda: any(p.suffix == ".tmp" for p in set(job.folder.iterdir()) - before), "a save"):
            run.kill()
            times += 1
    job.begin_or_resume().finish(0)
    bench.must_be_whole(job)
    yield f"{times} times", "nothing that had been saved before"


@fault
def full_disk(bench):
    """the disk is full in the middle of a render; to its end"""
    with FullDisk(bench.folder / "disk", "8m") as disk:
        if not disk.mounted:
            yield from file_too_large(bench)
            return
        job = bench.job(["--spp", "512"], folder=disk.folder)
        bench.reference(job)
        run = job.begin()
        require(run.wait_until(job.checkpoint.exists, "the first save"), "ended before the first save")
        disk.fill()
        require(run.wait_until(lambda: "No space left" in run.error_text(), "the warning"), f"no warning:\n{run.error_text()}")
        disk.empty()
        text = run.finish(0)
        require(" failed in " in text, f"the summary does not count the saves that failed:\n{text}")
        bench.must_be_whole(job)
        yield "in the middle, free again later: once", "nothing; warnings, and the render continues"
        for path in (job.checkpoint, job.previous, job.folder / "a.exr"):
            path.unlink(missing_ok=True)
        run = job.begin()
        require(run.wait_until(job.previous.exists, "two saves"), "ended before the second save")
        disk.fill()
        text = run.finish(4)
        require("No space left" in text and text.count("error:") >= 1, f"no clear error:\n{text}")
        disk.empty()
        saved = job.checkpoint.read_bytes()
        job.resume().finish(0)
        bench.must_be_whole(job)
        yield "to the end: once", f"what came after the last save of {len(saved) >> 10} KiB, which stays: exit code 4, then `resume`"


def file_too_large(bench):
    """Without tmpfs: files above a size limit are refused."""
    job = bench.job()
    size = len(bench.finished().checkpoint.read_bytes())
    run = job.begin(prefix=["prlimit", f"--fsize={size // 2}"], preexec_fn=without_core_and_signals, restore_signals=False)
    text = run.finish(4)
    require("File too large" in text, f"no clear error:\n{text}")
    job.begin().finish(0)
    bench.must_be_whole(job)
    yield "a limit on the size of files, from the beginning: once", "the checkpoint; exit code 4"


@fault
def damage(bench):
    """the checkpoint is cut off, emptied, or has a bit flipped; its previous generation is there, or not"""
    done = bench.finished()
    good = done.checkpoint.read_bytes()
    require(done.previous.exists(), "there is no previous generation")
    damages = [("emptied", b""), ("a foreign file", b"P6 1 1 255 abc"), ("of version 999", good[:8] + b"\xe7\x03\x00\x00" + good[12:])]
    for _ in range(4 if bench.quick else 30):
        damages.append(("cut off", good[:bench.random.randrange(1, len(good))]))
        at, bit = bench.random.randrange(len(good)), 1 << bench.random.randrange(8)
        damages.append((f"bit {bit} of byte {at}", good[:at] + bytes([good[at] ^ bit]) + good[at + 1:]))
    image = done.folder / "a.exr"
    for i, (what, bytes_) in enumerate(damages):
        done.checkpoint.write_bytes(bytes_)
        image.unlink(missing_ok=True)
        if i % 2 == 0:
            text = done.resume().finish(0)
            require("warning" in text and re.search(r"(?:resum|continu)\w+ from", text), f"{what}: not reported:\n{text}")
            bench.must_be_whole(done)
            damaged = done.folder / "c.kacc.damaged"
            require(damaged.read_bytes() == bytes_, f"{what}: the damaged file was not set aside")
            done.checkpoint.write_bytes(good)
            shutil.copy(done.checkpoint, done.previous)
        else:
            aside = done.previous.rename(done.folder / "aside")
            run = done.resume()
            code = run.process.wait(60)
            text = run.error_text()
            require(code in (2, 4) and text.count("\n") == 1, f"{what}: exit code {code}, not one line:\n{text}")
            require(not image.exists(), f"{what}: an image was written")
            aside.rename(done.previous)
    yield f"{len(damages)} files", "what came after the previous generation; without one: exit code 4, no image"


@fault
def changed_scene(bench):
    """the scene has changed, or moved, when the render is resumed"""
    folder = bench.folder / "scenes"
    folder.mkdir()
    scene = folder / "s.glb"
    shutil.copy(bench.scenes / "cornell_box.glb", scene)
    job = bench.finished(scene=scene)
    good = scene.read_bytes()
    at = good.rindex(b"\x3f")  # part of a number, so the scene stays valid
    scene.write_bytes(good[:at] + b"\x3e" + good[at + 1:])
    text = job.resume("--spp", "300").finish(2)
    require("the scene has changed" in text, text)
    scene.rename(folder / "moved.glb")
    text = job.resume().finish(4)
    require(str(scene) in text, text)
    (folder / "moved.glb").write_bytes(good)
    job.resume("--scene-file", folder / "moved.glb").finish(0)
    bench.must_be_whole(job)
    yield "changed, moved: once each", "nothing; exit codes 2 and 4; it resumes with the old scene or the new path"


@fault
def folder_that_cannot_be_written(bench):
    """the folder of the checkpoint is read-only"""
    with FullDisk(bench.folder / "read-only", "8m") as disk:
        if disk.mounted:
            job = bench.job(folder=disk.folder)
            subprocess.run(["mount", "-o", "remount,ro", str(disk.folder)], check=True)
            cwd = bench.folder
        else:
            require(not is_root(), "root without a tmpfs: nothing is read-only")
            job = bench.job()
            job.folder.chmod(0o555)
            cwd = bench.folder
        run = Run(bench.program, [*job.image, "-o", "a.exr", "--checkpoint", job.checkpoint], cwd)
        begun = time.time()
        text = run.finish(4)
        require("--checkpoint" in text and text.count("\n") == 1, text)
        require(time.time() - begun < 10, "the error came after the work")
        if not disk.mounted:
            job.folder.chmod(0o755)
    yield "once", "no time: exit code 4 before the work"


@fault
def disk_for_temporary_files(bench):
    """the disk for temporary files is missing, or full; a process with textures there is killed"""
    paged = ["render", bench.scenes / "interior.glb", "--size", "64x36", "--texture-memory", "64K", "-q"]
    with FullDisk(bench.folder / "temporary", "16m") as disk:
        inside = {**os.environ, "TMPDIR": str(disk.folder)}
        run = Run(bench.program, [*paged, "-o", "killed.exr", "--spp", "1000000"], bench.folder, env=inside)
        require(run.wait_until(lambda: list(disk.folder.glob("*/*.tif")), "a paged texture"), "ended before the first texture")
        run.kill()
        require(list(disk.folder.iterdir()), "the killed process left nothing")
        Run(bench.program, [*paged, "-o", "b.exr", "--spp", "1"], bench.folder, env=inside).finish(0)
        require(not list(disk.folder.iterdir()), "the next process did not remove what the killed one left")
        if disk.mounted:
            disk.fill()
            text = Run(bench.program, [*paged, "-o", "c.exr", "--spp", "1"], bench.folder, env=inside).finish(4)
            require("No space left" in text or "textures on disk" in text, text)
    missing = {**os.environ, "TMPDIR": str(bench.folder / "nowhere")}
    text = Run(bench.program, [*paged, "-o", "d.exr", "--spp", "1"], bench.folder, env=missing).finish(4)
    require("no temporary folder in" in text and text.count("\n") == 1, text)
    yield "missing, full, killed: once each", "that render: exit code 4; the next one removes the files of the killed process"


@fault
def terminated(bench):
    """SIGTERM (as a farm sends it), SIGINT (as a user does) and SIGHUP (a closed terminal), and a second signal at once"""
    times = too_late = 0
    render_s = float("inf")  # the shortest so far: the reference may have met a busier machine
    for number, code in ((signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129)) * (1 if bench.quick else 5):
        job = bench.job(every_s=1000)  # only the signal saves
        render_s = min(render_s, bench.reference(job)[1])
        run = job.begin()
        time.sleep(bench.random.uniform(0.3, 0.3 + 0.5 * render_s))
        was_running = run.running()
        if was_running:
            run.signal(number)
            run.process.wait(120)
            times += 1
        if run.process.returncode == 0:  # it had ended, or was about to: faster than the reference
            render_s = min(render_s, time.time() - run.started)
            too_late += was_running
            bench.must_be_whole(job)
            continue
        text = run.error_text()
        require(run.process.returncode in (code, -number), f"exit code {run.process.returncode}:\n{text}")
        if job.checkpoint.exists():
            require("interrupted" in text, text)
            job.resume().finish(0)
            bench.must_be_whole(job)
    require(times > 0, "all renders ended before the signal")
    require(3 * too_late <= times, f"{too_late} of {times} renders ended as if there had been no signal")
    job = bench.job()
    for _ in range(2 if bench.quick else 10):
        run = job.begin_or_resume()
        if run.wait_until(lambda: job.saved_at() is not None, "a save"):
            run.signal(signal.SIGTERM)
            time.sleep(bench.random.uniform(0.0, 0.01))
            run.signal(signal.SIGTERM)
            run.process.wait(60)
            require(run.process.returncode in (143, -signal.SIGTERM, 0), f"exit code {run.process.returncode}:\n{run.error_text()}")
            times += 1
    job.begin_or_resume().finish(0)
    bench.must_be_whole(job)
    yield f"{times} times", "nothing: saved to the tile; after a second signal what the last save had not"


@fault
def stopped(bench):
    """SIGSTOP, a while, SIGCONT"""
    job = bench.job()
    run = job.begin()
    times = 0
    while run.running() and times < (3 if bench.quick else 20):
        time.sleep(bench.random.uniform(0.02, 0.2))
        run.signal(signal.SIGSTOP)
        time.sleep(0.05)
        run.signal(signal.SIGCONT)
        times += 1
    run.finish(0)
    bench.must_be_whole(job)
    yield f"{times} times", "nothing"


@fault
def two_at_once(bench):
    """a second process resumes the same checkpoint"""
    job = bench.job()
    first = job.begin()
    require(first.wait_until(job.checkpoint.exists, "the first save"), "ended before the first save")
    log = bench.folder / "second"
    log.mkdir()
    text = Run(bench.program, ["resume", job.checkpoint], log).finish(4)
    require("is rendering to it" in text, text)
    first.finish(0)
    bench.must_be_whole(job)
    yield "once", "nothing: the second one is refused, exit code 4"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--quick", action="store_true", help="repeat each fault a few times only")
    parser.add_argument("--only", action="append", choices=sorted(FAULTS))
    parser.add_argument("--seed", type=int, help="seed of the random moments (default: random; printed)")
    parser.add_argument("--folder", type=Path, help="working folder, which remains afterwards (default: a temporary one)")
    options = parser.parse_args()
    seed = options.seed if options.seed is not None else random.SystemRandom().randrange(1 << 31)
    print(f"seed {seed}\n\n| fault | how often | lost |\n|---|---|---|", flush=True)
    failed = 0
    with tempfile.TemporaryDirectory(prefix="kindling-faults-") as temporary:
        folder = options.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        bench = Bench(options.program.resolve(), options.scenes.resolve(), folder.resolve(), options.quick, seed)
        for name in options.only or FAULTS:
            try:
                for often, lost in FAULTS[name](bench):
                    print(f"| {FAULTS[name].__doc__} | {often} | {lost} |", flush=True)
            except FaultError as error:
                failed += 1
                print(f"\nFAILED {name} (seed {seed}): {error}\n", flush=True)
            Run.kill_all()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
