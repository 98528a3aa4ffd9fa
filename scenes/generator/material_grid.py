# SPDX-License-Identifier: Apache-2.0
"""Spheres by roughness (left to right, 0 to 1) and surface (front to back, dielectric to metal)."""
import math

from . import images
from .gltf import Gltf
from .shapes import lathe, quad, sphere

COLUMNS = 7
# Linear. The metals' colors are reflectances at normal incidence.
ROWS = [
    ("ceramic", (0.80, 0.78, 0.74), 0.0),
    ("red lacquer", (0.55, 0.020, 0.018), 0.0),
    ("blue glaze", (0.022, 0.085, 0.33), 0.0),
    ("pewter", (0.46, 0.45, 0.44), 0.5),
    ("gold", (1.000, 0.766, 0.336), 1.0),
    ("copper", (0.955, 0.638, 0.538), 1.0),
    ("silver", (0.972, 0.960, 0.915), 1.0),
]


def _ground_picture():
    def pixel(x, y):
        line = min(x % 32, 31 - x % 32, y % 32, 31 - y % 32)
        tone = 0.30 + 0.10 * images.hash_unit(x // 32, y // 32, 3) + 0.05 * images.fractal(x / 8, y / 8, 16, 16, 3, 5)
        tone *= 0.55 if line < 1 else 1.0
        return (tone, tone * 0.985, tone * 0.96)

    return images.paint(128, 128, 3, pixel, 64)


def build():
    g = Gltf()
    ball = sphere(0.42, 48, 24).without_uvs().moved(y=0.46)
    foot = lathe([(0.0, 0.0), (0.24, 0.0), (0.24, 0.02), (0.17, 0.075)], 32).without_uvs()
    stand = g.add_material("stand", (0.03, 0.03, 0.032), 0.0, 0.4)
    ball_part = foot_part = None
    roots = []
    for row, (name, color, metallic) in enumerate(ROWS):
        for column in range(COLUMNS):
            roughness = column / (COLUMNS - 1)
            material = g.add_material("%s %.2f" % (name, roughness), color, metallic, roughness)
            ball_part = ball_part or g.add_primitive(ball)
            foot_part = foot_part or g.add_primitive(foot, stand)
            mesh = g.add("meshes", {"name": "%s %.2f" % (name, roughness),
                                    "primitives": [{**ball_part, "material": material}, foot_part]})
            x, z = column - (COLUMNS - 1) / 2, (len(ROWS) - 1) / 2 - row
            roots.append(g.add_node("%s %d" % (name, column), mesh=mesh, translation=[x, 0, z]))
    ground = g.add_material("ground", g.add_texture("tiles", _ground_picture()), 0.0, 0.55)
    size = 24.0
    plane = quad((-size, 0, size), (2 * size, 0, 0), (0, 0, -2 * size), (size / 2, size / 2))
    roots.append(g.add_node("ground", mesh=g.add_mesh("ground", [(plane, ground)])))
    roots.append(g.add_camera_node("camera", (-2.4, 6.2, 8.8), (0.05, 0.1, 0.22), math.radians(36)))
    return {"material_grid.glb": g.finish(roots, "material grid").to_glb()}
