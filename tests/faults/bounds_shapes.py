"""Meshes that are hard for acceleration structures, and a typical one: of bounds.py."""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import random
from array import array

FLOAT, UINT, USHORT = 5126, 5125, 5123


class Gltf:
    """A glTF file under construction; its buffer becomes a file beside it."""

    def __init__(self):
        self.root = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [], "nodes": []}
        self.bin = bytearray()

    def accessor(self, values, component, kind, count=None):
        """Without values: all zero, which takes no bytes of the file."""
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        entry = {"componentType": component, "type": kind, "count": count if values is None else len(values) // width}
        if values is not None:
            entry["bufferView"] = len(self.root["bufferViews"])
            data = values.tobytes()
            self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bin), "byteLength": len(data)})
            self.bin += data + bytes(-len(data) % 4)
        self.root["accessors"].append(entry)
        return len(self.root["accessors"]) - 1

    def mesh(self, positions, indices, **attributes):
        primitive = {"attributes": {"POSITION": positions, **attributes}}
        if indices is not None:
            primitive["indices"] = indices
        self.root["meshes"].append({"primitives": [primitive]})
        return len(self.root["meshes"]) - 1

    def triangles(self, positions, indices):
        return self.mesh(self.accessor(array("f", positions), FLOAT, "VEC3"), self.accessor(array("I", indices), UINT, "SCALAR"))

    def node(self, **node):
        self.root["nodes"].append(node)
        return len(self.root["nodes"]) - 1

    def write(self, folder, name):
        root = {key: value for key, value in self.root.items() if value}
        root.setdefault("scenes", [{"nodes": list(range(len(self.root["nodes"])))}])
        if self.bin:
            root["buffers"] = [{"uri": name + ".bin", "byteLength": len(self.bin)}]
            (folder / (name + ".bin")).write_bytes(self.bin)
        path = folder / (name + ".gltf")
        path.write_text(json.dumps(root, separators=(",", ":")))
        return path


def same_triangles(count):
    """Indices of copies of one triangle."""
    return array("I", [0, 1, 2]) * count


TILTED = [0.0, 0.0, 0.0, 1.0, 0.1, 0.3, 0.2, 1.0, 0.6]
BOX = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]


def box_mesh(gltf, extents):
    positions, indices = array("f"), array("I")
    for low, high in extents:
        first = len(positions) // 3
        for corner in range(8):
            positions.extend(high if corner >> axis & 1 else low for axis in range(3))
        indices.extend(first + i for i in BOX)
    return gltf.mesh(gltf.accessor(positions, FLOAT, "VEC3"), gltf.accessor(indices, UINT, "SCALAR"))


def loose(gltf, corners):
    """A mesh of triangles without common vertices."""
    return gltf.mesh(gltf.accessor(corners, FLOAT, "VEC3"), None)


def camera(gltf, eye, half_angle=0.7):
    """A camera that looks along -z."""
    gltf.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": 2 * half_angle, "znear": 1e-5}}]
    gltf.node(camera=0, translation=eye)


def bumpy(gltf, triangles):
    """a bumpy surface: typical"""
    side = round(math.sqrt(triangles / 2))
    positions = array("f")
    for z in range(side + 1):
        for x in range(side + 1):
            u, v = x / side, z / side
            positions.extend((u, 0.05 * math.sin(20 * u) * math.cos(17 * v), v))
    indices = array("I")
    for z in range(side):
        for x in range(side):
            i = z * (side + 1) + x
            j = i + side + 1
            indices.extend((i, j, i + 1, i + 1, j, j + 1))
    return gltf.mesh(gltf.accessor(positions, FLOAT, "VEC3"), gltf.accessor(indices, UINT, "SCALAR"))


def needles(gltf, triangles):
    """needles through the whole scene in all directions"""
    rng, positions = random.Random(2), array("f")
    for _ in range(triangles):
        a = [rng.gauss(0, 1) for _ in range(3)]
        b = [rng.gauss(0, 1) for _ in range(3)]
        positions.extend(a)
        positions.extend(b)
        positions.extend(value + 1e-4 * rng.gauss(0, 1) for value in b)
    return loose(gltf, positions)


