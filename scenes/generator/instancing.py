# SPDX-License-Identifier: Apache-2.0
"""Instances in both forms: a colonnade of nodes, and a field by EXT_mesh_gpu_instancing."""
import math

from .gltf import BYTE, FLOAT, Gltf
from .images import hash_unit
from .shapes import beveled_box, joined, lathe, quad, sphere

PEBBLES = 2000
COLUMNS = 24
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


def _column():
    fluted = lathe([(0.0, 0.24), (0.27, 0.24), (0.30, 0.28), (0.27, 0.32), (0.235, 0.36), (0.225, 1.4), (0.20, 2.6),
                    (0.22, 2.66), (0.30, 2.74), (0.30, 2.78)], 28)
    return joined([beveled_box((-0.34, 0.0, -0.34), (0.34, 0.24, 0.34), 0.02), fluted,
                   beveled_box((-0.33, 2.78, -0.33), (0.33, 2.92, 0.33), 0.02)]).without_uvs()


def build():
    g = Gltf()
    g.use("EXT_mesh_gpu_instancing", required=True)
    marble = g.add_material("marble", (0.72, 0.69, 0.64), 0.0, 0.45)
    stone = g.add_material("stone", (0.42, 0.36, 0.30), 0.0, 0.9)
    brass = g.add_material("brass", (0.89, 0.66, 0.33), 1.0, 0.34)
    glow = g.add_material("glow", (0, 0, 0), emission=(20.0, 12.0, 5.4))

    # A phyllotaxis: pebble i at angle i * golden angle and radius sqrt(i).
    translations, rotations, scales = [], [], []
    for i in range(PEBBLES):
        radius = 0.155 * math.sqrt(i + 14.0)
        angle = i * GOLDEN_ANGLE
        size = (0.55 + 0.45 * hash_unit(i, 1)) * (0.75 + 0.25 * radius / 6.9)
        height = 0.35 * math.exp(-((radius - 4.0) / 1.1) ** 2)
        translations.append((radius * math.cos(angle), height, radius * math.sin(angle)))
        half = 0.5 * (angle + 0.6 * hash_unit(i, 2))
        # The extension permits normalized bytes for rotations.
        rotations.append((0, round(-127 * math.sin(half)), 0, round(127 * math.cos(half))))
        scales.append((size, size * (0.6 + 0.8 * hash_unit(i, 3)), size))
    pebble = sphere(1.0, 16, 8).scaled(0.17, 0.10, 0.12).without_uvs()
    attributes = {
        "TRANSLATION": g.add_accessor(translations, "VEC3", FLOAT),
        "ROTATION": g.add_accessor(rotations, "VEC4", BYTE, normalized=True),
        "SCALE": g.add_accessor(scales, "VEC3", FLOAT),
    }
    roots = [g.add_node("pebbles", mesh=g.add_mesh("pebble", [(pebble, brass)]), translation=[0, 0.02, 0],
                        extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})]

    column = g.add_mesh("column", [(_column(), marble)])
    ring = []
    for i in range(COLUMNS):
        angle = 2.0 * math.pi * (i + 0.5) / COLUMNS
        half = -0.5 * angle
        # One is mirrored by a negative scale.
        fields = {"scale": [-1, 1, 1]} if i == 7 else {}
        ring.append(g.add_node("column %d" % i, mesh=column, translation=[8.2 * math.cos(angle), 0, 8.2 * math.sin(angle)],
                               rotation=[0, math.sin(half), 0, math.cos(half)], **fields))
    roots.append(g.add_node("colonnade", ring))
    steps = lathe([(9.6, -0.4), (9.6, -0.2), (9.2, -0.2), (9.2, 0.0), (0.0, 0.0)], 72)
    roots.append(g.add_node("steps", mesh=g.add_mesh("steps", [(steps.without_uvs(), marble)])))
    roots.append(g.add_node("orb", mesh=g.add_mesh("orb", [(sphere(0.45, 24, 12).without_uvs(), glow)]), translation=[0, 1.05, 0]))
    ground = quad((-60, -0.4, 60), (120, 0, 0), (0, 0, -120)).without_uvs()
    roots.append(g.add_node("ground", mesh=g.add_mesh("ground", [(ground, stone)])))
    sky = quad((-18, 22, -8), (36, 0, 0), (0, 0, 24)).without_uvs()
    roots.append(g.add_node("sky light", mesh=g.add_mesh("sky light", [(sky, g.add_material("sky", (0, 0, 0), emission=(0.55, 0.8, 1.3)))])))
    sun = g.add_light("evening sun", "directional", (1.0, 0.72, 0.45), 3.0)
    half = math.radians(-28) / 2
    turn = math.radians(55) / 2
    # Pitched down by 28 degrees, then rotated about y by 55.
    rotation = [math.cos(turn) * math.sin(half), math.sin(turn) * math.cos(half), -math.sin(turn) * math.sin(half),
                math.cos(turn) * math.cos(half)]
    roots.append(g.add_node("evening sun", rotation=rotation, extensions=sun))
    roots.append(g.add_camera_node("camera", (-4.2, 8.8, 14.0), (0.1, 0.2, 0.3), math.radians(38)))
    return {"instancing.glb": g.finish(roots, "instancing").to_glb()}
