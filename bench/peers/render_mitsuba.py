"""Renders one glTF scene with Mitsuba 3, on the processor (llvm_ad_rgb) or a GPU (cuda_ad_rgb).

    PYTHON render_mitsuba.py JOB.json

PYTHON is that of the environment of install.py; the job is written by run.py. Settings are those of a plain path
tracer: integrator `path` (or `volpath` where glass absorbs or surfaces are cut out), box filter, independent samples, as Mitsuba's defaults are.
What differs from glTF: see README.md.
"""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import os
import sys
import tempfile
import time
from pathlib import Path

import drjit as dr
import numpy as np

import mitsuba as mi

import gltf_meshes
import gltf_scene

MIN_ALPHA = 1e-4
MAX_SMOOTH = 0.01  # roughness of glass that counts as smooth
MIN_GLASS = 0.99  # share of glass from which on a material is nothing else


def rgb(values):
    return {"type": "rgb", "value": [float(value) for value in values]}


class Converter:
    def __init__(self, folder):
        self.folder = folder
        self.needs_volpath = False  # light that is sampled passes through cut-outs, and through glass that absorbs, in `volpath` alone

    def scene(self, gltf, job):
        scene = {"type": "scene", "sensor": self.sensor(gltf.camera, job)}
        materials = {}
        for mesh in gltf.meshes:
            if id(mesh.material) not in materials:
                materials[id(mesh.material)] = f"material{len(materials)}"
                scene[materials[id(mesh.material)]] = self.bsdf(mesh.material)
        for number, mesh in enumerate(gltf.meshes):
            self.add_mesh(scene, number, mesh, materials[id(mesh.material)])
        for number, light in enumerate(gltf.lights):
            scene[f"light{number}"] = punctual(light)
        if job["environment"]:
            scene["environment"] = {"type": "envmap", "filename": job["environment"], "scale": job["environment_intensity"],
                                    "to_world": environment_to_world(job["environment_rotation_deg"])}
        depth = job["max_bounces"] + 2  # Mitsuba counts segments: 1 is emission, 2 direct light
        scene["integrator"] = {"type": "volpath" if self.needs_volpath else "path", "max_depth": depth,
                               "hide_emitters": not job["background_visible"]}
        return scene

    @staticmethod
    def sensor(camera, job):
        flip = np.diag([-1.0, 1.0, -1.0, 1.0])  # Mitsuba's cameras look along +z, with x to the left
        width, height = job["size_px"]
        return {"type": "perspective", "fov_axis": "y", "fov": math.degrees(camera.yfov_rad), "near_clip": 1e-3, "far_clip": 1e6,
                "to_world": mi.ScalarTransform4f((camera.to_world @ flip).tolist()),
                "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"},
                         "pixel_format": "rgb", "component_format": "float32"},
                "sampler": {"type": "independent", "sample_count": job["spp"]}}

    def add_mesh(self, scene, number, mesh, material):
        file = self.folder / f"mesh{number}.ply"
        gltf_meshes.write_ply(mesh, file)
        shape = {"type": "ply", "filename": str(file), "face_normals": mesh.normals is None,
                 "bsdf": {"type": "ref", "id": material}}
        if mesh.material.transmission > 0.0 and mesh.material.thickness > 0.0 and (medium := self.medium(mesh.material)):
            shape["interior"] = medium
        if mesh.material.emits():
            shape["emitter"] = {"type": "area", "radiance": color(mesh.material.emission, mesh.material.emission_texture)}
        scene[f"mesh{number}"] = shape
        if mesh.material.emits() and not gltf_meshes.is_closed(mesh):  # Mitsuba's emitters have one side
            back = self.folder / f"mesh{number}.back.ply"
            gltf_meshes.write_ply(gltf_meshes.back_of(mesh), back)
            scene[f"mesh{number}back"] = dict(shape, filename=str(back))

    def medium(self, material):
        if material.attenuation_distance == float("inf") or min(material.attenuation_color) >= 1.0:
            return None
        self.needs_volpath = True
        sigma = [max(-math.log(max(value, 1e-6)), 0.0) / material.attenuation_distance for value in material.attenuation_color]
        scale = max(sigma)
        relative = [max(value / scale, 1e-4) for value in sigma]  # `volpath` returns NaN where a channel is not absorbed
        return {"type": "homogeneous", "albedo": 0.0, "sigma_t": rgb(relative), "scale": scale}

    def bsdf(self, material):
        weight = self.glass_weight(material)
        parts = []
        if np.min(weight) < MIN_GLASS:
            parts.append({"type": "twosided", "bsdf": self.with_normals(material, self.opaque(material))})
        if np.max(weight) > 0.0:
            parts.append(self.with_normals(material, self.glass(material)))
        bsdf = parts[0]
        if len(parts) == 2:
            bsdf = {"type": "blendbsdf", "weight": bitmap(weight) if weight.ndim else float(weight), "opaque": parts[0], "glass": parts[1]}
        opacity = self.opacity(material)
        self.needs_volpath |= opacity is not None
        return {"type": "mask", "opacity": opacity, "bsdf": bsdf} if opacity is not None else bsdf

    @staticmethod
    def glass_weight(material):
        """The share of a material that is glass; the rest is opaque. A number, or (height, width, 1)."""
        weight = np.float32(material.transmission)
        if weight > 0.0 and material.transmission_texture is not None:
            weight = weight * load_texels(material.transmission_texture)[..., :1]
        if np.max(weight) == 0.0 or material.metallic == 0.0:
            return weight
        metallic = np.float32(material.metallic)
        if material.metallic_roughness_texture is not None:
            metallic = metallic * load_texels(material.metallic_roughness_texture)[..., 2:3]
        return times(weight, 1.0 - metallic)

    @staticmethod
    def with_normals(material, bsdf):
        if material.normal_texture is None:
            return bsdf
        texels = load_texels(material.normal_texture)[..., :3]
        texels[..., :2] = 0.5 + (texels[..., :2] - 0.5) * material.normal_scale
        return {"type": "normalmap", "normalmap": bitmap(texels), "bsdf": bsdf}

    @staticmethod
    def opacity(material):
        if material.alpha_mode == "OPAQUE":
            return None
        if material.base_color_texture is None:
            return material.alpha
        texels = load_texels(material.base_color_texture)
        alpha = (texels[..., 3:4] if texels.shape[2] == 4 else np.ones_like(texels[..., :1])) * material.alpha
        return bitmap((alpha >= material.alpha_cutoff).astype(np.float32) if material.alpha_mode == "MASK" else alpha)

    @staticmethod
    def opaque(material):
        base_color = color(material.base_color, material.base_color_texture)
        if material.specular == 0.0 and material.metallic == 0.0:
            return {"type": "diffuse", "reflectance": base_color}
        roughness, metallic = material.roughness, material.metallic
        if material.metallic_roughness_texture is not None:
            texels = load_texels(material.metallic_roughness_texture)
            roughness, metallic = bitmap(texels[..., 1:2] * roughness), bitmap(texels[..., 2:3] * metallic)
        if metallic == 1.0 and not isinstance(roughness, dict) and material.clearcoat == 0.0:  # a metal alone: its exact model
            return {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": max(roughness ** 2, MIN_ALPHA),
                    "specular_reflectance": base_color}
        reflectance = material.specular * ((material.ior - 1.0) / (material.ior + 1.0)) ** 2
        return {"type": "principled", "base_color": base_color, "roughness": roughness, "metallic": metallic,
                "specular": min(reflectance / 0.08, 1.0)} | coat(material)

    @staticmethod
    def glass(material):
        roughness = np.float32(material.roughness)
        if material.metallic_roughness_texture is not None:
            roughness = roughness * load_texels(material.metallic_roughness_texture)[..., 1:2]
        is_smooth = np.max(roughness) <= MAX_SMOOTH
        tint = color(material.base_color, material.base_color_texture)
        if material.thickness == 0.0 and not is_smooth and material.ior > 1.0:
            return {"type": "principledthin", "base_color": tint, "roughness": bitmap(roughness) if roughness.ndim else float(roughness),
                    "spec_trans": 1.0, "diff_trans": 0.0, "eta": material.ior}
        kind = {"type": "thindielectric" if material.thickness == 0.0 else "dielectric"}
        if material.thickness > 0.0 and not is_smooth:
            alpha = np.maximum(roughness ** 2, MIN_ALPHA)
            kind = {"type": "roughdielectric", "distribution": "ggx", "alpha": bitmap(alpha) if alpha.ndim else float(alpha)}
        return kind | {"int_ior": material.ior, "ext_ior": 1.0, "specular_transmittance": tint}


