# SPDX-License-Identifier: Apache-2.0
"""Procedural images as PNG: value noise, wood, weave, leaves."""
import math
import struct
import zlib


def png(width, height, channels, rows):
    """8-bit PNG from rows of bytes, top row first. Each row uses the filter with the smallest differences."""
    previous = bytes(width * channels)
    body = bytearray()
    for row in rows:
        best = None
        for kind in range(5):
            line = bytearray(len(row))
            for i, value in enumerate(row):
                left = row[i - channels] if i >= channels else 0
                up = previous[i]
                corner = previous[i - channels] if i >= channels else 0
                if kind == 4:
                    p = left + up - corner
                    a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                    guess = left if a <= b and a <= c else up if b <= c else corner
                else:
                    guess = (0, left, up, (left + up) // 2)[kind]
                line[i] = (value - guess) & 255
            cost = sum(min(v, 256 - v) for v in line)
            if best is None or cost < best[0]:
                best = (cost, kind, line)
        body.append(best[1])
        body.extend(best[2])
        previous = row

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(body), 9)) + chunk(b"IEND", b"")


def paint(width, height, channels, pixel, levels=256):
    """An image from pixel(x, y) -> stored values in [0, 1] (no encoding is applied); fewer levels make smaller files."""
    rows = []
    for y in range(height):
        row = bytearray()
        for x in range(width):
            for value in pixel(x, y):
                step = round(min(max(value, 0.0), 1.0) * (levels - 1))
                row.append(step * 255 // (levels - 1))
        rows.append(bytes(row))
    return png(width, height, channels, rows)


def to_srgb(value):
    value = min(max(value, 0.0), 1.0)
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


def srgb(color):
    return tuple(to_srgb(c) for c in color)


def mix(a, b, t):
    if isinstance(a, tuple):
        return tuple(x + (y - x) * t for x, y in zip(a, b))
    return a + (b - a) * t


def smooth(low, high, x):
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def hash_unit(x, y, seed=0):
    """Uniform in [0, 1) from integers: a 32-bit finalizer, the same everywhere."""
    h = (x * 0x9E3779B1 ^ y * 0x85EBCA77 ^ seed * 0xC2B2AE3D) & 0xFFFFFFFF
    h ^= h >> 16
    h = h * 0x7FEB352D & 0xFFFFFFFF
    h ^= h >> 15
    h = h * 0x846CA68B & 0xFFFFFFFF
    h ^= h >> 16
    return h / 4294967296.0


def noise(x, y, period_x, period_y, seed=0):
    """Value noise in [0, 1] with these periods."""
    ix, iy = math.floor(x), math.floor(y)
    fx, fy = x - ix, y - iy
    fx, fy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
    corner = lambda i, j: hash_unit((ix + i) % period_x, (iy + j) % period_y, seed)
    return mix(mix(corner(0, 0), corner(1, 0), fx), mix(corner(0, 1), corner(1, 1), fx), fy)


def fractal(x, y, period_x, period_y, octaves, seed=0):
    total, weight, scale = 0.0, 0.0, 1
    for octave in range(octaves):
        amplitude = 0.5 ** octave
        total += amplitude * noise(x * scale, y * scale, period_x * scale, period_y * scale, seed + octave)
        weight += amplitude
        scale *= 2
    return total / weight


def normal_map(width, height, level, strength):
    """A normal map from the periodic height level(x, y) in [0, 1]; +y up as in glTF."""
    grid = [[level(x, y) for x in range(width)] for y in range(height)]

    def pixel(x, y):
        dx = (grid[y][(x + 1) % width] - grid[y][x - 1]) * strength
        dy = (grid[y - 1][x] - grid[(y + 1) % height][x]) * strength
        length = math.sqrt(dx * dx + dy * dy + 1.0)
        return (-dx / length * 0.5 + 0.5, -dy / length * 0.5 + 0.5, 1.0 / length * 0.5 + 0.5)

    return paint(width, height, 3, pixel)
