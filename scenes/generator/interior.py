# SPDX-License-Identifier: Apache-2.0
"""A room with low sun: table, plant, lamps and copper.

It is the image of the README and of cmake/demo.sh.

Light: a directional sun through the window on the left; a wide panel outside as sky, with a hole for the sun's beam; a pendant, a table lamp and a candle.
"""
import math

from . import interior_images as images
from . import interior_things as things
from .gltf import Gltf, look_at, normalize
from .images import hash_unit
from .shapes import beveled_box, box, joined, quad, sphere

# The room in meters; the floor is y = 0, the camera looks towards -z, the window is in the wall at
# x = LEFT.
LEFT, RIGHT, BACK, FRONT, CEILING = -2.2, 2.4, -2.2, 3.0, 2.75
WINDOW_LOW, WINDOW_HIGH, WINDOW_BACK, WINDOW_FRONT = 0.90, 2.20, -1.40, 0.10
SUN = normalize((0.86, -0.45, 0.20))
PANEL_DISTANCE = 4.0
TABLE = (-0.20, -0.35)  # x, z
TABLE_HEIGHT = 0.75


class _Room:
    """Materials by name, and short calls that place objects."""

    def __init__(self):
        self.g = Gltf()
        self.roots = []
        self.material = {}
        self.library = {}  # primitives shared by several objects

    def define(self, name, *args, **fields):
        self.material[name] = self.g.add_material(name, *args, **fields)

    def place(self, name, parts, at=(0, 0, 0), turn_deg=0.0, **fields):
        """parts: (mesh, material name) pairs; a mesh may be the name of one in the library."""
        textured = {"oak floor", "walnut", "rug", "painting", "copper", "orange peel", "plaster", "outside", "shade"}
        primitives = []
        for mesh, material in parts:
            if isinstance(mesh, str):
                primitives.append({**self.library[mesh], "material": self.material[material]})
            else:
                primitives.append(self.g.add_primitive(mesh if material in textured else mesh.without_uvs(), self.material[material]))
        half = math.radians(turn_deg) / 2
        rotation = [0, math.sin(half), 0, math.cos(half)] if turn_deg else None
        mesh = self.g.add("meshes", {"name": name, "primitives": primitives})
        node = self.g.add_node(name, mesh=mesh, translation=list(at) if any(at) else None,
                               rotation=rotation, **fields)
        self.roots.append(node)
        return mesh


