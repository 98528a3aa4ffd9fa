# SPDX-License-Identifier: Apache-2.0
"""All extensions in one image: fifteen spheres on three steps, each with its best parameters."""
from . import gallery_materials as materials
from . import images
from .gallery_stage import RADIUS, Stage
from .shapes import beveled_box, sphere

COLUMNS, STEP_M, PITCH = 5, 0.46, 1.16


def build():
    stage = Stage(COLUMNS)
    g = stage.g
    stone = g.add_material("stone", (0.30, 0.30, 0.31), 0.0, 0.5)
    for row in range(1, 3):
        block = beveled_box((-3.4, 0.0, -1.25 * row - 2.4), (3.4, STEP_M * row, -1.25 * row + 0.62), 0.02)
        stage.add("step %d" % row, block.without_uvs(), stone)
    stripes = g.add_texture("stripes", _stripes(), nearest=True)
    card = g.add_material("striped wall", stripes, 0.0, 0.9, diffuse_only=True)
    stage.add("striped wall", beveled_box((-3.4, 0.0, -4.6), (3.4, 2.9, -4.4), 0.01, 1.0), card)

    balls = _balls(g)
    plain, textured, lamp = (sphere(RADIUS, 56, 28).without_uvs(), sphere(RADIUS, 56, 28), sphere(0.1, 16, 8).without_uvs())
    parts = {}
    for number, (name, material, shape) in enumerate(balls):
        row, column = divmod(number, COLUMNS)
        at = [(column - (COLUMNS - 1) / 2) * PITCH + (0.10 if row == 1 else 0.0), row * STEP_M + RADIUS + 0.002, -1.25 * row]
        shapes = [(textured if shape == "textured" else plain, material)] + ([(lamp, shape)] if isinstance(shape, int) else [])
        primitives = []
        for mesh, m in shapes:
            if id(mesh) not in parts:
                parts[id(mesh)] = g.add_primitive(mesh)
            primitives.append({**parts[id(mesh)], "material": m})
        stage.roots.append(g.add_node(name, mesh=g.add("meshes", {"name": name, "primitives": primitives}), translation=at))
    return stage.finish("material gallery", (0.0, 2.75, 8.6), (0.0, 0.80, -1.1), 20.5, 16 / 9)


def _balls(g):
    """List of (name, material, "plain", "textured" or the material of a lamp inside), from the front left."""
    make, glass = materials.make, materials.glass
    bulb = g.add_material("bulb", (0, 0, 0), emission=(12, 9.6, 7), diffuse_only=True)
    hammered = {"index": g.add_texture("hammered", materials.bumps(64, 5, 3.0))}
    ramp = g.add_texture("ramp", images.paint(1, 64, 3, lambda x, y: (0.0, (63 - y) / 63, 0.0)), wrap=33071)
    soap = {"iridescenceFactor": 1.0, "iridescenceIor": 1.33, "iridescenceThicknessMinimum": 100, "iridescenceThicknessMaximum": 800,
            "iridescenceThicknessTexture": {"index": ramp}}
    return [
        ("amber", glass(g, "volume", 1.5, 0.0, 0.6, (0.92, 0.45, 0.07)), "plain"),
        ("car paint", make(g, "clearcoat", (0.05, 0.10, 0.42), 0.85, 0.5, {"normalTexture": hammered},
                           clearcoat={"clearcoatFactor": 1.0}), "textured"),
        ("diamond", glass(g, "dispersion", 2.0, dispersion={"dispersion": 3.0}), "plain"),
        ("velvet", make(g, "sheen", (0.16, 0.006, 0.03), 0.0, 0.9, sheen={
            "sheenColorFactor": [0.95, 0.35, 0.45], "sheenRoughnessFactor": 0.35}), "plain"),
        ("jade", glass(g, "volume scatter", 1.5, 0.15, 0.08, (0.5, 0.5, 0.5), volume_scatter={
            "multiscatterColorFactor": [0.35, 0.8, 0.5], "scatterAnisotropy": 0.0}), "plain"),
        ("tempered steel", make(g, "iridescence", (0.42, 0.42, 0.44), 1.0, 0.15, iridescence={
            "iridescenceFactor": 1.0, "iridescenceIor": 1.6, "iridescenceThicknessMaximum": 330}), "plain"),
        ("brushed copper", make(g, "anisotropy", materials.COPPER, 1.0, 0.4, anisotropy={"anisotropyStrength": 0.95}), "textured"),
        ("paper lantern", make(g, "diffuse transmission", (0.75, 0.7, 0.6), 0.0, 0.8, diffuse_transmission={
            "diffuseTransmissionFactor": 0.7, "diffuseTransmissionColorFactor": [0.95, 0.62, 0.3]}), bulb),
        ("soap bubble", make(g, "thin transmission, iridescence", (1, 1, 1), 0.0, 0.0, transmission={"transmissionFactor": 1.0},
                             iridescence=soap), "textured"),
        ("flat", make(g, "unlit", (0.85, 0.50, 0.03), 0.0, 0.5, unlit={}), "plain"),
        ("high index", make(g, "ior", (0.10, 0.012, 0.015), 0.0, 0.06, ior={"ior": 2.4}), "plain"),
        ("tinted gloss", make(g, "specular", (0.03, 0.04, 0.05), 0.0, 0.12, specular={"specularColorFactor": [6.0, 3.5, 1.2]}), "plain"),
        ("ember", g.add_material("emissive strength", (0.02, 0.02, 0.02), 0.0, 0.5, emission=(1.5, 0.30, 0.04)), "plain"),
        ("old gold", make(g, "specular-glossiness", (0.5, 0.5, 0.5), 0.0, 1.0, pbrSpecularGlossiness={
            "diffuseFactor": [0, 0, 0, 1], "specularFactor": list(materials.GOLD), "glossinessFactor": 0.75}), "plain"),
        ("frosted", glass(g, "rough volume", 1.5, 0.3, 0.7, (0.55, 0.85, 0.9)), "plain"),
    ]


def _stripes():
    return images.paint(16, 16, 3, lambda x, y: (0.86, 0.85, 0.82) if x // 8 == 0 else (0.20, 0.24, 0.30))
