# SPDX-License-Identifier: Apache-2.0
"""The gallery's rows: one extension each, its parameters from left to right."""
import math

from . import images

GOLD, COPPER = (1.000, 0.766, 0.336), (0.955, 0.638, 0.538)


def make(g, name, color, metallic=0.0, roughness=0.05, fields=None, **extensions):
    """A material with KHR_materials_NAME for each of the extensions."""
    for extension in extensions:
        g.use("KHR_materials_" + extension)
    return g.add_material(name, color, metallic, roughness, extensions={"KHR_materials_" + k: v for k, v in extensions.items()},
                          **(fields or {}))


def ior(stage):
    for i, n in enumerate([1.0, 1.15, 1.33, 1.5, 1.8, 2.4, 4.0]):
        stage.place(i, make(stage.g, "ior %g" % n, (0.10, 0.012, 0.015), 0.0, 0.06, ior={"ior": n}))


def specular(stage):
    base = (0.035, 0.05, 0.085)
    for i, factor in enumerate([0.0, 0.35, 0.7, 1.0]):
        stage.place(i, make(stage.g, "factor %g" % factor, base, 0.0, 0.12, specular={"specularFactor": factor}))
    colors = [("colour 1 .3 .1", (1.0, 0.3, 0.1)), ("colour .1 .6 1", (0.1, 0.6, 1.0)), ("colour 8 5 2", (8.0, 5.0, 2.0))]
    for i, (name, color) in enumerate(colors):
        stage.place(4 + i, make(stage.g, name, base, 0.0, 0.12, specular={"specularColorFactor": color}))


def clearcoat(stage):
    g, red = stage.g, (0.42, 0.022, 0.02)
    hammered = {"index": g.add_texture("hammered", bumps(64, 5, 3.0))}
    peel = {"index": g.add_texture("orange peel", bumps(96, 16, 0.8))}
    rows = [("factor 0", {}, {}), ("factor .5", {"clearcoatFactor": 0.5}, {}), ("factor 1", {"clearcoatFactor": 1.0}, {}),
            ("rough .2", {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.2}, {}),
            ("rough .5", {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.5}, {}),
            ("base bumps", {"clearcoatFactor": 1.0}, {"normalTexture": hammered}),
            ("coat bumps", {"clearcoatFactor": 1.0, "clearcoatNormalTexture": peel}, {})]
    for i, (name, coat, fields) in enumerate(rows):
        stage.place(i, make(g, name, red, 0.9, 0.55, fields, clearcoat=coat), "textured")


def sheen(stage):
    base = (0.02, 0.02, 0.03)
    for i, roughness in enumerate([None, 0.15, 0.3, 0.6, 1.0]):
        cloth = {} if roughness is None else {"sheen": {"sheenColorFactor": [0.9, 0.9, 0.9], "sheenRoughnessFactor": roughness}}
        stage.place(i, make(stage.g, "none" if roughness is None else "rough %g" % roughness, base, 0.0, 0.9, **cloth))
    for i, (name, color) in enumerate([("red", (0.9, 0.08, 0.06)), ("blue on teal", (0.12, 0.2, 1.0))]):
        stage.place(5 + i, make(stage.g, name, base if i == 0 else (0.01, 0.10, 0.09), 0.0, 0.9,
                                sheen={"sheenColorFactor": color, "sheenRoughnessFactor": 0.4}))


def transmission(stage):
    rows = [("factor 0", (0.9, 0.9, 0.9), 0.0, 0.0), ("factor .5", (0.9, 0.9, 0.9), 0.5, 0.0), ("factor 1", (1.0, 1.0, 1.0), 1.0, 0.0),
            ("tinted", (0.95, 0.55, 0.12), 1.0, 0.0), ("rough .15", (1.0, 1.0, 1.0), 1.0, 0.15),
            ("rough .35", (1.0, 1.0, 1.0), 1.0, 0.35), ("rough .7", (1.0, 1.0, 1.0), 1.0, 0.7)]
    for i, (name, color, factor, roughness) in enumerate(rows):
        stage.place(i, make(stage.g, name, color, 0.0, roughness, transmission={"transmissionFactor": factor}))


