"""Scenes and files made to exhaust memory and patience: the material of bounds.py."""
# SPDX-License-Identifier: Apache-2.0
import random
from array import array

import bounds_shapes as shapes
from bounds_shapes import FLOAT, TILTED, UINT, USHORT, Gltf, box_mesh, same_triangles


def typical(folder):
    """1 million triangles of a bumpy surface"""
    return shapes.write_shape(folder, shapes.bumpy, 1_000_000)


def coincident_triangles(folder):
    """4 million copies of one tilted triangle in one mesh"""
    return shapes.write_shape(folder, shapes.coincident, 4_000_000)


def nested_boxes(folder):
    """83,333 boxes one in the other, 1 million triangles"""
    return shapes.write_shape(folder, shapes.nested_boxes, 1_000_000)


def nested_spheres(folder):
    """12,500 spheres one in the other, 1 million triangles"""
    return shapes.write_shape(folder, shapes.nested_spheres, 1_000_000)


def needles(folder):
    """1 million needles through the whole scene in all directions"""
    return shapes.write_shape(folder, shapes.needles, 1_000_000)


def one_cell(folder):
    """1 million triangles in a spot of 0.1 mm, far from two others"""
    return shapes.write_shape(folder, shapes.one_cell, 1_000_000)


def soup(folder):
    """1 million random triangles of all sizes"""
    return shapes.write_shape(folder, shapes.soup, 1_000_000)


def overlapping_soup(folder):
    """300,000 large random triangles through one another"""
    return shapes.write_shape(folder, shapes.large_soup, 300_000)


def coincident_instances(folder, moved=False):
    """16,384 nodes at one place, each with the same 1,000 copies of a triangle"""
    gltf = Gltf()
    mesh = gltf.mesh(gltf.accessor(array("f", TILTED), FLOAT, "VEC3"), gltf.accessor(same_triangles(1000), UINT, "SCALAR"))
    for _ in range(16384):
        gltf.node(mesh=mesh, **({"translation": [0.5, 0.25, 0.125]} if moved else {}))
    return gltf.write(folder, "coincident_instances" + ("_moved" if moved else ""))


def coincident_instances_moved(folder):
    """the same, all moved by one translation"""
    return coincident_instances(folder, True)


def million_coincident_instances(folder):
    """5.2 million instances at one place of 1,000 copies of a triangle, in a file of 1 KB"""
    gltf = Gltf()
    mesh = gltf.mesh(gltf.accessor(array("f", TILTED), FLOAT, "VEC3"), gltf.accessor(same_triangles(1000), UINT, "SCALAR"))
    places = gltf.accessor(None, FLOAT, "VEC3", 5_200_000)
    gltf.root["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    gltf.node(mesh=mesh, extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}})
    return gltf.write(folder, "million_coincident_instances")


def scattered_instances(folder):
    """4 million instances of 12 triangles, scattered over a plain"""
    gltf, rng = Gltf(), random.Random(1)
    mesh = box_mesh(gltf, [(-0.5, 0.5)])
    places = array("f", (value for _ in range(4_000_000) for value in (rng.random() * 4000, rng.random(), rng.random() * 4000)))
    gltf.root["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    gltf.node(mesh=mesh, extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": gltf.accessor(places, FLOAT, "VEC3")}}})
    return gltf.write(folder, "scattered_instances")


def skinned_nodes(folder):
    """50 KB: 800 nodes with a skinned mesh of 1.2 million vertices without data"""
    gltf = Gltf()
    count = 1_200_000
    zero = gltf.accessor(None, FLOAT, "VEC3", count)
    joints = gltf.accessor(None, USHORT, "VEC4", count)
    weights = gltf.accessor(None, FLOAT, "VEC4", count)
    mesh = gltf.mesh(zero, None, NORMAL=zero, JOINTS_0=joints, WEIGHTS_0=weights)
    gltf.root["skins"] = [{"joints": [0]}]
    gltf.node()
    for _ in range(800):
        gltf.node(mesh=mesh, skin=0)
    return gltf.write(folder, "skinned_nodes")


def shared_meshes(folder):
    """50 KB: 2,000 nodes with one mesh of 2.7 million vertices without data"""
    gltf = Gltf()
    mesh = gltf.mesh(gltf.accessor(None, FLOAT, "VEC3", 2_700_000), None)
    for _ in range(2000):
        gltf.node(mesh=mesh)
    return gltf.write(folder, "shared_meshes")


