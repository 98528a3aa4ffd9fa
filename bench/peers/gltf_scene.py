"""Reads glTF as plain triangles, materials and a camera, for renderers that read no glTF.

Static scenes without compression: nodes, meshes of triangles, EXT_mesh_gpu_instancing, KHR_mesh_quantization, KHR_lights_punctual,
KHR_texture_transform where all textures of a material have the same one,
KHR_materials_{specular,ior,transmission,volume,emissive_strength}, and the factors of KHR_materials_clearcoat. Joints and
morph targets are not read. A file that requires more ends with a message.
"""
# SPDX-License-Identifier: Apache-2.0
import base64
import json
import math
import struct
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gltf_meshes import Mesh, placed

COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
READ = {"KHR_materials_specular", "KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume",
        "KHR_materials_emissive_strength", "KHR_materials_clearcoat", "KHR_lights_punctual", "KHR_texture_transform",
        "KHR_mesh_quantization", "EXT_mesh_gpu_instancing"}


@dataclass
class Material:
    """As glTF defines it. Textures are files, or None."""
    name: str = "default"
    base_color: tuple = (1.0, 1.0, 1.0)
    alpha: float = 1.0
    alpha_mode: str = "OPAQUE"
    alpha_cutoff: float = 0.5
    base_color_texture: Path | None = None
    metallic: float = 1.0
    roughness: float = 1.0
    metallic_roughness_texture: Path | None = None
    normal_texture: Path | None = None
    normal_scale: float = 1.0
    emission: tuple = (0.0, 0.0, 0.0)  # radiance
    emission_texture: Path | None = None
    double_sided: bool = False
    specular: float = 1.0
    ior: float = 1.5
    transmission: float = 0.0
    transmission_texture: Path | None = None
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.0
    thickness: float = 0.0  # above 0: the mesh bounds a solid
    attenuation_color: tuple = (1.0, 1.0, 1.0)
    attenuation_distance: float = float("inf")
    texture_place: "TexturePlace | None" = None  # None: without textures

    def emits(self):
        return any(value > 0.0 for value in self.emission)


@dataclass(frozen=True)
class TexturePlace:
    """Where textures lie: a set of texture coordinates, and what KHR_texture_transform does to it."""
    texcoord: int = 0
    offset: tuple = (0.0, 0.0)
    rotation_rad: float = 0.0
    scale: tuple = (1.0, 1.0)

    def apply(self, texcoords):
        """(n, 2) to (n, 2): scaled, then rotated, then moved."""
        x, y = texcoords[:, 0] * self.scale[0], texcoords[:, 1] * self.scale[1]
        c, s = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        return np.stack([c * x + s * y + self.offset[0], c * y - s * x + self.offset[1]], axis=1).astype(np.float32)


@dataclass
class Light:
    """A light of KHR_lights_punctual."""
    kind: str  # "point", "spot" or "directional"
    intensity: np.ndarray  # (3,), W/sr or, of a directional light, W/m^2, by channel
    position: np.ndarray  # (3,)
    direction: np.ndarray  # (3,), unit: where it shines
    inner_rad: float = 0.0  # of a spot: angles from its direction
    outer_rad: float = math.pi / 4.0


@dataclass
class Camera:
    to_world: np.ndarray  # (4, 4), looks along -z
    yfov_rad: float


@dataclass
class GltfScene:
    meshes: list = field(default_factory=list)
    lights: list = field(default_factory=list)
    camera: Camera | None = None


def read_scene(path, folder):
    """The default scene of a file. Embedded images are written to `folder`."""
    return Reader(Path(path), Path(folder)).read()


