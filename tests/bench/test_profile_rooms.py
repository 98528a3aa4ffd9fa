#!/usr/bin/env python3
"""Tests of bench/profile_rooms.py on written stacks and counts, and on those of a small program.

test_profile_rooms.py BENCH_FOLDER [compiler]
"""
# SPDX-License-Identifier: Apache-2.0
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, sys.argv[1])
import profile_rooms

COMPILER = sys.argv[2] if len(sys.argv) > 2 else ""
PERF = """
\t    10 kindling::GltfBsdf::eval (/k)
\t    20 kindling::PathIntegrator::render_block (/k)
\t    30 main (/k)

\t    99 [unknown] (/usr/lib/libembree3.so.3)
\t    40 kindling::accel::(anonymous namespace)::EmbreeAccelerator::occluded (/k)
\t    20 kindling::PathIntegrator::render_block (/k)

\t    77 __memcpy (/usr/lib/libc.so.6)
\t    30 main (/k)

"""
SYMBOLS = {  # callers by the address before the one that they return to
    0x10: [("std::max", "/usr/include/c++/12/bits/stl_algobase.h"), ("kindling::pow5", "/r/renderer/base/math.h"),
           ("kindling::GltfBsdf::eval", "/r/renderer/bsdf/gltf_bsdf.cpp")],
    0x1f: [("kindling::PathIntegrator::shade", "/r/renderer/integrator/path_integrator.cpp"),
           ("kindling::PathIntegrator::render_block", "/r/renderer/integrator/path_integrator.cpp")],
    0x2f: [("main", "/r/renderer/app/main.cpp")],
    0x3f: [("kindling::accel::(anonymous namespace)::EmbreeAccelerator::occluded", "/r/accel/embree/embree_accelerator.cpp")]}
CALLGRIND = """ob=/k
fl=/r/renderer/integrator/path_integrator.cpp
fn=kindling::PathIntegrator::render_block(int)
10 5
fi=/r/renderer/bsdf/gltf_bsdf.cpp
11 20
fe=/r/renderer/integrator/path_integrator.cpp
cfi=/r/accel/kdtree/kdtree.cpp
cfn=kindling::accel::(anonymous namespace)::KdTreeAccelerator::occluded(int)
calls=3 50
12 300

fl=/r/accel/kdtree/kdtree.cpp
fn=kindling::accel::(anonymous namespace)::KdTreeAccelerator::occluded(int)
50 300

fl=/r/renderer/session/render_session.cpp
fn=kindling::render(int)
7 15
cfi=/r/renderer/integrator/path_integrator.cpp
cfn=kindling::PathIntegrator::render_block(int)
calls=1 10
8 325

ob=/usr/lib/libc.so.6
fl=???
fn=memcpy
0 60

summary: 400
totals: 400
"""


class Stacks(unittest.TestCase):
    def test_stages_and_rooms(self):
        stacks = profile_rooms.read_stacks(PERF.splitlines(keepends=True))
        self.assertEqual([len(stack) for stack in stacks], [3, 3, 2])
        stages, rooms = profile_rooms.of_stacks(stacks, SYMBOLS, "/r", "/k")
        self.assertEqual(dict(stages), {"BSDF": 1, "rays: shadow": 1, profile_rooms.OUTSIDE: 1})
        self.assertEqual(dict(rooms), {"renderer/base": 1, "Embree": 1, "libc, libm, libstdc++": 1})
        text = profile_rooms.report(stages, rooms, "samples")
        self.assertIn("3 samples, 2 of them in the render", text)
        self.assertRegex(text, r"BSDF +50\.0")
        self.assertRegex(text, r"Embree +33\.3")

    def test_sampler_is_separated_from_warps(self):
        self.assertEqual(profile_rooms.stage_of("renderer/sampling", "/r/renderer/sampling/sampler.h"), "sampler")
        self.assertIsNone(profile_rooms.stage_of("renderer/sampling", "/r/renderer/sampling/warp.h"))

    @unittest.skipUnless(COMPILER, "no compiler was named")
    def test_inlined_functions_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            header, source, program = (Path(folder) / name for name in ("inner.h", "outer.cpp", "program"))
            header.write_text("static inline int inner(int x) { return x * x + 7; }\n")
            source.write_text('#include "inner.h"\n#include <cstdlib>\n'
                              '__attribute__((noinline)) int outer(int x) { return inner(x); }\n'
                              'int main(int n, char**) { return outer(n) == 3 ? 1 : 0; }\n')
            subprocess.run([COMPILER, "-O2", "-g", "-o", program, source], check=True)
            symbols = subprocess.run(["nm", program], stdout=subprocess.PIPE, text=True, check=True).stdout
            start = int(re.search(r"([0-9a-f]+) T _Z5outeri", symbols)[1], 16)
            stacks = [[(start, "outer", str(program))]]
            frames = profile_rooms.symbolize(str(program), stacks)[start]
        self.assertEqual([function for function, _ in frames][-1], "outer(int)")
        self.assertTrue(frames[0][1].endswith(("inner.h", "outer.cpp")))


class Callgrind(unittest.TestCase):
    def test_stages_and_rooms(self):
        stages, rooms = profile_rooms.of_callgrind(CALLGRIND.splitlines(keepends=True), "/r")
        self.assertEqual(stages["rays: shadow"], 300)
        self.assertEqual(stages["BSDF"], 20)
        self.assertEqual(stages["integrator"], 5)
        self.assertEqual(rooms["accel/kdtree"], 300)
        self.assertEqual(rooms["libc, libm, libstdc++"], 60)
        self.assertEqual(sum(rooms.values()), 400)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