def glass(g, name, n=1.5, roughness=0.0, distance_m=None, color=(1, 1, 1), **more):
    volume = {"thicknessFactor": 0.9}
    if distance_m is not None:
        volume.update(attenuationDistance=distance_m, attenuationColor=list(color))
    return make(g, name, (1, 1, 1), 0.0, roughness, transmission={"transmissionFactor": 1.0}, volume=volume, ior={"ior": n}, **more)


def volume(stage):
    """Solid glass: attenuation of one color at decreasing distances, then a smaller index, then rough."""
    amber = (0.90, 0.42, 0.06)
    stage.place(0, glass(stage.g, "clear"))
    for i, distance in enumerate([1.6, 0.8, 0.4, 0.2]):
        stage.place(1 + i, glass(stage.g, "%g m" % distance, distance_m=distance, color=amber))
    stage.place(5, glass(stage.g, "water", 1.33, 0.0, 0.8, (0.35, 0.75, 0.85)))
    stage.place(6, glass(stage.g, "rough .25", 1.5, 0.25, 0.6, (0.25, 0.8, 0.35)))


def dispersion(stage):
    for i, amount in enumerate([0.0, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0]):
        stage.place(i, glass(stage.g, "%g" % amount, 1.7, dispersion={"dispersion": amount}))


def iridescence(stage):
    g, base = stage.g, (0.42, 0.42, 0.44)
    for i, thickness in enumerate([150, 250, 350, 450, 600]):
        stage.place(i, make(g, "%d nm" % thickness, base, 1.0, 0.12, iridescence={
            "iridescenceFactor": 1.0, "iridescenceIor": 1.4, "iridescenceThicknessMaximum": thickness}), "textured")
    stage.place(5, make(g, "350 nm ior 2", base, 1.0, 0.12, iridescence={
        "iridescenceFactor": 1.0, "iridescenceIor": 2.0, "iridescenceThicknessMaximum": 350}), "textured")
    ramp = g.add_texture("ramp", images.paint(1, 64, 3, lambda x, y: (0.0, (63 - y) / 63, 0.0)), wrap=33071)
    stage.place(6, make(g, "100-900 nm", (0.01, 0.01, 0.012), 0.0, 0.02, iridescence={
        "iridescenceFactor": 1.0, "iridescenceIor": 1.33, "iridescenceThicknessMinimum": 100, "iridescenceThicknessMaximum": 900,
        "iridescenceThicknessTexture": {"index": ramp}}, ior={"ior": 1.8}), "textured")


def anisotropy(stage):
    g = stage.g
    rows = [("strength %g" % s, {"anisotropyStrength": s}) for s in (0.0, 0.35, 0.7, 1.0)]
    rows += [("at 45 deg", {"anisotropyStrength": 1.0, "anisotropyRotation": math.pi / 4}),
             ("at 90 deg", {"anisotropyStrength": 1.0, "anisotropyRotation": math.pi / 2}),
             ("by texture", {"anisotropyStrength": 1.0, "anisotropyTexture": {"index": g.add_texture("turns", turns())}})]
    for i, (name, values) in enumerate(rows):
        stage.place(i, make(g, name, (0.80, 0.78, 0.75), 1.0, 0.4, anisotropy=values), "textured")


def diffuse_transmission(stage):
    """Paper globes with a lamp in each."""
    g = stage.g
    rows = [("factor 0", 0.0, (1, 1, 1)), ("factor .25", 0.25, (1, 1, 1)), ("factor .5", 0.5, (1, 1, 1)), ("factor 1", 1.0, (1, 1, 1)),
            ("red", 0.7, (0.9, 0.12, 0.06)), ("green", 0.7, (0.25, 0.75, 0.1)), ("blue", 0.7, (0.1, 0.25, 0.9))]
    for i, (name, factor, color) in enumerate(rows):
        stage.place(i, make(g, name, (0.75, 0.73, 0.7), 0.0, 0.8, diffuse_transmission={
            "diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": list(color)}))
    lamp = g.add_material("lamp", (0, 0, 0), emission=(10, 8.4, 6.4), diffuse_only=True)
    for i in range(len(rows)):
        stage.place(i, lamp, "lamp", 0.09)


def emissive_strength(stage):
    for i, strength in enumerate([0.05, 0.15, 0.5, 1.0, 2.0, 4.0, 8.0]):
        hue = images.mix((1.0, 0.16, 0.02), (0.10, 0.30, 1.0), i / 6)
        stage.g.use("KHR_materials_emissive_strength")
        stage.place(i, stage.g.add_material("strength %g" % strength, (0.02, 0.02, 0.02), 0.0, 0.5, emissiveFactor=list(hue), extensions={
            "KHR_materials_emissive_strength": {"emissiveStrength": strength}}))


