"""The figures of the paper's GPU by the device, through bench/paper/run.py."""
# SPDX-License-Identifier: Apache-2.0
import json
import re
import shlex
import sys

from one_round import ROOT, Skipped

NUMBERS = "9,10,11,12,13,14,15,16"
MISSING = r"NumPy is not installed.*|neither oiiotool nor Pillow is installed.*"


def paper(the_round):
    """Times of each figure, and whether the images of the device are the CPU's; the page is OUT/paper.html."""
    options = the_round.options
    page = options.out / "paper.html"
    data = page.with_suffix(".json")
    data.unlink(missing_ok=True)
    if the_round.is_over():
        return {"ended early before": "figure 9"}
    result = the_round.run_tool([sys.executable, "-B", ROOT / "bench" / "paper" / "run.py", "--figures", NUMBERS, "--device", options.device,
                                 "--kindling", the_round.program, "--seconds", max(the_round.left_s(), 1.0), "--out", page,
                                 *shlex.split(options.paper_flags)])
    if missing := re.search(MISSING, result.stdout):
        raise Skipped(missing[0])
    figures = json.loads(data.read_text(encoding="utf-8"))["figures"] if data.is_file() else []
    table = {}
    for figure in figures:
        for scene in figure["scenes"]:
            name = f"{figure['number']} {scene['caption']}".strip()
            table |= {f"{name}, {render['name']}": row_of(render, scene["then"]) for render in scene["renders"]}
    different = any(not row["same bits"] for row in table.values())
    if result.returncode != 0 and not (result.returncode == 1 and different) or not figures:
        table["failed"] = f"bench/paper/run.py: exit code {result.returncode}: {' '.join(result.stdout.strip().splitlines()[-3:])}"
    elif "left out" in result.stdout:
        table["ended early after"] = f"figure {figures[-1]['number']}"
    return table


def row_of(render, then):
    """Seconds of the render phase, the device's without its start."""
    device, all_s = render["device"], render["all_cores_s"]
    device_s = max(device["render_s"] - device["start_s"], 1e-9)
    return {"paper": then or "-", "samples": round(render["spp"]), "CPU, one thread, s": render["one_core_s"], "CPU, all threads, s": all_s,
            "device, s": device_s, "all threads / device": all_s / device_s, "same bits": device["same"]}
