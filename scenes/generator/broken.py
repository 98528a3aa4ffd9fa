# SPDX-License-Identifier: Apache-2.0
"""Files with one fault each, and the outcome that a reader must report (expected.json)."""
import base64
import json
import struct
import zlib

from .gltf import COPYRIGHT, FLOAT, UBYTE, Gltf, dump, glb


def _triangle():
    """A valid file as a dictionary, the base of each broken one."""
    g = Gltf()
    g.json["asset"] = {"version": "2.0", "copyright": COPYRIGHT}
    attributes = {"POSITION": g.add_accessor([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "VEC3", bounds=True)}
    indices = g.add_accessor([0, 1, 2], "SCALAR", UBYTE)
    g.add("meshes", {"primitives": [{"attributes": attributes, "indices": indices}]})
    g.finish([g.add_node("node", mesh=0)])
    return g


def _document(g):
    return g.document("data:application/octet-stream;base64," + base64.b64encode(bytes(g.bin)).decode())


CASES = []


def case(pointer, reason, outcome="error"):
    """pointer: start of the JSON pointer in the message ("" if there is none). outcome: "error", "warning" (loads with a
    warning), or "any": unusual but valid; must not crash."""
    def register(make):
        CASES.append((make, pointer, reason, outcome))
        return make

    return register


@case("/meshes/0/primitives/0/indices", "an index is 7, but there are 3 vertices")
def index_out_of_range():
    g = _triangle()
    g.bin[36:39] = bytes([0, 1, 7])
    return _document(g)


@case("/meshes/0/primitives/0/attributes/POSITION", "there is no accessor 9")
def accessor_does_not_exist():
    d = _document(_triangle())
    d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9
    return d


@case("/accessors/0", "300 positions do not fit into a view of 36 bytes")
def accessor_beyond_its_view():
    d = _document(_triangle())
    d["accessors"][0]["count"] = 300
    return d


@case("/accessors/0", "a count that would ask for 48 GB")
def accessor_of_absurd_size():
    d = _document(_triangle())
    d["accessors"][0]["count"] = 4000000000
    return d


@case("/accessors/0/componentType", "5130 (double) is not a component type of glTF")
def accessor_of_unknown_type():
    d = _document(_triangle())
    d["accessors"][0]["componentType"] = 5130
    return d


@case("/accessors/0/sparse", "a sparse index of 200 in an accessor of 3")
def sparse_index_out_of_range():
    g = _triangle()
    where = g.add_view(struct.pack("<2B", 1, 200))
    what = g.add_view(struct.pack("<6f", *[0.5] * 6))
    g.json["accessors"][0]["sparse"] = {"count": 2, "indices": {"bufferView": where, "componentType": UBYTE},
                                        "values": {"bufferView": what}}
    return _document(g)


@case("/bufferViews/0", "the view ends at byte 1036 of a buffer of 39")
def view_beyond_its_buffer():
    d = _document(_triangle())
    d["bufferViews"][0]["byteOffset"] = 1000
    return d


@case("/buffers/0", "the buffer says 100 bytes, its data are 39")
def buffer_shorter_than_it_says():
    d = _document(_triangle())
    d["buffers"][0]["byteLength"] = 100
    return d


@case("/buffers/0/uri", "the file does not exist")
def buffer_missing():
    d = _document(_triangle())
    d["buffers"][0]["uri"] = "no_such_file.bin"
    return d


@case("/buffers/0/uri", "a path that leaves the folder of the file")
def path_leaves_the_folder():
    d = _document(_triangle())
    d["buffers"][0]["uri"] = "../../../../../etc/hostname"
    return d


@case("/buffers/0/uri", "the same, percent-encoded")
def path_leaves_the_folder_encoded():
    d = _document(_triangle())
    d["buffers"][0]["uri"] = "%2e%2e%2f%2e%2e%2fetc%2fhostname"
    return d


@case("/buffers/0/uri", "an absolute path")
def path_is_absolute():
    d = _document(_triangle())
    d["buffers"][0]["uri"] = "/etc/hostname"
    return d


@case("/buffers/0/uri", "a network address")
def path_is_on_the_network():
    d = _document(_triangle())
    d["buffers"][0]["uri"] = "https://example.com/triangle.bin"
    return d


@case("/nodes", "node 0 is below node 1, which is below node 0")
def cycle_in_nodes():
    d = _document(_triangle())
    d["nodes"] = [{"children": [1]}, {"children": [0], "mesh": 0}]
    return d


@case("/nodes", "node 2 has two parents")
def node_with_two_parents():
    d = _document(_triangle())
    d["nodes"] = [{"children": [2]}, {"children": [2]}, {"mesh": 0}]
    d["scenes"][0]["nodes"] = [0, 1]
    return d


@case("/meshes/0/primitives/0/attributes/POSITION", "a position is not a number")
def position_is_nan():
    g = _triangle()
    g.bin[12:16] = struct.pack("<f", float("nan"))
    d = _document(g)
    return d


@case("/nodes/0/matrix", "a matrix of 15 numbers")
def matrix_too_short():
    d = _document(_triangle())
    d["nodes"][0]["matrix"] = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0]
    return d