def coat(material):
    """The clear coat of a `principled`, whose alpha is 0.1 to 0.001 by its gloss."""
    if material.clearcoat == 0.0:
        return {}
    return {"clearcoat": material.clearcoat, "clearcoat_gloss": min(max((0.1 - material.clearcoat_roughness ** 2) / 0.099, 0.0), 1.0)}


def times(a, b):
    """The product of two images, or of one and a number; the smaller image is spread over the larger one."""
    if not (np.ndim(a) and np.ndim(b)):
        return a * b
    height, width = max(a.shape[0], b.shape[0]), max(a.shape[1], b.shape[1])
    rows, columns = np.arange(height), np.arange(width)
    a, b = (x[rows[:, None] * x.shape[0] // height, columns * x.shape[1] // width] for x in (a, b))
    return a * b


def color(factor, texture):
    if texture is None:
        return rgb(factor)
    return bitmap(linear(load_texels(texture)[..., :3]) * np.array(factor, np.float32))


def punctual(light):
    """A spot's edge is linear in the angle, where glTF has the square of a line in its cosine."""
    position, direction = light.position.tolist(), light.direction.tolist()
    if light.kind == "directional":
        return {"type": "directional", "direction": direction, "irradiance": rgb(light.intensity)}
    if light.kind == "point":
        return {"type": "point", "position": position, "intensity": rgb(light.intensity)}
    up = [0.0, 1.0, 0.0] if abs(direction[1]) < 0.9 else [1.0, 0.0, 0.0]
    to_world = mi.ScalarTransform4f().look_at(position, [a + b for a, b in zip(position, direction)], up)
    return {"type": "spot", "to_world": to_world, "intensity": rgb(light.intensity),
            "cutoff_angle": math.degrees(light.outer_rad), "beam_width": math.degrees(light.inner_rad)}


def environment_to_world(rotation_deg):
    """glTF's direction (x, y, z) is at u = 0.5 + atan2(z, x) / 2 pi of the image; Mitsuba's at atan2(x, -z) / 2 pi."""
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], rotation_deg)
    return turn @ mi.ScalarTransform4f([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])


