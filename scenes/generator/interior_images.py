# SPDX-License-Identifier: Apache-2.0
"""Images of the interior: wood, weave, leaves, a painting, and the view from the window."""
import math

from . import images
from .images import fractal, hash_unit, mix, noise, smooth, srgb


def floor_boards():
    """Oak boards, 8 across and two along: color, and roughness in G. Covers 1.6 m."""
    size, width = 256, 32
    light, dark = (0.42, 0.235, 0.115), (0.235, 0.118, 0.052)

    def board(x, y):
        lane = x // width
        along = (y + int(hash_unit(lane, 5) * size)) % size
        return lane, along // 128, min(x % width, width - 1 - x % width), min(along % 128, 127 - along % 128)

    def grain(x, y):
        lane, part, _, _ = board(x, y)
        shift = 37 * lane + 91 * part
        return 0.62 * fractal((x + shift) / 2.0, y / 32.0, 128, 8, 3, lane * 2 + part) + 0.38 * fractal(
            x / 16.0 + 0.8 * noise(x / 16.0, y / 32.0, 16, 8, 3), y / 64.0, 16, 4, 2, 7 + lane)

    def color(x, y):
        lane, part, side, end = board(x, y)
        tone = hash_unit(lane * 2 + part, 11)
        c = mix(dark, light, 0.30 + 0.55 * grain(x, y) + 0.35 * (tone - 0.5))
        gap = 0.35 if side < 1 or end < 1 else 0.85 if side < 2 else 1.0
        return srgb(tuple(v * gap for v in c))

    def roughness(x, y):
        _, _, side, end = board(x, y)
        value = 0.30 + 0.22 * grain(x, y) + (0.3 if side < 1 or end < 1 else 0.0)
        return (1.0, value, 0.0)

    return images.paint(size, size, 3, color, 40), images.paint(size, size, 3, roughness, 24)


def walnut():
    """Growth rings cut lengthwise; covers 0.6 m, grain along u."""
    light, dark = (0.30, 0.155, 0.075), (0.105, 0.048, 0.022)

    def color(x, y):
        warp = fractal(x / 64.0, y / 16.0, 2, 8, 3, 21)
        rings = 0.5 + 0.5 * math.sin((y / 16.0 + 1.6 * warp) * 2.0 * math.pi)
        fine = fractal(x / 16.0, y, 8, 128, 2, 22)
        return srgb(mix(dark, light, 0.15 + 0.45 * rings ** 1.6 + 0.4 * fine))

    return images.paint(128, 128, 3, color, 40)


def rug():
    """A woven border around diamonds; covers the whole rug."""
    width, height = 144, 96
    red, cream, navy, ochre = (0.20, 0.026, 0.022), (0.46, 0.38, 0.27), (0.022, 0.034, 0.080), (0.34, 0.17, 0.045)

    def color(x, y):
        edge = min(x, y, width - 1 - x, height - 1 - y)
        if edge < 2:
            c = navy
        elif edge < 5:
            c = cream
        elif edge < 13:
            along = x if min(y, height - 1 - y) == edge else y
            c = ochre if (along + 2 * abs(edge - 9)) % 16 < 8 else navy
        elif edge < 16:
            c = cream
        else:
            u, v = (x - 16) % 28 - 14, (y - 16) % 32 - 16
            ring = abs(u) * 8 / 7 + abs(v)
            c = navy if ring < 3 else cream if ring < 6 else ochre if ring < 8 else navy if 12 < ring < 14 else red
        weave = 0.82 + 0.18 * hash_unit(x, y, 31) if (x + y) % 2 else 0.70 + 0.18 * hash_unit(x, y, 32)
        return srgb(tuple(v * weave for v in c))

    return images.paint(width, height, 3, color, 32)


def painting():
    """Hills at dusk."""
    width, height = 96, 120
    sky_top, sky_low = (0.10, 0.16, 0.30), (0.85, 0.47, 0.24)
    layers = [(0.50, 0.10, (0.42, 0.26, 0.30)), (0.62, 0.08, (0.22, 0.17, 0.26)), (0.74, 0.07, (0.085, 0.10, 0.17)),
              (0.86, 0.05, (0.028, 0.045, 0.065))]

    def color(x, y):
        u, v = x / width, y / height
        c = mix(sky_top, sky_low, smooth(0.0, 0.62, v))
        distance = math.hypot((u - 0.64) * width, (v - 0.36) * height)
        c = mix((1.0, 0.78, 0.42), c, smooth(9.5, 11.0, distance))
        for i, (base, rise, tone) in enumerate(layers):
            ridge = base - rise * (fractal(u * 4.0, 0.5, 4, 1, 4, 41 + i) - 0.5) * 3.0
            c = mix(c, tone, smooth(ridge - 0.008, ridge + 0.008, v))
        stroke = 0.88 + 0.24 * fractal(x / 3.0, y / 12.0, 32, 10, 2, 50)
        return srgb(tuple(k * stroke for k in c))

    return images.paint(width, height, 3, color, 48)


