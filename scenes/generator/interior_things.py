# SPDX-License-Identifier: Apache-2.0
"""Objects of the interior as meshes, each on y = 0 around the origin."""
import math

from .images import hash_unit
from .shapes import beveled_box, box, joined, lathe, outward, sheet, sphere, torus, tube


def arc(centre, radius, start_deg, end_deg, steps, plane="xy"):
    """Points on a circle, for tubes."""
    points = []
    for i in range(steps + 1):
        a = math.radians(start_deg + (end_deg - start_deg) * i / steps)
        c, s = radius * math.cos(a), radius * math.sin(a)
        points.append((centre[0] + c, centre[1] + s, centre[2]) if plane == "xy" else (centre[0] + c, centre[1], centre[2] + s))
    return points


def curve(points, steps):
    """Catmull-Rom through the points."""
    result = []
    for i in range(len(points) - 1):
        p = [points[max(i - 1, 0)], points[i], points[i + 1], points[min(i + 2, len(points) - 1)]]
        for s in range(steps + (1 if i == len(points) - 2 else 0)):
            t = s / steps
            w = (-0.5 * t ** 3 + t ** 2 - 0.5 * t, 1.5 * t ** 3 - 2.5 * t ** 2 + 1, -1.5 * t ** 3 + 2 * t ** 2 + 0.5 * t,
                 0.5 * t ** 3 - 0.5 * t ** 2)
            result.append(tuple(sum(w[k] * p[k][c] for k in range(4)) for c in range(len(points[0]))))
    return result


def table(width, depth, height):
    """Top, apron and four tapered legs; the grain runs along the top."""
    k = 1.0 / 0.6
    w, d, t = width / 2, depth / 2, 0.038
    parts = [beveled_box((-w, height - t, -d), (w, height, d), 0.006, k)]
    for z in (-d + 0.07, d - 0.09):
        parts.append(box((-w + 0.12, height - t - 0.09, z), (w - 0.12, height - t, z + 0.02), k))
    for x in (-w + 0.10, w - 0.12):
        parts.append(box((x, height - t - 0.09, -d + 0.09), (x + 0.02, height - t, d - 0.09), k))
    leg = lathe([(0.0, 0.0), (0.020, 0.0), (0.022, 0.01), (0.034, height - 0.16), (0.036, height - t)], 12, (0.2, 1.1))
    for x in (-w + 0.10, w - 0.10):
        for z in (-d + 0.09, d - 0.09):
            parts.append(leg.moved(x, 0, z))
    return joined(parts)


def chair():
    """Turned legs, a round seat, a bent back."""
    parts = []
    seat = lathe([(0.0, 0.435), (0.175, 0.435), (0.195, 0.445), (0.20, 0.458), (0.19, 0.468), (0.13, 0.464), (0.0, 0.460)], 28)
    parts.append(seat)
    for x in (-1, 1):
        parts.append(tube([(0.17 * x, 0.0, 0.17), (0.125 * x, 0.45, 0.125)], [0.013, 0.019], 8))
        parts.append(tube(curve([(0.16 * x, 0.0, -0.20), (0.135 * x, 0.44, -0.15), (0.165 * x, 0.72, -0.20), (0.15 * x, 0.86, -0.245)], 4),
                          0.015, 8))
    for y, z in ((0.86, -0.245), (0.66, -0.195)):
        parts.append(tube(curve([(-0.158, y, z), (-0.08, y + 0.035, z - 0.035), (0.08, y + 0.035, z - 0.035), (0.158, y, z)], 5), 0.014, 8))
    parts.append(torus(0.145, 0.008, 28, 6).moved(y=0.22))
    for x in (-0.055, 0.0, 0.055):
        parts.append(tube([(x, 0.69, -0.228), (x, 0.885, -0.275)], 0.007, 6))
    return joined(parts)


