# SPDX-License-Identifier: Apache-2.0
"""Builds glTF 2.0 documents: accessors, meshes, materials, nodes; writes .gltf and .glb."""
import base64
import json
import struct

FLOAT, UBYTE, BYTE, USHORT, SHORT, UINT = 5126, 5121, 5120, 5123, 5122, 5125
_FORMAT = {FLOAT: "f", UBYTE: "B", BYTE: "b", USHORT: "H", SHORT: "h", UINT: "I"}
_COUNT = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
COPYRIGHT = "The Kindling authors. CC0 1.0."


class Exact(float):
    """A float32 whose decimals must give the same float32, as the bounds of an accessor."""


def rounded(value):
    """Short decimals, so that files are readable and the same everywhere."""
    if isinstance(value, Exact):
        stored = struct.pack("<f", value)
        short = next(float(text) for text in ("%.*g" % (digits, value) for digits in (7, 8, 9)) if struct.pack("<f", float(text)) == stored)
        return int(short) if short == int(short) and abs(short) < 1e9 else short
    if isinstance(value, float):
        short = float("%.7g" % value)
        return int(short) if short == int(short) and abs(short) < 1e9 else short
    if isinstance(value, (list, tuple)):
        return [rounded(v) for v in value]
    if isinstance(value, dict):
        return {key: rounded(v) for key, v in value.items()}
    return value


def without_residues(value):
    """0 for what rounding left of a 0: C libraries differ in it."""
    return 0.0 if 0.0 < abs(value) < 1e-12 else value


