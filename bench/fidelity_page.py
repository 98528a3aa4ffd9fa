"""The page of fidelity.py: for each scenario our image, the goldens, and where they differ."""
# SPDX-License-Identifier: Apache-2.0
import base64
import html

import plots
from fidelity_scenarios import PATH_TRACERS

STYLE = """body { max-width: none; } figure { margin: 0; width: var(--w); } figure img { display: block; width: 100%; background: #777; }
figure img.map { background: #000; } figcaption { font-size: 12px; line-height: 1.35; } .row { display: flex; flex-wrap: wrap; gap: .5em; }
section { border-top: 1px solid #ccc; margin-top: 1em; } h2 { font-size: 17px; margin: .5em 0; } h2 small { font-weight: 400; color: #666; }
table { border-collapse: collapse; font-size: 13px; } td, th { padding: .1em .7em; border-bottom: 1px solid #ddd; text-align: right; }
td:first-child { text-align: left; } .pt { font-weight: 600; } .worse { color: #b00; } .better { color: #080; } .note { color: #a00; }
"""
# A pointer over a golden shows our image in its place, so differences flip.
SCRIPT = """<script>
document.querySelectorAll("img.golden").forEach(golden => {
  const theirs = golden.src, ours = golden.closest("section").querySelector("img.ours").src;
  golden.addEventListener("mouseenter", () => golden.src = ours);
  golden.addEventListener("mouseleave", () => golden.src = theirs);
});
</script>
"""


def page(result, images):
    """Returns the page. result: the content of the JSON file, scenarios in their order on the page. images: {scenario: {"ours": webp bytes,
    "goldens": {renderer: (mime type, bytes, PNG bytes of the difference map)}}}."""
    text = [plots.page_start("Render fidelity", STYLE), "<h1>Render fidelity</h1>\n",
            f"<p>{html.escape(result['settings']['folder'])}: {len(result['scenarios'])} scenarios, {result['settings']['spp']} samples "
            "per pixel. FLIP: 0 the same, 1 as different as can be; &Delta;E: CIEDE2000; ratio: mean linear radiance, ours / theirs, red green "
            "blue; means over opaque pixels. Path tracers in bold; what sorts is the median of their FLIP, without them that of all. Hold the pointer "
            "on a golden to see our image in its place.</p>\n", summary(result["scenarios"])]
    for scenario in result["scenarios"]:
        text.append(section(scenario, images[scenario["name"]]))
    text.append(SCRIPT + "</body></html>\n")
    return "".join(text)


def summary(scenarios):
    compared = any("before" in scenario for scenario in scenarios)
    head = ["scenario", "goldens", "FLIP least", "FLIP median", "&Delta;E least", "&Delta;E median"] + (["FLIP median before"] if compared else [])
    rows = ["<tr>" + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>\n"]
    for scenario in scenarios:
        name = html.escape(scenario["name"])
        cells = [f'<a href="#{name}">{name}</a>', str(len(scenario["goldens"]))]
        cells += [number(scenario["summary"][key]) for key in ("flip_min", "flip_median")]
        cells += [number(scenario["summary"][key], 1) for key in ("delta_e_min", "delta_e_median")]
        if compared:
            before, now = scenario.get("before"), scenario["summary"]["flip_median"]
            kind = "" if before is None or now is None else "worse" if now > before + 0.002 else "better" if now < before - 0.002 else ""
            cells.append(f'<span class="{kind}">{number(before)}</span>')
        rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>\n")
    return "<table>\n" + "".join(rows) + "</table>\n"


def section(scenario, images):
    name = html.escape(scenario["name"])
    text = [f'<section id="{name}" style="--w: {260 if scenario["aspect"] < 1.6 else 380}px"><h2>{name} <small>{html.escape(scenario["file"])}, '
            f'{scenario["seconds"]:.1f} s</small></h2>\n']
    if scenario["messages"]:
        text.append(f'<pre class="note">{html.escape(scenario["messages"])}</pre>\n')
    text.append('<div class="row">\n')
    if images.get("ours"):
        text.append(figure([("ours", "image/webp", images["ours"])], "Kindling", ""))
    for renderer, (mime, golden, difference) in images["goldens"].items():
        figures = scenario["goldens"][renderer]
        ratio = " ".join(number(value, 2) for value in figures["ratio"])
        caption = (f"FLIP {number(figures['flip'])}, &Delta;E {number(figures['delta_e'], 1)}<br>ratio {ratio}"
                   + (f"<br>silhouette {100 * figures['silhouette']:.1f} %" if figures["silhouette"] > 0.005 else ""))
        text.append(figure([("golden", mime, golden), ("map", "image/png", difference)], renderer, caption))
    text.append("</div></section>\n")
    return "".join(text)


def figure(images, renderer, caption):
    kind = "pt" if renderer in PATH_TRACERS else ""
    shown = "".join(f'<img class="{css}" alt="{html.escape(renderer)} {css}" src="data:{mime};base64,{base64.b64encode(data).decode("ascii")}">'
                    for css, mime, data in images)
    return f'<figure>{shown}<figcaption><span class="{kind}">{html.escape(renderer)}</span> {caption}</figcaption></figure>\n'


def number(value, digits=3):
    return "&ndash;" if value is None else f"{value:.{digits}f}"
