"""Runs Kindling and Cycles on the same job and reads what each says about itself; shared by the comparison scripts."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KINDLING = ROOT / "build" / "release" / "kindling"


@dataclass
class Job:
    """One scene as both renderers are asked to render it. max_bounces counts indirect bounces, as both do: 0 is direct light."""
    name: str
    scene: Path
    size_px: tuple
    spp: int
    max_bounces: int
    environment: Path | None = None
    environment_rotation_deg: float = 0.0
    environment_intensity: float = 1.0
    background_visible: bool = True
    threads: int = 2
    reference: Path | None = None

    def paths(self):
        return self.size_px[0] * self.size_px[1] * self.spp


@dataclass
class Run:
    """One render by one renderer."""
    seed: int
    picture: Path
    path_tracing_s: float
    first_sample_s: float  # from the start of the process until every pixel had its first sample
    process_s: float
    peak_mb: float  # maximum resident set of the process, MiB


@dataclass
class Runs:
    """All renders of one job by one renderer."""
    runs: list = field(default_factory=list)

    def median(self, name):
        return statistics.median(getattr(run, name) for run in self.runs)


def run_measured(command, log_path, environment=None):
    """Runs a program; its output goes to log_path. Returns ([(seconds since start, line)], wall seconds, peak MiB)."""
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
        sys.exit(f"exit code {process.returncode} from: {' '.join(map(str, command))}\n{tail}\n(whole log: {log_path})")
    return lines, wall_s, usage.ru_maxrss / 1024.0


def kindling_command(binary, job, seed, picture, accelerator="embree"):
    """The command line that asks Kindling for the job."""
    command = [binary, "render", job.scene, "-o", picture, "--size", f"{job.size_px[0]}x{job.size_px[1]}", "--spp", job.spp,
               "--seed", seed, "--threads", job.threads, "--filter", "box", "--accel", accelerator, "--exr-float",
               "--max-bounces", job.max_bounces]
    if job.environment:
        command += ["--env", job.environment, "--env-rotation", job.environment_rotation_deg,
                    "--env-intensity", job.environment_intensity]
    if not job.background_visible:
        command += ["--background", "0,0,0"]
    return command


def run_kindling(binary, job, seed, folder, accelerator="embree"):
    """Times come from --stats: the render phase alone is the path tracing."""
    stem = folder / f"{job.name}.kindling.{seed}"
    picture, stats_path = stem.with_suffix(stem.suffix + ".exr"), stem.with_suffix(stem.suffix + ".json")
    command = kindling_command(binary, job, seed, picture, accelerator) + ["--stats", stats_path, "--progress", "none"]
    _, wall_s, peak_mb = run_measured(command, stem.with_suffix(stem.suffix + ".log"))
    with open(stats_path, encoding="utf-8") as file:
        stats = json.load(file)
    return Run(seed, picture, stats["phases"]["render"], stats["time_to_first_pixel_s"], wall_s, peak_mb)


def run_cycles(blender, job, seed, folder):
    """Times come from Cycles' own report: 'Path Tracing' leaves out import, synchronization and BVH."""
    stem = folder / f"{job.name}.cycles.{seed}"
    picture, job_path = stem.with_suffix(stem.suffix + ".exr"), stem.with_suffix(stem.suffix + ".job.json")
    job_path.write_text(json.dumps({
        "scene": str(job.scene.resolve()), "environment": str(job.environment.resolve()) if job.environment else None,
        "environment_rotation_deg": job.environment_rotation_deg, "environment_intensity": job.environment_intensity,
        "background_visible": job.background_visible, "size_px": list(job.size_px), "spp": job.spp, "seed": seed,
        "max_bounces": job.max_bounces, "threads": job.threads, "output": str(picture.resolve())}), encoding="utf-8")
    # Debian's Blender finds its Python modules by the first python3 in PATH: that must be Debian's.
    environment = dict(os.environ, PATH="/usr/bin:/bin")
    lines, wall_s, peak_mb = run_measured(
        [blender, "-b", "--factory-startup", "-noaudio", "--debug-cycles", "--python-exit-code", "1", "-P",
         ROOT / "bench" / "cycles_render.py", "--", job_path], stem.with_suffix(stem.suffix + ".log"), environment)
    path_tracing_s = first_sample_s = None
    for when_s, line in lines:
        if report := re.match(r"\s*Path Tracing\s+([0-9.]+)\s", line):
            path_tracing_s = float(report[1])
        if first_sample_s is None and re.search(r"\| Sample [1-9]\d*/", line):
            first_sample_s = when_s
    if path_tracing_s is None:
        sys.exit(f"Cycles printed no path tracing time; see {stem}.log")
    return Run(seed, picture, path_tracing_s, first_sample_s or wall_s, wall_s, peak_mb)


def find_kindling(path=None):
    binary = Path(path) if path else KINDLING
    if not binary.is_file():
        sys.exit(f"no Kindling at {binary}; build it (cmake --build --preset release) or name it with --kindling PATH")
    return binary


def find_blender():
    return shutil.which("blender")


def load_jobs(folder, *, scenes=None, spp=16, size_px=None, threads=2):
    """The scenes of a folder: what its scenes.json says, else each .glb and .gltf with a camera of its own."""
    folder = Path(folder)
    table = folder / "scenes.json"
    if table.is_file():
        entries = json.loads(table.read_text(encoding="utf-8"))
    else:
        entries = {path.stem: {"file": path.name} for path in sorted(folder.iterdir()) if path.suffix in (".glb", ".gltf")}
    if not entries:
        sys.exit(f"{folder}: neither scenes.json nor a .glb or .gltf in it")
    unknown = set(scenes or ()) - set(entries)
    if unknown:
        sys.exit(f"{folder}: no scene {', '.join(sorted(unknown))}; there are {', '.join(entries)}")
    jobs = []
    for name, entry in entries.items():
        if scenes and name not in scenes:
            continue
        reference = entry.get("ref", {}).get("file")
        jobs.append(Job(
            name=name, scene=folder / entry["file"], spp=spp, threads=threads, max_bounces=entry.get("max_bounces", 8),
            size_px=size_px or (entry.get("width", 640), entry.get("height", 360)),
            environment=find_environment(folder, entry["hdr"]) if entry.get("hdr") else None,
            environment_rotation_deg=entry.get("hdr_rotation_deg", 0.0), environment_intensity=entry.get("hdr_intensity", 1.0),
            background_visible=entry.get("background_visible", True),
            reference=folder / reference if reference and (folder / reference).is_file() else None))
    return jobs


def find_environment(folder, name):
    for candidate in (folder / name, folder / "env" / name, folder.parent / "env" / name):
        if candidate.is_file():
            return candidate
    sys.exit(f"{folder}: environment {name} is neither there nor in {folder / 'env'} nor in {folder.parent / 'env'}")


def parse_size(text):
    size = re.fullmatch(r"(\d+)x(\d+)", text)
    if not size:
        raise ValueError(text)
    return int(size[1]), int(size[2])