def _materials(room):
    g = room.g
    color, rough = images.floor_boards()
    boards = g.add_texture("oak floor", color)
    board_roughness = g.add_texture("oak floor roughness", rough)
    walnut = g.add_texture("walnut", images.walnut())
    hammered = {"index": g.add_texture("hammered", images.hammered())}
    peel = {"index": g.add_texture("peel", images.peel())}
    plaster = {"index": g.add_texture("plaster", images.plaster()), "scale": 0.5}
    room.define("oak floor", boards, 0.0, 1.0, pbr={"metallicRoughnessTexture": {"index": board_roughness}})
    room.define("walnut", walnut, 0.0, 0.34)
    room.define("dark wood", (0.060, 0.028, 0.014), 0.0, 0.38)
    room.define("rug", g.add_texture("rug", images.rug(), 33071), 0.0, 0.95)
    room.define("painting", g.add_texture("painting", images.painting(), 33071), 0.0, 0.6)
    room.define("plaster", (0.74, 0.67, 0.56), 0.0, 0.92, normalTexture=plaster)
    room.define("white paint", (0.78, 0.76, 0.72), 0.0, 0.45)
    room.define("ceiling", (0.80, 0.78, 0.74), 0.0, 0.95)
    room.define("linen", (0.74, 0.68, 0.58), 0.0, 0.95, doubleSided=True)
    room.define("copper", (0.93, 0.56, 0.42), 1.0, 0.30, normalTexture=hammered)
    room.define("brass", (0.87, 0.62, 0.28), 1.0, 0.34)
    room.define("black", (0.018, 0.016, 0.015), 0.0, 0.35)
    room.define("teal glaze", (0.008, 0.105, 0.120), 0.0, 0.22)
    room.define("porcelain", (0.80, 0.79, 0.76), 0.0, 0.26)
    room.define("stoneware", (0.36, 0.40, 0.42), 0.0, 0.30)
    room.define("terracotta", (0.44, 0.17, 0.085), 0.0, 0.80)
    room.define("soil", (0.035, 0.022, 0.014), 0.0, 1.0)
    room.define("stalk", (0.10, 0.115, 0.035), 0.0, 0.7)
    room.define("orange peel", (0.82, 0.26, 0.018), 0.0, 0.33, normalTexture=peel)
    room.define("apple", (0.46, 0.022, 0.016), 0.0, 0.30)
    room.define("lemon", (0.83, 0.60, 0.045), 0.0, 0.36)
    room.define("tea", (0.16, 0.045, 0.008), 0.0, 0.22)
    room.define("wax", (0.82, 0.76, 0.62), 0.0, 0.5)
    room.define("paper", (0.74, 0.68, 0.55), 0.0, 0.9)
    room.define("enamel", (0.012, 0.052, 0.036), 0.0, 0.26)
    for name, c in (("red cloth", (0.32, 0.030, 0.024)), ("blue cloth", (0.030, 0.060, 0.16)), ("ochre cloth", (0.50, 0.28, 0.055)),
                    ("green cloth", (0.035, 0.10, 0.052))):
        room.define(name, c, 0.0, 0.6)
    room.define("leaf", g.add_texture("leaf", images.leaf(), 33071), 0.0, 0.36, alphaMode="MASK", doubleSided=True)
    room.define("glow", (0, 0, 0), emission=(11.0, 7.2, 3.7))
    shade = g.add_texture("lamp shade", images.lamp_shade(), 33071)
    room.define("shade", (0.7, 0.6, 0.45), 0.0, 0.9, emission=(9.0, 9.0, 9.0), emissiveTexture={"index": shade})
    sky = g.add_texture("outside", images.outside(), 33071)
    room.define("overcast", (0, 0, 0), emission=(4.5, 4.7, 5.0))
    room.define("outside", (0, 0, 0), emission=(6.0, 6.0, 6.0), emissiveTexture={"index": sky})


def _walls(room):
    depth, width = FRONT - BACK, RIGHT - LEFT
    room.place("floor", [(quad((LEFT, 0, FRONT), (width, 0, 0), (0, 0, -depth), (width / 1.6, depth / 1.6)), "oak floor")])
    room.place("ceiling", [(quad((LEFT, CEILING, BACK), (width, 0, 0), (0, 0, depth)), "ceiling")])
    wall = lambda corner, a, b, w, h: quad(corner, a, b, (w / 1.1, h / 1.1))
    h = CEILING
    pieces = [wall((LEFT, 0, BACK), (width, 0, 0), (0, h, 0), width, h), wall((RIGHT, 0, FRONT), (-width, 0, 0), (0, h, 0), width, h),
              wall((RIGHT, 0, BACK), (0, 0, depth), (0, h, 0), depth, h)]
    # The left wall leaves the window open; seen from inside, front is on the left.
    strips = [((FRONT, WINDOW_FRONT), (0, h)), ((WINDOW_BACK, BACK), (0, h)), ((WINDOW_FRONT, WINDOW_BACK), (0, WINDOW_LOW)),
              ((WINDOW_FRONT, WINDOW_BACK), (WINDOW_HIGH, h))]
    for (z0, z1), (y0, y1) in strips:
        pieces.append(wall((LEFT, y0, z0), (0, 0, z1 - z0), (0, y1 - y0, 0), z0 - z1, y1 - y0))
    # The thickness of the wall around the window.
    t, y0, y1, z0, z1 = 0.22, WINDOW_LOW, WINDOW_HIGH, WINDOW_BACK, WINDOW_FRONT
    reveal = [wall((LEFT - t, y0, z1), (t, 0, 0), (0, 0, z0 - z1), t, 1.5), wall((LEFT, y1, z1), (-t, 0, 0), (0, 0, z0 - z1), t, 1.5),
              wall((LEFT, y0, z1), (-t, 0, 0), (0, y1 - y0, 0), t, 1.3), wall((LEFT - t, y0, z0), (t, 0, 0), (0, y1 - y0, 0), t, 1.3)]
    room.place("walls", [(joined(pieces + reveal), "plaster")])
    s, sh = 0.016, 0.11
    skirting = [beveled_box((LEFT, 0, BACK), (RIGHT, sh, BACK + s), 0.006), beveled_box((LEFT, 0, BACK), (LEFT + s, sh, FRONT), 0.006),
                beveled_box((RIGHT - s, 0, BACK), (RIGHT, sh, FRONT), 0.006), beveled_box((LEFT, 0, FRONT - s), (RIGHT, sh, FRONT), 0.006)]
    room.place("skirting", [(joined(skirting), "white paint")])
    beams = [box((LEFT, CEILING - 0.16, z), (RIGHT, CEILING, z + 0.14), 1 / 0.6) for z in (-1.5, -0.1, 1.3)]
    room.place("beams", [(joined(beams), "walnut")])
    room.place("window", [(things.window(z1 - z0, y1 - y0, 0.20), "white paint")], (LEFT - 0.02, y0, z1), 90)
    rod = joined([box((LEFT + 0.075, y1 + 0.105, z0 - 0.42), (LEFT + 0.095, y1 + 0.125, z1 + 0.42)),
                  sphere(0.026, 12, 8).moved(LEFT + 0.085, y1 + 0.115, z0 - 0.43), sphere(0.026, 12, 8).moved(LEFT + 0.085, y1 + 0.115, z1 + 0.43)])
    room.place("curtain rod", [(rod, "brass")])
    for name, z, seed in (("curtain back", z0 - 0.16, 3), ("curtain front", z1 + 0.19, 5)):
        room.place(name, [(things.curtain(0.46, y1 + 0.11, 6, seed), "linen")], (LEFT + 0.085, 0.005, z), 90)


