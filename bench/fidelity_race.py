#!/usr/bin/env python3
"""Makes a folder of scenes for equal_noise.py from the scenarios of fidelity.py.

    bench/fidelity_race.py FOLDER OUT [--only PATTERN]     # then: bench/equal_noise.py OUT --peers cycles,mitsuba

Copies each model with its files and its environment; scenes.json names both. The scenario's camera becomes the only one of the
copy, so that every renderer has it; animations are left out, so that all show the same pose. --without removes an extension
that a peer lacks, so that all render the same material.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import math
import shutil
import sys
from pathlib import Path

import fidelity_scenarios
from peers import gltf_json

BOUNCES = 8


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path, help="a new folder, or one that this script made")
    parser.add_argument("--only", action="append", metavar="PATTERN", help="scenarios or models with this in their name; with *, ?: a whole name")
    parser.add_argument("--without", action="append", default=[], metavar="EXTENSION", help="a glTF extension to remove, such as KHR_materials_iridescence")
    arguments = parser.parse_args()
    scenarios = [scenario for scenario in fidelity_scenarios.read_folder(arguments.folder)
                 if scenario.listed and (not arguments.only or any(fidelity_scenarios.matches(scenario, p) for p in arguments.only))]
    if not scenarios:
        sys.exit(f"{arguments.folder}: no scenario" + (" of that name" if arguments.only else ""))
    (arguments.out / "env").mkdir(parents=True, exist_ok=True)
    entries = {scenario.model: scene_of(scenario, arguments.out, arguments.without) for scenario in scenarios}
    (arguments.out / "scenes.json").write_text(json.dumps(entries, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"{len(entries)} scenes in {arguments.out}")


def scene_of(scenario, out, without):
    """Copies a scenario's model, less animations and some extensions, and its environment; returns its entry of scenes.json."""
    flags = dict(zip(scenario.flags[::2], scenario.flags[1::2]))
    target = out / scenario.model
    shutil.copytree(scenario.file.parent, target, dirs_exist_ok=True)
    document = without_extensions(gltf_json.read_json(scenario.file), without)
    document.pop("animations", None)
    gltf_json.write_json(target / scenario.file.name, with_camera(document, flags, scenario.aspect))
    environment = flags.get("--env")
    if environment:
        shutil.copy(environment, out / "env" / environment.name)
    return {"file": f"{scenario.model}/{scenario.file.name}", "hdr": environment.name if environment else None, "max_bounces": BOUNCES}


def without_extensions(value, names):
    """A document, or a part of one, in which no object has these extensions."""
    if isinstance(value, list):
        return [without_extensions(item, names) for item in value]
    if not isinstance(value, dict):
        return value
    rest = {key: without_extensions(item, names) for key, item in value.items()}
    for key in ("extensionsUsed", "extensionsRequired"):
        if key in rest:
            rest[key] = [name for name in rest[key] if name not in names]
    if "extensions" in rest:
        rest["extensions"] = {name: item for name, item in rest["extensions"].items() if name not in names}
    return {key: item for key, item in rest.items() if not (key.startswith("extensions") and not item)}


def with_camera(document, flags, aspect):
    """The document with one camera, in a node of its own, in the default scene."""
    azimuth, polar, radius = (float(v) for v in flags["--orbit"].split(","))
    target = [float(v) for v in flags["--target"].split(",")]
    for node in document.get("nodes", []):
        node.pop("camera", None)
    document["cameras"] = [{"type": "perspective", "perspective": {
        "yfov": math.radians(float(flags["--fov"])), "aspectRatio": aspect, "znear": radius / 1000}}]
    azimuth, polar = math.radians(azimuth), math.radians(polar)
    way = (math.sin(polar) * math.sin(azimuth), math.cos(polar), math.sin(polar) * math.cos(azimuth))
    nodes = document.setdefault("nodes", [])
    nodes.append({"name": "camera of the scenario", "camera": 0, "translation": [t + radius * w for t, w in zip(target, way)],
                  "rotation": orbit_rotation(azimuth, polar - math.pi / 2)})
    scenes = document.setdefault("scenes", [{}])
    scenes[document.setdefault("scene", 0)].setdefault("nodes", []).append(len(nodes) - 1)
    return document


def orbit_rotation(about_y, about_x):
    """Quaternion (x, y, z, w) of a rotation about the x axis, then one about the y axis; radians."""
    sin_y, cos_y, sin_x, cos_x = math.sin(about_y / 2), math.cos(about_y / 2), math.sin(about_x / 2), math.cos(about_x / 2)
    return [cos_y * sin_x, sin_y * cos_x, -sin_y * sin_x, cos_y * cos_x]


if __name__ == "__main__":
    main()
