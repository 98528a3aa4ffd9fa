# SPDX-License-Identifier: Apache-2.0
"""Procedural surfaces of the figures: turbulence and checkers, with a flat color as fallback."""
from . import images, procedurals
from .procedurals import Graph


def textured(g, name, graph, mean, metallic=0.0, roughness=0.5, **fields):
    """A material whose base color is a graph; `mean`: linear RGB for readers without support for graphs."""
    root = g.json.get("extensions", {}).get("KHR_texture_procedurals", {"procedurals": []})
    number = len(root["procedurals"])
    procedurals.add(g, [graph])
    fallback = g.add_texture(name, images.paint(1, 1, 3, lambda x, y: images.srgb(mean)), nearest=True)
    return g.add_material(name, (1, 1, 1), metallic, roughness, pbr={"baseColorTexture": procedurals.slot(number, fallback)}, **fields)


def turbulence(name, colors, frequency, seed=0.0, octaves=6, gain=1.15, warp=0.0):
    """Perlin's turbulence of the object's position (Perlin 1985, "An Image Synthesizer") through a ramp of three colors.

    `seed` moves the pattern. `warp` above 0: the sine of the height plus turbulence times `warp`, which is marble.
    """
    graph = Graph(name)
    moved = graph.node("add", "vector3", in1=graph.node("position", "vector3", space="object"), in2=(seed, 0.37 * seed, 0.71 * seed))
    place = graph.node("multiply", "vector3", in1=moved, in2=float(frequency))
    value = procedurals.turbulence_of(graph, place, octaves)
    if warp:
        height = graph.node("extract", "float", in_=place, index=1)
        phase = graph.node("add", "float", in1=height, in2=graph.node("multiply", "float", in1=value, in2=float(warp)))
        wave = graph.node("sin", "float", in_=graph.node("multiply", "float", in1=phase, in2=2.2))
        value = graph.node("remap", "float", in_=wave, inlow=-1.0, inhigh=1.0, outlow=0.0, outhigh=1.0)
    else:
        value = graph.node("multiply", "float", in1=value, in2=float(gain))
    low, middle, high = colors
    first = graph.node("smoothstep", "float", in_=value, low=0.0, high=0.5)
    second = graph.node("smoothstep", "float", in_=value, low=0.45, high=1.0)
    lower = graph.node("mix", "color3", bg=low, fg=middle, mix=first)
    return graph.output(graph.node("mix", "color3", bg=lower, fg=high, mix=second))