def _outside(room):
    """Four strips around the hole for the sun; one image over all of them."""
    x = LEFT - PANEL_DISTANCE
    k = PANEL_DISTANCE / SUN[0]
    margin = 0.12
    hole_low, hole_high = WINDOW_LOW - SUN[1] * k - margin, WINDOW_HIGH - SUN[1] * k + margin
    hole_back, hole_front = WINDOW_BACK - SUN[2] * k - margin, WINDOW_FRONT - SUN[2] * k + margin
    low, high, back, front = -1.0, 6.0, -7.0, 3.0
    strips = [((front, back), (low, hole_low)), ((front, back), (hole_high, high)), ((front, hole_front), (hole_low, hole_high)),
              ((hole_back, back), (hole_low, hole_high))]
    pieces = [quad((x, y0, z0), (0, 0, z1 - z0), (0, y1 - y0, 0)) for (z0, z1), (y0, y1) in strips]
    panel = joined(pieces).with_uvs(lambda p: ((front - p[2]) / (front - back), (high - p[1]) / (high - low)))
    room.place("sky and garden", [(panel, "outside")])
    # A wide window behind the camera, outside of the view.
    fill = quad((0.9, 0.75, FRONT - 0.01), (-2.7, 0, 0), (0, 1.65, 0))
    room.place("window behind the camera", [(fill, "overcast")])
    sun = room.g.add_light("sun", "directional", (1.0, 0.80, 0.56), 19.0)
    room.roots.append(room.g.add_node("sun", rotation=look_at((0, 0, 0), SUN), extensions=sun))


