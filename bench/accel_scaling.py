#!/usr/bin/env python3
"""How build time and speed of the kd-tree and of Embree depend on the number of triangles.

Runs bench_scaling for each shape and size, one process each, and, for scenes that are given, `kindling shootout` for further
points. Prints build time over N log2 N, the exponent of the growth of build time and what speed loses with every doubling,
and writes a table (CSV) and a page with plots that needs nothing else (HTML).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import csv
import html
import io
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SIZES = [1000, 3000, 10000, 30000, 100000, 300000, 1000000, 3000000, 10000000]
SPEEDS = {  # column: title of its plot
    "camera_single_mrays_s": "Camera rays, single calls",
    "camera_coherent_mrays_s": "Camera rays, coherent calls",
    "bounce1_single_mrays_s": "First bounce, single calls",
    "bounce1_batch_mrays_s": "First bounce, batches",
    "bounce2_single_mrays_s": "Second bounce, single calls",
    "bounce2_batch_mrays_s": "Second bounce, batches",
    "ambient_batch_mrays_s": "Ambient occlusion, batches",
}
SHOOTOUT = {  # variant of a shootout: accelerator of bench_scaling
    "kdtree": "kdtree", "embree": "embree medium robust", "embree:non-robust": "embree medium",
    "embree:best:non-robust": "embree high"}
SHOOTOUT_ROWS = {  # (rays, call) of a shootout: column
    ("camera", "single"): "camera_single_mrays_s", ("camera", "coherent"): "camera_coherent_mrays_s",
    ("bounce1", "single"): "bounce1_single_mrays_s", ("bounce1", "batch"): "bounce1_batch_mrays_s",
    ("ambient-occlusion", "batch"): "ambient_batch_mrays_s"}
COLORS = ["#0072b2", "#e69f00", "#009e73", "#d55e00"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=Path, help="glTF scenes for further points, by `kindling shootout`")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "release", help="build folder (build/release)")
    parser.add_argument("--shapes", default="hall,sphere,soup", help="(hall,sphere,soup)")
    parser.add_argument("--sizes", default=",".join(map(str, SIZES)),
                        help="triangles; ten million need 10 GB (1000 to 10000000 in steps of about 3)")
    parser.add_argument("--repeat", type=int, default=3, help="(3)")
    parser.add_argument("--csv", type=Path, default=Path("accel_scaling.csv"), help="(accel_scaling.csv)")
    parser.add_argument("--html", type=Path, default=Path("accel_scaling.html"), help="(accel_scaling.html)")
    parser.add_argument("--from-csv", type=Path, help="measure nothing; fit and plot this table")
    options = parser.parse_args()

    if options.from_csv:
        rows = parse(options.from_csv.read_text())
    else:
        try:
            rows = measure(options)
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"accel_scaling.py: error: {error}")
        write_csv(options.csv, rows)
    fits = fit_all(rows)
    print(format_fits(fits))
    options.html.write_text(page(rows, fits))
    print(f"wrote {options.html}" + ("" if options.from_csv else f" and {options.csv}"))


# --- measuring

def measure(options):
    rows = []
    for shape in options.shapes.split(","):
        for size in options.sizes.split(","):
            print(f"{shape}, {size} triangles", file=sys.stderr)
            command = [options.build / "bench" / "accel" / "bench_scaling", shape, size, str(options.repeat)]
            rows += parse(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
    for scene in options.scenes:
        print(scene, file=sys.stderr)
        rows += race(options, scene)
    return rows


def race(options, scene):
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "race.json"
        subprocess.run([options.build / "kindling", "shootout", scene, "--clock", "cpu", "--no-embree-calls", "--repeat",
                        str(options.repeat), "--build-repeat", str(options.repeat), "--json", report],
                       check=True, stdout=subprocess.DEVNULL)
        return rows_of_shootout(json.loads(report.read_text()))


def rows_of_shootout(report):
    rows = []
    for scene in report["scenes"]:
        for accelerator in scene["accelerators"]:
            if accelerator["name"] not in SHOOTOUT:
                continue
            row = {"shape": Path(scene["file"]).name, "triangles": scene["triangles"],
                   "accelerator": SHOOTOUT[accelerator["name"]], "build_threads": report["build_threads"],
                   "build_1_thread_s": accelerator["build"]["one_thread"]["median_s"],
                   "build_all_s": accelerator["build"]["many_threads"]["median_s"],
                   "memory_bytes": accelerator["memory_bytes"]}
            for result in accelerator["traversal"]:
                column = SHOOTOUT_ROWS.get((result["rays"], result["call"]))
                if column:
                    row[column] = result["mega_rays_per_s"]
            rows.append(row)
    return rows


def parse(text):
    """Rows of a table as dictionaries; numbers as numbers, empty fields left out."""
    rows = []
    for fields in csv.DictReader(io.StringIO(text)):
        rows.append({key: value if key in ("shape", "accelerator") else float(value)
                     for key, value in fields.items() if value != ""})
    return rows


def write_csv(path, rows):
    columns = ["shape", "triangles", "accelerator", "build_1_thread_s", "build_threads", "build_all_s", "memory_bytes",
               *SPEEDS]
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n", restval="")
        writer.writeheader()
        writer.writerows(rows)


# --- fitting

def slope(points):
    """Least squares of y = a + b x; b, or None for fewer than two x."""
    n = len(points)
    mean_x = sum(x for x, _ in points) / n if n else 0
    mean_y = sum(y for _, y in points) / n if n else 0
    spread = sum((x - mean_x) ** 2 for x, _ in points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / spread if spread > 0 else None


def n_log_n_ns(row):
    """Nanoseconds of one thread's build over N log2 N."""
    n = row["triangles"]
    return row["build_1_thread_s"] * 1e9 / (n * math.log2(max(n, 2)))


