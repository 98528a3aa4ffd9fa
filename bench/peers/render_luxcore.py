"""Renders one glTF scene with LuxCore, by its path tracer for processors.

    PYTHON render_luxcore.py JOB.json

PYTHON is that of the environment of install.py; the job is written by run.py. Settings: PATHCPU, Sobol samples, box
filter, no clamping. What differs from glTF: see README.md.
"""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyluxcore

import gltf_meshes
import gltf_scene


class Converter:
    def __init__(self, folder):
        self.folder = folder
        self.properties = pyluxcore.Properties()
        self.textures = {}

    def set(self, prefix, values):
        for name, value in values.items():
            self.properties.Set(pyluxcore.Property(f"{prefix}.{name}", value))

    def scene(self, gltf, job):
        self.camera(gltf.camera, job["size_px"])
        names = {}
        for mesh in gltf.meshes:
            if id(mesh.material) not in names:
                names[id(mesh.material)] = f"material{len(names)}"
                self.material(names[id(mesh.material)], mesh.material)
        for number, mesh in enumerate(gltf.meshes):
            self.add_object(f"mesh{number}", mesh, names[id(mesh.material)])
            if mesh.material.emits() and not gltf_meshes.is_closed(mesh):  # LuxCore's emitters have one side
                self.add_object(f"mesh{number}back", gltf_meshes.back_of(mesh), names[id(mesh.material)])
        for number, light in enumerate(gltf.lights):
            self.set(f"scene.lights.light{number}", punctual(light))
        if job["environment"]:
            self.environment(job)
        scene = pyluxcore.Scene()
        scene.Parse(self.properties)
        return scene

    def camera(self, camera, size_px):
        to_world = camera.to_world
        eye = to_world[:3, 3]
        # The angle is that of the longer side.
        aspect = max(size_px[0] / size_px[1], 1.0)
        angle_rad = 2.0 * math.atan(math.tan(camera.yfov_rad / 2.0) * aspect)
        self.set("scene.camera", {"type": "perspective", "lookat.orig": list(map(float, eye)),
                                  "lookat.target": list(map(float, eye - to_world[:3, 2])), "up": list(map(float, to_world[:3, 1])),
                                  "fieldofview": math.degrees(angle_rad), "autofocus.enable": False, "lensradius": 0.0,
                                  "cliphither": 1e-3, "clipyon": 1e6})

    def add_object(self, name, mesh, material):
        file = self.folder / f"{name}.ply"
        gltf_meshes.write_ply(mesh, file)
        self.set(f"scene.shapes.{name}", {"type": "mesh", "ply": str(file)})
        self.set(f"scene.objects.{name}", {"shape": name, "material": material})

    def environment(self, job):
        # glTF's direction (x, y, z) is at u = 0.5 + atan2(z, x) / 2 pi of the image; LuxCore's at
        # atan2(y, x) / 2 pi, z up.
        angle = math.radians(job["environment_rotation_deg"])
        turn = np.array([[math.cos(angle), 0, math.sin(angle)], [0, 1, 0], [-math.sin(angle), 0, math.cos(angle)]])
        to_world = np.eye(4)
        to_world[:3, :3] = turn @ np.array([[-1, 0, 0], [0, 0, -1], [0, 1, 0]]).T
        gain = job["environment_intensity"]
        self.set("scene.lights.environment", {"type": "infinite", "file": job["environment"], "gamma": 1.0, "gain": [gain] * 3,
                                              "transformation": [float(value) for value in to_world.T.ravel()]})

    def texture(self, file, gamma, channel=None, factor=None):
        """The name of an image as a texture, times a factor."""
        key = (file, gamma, channel, factor)
        if key not in self.textures:
            self.textures[key] = name = f"texture{len(self.textures)}"
            values = {"type": "imagemap", "file": str(file), "gamma": gamma}
            self.set(f"scene.textures.{name}", values | ({"channel": channel} if channel else {}))
            if factor is not None:
                scaled = f"{name}scaled"
                self.set(f"scene.textures.{scaled}", {"type": "scale", "texture1": name, "texture2": list(factor)})
                self.textures[key] = scaled
        return self.textures[key]

    def material(self, name, material):
        common = {}
        if material.normal_texture is not None:
            bump = f"{name}normal"
            self.set(f"scene.textures.{bump}", {"type": "normalmap", "texture": self.texture(material.normal_texture, 1.0),
                                                "scale": material.normal_scale})
            common["bumptex"] = bump
        values = self.glass(name, material) if material.transmission > 0.0 else self.opaque(name, material, common)
        values |= common
        if material.alpha_mode != "OPAQUE":
            if material.base_color_texture is None:
                values["transparency"] = material.alpha
            else:
                values["transparency"] = self.texture(material.base_color_texture, 1.0, "alpha", (material.alpha,))
        if material.emits():
            values |= {"emission": list(material.emission), "emission.power": 0.0, "emission.normalizebycolor": False,
                       "emission.gain": [1.0, 1.0, 1.0]}
            if material.emission_texture is not None:
                values["emission"] = self.texture(material.emission_texture, 2.2, None, tuple(material.emission))
        self.set(f"scene.materials.{name}", values)

    def opaque(self, name, material, common):
        """A glossy dielectric, a metal, or a mixture of both by the metallic value."""
        color = list(material.base_color)
        if material.base_color_texture is not None:
            color = self.texture(material.base_color_texture, 2.2, None, tuple(material.base_color))
        if material.specular == 0.0 and material.metallic == 0.0:
            return {"type": "matte", "kd": color}
        alpha, metallic = material.roughness ** 2, material.metallic
        if material.metallic_roughness_texture is not None:
            roughness = self.texture(material.metallic_roughness_texture, 1.0, "green", (material.roughness,))
            alpha = f"{name}alpha"
            self.set(f"scene.textures.{alpha}", {"type": "scale", "texture1": roughness, "texture2": roughness})
            metallic = self.texture(material.metallic_roughness_texture, 1.0, "blue", (metallic,))
        reflectance = material.specular * ((material.ior - 1.0) / (material.ior + 1.0)) ** 2
        dielectric = {"type": "glossy2", "kd": color, "ks": [reflectance] * 3, "uroughness": alpha, "vroughness": alpha,
                      "multibounce": False}
        fresnel = f"{name}fresnel"
        self.set(f"scene.textures.{fresnel}", {"type": "fresnelcolor", "kr": color})
        metal = {"type": "metal2", "fresnel": fresnel, "uroughness": alpha, "vroughness": alpha}
        if metallic == 0.0:
            return dielectric
        if metallic == 1.0:
            return metal
        self.set(f"scene.materials.{name}dielectric", dielectric | common)
        self.set(f"scene.materials.{name}metal", metal | common)
        return {"type": "mix", "material1": f"{name}dielectric", "material2": f"{name}metal", "amount": metallic}

    def glass(self, name, material):
        kind = "archglass" if material.thickness == 0.0 else "roughglass" if material.roughness > 0.01 else "glass"
        values = {"type": kind, "kr": [1.0] * 3, "kt": list(material.base_color), "interiorior": material.ior, "exteriorior": 1.0}
        if kind == "roughglass":
            values |= {"uroughness": material.roughness ** 2, "vroughness": material.roughness ** 2}
        if material.thickness > 0.0 and material.attenuation_distance < float("inf") and min(material.attenuation_color) < 1.0:
            volume = f"{name}volume"
            absorption = [-math.log(max(value, 1e-6)) / material.attenuation_distance for value in material.attenuation_color]
            self.set(f"scene.volumes.{volume}", {"type": "clear", "absorption": absorption, "ior": material.ior})
            values["volume.interior"] = volume
        return values


