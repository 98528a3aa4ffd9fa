"""The page of a round: a heading and a table or a list for each part."""
# SPDX-License-Identifier: Apache-2.0

NOTES = {
    "speed": "Million samples per second.",
    "times": "Nanoseconds for a sample, by kernel: those of all launches, from events of the device.",
    "kernels": "One pass of samples, each launch measured alone; percentages are of the peak, averages weighted by time. Bound: the unit that is "
               "busiest, or latency where none reaches 60 %.",
    "sanitizer": "Errors of memcheck, hazards of racecheck.",
    "paper": "Seconds; the paper's are of its machine, those of one thread from an eighth of the samples; the device's without its start.",
    "peer": "Rates of path tracing alone, by the clock; cost: how many times Mitsuba's relMSE x s is Kindling's.",
}
# Words for the first column of tables, else "scene".
FIRST_COLUMN = {"sanitizer": "render", "paper": "figure"}


def markdown(found, device):
    """The round as a page."""
    lines = [f"# A round of `--device {device}`", ""]
    for part, result in found.items():
        lines += [f"## {part}", ""]
        if part in NOTES and any(isinstance(row, dict) for row in result.values()):
            lines += [NOTES[part], ""]
        if part == "kernels":
            lines += kernel_tables(result)
        elif part == "speed":
            lines += table_of({scene: rates | ratios(rates) if isinstance(rates, dict) else rates for scene, rates in result.items()})
        elif part in ("times", "shootout", "scaling", "sanitizer", "paper", "peer"):
            lines += table_of(result, FIRST_COLUMN.get(part, "scene"))
        else:
            lines += [f"- {name}: {f'{value:.2f} s' if isinstance(value, float) else value}" for name, value in result.items()]
        lines.append("")
    return "\n".join(lines)


def ratios(rates):
    """Those of the first contestant to each other one."""
    names = list(rates)
    return {f"{names[0]} / {name}": rates[names[0]] / rates[name] for name in names[1:]}


def table_of(result, first="scene"):
    """A table with a row for each entry that is a dict; notes of other kinds as a list."""
    rows = {name: row for name, row in result.items() if isinstance(row, dict)}
    lines = [f"- {name}: {value}" for name, value in result.items() if name not in rows]
    if lines and rows:
        lines.append("")
    if rows:
        names = list(dict.fromkeys(name for row in rows.values() for name in row))
        lines += [f"| {first} | {' | '.join(names)} |", "|---" * (1 + len(names)) + "|"]
        lines += [f"| {scene} | {' | '.join(text_of(row.get(name, '-')) for name in names)} |" for scene, row in rows.items()]
    return lines


def kernel_tables(result):
    """A table for each scene."""
    lines = table_of({name: value for name, value in result.items() if not isinstance(value, dict)})
    for scene, rows in result.items():
        if isinstance(rows, dict):
            lines += [f"### {scene}", "", *table_of(rows, "kernel"), ""]
    return lines


def text_of(value):
    """Numbers below 1 with three digits, others with two decimals."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.2f}" if abs(value) >= 1.0 or value == 0.0 else f"{value:.3g}"
    return str(value).replace("|", "\\|").replace("\n", " ")
