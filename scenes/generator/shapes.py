# SPDX-License-Identifier: Apache-2.0
"""Indexed triangle meshes: boxes, spheres, lathes, tubes, sheets; transforms and unions."""
import math

from .gltf import cross, normalize, subtract


class Mesh:
    def __init__(self, positions=(), normals=(), uvs=(), indices=(), colors=()):
        self.positions = list(positions)
        self.normals = list(normals)
        self.uvs = list(uvs)
        self.indices = list(indices)
        self.colors = list(colors)

    def append(self, other):
        base = len(self.positions)
        self.positions += other.positions
        self.normals += other.normals
        self.uvs += other.uvs
        self.colors += other.colors
        self.indices += [base + i for i in other.indices]
        return self

    def mapped(self, point, vector=None):
        """point and vector are functions of a triple; vector None: directions are unchanged."""
        normals = [normalize(vector(n)) for n in self.normals] if vector else self.normals
        return Mesh([point(p) for p in self.positions], normals, self.uvs, self.indices, self.colors)

    def moved(self, x=0.0, y=0.0, z=0.0):
        return self.mapped(lambda p: (p[0] + x, p[1] + y, p[2] + z))

    def scaled(self, x, y=None, z=None):
        y = x if y is None else y
        z = x if z is None else z
        return self.mapped(lambda p: (p[0] * x, p[1] * y, p[2] * z), lambda n: (n[0] / x, n[1] / y, n[2] / z))

    def rotated(self, axis, degrees):
        """About x, y or z, counter-clockwise seen against the axis."""
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        turn = {
            "x": lambda p: (p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]),
            "y": lambda p: (c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]),
            "z": lambda p: (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]),
        }[axis]
        return self.mapped(turn, turn)

    def with_uvs(self, function):
        """function: position -> uv."""
        return Mesh(self.positions, self.normals, [function(p) for p in self.positions], self.indices, self.colors)

    def without_uvs(self):
        return Mesh(self.positions, self.normals, (), self.indices, self.colors)


def joined(meshes):
    result = Mesh()
    for mesh in meshes:
        result.append(mesh)
    return result


def quad(corner, a, b, uv_scale=(1.0, 1.0)):
    """corner, corner + a, corner + a + b, corner + b; faces a x b. v runs against b, so that images are upright."""
    n = normalize(cross(a, b))
    add = lambda p, q: tuple(x + y for x, y in zip(p, q))
    u, v = uv_scale
    return Mesh([corner, add(corner, a), add(add(corner, a), b), add(corner, b)], [n] * 4,
                [(0.0, v), (u, v), (u, 0.0), (0.0, 0.0)], [0, 1, 2, 0, 2, 3])


