"""Runs a renderer of install.py on a job, for the scripts here."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import re
import sys
from pathlib import Path

import renderers
from peers import install

FOLDER = Path(__file__).resolve().parent
IMAGE_SUFFIX = {"cycles": ".exr", "mitsuba": ".pfm", "mitsuba_cuda": ".pfm", "luxcore": ".pfm"}  # PFM: read without oiiotool, too
VARIANTS = {"mitsuba": "llvm_ad_rgb", "mitsuba_cuda": "cuda_ad_rgb"}
RESULT = "PEER-RESULT "


def llvm_library():
    """LLVM's shared library, which compiles Mitsuba's vector code: Debian's newest one. None: there is none of version 15 or later."""
    found = [(int(version[1]), path) for path in Path("/usr/lib").glob("*-linux-gnu/libLLVM*")
             if (version := re.match(r"libLLVM(?:-|\.so\.)(\d+)", path.name))]
    version, path = max(found, default=(0, None))
    return path if version >= 15 else None


def prepare(names):
    """Installs those that are missing. Returns the names that can run; says why others cannot."""
    failed = install.install(names)
    if "mitsuba" in names and "mitsuba" not in failed and not os.environ.get("DRJIT_LIBLLVM_PATH") and llvm_library() is None:
        failed["mitsuba"] = "needs LLVM's library, version 15 or later (Debian: apt-get install libllvm19)"
    for name, reason in failed.items():
        print(f"{name}: left out: {reason}", file=sys.stderr)
    return [name for name in names if name not in failed]


def run(name, job, spp, seed, stem):
    """Writes STEM.exr or STEM.pfm, and STEM.log. Times are those of path tracing alone, as the renderer's script measures them."""
    image = Path(f"{stem}{IMAGE_SUFFIX[name]}")
    result, wall_s, peak_mb, cpu_s = call(name, renderers.peer_job(job, spp, seed, image) | {"timed": True}, stem)
    return renderers.Run(seed, image, result["wall_s"], wall_s, wall_s, peak_mb, cpu_s, result["cpu_s"])


def run_denoised(name, job, budget_s, clock, seed, stem):
    """Writes STEM.exr, denoised by the renderer itself, with as many samples as path tracing and filter can have in that time on
    this clock, "wall" or "cpu". Returns image, spp, total_s and filter_s."""
    image = Path(f"{stem}{IMAGE_SUFFIX[name]}")
    result, *_ = call(name, renderers.peer_job(job, 1, seed, image) | {"budget_s": budget_s, "clock": clock}, stem)
    return {"image": image} | {key: result[key] for key in ("spp", "total_s", "filter_s")}


def call(name, job, stem):
    """Runs a renderer's script. Returns what it reported, wall seconds, peak MiB and CPU seconds."""
    job_path, script = Path(f"{stem}.job.json"), name
    if name in VARIANTS:
        job, script = job | {"variant": VARIANTS[name]}, "mitsuba"
    job_path.write_text(json.dumps(job), encoding="utf-8")
    environment = dict(os.environ)
    if name == "mitsuba" and (library := llvm_library()):
        environment.setdefault("DRJIT_LIBLLVM_PATH", str(library))
    lines, wall_s, peak_mb, cpu_s = renderers.run_measured(
        [install.python_of(name), "-B", FOLDER / f"render_{script}.py", job_path], Path(f"{stem}.log"), environment)
    results = [json.loads(line[len(RESULT):]) for _, line in lines if line.startswith(RESULT)]
    if len(results) != 1:
        raise renderers.Failed(f"{name} reported no time; see {stem}.log")
    return results[0], wall_s, peak_mb, cpu_s