def kettle():
    """Body and lid, spout, handle: (copper, dark) meshes. 0.2 m high."""
    body = lathe(curve([(0.0, 0.0), (0.085, 0.0), (0.100, 0.012), (0.112, 0.05), (0.102, 0.095), (0.070, 0.128), (0.052, 0.137)], 4)[1:]
                 + [(0.056, 0.142), (0.056, 0.148), (0.048, 0.152)], 36, (7.0, 3.0))
    lid = lathe(curve([(0.050, 0.150), (0.040, 0.160), (0.016, 0.168), (0.008, 0.172)], 3) + [(0.0, 0.173)], 28, (4.0, 1.0))
    spout = tube(curve([(0.085, 0.045, 0), (0.135, 0.072, 0), (0.150, 0.120, 0), (0.182, 0.146, 0)], 5),
                 [0.026 - 0.0010 * i for i in range(16)], 12, caps=False)
    spout.uvs = [(u * 2.0, v * 2.0) for u, v in spout.uvs]
    brackets = [tube([(x, 0.128, 0), (x * 1.12, 0.215, 0)], 0.005, 6) for x in (-0.062, 0.062)]
    copper = joined([body, lid, spout] + brackets)
    dark = joined([tube(arc((0, 0.205, 0), 0.071, 8, 172, 12), 0.010, 8), sphere(0.012, 12, 8).moved(y=0.184)])
    return copper, dark


def bowl(radius, height):
    """A thin wall with a foot; inside and outside."""
    r, h = radius, height
    outer = curve([(0.38 * r, 0.0), (0.42 * r, 0.08 * h), (0.78 * r, 0.45 * h), (r, h)], 5)
    inner = curve([(0.965 * r, h), (0.74 * r, 0.49 * h), (0.36 * r, 0.16 * h), (0.0, 0.13 * h)], 5)
    return lathe([(0.0, 0.0)] + outer + inner, 36)


def vase():
    """A long neck on a round belly. 0.27 m high."""
    outer = curve([(0.045, 0.0), (0.052, 0.008), (0.083, 0.075), (0.062, 0.145), (0.027, 0.195), (0.025, 0.235), (0.037, 0.270)], 5)
    inner = curve([(0.033, 0.270), (0.021, 0.235), (0.022, 0.195)], 3)
    return lathe([(0.0, 0.0)] + outer + inner + [(0.0, 0.19)], 32)


def cup():
    """Cup and saucer."""
    wall = [(0.0, 0.012), (0.020, 0.012)] + curve([(0.022, 0.014), (0.034, 0.032), (0.040, 0.062), (0.042, 0.078)], 4)
    inside = curve([(0.039, 0.078), (0.037, 0.060), (0.030, 0.033), (0.0, 0.022)], 4)
    saucer = [(0.0, 0.0), (0.040, 0.0), (0.044, 0.004), (0.074, 0.016), (0.075, 0.018), (0.044, 0.010), (0.0, 0.009)]
    handle = tube(arc((0.044, 0.045, 0), 0.020, -75, 80, 10), 0.0042, 8)
    return joined([lathe(wall + inside, 32), lathe(saucer, 36), handle])


def tea():
    return lathe([(0.0372, 0.066), (0.0, 0.0662)], 28)


def candlestick():
    """(brass, wax, flame): 0.36 m with the candle."""
    brass = lathe([(0.0, 0.0), (0.058, 0.0), (0.060, 0.006)] + curve([(0.052, 0.014), (0.022, 0.024), (0.010, 0.045), (0.010, 0.075)], 4)
                  + curve([(0.010, 0.075), (0.019, 0.088), (0.010, 0.101), (0.010, 0.135), (0.016, 0.150), (0.034, 0.160)], 3)
                  + [(0.035, 0.163), (0.017, 0.165), (0.016, 0.185), (0.012, 0.185)], 28)
    wax = lathe([(0.0110, 0.170), (0.0108, 0.315), (0.0095, 0.318), (0.004, 0.314), (0.0, 0.314)], 16)
    flame = lathe(curve([(0.0, 0.320), (0.0052, 0.329), (0.0048, 0.340), (0.0, 0.360)], 4), 10)
    return brass, wax, flame


