#!/usr/bin/env python3
"""Writes seeds for the harnesses: small valid inputs of each kind, one folder for each harness.

    make_seeds.py FOLDER [--programs BUILD/tests/fuzz] [--only KIND]...

Images are made by oiiotool, scenes are those of the repository, and what only Kindling's libraries can write is written by the
programs fuzz_seeds_scenes and fuzz_seeds_records of the build, where they exist. Nothing is written twice: a seed is named by its
content.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import hashlib
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MAX_BYTES = 60000  # a larger seed slows every mutation


class Seeds:
    """Folders of seeds, one for each kind."""

    def __init__(self, folder, only):
        self.folder = folder
        self.only = only
        self.counts = {}

    def wants(self, *kinds):
        return not self.only or any(kind in self.only for kind in kinds)

    def add(self, kind, content):
        if not self.wants(kind) or len(content) > MAX_BYTES:
            return
        folder = self.folder / kind
        folder.mkdir(parents=True, exist_ok=True)
        (folder / hashlib.sha1(content).hexdigest()).write_bytes(content)
        self.counts[kind] = self.counts.get(kind, 0) + 1


def png(width, height, depth, color, rows, chunks=(), interlace=0):
    def chunk(name, content):
        body = name + content
        return struct.pack(">I", len(content)) + body + struct.pack(">I", zlib.crc32(body))
    header = struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, interlace)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + b"".join(chunk(*each) for each in chunks) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def pngs(seeds):
    palette = (b"PLTE", bytes(range(48)))
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
    for color, depths in {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}.items():
        for depth in depths:
            row = (5 * channels[color] * depth + 7) // 8
            rows = b"".join(bytes([line % 5]) + bytes((line * 16 + i) % (16 if color == 3 else 256) for i in range(row)) for line in range(6))
            chunks = [palette] if color == 3 else []
            if color in (0, 2, 3):
                transparent = {0: b"\0\1", 2: b"\0\1\0\2\0\3", 3: bytes([0, 128, 255])}[color]
                seeds.add("png", png(5, 6, depth, color, rows, chunks + [(b"tRNS", transparent)]))
            seeds.add("png", png(5, 6, depth, color, rows, chunks + [(b"gAMA", struct.pack(">I", 45455)), (b"tEXt", b"a\0b")]))
    # Adam7: seven images of 1x1, 1x1, 2x1, 2x2, ... for 5 x 6 pixels of gray.
    passes = [(1, 1), (1, 1), (2, 1), (1, 2), (3, 1), (2, 3), (5, 3)]
    rows = b"".join((b"\0" + bytes(range(width))) * height for width, height in passes)
    seeds.add("png", png(5, 6, 8, 0, rows, interlace=1))


def oiio_images(seeds):
    """JPEG, WebP, EXR and HDR in their variants."""
    if not seeds.wants("jpeg", "webp", "exr", "hdr"):
        return
    if not shutil.which("oiiotool"):
        sys.exit("make_seeds.py: oiiotool is missing; install openimageio-tools, or choose others with --only")
    gray, rgb, rgba = (["--pattern", "fill:topleft=.1:topright=.9:bottomleft=.4:bottomright=1", "19x13", "1"],
                       ["--pattern", "checker:width=3:height=2:color1=.1,.4,.9:color2=1,.3,0", "19x13", "3"],
                       ["--pattern", "constant:color=.2,.5,.8,.6", "19x13", "4"])
    jobs = []
    for name, image in (("gray", gray), ("rgb", rgb)):
        for quality in ("20", "95"):
            jobs.append(("jpeg", image + ["--compression", f"jpeg:{quality}", "-o", f"{name}{quality}.jpg"]))
    jobs.append(("jpeg", rgb + ["--attrib", "jpeg:subsampling", "4:2:0", "-o", "subsampled.jpg"]))
    jobs.append(("jpeg", rgb + ["--attrib", "jpeg:progressive", "1", "-o", "progressive.jpg"]))
    for name, image in (("rgb", rgb), ("rgba", rgba)):
        jobs.append(("webp", image + ["-o", f"{name}.webp"]))
        jobs.append(("webp", image + ["--compression", "lossless", "-o", f"{name}_lossless.webp"]))
    for compression in ("none", "rle", "zip", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"):
        jobs.append(("exr", rgb + ["-d", "half", "--compression", compression, "-o", f"rgb_{compression}.exr"]))
    for compression in ("zip", "piz", "pxr24", "dwaa"):
        jobs.append(("exr", rgba + ["-d", "float", "--compression", compression, "-o", f"rgba_{compression}.exr"]))
    jobs.append(("exr", gray + ["-d", "half", "-o", "gray.exr"]))
    jobs.append(("exr", rgba + ["-d", "half", "--tile", "8", "8", "-o", "tiled.exr"]))
    jobs.append(("exr", rgba + ["-d", "half", "--tile", "8", "8", "-otex", "levels.exr"]))
    jobs.append(("exr", rgb + ["--origin", "+3-4", "--fullsize", "30x20+0+0", "-o", "cropped.exr"]))
    jobs.append(("exr", rgb + rgba + ["--siappend", "-d", "half", "-o", "parts.exr"]))
    jobs.append(("hdr", rgb + ["-o", "rgb.hdr"]))
    jobs.append(("hdr", ["--pattern", "noise", "6x3", "3", "-o", "narrow.hdr"]))
    with tempfile.TemporaryDirectory() as folder:
        wanted = [arguments for kind, arguments in jobs if seeds.wants(kind)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:  # each loads hundreds of libraries
            ends = list(pool.map(lambda arguments: subprocess.run(["oiiotool", *arguments], cwd=folder, capture_output=True, check=False), wanted))
        for arguments, done in zip(wanted, ends):
            if done.returncode != 0:
                print(f"make_seeds.py: left out {arguments[-1]}: {done.stderr.decode(errors='replace').strip().splitlines()[-1:]}", file=sys.stderr)
        for kind, pattern in (("jpeg", "*.jpg"), ("webp", "*.webp"), ("exr", "*.exr"), ("hdr", "*.hdr")):
            for file in sorted(Path(folder).glob(pattern)):
                seeds.add(kind, file.read_bytes())
    plain = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n%b 2 +X 3\n" + bytes(range(24))
    seeds.add("hdr", plain % b"-Y")
    seeds.add("hdr", plain % b"+Y")


def ktx2(seeds):
    """The fixtures of the tests, and one of them compressed by zlib."""
    for file in sorted((ROOT / "tests/image/ktx2").glob("*.ktx2")):
        content = file.read_bytes()
        seeds.add("ktx2", content)
        scheme, = struct.unpack_from("<I", content, 44)
        levels, = struct.unpack_from("<I", content, 40)
        if scheme == 0 and levels == 1:
            offset, length, _ = struct.unpack_from("<QQQ", content, 80)
            packed = zlib.compress(content[offset:offset + length])
            head = bytearray(content[:offset])
            struct.pack_into("<I", head, 44, 3)
            struct.pack_into("<QQQ", head, 80, offset, len(packed), length)
            seeds.add("ktx2", bytes(head) + packed)


def glb_of(document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I", len(text)) + b"JSON" + text
    if binary:
        chunks += struct.pack("<I", len(binary)) + b"BIN\0" + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


# Extensions with values of every kind, which the shipped scenes do not have all of.
MATERIALS = json.loads("""
[{"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatNormalTexture": {"index": 0, "scale": 0.5}},
  "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0.5], "sheenRoughnessFactor": 0.3}, "KHR_materials_ior": {"ior": 1.4}}},
 {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_dispersion": {"dispersion": 0.1},
  "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [0.5, 1, 1], "attenuationDistance": 2},
  "KHR_materials_volume_scatter": {"multiscatterColor": [1, 0.9, 0.8], "scatterAnisotropy": 0.2}}},
 {"extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 400},
  "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyTexture": {"index": 0}}, "KHR_materials_specular": {"specularFactor": 0.2}}},
 {"extensions": {"KHR_materials_unlit": {}}, "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true},
 {"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, 1], "glossinessFactor": 0.5},
  "KHR_materials_emissive_strength": {"emissiveStrength": 5}}, "emissiveFactor": [1, 1, 1]},
 {"extensions": {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5}}, "alphaMode": "BLEND",
  "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform":
   {"offset": [0, 1], "rotation": 1, "scale": [2, 2], "texCoord": 1}}}}}]