def soup(gltf, triangles):
    """random triangles of all sizes, from 0.1 mm to the scene's"""
    rng, positions = random.Random(4), array("f")
    for _ in range(triangles):
        size = 10 ** rng.uniform(-4, 0)
        at = [rng.random() for _ in range(3)]
        for _ in range(3):
            positions.extend(value + size * rng.uniform(-0.5, 0.5) for value in at)
    return loose(gltf, positions)


def large_soup(gltf, triangles):
    """random triangles as large as the scene"""
    rng = random.Random(4)
    return loose(gltf, array("f", (rng.random() for _ in range(9 * triangles))))


def nested_boxes(gltf, triangles):
    """boxes one in the other; the camera is in the middle of them"""
    count = triangles // 12
    camera(gltf, [0, 0, 1.5 - 0.5 / count])
    return box_mesh(gltf, [(-1 - i / count, 1 + i / count) for i in range(count)])


def nested_spheres(gltf, triangles):
    """spheres of 80 triangles one in the other; the camera is in the middle of them"""
    count = triangles // 80
    camera(gltf, [0, 0, -1.5 * 0.985])
    corners, faces = icosphere()
    positions, indices = array("f"), array("I")
    for i in range(count):
        radius, first = 1 + i / count, len(positions) // 3
        for corner in corners:
            positions.extend(radius * value for value in corner)
        indices.extend(first + index for face in faces for index in face)
    return gltf.mesh(gltf.accessor(positions, FLOAT, "VEC3"), gltf.accessor(indices, UINT, "SCALAR"))


def icosphere():
    """Corners and faces of an icosahedron whose faces are divided in four: 80 triangles."""
    golden = (1 + math.sqrt(5)) / 2
    signs = [(s, t) for s in (1, -1) for t in (1, -1)]
    corners = [corner for s, t in signs for corner in ((s, t * golden, 0), (0, s, t * golden), (t * golden, 0, s))]
    points = [tuple(value / math.hypot(*corner) for value in corner) for corner in corners]
    edges = {(i, j) for j in range(12) for i in range(j) if math.dist(corners[i], corners[j]) < 2.1}
    middles = {}
    for i, j in sorted(edges):
        middle = [a + b for a, b in zip(points[i], points[j])]
        middles[i, j] = len(points)
        points.append(tuple(value / math.hypot(*middle) for value in middle))
    faces = []
    for i, j in sorted(edges):
        for k in range(j + 1, 12):
            if (i, k) in edges and (j, k) in edges:
                a, b, c = middles[i, j], middles[j, k], middles[i, k]
                faces += [(i, a, c), (a, j, b), (c, b, k), (a, b, c)]
    return points, faces


def one_cell(gltf, triangles):
    """a cluster of 0.1 mm and two triangles, 1 km away; the camera sees the cluster"""
    rng = random.Random(3)
    positions = array("f", [1000, 0, 0, 1000, 1, 0, 1000, 0, 1, -1000, 0, 0, -1000, 1, 0, -1000, 0, 1])
    for _ in range(triangles - 2):
        at = [rng.random() * 1e-4 for _ in range(3)]
        for _ in range(3):
            positions.extend(value + rng.random() * 1e-5 for value in at)
    camera(gltf, [5e-5, 5e-5, 3e-4])
    return loose(gltf, positions)


def coincident(gltf, triangles):
    """copies of one triangle"""
    return gltf.mesh(gltf.accessor(array("f", TILTED), FLOAT, "VEC3"),
                     gltf.accessor(same_triangles(triangles), UINT, "SCALAR"))


SHAPES = [bumpy, needles, soup, large_soup, nested_boxes, nested_spheres, one_cell, coincident]


def write_shape(folder, shape, triangles):
    gltf = Gltf()
    gltf.node(mesh=shape(gltf, triangles))
    return gltf.write(folder, shape.__name__)
