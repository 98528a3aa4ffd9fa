# SPDX-License-Identifier: Apache-2.0
"""Parts of the figures' scenes: a studio with a visible sky, soft boxes, point lights, spheres.

Sizes are those of a table: spheres of 5 to 15 cm, a camera one or two meters away, so that real lenses blur realistically.
"""
import math

from . import images
from .gltf import SHORT, USHORT, Gltf, cross, normalize, subtract
from .shapes import Mesh, quad, sheet, sphere

PAPER_ASPECT, GPU_ASPECT = 301 / 246, 901 / 738
IVORY, INK, TEAL, CORAL, AMBER, SLATE = ((0.80, 0.76, 0.68), (0.030, 0.042, 0.070), (0.030, 0.27, 0.28), (0.72, 0.135, 0.075),
                                         (0.83, 0.42, 0.06), (0.16, 0.19, 0.23))
SILVER, GOLD, STEEL_BLUE, ROSE = (0.95, 0.945, 0.93), (1.0, 0.76, 0.34), (0.52, 0.66, 0.80), (0.94, 0.66, 0.58)


class Studio:
    """One document; everything stands on y = 0. `sky`: linear RGB at the zenith, at the horizon and below it, 0 to 1; `fade`: the
    sine of the elevation at which it reaches the zenith's color."""

    def __init__(self, sky, fade=0.55):
        self.g = Gltf()
        self.roots = []
        self.balls = {}
        self._dome(sky, fade)

    def add(self, name, mesh, material, **transform):
        node = self.g.add_node(name, mesh=self.g.add_mesh(name, [(mesh, material)]), **transform)
        self.roots.append(node)
        return node

    def ball(self, name, at, radius, material, textured=False, level=4):
        """A sphere by its center. Spheres of one level share their vertices; `textured`: with texture coordinates around y."""
        key = "uv" if textured else level
        if key not in self.balls:
            self.balls[key] = self._textured_ball() if textured else self._plain_ball(level)
        mesh = self.g.add("meshes", {"name": name, "primitives": [{**self.balls[key], "material": material}]})
        node = self.g.add_node(name, mesh=mesh, translation=list(at), scale=[radius] * 3)
        self.roots.append(node)
        return node

    def floor(self, material, half=6.0, uv_per_m=1.0, centre=(0.0, 0.0)):
        x, z = centre
        self.add("floor", quad((x - half, 0, z + half), (2 * half, 0, 0), (0, 0, -2 * half), (2 * half * uv_per_m,) * 2), material)

    def sweep(self, material, back=-1.5, bend=0.9, height=4.0, half=6.0, front=4.0):
        """Background paper from the wall to the floor, without a horizon."""
        lengths = (front - back - bend, bend * math.pi / 2, height)
        total = sum(lengths)

        def at(u, v):
            way = v * total
            if way < lengths[0]:
                y, z = 0.0, front - way
            elif way < lengths[0] + lengths[1]:
                angle = (way - lengths[0]) / bend
                y, z = bend - bend * math.cos(angle), back + bend - bend * math.sin(angle)
            else:
                y, z = bend + way - lengths[0] - lengths[1], back
            return (half * (2 * u - 1), y, z)

        self.add("sweep", sheet(at, 1, 96).without_uvs(), material)

    def soft_box(self, name, centre, target, width, height, radiance):
        """An emitting rectangle facing the target, W/(m^2 sr)."""
        material = self.g.add_material(name, (0, 0, 0), emission=radiance, diffuse_only=True)
        self.add(name, panel(centre, target, width, height).without_uvs(), material)

    def lamp(self, name, at, color, intensity, radius=None):
        """A point light in candela; a sphere if it has a radius."""
        fields = {"extras": {"kindling": {"radius": radius}}} if radius else {}
        light = self.g.add_light(name, "point", color, intensity, **fields)
        self.roots.append(self.g.add_node(name, translation=list(at), extensions=light))

    def matte(self, name, color, roughness=0.9):
        return self.g.add_material(name, color, 0.0, roughness)

    def lacquer(self, name, color, roughness=0.0):
        """Paint with a dielectric coat."""
        return self.g.add_material(name, color, 0.0, roughness)

    def metal(self, name, color=SILVER, roughness=0.0):
        return self.g.add_material(name, color, 1.0, roughness)

    def glass(self, name, color=(1, 1, 1), distance_m=None, roughness=0.0, ior=1.5):
        for extension in ("transmission", "volume", "ior"):
            self.g.use("KHR_materials_" + extension)
        volume = {"thicknessFactor": 0.1}
        if distance_m is not None:
            volume.update(attenuationDistance=distance_m, attenuationColor=list(color))
        return self.g.add_material(name, (1, 1, 1), 0.0, roughness, extensions={
            "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_volume": volume, "KHR_materials_ior": {"ior": ior}})

    def picture(self, name, png):
        """A texture of hard squares."""
        return self.g.add_texture(name, png, nearest=True)

    def finish(self, name, eye, target, yfov_deg, aspect, **lens):
        """Adds the camera; lens: its extras."""
        camera = self.g.add_camera_node("camera", eye, target, math.radians(yfov_deg), aspect)
        if lens:
            self.g.json["cameras"][-1]["extras"] = {"kindling": lens}
        self.roots.append(camera)
        return self.g.finish(self.roots, name).to_glb()

    def _dome(self, sky, fade):
        """An unlit dome: rays that hit it see its radiance, but it is not sampled as a light."""
        inside = sphere(30.0, 32, 16)
        turned = [k for t in range(0, len(inside.indices), 3) for k in (inside.indices[t], inside.indices[t + 2], inside.indices[t + 1])]
        mesh = Mesh(inside.positions, [tuple(-c for c in n) for n in inside.normals], inside.uvs, turned)
        zenith, horizon, below = sky

        def pixel(_, y):
            height = 1.0 - (y + 0.5) / 64.0
            color = images.mix(horizon, zenith, images.smooth(0.0, fade, height)) if height > 0 else images.mix(
                horizon, below, images.smooth(0.0, 0.25, -height))
            return images.srgb(color)

        self.g.use("KHR_materials_unlit")
        material = self.g.add_material("sky", self.g.add_texture("sky", images.paint(1, 128, 3, pixel), wrap=33071),
                                       extensions={"KHR_materials_unlit": {}})
        self.add("sky", mesh, material)

    def _plain_ball(self, level):
        points, indices = icosphere(level)
        return self._quantized_ball(points, indices)

    def _textured_ball(self):
        mesh = sphere(1.0, 112, 56)
        part = self._quantized_ball(mesh.positions, mesh.indices)
        # Rounded twice: halves are rounded to even, whatever the C library left of them.
        uvs = [tuple(round(round(65535 * c, 6)) for c in uv) for uv in mesh.uvs]
        part["attributes"]["TEXCOORD_0"] = self.g.add_accessor(uvs, "VEC2", USHORT, normalized=True, target=34962)
        return part

    def _quantized_ball(self, points, indices):
        """Positions of a unit sphere equal its normals, so one accessor of shorts serves as both."""
        self.g.use("KHR_mesh_quantization", required=True)
        shorts = [tuple(round(32767 * c) for c in p) for p in points]
        accessor = self.g.add_accessor(shorts, "VEC3", SHORT, normalized=True, bounds=True, target=34962)
        return {"attributes": {"POSITION": accessor, "NORMAL": accessor},
                "indices": self.g.add_accessor(indices, "SCALAR", USHORT, target=34963)}


def panel(centre, target, width, height):
    """A rectangle facing the target."""
    n = normalize(subtract(target, centre))
    up = (0, 1, 0) if abs(n[1]) < 0.999 else (0, 0, -1)
    across = normalize(cross(up, n))
    up = cross(n, across)
    corner = tuple(centre[k] - width / 2 * across[k] - height / 2 * up[k] for k in range(3))
    return quad(corner, tuple(width * c for c in across), tuple(height * c for c in up))


def icosphere(level):
    """(unit vectors, triangles): an icosahedron whose edges are halved `level` times; 20 * 4^level triangles."""
    t = (1.0 + math.sqrt(5.0)) / 2.0
    points = [normalize(p) for p in ((-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
                                     (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1))]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(level):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(normalize(tuple(points[a][k] + points[b][k] for k in range(3))))
            return middles[key]

        split = []
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = split
    return points, [k for face in faces for k in face]


def checkers(first, second):
    """2 x 2 squares of two colors, linear RGB, with texture coordinates 0 to 1 over all."""
    return images.paint(2, 2, 3, lambda x, y: images.srgb(first if (x + y) % 2 == 0 else second))
