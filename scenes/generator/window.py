# SPDX-License-Identifier: Apache-2.0
"""A room in a yard, lit through windows alone; it has no lights and wants an environment."""
from .gltf import Gltf
from .shapes import box, joined, quad

ROOM = (6.0, 3.0, 5.0)  # meters
SILL, LINTEL = 1.0, 2.4  # heights of the lower and upper edge of windows
YARD = ((-20.0, -20.0), (26.0, 25.0))  # x and z
WALL_OF_YARD = 12.0


def _wall(begin, end, low, high):
    """A part of the wall with the windows, from z = begin to end."""
    return quad((ROOM[0], low, begin), (0.0, 0.0, end - begin), (0.0, high - low, 0.0))


def _front(windows):
    """The wall with windows of one width, as far apart as they are wide."""
    width, height, depth = ROOM[2] / (2 * windows + 1), ROOM[1], ROOM[2]
    parts = [_wall(0.0, depth, 0.0, SILL), _wall(0.0, depth, LINTEL, height)]
    parts += [_wall(2 * i * width, (2 * i + 1) * width, SILL, LINTEL) for i in range(windows + 1)]
    return joined(parts)


def window(windows=1):
    x, y, z = ROOM
    g = Gltf()
    plaster = g.add_material("plaster", (0.7, 0.68, 0.65), diffuse_only=True, doubleSided=True)
    room = joined([quad((0, 0, 0), (0, 0, z), (x, 0, 0)), quad((0, y, 0), (x, 0, 0), (0, 0, z)), quad((0, 0, 0), (0, y, 0), (0, 0, z)),
                   quad((0, 0, z), (0, y, 0), (x, 0, 0)), quad((0, 0, 0), (x, 0, 0), (0, y, 0)), _front(windows)])
    table = joined([box((2.5, 0.7, 2.0), (4.0, 0.8, 3.5)), box((3.2, 0.0, 2.6), (3.4, 0.7, 2.8))])
    cupboard = box((1.0, 0.0, 0.5), (1.8, 1.6, 1.2))
    (west, north), (east, south) = YARD
    yard = joined([quad((west, -0.01, north), (0, 0, south - north), (east - west, 0, 0)),
                   quad((west, -0.01, north), (east - west, 0, 0), (0, WALL_OF_YARD, 0))])
    roots = [g.add_node(name, mesh=g.add_mesh(name, [(mesh.without_uvs(), plaster)]))
             for name, mesh in (("room", room), ("table", table), ("cupboard", cupboard), ("yard", yard))]
    roots.append(g.add_camera_node("camera", (0.6, 1.7, 4.5), (4.5, 1.0, 1.5), 1.0))
    return g.finish(roots, "window").to_glb()


SCENES = {"window": (window, "windows", 1)}
