# SPDX-License-Identifier: Apache-2.0
"""A swimming pool under a sun: caustics seen through water, in a mirror and through glass.

The water is a closed mesh that reaches a little into floor and walls, so that rays leave it by its surface alone."""
import math

from . import images
from .gltf import Gltf, normalize
from .shapes import Mesh, beveled_box, joined, quad, sheet, sphere

HALF_X, HALF_Z, DEPTH, LEVEL = 2.0, 3.0, 1.3, -0.14  # meters; the deck is at 0
COLUMNS, ROWS = 64, 96
SUN = normalize((-0.38, -1.0, -0.52))  # the direction of its light


def build():
    g = Gltf()
    roots = []

    def add(name, mesh, material, at=None):
        roots.append(g.add_node(name, mesh=g.add_mesh(name, [(mesh, material)]), translation=at))

    tiles = g.add_material("tiles", g.add_texture("tiles", _tile_picture()), 0.0, 0.9, diffuse_only=True)
    add("basin", _basin(), tiles)
    stone = g.add_material("stone", g.add_texture("stone", _stone_picture()), 0.0, 0.8)
    add("deck", _deck(), stone)
    g.use("KHR_materials_transmission")
    g.use("KHR_materials_volume")
    g.use("KHR_materials_ior")
    add("water", _water(), _clear(g, "water", 1.33, 0.0, 4.0, (0.35, 0.75, 0.82)))
    ball = sphere(0.42, 56, 28).without_uvs()
    add("chrome ball", ball, g.add_material("chrome", (0.95, 0.95, 0.95), 1.0, 0.0), (-1.2, 0.422, -3.6))
    add("glass ball", sphere(0.34, 56, 28).without_uvs(), _clear(g, "glass", 1.5, 0.0, 1.0, (1.0, 1.0, 1.0)), (-2.6, 0.342, -0.9))
    red = g.add_material("beach ball", (0.75, 0.06, 0.04), 0.0, 0.35)
    add("beach ball", sphere(0.30, 40, 20).without_uvs(), red, (0.55, LEVEL + 0.14, -1.3))
    sun = g.add_light("sun", "directional", (1.0, 0.95, 0.86), 3.6)
    roots.append(g.add_node("sun", rotation=_turn_to(SUN), extensions=sun))
    roots.append(g.add_camera_node("camera", (2.9, 2.35, 3.1), (-0.75, -0.45, -1.35), math.radians(40), 16 / 9))
    g.finish(roots, "pool")
    _add_sky(g)
    return {"pool.glb": g.to_glb()}


def _clear(g, name, ior, roughness, distance, color):
    return g.add_material(name, (1.0, 1.0, 1.0), 0.0, roughness, extensions={
        "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": ior},
        "KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationDistance": distance, "attenuationColor": list(color)}})


def _height(x, z):
    """Ripples of a few wave lengths and directions, meters."""
    waves = ((0.012, 1.65, 0.3, 0.0), (0.009, 1.15, 1.9, 1.1), (0.006, 0.81, -0.8, 2.3), (0.004, 0.57, 2.5, 0.4), (0.0022, 0.39, 1.2, 3.7))
    return sum(a * math.sin(2.0 * math.pi / length * (x * math.cos(turn) + z * math.sin(turn)) + phase) for a, length, turn, phase in waves)


def _water():
    """Its sides and bottom are hidden in the walls and the floor."""
    x1, z1, low = HALF_X + 0.04, HALF_Z + 0.04, -DEPTH - 0.04

    def top(u, v):
        x, z = (2.0 * u - 1.0) * x1, (1.0 - 2.0 * v) * z1
        return (x, LEVEL + _height(x, z), z)

    surface = sheet(top, COLUMNS, ROWS).without_uvs()
    skirt = Mesh()
    edge = ([(i / COLUMNS, 0.0) for i in range(COLUMNS)] + [(1.0, j / ROWS) for j in range(ROWS)] +
            [(1.0 - i / COLUMNS, 1.0) for i in range(COLUMNS)] + [(0.0, 1.0 - j / ROWS) for j in range(ROWS)])
    for start, end in zip(edge, edge[1:] + edge[:1]):
        a, b = top(*start), top(*end)
        n = normalize((b[2] - a[2], 0.0, a[0] - b[0]))
        n = n if n[0] * a[0] + n[2] * a[2] > 0.0 else (-n[0], 0.0, -n[2])
        base = len(skirt.positions)
        skirt.positions += [a, b, (b[0], low, b[2]), (a[0], low, a[2])]
        skirt.normals += [n] * 4
        skirt.indices += [base, base + 2, base + 1, base, base + 3, base + 2]
    bottom = quad((-x1, low, -z1), (2 * x1, 0, 0), (0, 0, 2 * z1)).without_uvs()
    return joined([surface, skirt, bottom])


