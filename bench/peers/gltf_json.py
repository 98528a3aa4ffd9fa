"""Reads and replaces the JSON of a .gltf, or of the first chunk of a .glb (glTF 2.0, 4.4)."""
# SPDX-License-Identifier: Apache-2.0
import json
import struct
from pathlib import Path

MAGIC, JSON_CHUNK, HEADERS_BYTES = b"glTF", 0x4E4F534A, 20


def read_json(path):
    text, _ = split_chunks(Path(path).read_bytes())
    return json.loads(text)


def write_json(path, document):
    """`path` exists; what else is in it stays."""
    text = json.dumps(document, ensure_ascii=False).encode("utf-8")
    data = path.read_bytes()
    if data.startswith(MAGIC):
        rest = split_chunks(data)[1]
        text += b" " * (-len(text) % 4)
        text = struct.pack("<4sIIII", MAGIC, 2, HEADERS_BYTES + len(text) + len(rest), len(text), JSON_CHUNK) + text + rest
    path.write_bytes(text)


def split_chunks(data):
    """(JSON, the further chunks) of a file."""
    if not data.startswith(MAGIC):
        return data, b""
    end = HEADERS_BYTES + struct.unpack_from("<I", data, 12)[0]
    return data[HEADERS_BYTES:end], data[end:]
