# SPDX-License-Identifier: Apache-2.0
"""The figures of "Research on ray tracing" as glTF scenes, one file each."""
from . import paper_cpu, paper_gpu, paper_motion


def build():
    return {"paper/%s.glb" % name: make() for name, make in {**paper_cpu.FIGURES, **paper_gpu.FIGURES, **paper_motion.FIGURES}.items()}
