"""Scenarios of a folder of glTF models: camera, light and goldens of each.

A folder holds MODEL/.../*.gltf or *.glb, MODEL/goldens/SCENARIO/RENDERER-golden*.webp (.png), environments in env/ or
environments/ in it or beside it, and a list of scenarios in JSON as glTF-Render-Fidelity-Generator's test/config.json.
"""
# SPDX-License-Identifier: Apache-2.0
import fnmatch
import json
import math
import sys
from dataclasses import dataclass, field
from pathlib import Path

SCENARIO_FILES = ("render-fidelity.json", "scenarios.json", "config.json")
DEFAULT_ENVIRONMENT = "lightroom_14b.hdr"
PATH_TRACERS = ("blender-cycles", "three-gpu-pathtracer", "dspbr-pt", "vray", "stellar")
# Defaults of the generator (its src/config-reader.ts).
DEFAULT_SIZE, DEFAULT_FOV_DEG = (768, 768), 45


@dataclass
class Scenario:
    name: str
    model: str  # name of the model's folder
    file: Path
    flags: list  # of `kindling render`: camera, environment, background
    aspect: float  # width / height
    skybox: bool  # the environment is visible, so all pixels count
    listed: bool  # false: a model without a scenario in the list
    goldens: dict = field(default_factory=dict)  # {renderer: image}


def read_folder(folder, list_file=None, environment=None):
    """The listed scenarios whose models are there, in the list's order, then one for each model that has none: seen by its
    own camera, else one fitted to it."""
    environments = find_environments(folder)
    default = environment or environments.get(DEFAULT_ENVIRONMENT) or next(iter(environments.values()), None)
    models = find_models(folder)
    result, seen = [], set()
    for entry in read_list(folder, list_file):
        model = model_of(entry["model"])
        if model not in models:
            continue
        seen.add(model)
        flags, aspect = scenario_flags(entry, environments, default)
        place = folder / model / "goldens" / entry["name"]
        result.append(Scenario(entry["name"], model, choose_file(models[model], entry["model"]), flags, aspect,
                               bool(entry.get("renderSkybox", False)), True, find_goldens(place)))
    for model, files in models.items():
        if model not in seen:
            flags = (["--env", default] if default else []) + ["--background", "transparent"]
            result.append(Scenario(model, model, choose_file(files, model), flags, 4 / 3, False, False))
    return result


def matches(scenario, pattern):
    """Whether a pattern is part of the scenario's or its model's name, or with wildcards one of them whole."""
    wild = pattern.lower() if any(c in pattern for c in "*?[") else f"*{pattern.lower()}*"
    return any(fnmatch.fnmatchcase(name.lower(), wild) for name in (scenario.name, scenario.model))


def read_list(folder, list_file=None):
    """The entries of the scenario list; none without a file."""
    path = list_file or next((folder / name for name in SCENARIO_FILES if (folder / name).is_file()), None)
    if path is None:
        return []
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))["scenarios"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        sys.exit(f"{path}: not a list of scenarios: {error}")
    for number, entry in enumerate(entries):
        if not isinstance(entry, dict) or not isinstance(entry.get("name"), str) or not isinstance(entry.get("model"), str):
            sys.exit(f"{path}: /scenarios/{number}: an object with a name and a model was expected")
    return entries


def find_environments(folder):
    """{file name: path}; environments of the folder itself count before those beside it."""
    places = [place / name for place in (folder, folder.parent) for name in ("environments", "env")]
    return {path.name: path for place in reversed(places) for path in sorted(place.glob("*.hdr")) + sorted(place.glob("*.exr"))}


def find_models(folder):
    """{model: its glTF files}. A file in the folder itself is a model called by its stem."""
    models = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in (".gltf", ".glb") and path.is_file():
            parts = path.relative_to(folder).parts
            models.setdefault(parts[0] if len(parts) > 1 else path.stem, []).append(path)
    return models


def model_of(path):
    """The model's name in a scenario's path: what follows `Models`, else the folder above glTF..., else the file's stem."""
    parts = Path(path).parts
    if "Models" in parts[:-1]:
        return parts[parts.index("Models") + 1]
    folders = [part for part in parts[:-1] if part not in (".", "..", "/") and not part.startswith("glTF")]
    return folders[-1] if folders else Path(path).stem


def choose_file(files, wanted):
    """The file whose path ends most like the wanted one: its name, its variant folder, its stem."""
    wanted = Path(wanted)
    return max(files, key=lambda f: ((f.name == wanted.name) * 2 + (f.parent.name == wanted.parent.name), f.stem == wanted.stem))


def find_goldens(place):
    if not place.is_dir():
        return {}
    found = {path.name.split("-golden")[0]: path for path in sorted(place.iterdir()) if "-golden" in path.name}
    return {name: found[name] for name in sorted(found, key=lambda n: (PATH_TRACERS.index(n) if n in PATH_TRACERS else 99, n))}


def scenario_flags(entry, environments, default_environment):
    """(flags of `kindling render`, aspect) of a scenario over the generator's defaults: azimuth from +z towards +x and polar
    angle from +y in degrees, as Kindling's --orbit has them; the field of view is vertical whatever the aspect."""
    orbit = {"theta": 0, "phi": 90, "radius": 1, **entry.get("orbit", {})}
    target = {"x": 0, "y": 0, "z": 0, **entry.get("target", {})}
    size = {"width": DEFAULT_SIZE[0], "height": DEFAULT_SIZE[1], **entry.get("dimensions", {})}
    eye = [target[axis] for axis in "xyz"]
    radius = orbit["radius"]
    if radius == 0:
        # The eye is at the target and looks in the direction of the orbit: the same camera, one
        # meter back.
        theta, phi = math.radians(orbit["theta"]), math.radians(orbit["phi"])
        way = (math.sin(phi) * math.sin(theta), math.cos(phi), math.sin(phi) * math.cos(theta))
        eye, radius = [e - w for e, w in zip(eye, way)], 1
    flags = ["--orbit", f"{orbit['theta']},{orbit['phi']},{radius}", "--target", ",".join(f"{v:.9g}" for v in eye),
             "--fov", str(entry.get("verticalFoV", DEFAULT_FOV_DEG))]
    environment = environments.get(Path(entry.get("lighting", DEFAULT_ENVIRONMENT)).name, default_environment)
    if environment:
        flags += ["--env", environment]
    if not entry.get("renderSkybox", False):
        flags += ["--background", "transparent"]
    return flags, size["width"] / size["height"]
