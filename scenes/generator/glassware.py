# SPDX-License-Identifier: Apache-2.0
"""Things behind glass: a candle in a hurricane glass, a pear under a bell, a vase of marbles.

Every wall of glass is a closed mesh with an inside and an outside, so light is refracted twice on its way in."""
import math

from . import images
from .gltf import Gltf
from .shapes import joined, lathe, quad, sphere, tube

SEGMENTS = 48


def build():
    g = Gltf()
    roots = []

    def add(name, mesh, material, at=None):
        roots.append(g.add_node(name, mesh=g.add_mesh(name, [(mesh, material)]), translation=at))

    for extension in ("transmission", "volume", "ior"):
        g.use("KHR_materials_" + extension)
    clear = _glass(g, "clear glass", (0.97, 0.99, 0.98), 0.15)
    smoky = _glass(g, "blue glass", (0.35, 0.68, 0.85), 0.012)
    table = g.add_material("table", g.add_texture("table", _table_picture()), 0.0, 0.7)
    wax = g.add_material("wax", (0.84, 0.78, 0.66), 0.0, 0.6)
    brass = g.add_material("brass", (0.89, 0.66, 0.28), 1.0, 0.3)
    add("table", quad((-6, 0, 6), (12, 0, 0), (0, 0, -12), (10, 10)), table)

    add("candle", lathe([(0.0, 0.03), (0.13, 0.03), (0.13, 0.36), (0.10, 0.375), (0.03, 0.36), (0.0, 0.36)], SEGMENTS).without_uvs(), wax,
        (-0.72, 0, 0))
    add("wick", tube([(0, 0.35, 0), (0.004, 0.40, 0.002), (0.018, 0.43, 0.0)], [0.008, 0.007, 0.005]).without_uvs(),
        g.add_material("wick", (0.02, 0.02, 0.02), 0.0, 0.9), (-0.72, 0, 0))
    add("hurricane glass", _shell([(0.20, 0.012), (0.25, 0.10), (0.28, 0.25), (0.26, 0.42), (0.22, 0.55), (0.24, 0.66)], 0.012), smoky,
        (-0.72, 0, 0))

    add("pear", lathe(_smooth([(0.0, 0.05), (0.10, 0.055), (0.17, 0.13), (0.165, 0.22), (0.11, 0.31), (0.075, 0.39), (0.05, 0.43), (0.0, 0.44)]),
                      SEGMENTS, sharp_deg=180.0).without_uvs(), g.add_material("pear", (0.52, 0.56, 0.10), 0.0, 0.45), (0.05, 0, -0.1))
    add("stem", tube([(0, 0.43, 0), (0.008, 0.49, 0), (0.03, 0.53, 0.01)], [0.011, 0.009, 0.013]).without_uvs(),
        g.add_material("stem", (0.12, 0.07, 0.03), 0.0, 0.8), (0.05, 0, -0.1))
    add("plate", lathe([(0.0, 0.0), (0.33, 0.0), (0.35, 0.02), (0.35, 0.045), (0.0, 0.045)], SEGMENTS).without_uvs(), brass, (0.05, 0, -0.1))
    add("bell", _bell(), clear, (0.05, 0, -0.1))

    add("vase", _shell([(0.14, 0.012), (0.17, 0.05), (0.17, 0.60)], 0.014, 0.02), clear, (0.78, 0, 0.05))
    colors = ((0.75, 0.10, 0.06), (0.92, 0.62, 0.10), (0.10, 0.32, 0.60), (0.80, 0.80, 0.78), (0.10, 0.45, 0.25))
    marbles = [g.add_material("marble %d" % i, color, 0.0, 0.35) for i, color in enumerate(colors)]
    ball = sphere(0.052, 24, 12).without_uvs()
    for layer in range(6):
        for i in range(5):
            angle = 2.0 * math.pi * (i + 0.5 * layer) / 5
            at = (0.78 + 0.095 * math.cos(angle), 0.087 + 0.083 * layer, 0.05 + 0.095 * math.sin(angle))
            add("marble", ball, marbles[(2 * i + layer) % 5], at)
    roots.append(g.add_camera_node("camera", (0.25, 0.85, 2.6), (0.02, 0.28, 0), math.radians(25.5), 16 / 9))
    return {"glassware.glb": g.finish(roots, "glassware").to_glb()}


def _glass(g, name, color, distance):
    return g.add_material(name, (1.0, 1.0, 1.0), 0.0, 0.0, extensions={
        "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5},
        "KHR_materials_volume": {"thicknessFactor": 0.02, "attenuationDistance": distance, "attenuationColor": list(color)}})


def _smooth(profile, steps=6):
    """A Catmull-Rom curve through a profile."""
    points = [profile[0]] + list(profile) + [profile[-1]]
    result = []
    for a, b, c, d in zip(points, points[1:], points[2:], points[3:]):
        for i in range(steps):
            t = i / steps
            result.append(tuple(0.5 * (2 * b[k] + (c[k] - a[k]) * t + (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k]) * t * t +
                                       (3 * b[k] - a[k] - 3 * c[k] + d[k]) * t ** 3) for k in range(2)))
    result.append(tuple(profile[-1]))
    return [(max(r, 0.0), y) for r, y in result]


def _shell(outside, wall, foot=0.012):
    """An open vessel: its outside, its rim and its inside, a wall apart; the bottom is as thick as its foot."""
    curve = _smooth(outside)
    bottom = curve[0][1]
    profile = [(0.0, bottom)] + curve
    profile += [(r - wall, y) for r, y in reversed(curve) if y > bottom + foot] + [(curve[0][0] - wall, bottom + foot), (0.0, bottom + foot)]
    return lathe(profile, SEGMENTS, sharp_deg=60.0).without_uvs()


def _bell():
    """A dome with a knob over the plate."""
    radius, wall, low, high = 0.29, 0.012, 0.047, 0.42
    dome = [(radius, low), (radius, high)] + [(radius * math.cos(a), high + radius * math.sin(a))
                                             for a in (math.pi / 2 * i / 16 for i in range(1, 17))]
    dome[-1] = (0.0, dome[-1][1])
    inner = [((radius - wall) * math.cos(a), high + (radius - wall) * math.sin(a)) for a in (math.pi / 2 * i / 16 for i in range(16, 0, -1))]
    inner[0] = (0.0, inner[0][1])
    body = _walls(dome, inner + [(radius - wall, high), (radius - wall, low), (radius, low)])
    return joined([body, sphere(0.035, 24, 12).without_uvs().moved(y=high + radius + 0.033)])


def _walls(outside, inside):
    """Two runs of a profile, each smooth."""
    return joined([lathe(outside, SEGMENTS, sharp_deg=60.0).without_uvs(), lathe(inside, SEGMENTS, sharp_deg=60.0).without_uvs()])


def _table_picture():
    def pixel(x, y):
        board = y // 32
        grain = images.fractal(x / 64 + 0.37 * board, y / 8, 8, 16, 3, 3 + board)
        line = y % 32 < 1
        tone = (0.42 + 0.10 * images.hash_unit(board, 0, 7) + 0.16 * (grain - 0.5)) * (0.5 if line else 1.0)
        return (tone, tone * 0.72, tone * 0.48)

    return images.paint(128, 128, 3, pixel, 64)