def morphed_nodes(folder):
    """45 KB: 2,500 nodes with 1,000 morph targets of 3,000 vertices"""
    gltf = Gltf()
    zero = gltf.accessor(None, FLOAT, "VEC3", 3000)
    gltf.accessor(array("I", [0]), UINT, "SCALAR")
    gltf.accessor(array("f", [1.0, 1.0, 1.0]), FLOAT, "VEC3")
    target = gltf.accessor(None, FLOAT, "VEC3", 3000)
    gltf.root["accessors"][target]["sparse"] = {"count": 1, "indices": {"bufferView": 0, "componentType": UINT}, "values": {"bufferView": 1}}
    mesh = gltf.mesh(zero, None)
    gltf.root["meshes"][mesh]["weights"] = [1] * 1000
    gltf.root["meshes"][mesh]["primitives"][0]["targets"] = [{"POSITION": target}] * 1000
    for _ in range(2500):
        gltf.node(mesh=mesh)
    return gltf.write(folder, "morphed_nodes")


def shared_keys(folder):
    """4.2 MB: 1,000 channels that share 260,000 keys"""
    gltf = Gltf()
    gltf.node(mesh=gltf.triangles(TILTED, [0, 1, 2]))
    keys = 260_000
    times = gltf.accessor(array("f", range(keys)), FLOAT, "SCALAR")
    values = gltf.accessor(array("f", [0.0, 1.0, 0.0]) * keys, FLOAT, "VEC3")
    gltf.root["animations"] = [{"samplers": [{"input": times, "output": values}],
                                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}] * 1000}]
    return gltf.write(folder, "shared_keys")


def empty_nodes(folder):
    """4 MB: 1.3 million empty nodes"""
    path = folder / "empty_nodes.gltf"
    path.write_text('{"asset":{"version":"2.0"},"nodes":[' + ",".join(["{}"] * 1_300_000) + "]}")
    return path


def empty_materials(folder):
    """4 MB: 1.3 million empty materials"""
    path = folder / "empty_materials.gltf"
    path.write_text('{"asset":{"version":"2.0"},"materials":[' + ",".join(["{}"] * 1_300_000) + "]}")
    return path


def nested_json(folder):
    """50 KB: extras of 25,000 levels"""
    path = folder / "nested_json.gltf"
    path.write_text('{"asset":{"version":"2.0"},"nodes":[{"extras":' + "[" * 25000 + "]" * 25000 + "}]}")
    return path


def zero_tangents(folder):
    """1 KB: tangents for 2 million vertices without data"""
    gltf = Gltf()
    count = 2_000_000
    mesh = gltf.mesh(gltf.accessor(None, FLOAT, "VEC3", count), None, TEXCOORD_0=gltf.accessor(None, FLOAT, "VEC2", count))
    gltf.root["meshes"][mesh]["primitives"][0]["material"] = 0
    gltf.root["materials"] = [{"normalTexture": {"index": 0}}]
    gltf.root["textures"] = [{"source": 0}]
    gltf.root["images"] = [{"uri": "absent.png"}]
    gltf.node(mesh=mesh)
    return gltf.write(folder, "zero_tangents")


def long_joints(folder):
    """50 KB: 400 nodes with a skin of 15,000 joints"""
    gltf = Gltf()
    zero = gltf.accessor(None, FLOAT, "VEC3", 30)
    mesh = gltf.mesh(zero, None, JOINTS_0=gltf.accessor(None, USHORT, "VEC4", 30), WEIGHTS_0=gltf.accessor(None, FLOAT, "VEC4", 30))
    gltf.root["skins"] = [{"joints": [0] * 15000}]
    gltf.node()
    for _ in range(400):
        gltf.node(mesh=mesh, skin=0)
    return gltf.write(folder, "long_joints")


SCENES = [typical, coincident_triangles, coincident_instances, coincident_instances_moved, million_coincident_instances,
          scattered_instances, nested_boxes, nested_spheres, needles, one_cell, soup, overlapping_soup]
FILES = [skinned_nodes, morphed_nodes, shared_meshes, shared_keys, empty_nodes, empty_materials, nested_json, zero_tangents, long_joints]