def load_texels(path):
    """(height, width, channels) in [0, 1], as stored."""
    bitmap_read = mi.Bitmap(str(path))
    texels = np.array(bitmap_read)
    texels = texels[..., None] if texels.ndim == 2 else texels
    return texels.astype(np.float32) / (np.iinfo(texels.dtype).max if texels.dtype.kind == "u" else 1.0)


def linear(texels):
    return np.where(texels <= 0.04045, texels / 12.92, ((texels + 0.055) / 1.055) ** 2.4).astype(np.float32)


def bitmap(texels):
    return {"type": "bitmap", "data": mi.TensorXf(np.ascontiguousarray(texels, np.float32)), "raw": True}


def timed_render(scene, spp, seed):
    """Returns (pixels, wall seconds, CPU seconds of all threads)."""
    wall, cpu = time.perf_counter(), time.process_time()
    image = mi.render(scene, spp=spp, seed=seed)
    dr.eval(image)
    dr.sync_thread()
    pixels = np.array(image)
    return pixels, time.perf_counter() - wall, time.process_time() - cpu


def main():
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    mi.set_variant(job["variant"])
    # A pool of one thread waits for ever: with one, two threads share a core.
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:job["threads"]])
    dr.set_thread_count(max(job["threads"], 2))
    with tempfile.TemporaryDirectory() as folder:
        gltf = gltf_scene.read_scene(job["scene"], folder)
        scene = mi.load_dict(Converter(Path(folder)).scene(gltf, job))
        timed_render(scene, job["spp"], job["seed"] + 1_000_000)  # compiles the kernels
        pixels, wall_s, cpu_s = timed_render(scene, job["spp"], job["seed"])
    mi.Bitmap(pixels).write(job["output"])
    print("PEER-RESULT " + json.dumps({"version": mi.__version__, "wall_s": wall_s, "cpu_s": cpu_s}), flush=True)


main()
