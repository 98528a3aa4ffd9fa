# SPDX-License-Identifier: Apache-2.0
"""Figures 1 and 5 to 8: mirrors over a checkerboard, depth of field, antialiasing, soft shadows."""
import math

from . import images
from .paper_stage import AMBER, CORAL, GOLD, IVORY, PAPER_ASPECT, ROSE, STEEL_BLUE, TEAL, Studio, checkers
from .shapes import Mesh, beveled_box, torus

DUSK = ((0.008, 0.030, 0.12), (0.78, 0.46, 0.30), (0.05, 0.05, 0.07))
STUDIO = ((0.10, 0.12, 0.15), (0.24, 0.25, 0.27), (0.12, 0.12, 0.12))


def figure_01():
    """The scene for timings: glass, mirror and lacquer over a checkerboard, two point lights, and a net of mirrors behind
    with endless reflections. Its spheres are coarse, so that a tracer without an accelerator can finish."""
    s = Studio(DUSK, 0.34)
    board = s.g.add_material("checkerboard", s.picture("checkerboard", checkers(IVORY, (0.035, 0.075, 0.11))), 0.0, 0.0)
    s.floor(board, 6.0, 2.5)
    s.ball("glass sphere", (-0.26, 0.205, 0.16), 0.20, s.glass("glass"), level=4)
    s.ball("mirror sphere", (0.30, 0.255, -0.12), 0.25, s.metal("mirror"), level=4)
    s.ball("lacquer sphere", (0.10, 0.105, 0.42), 0.10, s.lacquer("lacquer", (0.60, 0.035, 0.03)), level=3)
    s.ball("gold sphere", (-0.52, 0.085, 0.42), 0.08, s.metal("gold", GOLD), level=3)
    metals = [s.metal("silver"), s.metal("rose", ROSE), s.metal("steel", STEEL_BLUE), s.metal("small gold", GOLD)]
    for row in range(4):
        for column in range(9):
            angle = math.radians(-52 + 13 * column)
            radius = 1.05
            at = (radius * math.sin(angle), 0.075 + 0.155 * row, 0.25 - radius * math.cos(angle))
            s.ball("net %d %d" % (row, column), at, 0.066, metals[(column + 2 * row) % 4], level=2)
    s.lamp("key", (-1.5, 2.1, 1.9), (1.0, 0.91, 0.78), 15.0)
    s.lamp("fill", (1.9, 1.5, 1.5), (0.66, 0.80, 1.0), 6.0)
    return s.finish("figure 1", (0.05, 0.62, 2.15), (0.0, 0.235, 0.0), 33, PAPER_ASPECT)


def figure_05():
    """Three spheres at three depths, the middle one in focus."""
    s = Studio(STUDIO)
    s.sweep(s.matte("sweep", (0.30, 0.40, 0.50)), back=-2.6)
    s.ball("near", (-0.20, 0.10, 0.52), 0.10, s.lacquer("coral", CORAL, 0.05))
    s.ball("middle", (0.0, 0.13, 0.0), 0.13, s.lacquer("teal", TEAL, 0.05))
    s.ball("far", (0.36, 0.16, -0.90), 0.16, s.lacquer("amber", AMBER, 0.05))
    s.soft_box("key", (-1.25, 1.5, 0.9), (0, 0.1, -0.1), 0.9, 0.9, (15.0, 13.6, 11.6))
    s.soft_box("rim", (1.5, 0.8, -1.1), (0, 0.1, -0.2), 0.35, 1.1, (5.0, 6.6, 8.6))
    return s.finish("figure 5", (0.0, 0.34, 1.75), (0.02, 0.135, 0.0), 24, 600 / 500, fStop=1.4, focalLength=0.085,
                    focusPoint=[0.49, 0.5])


def figure_06():
    """Edges of every slope: a star of black and white, a checkerboard to the horizon, a striped sphere."""
    s = Studio(((0.10, 0.26, 0.46), (0.52, 0.64, 0.70), (0.3, 0.3, 0.3)))
    s.floor(s.g.add_material("checkerboard", s.picture("checkerboard", checkers((0.82, 0.80, 0.76), (0.02, 0.02, 0.025))), 0.0, 1.0), 9.0, 3.0)
    s.add("star", _star(0.30, 36), s.matte("black", (0.015, 0.015, 0.02)), translation=[0.12, 0.34, -0.25])
    s.add("star's ground", _disc(0.335, 96, -0.004), s.matte("white", (0.85, 0.84, 0.80)), translation=[0.12, 0.34, -0.25])
    s.ball("red ball", (-0.25, 0.14, 0.14), 0.14, s.lacquer("red", (0.62, 0.05, 0.04), 0.2))
    for i in range(9):
        bar = beveled_box((-0.0022, 0, -0.0022), (0.0022, 0.62, 0.0022), 0.0002).without_uvs()
        s.add("rod %d" % i, bar.rotated("z", 14 - 3.6 * i), s.matte("rod %d" % i, images.mix(TEAL, (0.02, 0.05, 0.12), i / 8)), translation=[-0.50 + 0.026 * i, 0, -0.16])
    s.soft_box("key", (-1.0, 2.2, 1.6), (0, 0.1, 0), 0.7, 0.7, (24.0, 22.0, 19.0))
    return s.finish("figure 6", (-0.02, 0.42, 1.75), (-0.06, 0.25, 0.0), 28, PAPER_ASPECT)


