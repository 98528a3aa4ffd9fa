# SPDX-License-Identifier: Apache-2.0
"""Two large scenes of any size: `heavy` has millions of triangles, `swarm` millions of instances.

Needs NumPy: lists would take minutes instead of seconds.
"""
import math
import struct
import zlib

import numpy as np

from .gltf import FLOAT, UINT, BYTE, Gltf, normalize

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
_STORED = {FLOAT: np.float32, UINT: np.uint32, BYTE: np.int8}
_KIND = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def _accessor(g, array, component=FLOAT, normalized=False, bounds=False, target=None):
    """array: one row per element."""
    array = np.ascontiguousarray(array, dtype=_STORED[component])
    width = 1 if array.ndim == 1 else array.shape[1]
    accessor = {"bufferView": g.add_view(array.data.cast("B"), None, target), "componentType": component,
                "count": len(array), "type": _KIND[width]}
    if normalized:
        accessor["normalized"] = True
    if bounds:
        accessor["min"], accessor["max"] = array.min(axis=0).tolist(), array.max(axis=0).tolist()
    return g.add("accessors", accessor)


def array_primitive(g, material, positions, normals, indices, uvs=None):
    attributes = {"POSITION": _accessor(g, positions, bounds=True, target=ARRAY_BUFFER),
                  "NORMAL": _accessor(g, normals, target=ARRAY_BUFFER)}
    if uvs is not None:
        attributes["TEXCOORD_0"] = _accessor(g, uvs, target=ARRAY_BUFFER)
    return {"attributes": attributes, "indices": _accessor(g, indices.reshape(-1), UINT, target=ELEMENT_ARRAY_BUFFER),
            "material": material}


def png_of(pixels):
    """pixels: uint8, (height, width, 3 or 4)."""
    height, width, channels = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows.tobytes(), 4)) + chunk(b"IEND", b""))


def value_noise(x, y, cells, seed):
    """Smooth value noise in [-1, 1] at x, y in [0, 1], over cells x cells squares, periodic."""
    lattice = np.random.Generator(np.random.PCG64(seed)).uniform(-1.0, 1.0, (cells, cells)).astype(np.float32)
    column, row = np.floor(x * cells), np.floor(y * cells)
    u, v = x * cells - column, y * cells - row
    u, v = u * u * u * (u * (u * 6 - 15) + 10), v * v * v * (v * (v * 6 - 15) + 10)
    c0, r0 = column.astype(np.int32) % cells, row.astype(np.int32) % cells
    c1, r1 = (c0 + 1) % cells, (r0 + 1) % cells
    top = lattice[r0, c0] * (1 - u) + lattice[r0, c1] * u
    return top * (1 - v) + (lattice[r1, c0] * (1 - u) + lattice[r1, c1] * u) * v


def grid_indices(columns, rows):
    """Two triangles for each square of a grid of (rows + 1) x (columns + 1) vertices, front faces up for x to the right and z downwards."""
    first = (np.arange(rows, dtype=np.uint32)[:, None] * (columns + 1) + np.arange(columns, dtype=np.uint32)).reshape(-1)
    below = first + np.uint32(columns + 1)
    return np.stack([first, below, first + 1, first + 1, below, below + 1], axis=1)


def grid_normals(positions):
    """positions: (rows, columns, 3), neighbors adjacent."""
    along = np.gradient(positions, axis=1)
    down = np.gradient(positions, axis=0)
    normals = np.cross(down, along)
    return normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-20)


# ---- heavy ---------------------------------------------------------------------------------------

LAND = 400.0  # width in meters


def _height(x, z):
    """Height in meters for x and z in [0, 1]: ridges over hills, and fine gravel."""
    hills = 14.0 * value_noise(x, z, 5, 1)
    ridges = np.zeros_like(x)
    size = 22.0
    for octave in range(6):
        ridges += size * (0.5 - np.abs(value_noise(x, z, 7 << octave, 10 + octave)))
        size *= 0.48
    return hills + ridges + 0.10 * value_noise(x, z, 512, 30)


def _land_picture(size):
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size
    x, z = np.meshgrid(axis, axis)
    height = _height(x, z)
    slope_x, slope_z = np.gradient(height, LAND / size)[::-1]
    steep = np.clip((np.hypot(slope_x, slope_z) - 0.55) / 0.5, 0, 1)[..., None]
    snow = np.clip((height + 3.0 * value_noise(x, z, 96, 41) - 14.0) / 6.0, 0, 1)[..., None] * (1 - 0.8 * steep)
    grain = (1.0 + 0.18 * value_noise(x, z, 300, 40) + 0.12 * value_noise(x, z, 900, 42))[..., None]
    grass, rock, white = np.array([0.33, 0.38, 0.17]), np.array([0.42, 0.37, 0.33]), np.array([0.93, 0.94, 0.97])
    color = (grass * (1 - steep) + rock * steep) * grain
    color = color * (1 - snow) + white * snow
    return (np.clip(color, 0, 1) * 255 + 0.5).astype(np.uint8)


