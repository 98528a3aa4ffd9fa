# SPDX-License-Identifier: Apache-2.0
"""Figures 9 to 14: Whitted and glossy reflection, refraction and translucency, a lens."""
from . import images
from .paper_stage import CORAL, GOLD, GPU_ASPECT, IVORY, SILVER, Studio
from .shapes import beveled_box, quad

SUNSET = ((0.012, 0.04, 0.17), (0.95, 0.50, 0.28), (0.10, 0.045, 0.13))
MORNING = ((0.10, 0.16, 0.26), (0.34, 0.35, 0.36), (0.15, 0.15, 0.15))


def _mirrors(roughness, name):
    """Two mirror spheres over a mirror in the form of a parallelogram, in the evening."""
    s = Studio(SUNSET, 0.4)
    s.add("parallelogram", quad((-0.60, 0, 0.36), (0.92, 0, 0.0), (0.24, 0, -0.70)).without_uvs(), s.metal("plate", (0.16, 0.23, 0.33), roughness))
    s.ball("left sphere", (-0.225, 0.215, -0.02), 0.20, s.metal("silver", SILVER, roughness))
    s.ball("right sphere", (0.195, 0.165, 0.04), 0.15, s.metal("gold", GOLD, roughness))
    s.soft_box("key", (-1.3, 1.7, 1.5), (0, 0.1, 0), 0.9, 0.9, (5.5, 5.2, 4.9))
    s.soft_box("strip", (1.7, 0.7, 0.7), (0, 0.15, 0), 0.22, 1.3, (3.2, 4.4, 6.0))
    return s.finish(name, (0.04, 0.50, 1.85), (-0.02, 0.135, -0.02), 25, GPU_ASPECT)


def figure_09():
    return _mirrors(0.0, "figure 9")


def figure_10():
    return _mirrors(0.22, "figure 10")


def _stripes(name, roughness):
    """A glass sphere in front of stripes."""
    s = Studio(MORNING)
    s.sweep(s.matte("sweep", (0.36, 0.38, 0.40)), back=-1.4, bend=0.5)
    colors = [IVORY, (0.028, 0.06, 0.13), IVORY, CORAL]
    stripes = s.picture("stripes", images.paint(32, 1, 3, lambda x, _: images.srgb(colors[x % 4])))
    patch = quad((-1.0, 0.0, -0.85), (2.0, 0, 0), (0, 1.0, 0))
    s.add("striped patch", patch, s.g.add_material("stripes", stripes, 0.0, 0.8))
    s.ball("glass sphere", (0.0, 0.252, 0.0), 0.25, s.glass("glass", (0.80, 0.93, 0.95), 0.6, roughness))
    s.soft_box("key", (-1.3, 1.5, 1.0), (0, 0.2, -0.1), 1.9, 1.6, (5.6, 5.2, 4.5))
    s.soft_box("rim", (1.4, 0.9, 0.5), (0, 0.2, 0), 0.35, 1.2, (4.0, 4.8, 6.0))
    return s.finish(name, (0.0, 0.42, 1.75), (0.0, 0.30, -0.05), 27.5, GPU_ASPECT)


def _cube(name, roughness):
    """A sphere behind a glass cube."""
    s = Studio(MORNING)
    s.sweep(s.matte("sweep", (0.56, 0.45, 0.34)), back=-1.7, bend=0.6)
    cube = beveled_box((-0.17, 0.0, -0.17), (0.17, 0.34, 0.17), 0.006).without_uvs().rotated("y", 24)
    s.add("glass cube", cube, s.glass("glass", (0.66, 0.90, 0.86), 0.5, roughness), translation=[-0.09, 0.002, 0.10])
    s.ball("sphere behind", (0.08, 0.21, -0.40), 0.21, s.lacquer("coral", CORAL, 0.1))
    s.ball("small sphere", (0.33, 0.07, 0.10), 0.07, s.metal("gold", GOLD, 0.08))
    s.soft_box("key", (-1.3, 1.5, 1.0), (0, 0.2, -0.1), 1.9, 1.6, (5.6, 5.2, 4.5))
    s.soft_box("rim", (1.4, 0.9, -0.5), (0, 0.2, 0), 0.35, 1.2, (5.0, 6.0, 7.6))
    return s.finish(name, (0.12, 0.52, 1.72), (0.03, 0.175, -0.05), 25, GPU_ASPECT)


def figure_14():
    """A lens focused on the sphere behind; the one in front is blurred."""
    s = Studio(((0.008, 0.014, 0.04), (0.055, 0.075, 0.15), (0.02, 0.02, 0.035)))
    s.floor(s.lacquer("table", (0.022, 0.022, 0.03), 0.16), 8.0)
    s.ball("near", (-0.215, 0.11, 0.50), 0.11, s.lacquer("coral", CORAL, 0.04))
    s.ball("far", (0.20, 0.20, -0.55), 0.20, s.metal("gold", GOLD, 0.22))
    _lights_behind(s)
    s.soft_box("key", (-1.3, 1.3, 0.9), (0, 0.1, -0.2), 1.1, 1.1, (15.0, 13.4, 11.2))
    s.soft_box("rim", (1.3, 0.6, -0.9), (0, 0.15, -0.3), 0.35, 1.1, (4.0, 6.4, 9.6))
    s.soft_box("front", (0.9, 0.9, 2.2), (0, 0.15, -0.3), 2.2, 1.2, (2.6, 2.6, 2.8))
    return s.finish("figure 14", (0.0, 0.30, 1.62), (0.02, 0.165, -0.2), 25, GPU_ASPECT, fStop=1.0, focalLength=0.085,
                    focusPoint=[0.62, 0.48], apertureBlades=7, apertureRotation=0.2)


def _lights_behind(s):
    """A street at night: bulbs that the lens blurs to discs."""
    hues = [(16.0, 8.0, 2.6), (14.0, 12.0, 8.6), (14.0, 3.2, 1.8), (3.4, 10.0, 14.0)]
    bulbs = [s.g.add_material("bulb %d" % i, (0, 0, 0), emission=hue, diffuse_only=True) for i, hue in enumerate(hues)]
    for i in range(40):
        u, v, w = (images.hash_unit(i, k, 14) for k in range(3))
        depth = -2.6 - 3.4 * w
        across = 0.60 * (1.6 - depth) * (u - 0.5)
        s.ball("bulb %d" % i, (across, 0.10 + 0.17 * v * (1.6 - depth), depth), 0.018, bulbs[i % 4], level=2)


FIGURES = {
    "figure_09": figure_09, "figure_10": figure_10,
    "figure_12_left": lambda: _stripes("figure 12, left", 0.0), "figure_12_right": lambda: _stripes("figure 12, right", 0.32),
    "figure_13_left": lambda: _cube("figure 13, left", 0.0), "figure_13_right": lambda: _cube("figure 13, right", 0.28),
    "figure_14": figure_14,
}