def punctual(light):
    """A spot's edge is LuxCore's own, between the same angles."""
    position, color = light.position.tolist(), light.intensity.tolist()
    if light.kind == "directional":
        return {"type": "sharpdistant", "direction": light.direction.tolist(), "color": color, "gain": [1.0] * 3}
    gain = 4.0 * math.pi if light.kind == "point" else 1.0  # a point's color is that of all directions
    values = {"type": light.kind, "position": position, "color": color, "gain": [gain] * 3, "power": 0.0}
    if light.kind == "spot":
        values |= {"target": (light.position + light.direction).tolist(), "coneangle": math.degrees(light.outer_rad),
                   "conedeltaangle": math.degrees(light.outer_rad - light.inner_rad)}
    return values


def timed_render(scene, job, samples):
    """Returns (pixels, wall seconds, CPU seconds of all threads)."""
    width, height = job["size_px"]
    depth = job["max_bounces"] + 1
    properties = pyluxcore.Properties()
    values = {"renderengine.type": "PATHCPU", "sampler.type": "SOBOL", "native.threads.count": job["threads"],
              "film.width": width, "film.height": height, "film.filter.type": "BOX", "film.filter.width": 0.5,
              "film.imagepipelines.0.0.type": "NOP", "batch.haltspp": samples, "renderengine.seed": job["seed"],
              "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth, "path.pathdepth.glossy": depth,
              "path.pathdepth.specular": depth, "path.clamping.variance.maxvalue": 0.0}
    for name, value in values.items():
        properties.Set(pyluxcore.Property(name, value))
    wall, cpu = time.perf_counter(), time.process_time()
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties, scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.005)
        session.UpdateStats()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    pixels = np.zeros((height, width, 3), np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB_IMAGEPIPELINE, pixels)
    session.Stop()
    return pixels[::-1], wall, cpu


def write_pfm(path, pixels):
    """A PFM file: rows from the bottom."""
    with open(path, "wb") as file:
        file.write(f"PF\n{pixels.shape[1]} {pixels.shape[0]}\n-1.0\n".encode())
        file.write(np.ascontiguousarray(pixels[::-1], "<f4").tobytes())


def main():
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    pyluxcore.Init()
    with tempfile.TemporaryDirectory() as folder:
        gltf = gltf_scene.read_scene(job["scene"], folder)
        scene = Converter(Path(folder)).scene(gltf, job)
        _, one_wall_s, one_cpu_s = timed_render(scene, job, 1)
        pixels, wall_s, cpu_s = timed_render(scene, job, job["spp"])
    write_pfm(job["output"], pixels)
    rest = job["spp"] / max(job["spp"] - 1, 1)  # the first sample's time includes the building of trees
    print("PEER-RESULT " + json.dumps({"version": pyluxcore.Version(), "wall_s": max(wall_s - one_wall_s, 1e-3) * rest,
                                       "cpu_s": max(cpu_s - one_cpu_s, 1e-3) * rest}), flush=True)


main()