def _disc(radius, segments, z):
    ring = [(radius * math.cos(2 * math.pi * i / segments), radius * math.sin(2 * math.pi * i / segments), z) for i in range(segments)]
    return Mesh([(0.0, 0.0, z)] + ring, [(0.0, 0.0, 1.0)] * (segments + 1), (),
                [k for i in range(segments) for k in (0, 1 + i, 1 + (i + 1) % segments)])


def _star(radius, rays):
    """Every second one of 2 * rays sectors of a disc."""
    result = Mesh()
    for i in range(rays):
        a, b = 2 * math.pi * i / rays, 2 * math.pi * (i + 0.5) / rays
        result.append(Mesh([(0, 0, 0), (radius * math.cos(a), radius * math.sin(a), 0), (radius * math.cos(b), radius * math.sin(b), 0)],
                           [(0, 0, 1)] * 3, (), [0, 1, 2]))
    return result


def figure_07():
    """A rectangular light over objects on and above the ground: shadows soften with distance."""
    s = Studio(((0.07, 0.09, 0.12), (0.13, 0.14, 0.16), (0.1, 0.1, 0.1)))
    s.sweep(s.matte("sweep", (0.62, 0.58, 0.53)), back=-1.2, bend=0.4)
    s.ball("ball", (-0.27, 0.14, 0.14), 0.14, s.lacquer("coral", CORAL, 0.3))
    s.add("pillar", beveled_box((-0.055, 0, -0.055), (0.055, 0.52, 0.055), 0.004).without_uvs().rotated("y", 28), s.matte("ivory", IVORY), translation=[0.10, 0, -0.30])
    s.add("ring", torus(0.13, 0.036, 80, 28).without_uvs().rotated("x", 66).rotated("y", -24), s.lacquer("teal", TEAL, 0.3), translation=[0.34, 0.152, 0.22])
    s.ball("floating ball", (0.115, 0.62, -0.29), 0.082, s.lacquer("amber", AMBER, 0.3))
    s.soft_box("rectangular light", (-0.75, 1.55, 0.55), (0.0, 0.1, 0.0), 0.75, 0.42, (36.0, 32.0, 26.0))
    return s.finish("figure 7", (0.15, 0.62, 2.05), (0.02, 0.275, -0.05), 27, PAPER_ASPECT)


def figure_08():
    """Depth of field, soft shadows and smooth edges at once: a receding row of spheres."""
    s = Studio(((0.02, 0.04, 0.09), (0.30, 0.33, 0.38), (0.10, 0.10, 0.10)))
    board = s.g.add_material("checkerboard", s.picture("checkerboard", checkers((0.76, 0.73, 0.67), (0.035, 0.05, 0.075))), 0.0, 0.0)
    s.floor(board, 6.0, 2.6)
    colors = [CORAL, AMBER, IVORY, TEAL, (0.06, 0.10, 0.34)]
    for i, color in enumerate(colors):
        s.ball("sphere %d" % i, (-0.24 + 0.17 * i, 0.105, 0.56 - 0.46 * i), 0.105, s.lacquer("lacquer %d" % i, color, 0.02))
    s.ball("mirror", (-0.36, 0.17, -0.50), 0.17, s.metal("mirror"))
    s.ball("gold", (0.235, 0.055, 0.44), 0.055, s.metal("gold", GOLD))
    s.soft_box("rectangular light", (-0.9, 1.7, 0.9), (0.0, 0.1, -0.2), 0.9, 0.55, (26.0, 23.5, 20.0))
    return s.finish("figure 8", (0.10, 0.44, 1.80), (0.01, 0.125, -0.12), 24, PAPER_ASPECT, fStop=1.4, focalLength=0.085,
                    focusPoint=[0.45, 0.5])


FIGURES = {"figure_01": figure_01, "figure_05": figure_05, "figure_06": figure_06, "figure_07": figure_07, "figure_08": figure_08}
