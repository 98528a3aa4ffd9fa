"""Triangles of a glTF scene, and the PLY files through which renderers get them."""
# SPDX-License-Identifier: Apache-2.0
from dataclasses import dataclass

import numpy as np


@dataclass
class Mesh:
    """Triangles of one material; in world space (meters, y up) once they are placed."""
    positions: np.ndarray  # (n, 3)
    normals: np.ndarray | None  # (n, 3)
    texcoords: np.ndarray | None  # (n, 2), v down as in glTF; as the material's textures are read
    triangles: np.ndarray  # (m, 3)
    material: "Material"


def placed(mesh, worlds):
    """The mesh in world space, once for each of these matrices (4, 4), as one mesh."""
    copies = [transformed(mesh, world) for world in worlds]
    first_corners = len(mesh.positions) * np.arange(len(copies), dtype=np.int32)
    return Mesh(np.concatenate([copy.positions for copy in copies]),
                None if mesh.normals is None else np.concatenate([copy.normals for copy in copies]),
                None if mesh.texcoords is None else np.tile(mesh.texcoords, (len(copies), 1)),
                np.concatenate([copy.triangles + first for copy, first in zip(copies, first_corners)]), mesh.material)


def transformed(mesh, world):
    """Triangles that a matrix mirrors are turned over."""
    linear = world[:3, :3]
    normals = None
    if mesh.normals is not None:
        normals = mesh.normals @ np.linalg.inv(linear)
        normals = (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)).astype(np.float32)
    triangles = mesh.triangles[:, ::-1] if np.linalg.det(linear) < 0.0 else mesh.triangles
    return Mesh((mesh.positions @ linear.T + world[:3, 3]).astype(np.float32), normals, mesh.texcoords, triangles, mesh.material)


def is_closed(mesh):
    """Whether every edge has as many triangles in one direction as in the other."""
    _, places = np.unique(mesh.positions, axis=0, return_inverse=True)
    corners = places.reshape(-1)[mesh.triangles].astype(np.int64)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    forward, backward = (np.sort(a * (len(places) + 1) + b) for a, b in ((edges[:, 0], edges[:, 1]), (edges[:, 1], edges[:, 0])))
    return np.array_equal(forward, backward)


def back_of(mesh):
    """The same triangles turned over, a ten-thousandth of the mesh's size behind it, so that no ray meets both at once."""
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    behind = -np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    behind /= np.maximum(np.linalg.norm(behind, axis=1, keepdims=True), 1e-30)
    moved = corners + 1e-4 * np.ptp(mesh.positions, axis=0).max() * behind[:, None, :]
    order = mesh.triangles.ravel()
    return Mesh(moved.reshape(-1, 3).astype(np.float32), None if mesh.normals is None else -mesh.normals[order],
                None if mesh.texcoords is None else mesh.texcoords[order],
                np.arange(len(order), dtype=np.int32).reshape(-1, 3)[:, ::-1].copy(), mesh.material)


def write_ply(mesh, path):
    """A binary PLY file of a mesh: positions, normals and texture coordinates as far as it has them."""
    names, columns = ["x", "y", "z"], [mesh.positions]
    if mesh.normals is not None:
        names += ["nx", "ny", "nz"]
        columns.append(mesh.normals)
    if mesh.texcoords is not None:
        names += ["s", "t"]
        columns.append(mesh.texcoords)
    vertices = np.concatenate(columns, axis=1).astype("<f4")
    faces = np.empty(len(mesh.triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, mesh.triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
              *(f"property float {name}" for name in names), f"element face {len(faces)}",
              "property list uchar int vertex_indices", "end_header"]
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\n").encode())
        file.write(vertices.tobytes())
        file.write(faces.tobytes())
