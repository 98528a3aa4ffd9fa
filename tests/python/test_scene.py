# SPDX-License-Identifier: Apache-2.0
"""Tests of kindling.Scene: the file it makes, what it refuses, and what is rendered of it."""
import json
import struct
import zlib

import kindling
import numpy as np
import pytest

TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
QUAD = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def parts(data):
    """The document and the binary chunk of a .glb, whose lengths are checked."""
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data)) and size % 4 == 0
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and length % 4 == 0
    document = json.loads(data[20:20 + length])
    if 20 + length == len(data):
        return document, b""
    chunk, kind = struct.unpack_from("<I4s", data, 20 + length)
    assert kind == b"BIN\0" and 28 + length + chunk == len(data)
    return document, data[28 + length:]


def values(document, chunk, accessor):
    accessor = document["accessors"][accessor]
    view = document["bufferViews"][accessor["bufferView"]]
    dtype = {5126: np.float32, 5125: np.uint32}[accessor["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    return np.frombuffer(chunk, dtype, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)


def test_geometry_is_that_of_the_arrays():
    scene = kindling.Scene()
    vertices = np.asfortranarray(np.array(QUAD[0], dtype=np.float64))
    scene.add_mesh(vertices, np.array(QUAD[1], dtype=np.int8), normals=[[0, 0, 2]] * 4, uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
    document, chunk = parts(scene.to_glb())
    (primitive,) = document["meshes"][0]["primitives"]
    np.testing.assert_array_equal(values(document, chunk, primitive["attributes"]["POSITION"]), vertices)
    np.testing.assert_array_equal(values(document, chunk, primitive["indices"]).reshape(-1, 3), QUAD[1])
    np.testing.assert_array_equal(values(document, chunk, primitive["attributes"]["NORMAL"]), [[0, 0, 1]] * 4)
    assert document["accessors"][primitive["attributes"]["POSITION"]]["max"] == [1, 1, 0]
    assert document["scenes"] == [{"nodes": [0]}]


def test_equal_materials_and_meshes_are_stored_once():
    scene = kindling.Scene()
    material = kindling.Material(color=(1, 0, 0))
    mesh = scene.add_mesh(*TRIANGLE, material, place=False)
    scene.add_mesh(*TRIANGLE, material, name="other")
    matrix = np.eye(4)
    matrix[:3, 3] = 1, 2, 3
    scene.add_instance(mesh, matrix)
    scene.add_instance(mesh, matrix[:3])
    document, _ = parts(scene.to_glb())
    assert len(document["materials"]) == 1 and len(document["meshes"]) == 2
    placed = [node for node in document["nodes"] if node["mesh"] == mesh]
    assert len(placed) == 2 and all(node["matrix"][12:] == [1, 2, 3, 1] for node in placed)


def test_textures_are_png():
    texture = np.arange(5 * 7 * 4, dtype=np.uint8).reshape(5, 7, 4)
    scene = kindling.Scene()
    scene.add_mesh(*TRIANGLE, kindling.Material(texture=texture), uvs=[[0, 0], [1, 0], [0, 1]])
    document, chunk = parts(scene.to_glb())
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    png = chunk[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, pixels = 8, b""
    while at < len(png):
        size, name = struct.unpack_from(">I4s", png, at)
        assert struct.unpack_from(">I", png, at + 8 + size)[0] == zlib.crc32(png[at + 4:at + 8 + size])
        if name == b"IHDR":
            assert struct.unpack_from(">IIBB", png, at + 8) == (7, 5, 8, 6)
        if name == b"IDAT":
            pixels += png[at + 8:at + 8 + size]
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(pixels), np.uint8).reshape(5, 1 + 7 * 4)
    np.testing.assert_array_equal(rows[:, 1:].reshape(5, 7, 4), texture)


def test_cameras_and_lights_look_along_their_directions():
    scene = kindling.Scene()
    scene.add_camera((1, 2, 3), (1, 2, -5), yfov=90, name="front")
    scene.add_light("sun", 3, direction=(0, -1, 0))
    scene.add_light("spot", 10, position=(0, 4, 0), direction=(0, -2, 0), cone=(10, 20))
    document, _ = parts(scene.to_glb())
    camera, sun, spot = (np.array(node["matrix"]).reshape(4, 4).T for node in document["nodes"])
    np.testing.assert_allclose(camera, [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]], atol=1e-12)
    for matrix in (sun, spot):
        np.testing.assert_allclose(-matrix[:3, 2], (0, -1, 0), atol=1e-12)
        np.testing.assert_allclose(np.linalg.det(matrix), 1)
    lights = document["extensions"]["KHR_lights_punctual"]["lights"]
    assert [light["type"] for light in lights] == ["directional", "spot"]
    assert document["cameras"][0]["perspective"]["yfov"] == pytest.approx(np.pi / 2)


def add(scene, **settings):
    return scene.add_mesh(*TRIANGLE, kindling.Material(**settings))


@pytest.mark.parametrize("call, text", [
    (lambda s: s.add_mesh([[0, 0]], [[0, 0, 0]]), r"vertices: shape \(1, 2\), expected \(n, 3\)"),
    (lambda s: s.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "vertices: none"),
    (lambda s: s.add_mesh([[0, 0, 0], [1, np.nan, 0]], [[0, 1, 1]]), r"vertices\[1\] is \(1.0, nan, 0.0\)"),
    (lambda s: s.add_mesh(TRIANGLE[0], [[0, 1, 3]]), r"faces\[0\] is \(0, 1, 3\), but there are 3 vertices"),
    (lambda s: s.add_mesh(TRIANGLE[0], [[0.0, 1.0, 2.0]]), r"faces: shape \(1, 3\) of float64, expected \(m, 3\) of integers"),
    (lambda s: s.add_mesh(*TRIANGLE, normals=[[0, 0, 1]]), r"normals: shape \(1, 3\), expected \(3, 3\)"),
    (lambda s: s.add_mesh(*TRIANGLE, normals=[[0, 0, 1], [0, 0, 0], [0, 0, 1]]), r"normals\[1\] is \(0, 0, 0\)"),
    (lambda s: s.add_mesh(*TRIANGLE, colors=[[1, 1], [1, 1], [1, 1]]), r"colors: shape \(3, 2\), expected \(3, 3\) or \(3, 4\)"),
    (lambda s: s.add_mesh(*TRIANGLE, transform=np.eye(3)), r"transform: shape \(3, 3\)"),
    (lambda s: s.add_mesh(*TRIANGLE, transform=np.diag([1, 1, 1, 2])), r"transform\[3\] is"),
    (lambda s: s.add_instance(0, np.eye(4)), "mesh: 0, but there are 0 meshes"),
    (lambda s: add(s, color=(2, 0, 0)), r"color: \(2, 0, 0\), expected"),
    (lambda s: add(s, metallic=-1), "metallic: -1, expected 0 to 1"),
    (lambda s: add(s, roughness=float("nan")), "roughness: nan, expected"),
    (lambda s: add(s, ior=0.5), "ior: 0.5, expected 1 or more"),
    (lambda s: add(s, emission=(0, -1, 0)), "emission: "),
    (lambda s: add(s, texture=np.zeros((2, 2, 3), np.uint8)), "uvs: none, but the material has a texture"),
    (lambda s: s.add_mesh(*TRIANGLE, kindling.Material(texture=np.zeros((2, 2))), uvs=np.zeros((3, 2))), r"texture: shape \(2, 2\) of float64"),
    (lambda s: s.add_camera((0, 0, 0), (0, 1, 0)), "expected a view that is not along up"),
    (lambda s: s.add_camera((0, 0, 0), (0, 0, 1), yfov=180), "yfov: 180, expected"),
    (lambda s: s.add_light("area", 1), "kind: 'area', expected"),
    (lambda s: s.add_light("point", -1), "intensity: -1, expected"),
    (lambda s: s.add_light("spot", 1, cone=(30, 20)), r"cone: \(30, 20\), expected"),
])
def test_errors_name_place_and_value(call, text):
    scene = kindling.Scene()
    with pytest.raises(ValueError, match=text):
        call(scene)
    document, chunk = parts(scene.to_glb())
    assert document["scenes"] == [{}]  # nothing was placed


def quad_scene(**material):
    scene = kindling.Scene()
    scene.add_mesh(*QUAD, kindling.Material(**material), uvs=[[0, 1], [1, 1], [1, 0], [0, 0]])
    scene.add_camera((0, 0, 1), (0, 0, 0), yfov=2 * np.degrees(np.arctan(0.5)))
    return scene


def test_emission_is_radiance():
    pytest.importorskip("kindling._render")
    image = kindling.render(quad_scene(color=(0, 0, 0), emission=(3, 0.5, 0.25), roughness=1), size=(8, 8), spp=4, env_color=(0, 0, 0))
    np.testing.assert_allclose(image.rgb, np.broadcast_to((3, 0.5, 0.25), (8, 8, 3)), rtol=1e-4)


def test_the_texture_begins_at_the_top_left():
    pytest.importorskip("kindling._render")
    texture = np.zeros((2, 2, 3), np.uint8)
    texture[0, 0], texture[0, 1], texture[1, 0] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    image = kindling.render(quad_scene(texture=texture), size=(64, 64), spp=4, env_color=(1, 1, 1), aovs=["albedo"])
    albedo = image.layer("albedo")
    assert albedo[4, 4].argmax() == 0 and albedo[4, 59].argmax() == 1 and albedo[59, 4].argmax() == 2


def test_bytes_give_the_image_of_their_file(tmp_path):
    pytest.importorskip("kindling._render")
    data = quad_scene(color=(0.5, 0.25, 0.125)).to_glb()
    (tmp_path / "scene.glb").write_bytes(data)
    small = {"size": (16, 12), "spp": 4}
    expected = kindling.render(tmp_path / "scene.glb", **small).rgb
    assert expected.max() > 0.01
    np.testing.assert_array_equal(kindling.render(data, **small).rgb, expected)
    np.testing.assert_array_equal(kindling.render(quad_scene(color=(0.5, 0.25, 0.125)), **small).rgb, expected)


def test_trimesh_scenes_are_rendered():
    pytest.importorskip("kindling._render")
    trimesh = pytest.importorskip("trimesh")
    sphere = trimesh.creation.icosphere(2)
    for scene in (sphere, trimesh.Scene([sphere])):
        alpha = kindling.render(scene, size=(32, 32), spp=4, transparent_background=True, aovs=["alpha"]).layer("alpha")
        assert alpha[16, 16] == 1 and alpha[0, 0] == 0


def test_other_types_are_refused():
    pytest.importorskip("kindling._render")
    with pytest.raises(TypeError, match="scene: int, expected a file, bytes, kindling.Scene, or a trimesh mesh"):
        kindling.render(7)
    with pytest.raises(ValueError, match="scene.gltf"):
        kindling.render(b"no scene")