def _boulder(columns, rows, seed):
    """An eroded sphere of columns x rows squares: positions, normals, indices."""
    angle = np.linspace(0, 2 * math.pi, columns + 1, dtype=np.float32)
    polar = np.linspace(0.002, math.pi - 0.002, rows + 1, dtype=np.float32)
    a, p = np.meshgrid(angle, polar)
    direction = np.stack([np.sin(p) * np.cos(a), np.cos(p), -np.sin(p) * np.sin(a)], axis=2)
    radius = np.ones_like(a)
    size = 0.30
    for octave in range(5):  # three projections, to avoid seams and poles
        for axis in range(3):
            u, v = direction[..., axis] * 0.5 + 0.5, direction[..., (axis + 1) % 3] * 0.5 + 0.5
            radius += size / 3 * value_noise(u, v, 4 << octave, seed * 100 + octave * 3 + axis)
        size *= 0.5
    positions = direction * radius[..., None] * np.array([1.0, 0.75, 0.9], np.float32)
    return positions.reshape(-1, 3), grid_normals(positions).reshape(-1, 3), grid_indices(columns, rows)


def heavy(triangles=7_000_000):
    """A textured landscape with 9/14 of the triangles, and 16 different boulders of four materials. `triangles` is a minimum.

    7,000,000 are 1500 x 1500 squares of land and 625 x 125 of each boulder.
    """
    g = Gltf()
    side = math.ceil(math.sqrt(triangles * 9 / 14 / 2))
    boulder_squares = max(0, triangles - 2 * side * side) / 32
    boulder_rows = max(4, round(math.sqrt(boulder_squares / 5)))
    boulder_columns = max(8, math.ceil(boulder_squares / boulder_rows))

    axis = np.linspace(0, 1, side + 1, dtype=np.float32)
    x, z = np.meshgrid(axis, axis)
    land = np.stack([(x - 0.5) * LAND, _height(x, z), (z - 0.5) * LAND], axis=2)
    texture = g.add_texture("land", png_of(_land_picture(2048 if triangles > 1_000_000 else 256)))
    earth = g.add_material("land", texture, 0.0, 0.9)
    parts = [("land", array_primitive(g, earth, land.reshape(-1, 3), grid_normals(land).reshape(-1, 3), grid_indices(side, side),
                                 np.stack([x, z], axis=2).reshape(-1, 2)), None)]
    stones = [g.add_material("granite", (0.42, 0.40, 0.39), 0.0, 0.75), g.add_material("sandstone", (0.62, 0.43, 0.26), 0.0, 0.95),
              g.add_material("slate", (0.10, 0.12, 0.14), 0.0, 0.45), g.add_material("iron ore", (0.55, 0.30, 0.22), 0.9, 0.45)]
    random = np.random.Generator(np.random.PCG64(5))
    for number in range(16):
        place = np.array([0.38 + 0.24 * random.random(), 0.52 + 0.28 * random.random()], np.float32)
        size = 2.0 + 7.0 * random.random() ** 2
        height = float(_height(place[:1], place[1:])[0])
        at = [float((place[0] - 0.5) * LAND), height + 0.3 * size, float((place[1] - 0.5) * LAND)]
        parts.append(("boulder %d" % number, array_primitive(g, stones[number % 4], *_boulder(boulder_columns, boulder_rows, number + 1)),
                      {"translation": at, "scale": [size] * 3}))
    roots = []
    for name, primitive, place in parts:
        roots.append(g.add_node(name, mesh=g.add("meshes", {"name": name, "primitives": [primitive]}), **(place or {})))
    eye, target = (6.0, 34.0, 150.0), (0.0, 4.0, 20.0)
    roots.append(g.add_camera_node("camera", eye, target, math.radians(42)))
    roots.append(_sun(g, (0.70, -0.42, -0.35), 6.0))
    return g.finish(roots, "heavy").to_glb()


# ---- swarm ---------------------------------------------------------------------------------------