class Reader:
    def __init__(self, path, folder):
        self.path, self.folder = path, folder
        data = path.read_bytes()
        self.binary = b""
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            self.gltf = json.loads(data[20:20 + length])
            self.binary = data[20 + length + 8:]
        else:
            self.gltf = json.loads(data)
        if unread := set(self.gltf.get("extensionsRequired", [])) - READ:
            sys.exit(f"{path}: requires {', '.join(sorted(unread))}, which this reader does not have")
        self.materials = [self.material(entry) for entry in self.gltf.get("materials", [])]

    def read(self):
        scene = GltfScene()
        roots = self.gltf["scenes"][self.gltf.get("scene", 0)]["nodes"]
        self.add_nodes(roots, np.eye(4), scene)
        return scene

    def add_nodes(self, nodes, parent, scene):
        for index in nodes:
            node = self.gltf["nodes"][index]
            world = parent @ local_matrix(node)
            if "mesh" in node:
                worlds = [world @ instance for instance in self.instances(node)]
                for primitive in self.gltf["meshes"][node["mesh"]]["primitives"]:
                    if primitive.get("mode", 4) == 4:
                        scene.meshes.append(placed(self.mesh(primitive), worlds))
            if "camera" in node and scene.camera is None:
                perspective = self.gltf["cameras"][node["camera"]].get("perspective")
                if perspective is None:
                    sys.exit(f"{self.path}: its camera is not a perspective one")
                scene.camera = Camera(world, perspective["yfov"])
            if "KHR_lights_punctual" in node.get("extensions", {}):
                scene.lights.append(self.light(node["extensions"]["KHR_lights_punctual"]["light"], world))
            self.add_nodes(node.get("children", []), world, scene)

    def light(self, index, world):
        entry = self.gltf["extensions"]["KHR_lights_punctual"]["lights"][index]
        spot = entry.get("spot", {})
        direction = -world[:3, 2] / np.linalg.norm(world[:3, 2])
        return Light(entry["type"], entry.get("intensity", 1.0) * np.array(entry.get("color", [1.0] * 3)), world[:3, 3], direction,
                     spot.get("innerConeAngle", 0.0), spot.get("outerConeAngle", math.pi / 4.0))

    def instances(self, node):
        """Places of a node's mesh relative to the node: one, or those of EXT_mesh_gpu_instancing."""
        attributes = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        columns = {name: self.accessor(attributes[name.upper()]) for name in ("translation", "rotation", "scale") if name.upper() in attributes}
        if not columns:
            return [np.eye(4)]
        return [local_matrix(dict(zip(columns, values))) for values in zip(*columns.values())]

    def mesh(self, primitive):
        """In the space of its node."""
        attributes = primitive["attributes"]
        positions = self.accessor(attributes["POSITION"]).astype(np.float64)
        normals = self.accessor(attributes["NORMAL"]).astype(np.float64) if "NORMAL" in attributes else None
        triangles = self.accessor(primitive["indices"]).ravel() if "indices" in primitive else np.arange(len(positions))
        material = self.materials[primitive["material"]] if "material" in primitive else Material()
        place = material.texture_place or TexturePlace()
        texcoords = attributes.get(f"TEXCOORD_{place.texcoord}")
        if texcoords is not None:
            texcoords = place.apply(self.accessor(texcoords).astype(np.float32))
        return Mesh(positions, normals, texcoords, triangles.reshape(-1, 3).astype(np.int32), material)

    def accessor(self, index):
        accessor = self.gltf["accessors"][index]
        if "sparse" in accessor or "bufferView" not in accessor:
            sys.exit(f"{self.path}: accessor {index} is sparse, which this reader does not have")
        view = self.gltf["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        stride = view.get("byteStride", kind.itemsize * width)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        values = np.ndarray((accessor["count"], width), kind, self.buffer(view["buffer"]), start, (stride, kind.itemsize))
        if accessor.get("normalized"):
            return np.maximum(values.astype(np.float32) / np.iinfo(kind).max, -1.0)
        return values

    def buffer(self, index):
        uri = self.gltf["buffers"][index].get("uri")
        return self.binary if uri is None else self.bytes_of(uri)

    def bytes_of(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.path.parent / uri).read_bytes()

    def texture_place(self, name, slots):
        """The place that all textures of a material share."""
        places = set()
        for slot in filter(None, slots):
            moved = slot.get("extensions", {}).get("KHR_texture_transform", {})
            places.add(TexturePlace(moved.get("texCoord", slot.get("texCoord", 0)), tuple(moved.get("offset", (0.0, 0.0))),
                                    moved.get("rotation", 0.0), tuple(moved.get("scale", (1.0, 1.0)))))
        if len(places) > 1:
            sys.exit(f"{self.path}: material {name}: its textures lie in {len(places)} ways, and this reader has one for each material")
        return places.pop() if places else None

    def texture(self, slot):
        """The file of a texture's image; repeated."""
        if slot is None:
            return None
        image = self.gltf["images"][self.gltf["textures"][slot["index"]]["source"]]
        if "uri" in image and not image["uri"].startswith("data:"):
            return self.path.parent / image["uri"]
        if "uri" in image:
            data = self.bytes_of(image["uri"])
        else:
            view = self.gltf["bufferViews"][image["bufferView"]]
            start = view.get("byteOffset", 0)
            data = self.buffer(view["buffer"])[start:start + view["byteLength"]]
        number = self.gltf["images"].index(image)
        file = self.folder / f"image{number}{'.png' if data[:4] == bytes([137]) + b'PNG' else '.jpg'}"
        if not file.is_file():
            file.write_bytes(data)
        return file

    def material(self, entry):
        base = entry.get("pbrMetallicRoughness", {})
        extensions = entry.get("extensions", {})
        color = base.get("baseColorFactor", [1.0] * 4)
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        volume = extensions.get("KHR_materials_volume", {})
        transmission = extensions.get("KHR_materials_transmission", {})
        coat = extensions.get("KHR_materials_clearcoat", {})
        normal = entry.get("normalTexture")
        slots = [base.get("baseColorTexture"), base.get("metallicRoughnessTexture"), normal, entry.get("emissiveTexture"),
                 transmission.get("transmissionTexture")]
        return Material(
            name=entry.get("name", "material"), base_color=tuple(color[:3]), alpha=color[3],
            alpha_mode=entry.get("alphaMode", "OPAQUE"), alpha_cutoff=entry.get("alphaCutoff", 0.5),
            base_color_texture=self.texture(base.get("baseColorTexture")),
            metallic=base.get("metallicFactor", 1.0), roughness=base.get("roughnessFactor", 1.0),
            metallic_roughness_texture=self.texture(base.get("metallicRoughnessTexture")),
            normal_texture=self.texture(normal), normal_scale=normal.get("scale", 1.0) if normal else 1.0,
            emission=tuple(strength * value for value in entry.get("emissiveFactor", [0.0] * 3)),
            emission_texture=self.texture(entry.get("emissiveTexture")), double_sided=entry.get("doubleSided", False),
            specular=extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0),
            ior=float(extensions.get("KHR_materials_ior", {}).get("ior", 1.5)),
            transmission=transmission.get("transmissionFactor", 0.0),
            transmission_texture=self.texture(transmission.get("transmissionTexture")),
            clearcoat=coat.get("clearcoatFactor", 0.0), clearcoat_roughness=coat.get("clearcoatRoughnessFactor", 0.0),
            thickness=volume.get("thicknessFactor", 0.0), attenuation_color=tuple(volume.get("attenuationColor", [1.0] * 3)),
            attenuation_distance=volume.get("attenuationDistance", float("inf")),
            texture_place=self.texture_place(entry.get("name", "material"), slots))


def local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
    matrix[:3, :3] = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                               [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                               [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix[:3, :3] *= np.array(node.get("scale", [1.0, 1.0, 1.0]))
    matrix[:3, 3] = node.get("translation", [0.0, 0.0, 0.0])
    return matrix