""")
ANIMATION_POINTERS = ["/materials/0/pbrMetallicRoughness/roughnessFactor", "/nodes/0/translation", "/cameras/0/perspective/yfov",
                      "/extensions/KHR_lights_punctual/lights/0/intensity"]


def scene_of_extensions():
    """A document with every extension that the importer reads, over a buffer of 256 bytes."""
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}], "buffers": [{"byteLength": 256}],
        "bufferViews": [{"buffer": 0, "byteLength": 256}, {"buffer": 0, "byteOffset": 96, "byteLength": 160}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "byteOffset": 60},
                      {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"},
                      {"componentType": 5126, "count": 3, "type": "VEC3", "sparse": {"count": 1, "indices": {
                          "bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "targets": [{"POSITION": 3}], "extensions": {
            "KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}}], "weights": [0.5]}],
        "materials": MATERIALS, "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071}], "images": [{"uri": "a.png"}],
        "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}},
                                             "KHR_node_visibility": {"visible": True}}},
                  {"camera": 0, "rotation": [0, 0, 0, 1]}, {"extensions": {"KHR_lights_punctual": {"light": 0},
                                                                          "EXT_lights_ies": {"light": 0}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}, "extras": {"kindling": {"fStop": 2}}}],
        "extensions": {
            "KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}, "intensity": 3}]},
            "EXT_lights_ies": {"lights": [{"uri": "a.ies"}]}, "KHR_materials_variants": {"variants": [{"name": "a"}]},
            "EXT_lights_image_based": {"lights": [{"intensity": 1, "specularImageSize": 1, "specularImages": [[0, 0, 0, 0, 0, 0]],
                                                   "irradianceCoefficients": [[0.1, 0.1, 0.1]] * 9}]}},
        "animations": [{"channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": {
            "KHR_animation_pointer": {"pointer": pointer}}}} for pointer in ANIMATION_POINTERS],
            "samplers": [{"input": 1, "output": 1, "interpolation": "STEP"}]}]}
    used = set()

    def find(value):
        if isinstance(value, dict):
            used.update(value.get("extensions", {}))
            value = list(value.values())
        if isinstance(value, list):
            for each in value:
                find(each)
    find(document)
    document["extensionsUsed"] = sorted(used)
    return document


def scenes(seeds):
    for file in sorted([*(ROOT / "scenes").glob("*.gl*"), *(ROOT / "scenes/tiny").glob("*.gltf"), *(ROOT / "scenes/broken").glob("*.gl*")]):
        seeds.add("glb" if file.suffix == ".glb" else "gltf", file.read_bytes())
    document = scene_of_extensions()
    floats = struct.pack("<24f", 0, 0, 0, 1, 0, 0, 0, 1, 0, *([0.5] * 6), 0, 1, *([1.0] * 7)) + bytes([0, 1, 2, 0]) + bytes(156)
    seeds.add("glb", glb_of(document, floats))
    document["buffers"][0]["uri"] = "a.bin"
    seeds.add("gltf", json.dumps(document).encode())


IES = """IESNA:LM-63-%s
[TEST] seed
TILT=%s
%s1 1000 1.0 %d %d %d 2 0.1 0.1 0
1.0 1.0 50
%s
%s
%s
"""


def ies(seeds):
    vertical, half = "0 45 90", "0 45 90 135 180"
    for year, tilt, lamp, kind, down, around in (
            ("2002", "NONE", "", 1, vertical, "0"), ("1995", "NONE", "", 1, half, "0 90 180"), ("2019", "NONE", "", 1, vertical, "0 90"),
            ("1991", "INCLUDE", "1\n2\n0 90\n1 0.9\n", 1, vertical, "0 90 180 270 360"), ("2002", "NONE", "", 2, "-90 0 90", "-90 0 90"),
            ("2002", "NONE", "", 3, "0 45 90", "0 45 90")):
        angles = len(down.split()), len(around.split())
        candela = "\n".join(" ".join(str(100 * i + k) for i in range(angles[0])) for k in range(angles[1]))
        seeds.add("ies", (IES % (year, tilt, lamp, *angles, kind, down, around, candela)).encode())
    seeds.add("ies", b"TILT=NONE\r\n1 -1 1 2 1 1 1 0 0 0 1 1 1 0 90 0 5 6\r\n")


PLY = """ply
format %s 1.0
comment seed
element vertex 3
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 1
property list uchar int vertex_indices
end_header
"""


def polygons(seeds):
    corners, face = ((0, 0, 0), (1, 0, 0), (0, 1, 0)), (0, 1, 2)
    text = "".join(f"{x} {y} {z} 255 128 0\n" for x, y, z in corners) + "3 0 1 2\n"
    seeds.add("polygons", b"\0" + (PLY % "ascii" + text).encode())
    for order, name in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        body = b"".join(struct.pack(order + "3f3B", *p, 255, 128, 0) for p in corners) + struct.pack(order + "B3i", 3, *face)
        seeds.add("polygons", b"\0" + (PLY % name).encode() + body)
    seeds.add("polygons", b"\1v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\n")
    facet = "".join("vertex %g %g %g\n" % p for p in corners)
    seeds.add("polygons", f"\2solid a\nfacet normal 0 0 1\nouter loop\n{facet}endloop\nendfacet\nendsolid a\n".encode())
    seeds.add("polygons", b"\2" + bytes(80) + struct.pack("<I12fH", 1, 0, 0, 1, *[x for p in corners for x in p], 0))


OCIO = """Linear
ocio_profile_version: 2
environment: {SHOT: a}
search_path: luts:.
roles: {scene_linear: lin, default: raw, aces_interchange: ap0}
displays:
  screen:
    - !<View> {name: Linear, colorspace: lin}
    - !<View> {name: Film, view_transform: film, display_colorspace: screen}