def _table(room):
    x, z = TABLE
    y = TABLE_HEIGHT
    room.place("rug", [(beveled_box((-1.25, 0.0, -0.83), (1.25, 0.014, 0.83), 0.005).with_uvs(
        lambda p: (p[0] / 2.5 + 0.5, p[2] / 1.66 + 0.5)), "rug")], (x + 0.1, 0.0, z + 0.12), 4)
    room.place("table", [(things.table(1.5, 0.82, y), "walnut")], (x, 0.012, z))
    y += 0.012
    chair = room.place("chair", [(things.chair(), "dark wood")], (x + 0.98, 0.012, z + 0.42), -118)
    room.roots.append(room.g.add_node("chair 2", mesh=chair, translation=[x - 0.35, 0.012, z - 0.72], rotation=[0, 0.06, 0, 0.998199]))

    copper, dark = things.kettle()
    room.place("kettle", [(copper, "copper"), (dark, "black")], (x - 0.40, y, z - 0.12), -28)
    room.place("fruit bowl", [("bowl", "stoneware")], (x - 0.02, y, z + 0.06), scale=[0.165, 0.085, 0.165])
    fruit = [("orange peel", 0.046, (-0.062, 0.062, 0.035)), ("orange peel", 0.044, (0.030, 0.060, 0.068)), ("orange peel", 0.045, (-0.020, 0.065, -0.062)),
             ("orange peel", 0.043, (0.005, 0.118, 0.012)), ("apple", 0.043, (0.078, 0.066, -0.016)), ("lemon", 0.036, (0.022, 0.058, -0.104))]
    by_kind = {}
    for kind, radius, at in fruit:
        squash = {"orange peel": 0.94, "apple": 0.92, "lemon": 1.0}[kind]
        ball = sphere(radius, 24, 12)
        if kind == "lemon":
            ball = ball.scaled(1.25, 0.92, 0.92).rotated("y", 35)
        elif kind == "apple":
            ball = ball.mapped(lambda p, r=radius: (p[0], p[1] - 0.3 * r * math.exp(-(p[0] ** 2 + p[2] ** 2) / (0.12 * r * r)) * (1 if p[1] > 0 else -0.4), p[2]))
        else:
            ball = ball.scaled(1.0, squash, 1.0).rotated("x", 40 * hash_unit(int(at[0] * 1000) + 500, 3))
        ball.uvs = [(u * 6.0, v * 3.0) for u, v in ball.uvs]
        by_kind.setdefault(kind, []).append(ball.moved(*at))
    room.place("fruit", [(joined(balls), kind) for kind, balls in by_kind.items()], (x - 0.02, y, z + 0.06))
    stray = sphere(0.045, 24, 12)
    stray.uvs = [(u * 6.0, v * 3.0) for u, v in stray.uvs]
    room.place("stray orange", [(stray, "orange peel")], (x - 0.24, y + 0.045, z + 0.26), 30)

    room.place("vase", [("vase", "teal glaze")], (x + 0.26, y, z - 0.16))
    stalk_mesh, places = things.stalks(4, 0.52, 0.24, 5)
    room.place("branches", [(stalk_mesh.scaled(0.6, 1.0, 0.6), "stalk")], (x + 0.26, y + 0.20, z - 0.16))

    books = [("red cloth", 0.165, 0.235, 0.032, 12), ("ochre cloth", 0.15, 0.215, 0.024, -6), ("blue cloth", 0.14, 0.20, 0.020, 20)]
    top = y
    for i, (cloth, w, d, h, turn) in enumerate(books):
        cover, pages = things.book(w, d, h)
        room.place("book %d" % i, [(cover, cloth), (pages, "paper")], (x + 0.50, top, z + 0.16), turn + 90)
        top += h + 0.0005
    room.place("cup", [(things.cup(), "porcelain"), (things.tea(), "tea")], (x + 0.505, top, z + 0.155), -35)
    brass, wax, flame = things.candlestick()
    room.place("candlestick", [(brass, "brass"), (wax, "wax"), (flame, "glow")], (x - 0.60, y, z + 0.16))
    dome, diffuser = things.pendant(CEILING - 1.72)
    room.place("pendant", [(dome, "enamel"), (diffuser, "glow")], (x + 0.12, 1.72, z - 0.05))
    return places


def _leaves(room, places, origin, scale):
    """One leaf mesh, many nodes."""
    if "blade" not in room.material:
        room.material["blade"] = room.g.add_mesh("leaf", [(things.leaf_blade(), room.material["leaf"])])
    for point, turn, pitch, size in places:
        # Pitch raises +z, then the heading rotates it about y.
        a, b = math.radians(turn) / 2, math.radians(-pitch) / 2
        rotation = [math.cos(a) * math.sin(b), math.sin(a) * math.cos(b), -math.sin(a) * math.sin(b), math.cos(a) * math.cos(b)]
        at = [o + s * p for o, s, p in zip(origin, scale, point)]
        room.roots.append(room.g.add_node("leaf", mesh=room.material["blade"], translation=at, rotation=rotation, scale=[size] * 3))


