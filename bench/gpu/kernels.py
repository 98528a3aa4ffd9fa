"""The time of a render by kernel, and what bounds each, measured by Nsight Compute (ncu)."""
# SPDX-License-Identifier: Apache-2.0
import csv
import re

from one_round import Skipped, chosen_jobs, find_tool

SIZE, SPP = "960x540", 1  # one pass, half a million paths: ncu repeats each launch several times
DURATION = "gpu__time_duration.sum"
# Averages over the launches of a kernel, weighted by their time, by the name in the result.
AVERAGES = {
    "multiprocessors, %": "sm__throughput.avg.pct_of_peak_sustained_elapsed",
    "caches and memory, %": "gpu__compute_memory_throughput.avg.pct_of_peak_sustained_elapsed",
    "memory, %": "dram__throughput.avg.pct_of_peak_sustained_elapsed",
    "occupancy, %": "sm__warps_active.avg.pct_of_peak_sustained_active",
    "lanes of 32": "smsp__thread_inst_executed_per_inst_executed.ratio",
}
REGISTERS = "launch__registers_per_thread"
SECONDS = {"nsecond": 1e-9, "ns": 1e-9, "usecond": 1e-6, "us": 1e-6, "msecond": 1e-3, "ms": 1e-3, "second": 1.0, "s": 1.0}
BUSY_PERCENT = 60.0  # a unit below this share of its peak is no bound: instructions wait for each other
SAME_PERCENT = 2.0  # figures that are measured in different passes differ by so much
# Messages of a machine that forbids or lacks the counters, and of a program without kernels.
NO_COUNTERS = r"ERR_NVGPUCTRPERM|Failed to initialize the profiler|not supported|No kernels were profiled"


def kernels(the_round):
    """The kernels of a short render of dragon and hotel, without guide and path reuse."""
    ncu = find_tool("ncu")
    table = the_round.found.setdefault("kernels", {})
    for job in chosen_jobs("dragon", "hotel", otherwise="interior.glb"):
        if the_round.is_over():
            table["ended early before"] = job.name
            break
        metrics = ",".join([DURATION, REGISTERS, *AVERAGES.values()])
        result = the_round.run_tool(
            [ncu, "--csv", "--page", "raw", "--print-units", "base", "--clock-control", "none", "--cache-control", "none", "--metrics", metrics,
             *the_round.render_command(job, the_round.folder / "kernels.png", "--guiding", "off", "--path-reuse", "1", spp=SPP, size=SIZE)])
        launches = launches_of(result.stdout)
        if result.returncode != 0 or not launches:
            refuse(result)
        table[job.name] = by_kernel(launches)
        the_round.save()
    return table


def refuse(result):
    messages = [line for line in result.stdout.splitlines() if re.match(r"==(ERROR|WARNING)==", line)] or result.stdout.strip().splitlines()[-3:]
    text = f"ncu: exit code {result.returncode}: {' '.join(messages) or 'no output'}"
    raise (Skipped if re.search(NO_COUNTERS, result.stdout) else RuntimeError)(text)


def launches_of(output):
    """The rows of ncu's table as dicts of strings. Lines before it, ncu's messages (==PROF== ...) and other programs' lines are left
    out; the row of units that follows the header becomes part of the duration: "_s"."""
    header, units, launches = None, None, []
    for row in csv.reader(line for line in output.splitlines() if not line.startswith("==")):
        if "Kernel Name" in row:
            header, units = row, None
        elif header is None or len(row) != len(header):
            continue
        elif units is None and not row[header.index("ID")].strip():
            units = dict(zip(header, row))
        elif DURATION in header:
            launch = dict(zip(header, row))
            duration = number(launch[DURATION])
            if duration is not None:
                unit = (units or {}).get(DURATION, "ns")
                if unit not in SECONDS:
                    raise ValueError(f"ncu: {DURATION} in '{unit}'; {', '.join(SECONDS)} were expected")
                launches.append(launch | {"_s": duration * SECONDS[unit]})
    return launches


def number(text):
    """A number as ncu prints it, with commas between thousands; None: not measured."""
    try:
        return float((text or "").replace(",", ""))
    except ValueError:
        return None


def by_kernel(launches):
    """{kernel: figures}, the longest first; the last row, "all", has the whole render."""
    groups = {}
    for launch in launches:
        name = re.sub(r"\(.*", "", launch["Kernel Name"], flags=re.S).strip().removeprefix("kindling_")
        groups.setdefault(name, []).append(launch)
    total_s = sum(launch["_s"] for launch in launches)
    rows = sorted(((name, figures(group, total_s)) for name, group in groups.items()), key=lambda row: -row[1]["ms"])
    return dict(rows) | {"all": figures(launches, total_s)}


def figures(launches, total_s):
    """Sums and averages of a kernel's launches."""
    seconds = sum(launch["_s"] for launch in launches)
    row = {"launches": len(launches), "ms": seconds * 1e3, "share, %": 100.0 * seconds / total_s if total_s > 0.0 else 0.0}
    row |= {name: weighted(launches, metric) for name, metric in AVERAGES.items()}
    registers = [value for launch in launches if (value := number(launch.get(REGISTERS))) is not None]
    return row | {"registers": int(max(registers)) if registers else None, "bound": bound(row)}


def weighted(launches, metric):
    """The average weighted by time, of the launches that have the metric; None: none of them has it."""
    pairs = [(launch["_s"], value) for launch in launches if (value := number(launch.get(metric))) is not None]
    seconds = sum(weight for weight, _ in pairs)
    return sum(weight * value for weight, value in pairs) / seconds if seconds > 0.0 else None


def bound(row):
    """The unit of a roofline that limits a kernel; latency where none of them is busy."""
    units = {"arithmetic": row["multiprocessors, %"], "caches": row["caches and memory, %"], "memory": row["memory, %"]}
    known = {name: percent for name, percent in units.items() if percent is not None}
    if "memory" in known and known["memory"] >= known.get("caches", 0.0) - SAME_PERCENT:
        known.pop("caches", None)  # its figure includes that of memory
    name = max(known, key=known.get, default=None)
    return name if name is None or known[name] >= BUSY_PERCENT else "latency"
