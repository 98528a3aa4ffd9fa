# SPDX-License-Identifier: Apache-2.0
"""Figures 11, 15 and 16: turbulence and checkers, moving spheres, and all effects in one image."""
import math

from . import images, procedurals
from .paper_stage import AMBER, CORAL, GOLD, GPU_ASPECT, IVORY, SILVER, Studio
from .paper_textures import textured, turbulence
from .shapes import beveled_box, quad

EVENING = ((0.012, 0.035, 0.12), (0.62, 0.44, 0.36), (0.05, 0.04, 0.07))
SEA = ((0.010, 0.035, 0.075), (0.03, 0.30, 0.36), (0.86, 0.84, 0.74))
EMBER = ((0.09, 0.008, 0.012), (0.62, 0.11, 0.03), (0.98, 0.72, 0.26))
VIOLET = ((0.035, 0.012, 0.085), (0.34, 0.10, 0.42), (0.92, 0.62, 0.66))
NIGHT = ((0.006, 0.008, 0.022), (0.022, 0.045, 0.13), (0.16, 0.26, 0.42))
SHUTTER_S = 0.02


def figure_11():
    """Glossy spheres: turbulence on the left one, a checkerboard on the right one."""
    s = Studio(EVENING, 0.4)
    s.add("parallelogram", quad((-0.72, 0, 0.40), (1.16, 0, 0.0), (0.26, 0, -0.78)).without_uvs(), s.metal("plate", (0.16, 0.20, 0.27), 0.16))
    s.ball("turbulence", (-0.225, 0.202, 0.0), 0.20, textured(s.g, "turbulence", turbulence("turbulence", SEA, 1.6, 2.3), (0.10, 0.35, 0.38), 0.0, 0.14))
    board = procedurals.checkerboard((0.82, 0.79, 0.72), (0.55, 0.055, 0.045), (16.0, 8.0))
    s.ball("checkerboard", (0.225, 0.202, 0.0), 0.20, textured(s.g, "checkerboard", board, (0.6, 0.3, 0.3), 0.0, 0.14), textured=True)
    s.soft_box("key", (-1.2, 1.6, 1.3), (0, 0.15, 0), 1.1, 1.1, (11.0, 10.2, 9.0))
    s.soft_box("strip", (1.7, 0.8, 0.5), (0, 0.15, 0), 0.25, 1.4, (5.0, 6.6, 9.0))
    return s.finish("figure 11", (0.0, 0.50, 1.85), (0.0, 0.155, 0.0), 25, GPU_ASPECT)


def move(s, node, way):
    """Moves the node by the displacement `way` while the shutter is open; it rests for the last third, a sphere at the end of its trail."""
    at = s.g.json["nodes"][node]["translation"]
    times = s.g.add_accessor([0.0, 0.66 * SHUTTER_S, SHUTTER_S], "SCALAR", bounds=True)
    places = s.g.add_accessor([tuple(a - d for a, d in zip(at, way)), at, at], "VEC3")
    if "animations" not in s.g.json:
        s.g.add("animations", {"name": "motion", "samplers": [], "channels": []})
    motion = s.g.json["animations"][0]
    motion["channels"].append({"sampler": len(motion["samplers"]), "target": {"node": node, "path": "translation"}})
    motion["samplers"].append({"input": times, "output": places, "interpolation": "LINEAR"})


def figure_15():
    """Three spheres of turbulence that fly past a turbulent patch; highlights of small lamps draw their paths."""
    s = Studio(((0.02, 0.03, 0.06), (0.09, 0.10, 0.16), (0.03, 0.03, 0.05)))
    patch = turbulence("patch", NIGHT, 2.4, 5.1, 7, 0.95)
    s.add("patch", quad((-1.3, -0.75, -0.75), (2.6, 0, 0), (0, 2.2, 0)).without_uvs(), textured(s.g, "patch", patch, (0.03, 0.05, 0.1), 0.0, 0.6))
    flights = [("ember", EMBER, (-0.27, 0.31, 0.05), 0.150, (0.17, 0.055, 0.0), 1.0), ("sea", SEA, (0.245, 0.335, -0.16), 0.135, (0.06, -0.145, 0.02), 3.7),
               ("violet", VIOLET, (0.07, 0.075, 0.22), 0.105, (-0.20, 0.03, 0.03), 7.9)]
    for name, colors, at, radius, way, seed in flights:
        material = textured(s.g, name, turbulence(name, colors, 1.5, seed), colors[1], 0.25, 0.16)
        move(s, s.ball(name, at, radius, material), way)
    lamp = s.g.add_material("lamp", (0, 0, 0), emission=(260.0, 235.0, 200.0), diffuse_only=True)
    for i, at in enumerate([(-0.9, 1.1, 1.3), (0.1, 1.4, 1.1), (1.0, 0.9, 1.3), (0.6, -0.5, 1.2), (-0.8, 0.0, 1.4)]):
        s.ball("lamp %d" % i, at, 0.035, lamp, level=2)
    s.soft_box("key", (-1.3, 1.5, 1.1), (0, 0.2, 0), 1.0, 1.0, (7.0, 6.4, 5.6))
    s.soft_box("rim", (1.6, 0.4, -0.2), (0, 0.2, 0), 0.3, 1.2, (6.0, 7.4, 10.0))
    return s.finish("figure 15", (0.0, 0.26, 1.85), (0.0, 0.215, 0.0), 26, GPU_ASPECT, shutterOpen=0.0, shutterClose=SHUTTER_S)


