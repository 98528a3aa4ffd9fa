#!/usr/bin/env python3
"""Compiles the sources that paths run through for NVIDIA GPUs, and looks through the PTX.

usage: path_sources.py CLANG ROOT [INCLUDE]...
CLANG is clang++-19, ROOT the repository, INCLUDE folders of headers. Each source must compile as it stands. Checked are
 - arithmetic: every operation rounds to nearest; none is approximate, fused or flushes denormal numbers;
 - symbols: a function is defined in one of the sources, or listed below with the reason;
 - calls through pointers: only in the sources listed below.
Exit code 0 if all hold, 1 with a line for each finding."""
# SPDX-License-Identifier: Apache-2.0
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "accel"))
from check_ptx import ARITHMETIC, FLAGS, HOST, host_includes  # noqa: E402

SOURCES = """
bsdf/anisotropic_interface.cpp bsdf/anisotropic_tables.cpp bsdf/base_lobes.cpp bsdf/dielectric_albedo.cpp bsdf/dielectric_lobe.cpp
bsdf/dielectric_tables.cpp bsdf/dispersion.cpp bsdf/film_layer.cpp bsdf/film_tables.cpp bsdf/ggx_tables.cpp bsdf/gltf_bsdf.cpp
bsdf/layered_bsdf.cpp bsdf/sheen_lobe.cpp bsdf/sheen_tables.cpp bsdf/thin_film.cpp bsdf/wavelength_tables.cpp
camera/aperture.cpp camera/camera_rays.cpp
guiding/bright_patches.cpp
integrator/caustics.cpp integrator/stages/path_media.cpp integrator/stages/path_transparency.cpp integrator/stages/shade_path.cpp
light/environment_sampling.cpp light/light_profile_lookup.cpp light/light_set.cpp light/light_tree.cpp light/moving_triangles.cpp
light/punctual_samples.cpp
sampling/jittered.cpp sampling/pixel_filter.cpp
texture/noise.cpp texture/procedural_program.cpp texture/procedural_texture.cpp texture/texture_lookup.cpp
world/layers.cpp world/moving_hit.cpp world/prefetch.cpp world/procedural_lookup.cpp world/ray_origins.cpp world/surface.cpp
""".split()

# Functions outside of the sources, by a part of their names.
OUTSIDE = {
    "TextureView5fetch": "texels in pages stay on the host",
    "Distribution2DView8prefetch": "prefetching serves processors",
    "remainder": "in the constructor of Aperture, which runs on the host",
    "strlen": "in the names of caustics, which the host reads",
    "memcmp": "in the names of caustics, which the host reads",
}
# Sources with calls through pointers.
INDIRECT = {
    "bsdf/anisotropic_interface.cpp": "the table of azimuths is computed when the program starts; a device will need it as an array",
    "world/ray_origins.cpp": "probes of guarded hits, through the accelerator's interface",
    "world/surface.cpp": "sight of faces that are cut away, through the accelerator's interface",
}
# <memory> has a loop that waits, with an instruction of the host's processor.
MORE = ["-D__builtin_ia32_pause()=void()", "-fno-math-errno", "-fno-trapping-math", "-Wno-bitwise-instead-of-logical"]


def compile_source(clang, root, source, includes, folder):
    """The PTX of a source, or the compiler's message."""
    ptx = pathlib.Path(folder) / (source.replace("/", "_") + ".ptx")
    libraries = [word for path in includes for word in ("-isystem", path)]
    command = [clang, *FLAGS, *HOST, *MORE, *host_includes(clang), *libraries, "-I", root, f"{root}/renderer/{source}", "-o", str(ptx)]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    return (ptx.read_text(encoding="utf-8"), "") if result.returncode == 0 else ("", result.stderr)


def findings(texts):
    """A line for each rule that is broken."""
    defined = {name for text in texts.values() for name in re.findall(r"^(?:\.visible |\.weak )?\.func [^;{]*?([\w$]+)\([^;{]*\{", text, re.M | re.S)}
    outside, indirect = set(), set()
    for source, text in texts.items():
        for operation in sorted(set(ARITHMETIC.findall(text))):
            if ".rn." not in operation or ".ftz" in operation or operation.startswith(("fma", "mad")):
                yield f"{source}: {operation}"
        if ".approx" in text:
            yield f"{source}: .approx occurs"
        for name in re.findall(r"^\.extern \.func\s[^;]*?([\w$]+)\s*\(\s*(?:\.param|\))", text, re.M):
            if name in defined:
                continue
            known = [part for part in OUTSIDE if part in name]
            outside.update(known)
            if not known:
                yield f"{source}: needs {name}, which no source defines"
        if "callprototype" in text:
            indirect.add(source)
            if source not in INDIRECT:
                yield f"{source}: calls through a pointer"
    for part in OUTSIDE.keys() - outside:
        yield f"OUTSIDE: {part} is not needed any more"
    for source in INDIRECT.keys() - indirect:
        yield f"INDIRECT: {source} has no such call any more"


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    clang, root, *includes = sys.argv[1:]
    texts, failed = {}, []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {source: pool.submit(compile_source, clang, root, source, includes, folder) for source in SOURCES}
        for source, job in jobs.items():
            texts[source], message = job.result()
            if message:
                failed.append(f"{source} does not compile:\n{message}")
    found = failed or list(findings(texts))
    for line in found:
        print(line, file=sys.stderr)
    print(f"{len(SOURCES)} sources, {sum(text.count('.func') for text in texts.values())} functions")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
