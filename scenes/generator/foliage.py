# SPDX-License-Identifier: Apache-2.0
"""`foliage`: trees and grass of cards whose textures cut the leaves out, with stones.

It has no lights: give it an environment. Needs NumPy.
"""
import math

import numpy as np

from .gltf import Gltf
from .large import array_primitive, grid_indices, png_of, value_noise

GREENS = [((.08, .20, .02), (.25, .45, .08)), ((.15, .25, .03), (.40, .50, .10)), ((.05, .15, .03), (.15, .35, .08)), ((.30, .20, .02), (.60, .40, .06))]
TREES, STONES = 46, 4


def _random(seed):
    return np.random.Generator(np.random.PCG64(seed))


def _turbulence(size, seed):
    """Noise of eight octaves in [0, 1], (size, size), periodic."""
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size
    x, y = np.meshgrid(axis, axis)
    total = sum(value_noise(x, y, 4 << octave, seed * 10 + octave) / 1.7 ** octave for octave in range(8) if 4 << octave <= size)
    return (total - total.min()) / (total.max() - total.min())


def _bytes(channels):
    return (np.clip(channels, 0, 1) * 255 + 0.5).astype(np.uint8)


def _blend(dark, light, seed, size=1024):
    share = _turbulence(size, seed)[..., None]
    return np.array(dark) * (1 - share) + np.array(light) * share


def _normals(seed, size=1024):
    height = _turbulence(size, seed) * 60
    slopes = [np.roll(height, -1, axis) - np.roll(height, 1, axis) for axis in (1, 0)]
    normals = np.dstack([-slopes[0], slopes[1], np.full_like(height, 2.0)])
    return normals / np.linalg.norm(normals, axis=2, keepdims=True) * 0.5 + 0.5


def _roughness(seed, size=512):
    share = _turbulence(size, seed)
    return np.dstack([np.zeros_like(share), 0.5 + 0.5 * share, np.zeros_like(share)])


def _leaves(dark, light, seed, size=512):
    """26 leaves, each a pointed ellipse of its own brightness."""
    random = _random(seed)
    y, x = np.mgrid[0:size, 0:size] / size
    color, alpha = _blend(dark, light, seed, size), np.zeros((size, size))
    for _ in range(26):
        cx, cy = random.random(2) * 0.8 + 0.1
        angle, length = random.random() * 2 * math.pi, 0.06 + 0.08 * random.random()
        along = ((x - cx) * math.cos(angle) + (y - cy) * math.sin(angle)) / length
        across = ((y - cy) * math.cos(angle) - (x - cx) * math.sin(angle)) / (0.45 * length)
        inside = along ** 2 + (across / (1 - 0.5 * np.clip(along, -1, 1))) ** 2 < 1
        alpha[inside] = 1
        color[inside] *= 0.8 + 0.4 * random.random()
    return np.dstack([color, alpha])


def _grass(seed, size=512):
    """40 bent blades."""
    random = _random(seed)
    y, x = np.mgrid[0:size, 0:size] / size
    alpha = np.zeros((size, size))
    for _ in range(40):
        foot, bend = random.random(), (random.random() - 0.5) * 0.4
        height, width = 0.5 + 0.5 * random.random(), 0.012 + 0.01 * random.random()
        up = (1 - y) / height
        alpha[(up < 1) & (np.abs(x - foot - bend * up ** 2) < width * (1 - up))] = 1
    return np.dstack([_blend((.10, .25, .03), (.35, .50, .10), seed, size), alpha])


def _solid(g, name, dark, light, seed):
    """A rough material with three textures."""
    base = g.add_texture(name, png_of(_bytes(_blend(dark, light, seed))))
    rough = g.add_texture(name + " roughness", png_of(_bytes(_roughness(seed + 200))))
    bumps = g.add_texture(name + " normals", png_of(_bytes(_normals(seed + 100))))
    return g.add_material(name, base, 1.0, 1.0, pbr={"metallicRoughnessTexture": {"index": rough}}, normalTexture={"index": bumps})


def _cut_out(g, name, pixels, roughness):
    return g.add_material(name, g.add_texture(name, png_of(_bytes(pixels))), 0.0, roughness, alphaMode="MASK", doubleSided=True)


def _cards(g, material, centers, halves_u, halves_v):
    """Squares around `centers` that show a whole texture, its top along halves_v."""
    count = len(centers)
    corners = np.stack([centers - halves_u - halves_v, centers + halves_u - halves_v, centers + halves_u + halves_v,
                        centers - halves_u + halves_v], axis=1).reshape(-1, 3)
    normals = np.cross(halves_u, halves_v)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    uvs = np.tile(np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32), (count, 1))
    indices = np.arange(count, dtype=np.uint32)[:, None] * 4 + np.array([0, 1, 2, 0, 2, 3], np.uint32)
    return array_primitive(g, material, corners, np.repeat(normals, 4, axis=0), indices, uvs)


