# SPDX-License-Identifier: Apache-2.0
"""One small, readable glTF for each feature of the format."""
import math
import struct

from . import images, procedurals
from .gltf import BYTE, FLOAT, SHORT, UBYTE, USHORT, Gltf, dump
from .shapes import Mesh, box, quad, sphere


def _leaf_picture(alpha):
    """An 8 x 8 checker; with alpha from 0 on the left to 1 on the right if requested."""
    def pixel(x, y):
        color = (0.85, 0.35, 0.20) if (x + y) % 2 else (0.95, 0.85, 0.60)
        return color + (((x + 0.5) / 8,) if alpha else ())

    return images.paint(8, 8, 4 if alpha else 3, pixel)


def _checker_texture(g, alpha=False, nearest=True):
    return g.add_texture("checker", _leaf_picture(alpha), nearest=nearest)


def _cube(size=0.5):
    return box((-size, -size, -size), (size, size, size)).without_uvs()


def _single(g, primitive, name, **node_fields):
    mesh = g.add("meshes", {"name": name, "primitives": [primitive]})
    return g.finish([g.add_node(name, mesh=mesh, **node_fields)], name).to_gltf()


def triangle_strip():
    g = Gltf()
    ribbon = [(0.5 * (i // 2), 0.3 * math.sin(i // 2), 1.0 - i % 2) for i in range(12)]
    attributes = {"POSITION": g.add_accessor(ribbon, "VEC3", bounds=True)}
    return _single(g, {"attributes": attributes, "mode": 5}, "strip")


def triangle_fan():
    g = Gltf()
    rim = [(math.cos(a * math.pi / 4), math.sin(a * math.pi / 4), 0.0) for a in range(8)]
    attributes = {"POSITION": g.add_accessor([(0.0, 0.0, 0.3)] + rim, "VEC3", bounds=True)}
    indices = g.add_accessor([0, 1, 2, 3, 4, 5, 6, 7, 8, 1], "SCALAR", UBYTE)
    return _single(g, {"attributes": attributes, "indices": indices, "mode": 6}, "fan")


def non_indexed():
    g = Gltf()
    apex, base = (0.0, 1.0, 0.0), [(0.7, 0.0, 0.7), (0.7, 0.0, -0.7), (-0.7, 0.0, -0.7), (-0.7, 0.0, 0.7)]
    positions = [p for i in range(4) for p in (base[i], base[(i + 1) % 4], apex)]
    attributes = {"POSITION": g.add_accessor(positions, "VEC3", bounds=True)}
    return _single(g, {"attributes": attributes}, "pyramid without normals")


def sparse():
    """A flat 4 x 4 grid from one view; the sparse part raises two vertices. A second accessor has no view."""
    g = Gltf()
    grid = [(i % 4, 0.0, i // 4) for i in range(16)]
    positions = g.add_accessor(grid, "VEC3", bounds=True)
    lifted = {5: (1.0, 0.8, 1.0), 10: (2.0, 0.4, 2.0)}
    where = g.add_view(struct.pack("<2B", *lifted))
    what = g.add_view(b"".join(struct.pack("<3f", *p) for p in lifted.values()))
    g.json["accessors"][positions]["sparse"] = {"count": 2, "indices": {"bufferView": where, "componentType": UBYTE},
                                                "values": {"bufferView": what}}
    g.json["accessors"][positions]["max"] = [3, 0.8, 3]
    zeros = g.add("accessors", {"componentType": FLOAT, "count": 16, "type": "VEC2"})
    quads = [(r * 4 + c, r * 4 + c + 4, r * 4 + c + 5, r * 4 + c + 1) for r in range(3) for c in range(3)]
    indices = g.add_accessor([i for a, b, c, d in quads for i in (a, b, c, a, c, d)], "SCALAR", UBYTE)
    return _single(g, {"attributes": {"POSITION": positions, "TEXCOORD_0": zeros}, "indices": indices}, "sparse")


def interleaved():
    """Interleaved positions, normals and colors: one view with a stride of 28 bytes."""
    g = Gltf()
    mesh = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    colors = [(255, 60, 30, 255), (40, 200, 60, 255), (40, 90, 255, 255), (250, 220, 60, 255)]
    data = b"".join(struct.pack("<6f4B", *p, *n, *c) for p, n, c in zip(mesh.positions, mesh.normals, colors))
    view = g.add_view(data, 28, 34962)
    accessor = lambda offset, kind, component, **more: g.add(
        "accessors", {"bufferView": view, "byteOffset": offset, "componentType": component, "count": 4, "type": kind, **more})
    attributes = {"POSITION": accessor(0, "VEC3", FLOAT, min=[-1, -1, 0], max=[1, 1, 0]), "NORMAL": accessor(12, "VEC3", FLOAT),
                  "COLOR_0": accessor(24, "VEC4", UBYTE, normalized=True)}
    return _single(g, {"attributes": attributes, "indices": g.add_accessor(mesh.indices, "SCALAR", USHORT)}, "interleaved")


def vertex_colors():
    """COLOR_0 as normalized shorts, linear; multiplied by the material's color."""
    g = Gltf()
    mesh = _cube()
    colors = [tuple(int(65535 * (0.5 + c)) for c in p) for p in mesh.positions]
    primitive = g.add_primitive(mesh, g.add_material("white"))
    primitive["attributes"]["COLOR_0"] = g.add_accessor(colors, "VEC3", USHORT, normalized=True, target=34962)
    return _single(g, primitive, "colour cube")


def morph_targets():
    """Two targets, weighted by the mesh; an animation moves the weights from there to (1, 0) and to (0, 1)."""
    g = Gltf()
    mesh = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    primitive = g.add_primitive(Mesh(mesh.positions, (), (), mesh.indices))
    wide = g.add_accessor([(-0.5, 0, 0), (0.5, 0, 0), (0.5, 0, 0), (-0.5, 0, 0)], "VEC3", bounds=True)
    bent = g.add_accessor([(0, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, 1)], "VEC3", bounds=True)
    primitive["targets"] = [{"POSITION": wide}, {"POSITION": bent}]
    node = g.add_node("morph", mesh=g.add("meshes", {"primitives": [primitive], "weights": [0.25, 0.5]}))
    times = g.add_accessor([0.0, 1.0, 2.0], "SCALAR", bounds=True)
    values = g.add_accessor([0.25, 0.5, 1.0, 0.0, 0.0, 1.0], "SCALAR")
    g.add("animations", {"name": "weights", "samplers": [{"input": times, "output": values, "interpolation": "LINEAR"}],
                         "channels": [{"sampler": 0, "target": {"node": node, "path": "weights"}}]})
    return g.finish([node], "morph").to_gltf()


def skin():
    """A bar of five cross-sections on two bones; the upper bone leans by 60 degrees."""
    g = Gltf()
    sections = [(y / 2.0, max(0.0, min(1.0, y / 2.0 - 0.5))) for y in range(5)]
    corners = [(-0.2, 0.2), (0.2, 0.2), (0.2, -0.2), (-0.2, -0.2)]
    positions = [(x, y, z) for y, _ in sections for x, z in corners]
    weights = [(1.0 - w, w, 0.0, 0.0) for _, w in sections for _ in corners]
    indices = [i for s in range(4) for c in range(4)
               for i in (4 * s + c, 4 * s + (c + 1) % 4, 4 * s + 4 + (c + 1) % 4,
                         4 * s + c, 4 * s + 4 + (c + 1) % 4, 4 * s + 4 + c)]
    primitive = {
        "attributes": {
            "POSITION": g.add_accessor(positions, "VEC3", bounds=True),
            "JOINTS_0": g.add_accessor([(0, 1, 0, 0)] * len(positions), "VEC4", UBYTE),
            "WEIGHTS_0": g.add_accessor(weights, "VEC4"),
        },
        "indices": g.add_accessor(indices, "SCALAR", UBYTE),
    }
    upper = g.add_node("upper bone", translation=[0, 1, 0], rotation=[0, 0, math.sin(-math.pi / 6), math.cos(-math.pi / 6)])
    lower = g.add_node("lower bone", [upper])
    identity = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
    lowered = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1)
    inverse = g.add_accessor([identity, lowered], "MAT4")
    g.add("skins", {"joints": [lower, upper], "inverseBindMatrices": inverse, "skeleton": lower})
    bar = g.add_node("bar", mesh=g.add("meshes", {"primitives": [primitive]}), skin=0)
    return g.finish([bar, lower], "skin").to_gltf()


def animation():
    """Four cubes moved by STEP, LINEAR and CUBICSPLINE, and rotated; try --time 0.25, 0.5, 1.5."""
    g = Gltf()
    mesh = g.add("meshes", {"primitives": [g.add_primitive(_cube(0.3))]})
    nodes = [g.add_node(name, mesh=mesh, translation=[i - 1.5, 0, 0]) for i, name in enumerate(["step", "linear", "cubic", "turning"])]
    times = g.add_accessor([0.0, 1.0, 2.0], "SCALAR", bounds=True)
    keys = lambda x: [(x, 0, 0), (x, 1, 0), (x, 0, 0)]
    cubic = [v for p in keys(0.5) for v in ((0, 2, 0), p, (0, 2, 0))]
    turns = [(0, 0, 0, 1), (0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4)), (0, 1, 0, 0)]
    outputs = [g.add_accessor(keys(-1.5), "VEC3"), g.add_accessor(keys(-0.5), "VEC3"), g.add_accessor(cubic, "VEC3"),
               g.add_accessor(turns, "VEC4")]
    ways = ["STEP", "LINEAR", "CUBICSPLINE", "LINEAR"]
    g.add("animations", {
        "name": "up and down",
        "samplers": [{"input": times, "output": o, "interpolation": w} for o, w in zip(outputs, ways)],
        "channels": [{"sampler": i, "target": {"node": n, "path": "rotation" if i == 3 else "translation"}}
                     for i, n in enumerate(nodes)],
    })
    return g.finish(nodes, "animation").to_gltf()


def texture_transform():
    """The same quad and image, plain and with offset, rotation and scale of KHR_texture_transform."""
    g = Gltf()
    g.use("KHR_texture_transform")
    texture = _checker_texture(g)
    shared = g.add_primitive(quad((-0.45, -0.45, 0), (0.9, 0, 0), (0, 0.9, 0)))
    transforms = [None, {"offset": [0.5, 0.25]}, {"rotation": math.radians(30)}, {"scale": [2, 0.5]},
                  {"offset": [0.1, 0.2], "rotation": math.radians(45), "scale": [0.5, 0.5]}]
    nodes = []
    for i, transform in enumerate(transforms):
        reference = {"index": texture}
        if transform:
            reference["extensions"] = {"KHR_texture_transform": transform}
        material = g.add("materials", {"pbrMetallicRoughness": {"baseColorTexture": reference, "metallicFactor": 0}})
        nodes.append(g.add_node("quad %d" % i, mesh=g.add("meshes", {"primitives": [{**shared, "material": material}]}),
                                translation=[i - 2, 0, 0]))
    return g.finish(nodes, "texture transform").to_gltf()


def _lit(kind, intensity, position, rotation, **fields):
    g = Gltf()
    floor = g.add_mesh("floor", [(quad((-3, 0, 3), (6, 0, 0), (0, 0, -6)).without_uvs(), g.add_material("white", (0.8, 0.8, 0.8)))])
    block = g.add_mesh("block", [(_cube(0.4), g.add_material("red", (0.7, 0.1, 0.05)))])
    light = g.add_light(kind, kind, (1.0, 0.9, 0.75), intensity, **fields)
    roots = [g.add_node("floor", mesh=floor), g.add_node("block", mesh=block, translation=[0, 0.4, 0]),
             g.add_node("light", translation=position, rotation=rotation, extensions=light),
             g.add_camera_node("camera", (0, 3, 6), (0, 0.3, 0), 0.7, 1.5)]
    return g.finish(roots, kind).to_gltf()


def light_point():
    return _lit("point", 30.0, [1.5, 2.0, 1.0], None, range=8.0)


def light_spot():
    down = [math.sin(-math.pi / 4), 0, 0, math.cos(-math.pi / 4)]  # the light's axis is -z; a quarter turn about x maps it to -y
    return _lit("spot", 60.0, [0.6, 3.0, 0.4], down, spot={"innerConeAngle": 0.25, "outerConeAngle": 0.5})


def light_directional():
    tilted = [math.sin(math.radians(-25)), 0, 0, math.cos(math.radians(-25))]
    return _lit("directional", 3.0, None, tilted)


def unlit():
    g = Gltf()
    g.use("KHR_materials_unlit")
    texture = _checker_texture(g)
    material = g.add_material("unlit", texture, extensions={"KHR_materials_unlit": {}})
    return _single(g, g.add_primitive(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), material), "unlit")


def alpha_modes():
    """One image whose alpha increases to the right: OPAQUE ignores it, MASK cuts at 0.3 and at the default 0.5, BLEND mixes."""
    g = Gltf()
    texture = _checker_texture(g, alpha=True, nearest=False)
    shared = g.add_primitive(quad((-0.45, -0.45, 0), (0.9, 0, 0), (0, 0.9, 0)))
    modes = [{}, {"alphaMode": "MASK", "alphaCutoff": 0.3}, {"alphaMode": "MASK"}, {"alphaMode": "BLEND"}]
    nodes = []
    for i, mode in enumerate(modes):
        material = g.add_material(mode.get("alphaMode", "OPAQUE"), texture, doubleSided=True, **mode)
        mesh = g.add("meshes", {"primitives": [{**shared, "material": material}]})
        nodes.append(g.add_node("quad %d" % i, mesh=mesh, translation=[i - 1.5, 0, 0]))
    wall = g.add_mesh("wall", [(quad((-2.2, -0.7, -0.5), (4.4, 0, 0), (0, 1.4, 0)).without_uvs(), g.add_material("blue", (0.1, 0.2, 0.6)))])
    return g.finish(nodes + [g.add_node("wall", mesh=wall)], "alpha modes").to_gltf()


def orthographic_camera():
    g = Gltf()
    mesh = g.add("meshes", {"primitives": [g.add_primitive(_cube())]})
    cubes = [g.add_node("cube %d" % i, mesh=mesh, translation=[1.5 * i - 1.5, 0, -4.0 * i]) for i in range(3)]
    camera = g.add_camera_node("camera", (0, 4, 8), (0, 0, -4), xmag=3.0, ymag=2.0, znear=0.1, zfar=50.0)
    return g.finish(cubes + [camera], "equal sizes").to_gltf()


def negative_scale():
    """The right one is the left one mirrored: its winding is reversed, its front is not."""
    g = Gltf()
    mesh = g.add_mesh("letter", [(box((-0.5, -0.5, -0.1), (-0.3, 0.5, 0.1)).append(box((-0.3, -0.5, -0.1), (0.3, -0.3, 0.1))).without_uvs(),
                                  g.add_material("red", (0.7, 0.1, 0.05)))])
    nodes = [g.add_node("as is", mesh=mesh, translation=[-0.8, 0, 0]),
             g.add_node("mirrored", mesh=mesh, translation=[0.8, 0, 0], scale=[-1, 1, 1])]
    return g.finish(nodes, "mirror").to_gltf()


def several_scenes():
    """Two scenes, two cameras in the first; the second scene is the default."""
    g = Gltf()
    mesh = g.add("meshes", {"primitives": [g.add_primitive(_cube())]})
    one = [g.add_node("cube", mesh=mesh), g.add_camera_node("near", (2, 2, 3), (0, 0, 0), 0.8),
           g.add_camera_node("far", (6, 6, 9), (0, 0, 0), 0.4)]
    parent = g.add_node("matrix", mesh=mesh, matrix=[1, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1],
                        children=[g.add_node("child", mesh=mesh, translation=[0, 2, 0])])
    g.finish(one, "one cube")
    g.json["scenes"].append({"name": "two cubes", "nodes": [parent]})
    g.json["scene"] = 1
    return g.to_gltf()


def node_visibility():
    """The middle node and its child are hidden by KHR_node_visibility."""
    g = Gltf()
    g.use("KHR_node_visibility")
    mesh = g.add("meshes", {"primitives": [g.add_primitive(_cube(0.4))]})
    hidden = g.add_node("hidden", [g.add_node("below hidden", mesh=mesh, translation=[0, 1, 0])], mesh=mesh,
                        extensions={"KHR_node_visibility": {"visible": False}})
    nodes = [g.add_node("left", mesh=mesh, translation=[-1, 0, 0]), hidden, g.add_node("right", mesh=mesh, translation=[1, 0, 0])]
    return g.finish(nodes, "visibility").to_gltf()


def quantized():
    """KHR_mesh_quantization: positions in shorts, normals in bytes, coordinates in unsigned bytes."""
    g = Gltf()
    g.use("KHR_mesh_quantization", required=True)
    mesh = sphere(1.0, 12, 6)
    primitive = {
        "attributes": {
            "POSITION": g.add_accessor([tuple(round(c * 1000) for c in p) for p in mesh.positions], "VEC3", SHORT, bounds=True,
                                       target=34962),
            "NORMAL": g.add_accessor([tuple(round(c * 127) for c in n) for n in mesh.normals], "VEC3", BYTE, True, target=34962),
            "TEXCOORD_0": g.add_accessor([tuple(round(c * 255) for c in uv) for uv in mesh.uvs], "VEC2", UBYTE, True, target=34962),
        },
        "indices": g.add_accessor(mesh.indices, "SCALAR", UBYTE),
    }
    return _single(g, primitive, "quantized", scale=[0.001, 0.001, 0.001])


def points_and_lines():
    """A triangle, points at its corners, and a line strip that completes the square."""
    g = Gltf()
    triangle = {"POSITION": g.add_accessor([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "VEC3", bounds=True)}
    strip = {"POSITION": g.add_accessor([(1, 0, 0), (1, 1, 0), (0, 1, 0)], "VEC3", bounds=True)}
    primitives = [{"attributes": strip if mode == 3 else triangle, "mode": mode} for mode in (0, 3, 4)]
    return g.finish([g.add_node("mixed", mesh=g.add("meshes", {"primitives": primitives}))], "modes").to_gltf()


def emissive_strength():
    """Left emission 1, right 10: KHR_materials_emissive_strength."""
    g = Gltf()
    parts = [(quad((x, -0.5, 0), (1, 0, 0), (0, 1, 0)).without_uvs(), g.add_material("glow %g" % s, (0, 0, 0), emission=(s, 0.5 * s, 0.2 * s)))
             for x, s in ((-1.1, 1.0), (0.1, 10.0))]
    floor = quad((-2, -0.6, 2), (4, 0, 0), (0, 0, -4)).without_uvs()
    roots = [g.add_node("panels", mesh=g.add_mesh("panels", parts)),
             g.add_node("floor", mesh=g.add_mesh("floor", [(floor, g.add_material("white", (0.8, 0.8, 0.8)))]))]
    return g.finish(roots, "emission").to_gltf()


def procedural_textures():
    """Spheres of stripes, turbulence, marble, Worley cells and a noise sum on a checkerboard: KHR_texture_procedurals (draft)."""
    g = Gltf()
    bark = procedurals.Graph("noise sum")
    p = bark.node("multiply", "vector3", in1=bark.node("position", "vector3"), in2=(3.0, 1.0, 3.0))
    bark.output(bark.node("remap", "float", in_=bark.node("fractal3d", "float", octaves=6, position=p), inlow=-1.0, inhigh=1.0,
                          outlow=0.1, outhigh=0.8))
    procedurals.add(g, [
        procedurals.checkerboard((0.8, 0.8, 0.75), (0.08, 0.1, 0.12), (40.0, 40.0)),
        procedurals.stripes((0.8, 0.1, 0.05), (0.85, 0.85, 0.8), 12.0, 0.4),
        procedurals.turbulence((0.02, 0.05, 0.2), (0.9, 0.9, 0.95)),
        procedurals.marble((0.03, 0.03, 0.05), (0.85, 0.83, 0.78)),
        procedurals.worley((0.9, 0.5, 0.1), (0.1, 0.02, 0.02)), bark])
    fallback = g.add("textures", {})

    def material(name, graph):
        return g.add_material(name, roughness=0.6, pbr={"baseColorTexture": procedurals.slot(graph, fallback)})

    floor = g.add_mesh("floor", [(quad((-10, 0, 10), (20, 0, 0), (0, 0, -20)), material("checkerboard", 0))])
    ball = g.add_primitive(sphere(0.5, 24, 12))
    roots = [g.add_node("floor", mesh=floor), g.add_camera_node("camera", (0.0, 1.6, 5.0), (0.0, 0.4, 0.0), 0.6)]
    for i, name in enumerate(["stripes", "turbulence", "marble", "worley", "noise sum"]):
        mesh = g.add("meshes", {"name": name, "primitives": [{**ball, "material": material(name, i + 1)}]})
        roots.append(g.add_node(name, mesh=mesh, translation=[1.1 * (i - 2), 0.5, 0.0]))
    return g.finish(roots, "procedural textures").to_gltf()


def external_files():
    """Buffer and image beside the file, with a space and a letter outside of ASCII in their names, percent-encoded."""
    g = Gltf()
    g.json["images"] = [{"uri": "checker%20board.png"}]
    g.json["textures"] = [{"source": 0}]
    material = g.add_material("checker", 0)
    mesh = g.add_mesh("quad", [(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), material)])
    g.finish([g.add_node("quad", mesh=mesh)], "external files")
    return {"external_files.gltf": dump(g.document("b%C3%BCffer.bin")).encode(), "b\u00fcffer.bin": bytes(g.bin),
            "checker board.png": _leaf_picture(False)}


def build():
    files = [triangle_strip, triangle_fan, non_indexed, sparse, interleaved, vertex_colors, morph_targets, skin, animation,
             texture_transform, light_point, light_spot, light_directional, unlit, alpha_modes, orthographic_camera,
             negative_scale, several_scenes, node_visibility, quantized, points_and_lines, emissive_strength,
             procedural_textures]
    result = {"tiny/%s.gltf" % make.__name__: make() for make in files}
    result.update({"tiny/" + name: data for name, data in external_files().items()})
    return result