def figure_16():
    """All effects: mirrors, gloss, glass clear and frosted, stripes, checkers, turbulence, a lens and a shutter."""
    s = Studio(EVENING, 0.4)
    s.add("parallelogram", quad((-1.5, 0, 0.75), (2.7, 0, 0.0), (0.30, 0, -1.75)).without_uvs(), s.metal("plate", (0.15, 0.18, 0.24), 0.10))
    colors = [IVORY, (0.028, 0.06, 0.13), IVORY, CORAL]
    stripes = s.picture("stripes", images.paint(24, 1, 3, lambda x, _: images.srgb(colors[x % 4])))
    s.add("striped patch", quad((-0.98, 0.0, -0.62), (0.96, 0, 0.0), (0, 0.56, 0)), s.g.add_material("stripes", stripes, 0.0, 0.7))
    patch = turbulence("patch", NIGHT, 2.8, 5.1, 7, 1.1)
    s.add("patch", quad((0.02, 0.0, -0.62), (0.96, 0, 0.0), (0, 0.56, 0)).without_uvs(), textured(s.g, "patch", patch, (0.03, 0.05, 0.1), 0.0, 0.6))
    s.ball("glass sphere", (-0.36, 0.182, 0.02), 0.18, s.glass("glass", (0.82, 0.94, 0.95), 0.6))
    cube = beveled_box((-0.11, 0.0, -0.11), (0.11, 0.22, 0.11), 0.005).without_uvs().rotated("y", 28)
    s.add("frosted cube", cube, s.glass("frosted glass", (0.66, 0.90, 0.86), 0.5, 0.25), translation=[0.30, 0.002, 0.16])
    s.ball("mirror", (0.02, 0.16, -0.30), 0.158, s.metal("silver", SILVER))
    board = procedurals.checkerboard((0.82, 0.79, 0.72), (0.05, 0.06, 0.09), (16.0, 8.0))
    s.ball("checkerboard", (0.02, 0.082, 0.30), 0.08, textured(s.g, "checkerboard", board, (0.4, 0.4, 0.4), 0.0, 0.12), textured=True)
    s.ball("gold", (-0.20, 0.052, 0.42), 0.05, s.metal("gold", GOLD, 0.12))
    s.ball("behind the cube", (0.40, 0.12, -0.16), 0.118, s.lacquer("amber", AMBER, 0.08))
    ember = textured(s.g, "ember", turbulence("ember", EMBER, 1.5, 1.0), EMBER[1], 0.25, 0.16)
    move(s, s.ball("ember", (0.40, 0.44, -0.06), 0.085, ember), (0.24, 0.07, 0.0))
    s.soft_box("key", (-1.4, 1.6, 1.2), (0, 0.15, 0), 1.3, 1.3, (8.0, 7.4, 6.5))
    s.soft_box("strip", (1.6, 0.9, 0.5), (0, 0.15, 0), 0.25, 1.4, (5.0, 6.6, 9.0))
    return s.finish("figure 16", (0.0, 0.56, 2.10), (-0.01, 0.20, 0.0), 26, GPU_ASPECT, fStop=2.0, focalLength=0.085,
                    focusDistance=2.08, apertureBlades=6, shutterOpen=0.0, shutterClose=SHUTTER_S)


FIGURES = {"figure_11": figure_11, "figure_15": figure_15, "figure_16": figure_16}