def _rock(seed):
    """A rock of 80 triangles: positions, normals, indices."""
    golden = (1 + math.sqrt(5)) / 2
    points = [normalize(p) for p in [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden),
                                     (0, -1, -golden), (0, 1, -golden), (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    middles, finer = {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(points)
            points.append(normalize(tuple(p + q for p, q in zip(points[a], points[b]))))
        return middles[key]

    for a, b, c in faces:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    random = np.random.Generator(np.random.PCG64(seed))
    positions = np.array(points, np.float32) * random.uniform(0.68, 1.0, (len(points), 1)).astype(np.float32)
    positions *= np.array([1.0, 0.72, 0.85], np.float32)
    indices = np.array(finer, np.uint32)
    corners = positions[indices]
    face_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(positions)
    for corner in range(3):
        np.add.at(normals, indices[:, corner], face_normals)
    return positions, normals / np.linalg.norm(normals, axis=1, keepdims=True), indices


def _ring(count, seed):
    """Radii (with gaps and waves), angles and heights, in meters."""
    random = np.random.Generator(np.random.PCG64(seed))
    radius = np.sqrt(random.uniform(125.0 ** 2, 235.0 ** 2, count)).astype(np.float32)
    gaps = ((radius > 190.0) & (radius < 196.0)) | ((radius > 150.0) & (radius < 152.0))
    radius[gaps] += np.float32(8.0)
    angle = random.uniform(0, 2 * math.pi, count).astype(np.float32)
    height = random.normal(0.0, 0.10, count).astype(np.float32) + 0.25 * np.sin(radius * 1.1 + 2 * angle).astype(np.float32)
    return radius, angle, height


def swarm(instances=10_000_000):
    """The ring of a planet: `instances` rocks of four shapes with 80 triangles each, by EXT_mesh_gpu_instancing."""
    g = Gltf()
    g.use("EXT_mesh_gpu_instancing", required=True)
    materials = [g.add_material("ice", (0.72, 0.76, 0.80), 0.0, 0.55), g.add_material("dust", (0.56, 0.45, 0.34), 0.0, 0.95),
                 g.add_material("rock", (0.32, 0.29, 0.27), 0.0, 0.85), g.add_material("rust", (0.50, 0.27, 0.17), 0.0, 0.9)]
    roots = []
    for shape, material in enumerate(materials):
        count = instances // 4 + (1 if shape < instances % 4 else 0)
        name = "rocks %d" % shape
        mesh = g.add("meshes", {"name": name, "primitives": [array_primitive(g, material, *_rock(60 + shape))]})
        if count == 0:
            continue
        radius, angle, height = _ring(count, 70 + shape)
        random = np.random.Generator(np.random.PCG64(80 + shape))
        turn = random.normal(size=(count, 4)).astype(np.float32)
        turn *= 127.0 / np.linalg.norm(turn, axis=1, keepdims=True)
        # Sizes grow where the ring is sparse, so that it looks closed from afar; a few rocks are
        # ten times as large.
        size = np.float32(0.035 * math.sqrt(1e7 / instances)) * (1 + 0.12 * (1 / random.uniform(0.012, 1.0, count).astype(np.float32) - 1))
        attributes = {"TRANSLATION": _accessor(g, np.stack([radius * np.cos(angle), height, radius * np.sin(angle)], axis=1)),
                      "ROTATION": _accessor(g, np.rint(turn), BYTE, normalized=True),
                      "SCALE": _accessor(g, np.repeat(size[:, None], 3, axis=1))}
        roots.append(g.add_node(name, mesh=mesh, extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}}))
    planet = g.add_material("planet", (0.46, 0.33, 0.22), 0.0, 1.0)
    sphere = _boulder_sphere(100.0)
    roots.append(g.add_node("planet", mesh=g.add("meshes", {"name": "planet", "primitives": [array_primitive(g, planet, *sphere)]})))
    roots.append(g.add_camera_node("camera", (0.0, 9.0, 236.0), (-62.0, -2.0, 120.0), math.radians(45)))
    roots.append(_sun(g, (0.85, -0.30, -0.05), 5.0))
    return g.finish(roots, "swarm").to_glb()


def _boulder_sphere(radius):
    angle = np.linspace(0, 2 * math.pi, 129, dtype=np.float32)
    polar = np.linspace(0, math.pi, 65, dtype=np.float32)
    a, p = np.meshgrid(angle, polar)
    direction = np.stack([np.sin(p) * np.cos(a), np.cos(p), -np.sin(p) * np.sin(a)], axis=2).reshape(-1, 3)
    return direction * radius, direction, grid_indices(128, 64)


def _sun(g, towards, lux):
    """A directional light along `towards`."""
    z = np.array(normalize(tuple(-t for t in towards)))
    x = np.cross((0.0, 1.0, 0.0), z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    matrix = [*x.tolist(), 0.0, *y.tolist(), 0.0, *z.tolist(), 0.0, 0.0, 0.0, 0.0, 1.0]
    return g.add_node("sun", matrix=matrix, extensions=g.add_light("sun", "directional", (1.0, 0.94, 0.86), lux))


SCENES = {"heavy": (heavy, "triangles", 7_000_000), "swarm": (swarm, "instances", 10_000_000)}
