#!/usr/bin/env python3
"""Renders by kernels of other compilers, and for arm64; images must have the bits of this build.

usage: compare_compilers.py ROOT FREEZE_SCENE SCENES [--imath FOLDER] [--all]
FREEZE_SCENE is the program of this build that freezes scenes (freeze_scene.cpp), SCENES a folder of scenes. Each variant compiles the sources of gpu_sources.txt and render_frozen.cpp by itself, and renders
all scenes with both tracers, and with light paths. Without --all: the newest clang++, and g++ for arm64 where qemu-user-static can run it.
Exit code 0 if all images are the same, 1 if not."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

FLAGS = ["-std=c++20", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-Wno-psabi", "-DIMATH_HALF_NO_LOOKUP_TABLE",
         "-ffunction-sections"]
CLANGS = [f"clang++-{n}" for n in range(21, 15, -1)]
LEFT_OUT = {"broken", "images"}


def variants(everything):
    """(name, compiler, flags, what runs the program)"""
    clang = next((name for name in CLANGS if shutil.which(name)), None)
    found = []
    if clang:
        found.append((f"{clang} -O2", clang, ["-O2"], []))
    if shutil.which("aarch64-linux-gnu-g++") and shutil.which("qemu-aarch64-static"):
        found.append(("g++ for arm64 -O2", "aarch64-linux-gnu-g++", ["-O2", "-static"], ["qemu-aarch64-static"]))
    if everything and clang:
        found.append((f"{clang} -O0", clang, ["-O0"], []))
    if everything:
        found += [("g++ -O2", "g++", ["-O2"], []), ("g++ -O3, AVX2 and FMA", "g++", ["-O3", "-march=x86-64-v3"], [])]
    return found


def build(root, imath, compiler, flags, folder):
    """Returns the program, or ends with the compiler's message."""
    listed = (root / "renderer/device/kernels/gpu_sources.txt").read_text(encoding="utf-8").splitlines()
    sources = [root / "renderer" / line for line in listed if line and not line.startswith("#")]
    sources.append(root / "tests/device/frozen/render_frozen.cpp")

    def compile_one(source):
        output = folder / (str(source.relative_to(root)).replace("/", "_") + ".o")
        done = subprocess.run([compiler, *FLAGS, *flags, f"-I{root}", f"-isystem{imath}", "-c", source, "-o", output],
                              check=False, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{compiler} cannot compile {source}:\n{done.stderr}")
        return output

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compile_one, sources))
    program = folder / "render_frozen"
    # Functions that kernels do not call may need sources that are not listed.
    subprocess.run([compiler, *flags, *objects, "-Wl,--gc-sections", "-o", program], check=True)
    return program


def frozen_scenes(freeze_scene, scenes, folder):
    """The files of all scenes, frozen for both tracers, and for paths beside light paths."""
    found = [path for pattern in ("*.glb", "*.gltf") for path in scenes.rglob(pattern)]
    files = []
    for path in sorted(path for path in found if not LEFT_OUT & set(path.relative_to(scenes).parts[:-1])):
        for tracer in ("path", "light_paths", "whitted"):
            file = folder / f"{path.stem}-{tracer}"
            subprocess.run([freeze_scene, path, file, tracer], check=True)
            files.append(file)
    return files


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    for name in ("root", "freeze_scene", "scenes"):
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--imath", type=pathlib.Path, default="/usr/include/Imath")
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    failed = False
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        files = frozen_scenes(arguments.freeze_scene, arguments.scenes, folder)
        for number, (name, compiler, flags, runner) in enumerate(variants(arguments.all)):
            objects = folder / str(number)
            objects.mkdir()
            program = build(arguments.root.resolve(), arguments.imath, compiler, flags, objects)
            done = subprocess.run([*runner, program, *files], check=False, capture_output=True, text=True)
            print(f"{name}: {done.stdout.strip()} {done.stderr.strip()}", flush=True)
            failed = failed or done.returncode != 0
    sys.exit("images depend on the compiler" if failed else 0)


if __name__ == "__main__":
    main()
