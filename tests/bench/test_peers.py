#!/usr/bin/env python3
"""Tests of bench/peers: reading of glTF, PLY files, and what happens where a renderer is missing.

test_peers.py BENCH_FOLDER SCENES_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path[:0] = [sys.argv[1], str(Path(sys.argv[1], "peers"))]
sys.dont_write_bytecode = True
import with_numpy  # noqa: F401
import gltf_meshes
import gltf_scene
import numpy as np

from peers import install, run

BENCH, SCENES = Path(sys.argv[1]), Path(sys.argv[2])


class ReadScene(unittest.TestCase):
    def test_cornell_box(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = gltf_scene.read_scene(SCENES / "cornell_box.glb", folder)
        self.assertGreater(scene.camera.yfov_rad, 0.1)
        lamps = [mesh for mesh in scene.meshes if mesh.material.emits()]
        self.assertEqual(len(lamps), 1)
        self.assertFalse(gltf_meshes.is_closed(lamps[0]))
        bounds = np.concatenate([mesh.positions for mesh in scene.meshes])
        for mesh in scene.meshes:
            self.assertLess(mesh.triangles.max(), len(mesh.positions))
            self.assertTrue(np.isfinite(mesh.positions).all())
        self.assertTrue((np.ptp(bounds, axis=0) > 0.1).all())

    def test_transforms(self):
        """A triangle in a node that is turned by 90 degrees about y, below one that is mirrored and moved."""
        data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
        half = 0.5 ** 0.5
        gltf = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
                "nodes": [{"translation": [5, 0, 0], "scale": [-1, 1, 1], "children": [1]}, {"rotation": [0, half, 0, half], "mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
                "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "a.bin"}]}
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "a.bin").write_bytes(data)
            (Path(folder) / "a.gltf").write_text(json.dumps(gltf))
            mesh = gltf_scene.read_scene(Path(folder) / "a.gltf", folder).meshes[0]
        self.assertTrue(np.allclose(mesh.positions, [[5, 0, 0], [5, 0, -1], [5, 1, 0]], atol=1e-6))
        self.assertEqual(mesh.triangles.tolist(), [[2, 1, 0]])  # mirrored: turned over

    def read_with(self, data=None, **fields):
        """Reads a triangle with texture coordinates, in a node that is turned so that -z becomes +x. Fields replace its own."""
        data = data or struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + struct.pack("<12f", 0, 0, 1, 0, 0, 1, .5, .5, .5, .5, .5, .5)
        half = 0.5 ** 0.5
        gltf = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
                "nodes": [{"rotation": [0, -half, 0, half], "translation": [1, 2, 3], "mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2}, "material": 0}]}],
                "materials": [{}], "images": [{"uri": "a.png"}], "textures": [{"source": 0}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                              {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
                              {"bufferView": 1, "byteOffset": 24, "componentType": 5126, "count": 3, "type": "VEC2"}],
                "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 48}],
                "buffers": [{"byteLength": 84, "uri": "a.bin"}]} | fields
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "a.bin").write_bytes(data)
            (Path(folder) / "a.gltf").write_text(json.dumps(gltf))
            return gltf_scene.read_scene(Path(folder) / "a.gltf", folder)

    def test_lights(self):
        lights = [{"type": "spot", "intensity": 8, "color": [1, 0.5, 0.25], "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
                  {"type": "directional"}]
        nodes = [{"rotation": [0, -(0.5 ** 0.5), 0, 0.5 ** 0.5], "translation": [1, 2, 3], "scale": [2, 2, 2],
                  "extensions": {"KHR_lights_punctual": {"light": 0}}},
                 {"extensions": {"KHR_lights_punctual": {"light": 1}}}]
        scene = self.read_with(nodes=nodes, scenes=[{"nodes": [0, 1]}], extensions={"KHR_lights_punctual": {"lights": lights}})
        spot, sun = scene.lights
        self.assertEqual((spot.kind, spot.inner_rad, spot.outer_rad), ("spot", 0.2, 0.4))
        self.assertEqual(spot.intensity.tolist(), [8.0, 4.0, 2.0])
        self.assertTrue(np.allclose(spot.position, [1, 2, 3]))
        self.assertTrue(np.allclose(spot.direction, [1, 0, 0]))
        self.assertEqual((sun.kind, sun.intensity.tolist()), ("directional", [1.0, 1.0, 1.0]))
        self.assertTrue(np.allclose(sun.direction, [0, 0, -1]))

    def test_moved_textures(self):
        """Scaled, then turned by a right angle, then moved, as KHR_texture_transform has it; of the second set."""
        moved = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {
            "offset": [0.25, 0.5], "rotation": 0.5 * np.pi, "scale": [2, 3], "texCoord": 1}}}
        mesh = self.read_with(materials=[{"pbrMetallicRoughness": {"baseColorTexture": moved}}]).meshes[0]
        self.assertTrue(np.allclose(mesh.texcoords, [[0.25 + 1.5, 0.5 - 1.0]] * 3, atol=1e-6))
        plain = self.read_with().meshes[0]
        self.assertTrue(np.allclose(plain.texcoords, [[0, 0], [1, 0], [0, 1]]))

    def test_coats_and_textures_of_transmission(self):
        extensions = {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25},
                      "KHR_materials_transmission": {"transmissionFactor": 0.75, "transmissionTexture": {"index": 0}}}
        material = self.read_with(materials=[{"extensions": extensions}]).meshes[0].material
        self.assertEqual((material.clearcoat, material.clearcoat_roughness, material.transmission), (0.5, 0.25, 0.75))
        self.assertEqual(material.transmission_texture.name, "a.png")
        plain = self.read_with().meshes[0].material
        self.assertEqual((plain.clearcoat, plain.transmission, plain.transmission_texture), (0.0, 0.0, None))

    def test_instances(self):
        """Two triangles for one node: each is scaled, then moved, then turned with the node; the second is mirrored, too."""
        places = struct.pack("<6f", 1, 0, 0, 0, 4, 0) + struct.pack("<6f", 2, 2, 2, 1, 1, -1)
        triangle = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
        half = 0.5 ** 0.5
        instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1, "SCALE": 2}}}
        file = self.read_with(
            extensionsRequired=["EXT_mesh_gpu_instancing"], data=triangle + places,
            nodes=[{"rotation": [0, -half, 0, half], "mesh": 0, "extensions": instancing}],
            meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}],
            accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                       {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "VEC3"},
                       {"bufferView": 0, "byteOffset": 60, "componentType": 5126, "count": 2, "type": "VEC3"}],
            bufferViews=[{"buffer": 0, "byteLength": 84}], buffers=[{"byteLength": 84, "uri": "a.bin"}])
        mesh, = file.meshes
        expected = [[0, 0, 1], [0, 0, 3], [0, 2, 1], [0, 4, 0], [0, 4, 1], [0, 5, 0]]
        self.assertTrue(np.allclose(mesh.positions, expected, atol=1e-6), mesh.positions)
        self.assertEqual(mesh.triangles.tolist(), [[0, 1, 2], [5, 4, 3]])

    def test_textures_that_lie_apart_end_with_a_message(self):
        materials = [{"name": "cloth", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
                      "normalTexture": {"index": 0, "texCoord": 1}}]
        with self.assertRaisesRegex(SystemExit, "material cloth: its textures lie in 2 ways"):
            self.read_with(materials=materials)

    def test_required_extensions_that_are_not_read_end_with_a_message(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "a.gltf"
            file.write_text(json.dumps({"extensionsRequired": ["EXT_meshopt_compression"]}))
            with self.assertRaisesRegex(SystemExit, "EXT_meshopt_compression"):
                gltf_scene.read_scene(file, folder)


class Meshes(unittest.TestCase):
    def tetrahedron(self):
        positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
        triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
        return gltf_meshes.Mesh(positions, None, None, triangles, gltf_scene.Material())

    def test_closed_meshes(self):
        mesh = self.tetrahedron()
        self.assertTrue(gltf_meshes.is_closed(mesh))
        mesh.triangles = mesh.triangles[:3]
        self.assertFalse(gltf_meshes.is_closed(mesh))
        soup = self.tetrahedron()  # each triangle with corners of its own
        soup.positions, soup.triangles = soup.positions[soup.triangles.ravel()], np.arange(12).reshape(4, 3)
        self.assertTrue(gltf_meshes.is_closed(soup))

    def test_backs_face_the_other_way(self):
        mesh = self.tetrahedron()
        mesh.triangles = mesh.triangles[:1]  # z = 0, faces -z
        back = gltf_meshes.back_of(mesh)
        corners = back.positions[back.triangles[0]]
        self.assertGreater(np.cross(corners[1] - corners[0], corners[2] - corners[0])[2], 0.0)
        self.assertTrue(np.allclose(back.positions[:, 2], 1e-4, atol=1e-6))  # behind: towards +z

    def test_ply(self):
        mesh = self.tetrahedron()
        mesh.texcoords = np.arange(8, dtype=np.float32).reshape(4, 2)
        with tempfile.TemporaryDirectory() as folder:
            gltf_meshes.write_ply(mesh, Path(folder) / "a.ply")
            header, body = (Path(folder) / "a.ply").read_bytes().split(b"end_header\n")
        self.assertIn(b"element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n", header)
        self.assertEqual(np.frombuffer(body, "<f4", 5, 20).tolist(), [1.0, 0.0, 0.0, 2.0, 3.0])
        self.assertEqual(struct.unpack_from("<B3i", body, 4 * 20), (3, 0, 2, 1))
        self.assertEqual(len(body), 4 * 20 + 4 * 13)


class Installation(unittest.TestCase):
    def test_missing_renderers_are_left_out(self):
        with tempfile.TemporaryDirectory() as cache, mock.patch.dict(os.environ, {"XDG_CACHE_HOME": cache}), \
                mock.patch.object(install.subprocess, "run", return_value=subprocess.CompletedProcess([], 1, "", "no network")):
            self.assertFalse(install.installed("luxcore"))
            self.assertEqual(run.prepare(["luxcore"]), [])
            install.environment_folder().joinpath("bin").mkdir(parents=True)
            install.python().touch()
            self.assertEqual(install.install(["luxcore"]), {"luxcore": "no network"})

    def test_unknown_names(self):
        done = subprocess.run([sys.executable, BENCH / "peers" / "install.py", "povray"], capture_output=True, text=True, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no renderer povray; there are cycles, mitsuba, mitsuba_cuda, luxcore", done.stderr)

    def test_the_running_python_comes_first(self):
        for version, found in (("3.0.0", False), ("3.9.1", True)):
            with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, {"XDG_CACHE_HOME": folder}), \
                    mock.patch.object(sys, "path", [folder]):
                package = Path(folder) / f"mitsuba-{version}.dist-info"
                package.mkdir()
                (package / "METADATA").write_text(f"Metadata-Version: 2.1\nName: mitsuba\nVersion: {version}\n")
                self.assertEqual(install.installed("mitsuba_cuda"), found)
                self.assertEqual(install.python_of("mitsuba_cuda"), Path(sys.executable) if found else install.python())


class Calls(unittest.TestCase):
    def test_variants_of_mitsuba_share_a_script(self):
        result = [(0.1, 'PEER-RESULT {"wall_s": 1.0, "cpu_s": 2.0}')], 3.0, 4.0, 5.0
        for name, variant in (("mitsuba", "llvm_ad_rgb"), ("mitsuba_cuda", "cuda_ad_rgb")):
            with tempfile.TemporaryDirectory() as folder, mock.patch.object(run.renderers, "run_measured", return_value=result) as measured:
                run.call(name, {"spp": 1}, Path(folder) / "a")
                job = json.loads((Path(folder) / "a.job.json").read_text())
            self.assertEqual((job["variant"], job["spp"]), (variant, 1))
            self.assertEqual(measured.call_args[0][0][2].name, "render_mitsuba.py")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
