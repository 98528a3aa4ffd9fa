#!/usr/bin/env python3
"""Draws the plots of the root README as SVG: a race of accelerators, efficiency of threads.

    build/release/kindling shootout SCENE... --clock cpu --no-embree-calls --json race.json
    bench/readme_plots.py shootout race.json -o scenes/images/shootout.svg
    bench/readme_plots.py scaling bench/README.md -o scenes/images/scaling.svg

`shootout` reads the report of `kindling shootout`: million rays per second by kind of rays, the
fastest call of each accelerator, and build time and memory, as geometric means of its scenes.
`scaling` reads the table of efficiencies in a Markdown file, as bench/thread_scaling.py prints it;
of a scene with several rows the last one counts. --machine names the processor in the caption.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import html
import json
import sys
from pathlib import Path
from statistics import geometric_mean

import plots

KINDS = {"camera": "camera", "bounce1": "1st bounce", "bounce3": "3rd bounce", "shadow1": "shadow", "ambient-occlusion": "ambient occlusion"}
EMBREE, FASTEST, KDTREE = "Embree, robust", "Embree, not robust", "kd-tree (watertight)"
COLORS = {EMBREE: "#e69f00", FASTEST: "#f2cf87", KDTREE: "#0072b2"}
BAR_PX, GAP_PX, HEIGHT_PX, TOP_PX, LEFT_PX = 18, 6, 190, 62, 44


def best_speed(accelerators, kind):
    """Million rays per second of the fastest call of the fastest of these accelerators."""
    return max(row["mega_rays_per_s"] for accelerator in accelerators for row in accelerator["traversal"] if row["rays"] == kind)


def race(report):
    """(speeds, costs) of a shootout: {kind: {contestant: million rays/s}} and {quantity: {contestant: times Embree's}}, geometric means."""
    speeds, costs = {}, {}
    scenes = []
    for scene in report["scenes"]:
        by_name = {accelerator["name"]: accelerator for accelerator in scene["accelerators"]}
        others = [accelerator for name, accelerator in by_name.items() if name.startswith("embree") and name != "embree"]
        scenes.append({EMBREE: [by_name["embree"]], FASTEST: others, KDTREE: [by_name["kdtree"]]})
    for kind, title in KINDS.items():
        speeds[title] = {name: geometric_mean([best_speed(scene[name], kind) for scene in scenes]) for name in COLORS}
    for title, value in (("build time", lambda a: a["build"]["one_thread"]["median_s"]), ("memory", lambda a: a["memory_bytes"])):
        costs[title] = {name: geometric_mean([value(scene[name][0]) / value(scene[EMBREE][0]) for scene in scenes]) for name in (EMBREE, KDTREE)}
    return speeds, costs


def efficiencies(markdown):
    """{scene: {"kd-tree": e, "Embree": e}} from the first table with columns `scene` and `efficiency, ...`."""
    found, columns, scene = {}, None, None
    for line in markdown.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        if not cells:
            if found:
                break
            columns = None
        elif columns is None:
            heads = {number: cell.split("efficiency, ")[1] for number, cell in enumerate(cells) if cell.startswith("efficiency, ")}
            columns = heads if cells[0] == "scene" and heads else None
        elif not cells[0].startswith("---"):
            scene = cells[0] or scene
            found[scene] = {name: float(cells[number]) for number, name in columns.items()}
    return found


def bars(groups, colors, title, left, width, digits):
    """One panel of grouped bars. `groups`: {label: {series: value}}; values stand above the bars."""
    ticks = plots.even_ticks([value for group in groups.values() for value in group.values()])
    svg = [f'<text x="{left}" y="{TOP_PX - 12}" class="title">{html.escape(title)}</text>']
    y_of = lambda value: TOP_PX + HEIGHT_PX * (1 - value / ticks[-1])
    for tick in ticks:
        svg.append(f'<line x1="{left}" x2="{left + width}" y1="{y_of(tick):.1f}" y2="{y_of(tick):.1f}" class="grid"/>'
                   f'<text x="{left - 6}" y="{y_of(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
    step = width / len(groups)
    for place, (label, group) in enumerate(groups.items()):
        start = left + step * (place + 0.5) - (BAR_PX + GAP_PX) * len(group) / 2
        for number, (name, value) in enumerate(group.items()):
            x = start + (BAR_PX + GAP_PX) * number
            svg.append(f'<rect x="{x:.1f}" y="{y_of(value):.1f}" width="{BAR_PX}" height="{HEIGHT_PX + TOP_PX - y_of(value):.1f}" fill="{colors[name]}"/>'
                       f'<text x="{x + BAR_PX / 2:.1f}" y="{y_of(value) - 3:.1f}" text-anchor="middle" class="value">{value:.{digits}f}</text>')
        for row, words in enumerate(wrap(label)):
            svg.append(f'<text x="{left + step * (place + 0.5):.1f}" y="{TOP_PX + HEIGHT_PX + 16 + 13 * row}" text-anchor="middle">{html.escape(words)}</text>')
    return svg


def wrap(label):
    """A label on one line or, from 11 letters on, on two."""
    words = label.split()
    return [label] if len(label) < 11 or len(words) < 2 else [" ".join(words[:-1]), words[-1]]


def image(panels, colors, width, caption):
    """The SVG, with a key above and a caption below, on white: READMEs show it on dark pages too."""
    height = TOP_PX + HEIGHT_PX + 66
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" aria-label="{html.escape(caption)}">',
           "<style>text { font: 12px system-ui, sans-serif; fill: #222; } .title { font-weight: 600; } .value { font-size: 9.5px; fill: #555; } "
           ".grid { stroke: #ddd; } .caption { fill: #555; }</style>",
           f'<rect width="{width}" height="{height}" fill="#fff"/>']
    x = LEFT_PX
    for name, fill in colors.items():
        svg.append(f'<rect x="{x}" y="12" width="12" height="12" fill="{fill}"/><text x="{x + 17}" y="22">{html.escape(name)}</text>')
        x += 34 + 6.6 * len(name)
    svg += [line for panel in panels for line in panel]
    svg.append(f'<text x="{LEFT_PX}" y="{height - 10}" class="caption">{html.escape(caption)}</text>')
    return "\n".join(svg) + "\n</svg>\n"


def shootout_image(report, machine):
    speeds, costs = race(report)
    clock = "CPU" if report.get("clock") == "cpu" else "wall"
    caption = f"Geometric means of {len(report['scenes'])} scenes, {report['repeat']} rounds of {clock} time, one thread of {machine or report['processor']}"
    return image([bars(speeds, COLORS, "million rays per second", LEFT_PX, 470, 1), bars(costs, COLORS, "relative to Embree", 570, 170, 2)], COLORS, 760, caption)


def scaling_image(markdown, machine):
    groups = efficiencies(markdown)
    if not groups:
        sys.exit("readme_plots.py: no table with the columns 'scene' and 'efficiency, ...'")
    groups = {scene.split(",")[0]: group for scene, group in groups.items()}
    colors = {name: COLORS[KDTREE] if name == "kd-tree" else COLORS[EMBREE] for name in next(iter(groups.values()))}
    caption = f"Medians of three interleaved rounds{', ' + machine if machine else ''}; 1 is twice the speed of one thread"
    return image([bars(groups, colors, "efficiency with two threads", LEFT_PX, 700, 2)], colors, 760, caption)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plot", choices=["shootout", "scaling"])
    parser.add_argument("source", type=Path, help="report of the shootout (JSON), or Markdown with a table of efficiencies")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.svg")
    parser.add_argument("--machine", default="", help="name of the processor (default: as the report has it)")
    options = parser.parse_args(arguments)
    text = options.source.read_text(encoding="utf-8")
    svg = shootout_image(json.loads(text), options.machine) if options.plot == "shootout" else scaling_image(text, options.machine)
    options.out.write_text(svg, encoding="utf-8")


if __name__ == "__main__":
    main()