def _units(random, count):
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _height(x, z):
    return 0.35 * np.sin(0.4 * x) * np.cos(0.33 * z) + 0.15 * np.sin(1.1 * x + 0.7 * z)


def _ground(g, material):
    axis = np.linspace(-30, 30, 120)
    x, z = np.meshgrid(axis, axis)
    slopes = [(_height(x + dx, z + dz) - _height(x - dx, z - dz)) / 0.02 for dx, dz in ((0.01, 0), (0, 0.01))]
    normals = np.stack([-slopes[0], np.ones_like(x), -slopes[1]], axis=2).reshape(-1, 3)
    positions = np.stack([x, _height(x, z), z], axis=2).reshape(-1, 3)
    return array_primitive(g, material, positions, normals / np.linalg.norm(normals, axis=1, keepdims=True), grid_indices(119, 119),
                           positions[:, [0, 2]] * 0.5)


def _trunk(g, material, foot, height, radius):
    angle, up = np.meshgrid(np.linspace(0, 2 * math.pi, 25), np.linspace(0, 1, 8)[::-1])
    around = np.stack([np.cos(angle), np.full_like(angle, 0.1), np.sin(angle)], axis=2)
    positions = foot + np.stack([radius * (1 - 0.6 * up) * np.cos(angle), height * up, radius * (1 - 0.6 * up) * np.sin(angle)], axis=2)
    uvs = np.stack([angle / math.pi, height * up], axis=2)
    normals = around / np.linalg.norm(around, axis=2, keepdims=True)
    return array_primitive(g, material, positions.reshape(-1, 3), normals.reshape(-1, 3), grid_indices(24, 7)[:, ::-1], uvs.reshape(-1, 2))


def _crown(g, material, center, count, random):
    outward = _units(random, count) * (0.4 + 0.6 * random.random(count)[:, None] ** 0.4)
    u = _units(random, count)
    v = np.cross(u, _units(random, count))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    size = 0.16 + 0.1 * random.random((count, 1))
    return _cards(g, material, center + outward * [1.5, 1.7, 1.5], u * size, v * size)


def _places(random):
    """Feet of trees, apart from each other and from the camera."""
    places = []
    while len(places) < TREES:
        x, z = random.uniform(-16, 16, 2)
        if math.hypot(x, z - 14) > 5 and all(math.hypot(x - a, z - b) > 1.8 for a, b in places):
            places.append((x, z))
    return places


def foliage(cards=111_000):
    """46 trees with five eighths of the cards, grass of the others."""
    g, random = Gltf(), _random(7)
    earth = _solid(g, "earth", (.12, .08, .05), (.30, .24, .15), 1)
    bark = [_solid(g, "bark %d" % i, (.15, .10, .06), (.40, .30, .20), 10 + i) for i in range(3)]
    stone = [_solid(g, "stone %d" % i, (.50, .45, .40), (.80, .75, .70), 70 + i) for i in range(STONES)]
    leaves = [_cut_out(g, "leaves %d" % i, _leaves(dark, light, 40 + i), 0.5) for i, (dark, light) in enumerate(GREENS)]
    grass = [_cut_out(g, "grass %d" % i, _grass(60 + i), 0.6) for i in range(3)]
    primitives = [_ground(g, earth)]
    for number, (x, z) in enumerate(_places(random)):
        foot, height = np.array([x, _height(x, z) - 0.1, z]), 3 + 2.5 * random.random()
        primitives.append(_trunk(g, bark[number % 3], foot, height, 0.12 + 0.1 * random.random()))
        primitives.append(_crown(g, leaves[number % 4], foot + [0, height + 0.4, 0], max(1, cards * 5 // 8 // TREES), random))
    for material in grass:
        count = max(1, cards // 8)
        x, z = random.uniform(-18, 18, (2, count))
        size, angle = 0.12 + 0.12 * random.random((count, 1)), random.random(count) * 2 * math.pi
        centers = np.stack([x, _height(x, z) + size[:, 0] - 0.02, z], axis=1)
        along = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
        primitives.append(_cards(g, material, centers, along * size, np.array([0.0, 1.0, 0.0]) * size))
    for material, center, half in zip(stone, ((-5, 1.2, -2), (6, 1, -5), (0, .5, 3), (3, .4, 6)),
                                      ((2, 1.4, 1.6), (1.5, 1.2, 1.5), (.5, .6, .5), (.3, .5, .9))):
        axes = np.diag(half)
        sides = [(sign * axes[a], axes[(a + 1) % 3], sign * axes[(a + 2) % 3]) for a in range(3) for sign in (-1, 1)]
        out, u, v = (np.array(column, float) for column in zip(*sides))
        primitives.append(_cards(g, material, np.array(center, float) + out, u, v))
    roots = [g.add_node("foliage", mesh=g.add("meshes", {"name": "foliage", "primitives": primitives})),
             g.add_camera_node("camera", (1.5, 1.9, 15.5), (0.0, 1.9, 0.0), 0.75)]
    return g.finish(roots, "foliage").to_glb()


SCENES = {"foliage": (foliage, "cards", 111_000)}
