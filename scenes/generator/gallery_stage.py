# SPDX-License-Identifier: Apache-2.0
"""The gallery's stage: a dome of soft light, a soft and a bright lamp, a floor, a background."""
import math

from . import images
from .gltf import Gltf, cross, normalize, subtract
from .shapes import Mesh, quad, sphere

RADIUS, SPACING = 0.45, 1.05  # meters
LIFT = 0.002  # spheres float above the floor
CAMERA, TARGET, ASPECT = (0.0, 1.25, 9.0), (0.0, 0.455, 0.0), 4.4


class Stage:
    """One document with the lights, the floor and a camera that sees a row of spheres."""

    def __init__(self, count, card=False, dim=1.0):
        """card: adds the card behind transparent spheres. dim: factor of all light."""
        self.g = Gltf()
        self.roots = []
        self.count = count
        self.shapes = {}
        self._dome(dim)
        lamp = self.g.add_material("soft lamp", (0, 0, 0), emission=tuple(7.0 * dim * c for c in (1.0, 0.95, 0.88)), diffuse_only=True)
        self.add("soft lamp", panel((-2.6, 3.4, 3.0), (0, 0.3, 0), 3.4, 1.5), lamp)
        bright = self.g.add_material("bright lamp", (0, 0, 0), emission=tuple(150.0 * dim * c for c in (1.0, 0.93, 0.82)),
                                     diffuse_only=True)
        self.add("bright lamp", sphere(0.1, 16, 8).without_uvs(), bright, (3.0, 3.2, 2.6))
        floor = self.g.add_material("floor", self.g.add_texture("floor", _floor_picture()), 0.0, 0.65)
        self.add("floor", quad((-11, 0, 11), (22, 0, 0), (0, 0, -22), (22 / SPACING, 22 / SPACING)), floor)
        if card:
            material = self.g.add_material("card", self.g.add_texture("card", _card_picture(), nearest=True), 0.0, 0.9, diffuse_only=True)
            half = (count + 0.4) * SPACING / 2
            self.add("card", quad((-half, 0, -1.15), (2 * half, 0, 0), (0, 1.15, 0), (count + 0.4, 1)), material)

    def add(self, name, mesh, material, at=None):
        self.roots.append(self.g.add_node(name, mesh=self.g.add_mesh(name, [(mesh, material)]), translation=at))

    def place(self, index, material, shape="ball", radius=RADIUS):
        """Adds a sphere to the row. shape: "ball", or "textured" for one with texture coordinates; each is stored once."""
        part = self.shapes.get((shape, radius))
        if part is None:
            mesh = sphere(radius, 56, 28) if radius > 0.2 else sphere(radius, 16, 8)
            part = self.shapes[shape, radius] = self.g.add_primitive(mesh if shape == "textured" else mesh.without_uvs())
        name = self.g.json["materials"][material]["name"]
        mesh = self.g.add("meshes", {"name": name, "primitives": [{**part, "material": material}]})
        x = (index - (self.count - 1) / 2) * SPACING
        self.roots.append(self.g.add_node(name, mesh=mesh, translation=[x, RADIUS + LIFT, 0]))

    def finish(self, name, camera=CAMERA, target=TARGET, yfov_deg=10.9, aspect=ASPECT):
        self.roots.append(self.g.add_camera_node("camera", camera, target, math.radians(yfov_deg), aspect))
        return self.g.finish(self.roots, name).to_glb()

    def _dome(self, dim):
        inside = sphere(14.0, 24, 12)
        turned = [k for t in range(0, len(inside.indices), 3) for k in (inside.indices[t], inside.indices[t + 2], inside.indices[t + 1])]
        mesh = Mesh(inside.positions, [tuple(-c for c in n) for n in inside.normals], inside.uvs, turned)
        texture = self.g.add_texture("dome", _dome_picture(), wrap=33071)
        material = self.g.add_material("dome", (0, 0, 0), emission=(0.9 * dim,) * 3, diffuse_only=True, emissiveTexture={"index": texture})
        self.add("dome", mesh, material)


def panel(centre, target, width, height):
    """A rectangle facing the target."""
    n = normalize(subtract(target, centre))
    across = normalize(cross((0, 1, 0), n))
    up = cross(n, across)
    corner = tuple(centre[k] - width / 2 * across[k] - height / 2 * up[k] for k in range(3))
    return quad(corner, tuple(width * c for c in across), tuple(height * c for c in up))


def _dome_picture():
    """The dome's image, zenith in the top row: dark above, bright at the horizon, a warm and a cool side."""
    def pixel(x, y):
        height = 1.0 - (y + 0.5) / 16.0  # 1 at the zenith, -1 at the nadir
        side = 0.5 + 0.5 * math.cos(2.0 * math.pi * (x + 0.5) / 32.0)
        level = 0.10 + 0.55 * math.exp(-((height - 0.12) / 0.28) ** 2) if height > 0 else 0.3
        return images.srgb(tuple(level * c for c in images.mix((0.80, 0.92, 1.08), (1.08, 0.98, 0.84), side)))

    return images.paint(32, 32, 3, pixel)


def _floor_picture():
    def pixel(x, y):
        line = min(x, 63 - x, y, 63 - y) < 1
        tone = 0.57 + 0.03 * images.hash_unit(x // 2, y // 2, 11)
        return (0.42, 0.42, 0.43) if line else (tone, tone * 0.99, tone * 0.97)

    return images.paint(64, 64, 3, pixel, 64)


def _card_picture():
    """The card's image, one period per sphere: stripes, then a checkerboard, with one colored column in each."""
    white, black, orange, teal = (0.93, 0.93, 0.91), (0.05, 0.05, 0.055), (0.90, 0.42, 0.08), (0.05, 0.55, 0.60)

    def pixel(x, y):
        column, row = x // 4, y // 4
        if column in (3, 12):
            return orange if column == 3 else teal
        if column < 8:
            return white if column % 2 else black
        return white if (column + row) % 2 else black

    return images.paint(64, 64, 3, pixel)
