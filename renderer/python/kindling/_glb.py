# SPDX-License-Identifier: Apache-2.0
"""Writes arrays as a binary glTF file in memory (glTF 2.0 specification, sections 3.6 and 4.4)."""

from __future__ import annotations

import json
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["GlbWriter", "png"]

_COMPONENT = {"float32": 5126, "uint32": 5125}
_TYPE = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class GlbWriter:
    """A document of glTF, and the binary chunk that its accessors and images lie in."""

    def __init__(self) -> None:
        self.document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "Kindling for Python"}}
        self._chunk = bytearray()

    def append(self, kind: str, element: dict[str, Any]) -> int:
        """Append an element to one of the document's arrays; return its index."""
        elements: list[dict[str, Any]] = self.document.setdefault(kind, [])
        elements.append(element)
        return len(elements) - 1

    def use(self, extension: str) -> None:
        """Name an extension as used."""
        used: list[str] = self.document.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def accessor(self, values: NDArray[Any], *, bounds: bool = False) -> int:
        """Append (n,) or (n, 2 to 4) values, float32 or uint32; return the index of their accessor."""
        element = {
            "bufferView": self._view(np.ascontiguousarray(values).tobytes()),
            "componentType": _COMPONENT[values.dtype.name],
            "count": len(values),
            "type": _TYPE[1 if values.ndim == 1 else values.shape[1]],
        }
        if bounds:
            element["min"], element["max"] = values.min(axis=0).tolist(), values.max(axis=0).tolist()
        return self.append("accessors", element)

    def image(self, data: bytes) -> int:
        """Append the bytes of a PNG; return the index of a texture of it."""
        source = self.append("images", {"bufferView": self._view(data), "mimeType": "image/png"})
        return self.append("textures", {"source": source})

    def to_bytes(self) -> bytes:
        """Return the whole file."""
        if self._chunk:
            self.document["buffers"] = [{"byteLength": len(self._chunk)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + (8 + len(self._chunk) if self._chunk else 0)
        if size >= 1 << 32:
            raise ValueError(f"the scene takes {size} bytes, and a binary glTF file at most {(1 << 32) - 1}")
        parts = [struct.pack("<4sII", b"glTF", 2, size), struct.pack("<I4s", len(text), b"JSON"), text]
        if self._chunk:
            parts += [struct.pack("<I4s", len(self._chunk), b"BIN\0"), bytes(self._chunk)]
        return b"".join(parts)

    def _view(self, data: bytes) -> int:
        offset = len(self._chunk)
        self._chunk += data + b"\0" * (-len(data) % 4)
        return self.append("bufferViews", {"buffer": 0, "byteOffset": offset, "byteLength": len(data)})


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Return (height, width, 3 or 4) pixels as a PNG (ISO/IEC 15948)."""
    height, width, channels = pixels.shape
    rows = np.zeros((height, 1 + width * channels), np.uint8)  # each begins with the number of its filter: none
    rows[:, 1:] = pixels.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 1)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
