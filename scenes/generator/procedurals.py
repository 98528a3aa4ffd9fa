# SPDX-License-Identifier: Apache-2.0
"""Graphs of KHR_texture_procedurals (draft): MaterialX 1.39 nodes, and patterns of them."""


class Ref:
    """The output of a node, for inputs of later nodes."""

    def __init__(self, node, value_type, output=None):
        self.node, self.type, self.output = node, value_type, output


class Graph:
    """One entry of the extension's "procedurals". Inputs are keyword arguments: a Ref, or a constant (float, int, bool, str, tuple)."""

    def __init__(self, name):
        self.name, self.nodes, self.outputs = name, [], []

    def node(self, kind, value_type, **inputs):
        ports = [self._port(name.rstrip("_"), value, value_type) for name, value in inputs.items()]
        self.nodes.append({"nodetype": kind, "type": value_type, "inputs": ports,
                           "outputs": [{"name": "out", "nodetype": "output", "type": value_type}]})
        return Ref(len(self.nodes) - 1, value_type)

    def output(self, ref):
        port = {"name": "out%d" % len(self.outputs) if self.outputs else "out", "nodetype": "output", "type": ref.type,
                "node": ref.node}
        self.outputs.append(port)
        return self

    def to_gltf(self):
        return {"name": self.name, "nodetype": "nodegraph",
                "type": self.outputs[0]["type"] if len(self.outputs) == 1 else "multioutput",
                "inputs": [], "outputs": self.outputs, "nodes": self.nodes}

    @staticmethod
    def _port(name, value, node_type):
        if isinstance(value, Ref):
            return {"name": name, "nodetype": "input", "type": value.type, "node": value.node}
        if isinstance(value, bool):
            value_type = "boolean"
        elif isinstance(value, int):
            value_type = "integer"
        elif isinstance(value, float):
            value_type = "float"
        elif isinstance(value, str):
            value_type = "string"
        else:
            kind = "color" if node_type.startswith("color") and len(value) > 2 else "vector"
            value_type, value = "%s%d" % (kind, len(value)), list(value)
        return {"name": name, "nodetype": "input", "type": value_type, "value": value}


def checkerboard(color1, color2, tiling=(8.0, 8.0)):
    g = Graph("checkerboard")
    return g.output(g.node("checkerboard", "color3", color1=color1, color2=color2, uvtiling=tiling))


def stripes(color1, color2, count=8.0, share=0.5):
    """Vertical stripes: color1 for the first fraction `share` of each."""
    g = Graph("stripes")
    uv = g.node("texcoord", "vector2", index=0)
    u = g.node("extract", "float", in_=uv, index=0)
    scaled = g.node("multiply", "float", in1=u, in2=count)
    phase = g.node("modulo", "float", in1=scaled, in2=1.0)
    return g.output(g.node("ifgreater", "color3", value1=share, value2=phase, in1=color1, in2=color2))


def turbulence_of(g, position, octaves):
    """The sum of |noise(2^i p)| / 2^i over the octaves (Perlin 1985, "An Image Synthesizer")."""
    total = None
    for i in range(octaves):
        p = g.node("multiply", "vector3", in1=position, in2=float(2 ** i)) if i else position
        octave = g.node("absval", "float", in_=g.node("noise3d", "float", position=p))
        if i:
            octave = g.node("multiply", "float", in1=octave, in2=0.5 ** i)
        total = octave if total is None else g.node("add", "float", in1=total, in2=octave)
    return total


def turbulence(low, high, frequency=2.0, octaves=6):
    g = Graph("turbulence")
    p = g.node("multiply", "vector3", in1=g.node("position", "vector3", space="object"), in2=frequency)
    value = turbulence_of(g, p, octaves)
    return g.output(g.node("mix", "color3", fg=high, bg=low, mix=value))


def marble(vein, stone, frequency=2.0, swirl=6.0, octaves=6):
    """sin(x + turbulence) (Perlin 1985)."""
    g = Graph("marble")
    p = g.node("multiply", "vector3", in1=g.node("position", "vector3", space="object"), in2=frequency)
    x = g.node("extract", "float", in_=p, index=0)
    warp = g.node("multiply", "float", in1=turbulence_of(g, p, octaves), in2=swirl)
    phase = g.node("add", "float", in1=g.node("multiply", "float", in1=x, in2=3.0), in2=warp)
    wave = g.node("sin", "float", in_=phase)
    share = g.node("remap", "float", in_=wave, inlow=-1.0, inhigh=1.0, outlow=0.0, outhigh=1.0)
    return g.output(g.node("mix", "color3", fg=stone, bg=vein, mix=g.node("power", "float", in1=share, in2=0.6)))


def worley(low, high, frequency=4.0):
    g = Graph("worley")
    p = g.node("multiply", "vector3", in1=g.node("position", "vector3", space="object"), in2=frequency)
    return g.output(g.node("mix", "color3", fg=high, bg=low, mix=g.node("worleynoise3d", "float", position=p)))


def add(gltf, graphs):
    """Writes the graphs into a document (gltf.Gltf) and adds the fallback texture."""
    gltf.use("KHR_texture_procedurals")
    gltf.use("EXT_texture_procedurals_mx_1_39")
    root = gltf.json.setdefault("extensions", {}).setdefault("KHR_texture_procedurals", {"procedurals": []})
    root["procedurals"] += [graph.to_gltf() for graph in graphs]


def slot(graph, fallback_texture, output=None):
    """A textureInfo with graph number `graph`."""
    extension = {"index": graph} if output is None else {"index": graph, "output": output}
    return {"index": fallback_texture, "extensions": {"KHR_texture_procedurals": extension}}
