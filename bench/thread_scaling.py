#!/usr/bin/env python3
"""Runs `kindling scaling` on scenes with the settings of their scenes.json, and prints one table.

    bench/thread_scaling.py FOLDER OUT [--only NAME,...] [-- FLAGS OF kindling scaling]

Writes OUT/NAME.json, .csv and .svg for each scene, OUT/scaling.md, and prints that table.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import statistics
import subprocess
import sys
from pathlib import Path

import renderers


def parse_arguments(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path, help="a folder (scenes.json and its scenes, or just glTF files) or a glTF file")
    parser.add_argument("out", type=Path, help="folder for reports")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="NAME,...", help="these scenes alone")
    parser.add_argument("--kindling", type=Path, metavar="PATH", help="the program (build/release/kindling)")
    arguments = sys.argv[1:] if arguments is None else arguments
    own = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_args(arguments[:own])
    options.flags = arguments[own + 1:]
    return options


def command(kindling, job, stem, flags):
    words = [kindling, "scaling", job.scene, "--size", f"{job.size_px[0]}x{job.size_px[1]}", "--max-bounces", job.max_bounces,
             "--json", f"{stem}.json", "--csv", f"{stem}.csv", "--svg", f"{stem}.svg"]
    if job.environment:
        words += ["--env", job.environment, "--env-rotation", job.environment_rotation_deg, "--env-intensity", job.environment_intensity]
    if not job.background_visible:
        words += ["--background", "0,0,0"]
    return [str(word) for word in [*words, *flags]]


def row_of(accelerator, schedule, threads):
    rows = [row for row in accelerator["render"] if row["schedule"] == schedule and row["threads"] == threads]
    return rows[0] if rows else None


def table_of(reports):
    """Markdown: efficiency and idle time with as many threads as cores, or the largest count below. `reports`: {name: report of kindling scaling}."""
    first = next(iter(reports.values()))
    threads = max(n for n in first["thread_counts"] if n <= first["cores"])
    columns = [(a["name"], schedule) for a in first["scenes"][0]["accelerators"] for schedule in a["amdahl"]]
    heads = [f"{name}, {schedule}" for name, schedule in columns]
    lines = ["| scene | samples per pixel | " + " | ".join(f"efficiency at {threads}: {head} | idle" for head in heads) + " | ready, speed-up | peak memory, MiB |",
             "|---" * (4 + 2 * len(heads)) + "|"]
    efficiencies = {column: [] for column in columns}
    for name, report in reports.items():
        scene = report["scenes"][0]
        cells, peaks = [name, str(scene["spp"])], []
        for accelerator, schedule in columns:
            row = row_of(next(a for a in scene["accelerators"] if a["name"] == accelerator), schedule, threads)
            if row is None:  # interrupted
                cells += ["-", "-"]
                continue
            efficiencies[accelerator, schedule].append(row["efficiency"])
            cells += [f"{row['efficiency']:.3f}", f"{100 * row['idle_share']:.1f} %"]
            peaks.append(row["peak_rss_bytes"])
        ready = next(phase for phase in scene["preparation"] if phase["phase"].startswith("all"))
        cells.append(f"{next(point['speedup'] for point in ready['threads'] if point['threads'] == threads):.2f}")
        cells.append(f"{max(peaks) / 2 ** 20:.0f}" if peaks and None not in peaks else "unknown")
        lines.append("| " + " | ".join(cells) + " |")
    means = ["geometric mean", ""]
    for column in columns:
        values = [value for value in efficiencies[column] if value > 0]
        means += [f"{statistics.geometric_mean(values):.3f}" if values else "-", ""]
    return "\n".join([*lines, "| " + " | ".join([*means, "", ""]) + " |"]) + "\n"


def main():
    options = parse_arguments()
    kindling = renderers.find_kindling(options.kindling)
    options.out.mkdir(parents=True, exist_ok=True)
    reports, failed = {}, False
    for job in renderers.load_jobs([options.scenes], scenes=options.only):
        stem = options.out / job.name
        result = subprocess.run(command(kindling, job, stem, options.flags), check=False)
        failed = failed or result.returncode != 0
        if result.returncode not in (0, 1):
            return result.returncode
        reports[job.name] = json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))
    table = table_of(reports)
    (options.out / "scaling.md").write_text(table, encoding="utf-8")
    print(table)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
