"""The page of equal_noise.py: error against time, and the images side by side."""
# SPDX-License-Identifier: Apache-2.0
import base64
import html

import plots

IMAGE_WIDTH = 320  # pixels


def page(result, table):
    names = list(result["settings"])
    text = [plots.page_start("The cost of equal noise", """figure { margin: 0; } figure img { display: block; image-rendering: pixelated; }
figcaption { font-size: 13px; } .row { display: flex; flex-wrap: wrap; gap: .6em; margin-bottom: .6em; }
table { border-collapse: collapse; font-size: 13px; } td, th { padding: .15em .7em; border-bottom: 1px solid #ddd; text-align: right; }
"""), "<h1>The cost of equal noise</h1>\n<p>Relative squared error against seconds of path tracing ("
            f"{result['clock']} time) on {result['threads']} threads; medians of {result['seeds']} seeds. Dashed: error against the reference, which holds bias "
            "as well.</p>\n", plots.key(names)]
    for scene in result["scenes"]:
        text.append(f'<h2>{html.escape(scene["name"])}</h2>\n<div class="plots">\n')
        text.append(plot_scene(scene, names, "Time", "seconds", "path_tracing_s"))
        text.append(plot_scene(scene, names, "Samples", "samples per pixel", "spp"))
        text.append("</div>\n")
        for spp in dict.fromkeys(image[2] for image in scene["images"] or []):
            text.append('<div class="row">\n')
            text += [figure(caption, png) for caption, _, count, png in scene["images"] if count == spp]
            text.append("</div>\n")
    text.append("<h2>Figures</h2>\n" + html_table(table))
    text.append("<pre>" + html.escape("\n".join(f"{name}: {' '.join(result['common_flags'] + flags) or 'no flags'}"
                                                for name, flags in result["settings"].items())) + "</pre>\n</body></html>\n")
    return "".join(text)


def plot_scene(scene, names, title, x_label, x_key):
    groups = []
    for number, name in enumerate(names):
        for key, dashed in (("noise", False), ("error", True)):
            line = [(row[x_key], row[key]) for row in scene["rows"] if row["setting"] == name and row.get(key) and row[x_key] > 0]
            if line:
                groups.append((name, plots.color(number), dashed, sorted(line)))
    return plots.plot(title, x_label, "relMSE", groups, True)


def figure(caption, png):
    data = base64.b64encode(png).decode("ascii")
    label = html.escape(caption)
    return f'<figure><img alt="{label}" src="data:image/png;base64,{data}"><figcaption>{label}</figcaption></figure>\n'


def html_table(markdown):
    rows = [[cell.strip() for cell in line[2:-2].split(" | ")] for line in markdown.splitlines()]
    tagged = [("th", rows[0])] + [("td", row) for row in rows[2:]]
    return "<table>\n" + "".join("<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>\n"
                                  for tag, row in tagged) + "</table>\n"