@case("/nodes/0/rotation", "a quaternion of length 0")
def rotation_is_zero():
    d = _document(_triangle())
    d["nodes"][0]["rotation"] = [0, 0, 0, 0]
    return d


@case("/scenes/0/nodes/0", "there is no node 5")
def scene_names_missing_node():
    d = _document(_triangle())
    d["scenes"][0]["nodes"] = [5]
    return d


@case("/extensionsRequired", "an extension that no reader knows")
def extension_unknown_but_required():
    d = _document(_triangle())
    d["extensionsUsed"] = d["extensionsRequired"] = ["EXAMPLE_teapot_shading"]
    return d


@case("/asset/version", "a file of glTF 3.0")
def version_of_the_future():
    d = _document(_triangle())
    d["asset"] = {"version": "3.0", "minVersion": "3.0"}
    return d


@case("/materials/0/pbrMetallicRoughness/baseColorTexture/index", "there is no texture 3")
def material_names_missing_texture():
    d = _document(_triangle())
    d["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 3}}}]
    d["meshes"][0]["primitives"][0]["material"] = 0
    return d


@case("/cameras/0/perspective", "a field of view that is negative")
def camera_without_view():
    d = _document(_triangle())
    d["cameras"] = [{"type": "perspective", "perspective": {"yfov": -1.0, "znear": 0.1}}]
    d["nodes"].append({"camera": 0})
    d["scenes"][0]["nodes"] = [0, 1]
    return d


@case("/animations/0/samplers/0", "key times that run backwards")
def animation_runs_backwards():
    g = _triangle()
    times = g.add_accessor([1.0, 0.5], "SCALAR", bounds=True)
    values = g.add_accessor([(0, 0, 0), (0, 1, 0)], "VEC3")
    g.add("animations", {"samplers": [{"input": times, "output": values}],
                         "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]})
    return _document(g)


@case("/skins/0/joints/1", "there is no node 8")
def skin_names_missing_joint():
    g = _triangle()
    attributes = g.json["meshes"][0]["primitives"][0]["attributes"]
    attributes["JOINTS_0"] = g.add_accessor([(0, 0, 0, 0)] * 3, "VEC4", UBYTE)
    attributes["WEIGHTS_0"] = g.add_accessor([(1, 0, 0, 0)] * 3, "VEC4", FLOAT)
    g.add("skins", {"joints": [0, 8]})
    g.json["nodes"][0]["skin"] = 0
    return _document(g)


def _with_image(image_bytes):
    g = _triangle()
    attributes = g.json["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_0"] = g.add_accessor([(0, 0), (1, 0), (0, 1)], "VEC2", FLOAT)
    material = g.add_material("textured", g.add_texture("picture", image_bytes))
    g.json["meshes"][0]["primitives"][0]["material"] = material
    return _document(g)


@case("/images/0", "a PNG that ends in its header", outcome="warning")
def image_truncated():
    return _with_image(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x08")


@case("/images/0", "a format that is not read, though it says image/png", outcome="warning")
def image_of_another_format():
    return _with_image(b"GIF89a\x01\0\x01\0\0\0\0;")


@case("/images/0", "a PNG of 2 000 000 000 x 2 000 000 000 pixels", outcome="warning")
def image_of_absurd_size():
    header = struct.pack(">IIBBBBB", 2000000000, 2000000000, 8, 2, 0, 0, 0)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return _with_image(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b""))


@case("", "text that stops in the middle")
def json_cut_off():
    text = dump(_document(_triangle()))
    return text[: len(text) // 2].encode()


@case("", "no glTF at all")
def json_of_something_else():
    return b'{"name": "a package", "version": "1.0.0"}\n'


@case("", "lists within lists, 20 000 deep", outcome="any")
def json_nested_too_deep():
    return b'{"asset":{"version":"2.0"},"extras":' + b"[" * 20000 + b"]" * 20000 + b"}"


def _with_graph(required, nodes, **graph):
    """The triangle with a procedural texture of these nodes; its output is the last one."""
    g = _triangle()
    g.use("KHR_texture_procedurals", required)
    out = {"name": "out", "nodetype": "output", "type": "color3", "node": len(nodes) - 1}
    g.json["extensions"] = {"KHR_texture_procedurals": {"procedurals": [
        {"nodetype": "nodegraph", "type": "color3", "nodes": nodes, "outputs": [out], **graph}]}}
    slot = {"index": g.add("textures", {}), "extensions": {"KHR_texture_procedurals": {"index": 0}}}
    g.add("materials", {"pbrMetallicRoughness": {"baseColorTexture": slot}})
    g.json["meshes"][0]["primitives"][0]["material"] = 0
    return _document(g)


def _add_node(first, second):
    return {"nodetype": "add", "type": "color3", "inputs": [
        {"name": "in1", "nodetype": "input", "type": "color3", **first},
        {"name": "in2", "nodetype": "input", "type": "color3", **second}]}


_GRAPH = "/extensions/KHR_texture_procedurals/procedurals/0"


@case(_GRAPH + "/nodes/0: its inputs depend on its own output", "two nodes of a required procedural texture read each other")
def procedural_cycle():
    black = {"value": [0, 0, 0]}
    return _with_graph(True, [_add_node({"node": 1}, black), _add_node({"node": 0}, black)])


@case(_GRAPH + "/nodes/0/nodetype: 'perlin_wood'", "a procedural texture with a node that MaterialX has not", "warning")
def procedural_of_unknown_node():
    return _with_graph(False, [{"nodetype": "perlin_wood", "type": "color3"}])


@case(_GRAPH + "/nodes/1/inputs/0/type", "a procedural texture in which a colour is read as a vector")
def procedural_of_wrong_type():
    return _with_graph(True, [{"nodetype": "constant", "type": "color3"},
                              {"nodetype": "add", "type": "color3",
                               "inputs": [{"name": "in1", "nodetype": "input", "type": "vector3", "node": 0}]}])


@case(_GRAPH + "/nodes", "a procedural texture of 257 nodes")
def procedural_too_large():
    return _with_graph(True, [{"nodetype": "constant", "type": "color3"}] * 257)


@case(_GRAPH + "/nodes/0/inputs/0/node", "a procedural texture that reads a node that is none")
def procedural_names_missing_node():
    return _with_graph(True, [_add_node({"node": 7}, {"value": [0, 0, 0]})])


@case("/materials/0: KHR_texture_procedurals index 3", "a procedural texture that is none", "warning")
def procedural_missing():
    d = _with_graph(False, [{"nodetype": "constant", "type": "color3"}])
    d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_procedurals"]["index"] = 3
    return d


def _glb_parts():
    g = _triangle()
    g.bin.extend(b"\0" * (-len(g.bin) % 4))
    text = json.dumps(g.document(), separators=(",", ":")).encode()
    return text + b" " * (-len(text) % 4), bytes(g.bin)


@case("", "the header says more bytes than the file has")
def glb_cut_off():
    text, data = _glb_parts()
    return glb([(b"JSON", text), (b"BIN\0", data)])[:-20]


@case("", "a chunk that reaches beyond the end of the file")
def glb_chunk_too_long():
    text, data = _glb_parts()
    whole = bytearray(glb([(b"JSON", text), (b"BIN\0", data)]))
    whole[20 + len(text):24 + len(text)] = struct.pack("<I", 0x7FFFFFF0)
    return bytes(whole)


@case("", "the first chunk is not JSON")
def glb_without_json():
    _, data = _glb_parts()
    return glb([(b"BIN\0", data)])


@case("", "a container of version 1")
def glb_of_version_1():
    text, data = _glb_parts()
    return glb([(b"JSON", text), (b"BIN\0", data)], version=1)


@case("/buffers/0", "a buffer without URI, but no binary chunk")
def glb_without_binary_chunk():
    text, _ = _glb_parts()
    return glb([(b"JSON", text)])


@case("", "nothing")
def empty_file():
    return b""


def build():
    files, expected = {}, {}
    for make, pointer, reason, outcome in CASES:
        made = make()
        name = make.__name__ + (".glb" if make.__name__.startswith("glb_") else ".gltf")
        files["broken/" + name] = dump(made).encode() if isinstance(made, dict) else made
        expected[name] = {"what": reason, "outcome": outcome, "pointer": pointer}
    files["broken/expected.json"] = dump(expected, width=170).encode()
    return files
