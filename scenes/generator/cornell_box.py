# SPDX-License-Identifier: Apache-2.0
"""The Cornell box with its published measures.

Geometry in millimeters as measured at Cornell (graphics.cornell.edu/online/box/data.html); here one unit is 100 mm, the origin
is on the floor below the middle, and the camera looks along -z. Reflectances and emission are the usual linear Rec. 709
values for the measured spectra. All surfaces are purely diffuse.
"""
import math

from .gltf import Gltf
from .shapes import Mesh, joined
from .gltf import cross, normalize, subtract

WHITE = (0.725, 0.71, 0.68)
RED = (0.63, 0.065, 0.05)
GREEN = (0.14, 0.45, 0.091)
EMISSION = (17.0, 12.0, 4.0)


def _point(x, y, z):
    return ((278.0 - x) / 100.0, y / 100.0, (279.6 - z) / 100.0)


def _face(*corners):
    p = [_point(*corner) for corner in corners]
    n = normalize(cross(subtract(p[1], p[0]), subtract(p[2], p[0])))
    return Mesh(p, [n] * 4, (), [0, 1, 2, 0, 2, 3])


def _block(top):
    """Top corners as published, in the order that makes the top face up."""
    low = [(x, 0.0, z) for x, _, z in top]
    sides = [_face(top[i], low[i], low[(i + 1) % 4], top[(i + 1) % 4]) for i in range(4)]
    return joined([_face(*top)] + sides)


def build():
    g = Gltf()
    white = g.add_material("white", WHITE, diffuse_only=True)
    red = g.add_material("red", RED, diffuse_only=True)
    green = g.add_material("green", GREEN, diffuse_only=True)
    light = g.add_material("light", (0.78, 0.78, 0.78), emission=EMISSION, diffuse_only=True)

    floor = _face((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))
    ceiling = _face((556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0))
    back = _face((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))
    right = _face((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))
    left = _face((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))
    # Half a millimeter below the ceiling.
    lamp = _face((343, 548.3, 227), (343, 548.3, 332), (213, 548.3, 332), (213, 548.3, 227))
    short = _block([(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)])
    tall = _block([(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)])

    roots = [
        g.add_node("room", mesh=g.add_mesh("room", [(joined([floor, ceiling, back]), white), (left, red), (right, green)])),
        g.add_node("short block", mesh=g.add_mesh("short block", [(short, white)])),
        g.add_node("tall block", mesh=g.add_mesh("tall block", [(tall, white)])),
        g.add_node("light", mesh=g.add_mesh("light", [(lamp, light)])),
        # A 35 mm lens and a sensor of 25 x 25 mm.
        g.add_camera_node("camera", _point(278, 273, -800), _point(278, 273, 0), 2 * math.atan(0.0125 / 0.035), 1.0),
    ]
    return {"cornell_box.glb": g.finish(roots, "Cornell box").to_glb()}