class Gltf:
    """One document with one buffer. Every add_... returns the index of the added element."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0", "generator": "Kindling scenes/generate.py", "copyright": COPYRIGHT}}
        self.bin = bytearray()

    def add(self, kind, item):
        self.json.setdefault(kind, []).append(item)
        return len(self.json[kind]) - 1

    def use(self, extension, required=False):
        for key in ["extensionsUsed"] + (["extensionsRequired"] if required else []):
            if extension not in self.json.setdefault(key, []):
                self.json[key].append(extension)

    def add_view(self, data, stride=None, target=None):
        self.bin.extend(b"\0" * (-len(self.bin) % 4))
        view = {"buffer": 0, "byteOffset": len(self.bin), "byteLength": len(data)}
        if stride:
            view["byteStride"] = stride
        if target:
            view["target"] = target
        self.bin.extend(data)
        return self.add("bufferViews", view)

    def add_accessor(self, rows, kind, component=FLOAT, normalized=False, bounds=False, target=None):
        """rows: numbers for SCALAR, tuples otherwise."""
        rows = [(row,) if kind == "SCALAR" else tuple(row) for row in rows]
        if component == FLOAT:
            rows = [tuple(map(without_residues, row)) for row in rows]
        fmt = "<%d%s" % (_COUNT[kind], _FORMAT[component])
        size = struct.calcsize(fmt)
        # Vertex attributes start at multiples of four.
        pad = -size % 4 if target == 34962 else 0
        data = b"".join(struct.pack(fmt, *row) + b"\0" * pad for row in rows)
        accessor = {
            "bufferView": self.add_view(data, size + pad if pad else None, target),
            "componentType": component,
            "count": len(rows),
            "type": kind,
        }
        if normalized:
            accessor["normalized"] = True
        if bounds:
            stored = [struct.unpack(fmt, struct.pack(fmt, *row)) for row in rows]
            exact = Exact if component == FLOAT else int
            accessor["min"] = [exact(min(column)) for column in zip(*stored)]
            accessor["max"] = [exact(max(column)) for column in zip(*stored)]
        return self.add("accessors", accessor)

    def add_attributes(self, mesh):
        """Positions, normals, texture coordinates and colors of a shapes.Mesh."""
        attributes = {"POSITION": self.add_accessor(mesh.positions, "VEC3", bounds=True, target=34962)}
        if mesh.normals:
            attributes["NORMAL"] = self.add_accessor(mesh.normals, "VEC3", target=34962)
        if mesh.uvs:
            attributes["TEXCOORD_0"] = self.add_accessor(mesh.uvs, "VEC2", target=34962)
        if mesh.colors:
            attributes["COLOR_0"] = self.add_accessor(mesh.colors, "VEC3", target=34962)
        return attributes

    def add_primitive(self, mesh, material=None):
        component = USHORT if len(mesh.positions) <= 65535 else UINT
        primitive = {
            "attributes": self.add_attributes(mesh),
            "indices": self.add_accessor(mesh.indices, "SCALAR", component, target=34963),
        }
        if material is not None:
            primitive["material"] = material
        return primitive

    def add_mesh(self, name, parts):
        """parts: (shapes.Mesh, material index) pairs."""
        return self.add("meshes", {"name": name, "primitives": [self.add_primitive(m, mat) for m, mat in parts]})

    def add_node(self, name, children=None, **fields):
        node = {"name": name, **{key: value for key, value in fields.items() if value is not None}}
        if children:
            node["children"] = children
        return self.add("nodes", node)

    def add_image(self, name, png):
        return self.add("images", {"name": name, "mimeType": "image/png", "bufferView": self.add_view(png)})

    def add_texture(self, name, png, wrap=10497, nearest=False):
        sampler = {"wrapS": wrap, "wrapT": wrap, "magFilter": 9728 if nearest else 9729, "minFilter": 9728 if nearest else 9729}
        samplers = self.json.setdefault("samplers", [])
        if sampler not in samplers:
            samplers.append(sampler)
        return self.add("textures", {"sampler": samplers.index(sampler), "source": self.add_image(name, png)})

    def add_material(self, name, color=(1, 1, 1), metallic=0.0, roughness=1.0, emission=None, diffuse_only=False, **fields):
        """color: linear RGB or RGBA, or a texture index. emission: linear RGB radiance of any strength."""
        pbr = {"metallicFactor": metallic, "roughnessFactor": roughness}
        if isinstance(color, int):
            pbr["baseColorTexture"] = {"index": color}
        else:
            pbr["baseColorFactor"] = list(color) + [1.0] * (4 - len(color))
        pbr.update(fields.pop("pbr", {}))
        material = {"name": name, "pbrMetallicRoughness": pbr}
        if emission is not None:
            strength = max(emission)
            material["emissiveFactor"] = [e / strength for e in emission]
            if strength != 1.0:
                material.setdefault("extensions", {})["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
                self.use("KHR_materials_emissive_strength")
        if diffuse_only:
            material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0.0}
            self.use("KHR_materials_specular")
        material.update(fields)
        return self.add("materials", material)

    def add_light(self, name, kind, color, intensity, **fields):
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({"name": name, "type": kind, "color": list(color), "intensity": intensity, **fields})
        self.use("KHR_lights_punctual")
        return {"KHR_lights_punctual": {"light": len(lights) - 1}}

    def add_camera_node(self, name, eye, target, yfov=None, aspect=16 / 9, **orthographic):
        if yfov is not None:
            camera = {"type": "perspective", "name": name,
                      "perspective": {"yfov": yfov, "aspectRatio": aspect, "znear": 0.01}}
        else:
            camera = {"type": "orthographic", "name": name, "orthographic": orthographic}
        return self.add_node(name, camera=self.add("cameras", camera), translation=list(eye), rotation=look_at(eye, target))

    def finish(self, roots, scene_name="scene"):
        self.json["scenes"] = [{"name": scene_name, "nodes": roots}]
        self.json["scene"] = 0
        return self

    def document(self, uri=None):
        out = dict(self.json)
        if self.bin:
            out["buffers"] = [{"byteLength": len(self.bin)}]
            if uri is not None:
                out["buffers"][0]["uri"] = uri
        order = ["asset", "extensionsUsed", "extensionsRequired", "extensions", "scene", "scenes", "nodes", "cameras", "meshes",
                 "skins", "animations", "materials", "textures", "images", "samplers", "accessors", "bufferViews", "buffers"]
        return rounded({key: out[key] for key in order if key in out})

    def to_gltf(self):
        """The document as .gltf text with an embedded buffer."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.bin)).decode()
        return dump(self.document(uri)).encode()

    def to_glb(self):
        self.bin.extend(b"\0" * (-len(self.bin) % 4))
        text = json.dumps(self.document(), separators=(",", ":"), ensure_ascii=False).encode()
        return glb([(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", bytes(self.bin))])


def glb(chunks, version=2, length=None):
    body = b"".join(struct.pack("<I", len(data)) + kind + data for kind, data in chunks)
    return b"glTF" + struct.pack("<II", version, len(body) + 12 if length is None else length) + body


def dump(value, indent=0, width=118):
    """Readable JSON: values that fit on a line stay on one."""
    flat = json.dumps(value, ensure_ascii=False)
    if len(flat) + indent <= width or not isinstance(value, (dict, list)) or not value:
        return flat + ("\n" if indent == 0 else "")
    pad = " " * (indent + 2)
    if isinstance(value, dict):
        items = [pad + json.dumps(k, ensure_ascii=False) + ": " + dump(v, indent + 2).strip() for k, v in value.items()]
        text = "{\n" + ",\n".join(items) + "\n" + " " * indent + "}"
    else:
        items = [pad + dump(v, indent + 2).strip() for v in value]
        text = "[\n" + ",\n".join(items) + "\n" + " " * indent + "]"
    return text + ("\n" if indent == 0 else "")


def look_at(eye, target, up=(0.0, 1.0, 0.0)):
    """Quaternion (x, y, z, w) that rotates -z towards the target; cameras and lights look along -z."""
    z = normalize(subtract(eye, target))
    if abs(dot(z, up)) > 0.9999:
        up = (0.0, 0.0, -1.0)
    x = normalize(cross(up, z))
    y = cross(z, x)
    # x, y and z are the rows of the rotation matrix's transpose.
    trace = x[0] + y[1] + z[2]
    if trace > 0:
        s = 2.0 * (trace + 1.0) ** 0.5
        q = [(y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s, s / 4]
    elif x[0] >= y[1] and x[0] >= z[2]:
        s = 2.0 * (1.0 + x[0] - y[1] - z[2]) ** 0.5
        q = [s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s, (y[2] - z[1]) / s]
    elif y[1] >= z[2]:
        s = 2.0 * (1.0 + y[1] - x[0] - z[2]) ** 0.5
        q = [(y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s, (z[0] - x[2]) / s]
    else:
        s = 2.0 * (1.0 + z[2] - x[0] - y[1]) ** 0.5
        q = [(z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4, (x[1] - y[0]) / s]
    return q


def subtract(a, b):
    return tuple(p - q for p, q in zip(a, b))


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a):
    length = dot(a, a) ** 0.5
    return tuple(p / length for p in a) if length > 0 else (0.0, 1.0, 0.0)
