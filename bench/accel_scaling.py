#!/usr/bin/env python3
"""Measures build time and speed of the kd-tree and of Embree by the number of triangles.

Runs bench_scaling for each shape and size, one process each, and `kindling shootout` for further
points on given scenes. Prints build time over N log2 N, the exponent of the growth of build time and
the loss of speed with every doubling, and writes a table (CSV) and a self-contained page (HTML).
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import csv
import html
import io
import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import plots

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
    """Fits for each shape and accelerator with several sizes: ns over N log2 N from the smallest to the largest, the exponent of build time,
    and by kind of rays the percentage of speed that every doubling of the triangles costs. Below 10000 triangles fixed costs and
    caches dominate, so exponents leave these sizes out if there are larger ones."""
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
            fall = plots.slope(points)
            if fall is not None:
                losses[column] = 100 * (1 - math.exp(fall))
        fits.append({"shape": shape, "accelerator": accelerator, "quotients_ns": [n_log_n_ns(row) for row in group],
                     "sizes": [row["triangles"] for row in group], "exponent": plots.slope(build),
                     "n_log_n_exponent": plots.slope(model), "loss_percent": losses})
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

def accelerators(rows):
    return list(dict.fromkeys(row["accelerator"] for row in rows))


def shapes(rows):
    """(generated shapes, which have several sizes; scenes, which are single points)."""
    sizes = {}
    for row in rows:
        sizes.setdefault(row["shape"], set()).add(row["triangles"])
    return [s for s in sizes if len(sizes[s]) > 1], [s for s in sizes if len(sizes[s]) == 1]


def plot_column(rows, shape, title, y_label, value, log_y, model=None):
    _, scenes = shapes(rows)
    groups = []
    for number, accelerator in enumerate(accelerators(rows)):
        color = plots.color(number)
        for source in [shape, *scenes]:
            line = [(row["triangles"], value(row)) for row in rows
                    if row["accelerator"] == accelerator and row["shape"] == source and value(row)]
            groups.append((f"{accelerator}, {source}", color, False, sorted(line)))
        if model and groups and len(groups[-1 - len(scenes)][3]) > 1:
            line = groups[-1 - len(scenes)][3]
            factor = statistics.geometric_mean(y / model(x) for x, y in line)
            groups.append((f"{accelerator}: {factor:.3g} N log2 N", color, True, [(x, factor * model(x)) for x, _ in line]))
    return plots.plot(title, "triangles", y_label, groups, log_y)


def page(rows, fits):
    lines, scenes = shapes(rows)
    text = [plots.page_start("Scaling of the accelerators"), """<h1>Build time and speed against the number of triangles</h1>
<p>One thread, CPU time; medians. Dashed: N log<sub>2</sub> N through the geometric mean."""]
    if scenes:
        text.append(" Single points: " + html.escape(", ".join(scenes)) + ".")
    text.append("</p>\n" + plots.key(accelerators(rows)))
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
