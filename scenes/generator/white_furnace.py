# SPDX-License-Identifier: Apache-2.0
"""Spheres that reflect all light; under a constant environment they must vanish."""
from .gltf import Gltf
from .shapes import sphere

ROUGHNESS = (0.0, 0.25, 0.5, 0.75, 1.0)


def build():
    g = Gltf()
    ball = sphere(0.45, 32, 16).without_uvs()
    shared = None
    roots = []
    for row, metallic in enumerate((1.0, 0.5, 0.0)):
        for column, roughness in enumerate(ROUGHNESS):
            material = g.add_material("metallic %g roughness %g" % (metallic, roughness), (1, 1, 1), metallic, roughness)
            shared = shared or g.add_primitive(ball)
            mesh = g.add("meshes", {"primitives": [{**shared, "material": material}]})
            roots.append(g.add_node("ball %d %d" % (row, column), mesh=mesh, translation=[column - 2.0, 1.0 - row, 0]))
    roots.append(g.add_camera_node("camera", (0, 0, 10), (0, 0, 0), xmag=2.8, ymag=1.7, znear=0.1, zfar=20))
    return {"white_furnace.gltf": g.finish(roots, "white furnace").to_gltf()}
