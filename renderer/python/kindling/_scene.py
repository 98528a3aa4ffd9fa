# SPDX-License-Identifier: Apache-2.0
"""Scenes made of arrays: meshes with materials, instances, cameras and lights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kindling._glb import GlbWriter, png

__all__ = ["Material", "Scene"]

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Material:
    """A metallic-roughness material of glTF.

    color: base color, linear, 0 to 1; a fourth number is the coverage. texture: (height, width, 3 or 4) uint8, sRGB, by
    which color is multiplied; its mesh needs uvs. metallic, roughness, transmission: 0 to 1. emission: radiance in nits.
    ior: index of refraction, at least 1.
    """

    color: Sequence[float] = (0.8, 0.8, 0.8)
    texture: Optional[ArrayLike] = None
    metallic: float = 0.0
    roughness: float = 0.5
    transmission: float = 0.0
    ior: float = 1.5
    emission: Triple = (0.0, 0.0, 0.0)
    double_sided: bool = True
    name: str = ""


class Scene:
    """A scene made of arrays, for render() and Renderer. Meters; y is up.

    Every add_ function returns the number of what it added. Errors are raised at once: ValueError with the place, the
    value, and what is expected.
    """

    def __init__(self) -> None:
        self._glb = GlbWriter()
        self._materials: dict[int, tuple[Material, int]] = {}  # by id(); the material is kept so that it stays its own
        self._nodes: list[int] = []

    def add_mesh(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        material: Material = Material(),
        *,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        transform: ArrayLike | None = None,
        place: bool = True,
        name: str = "",
    ) -> int:
        """Add a mesh, and an instance of it unless place is False; return its number for add_instance().

        vertices: (n, 3). faces: (m, 3) numbers of vertices. normals: (n, 3), of any length but 0; flat without them.
        uvs: (n, 2), from the top left of the texture. colors: (n, 3 or 4), linear, by which the material's is multiplied.
        transform: (4, 4), or (3, 4), with the translation in its last column.
        """
        positions = _rows("vertices", vertices, (3,))
        if len(positions) == 0:
            raise ValueError("vertices: none, expected at least 3")
        count = len(positions)
        attributes = {"POSITION": self._glb.accessor(positions, bounds=True)}
        if normals is not None:
            attributes["NORMAL"] = self._glb.accessor(_unit(_rows("normals", normals, (3,), count)))
        if uvs is not None:
            attributes["TEXCOORD_0"] = self._glb.accessor(_rows("uvs", uvs, (2,), count))
        if colors is not None:
            attributes["COLOR_0"] = self._glb.accessor(_rows("colors", colors, (3, 4), count))
        primitive: dict[str, Any] = {
            "attributes": attributes,
            "indices": self._glb.accessor(_triangles(faces, count).reshape(-1)),
        }
        if material.texture is not None and uvs is None:
            raise ValueError("uvs: none, but the material has a texture")
        primitive["material"] = self._material(material)
        mesh = self._glb.append("meshes", {"primitives": [primitive], **_named(name)})
        if place:
            self._node({"mesh": mesh, **_matrix(transform), **_named(name)})
        return mesh

    def add_instance(self, mesh: int, transform: ArrayLike, *, name: str = "") -> int:
        """Add an instance of a mesh at a (4, 4) or (3, 4) transform; its geometry is stored once."""
        count = len(self._glb.document.get("meshes", []))
        if not 0 <= mesh < count:
            raise ValueError(f"mesh: {mesh}, but there are {count} meshes")
        return self._node({"mesh": mesh, **_matrix(transform), **_named(name)})

    def add_camera(
        self, position: Triple, target: Triple, *, up: Triple = (0.0, 1.0, 0.0), yfov: float = 40.0, name: str = ""
    ) -> int:
        """Add a camera that looks from position to target. yfov: vertical field of view in degrees, below 180."""
        if not 0.0 < yfov < 180.0:
            raise ValueError(f"yfov: {yfov}, expected degrees above 0 and below 180")
        perspective = {"yfov": math.radians(yfov), "znear": 1e-3}
        camera = self._glb.append("cameras", {"type": "perspective", "perspective": perspective, **_named(name)})
        self._node({"camera": camera, **_matrix(_look(position, target, up)), **_named(name)})
        return camera

    def add_light(
        self,
        kind: str,
        intensity: float,
        *,
        position: Triple = (0.0, 0.0, 0.0),
        direction: Triple = (0.0, -1.0, 0.0),
        color: Triple = (1.0, 1.0, 1.0),
        cone: tuple[float, float] = (0.0, 45.0),
        name: str = "",
    ) -> int:
        """Add a light: "point" or "spot" in candela at position, or "sun" in lux.

        direction: of the light of a spot or sun. cone: a spot's inner and outer angle in degrees, from its axis.
        """
        kinds = {"point": "point", "spot": "spot", "sun": "directional"}
        if kind not in kinds:
            raise ValueError(f"kind: {kind!r}, expected 'point', 'spot' or 'sun'")
        if not 0.0 <= intensity < math.inf:
            raise ValueError(f"intensity: {intensity}, expected 0 or more")
        light: dict[str, Any] = {"type": kinds[kind], "intensity": intensity, "color": list(color), **_named(name)}
        if kind == "spot":
            if not 0.0 <= cone[0] < cone[1] <= 90.0:
                raise ValueError(f"cone: {cone}, expected degrees, 0 <= inner < outer <= 90")
            light["spot"] = {"innerConeAngle": math.radians(cone[0]), "outerConeAngle": math.radians(cone[1])}
        self._glb.use("KHR_lights_punctual")
        lights = self._glb.document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        target = np.add(position, direction)
        up = (0.0, 1.0, 0.0) if abs(direction[1]) < 0.9 * float(np.linalg.norm(direction)) else (1.0, 0.0, 0.0)
        extension = {"KHR_lights_punctual": {"light": len(lights) - 1}}
        self._node({"extensions": extension, **_matrix(_look(position, target, up)), **_named(name)})
        return len(lights) - 1

    def to_glb(self) -> bytes:
        """Return the scene as a binary glTF file."""
        self._glb.document["scenes"] = [{"nodes": self._nodes}] if self._nodes else [{}]
        self._glb.document["scene"] = 0
        return self._glb.to_bytes()

    def _node(self, node: dict[str, Any]) -> int:
        index = self._glb.append("nodes", node)
        self._nodes.append(index)
        return index

    def _material(self, material: Material) -> int:
        known = self._materials.get(id(material))
        if known is None:
            known = self._materials[id(material)] = (material, self._add_material(material))
        return known[1]

    def _add_material(self, material: Material) -> int:
        color = [float(value) for value in material.color]
        if len(color) not in (3, 4) or not all(0.0 <= value <= 1.0 for value in color):
            raise ValueError(f"color: {tuple(material.color)}, expected 3 or 4 numbers, each 0 to 1")
        for name in ("metallic", "roughness", "transmission"):
            value = getattr(material, name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"{name}: {value}, expected 0 to 1")
        surface: dict[str, Any] = {
            "baseColorFactor": color + [1.0] * (4 - len(color)),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        if material.texture is not None:
            surface["baseColorTexture"] = {"index": self._glb.image(png(_pixels(material.texture)))}
        element = {"pbrMetallicRoughness": surface, "doubleSided": material.double_sided, **_named(material.name)}
        if len(color) == 4:
            element["alphaMode"] = "BLEND"
        extensions: dict[str, Any] = {}
        strongest = max(material.emission)
        if not 0.0 <= min(material.emission) <= strongest < math.inf:
            raise ValueError(f"emission: {material.emission}, expected three numbers of 0 or more")
        if strongest > 0.0:
            scale = max(1.0, strongest)
            element["emissiveFactor"] = [value / scale for value in material.emission]
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": scale}
        if material.transmission > 0.0:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": material.transmission}
            # A thickness above 0 makes it a solid, which refracts, and not a sheet.
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
        if material.ior != 1.5:
            if not 1.0 <= material.ior < math.inf:
                raise ValueError(f"ior: {material.ior}, expected 1 or more")
            extensions["KHR_materials_ior"] = {"ior": material.ior}
        for extension in extensions:
            self._glb.use(extension)
        return self._glb.append("materials", {**element, **({"extensions": extensions} if extensions else {})})


def _named(name: str) -> dict[str, str]:
    return {"name": name} if name else {}


def _rows(name: str, values: ArrayLike, columns: tuple[int, ...], count: int | None = None) -> NDArray[np.float32]:
    rows = np.asarray(values, dtype=np.float32)
    if rows.ndim != 2 or rows.shape[1] not in columns or (count is not None and len(rows) != count):
        sizes = " or ".join(f"({'n' if count is None else count}, {size})" for size in columns)
        raise ValueError(f"{name}: shape {rows.shape}, expected {sizes}")
    finite = np.isfinite(rows).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        raise ValueError(f"{name}[{row}] is {tuple(rows[row].tolist())}, expected finite numbers")
    return rows


def _unit(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    lengths = np.linalg.norm(normals, axis=1)
    if not (lengths > 0.0).all():
        raise ValueError(f"normals[{int(np.argmin(lengths))}] is (0, 0, 0), expected a direction")
    unit: NDArray[np.float32] = normals / lengths[:, None]
    return unit


def _triangles(faces: ArrayLike, count: int) -> NDArray[np.uint32]:
    triangles = np.asarray(faces)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise ValueError(f"faces: shape {triangles.shape} of {triangles.dtype}, expected (m, 3) of integers")
    inside = ((triangles >= 0) & (triangles < count)).all(axis=1)
    if not inside.all():
        row = int(np.argmin(inside))
        raise ValueError(f"faces[{row}] is {tuple(triangles[row].tolist())}, but there are {count} vertices")
    return triangles.astype(np.uint32)


def _pixels(texture: ArrayLike) -> NDArray[np.uint8]:
    pixels = np.asarray(texture)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape or pixels.dtype != np.uint8:
        raise ValueError(f"texture: shape {pixels.shape} of {pixels.dtype}, expected (height, width, 3 or 4) of uint8")
    return pixels


def _matrix(transform: ArrayLike | None) -> dict[str, list[float]]:
    if transform is None:
        return {}
    given = np.asarray(transform, dtype=np.float64)
    if given.shape not in ((4, 4), (3, 4)) or not np.isfinite(given).all():
        raise ValueError(f"transform: shape {given.shape}, expected (4, 4) or (3, 4) of finite numbers")
    matrix = np.eye(4)
    matrix[: len(given)] = given
    if not np.array_equal(matrix[3], (0.0, 0.0, 0.0, 1.0)):
        raise ValueError(f"transform[3] is {tuple(matrix[3].tolist())}, expected (0, 0, 0, 1)")
    return {"matrix": matrix.T.reshape(-1).tolist()}  # by columns


def _look(position: ArrayLike, target: ArrayLike, up: ArrayLike) -> NDArray[np.float64]:
    """Return the transform of a camera or light, which looks along its -z."""
    away = np.subtract(position, target, dtype=np.float64)
    right = np.cross(np.asarray(up, dtype=np.float64), away)
    if not np.linalg.norm(right) > 0.0:
        places = ", ".join(str(tuple(np.asarray(place).tolist())) for place in (position, target, up))
        raise ValueError(f"position, target and up: {places}, expected a view that is not along up")
    z, x = away / np.linalg.norm(away), right / np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([x, np.cross(z, x), z, np.asarray(position, dtype=np.float64)])
    return matrix