def series(rows):
    """Rows by (shape, accelerator), by size."""
    found = {}
    for row in rows:
        found.setdefault((row["shape"], row["accelerator"]), []).append(row)
    return {key: sorted(group, key=lambda row: row["triangles"]) for key, group in found.items()}


def fit_all(rows):
    """For each shape and accelerator of several sizes: ns over N log2 N from the smallest to the largest; the exponent of build time; and by
    kind of rays the percentage of speed that every doubling of the triangles costs. Below 10000 triangles fixed costs and
    caches rule, so that exponents leave those out where larger ones are."""
    fits = []
    for (shape, accelerator), group in series(rows).items():
        if len(group) < 2:
            continue
        large = [row for row in group if row["triangles"] >= 9000]
        fitted = large if len(large) > 1 else group
        build = [(math.log(row["triangles"]), math.log(row["build_1_thread_s"])) for row in fitted]
        model = [(math.log(row["triangles"]), math.log(row["triangles"] * math.log2(row["triangles"]))) for row in fitted]
        losses = {}
        for column in SPEEDS:
            points = [(math.log2(row["triangles"]), math.log(row[column])) for row in fitted if column in row]
            fall = slope(points)
            if fall is not None:
                losses[column] = 100 * (1 - math.exp(fall))
        fits.append({"shape": shape, "accelerator": accelerator, "quotients_ns": [n_log_n_ns(row) for row in group],
                     "sizes": [row["triangles"] for row in group], "exponent": slope(build),
                     "n_log_n_exponent": slope(model), "loss_percent": losses})
    return fits


def format_fits(fits):
    lines = ["build on one thread: nanoseconds over N log2 N for each size, and the exponent of its growth above 9000 triangles",
             "(in brackets that of N log2 N over the same sizes)"]
    for fit in fits:
        quotients = " ".join(f"{value:6.2f}" for value in fit["quotients_ns"])
        lines.append(f"  {fit['shape']:8} {fit['accelerator']:22} {quotients}   {fit['exponent']:.3f} "
                     f"({fit['n_log_n_exponent']:.3f})")
    lines.append("speed lost with every doubling of the triangles, percent")
    lines.append("  " + " " * 31 + " ".join(f"{column.removesuffix('_mrays_s'):>16}" for column in SPEEDS))
    for fit in fits:
        losses = " ".join(f"{fit['loss_percent'][c]:16.1f}" if c in fit["loss_percent"] else " " * 15 + "-" for c in SPEEDS)
        lines.append(f"  {fit['shape']:8} {fit['accelerator']:22} {losses}")
    return "\n".join(lines)


# --- plotting

def plot(title, y_label, groups, log_y):
    """SVG of points over triangles. `groups`: (name, colour, dashed, [(x, y)])."""
    left, top, width, height = 64, 30, 460, 250
    points = [point for _, _, _, line in groups for point in line]
    if not points:
        return ""
    low_x, high_x = (f(math.log10(x) for x, _ in points) for f in (min, max))
    low_x, high_x = math.floor(low_x), max(math.ceil(high_x), math.floor(low_x) + 1)
    if log_y:
        low_y, high_y = (f(math.log10(y) for _, y in points) for f in (min, max))
        low_y, high_y = math.floor(low_y), max(math.ceil(high_y), math.floor(low_y) + 1)
        ticks = [10.0 ** e for e in range(low_y, high_y + 1)]
    else:
        largest = max(y for _, y in points)
        step = 10 ** math.floor(math.log10(largest / 4))
        step *= max(f for f in (1, 2, 5) if f * step * 4 <= largest)
        low_y, high_y = 0, step * math.ceil(largest / step)
        ticks = [i * step for i in range(round(high_y / step) + 1)]
    to_y = math.log10 if log_y else float

    def place(x, y):
        return (left + width * (math.log10(x) - low_x) / (high_x - low_x),
                top + height * (1 - (to_y(y) - low_y) / (high_y - low_y)))

    svg = [f'<svg viewBox="0 0 {left + width + 20} {top + height + 40}" role="img" aria-label="{html.escape(title)}">',
           f'<text x="{left}" y="18" class="title">{html.escape(title)}</text>']
    for tick in ticks:
        y = place(10 ** low_x, tick)[1]
        svg.append(f'<line x1="{left}" x2="{left + width}" y1="{y:.1f}" y2="{y:.1f}" class="grid"/>'
                   f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
    for e in range(low_x, high_x + 1):
        x = place(10 ** e, ticks[-1])[0]
        svg.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{top + height}" class="grid"/>'
                   f'<text x="{x:.1f}" y="{top + height + 16}" text-anchor="middle">{short(10 ** e)}</text>')
    svg.append(f'<text x="{left + width / 2}" y="{top + height + 34}" text-anchor="middle">triangles</text>'
               f'<text transform="translate(14 {top + height / 2}) rotate(-90)" text-anchor="middle">{html.escape(y_label)}</text>')
    for name, color, dashed, line in groups:
        if len(line) > 1:
            path = " L".join(f"{x:.1f} {y:.1f}" for x, y in (place(*point) for point in line))
            dash = ' stroke-dasharray="5 4"' if dashed else ""
            svg.append(f'<path d="M{path}" fill="none" stroke="{color}" stroke-width="2"{dash}/>')
        for point in [] if dashed else line:
            x, y = place(*point)
            svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{color}"><title>{html.escape(name)}: '
                       f'{point[0]:,.0f} triangles, {point[1]:.4g}</title></circle>')
    return "\n".join(svg) + "\n</svg>\n"