view_transforms:
  - !<ViewTransform> {name: film, from_scene_reference: !<MatrixTransform> {matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}}
display_colorspaces:
  - !<ColorSpace> {name: screen, from_display_reference: !<ExponentTransform> {value: 2.2, style: mirror, direction: inverse}}
colorspaces:
  - !<ColorSpace> {name: lin, family: a, equalitygroup: b, bitdepth: 32f, isdata: false, encoding: scene-linear}
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace>
    name: ap0
    to_scene_reference: !<GroupTransform>
      children:
        - !<CDLTransform> {slope: [1, 1, 1], offset: [0, 0, 0], power: [1, 1, 1], sat: 1}
        - !<LogAffineTransform> {base: 10, logSideSlope: [0.2, 0.2, 0.2]}
        - !<RangeTransform> {minInValue: 0, minOutValue: 0, maxInValue: 1, maxOutValue: 1}
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
        - !<FileTransform> {src: a.cube, interpolation: linear}
"""


def ocio(seeds):
    seeds.add("ocio", OCIO.encode())
    seeds.add("ocio", OCIO.replace("Linear\n", "Film\n", 1).encode())
    seeds.add("ocio", b"Film\nocio_profile_version: 1\nsearch_path: luts\nroles: {scene_linear: lin}\ndisplays:\n  s:\n    - !<View> {name: Film, "
              b"colorspace: lin}\ncolorspaces:\n  - !<ColorSpace> {name: lin, to_reference: !<ExponentTransform> {value: [2, 2, 2, 1]}}\n")
    for path in (b"ocio://default", b"ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1", b"nowhere.ocio", b"/", b".", b"", b"a.ocioz"):
        seeds.add("ocio", b"path\n" + path)


def records(seeds):
    attempt = {"host": "a", "start_s": 1.5, "end_s": 2.5, "seen_s": 2, "progress": 0.5, "resumed": False, "saved_before": 0.0, "saved": 0.25,
               "outcome": "failed", "exit_code": 4, "signal": 0, "message": "m", "log": "logs/1"}
    outcomes = ("running", "done", "interrupted", "failed", "crashed", "refused", "lost", "out of time")
    for outcome in outcomes:
        seeds.add("farm", b"t" + json.dumps({"attempts": [attempt, dict(attempt, outcome=outcome)] * 2, "poisoned": ""}).encode())
    plan = {"version": 1, "program": "0.1.0", "binary": "/bin/kindling", "scene": "/s/scene.glb", "working_folder": "/s", "flags": ["--spp", "64"],
            "frames": [1, 2, -3], "parts": 2, "outputs": ["/s/out.####.exr"], "retries": 2, "engine": "slurm",
            "resources": {"partition": "p", "threads_per_part": 0, "memory": "4G", "time": "1:30:00"}}
    seeds.add("farm", b"p" + json.dumps(plan).encode())
    seeds.add("farm", b"p" + json.dumps(dict(plan, frames=[], parts=3, scene=[115, 255, 47])).encode())
    seeds.add("farm", b"m" + json.dumps({"end_s": 5.0, "exit_code": 0, "message": ""}).encode())
    seeds.add("farm", b"r" + json.dumps({"exit_code": 3, "task": 1, "message": "bad"}).encode())
    seeds.add("farm", b"j" + json.dumps({"arrays": [{"id": "12", "tasks": [0, 1]}], "merge": "13"}).encode())
    seeds.add("farm", b'l{"event": "progress", "phase": "render", "fraction": 0.5}\nkindling: error: a\n{"event": "warning", "message": "b"}\n{}')
    seeds.add("farm", b"s12|0|R|node1|None\n12|1|PD||Resources\n14|N/A|PD||Dependency\n13|[0-3%2]|PD||Priority\n")
    for text in (b"12;cluster", b"MaxArraySize            = 1001\n", b"90", b"1:30", b"1:30:00", b"2-12", b"2-12:30:00", b"UNLIMITED", b"4G"):
        seeds.add("farm", b"s" + text)


COMMANDS = """render scene.glb -o out.exr -o out.png --spp 64 --size 640x480 --accel embree
render scene.glb --frames 1-10 -o out.####.exr --fps 24 --shutter 0.5 --part 1/4 --seed 3
render scene.glb --env sky.hdr --exposure auto --view AgX --crop 0,0,10,10 --pixel 4,5 --sample 3
resume part.kacc --spp 128 -o out.exr
info scene.glb --json --strict
info --list-extensions
merge a.kacc b.kacc -o out.exr --allow-missing
shootout scene.glb --json out.json
scaling scene.glb --threads 1,2,4
farm submit scene.glb --parts 8 --frames 1-3 --folder farm -o out.####.exr -- --spp 5 --size 64x48
farm status farm
farm retry farm
farm work farm 3
farm merge farm
completion zsh
manual
--version
help"""


def flags(seeds):
    for line in COMMANDS.splitlines():
        seeds.add("flags", line.replace(" ", "\n").encode())


def from_programs(seeds, folder):
    """Draco, meshopt, files with faults of exporters, .kacc and rays."""
    for program, kinds in (("fuzz_seeds_scenes", ("draco", "meshopt", "gltf", "glb")), ("fuzz_seeds_records", ("kacc", "rays"))):
        file = folder / program
        if not seeds.wants(*kinds):
            continue
        if not file.exists():
            print(f"make_seeds.py: {file} is not built; left out its seeds of {', '.join(kinds)}", file=sys.stderr)
            continue
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([file, out], check=True)
            for kind in kinds:
                for seed in sorted(Path(out, kind).glob("*")):
                    seeds.add(kind, seed.read_bytes())


def findings(seeds):
    """Inputs of past findings, which are in the repository."""
    for file in sorted((ROOT / "tests/fuzz/corpus").glob("*/*")):
        seeds.add(file.parent.name, file.read_bytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--programs", type=Path, help="folder of fuzz_seeds_scenes and fuzz_seeds_records")
    parser.add_argument("--only", action="append", default=[], metavar="KIND", help="one kind; may be repeated")
    options = parser.parse_args()
    seeds = Seeds(options.folder, options.only)
    for make in (pngs, oiio_images, ktx2, scenes, ies, polygons, ocio, records, flags, findings):
        make(seeds)
    if options.programs:
        from_programs(seeds, options.programs)
    print(", ".join(f"{kind} {count}" for kind, count in sorted(seeds.counts.items())))


if __name__ == "__main__":
    main()
