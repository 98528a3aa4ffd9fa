"""Errors of memory and races in the kernels of tiny renders, found by compute-sanitizer."""
# SPDX-License-Identifier: Apache-2.0
import re

from one_round import Skipped, find_tool, project_job

SIZE = "32x18"
TOOLS = ("memcheck", "racecheck")
FOUND = 99  # exit code of compute-sanitizer where it finds errors
# Scene and flags by the kernels that they run.
RENDERS = {
    "paths": ("cornell_box.glb", 1, ("--path-reuse", "1")),
    "Whitted": ("paper/figure_10.glb", 1, ("--integrator", "whitted", "--glossy-samples", "2x2")),
    "path reuse": ("interior.glb", 2, ("--path-reuse", "8", "--guiding", "off")),
    "light paths": ("pool.glb", 2, ("--light-paths", "0.5", "--path-reuse", "1", "--guiding", "off")),
    "photons": ("pool.glb", 2, ("--photons", "0.5", "--path-reuse", "1", "--guiding", "off")),
    "paged textures": ("interior.glb", 1, ("--device-memory", "8M", "--path-reuse", "1", "--guiding", "off")),
    "parts of light": ("interior.glb", 2, ("--path-reuse", "8", "--light-groups", "name", "--aov", "diffuse_direct,glossy_indirect,diffuse_color",
                                           "--cryptomatte", "object", "--guiding", "off")),
    "guide": ("interior.glb", 1, ("--guiding", "on", "--path-reuse", "1")),
    "ambient occlusion": ("interior.glb", 1, ("--integrator", "ambient-occlusion")),
}
SUMMARY = {"memcheck": re.compile(r"ERROR SUMMARY: (\d+) error"), "racecheck": re.compile(r"RACECHECK SUMMARY: (\d+) hazard")}
REFUSED = r"Device not supported|not supported on this|Target application terminated before first instrumented API call"


def sanitizer(the_round):
    """Errors by tool and render; reports with errors are written to OUT/sanitizer.txt."""
    program = find_tool("compute-sanitizer")
    table = the_round.found.setdefault("sanitizer", {})
    reports = the_round.options.out / "sanitizer.txt"
    reports.unlink(missing_ok=True)
    for tool in TOOLS:
        for name, (scene, spp, flags) in RENDERS.items():
            if the_round.is_over():
                table["ended early before"] = f"{tool}, {name}"
                return table
            render = the_round.render_command(project_job(scene), the_round.folder / "sanitizer.exr", *flags, spp=spp, size=SIZE)
            result = the_round.run_tool([program, "--tool", tool, "--error-exitcode", FOUND, *render])
            errors = errors_of(tool, result)
            table.setdefault(name, {"scene": scene})[tool] = errors
            if errors:
                table[name][f"first of {tool}"] = first_report(result.stdout)
                with reports.open("a", encoding="utf-8") as file:
                    file.write(f"compute-sanitizer --tool {tool}, {name}, {scene}\n{result.stdout}\n")
            the_round.save()
    return table


def errors_of(tool, result):
    """The number of errors or hazards, as the summary names it; raises RuntimeError where the render or the tool failed. An error may
    end the render, too, whose exit code is the result's then."""
    found = SUMMARY[tool].findall(result.stdout)
    errors = sum(map(int, found))
    if found and (errors > 0 or result.returncode == 0):
        return errors
    lines = " ".join(line.lstrip("= ") for line in result.stdout.strip().splitlines()[-4:])
    text = f"compute-sanitizer --tool {tool}: exit code {result.returncode}: {lines or 'no output'}"
    raise (Skipped if re.search(REFUSED, result.stdout) else RuntimeError)(text)


def first_report(output):
    """The first error's first two lines: its kind and its place."""
    lines = [line.lstrip("= ") for line in output.splitlines() if line.startswith("=========") and len(line.strip("= ")) > 0]
    lines = [line for line in lines if not re.match(r"COMPUTE-SANITIZER|(?:RACECHECK|ERROR) SUMMARY", line)]
    return "; ".join(line.strip() for line in lines[:2])