def box(low, high, uv_per_m=1.0):
    """Axis-aligned, faces outwards; texture coordinates in meters times uv_per_m."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    k = uv_per_m
    return joined([
        quad((x0, y0, z1), (dx, 0, 0), (0, dy, 0), (dx * k, dy * k)),
        quad((x1, y0, z0), (-dx, 0, 0), (0, dy, 0), (dx * k, dy * k)),
        quad((x1, y0, z1), (0, 0, -dz), (0, dy, 0), (dz * k, dy * k)),
        quad((x0, y0, z0), (0, 0, dz), (0, dy, 0), (dz * k, dy * k)),
        quad((x0, y1, z1), (dx, 0, 0), (0, 0, -dz), (dx * k, dz * k)),
        quad((x0, y0, z0), (dx, 0, 0), (0, 0, dz), (dx * k, dz * k)),
    ])


def beveled_box(low, high, bevel, uv_per_m=1.0):
    """A box with flat chamfers on its twelve edges, which show highlights."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    b = min(bevel, (x1 - x0) * 0.45, (y1 - y0) * 0.45, (z1 - z0) * 0.45)
    centre = ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)
    half = ((x1 - x0) / 2, (y1 - y0) / 2, (z1 - z0) / 2)
    result = Mesh()

    def face(points):
        n = normalize(cross(subtract(points[1], points[0]), subtract(points[2], points[0])))
        outward = sum(n[i] * (points[0][i] - centre[i]) for i in range(3)) > 0
        if not outward:
            points = points[::-1]
            n = tuple(-c for c in n)
        axis = max(range(3), key=lambda i: abs(n[i]))
        iu, iv = {0: (2, 1), 1: (0, 2), 2: (0, 1)}[axis]
        base = len(result.positions)
        result.append(Mesh(points, [n] * len(points), [(p[iu] * uv_per_m, -p[iv] * uv_per_m) for p in points],
                           [i for k in range(1, len(points) - 1) for i in (0, k, k + 1)]))
        return base

    def corner(signs, inset):
        """The corner's three points lie on the three faces; inset names the face's axis."""
        return tuple(centre[i] + signs[i] * (half[i] - (0 if i == inset else b)) for i in range(3))

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1, 1):
            def at(su, sv):
                signs = [0, 0, 0]
                signs[axis], signs[u], signs[v] = side, su, sv
                return signs
            face([corner(at(-1, -1), axis), corner(at(1, -1), axis), corner(at(1, 1), axis), corner(at(-1, 1), axis)])
        # The four edges along this axis.
        for su in (-1, 1):
            for sv in (-1, 1):
                ends = []
                for side in (-1, 1):
                    signs = [0, 0, 0]
                    signs[axis], signs[u], signs[v] = side, su, sv
                    ends.append((corner(signs, u), corner(signs, v)))
                face([ends[0][0], ends[0][1], ends[1][1], ends[1][0]])
    for sx in (-1, 1):
        for sy in (-1, 1):
            for sz in (-1, 1):
                face([corner((sx, sy, sz), 0), corner((sx, sy, sz), 1), corner((sx, sy, sz), 2)])
    return result


def lathe(profile, segments=32, uv_scale=(1.0, 1.0), sharp_deg=40.0):
    """Turns a profile of (radius, height) pairs about y, from bottom to top with the outside on the right.

    Normals are smooth except where the profile bends by more than sharp_deg.
    """
    profile = [p for i, p in enumerate(profile) if i == 0 or math.dist(p, profile[i - 1]) > 1e-7]
    # Split at sharp corners: each run has its own normals.
    runs, run = [], [profile[0]]
    for i in range(1, len(profile)):
        run.append(profile[i])
        if i + 1 < len(profile):
            a = (profile[i][0] - profile[i - 1][0], profile[i][1] - profile[i - 1][1])
            b = (profile[i + 1][0] - profile[i][0], profile[i + 1][1] - profile[i][1])
            turn = abs(math.degrees(math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])))
            if turn > sharp_deg:
                runs.append(run)
                run = [profile[i]]
    runs.append(run)
    total = sum(math.dist(profile[i], profile[i + 1]) for i in range(len(profile) - 1))
    result, way = Mesh(), 0.0
    for run in runs:
        normals = []
        for i in range(len(run)):
            a = run[max(i - 1, 0)]
            b = run[min(i + 1, len(run) - 1)]
            d = (b[0] - a[0], b[1] - a[1])
            length = math.hypot(*d)
            normals.append((d[1] / length, -d[0] / length))
        part = Mesh()
        for i, (r, y) in enumerate(run):
            if i:
                way += math.dist(run[i - 1], run[i])
            for s in range(segments + 1):
                angle = 2.0 * math.pi * s / segments
                c, sn = math.cos(angle), math.sin(angle)
                part.positions.append((r * c, y, -r * sn))
                part.normals.append((normals[i][0] * c, normals[i][1], -normals[i][0] * sn))
                part.uvs.append((uv_scale[0] * s / segments, uv_scale[1] * (1.0 - way / total)))
        for i in range(len(run) - 1):
            for s in range(segments):
                p = i * (segments + 1) + s
                q = p + segments + 1
                if run[i][0] > 0:
                    part.indices += [p, p + 1, q + 1]
                if run[i + 1][0] > 0:
                    part.indices += [p, q + 1, q]
        result.append(part)
    return result


def sphere(radius=1.0, segments=32, rings=16):
    profile = [(radius * math.sin(math.pi * i / rings), -radius * math.cos(math.pi * i / rings)) for i in range(rings + 1)]
    profile[0] = (0.0, -radius)
    profile[-1] = (0.0, radius)
    mesh = lathe(profile, segments, sharp_deg=180.0)
    # The normals of a sphere are exact.
    mesh.normals = [normalize(p) for p in mesh.positions]
    return mesh