def short(count):
    return f"{count // 10**6} M" if count >= 10**6 else f"{count // 1000} k" if count >= 1000 else str(count)


def accelerators(rows):
    return list(dict.fromkeys(row["accelerator"] for row in rows))


def shapes(rows):
    """Generated shapes, which have several sizes, and the scenes, which are points beside each of them."""
    sizes = {}
    for row in rows:
        sizes.setdefault(row["shape"], set()).add(row["triangles"])
    return [s for s in sizes if len(sizes[s]) > 1], [s for s in sizes if len(sizes[s]) == 1]


def plot_column(rows, shape, title, y_label, value, log_y, model=None):
    _, scenes = shapes(rows)
    groups = []
    for number, accelerator in enumerate(accelerators(rows)):
        color = COLORS[number % len(COLORS)]
        for source in [shape, *scenes]:
            line = [(row["triangles"], value(row)) for row in rows
                    if row["accelerator"] == accelerator and row["shape"] == source and value(row)]
            groups.append((f"{accelerator}, {source}", color, False, sorted(line)))
        if model and groups and len(groups[-1 - len(scenes)][3]) > 1:
            line = groups[-1 - len(scenes)][3]
            factor = math.exp(sum(math.log(y / model(x)) for x, y in line) / len(line))
            groups.append((f"{accelerator}: {factor:.3g} N log2 N", color, True, [(x, factor * model(x)) for x, _ in line]))
    return plot(title, y_label, groups, log_y)


def page(rows, fits):
    lines, scenes = shapes(rows)
    text = ["""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Scaling of the accelerators</title><style>
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1140px; margin: 2em auto; padding: 0 1em; }
.plots { display: flex; flex-wrap: wrap; gap: 1em; } svg { width: 544px; max-width: 100%; height: auto; }
svg text { font: 12px system-ui, sans-serif; fill: #222; } svg text.title { font-weight: 600; font-size: 14px; } .grid { stroke: #ddd; }
.key { display: inline-block; width: 12px; height: 12px; margin: 0 .4em 0 1.2em; } pre { overflow-x: auto; font-size: 12px; }
</style></head><body>
<h1>Build time and speed against the number of triangles</h1>
<p>One thread, CPU time; medians. Dashed: N log<sub>2</sub> N through the geometric mean."""]
    if scenes:
        text.append(" Single points: " + html.escape(", ".join(scenes)) + ".")
    text.append("</p>\n<p>")
    for number, accelerator in enumerate(accelerators(rows)):
        text.append(f'<span class="key" style="background:{COLORS[number % len(COLORS)]}"></span>{html.escape(accelerator)}')
    text.append("</p>\n")
    for shape in lines:
        text.append(f'<h2>{html.escape(shape)}</h2>\n<div class="plots">\n')
        text.append(plot_column(rows, shape, "Build", "seconds", lambda row: row.get("build_1_thread_s"), True,
                                lambda n: n * math.log2(max(n, 2))))
        text.append(plot_column(rows, shape, "Build over N log2 N", "nanoseconds", n_log_n_ns, False))
        text.append(plot_column(rows, shape, "Memory", "bytes per triangle",
                                lambda row: row["memory_bytes"] / row["triangles"], False))
        for column, title in SPEEDS.items():
            text.append(plot_column(rows, shape, title, "million rays/s", lambda row, c=column: row.get(c), True))
        text.append("</div>\n")
    text.append(f"<h2>Fits</h2>\n<pre>{html.escape(format_fits(fits))}</pre>\n</body></html>\n")
    return "".join(text)


if __name__ == "__main__":
    main()
