# SPDX-License-Identifier: Apache-2.0
"""The material gallery: a row of spheres for each material extension, and a scene with all."""
from . import gallery_materials, gallery_scene, gallery_stage

SPHERES = 7


def build():
    files = {}
    for name, (fill, card, dim) in gallery_materials.ROWS.items():
        stage = gallery_stage.Stage(SPHERES, card, dim)
        fill(stage)
        files["gallery/%s.glb" % name] = stage.finish(name)
    files["gallery/material_gallery.glb"] = gallery_scene.build()
    return files