def torus(major, minor, segments=32, sides=12):
    result = Mesh()
    for i in range(segments + 1):
        a = 2.0 * math.pi * i / segments
        for j in range(sides + 1):
            b = 2.0 * math.pi * j / sides
            n = (math.cos(b) * math.cos(a), math.sin(b), -math.cos(b) * math.sin(a))
            result.positions.append((major * math.cos(a) + minor * n[0], minor * n[1], -major * math.sin(a) + minor * n[2]))
            result.normals.append(n)
            result.uvs.append((i / segments, j / sides))
    for i in range(segments):
        for j in range(sides):
            p, q = i * (sides + 1) + j, (i + 1) * (sides + 1) + j
            result.indices += [p, q, q + 1, p, q + 1, p + 1]
    return result


def tube(path, radii, sides=8, caps=True):
    """A round tube along points; its frame is transported without twist."""
    result = Mesh()
    count = len(path)
    tangents = [normalize(subtract(path[min(i + 1, count - 1)], path[max(i - 1, 0)])) for i in range(count)]
    reference = (0.0, 1.0, 0.0) if abs(tangents[0][1]) < 0.9 else (1.0, 0.0, 0.0)
    side = normalize(cross(tangents[0], reference))
    for i in range(count):
        t = tangents[i]
        along = sum(side[k] * t[k] for k in range(3))
        side = normalize(tuple(side[k] - along * t[k] for k in range(3)))
        up = cross(side, t)
        r = radii[i] if isinstance(radii, (list, tuple)) else radii
        for j in range(sides + 1):
            a = 2.0 * math.pi * j / sides
            n = tuple(math.cos(a) * side[k] + math.sin(a) * up[k] for k in range(3))
            result.positions.append(tuple(path[i][k] + r * n[k] for k in range(3)))
            result.normals.append(n)
            result.uvs.append((j / sides, i / max(count - 1, 1)))
    for i in range(count - 1):
        for j in range(sides):
            p, q = i * (sides + 1) + j, (i + 1) * (sides + 1) + j
            result.indices += [p, q, q + 1, p, q + 1, p + 1]
    if caps:
        for i, direction in ((0, -1.0), (count - 1, 1.0)):
            n = tuple(direction * c for c in tangents[i])
            ring = result.positions[i * (sides + 1):i * (sides + 1) + sides]
            order = range(1, sides - 1)
            fan = [k for j in order for k in ((0, j, j + 1) if direction > 0 else (0, j + 1, j))]
            result.append(Mesh(ring, [n] * sides, [(0.5, 0.5)] * sides, fan))
    return outward(result)


def outward(mesh):
    """Reverses triangles whose winding disagrees with their normals."""
    for t in range(0, len(mesh.indices), 3):
        a, b, c = mesh.indices[t:t + 3]
        face = cross(subtract(mesh.positions[b], mesh.positions[a]), subtract(mesh.positions[c], mesh.positions[a]))
        if sum(face[k] * (mesh.normals[a][k] + mesh.normals[b][k] + mesh.normals[c][k]) for k in range(3)) < 0:
            mesh.indices[t + 1], mesh.indices[t + 2] = c, b
    return mesh


def sheet(function, columns, rows, uv_scale=(1.0, 1.0)):
    """function(u, v) -> position for u, v in [0, 1]; faces du x dv; normals from differences."""
    result = Mesh()
    e = 1e-4
    for j in range(rows + 1):
        for i in range(columns + 1):
            u, v = i / columns, j / rows
            p = function(u, v)
            du = subtract(function(u + e, v), function(u - e, v))
            dv = subtract(function(u, v + e), function(u, v - e))
            result.positions.append(p)
            result.normals.append(normalize(cross(du, dv)))
            result.uvs.append((u * uv_scale[0], (1.0 - v) * uv_scale[1]))
    for j in range(rows):
        for i in range(columns):
            p = j * (columns + 1) + i
            q = p + columns + 1
            result.indices += [p, p + 1, q + 1, p, q + 1, q]
    return result
