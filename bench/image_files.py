"""Reads EXR files as Kindling writes them, and PFM files, where oiiotool is not installed."""
# SPDX-License-Identifier: Apache-2.0
import array
import itertools
import re
import struct
import sys
import zlib

NO_COMPRESSION, ZIPS, ZIP = 0, 2, 3
ROWS_OF_A_CHUNK = {NO_COMPRESSION: 1, ZIPS: 1, ZIP: 16}
HALF, FLOAT = 1, 2


class Unsupported(ValueError):
    """The file is of a kind that this module does not read."""


def read(path):
    """(width, height, channels, values) of a file: floats, interleaved, rows from the top, linear. It is PFM, or EXR of one part, in
    scanlines, uncompressed or compressed with ZIP, whose R, G, B and A (if it has that) are floats or halves."""
    data = path.read_bytes()
    try:
        return read_pfm(data) if data.startswith(b"PF\n") else read_exr(data)
    except Unsupported as error:
        raise Unsupported(f"{path}: {error}; it needs oiiotool (Debian: openimageio-tools)") from error


def read_pfm(data):
    """Three channels, rows from the bottom; a negative scale means little-endian floats."""
    header = re.match(rb"PF\n(\d+) (\d+)\n(\S+)\n", data)
    if not header or float(header[3]) >= 0.0:
        raise Unsupported("a PFM file of big-endian floats, or broken")
    width, height = int(header[1]), int(header[2])
    stored = floats(data[header.end():header.end() + 12 * width * height], FLOAT)
    if len(stored) != 3 * width * height:
        raise Unsupported("a PFM file that ends early")
    values = array.array("f")
    for row in range(height - 1, -1, -1):
        values.extend(stored[3 * width * row:3 * width * (row + 1)])
    return width, height, 3, values


def read_exr(data):
    if not data.startswith(b"\x76\x2f\x31\x01"):
        raise Unsupported("neither EXR nor PFM")
    version, = struct.unpack_from("<I", data, 4)
    if version & 0x1A00:
        raise Unsupported("an EXR file of tiles, of deep data or of several parts")
    header, at = exr_header(data)
    compression = header["compression"][0]
    if compression not in ROWS_OF_A_CHUNK:
        raise Unsupported(f"compression {compression} of EXR")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height, rows_of_a_chunk = x1 - x0 + 1, y1 - y0 + 1, ROWS_OF_A_CHUNK[compression]
    channels = [(name, kind, width * (2 if kind == HALF else 4)) for name, kind in exr_channels(header["channels"])]
    names = [name for name, _, _ in channels]
    wanted = {name: place for place, name in enumerate(name for name in "RGBA" if name in names)}
    if not {"R", "G", "B"} <= set(wanted):
        raise Unsupported("an EXR file without R, G and B")
    count, values = len(wanted), array.array("f", bytes(4 * len(wanted) * width * height))
    for chunk, offset in enumerate(struct.unpack_from(f"<{-(-height // rows_of_a_chunk)}Q", data, at)):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(rows_of_a_chunk, height - chunk * rows_of_a_chunk)
        raw = data[offset + 8:offset + 8 + size]
        if size < rows * sum(bytes_of_row for _, _, bytes_of_row in channels):  # chunks that would grow are stored uncompressed
            raw = unpacked(zlib.decompress(raw))
        at = 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind, bytes_of_row in channels:
                if name in wanted:
                    first = row * width * count + wanted[name]
                    values[first:(row + 1) * width * count:count] = floats(raw[at:at + bytes_of_row], kind)
                at += bytes_of_row
    return width, height, count, values


def exr_header(data):
    """The attributes by name, as bytes, and the place behind them."""
    attributes, at = {}, 8
    while data[at] != 0:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        size, = struct.unpack_from("<i", data, type_end + 1)
        attributes[data[at:name_end].decode("latin-1")] = data[type_end + 5:type_end + 5 + size]
        at = type_end + 5 + size
    return attributes, at + 1


def exr_channels(data):
    """(name, kind) in the order of the file."""
    at = 0
    while data[at] != 0:
        end = data.index(0, at)
        kind, = struct.unpack_from("<i", data, end + 1)
        yield data[at:end].decode("latin-1"), kind
        at = end + 17


def unpacked(data):
    """The bytes before the predictor and the interleaving of EXR's ZIP: differences plus 128; even bytes first, then odd ones."""
    data = bytes(value & 255 for value in itertools.accumulate(data, lambda sum, difference: sum + difference - 128))
    result, half = bytearray(len(data)), (len(data) + 1) // 2
    result[0::2], result[1::2] = data[:half], data[half:]
    return bytes(result)


def floats(data, kind):
    if kind == HALF:
        return array.array("f", struct.unpack(f"<{len(data) // 2}e", data))
    if kind != FLOAT:
        raise Unsupported("integers in a channel of color")
    values = array.array("f", data)
    if sys.byteorder == "big":
        values.byteswap()
    return values