def _basin():
    """Floor and walls, seen from inside; four tiles to a meter."""
    x, z, d = HALF_X, HALF_Z, DEPTH
    return joined([quad((-x, -d, z), (2 * x, 0, 0), (0, 0, -2 * z), (2 * x, 2 * z)),
                   quad((-x, -d, -z), (2 * x, 0, 0), (0, d, 0), (2 * x, d)),
                   quad((x, -d, z), (-2 * x, 0, 0), (0, d, 0), (2 * x, d)),
                   quad((-x, -d, z), (0, 0, -2 * z), (0, d, 0), (2 * z, d)),
                   quad((x, -d, -z), (0, 0, 2 * z), (0, d, 0), (2 * z, d))])


def _deck():
    """Slabs around the basin, with a rounded edge over the water, and the ground around them."""
    x, z, w = HALF_X, HALF_Z, 30.0
    slabs = [beveled_box((-w, -0.06, -w), (w, 0.0, -z + 0.03), 0.015), beveled_box((-w, -0.06, z - 0.03), (w, 0.0, w), 0.015),
             beveled_box((-w, -0.06, -z + 0.03), (-x + 0.03, 0.0, z - 0.03), 0.015),
             beveled_box((x - 0.03, -0.06, -z + 0.03), (w, 0.0, z - 0.03), 0.015)]
    return joined(slabs).with_uvs(lambda p: (p[0] * 0.5, p[2] * 0.5))


def _turn_to(direction):
    """The rotation from -z, along which lights shine, to a direction."""
    x, y, z = direction
    axis = (y, -x, 0.0)  # (0, 0, -1) x direction
    w = 1.0 - z
    length = math.sqrt(axis[0] ** 2 + axis[1] ** 2 + w * w)
    return [axis[0] / length, axis[1] / length, 0.0, w / length]


def _tile_picture():
    def pixel(x, y):
        if x % 16 == 0 or y % 16 == 0:
            return (0.80, 0.84, 0.86)
        tone = 0.92 + 0.10 * images.hash_unit(x // 16, y // 16, 5)
        return tuple(min(1.0, tone * c) for c in (0.42, 0.72, 0.84))

    return images.paint(64, 64, 3, pixel, 64)


def _stone_picture():
    def pixel(x, y):
        joint = x in (0, 63) or y in (0, 63)
        tone = 0.66 + 0.07 * images.fractal(x / 64, y / 64, 8, 8, 3, 2) + 0.02 * images.hash_unit(x, y, 9)
        return (0.45, 0.43, 0.40) if joint else (tone, tone * 0.96, tone * 0.90)

    return images.paint(64, 64, 3, pixel, 64)


def _add_sky(g):
    """A clear sky as EXT_lights_image_based: a cube of six small images, linear in their bytes' square."""
    faces = (lambda a, b: (1.0, -b, -a), lambda a, b: (-1.0, -b, a), lambda a, b: (a, 1.0, b), lambda a, b: (a, -1.0, -b),
             lambda a, b: (a, -b, 1.0), lambda a, b: (-a, -b, -1.0))

    def picture(face):
        def pixel(x, y):
            height = normalize(face((x + 0.5) / 8.0 - 1.0, (y + 0.5) / 8.0 - 1.0))[1]
            if height < 0.0:
                return images.srgb((0.30, 0.29, 0.27))
            return images.srgb(images.mix((0.62, 0.74, 0.90), (0.14, 0.32, 0.70), images.smooth(0.0, 0.8, height)))

        return images.paint(16, 16, 3, pixel)

    cube = [g.add_image("sky %d" % i, picture(face)) for i, face in enumerate(faces)]
    ambient = [[0.7, 0.8, 1.0]] + [[0.0, 0.0, 0.0]] * 8
    g.use("EXT_lights_image_based")
    g.json.setdefault("extensions", {})["EXT_lights_image_based"] = {"lights": [
        {"name": "sky", "intensity": 0.9, "irradianceCoefficients": ambient, "specularImageSize": 16, "specularImages": [cube]}]}
    g.json["scenes"][0]["extensions"] = {"EXT_lights_image_based": {"light": 0}}
