"""Plots as SVG within self-contained pages, and straight lines through points."""
# SPDX-License-Identifier: Apache-2.0
import html
import math

COLORS = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#000000"]
STYLE = """body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1140px; margin: 2em auto; padding: 0 1em; }
.plots { display: flex; flex-wrap: wrap; gap: 1em; } svg { width: 544px; max-width: 100%; height: auto; }
svg text { font: 12px system-ui, sans-serif; fill: #222; } svg text.title { font-weight: 600; font-size: 14px; } .grid { stroke: #ddd; }
.key { display: inline-block; width: 12px; height: 12px; margin: 0 .4em 0 1.2em; } pre { overflow-x: auto; font-size: 12px; }
"""


def color(number):
    return COLORS[number % len(COLORS)]


def page_start(title, more_style=""):
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title><style>
{STYLE}{more_style}</style></head><body>
"""


def key(names):
    """A line that names the color of each series."""
    return "<p>" + "".join(f'<span class="key" style="background:{color(number)}"></span>{html.escape(name)}'
                           for number, name in enumerate(names)) + "</p>\n"


def slope(points):
    """Least squares of y = a + b x; b, or None for fewer than two x."""
    n = len(points)
    mean_x = sum(x for x, _ in points) / n if n else 0
    mean_y = sum(y for _, y in points) / n if n else 0
    spread = sum((x - mean_x) ** 2 for x, _ in points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / spread if spread > 0 else None


def decades(values):
    """The whole powers of ten, at least one apart, that enclose positive values."""
    low = math.floor(math.log10(min(values)))
    return low, max(math.ceil(math.log10(max(values))), low + 1)


def plot(title, x_label, y_label, groups, log_y, log_x=True):
    """SVG of points over a logarithmic x, or one of whole numbers. `groups`: (name, color, dashed, [(x, y)])."""
    left, top, width, height = 64, 30, 460, 250
    points = [point for _, _, _, line in groups for point in line]
    if not points:
        return ""
    low_x, high_x = decades([x for x, _ in points]) if log_x else (min(x for x, _ in points), max(x for x, _ in points))
    if log_y:
        low_y, high_y = decades([y for _, y in points])
        ticks = [10.0 ** e for e in range(low_y, high_y + 1)]
    else:
        ticks = even_ticks([y for _, y in points])
        low_y, high_y = ticks[0], ticks[-1]
    to_x, to_y = math.log10 if log_x else float, math.log10 if log_y else float

    def place(x, y):
        return (left + width * (to_x(x) - low_x) / max(high_x - low_x, 1e-9),
                top + height * (1 - (to_y(y) - low_y) / (high_y - low_y)))

    svg = [f'<svg viewBox="0 0 {left + width + 20} {top + height + 40}" role="img" aria-label="{html.escape(title)}">',
           f'<text x="{left}" y="18" class="title">{html.escape(title)}</text>']
    first_x = 10 ** low_x if log_x else low_x
    for tick in ticks:
        y = place(first_x, tick)[1]
        svg.append(f'<line x1="{left}" x2="{left + width}" y1="{y:.1f}" y2="{y:.1f}" class="grid"/>'
                   f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
    for x_tick in [10.0 ** e for e in range(low_x, high_x + 1)] if log_x else whole_ticks(low_x, high_x):
        x = place(x_tick, ticks[-1])[0]
        svg.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{top + height}" class="grid"/>'
                   f'<text x="{x:.1f}" y="{top + height + 16}" text-anchor="middle">{short(x_tick)}</text>')
    svg.append(f'<text x="{left + width / 2}" y="{top + height + 34}" text-anchor="middle">{html.escape(x_label)}</text>'
               f'<text transform="translate(14 {top + height / 2}) rotate(-90)" text-anchor="middle">{html.escape(y_label)}</text>')
    for name, stroke, dashed, line in groups:
        if len(line) > 1:
            path = " L".join(f"{x:.1f} {y:.1f}" for x, y in (place(*point) for point in line))
            dash = ' stroke-dasharray="5 4"' if dashed else ""
            svg.append(f'<path d="M{path}" fill="none" stroke="{stroke}" stroke-width="2"{dash}/>')
        for point in [] if dashed else line:
            x, y = place(*point)
            svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{stroke}"><title>{html.escape(name)}: '
                       f'{grouped(point[0])} {html.escape(x_label)}, {point[1]:.4g}</title></circle>')
    return "\n".join(svg) + "\n</svg>\n"


def even_ticks(values):
    """Four to ten steps of 1, 2 or 5 times a power of ten, from 0 or below to all of the values."""
    lowest, highest = min(min(values), 0.0), max(max(values), 0.0)
    span = highest - lowest or 1.0
    step = 10 ** math.floor(math.log10(span / 4))
    step *= max(f for f in (1, 2, 5) if f * step * 4 <= span * 1.000001)
    first = math.floor(lowest / step)
    return [i * step for i in range(first, max(math.ceil(highest / step), first + 1) + 1)]


def whole_ticks(low, high, max_count=16):
    step = max(math.ceil((high - low) / max_count), 1)
    return range(math.ceil(low), math.floor(high) + 1, step)


def short(value):
    return f"{value / 1e6:g} M" if value >= 1e6 else f"{value / 1e3:g} k" if value >= 1e3 else f"{value:g}"


def grouped(value):
    return f"{value:,.0f}" if value >= 1000 else f"{value:.4g}"
