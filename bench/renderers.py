"""Runs Kindling and Cycles on the same job and reads their reports, for the scripts here."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KINDLING = ROOT / "build" / "release" / "kindling"


@dataclass
class Job:
    """One scene as both renderers are asked to render it. max_bounces counts indirect bounces, as both do: 0 is direct light."""
    name: str
    scene: Path
    size_px: tuple
    max_bounces: int
    environment: Path | None = None
    environment_rotation_deg: float = 0.0
    environment_intensity: float = 1.0
    background_visible: bool = True
    threads: int = 2
    reference: Path | None = None

    def paths(self, spp):
        return self.size_px[0] * self.size_px[1] * spp


@dataclass
class Run:
    """One render by one renderer."""
    seed: int
    image: Path
    path_tracing_s: float
    first_sample_s: float  # from the start of the process until every pixel had its first sample
    process_s: float
    peak_mb: float  # maximum resident set of the process, MiB
    cpu_s: float  # user and system time of the whole process
    path_tracing_cpu_s: float | None = None  # CPU seconds of path tracing alone, where the renderer tells them
    denoise_s: float = 0.0  # of the filter, on the clock
    samples: float | None = None  # of all pixels, where the renderer reports them: pixels may have different numbers


class Failed(SystemExit):
    """A renderer has failed. Ends the program with the message where it is not caught."""


def run_measured(command, log_path, environment=None):
    """Runs a program; its output goes to log_path. Returns ([(seconds since start, line)], wall seconds, peak MiB, CPU
    seconds). Raises Failed."""
    lines = []
    started = time.perf_counter()
    process = subprocess.Popen([str(part) for part in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, errors="replace", env=environment)

    def read():
        with open(log_path, "w", encoding="utf-8") as log:
            for line in process.stdout:
                lines.append((time.perf_counter() - started, line.rstrip("\n")))
                log.write(line)

    reader = threading.Thread(target=read)
    reader.start()
    _, status, usage = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    reader.join()
    if process.returncode != 0:
        tail = "\n".join(line for _, line in lines[-15:])
        raise Failed(f"exit code {process.returncode} from: {' '.join(map(str, command))}\n{tail}\n(whole log: {log_path})")
    return lines, wall_s, usage.ru_maxrss / 1024.0, usage.ru_utime + usage.ru_stime


def kindling_command(binary, job, spp, seed, image, flags=()):
    """The command line of Kindling for the job; `flags` come last, so they may override."""
    command = [binary, "render", job.scene, "-o", image, "--size", f"{job.size_px[0]}x{job.size_px[1]}", "--spp", spp,
               "--seed", seed, "--threads", job.threads, "--filter", "box", "--exr-float", "--max-bounces", job.max_bounces]
    if job.environment:
        command += ["--env", job.environment, "--env-rotation", job.environment_rotation_deg,
                    "--env-intensity", job.environment_intensity]
    if not job.background_visible:
        command += ["--background", "0,0,0"]
    return command + list(flags)


def run_kindling(binary, job, spp, seed, stem, flags=()):
    """Writes STEM.exr, STEM.json and STEM.log. Times come from --stats: the render phase alone is the path tracing, without the start
    of a device."""
    image, stats_path = Path(f"{stem}.exr"), Path(f"{stem}.json")
    command = kindling_command(binary, job, spp, seed, image, flags) + ["--stats", stats_path, "--progress", "none"]
    _, wall_s, peak_mb, cpu_s = run_measured(command, Path(f"{stem}.log"))
    with open(stats_path, encoding="utf-8") as file:
        stats = json.load(file)
    path_tracing_s = stats["phases"]["training"] + max(stats["phases"]["render"] - stats["device"]["start_s"], 1e-9)
    return Run(seed, image, path_tracing_s, stats["time_to_first_pixel_s"], wall_s, peak_mb, cpu_s,
               denoise_s=stats["phases"]["denoise"], samples=stats["spp_mean"] * job.paths(1))


def peer_job(job, spp, seed, image):
    """What the scripts in peers/ need to know of a render."""
    return {
        "scene": str(job.scene.resolve()), "environment": str(job.environment.resolve()) if job.environment else None,
        "environment_rotation_deg": job.environment_rotation_deg, "environment_intensity": job.environment_intensity,
        "background_visible": job.background_visible, "size_px": list(job.size_px), "spp": spp, "seed": seed,
        "max_bounces": job.max_bounces, "threads": job.threads, "output": str(image.resolve())}


def run_cycles(blender, job, spp, seed, stem):
    """Writes STEM.exr and STEM.log. Times come from Cycles' own report: 'Path Tracing' leaves out import, synchronization
    and BVH."""
    image, job_path = Path(f"{stem}.exr"), Path(f"{stem}.job.json")
    job_path.write_text(json.dumps(peer_job(job, spp, seed, image)), encoding="utf-8")
    # Debian's Blender finds its Python modules by the first python3 in PATH: that must be Debian's.
    environment = dict(os.environ, PATH="/usr/bin:/bin")
    lines, wall_s, peak_mb, cpu_s = run_measured(
        [blender, "-b", "--factory-startup", "-noaudio", "--debug-cycles", "--python-exit-code", "1", "-P",
         ROOT / "bench" / "peers" / "render_cycles.py", "--", job_path], Path(f"{stem}.log"), environment)
    path_tracing_s = first_sample_s = None
    for when_s, line in lines:
        if report := re.match(r"\s*Path Tracing\s+([0-9.]+)\s", line):
            path_tracing_s = float(report[1])
        if first_sample_s is None and re.search(r"\| Sample [1-9]\d*/", line):
            first_sample_s = when_s
    if path_tracing_s is None:
        sys.exit(f"Cycles printed no path tracing time; see {stem}.log")
    return Run(seed, image, path_tracing_s, first_sample_s or wall_s, wall_s, peak_mb, cpu_s)


def find_kindling(path=None):
    binary = Path(path) if path else KINDLING
    if not binary.is_file():
        sys.exit(f"no Kindling at {binary}; build it (cmake --build --preset release) or name it with --kindling PATH")
    return binary


def find_blender():
    return shutil.which("blender")


def load_jobs(paths, *, scenes=None, size_px=None, threads=2):
    """The scenes of folders and files: those of a folder's scenes.json, else each .glb and .gltf with a camera of its own."""
    jobs = [job for path in paths for job in jobs_of(Path(path), size_px, threads)]
    names = [job.name for job in jobs]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        sys.exit(f"two scenes are called {', '.join(twice)}; give one of them at a time")
    if unknown := sorted(set(scenes or ()) - set(names)):
        sys.exit(f"no scene {', '.join(unknown)}; there are {', '.join(names)}")
    jobs = [job for job in jobs if not scenes or job.name in scenes]
    for job in jobs:
        if not job.scene.is_file():
            sys.exit(f"{job.scene}: no such file")
    return jobs