def book(width, depth, height):
    """(cover, pages), lying on its back; the spine is at -x."""
    t = 0.0028
    w, d = width / 2, depth / 2
    cover = joined([beveled_box((-w, 0.0, -d), (w, t, d), 0.001), beveled_box((-w, height - t, -d), (w, height, d), 0.001),
                    beveled_box((-w, 0.0, -d), (-w + t, height, d), 0.001)])
    return cover, box((-w + t, t, -d + 0.005), (w - 0.005, height - t, d - 0.005))


def pendant(drop):
    """(dome, diffuser) of a lamp whose rim is at y = 0; the cord has length `drop`. The diffuser closes the dome: indirect
    light from inside would be noisy."""
    outline = curve([(0.020, 0.185), (0.035, 0.172), (0.075, 0.135), (0.150, 0.060), (0.172, 0.0)], 5)
    dome = joined([lathe([(0.160, 0.004), (0.166, 0.0)] + outline[::-1] + [(0.020, 0.215), (0.008, 0.222), (0.0, 0.222)], 36),
                   tube([(0, 0.215, 0), (0, drop, 0)], 0.0035, 6)])
    return dome, lathe([(0.0, 0.004), (0.160, 0.004)], 36)


def table_lamp():
    """(base, fitting, shade): 0.55 m high."""
    base = lathe([(0.0, 0.0), (0.062, 0.0), (0.066, 0.008)] + curve([(0.060, 0.016), (0.105, 0.085), (0.098, 0.150), (0.040, 0.215), (0.024, 0.235)], 5)
                 + [(0.020, 0.240), (0.0, 0.241)], 36)
    fitting = lathe([(0.016, 0.240), (0.016, 0.262), (0.007, 0.266), (0.007, 0.330), (0.0, 0.330)], 16)
    shade = lathe([(0.165, 0.285), (0.115, 0.520)], 40)
    return base, fitting, shade


def plant_pot():
    """(pot, soil): 0.34 m high."""
    pot = lathe([(0.0, 0.0), (0.115, 0.0), (0.120, 0.006), (0.165, 0.300), (0.176, 0.302), (0.180, 0.312), (0.180, 0.338), (0.174, 0.342),
                 (0.160, 0.338), (0.158, 0.280)], 36)
    return pot, lathe([(0.160, 0.300), (0.08, 0.312), (0.0, 0.310)], 24)


def leaf_blade():
    """Unit leaf: stem at the origin, 1 long along +z, 0.5 wide, arched and folded a little."""
    def shape(u, v):
        x = (u - 0.5) * 0.5
        return (x, 0.16 * math.sin(math.pi * 0.8 * v) - 0.10 * v * v + 0.25 * abs(x) * (1 - 0.3 * v), v)

    # v of the image runs from the tip (top) to the stem, along -z as seen from above.
    mesh = sheet(lambda u, v: shape(1.0 - u, v), 4, 5)
    mesh.normals = [tuple(-c for c in n) if n[1] < 0 else n for n in mesh.normals]
    for t in range(0, len(mesh.indices), 3):
        mesh.indices[t + 1], mesh.indices[t + 2] = mesh.indices[t + 2], mesh.indices[t + 1]
    return outward(mesh)


def stalks(count, height, spread, seed):
    """(tube mesh, leaf places): each place is (point, heading_deg, pitch_deg, size)."""
    meshes, places = [], []
    for i in range(count):
        heading = 2 * math.pi * (i + 0.35 * hash_unit(i, 1, seed)) / count
        lean = spread * (0.35 + 0.65 * hash_unit(i, 2, seed))
        tall = height * (0.72 + 0.28 * hash_unit(i, 3, seed))
        way = curve([(0, 0, 0), (0.25 * lean * math.cos(heading), 0.45 * tall, 0.25 * lean * math.sin(heading)),
                     (lean * math.cos(heading), tall, lean * math.sin(heading))], 5)
        meshes.append(tube(way, [0.009 - 0.0006 * k for k in range(len(way))], 6))
        for k in range(3, len(way)):
            for side in range(2 if k > 4 else 1):
                turn = math.degrees(heading) + 137.5 * (k + 0.5 * side) + 40 * hash_unit(i, k + 7 * side, seed)
                pitch = 12 + 38 * hash_unit(i, 20 + k + side, seed)
                size = 0.20 + 0.13 * hash_unit(i, 40 + k + side, seed)
                places.append((way[k], turn, pitch, size))
        places.append((way[-1], -math.degrees(heading) + 90, 62, 0.22))
    return joined(meshes), places


