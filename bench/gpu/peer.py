"""Mitsuba 3 on the same GPU: the cost of equal noise, through bench/equal_noise.py."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import sys

from one_round import ROOT, Skipped, chosen_jobs
from peers import install, run

SCENES = ("cornell", "manylights", "dragon", "hotel", "glass", "lambo")


def peer(the_round):
    """Rates, noise and its cost, of Kindling with and without path reuse and of Mitsuba."""
    options = the_round.options
    name = "mitsuba_cuda" if options.device == "gpu" else "mitsuba"  # elsewhere that of processors stands in for it
    if not install.installed(name):
        raise Skipped(f"{install.PACKAGES[name]} is absent; pack its wheels: round.sh pack FILE --wheels FOLDER")
    # Packed Mitsuba is in PYTHONPATH, and the round's cache has the kernels. Installed Mitsuba
    # is in the user's cache.
    environment = the_round.environment if install.at_hand(name) else dict(os.environ)
    refuse_without(name, the_round, environment)
    table = the_round.found.setdefault("peer", {})
    for job in chosen_jobs(*SCENES, otherwise="cornell_box.glb"):
        if the_round.is_over():
            table["ended early before"] = job.name
            break
        report = the_round.folder / "peer.json"
        report.unlink(missing_ok=True)
        packed = ROOT / "measured"
        scene = [packed, "--only", job.name] if packed in job.scene.parents else [job.scene]
        result = the_round.run_tool(
            [sys.executable, "-B", ROOT / "bench" / "equal_noise.py", *scene, "--kindling", the_round.program, "--peers", name, "--clock", "wall",
             "--threads", os.cpu_count(), "--seeds", 3, "--spp", options.peer_spp, "--size", options.peer_size, "--json", report,
             "--setting", f"kindling=--device {options.device}", "--setting", f"without_reuse=--device {options.device} --path-reuse 1"],
            environment)
        if result.returncode != 0 or not report.is_file():
            last = " ".join(result.stdout.strip().splitlines()[-3:])
            raise RuntimeError(f"{job.name}: bench/equal_noise.py: exit code {result.returncode}: {last}")
        table[job.name] = row_of(json.loads(report.read_text(encoding="utf-8"))["scenes"][0]["rows"], name)
        the_round.save()
    return table


def refuse_without(name, the_round, environment):
    """Raises Skipped if Mitsuba or NumPy cannot be imported there, or has no GPU to run on."""
    words = "import numpy, mitsuba" + (f"; mitsuba.set_variant('{run.VARIANTS[name]}')" if name == "mitsuba_cuda" else "")
    tried = the_round.run_tool([install.python_of(name), "-c", words], environment)
    if tried.returncode != 0:
        raise Skipped(f"{name}: {(tried.stdout.strip().splitlines() or ['no output'])[-1]}")


def row_of(rows, name):
    """The figures of a scene: those of each contestant, and how many times Mitsuba's cost of equal noise is Kindling's."""
    by_setting = {row["setting"]: row for row in rows}
    titles = {"kindling": "Kindling", "without_reuse": "without path reuse", name: "Mitsuba"}
    result = {}
    for key, text in (("mpaths_per_s", "M samples/s"), ("noise", "relMSE"), ("noise_x_s", "relMSE x s")):
        result |= {f"{text}, {title}": by_setting[setting][key] for setting, title in titles.items()}
    for setting in ("kindling", "without_reuse"):
        cost = by_setting[setting]["noise_x_s"]
        result[f"cost, Mitsuba / {titles[setting]}"] = by_setting[name]["noise_x_s"] / cost if cost > 0.0 else None
    return result