def leaf():
    """One leaf, stem at the bottom; alpha cuts its outline. RGBA."""
    width, height = 48, 96

    def color(x, y):
        u, v = (x + 0.5) / width * 2.0 - 1.0, 1.0 - (y + 0.5) / height
        half = 0.92 * math.sin(math.pi * min(1.0, v * 1.02) ** 0.8) ** 0.85 * (1.0 - 0.25 * v)
        stem = v < 0.06 and abs(u) < 0.07
        veins = abs(((v - 0.55 * abs(u)) * 9.0) % 1.0 - 0.5)
        rib = smooth(0.03, 0.08, abs(u))
        tone = mix(0.75, 1.0, smooth(0.02, 0.12, veins)) * (0.85 + 0.3 * fractal(x / 8.0, y / 8.0, 6, 12, 3, 60))
        c = tuple(k * tone for k in mix((0.34, 0.48, 0.14), (0.10, 0.27, 0.055), rib))
        return srgb(c) + (1.0 if stem or abs(u) < half else 0.0,)

    return images.paint(width, height, 4, color, 48)


def outside():
    """Sky over trees, out of focus. Stored as sRGB, multiplied by a strength."""
    width, height = 96, 64

    def color(x, y):
        u, v = x / width, y / height
        c = mix((0.16, 0.30, 0.60), (0.50, 0.56, 0.64), smooth(0.0, 0.62, v))
        c = mix(c, (0.8, 0.8, 0.8), 0.8 * smooth(0.52, 0.78, fractal(u * 6.0, v * 8.0, 6, 8, 3, 70)))
        crown = 0.60 - 0.22 * (fractal(u * 7.0, 0.5, 7, 1, 3, 71) - 0.35)
        foliage = mix((0.020, 0.052, 0.012), (0.15, 0.22, 0.045), fractal(u * 24.0, v * 16.0, 24, 16, 2, 72) ** 1.5)
        c = mix(c, foliage, smooth(crown - 0.03, crown + 0.03, v))
        return srgb(mix(c, (0.085, 0.13, 0.03), smooth(0.86, 0.92, v)))

    return images.paint(width, height, 3, color, 64)


def lamp_shade():
    """Backlit linen: brightest at the height of the bulb, darker along the seams."""
    def color(x, y):
        v = (y + 0.5) / 32
        glow = 0.30 + 0.70 * math.exp(-((v - 0.58) / 0.30) ** 2)
        thread = 0.93 + 0.07 * hash_unit(x, y, 80)
        return srgb(tuple(k * glow * thread for k in (1.0, 0.66 + 0.08 * glow, 0.36 + 0.12 * glow)))

    return images.paint(32, 32, 3, color, 64)


def _cells(x, y, period, seed):
    """Distances to the two nearest of randomly placed points, one in each grid cell."""
    ix, iy = math.floor(x), math.floor(y)
    distances = []
    for j in (-1, 0, 1):
        for i in (-1, 0, 1):
            a, b = (ix + i) % period, (iy + j) % period
            px, py = ix + i + hash_unit(a, b, seed), iy + j + hash_unit(a, b, seed + 1)
            distances.append(math.hypot(px - x, py - y))
    distances.sort()
    return distances[0], distances[1]


def hammered():
    """Round dents of a hammer."""
    return images.normal_map(96, 96, lambda x, y: min(_cells(x / 12.0, y / 12.0, 8, 90)[0], 1.0) ** 2, 2.2)


def peel():
    """Orange peel."""
    return images.normal_map(48, 48, lambda x, y: smooth(0.05, 0.5, _cells(x / 3.0, y / 3.0, 16, 95)[0]), 0.5)


def plaster():
    """Trowel marks on a wall."""
    return images.normal_map(96, 96, lambda x, y: fractal(x / 12.0, y / 12.0, 8, 8, 4, 100), 0.9)