def curtain(width, height, folds, seed):
    """Hangs from y = height to y = 0 along x, folds towards +-z."""
    def shape(u, v):
        gather = 1.0 - 0.10 * math.sin(math.pi * v) ** 2
        depth = 0.034 + 0.008 * math.sin(5.0 * u + seed)
        z = depth * math.sin(2 * math.pi * folds * u + 0.7 * math.sin(3.0 * v + seed)) * (0.75 + 0.25 * v)
        return ((u - 0.5) * width * gather, v * height, z)

    return sheet(shape, folds * 9, 6)


def window(width, height, depth):
    """Frame, two casements with a cross each, and a sill; in the plane z = 0, opening from (0, 0) to (width, height)."""
    b = 0.045
    s = 0.005  # offset of the frame into the opening, so that it shares no faces with the wall
    parts = [
        box((-b, -b, -depth), (s, height + b, 0.02)), box((width - s, -b, -depth), (width + b, height + b, 0.02)),
        box((s, height - s, -depth), (width - s, height + b, 0.02)), box((s, -b, -depth), (width - s, s, 0.02)),
        beveled_box((-0.10, -b - 0.03, -0.01), (width + 0.10, -b, 0.13), 0.006),
    ]
    t = 0.022
    for x in (0.0, width / 2):
        x0, x1 = x, x + width / 2
        for low, high in (((x0, 0, -0.06), (x0 + t * 1.6, height, -0.02)), ((x1 - t * 1.6, 0, -0.06), (x1, height, -0.02)),
                          ((x0, 0, -0.06), (x1, t * 2, -0.02)), ((x0, height - t * 2, -0.06), (x1, height, -0.02)),
                          ((x0, height * 0.62 - t / 2, -0.05), (x1, height * 0.62 + t / 2, -0.03))):
            parts.append(box(low, high))
    return joined(parts)


def sideboard(width, depth, height):
    """(carcass, doors, knobs)."""
    k = 1.0 / 0.6
    w = width / 2
    legs = [lathe([(0.0, 0.0), (0.012, 0.0), (0.020, 0.15)], 10, (0.2, 0.3)).moved(x, 0, z) for x in (-w + 0.08, w - 0.08) for z in (0.06, depth - 0.06)]
    carcass = joined([beveled_box((-w, 0.15, 0.0), (w, height, depth), 0.005, k)] + legs)
    doors, knobs = [], []
    for i in range(3):
        x0 = -w + 0.02 + i * (width - 0.04) / 3
        x1 = x0 + (width - 0.04) / 3 - 0.008
        doors.append(beveled_box((x0, 0.18, depth - 0.002), (x1, height - 0.03, depth + 0.014), 0.004, k))
        knobs.append(sphere(0.012, 12, 8).moved((x1 - 0.04) if i < 2 else (x0 + 0.04), 0.55 * height + 0.08, depth + 0.024))
    return carcass, joined(doors), joined(knobs)


def frame(width, height, border, depth):
    """A picture frame around a width x height image in the plane z = depth / 2; four bars that look mitered."""
    w, h, b = width / 2, height / 2, border
    return joined([beveled_box((-w - b, h, 0), (w + b, h + b, depth), 0.008), beveled_box((-w - b, -h - b, 0), (w + b, -h, depth), 0.008),
                   beveled_box((-w - b, -h, 0), (-w, h, depth), 0.008), beveled_box((w, -h, 0), (w + b, h, depth), 0.008)])