def unlit(stage):
    colors = [(0.8, 0.8, 0.8), (0.8, 0.10, 0.06), (0.85, 0.50, 0.03), (0.10, 0.45, 0.08), (0.04, 0.32, 0.45), (0.06, 0.09, 0.5),
              (0.02, 0.02, 0.02)]
    for i, color in enumerate(colors):
        flat = i % 2 == 0
        stage.place(i, make(stage.g, "unlit" if flat else "lit", color, 0.0, 0.5, **({"unlit": {}} if flat else {})))


def specular_glossiness(stage):
    """The archived pbrSpecularGlossiness; its fallback in metallic-roughness is plain gray."""
    for i, glossiness in enumerate([0.0, 0.35, 0.7, 1.0]):
        stage.place(i, make(stage.g, "gloss %g" % glossiness, (0.5, 0.5, 0.5), 0.0, 1.0, pbrSpecularGlossiness={
            "diffuseFactor": [0.03, 0.10, 0.16, 1.0], "specularFactor": [0.05, 0.05, 0.05], "glossinessFactor": glossiness}))
    colors = [("specular .2", (0.03, 0.10, 0.16), (0.2, 0.2, 0.2)), ("specular red", (0.03, 0.03, 0.03), (0.5, 0.08, 0.05)),
              ("gold", (0.0, 0.0, 0.0), GOLD)]
    for i, (name, diffuse, specular_color) in enumerate(colors):
        stage.place(4 + i, make(stage.g, name, (0.5, 0.5, 0.5), 0.0, 1.0, pbrSpecularGlossiness={
            "diffuseFactor": [*diffuse, 1.0], "specularFactor": list(specular_color), "glossinessFactor": 0.8}))


def volume_scatter(stage):
    """Draft: wax, jade, milk; then the phase function's g."""
    rows = [("albedo .3", 0.1, (0.3, 0.3, 0.3), 0.0), ("albedo .9", 0.1, (0.9, 0.9, 0.9), 0.0), ("wax", 0.12, (0.95, 0.75, 0.45), 0.0),
            ("jade", 0.08, (0.35, 0.8, 0.5), 0.0), ("skin", 0.05, (0.9, 0.6, 0.48), 0.0), ("g .8", 0.1, (0.9, 0.9, 0.9), 0.8),
            ("g -.5", 0.1, (0.9, 0.9, 0.9), -0.5)]
    for i, (name, distance, color, g) in enumerate(rows):
        stage.place(i, glass(stage.g, name, 1.4, 0.3, distance, (0.5, 0.5, 0.5), volume_scatter={
            "multiscatterColorFactor": list(color), "scatterAnisotropy": g}))


def bumps(size, cells, strength):
    return images.normal_map(size, size, lambda x, y: images.noise(x * cells / size, y * cells / size, cells, cells, 4), strength)


def turns():
    """Direction of anisotropy turns once around the sphere (red, green: cosine and sine); strength is 1."""
    def pixel(x, y):
        angle = 2.0 * math.pi * (x + 0.5) / 32.0 * 2.0
        return (0.5 + 0.5 * math.cos(angle), 0.5 + 0.5 * math.sin(angle), 1.0)

    return images.paint(32, 1, 3, pixel)


ROWS = {  # name: (function, card behind, factor of the stage's light)
    "ior": (ior, False, 1.0),
    "specular": (specular, False, 1.0),
    "clearcoat": (clearcoat, False, 1.0),
    "sheen": (sheen, False, 1.0),
    "transmission": (transmission, True, 1.0),
    "volume": (volume, True, 1.0),
    "dispersion": (dispersion, True, 1.0),
    "iridescence": (iridescence, False, 1.0),
    "anisotropy": (anisotropy, False, 1.0),
    "diffuse_transmission": (diffuse_transmission, False, 0.25),
    "emissive_strength": (emissive_strength, False, 0.1),
    "unlit": (unlit, False, 1.0),
    "specular_glossiness": (specular_glossiness, False, 1.0),
    "volume_scatter": (volume_scatter, False, 1.0),
}