def _corner(room):
    pot, soil = things.plant_pot()
    at = (-1.62, 0.0, -1.68)
    room.place("plant pot", [(pot, "terracotta"), (soil, "soil")], at)
    stalk_mesh, places = things.stalks(6, 1.25, 0.34, 11)
    room.place("plant", [(stalk_mesh, "stalk")], (at[0], 0.30, at[2]))
    _leaves(room, places, (at[0], 0.30, at[2]), (1, 1, 1))

    carcass, doors, knobs = things.sideboard(1.55, 0.42, 0.72)
    room.place("sideboard", [(joined([carcass, doors]), "walnut"), (knobs, "brass")], (1.02, 0.0, BACK + 0.02))
    base, fitting, shade = things.table_lamp()
    room.place("table lamp", [(base, "porcelain"), (fitting, "brass"), (shade, "shade")], (1.45, 0.72, BACK + 0.24))
    room.place("green vase", [("vase", "enamel")], (0.42, 0.72, BACK + 0.22), scale=[0.8] * 3)
    room.place("brass bowl", [("bowl", "brass")], (0.68, 0.72, BACK + 0.25), scale=[0.1, 0.055, 0.1])
    cloths = ["green cloth", "ochre cloth", "red cloth", "blue cloth", "paper", "green cloth", "red cloth"]

    canvas = quad((-0.30, -0.375, 0.016), (0.60, 0, 0), (0, 0.75, 0))
    room.place("painting", [(things.frame(0.60, 0.75, 0.045, 0.03), "brass"), (canvas, "painting")], (0.78, 1.56, BACK + 0.002))

    # A shelf between window and painting.
    shelf_x, shelf_y = -0.62, 1.42
    room.place("shelf", [(beveled_box((-0.46, 0, 0), (0.46, 0.03, 0.22), 0.005, 1 / 0.6), "walnut")], (shelf_x, shelf_y, BACK + 0.002))
    offset = -0.42
    for i, cloth in enumerate(cloths):
        thick, tall = 0.024 + 0.02 * hash_unit(i, 7), 0.19 + 0.06 * hash_unit(i, 8)
        cover, pages = things.book(0.15, tall, thick)
        # Upright, its spine towards the room: x of the lying book maps to -z, y to -x, z to y.
        cover, pages = (mesh.mapped(lambda p: (-p[1], p[2], -p[0]), lambda n: (-n[1], n[2], -n[0])) for mesh in (cover, pages))
        low, high = ([pick(p[k] for p in cover.positions) for k in range(3)] for pick in (min, max))
        parts = [(mesh.moved(-low[0], -low[1], -low[2]), material) for mesh, material in ((cover, cloth), (pages, "paper"))]
        room.place("shelf book %d" % i, parts, (shelf_x + offset, shelf_y + 0.03, BACK + 0.03))
        offset += high[0] - low[0] + 0.003
    room.place("small pot", [("bowl", "teal glaze")], (shelf_x + 0.02, shelf_y + 0.03, BACK + 0.11), scale=[0.06, 0.075, 0.06])
    room.place("copper ball", [(sphere(0.052, 28, 14), "copper")], (shelf_x + 0.20, shelf_y + 0.082, BACK + 0.11))
    room.place("porcelain vase", [("vase", "porcelain")], (shelf_x + 0.36, shelf_y + 0.03, BACK + 0.11), scale=[0.62] * 3)


def build():
    room = _Room()
    room.library["vase"] = room.g.add_primitive(things.vase().without_uvs())
    room.library["bowl"] = room.g.add_primitive(things.bowl(1.0, 1.0).without_uvs())
    _materials(room)
    _walls(room)
    _outside(room)
    branch_leaves = _table(room)
    _corner(room)
    x, z = TABLE
    small = [(p, turn, pitch, size * 0.62) for p, turn, pitch, size in branch_leaves]
    _leaves(room, small, (x + 0.26, TABLE_HEIGHT + 0.212, z - 0.16), (0.6, 1.0, 0.6))
    room.roots.append(room.g.add_camera_node("camera", (1.05, 1.50, 2.62), (-0.25, 0.88, -0.70), math.radians(38)))
    return {"interior.glb": room.g.finish(room.roots, "interior").to_glb()}
