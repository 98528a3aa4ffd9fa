"""One round: its findings so far, the time that is left, and the programs that its parts run."""
# SPDX-License-Identifier: Apache-2.0
import glob
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "bench"), str(ROOT / "tests" / "device")]
import renderers  # noqa: E402
import round_page  # noqa: E402

# Tools of NVIDIA that are in no PATH: folders of a toolkit, the newest last.
TOOL_FOLDERS = ("/opt/nvidia/nsight-compute/*", "/usr/local/cuda*/bin")
BITS_SHARE = 1.0 / 3.0  # of the time, which other parts leave to the comparison of bits


class Skipped(Exception):
    """A part cannot run here; the message is the reason."""


class Round:
    def __init__(self, options):
        self.options = options
        self.program = options.program
        self.ends = time.monotonic() + options.seconds
        self.reserved_s = 0.0  # of the time that is left, for a later part
        self.found = {}
        self.folder = Path(tempfile.mkdtemp(prefix="kindling_round_"))
        # A driver takes minutes to compile the kernels: once in a round.
        self.environment = dict(os.environ, XDG_CACHE_HOME=str(self.folder / "cache"))

    def reserve(self, bits_follow):
        """Reserves a part of the time for the comparison of bits, if that follows."""
        self.reserved_s = BITS_SHARE * self.options.seconds if bits_follow else 0.0

    def left_s(self):
        return self.ends - self.reserved_s - time.monotonic()

    def is_over(self):
        return self.left_s() < 0.0

    def run(self, *arguments):
        """The seconds that the program took, and its error output; raises RuntimeError if it fails."""
        started = time.perf_counter()
        result = subprocess.run([self.program, *map(str, arguments)], check=False, capture_output=True, text=True, env=self.environment)
        seconds = time.perf_counter() - started
        if result.returncode != 0:
            raise RuntimeError(f"kindling {' '.join(map(str, arguments))}: exit code {result.returncode}: {result.stderr.strip()}")
        return seconds, result.stderr

    def run_tool(self, command, environment=None):
        """The result of another program, its two outputs in one; raises RuntimeError where it takes a minute longer than the round."""
        limit_s = max(self.left_s(), 0.0) + 60.0
        try:
            return subprocess.run([str(word) for word in command], check=False, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True, errors="replace", env=environment or self.environment, timeout=limit_s)
        except subprocess.TimeoutExpired as error:
            raise RuntimeError(f"{Path(command[0]).name}: ended after {limit_s:.0f} s, a minute beyond the round") from error

    def render_command(self, job, image, *flags, spp, size):
        """The command line of a render by the device."""
        command = renderers.kindling_command(self.program, job, spp, 0, image)
        command[command.index("--size") + 1] = size
        command[command.index("--threads") + 1] = 0
        return [*command, "--device", self.options.device, "--quiet", *flags]

    def render(self, job, name, *flags, device, spp, size=None):
        """Renders to FOLDER/NAME.exr; returns the image and its statistics."""
        image, stats = self.folder / f"{name}.exr", self.folder / f"{name}.json"
        command = renderers.kindling_command(self.program, job, spp, 0, image, flags)[1:]
        if size:
            command[command.index("--size") + 1] = size
        command[command.index("--threads") + 1] = flags[flags.index("--threads") + 1] if "--threads" in flags else 0
        self.run(*command, "--device", device, "--stats", stats, "--quiet")
        return image, json.loads(stats.read_text(encoding="utf-8"))

    def measure(self, command, job, *flags):
        """The report of `kindling shootout` or `kindling scaling` on a scene. Where bits differ they fail, but have written it."""
        report = self.folder / f"{command}.json"
        report.unlink(missing_ok=True)
        environment = []
        if job.environment:
            environment = ["--env", job.environment, "--env-rotation", job.environment_rotation_deg,
                           "--env-intensity", job.environment_intensity]
        try:
            self.run(command, job.scene, *environment, "--device", self.options.device, "--json", report, "--quiet", *flags)
        except RuntimeError:
            if not report.is_file():
                raise
        return json.loads(report.read_text(encoding="utf-8"))["scenes"][0]

    def save(self):
        """Writes what was found so far: the machine may be taken away at any time."""
        page = round_page.markdown(self.found, self.options.device)
        (self.options.out / "round.md").write_text(page, encoding="utf-8")
        (self.options.out / "round.json").write_text(json.dumps(self.found, indent=1), encoding="utf-8")
        return page


def measured_jobs():
    folder = ROOT / "measured"
    return renderers.load_jobs([folder]) if (folder / "scenes.json").is_file() else []


def chosen_jobs(*names, otherwise):
    """The measured scenes of these names; without any, a scene of the project."""
    jobs = [job for job in measured_jobs() if job.name in names]
    return jobs or [project_job(otherwise)]


def project_job(name):
    scene = ROOT / "scenes" / name
    return renderers.Job(scene.stem, scene, (320, 180), 8)


def find_tool(name):
    """The path of a tool, from PATH or from the folders of a toolkit; raises Skipped if it is absent."""
    found = shutil.which(name)
    for folders in TOOL_FOLDERS:
        for path in sorted(glob.glob(f"{folders}/{name}")):
            found = found or (path if os.access(path, os.X_OK) else None)
    if not found:
        raise Skipped(f"{name} is neither in PATH nor in {' or '.join(TOOL_FOLDERS)}")
    return found