def jobs_of(path, size_px, threads):
    folder = path
    if not path.is_dir():
        folder, entries = path.parent, {path.stem: {"file": path.name}}
    elif (table := path / "scenes.json").is_file():
        try:
            entries = json.loads(table.read_text(encoding="utf-8"))
        except ValueError as error:
            sys.exit(f"{table}: {error}")
        if not isinstance(entries, dict) or not all(isinstance(e, dict) and "file" in e for e in entries.values()):
            sys.exit(f'{table}: an object of {{"NAME": {{"file": "NAME.glb", ...}}, ...}} was expected')
    else:
        entries = {file.stem: {"file": file.name} for file in sorted(path.iterdir()) if file.suffix in (".glb", ".gltf")}
    if not entries:
        sys.exit(f"{folder}: neither scenes.json nor a .glb or .gltf in it")
    for name, entry in entries.items():
        reference = (entry.get("ref") or {}).get("file")
        yield Job(
            name=name, scene=folder / entry["file"], threads=threads, max_bounces=entry.get("max_bounces", 8),
            size_px=size_px or (entry.get("width", 640), entry.get("height", 360)),
            environment=find_environment(folder, entry["hdr"]) if entry.get("hdr") else None,
            environment_rotation_deg=entry.get("hdr_rotation_deg", 0.0), environment_intensity=entry.get("hdr_intensity", 1.0),
            background_visible=entry.get("background_visible", True),
            reference=folder / reference if reference and (folder / reference).is_file() else None)


def find_environment(folder, name):
    for candidate in (folder / name, folder / "env" / name, folder.parent / "env" / name):
        if candidate.is_file():
            return candidate
    sys.exit(f"{folder}: environment {name} is neither in it nor in {folder / 'env'} nor in {folder.parent / 'env'}")


def parse_size(text):
    size = re.fullmatch(r"(\d+)x(\d+)", text)
    if not size:
        raise ValueError(text)
    return int(size[1]), int(size[2])
