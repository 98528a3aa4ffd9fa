"""The page of the paper's figures: images, times then and now, plots and findings."""
# SPDX-License-Identifier: Apache-2.0
import base64
import html

import plots
import tracers

STYLE = """body { max-width: 1240px; } figure { margin: 0; } figure img { display: block; width: 100%; } figcaption { font-size: 13px; line-height: 1.4; }
.row { display: flex; flex-wrap: wrap; gap: .8em; } .row figure { flex: 1 1 var(--w); max-width: var(--m); } section { border-top: 1px solid #ccc; margin-top: 1.6em; }
h2 { font-size: 20px; margin: .6em 0 .2em; } h3 { font-size: 16px; margin: 1.2em 0 .2em; } table { border-collapse: collapse; font-size: 14px; margin: .6em 0; }
td, th { padding: .15em .8em; border-bottom: 1px solid #ddd; text-align: right; } td:first-child, th:first-child { text-align: left; }
.then { color: #555; } .crops img { image-rendering: pixelated; } .map img { background: #000; } details { font-size: 13px; color: #555; }
nav.sheet { display: grid; grid-template-columns: repeat(auto-fill, minmax(150px, 1fr)); gap: 6px; margin: 1em 0; }
nav.sheet img { width: 100%; aspect-ratio: 1.22; object-fit: cover; display: block; } nav.sheet a { font-size: 12px; text-decoration: none; color: #444; }
"""


def page(result):
    """Returns the page. result: the measurements of run.py; parts that were not requested are missing."""
    head = result["about"]
    clock = " of the processor (the machine was busy), but for distribution" if head["clock"] == "cpu" else ""
    text = [plots.page_start("Ray tracing: the figures of the paper, and Kindling's", STYLE), "<h1>The paper's figures, by Kindling</h1>\n",
            f"<p>Measured on {html.escape(head['machine'])}, {head['cores']} cores, by Kindling {html.escape(head['version'])}; {html.escape(head['when'])}. "
            f"Times are those of rendering alone, in seconds{clock}, unless they say otherwise. The paper's are from its text, on its machines; its scenes are "
            "not published, so these are compositions of what it describes, and the times stand beside each other, not against each other.</p>\n"]
    if head["note"]:
        text.append(f"<p><b>{html.escape(head['note'])}</b></p>\n")
    figures = result.get("figures", [])
    if figures:
        text.append('<nav class="sheet">' + "".join(
            f'<a href="#figure-{f["number"]}">{image(f["scenes"][-1]["renders"][-1]["thumbnail"], f["title"])}{f["number"]}. {html.escape(f["title"])}</a>'
            for f in figures) + "</nav>\n")
        text.append(times_table(figures))
    if "tracers" in result:
        text.append(tracer_section(result["tracers"]))
    if "quality" in result:
        text.append(quality_section(result["quality"]))
    if "edges" in result:
        text.append(edges_section(result["edges"]))
    if "threads" in result:
        text.append(cores_section(result["threads"], result.get("processes")))
    text += [figure_section(figure) for figure in figures]
    return "".join(text) + "</body></html>\n"


def image(webp, alt, mime="image/webp"):
    return f'<img alt="{html.escape(alt)}" src="data:{mime};base64,{base64.b64encode(webp).decode("ascii")}">'


def table(head, rows):
    cells = "".join(f"<th>{cell}</th>" for cell in head)
    return f"<table>\n<tr>{cells}</tr>\n" + "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>\n" for row in rows) + "</table>\n"


def seconds(value):
    return "" if value is None else f"{value:.1f}" if value >= 100 else f"{value:.2f}" if value >= 1 else f"{value:.3f}"


def times_table(figures):
    rows = []
    devices = sorted({render["device"]["name"] for figure in figures for scene in figure["scenes"] for render in scene["renders"] if render["device"]})
    for figure in figures:
        for scene in figure["scenes"]:
            name = figure["number"] + (f", {scene['caption']}" if scene["caption"] else "")
            for number, render in enumerate(scene["renders"]):
                then = "" if number else scene["then"]
                size = "{0[0]} x {0[1]}".format(render["size_px"])
                rows.append([f'<a href="#figure-{figure["number"]}">{name}</a>', f'<span class="then">{then}</span>', html.escape(render["name"]), size,
                             f'{render["spp"]:g}', seconds(render["one_core_s"]), seconds(render["all_cores_s"]), f'{render["rays_per_s"] / 1e6:.2f}',
                             *device_cells(render["device"], devices)])
    head = ["figure", "the paper", "here", "pixels", "samples", "one core, s", "all cores, s", "million rays/s", *(f"{html.escape(name)}, s" for name in devices)]
    return "<h2>Times</h2>\n" + table(head, rows)


def device_cells(device, names):
    """The time of a render on each of the devices; images that are not those of the CPU are marked."""
    return ["" if device is None or device["name"] != name else seconds(device["render_s"]) + ("" if device["same"] else " (another image)") for name in names]


def figure_section(figure):
    stated = "" if figure["size_stated"] else " The paper states no size; this one is ours."
    then = ""
    if figure["machine"]:
        then = f' <span class="then">{html.escape(figure["machine"])}.</span>'
    text = [f'<section id="figure-{figure["number"]}"><h2>Figure {figure["number"]}. {html.escape(figure["title"])}</h2>\n'
            f'<p>The paper: {html.escape(figure["paper"])}{then}{stated}</p>\n<div class="row" style="--w: 320px; --m: {figure["shown_px"]}px">\n']
    for scene in figure["scenes"]:
        for number, render in enumerate(scene["renders"]):
            all_cores = "" if render["all_cores_s"] is None else f", {seconds(render['all_cores_s'])} s on all"
            words = [f"{html.escape(render['name'])}, {render['spp']:g} samples", f"{seconds(render['one_core_s'])} s on one core{all_cores}"]
            if scene["caption"]:
                words.insert(0, scene["caption"])
            if scene["then"] and number == 0:
                words.append(f'<span class="then">the paper: {scene["then"]}</span>')
            text.append(f"<figure>{image(render['image'], figure['title'])}<figcaption>{'; '.join(words)}</figcaption></figure>\n")
    commands = "\n".join(html.escape(" ".join(render["command"])) for scene in figure["scenes"] for render in scene["renders"])
    warnings = sorted({warning for scene in figure["scenes"] for render in scene["renders"] for warning in render["warnings"]})
    noted = f"<pre>{html.escape(chr(10).join(warnings))}</pre>" if warnings else ""
    text.append(f"</div><details><summary>commands</summary><pre>{commands}</pre>{noted}</details></section>\n")
    return "".join(text)


def tracer_section(data):
    names = list(tracers.TRACERS.values())
    text = ["<section id=\"tracers\"><h2>Figures 3 and 4. Three tracers by trace depth</h2>\n<p>The paper, on an Intel Pentium M 1.73 GHz: the optimizations "
            "are noticed beyond a depth of 4 and bring considerably more than the kd-tree; iteration alone about 1 %.</p>\n", plots.key(names), '<div class="plots">\n']
    for threads, times in data["by_depth"].items():
        groups = [(name, plots.color(number), False, sorted(times[tracer].items())) for number, (tracer, name) in enumerate(tracers.TRACERS.items())]
        where = "one thread" if threads == 1 else f"{threads} threads"
        text.append(plots.plot(f"Figure 3: rendering time, {where}", "trace depth", "seconds", groups, True, False))
    lines = [("one thread" if threads == 1 else f"{threads} threads", plots.color(3 + number), False, sorted(tracers.improvements(times).items()))
             for number, (threads, times) in enumerate(data["by_depth"].items())]
    text.append(plots.plot("Figure 4: time saved, optimized against kd-tree", "trace depth", "percent", lines, False, False))
    text.append("</div>\n")
    single = data["by_depth"][1]
    text.append(table(["trace depth", *names, "saved by optimizing, %"], [
        [depth, *(seconds(single[tracer].get(depth)) for tracer in tracers.TRACERS), f"{tracers.improvements(single)[depth]:.1f}"] for depth in sorted(single["kdtree"])]))
    text.append("<p>Seconds on one thread. " + findings(single) + "</p>\n")
    for each in data["contributions"]:
        text.append(f"<h3>Each optimization, at depth {each['depth']}</h3>\n<p>One thread, {each['spp']} samples a pixel, {each['repeats']} interleaved rounds; the plain kd-tree tracer takes "
                    f"{seconds(each['plain_s'])} s ({each['rays']['plain']:,} rays), all optimizations together {seconds(each['full_s'])} s "
                    f"({each['rays']['full']:,} rays): that {tracers.verdict(each['full'])}.{cache_words(each['cache'])}</p>\n")
        text.append(table(["optimization", "alone", "taken from the full set", "result"], [
            [html.escape(c.name), percent(c.alone), percent(c.left_out), f"{html.escape(c.name)} {tracers.verdict(c.alone)} alone, "
             f"{tracers.verdict(c.left_out)} beside the others"] for c in each["each"]]))
    return "".join(text) + "</section>\n"


def cache_words(stats):
    """A sentence about the cache in the last render of the full set."""
    cache = stats.get("cache", {})
    asked = sum(cache.get(kind, 0) for kind in ("hits", "misses", "bypasses"))
    if not asked:
        return ""
    return f" The cache answered {100 * cache['hits'] / asked:.0f} % of {asked:,} look-ups; {100 * cache['bypasses'] / asked:.0f} % were of textured materials, which it leaves out."


def percent(saving):
    low, middle, high = saving
    return f"{100 * middle:+.1f} % <small>({100 * low:+.1f} to {100 * high:+.1f})</small>"


def findings(times):
    """Figure 3's and 4's sentences of the paper, held against our numbers of one thread."""
    saved = tracers.improvements(times)
    noticed = [depth for depth in sorted(saved) if saved[depth] > 5.0]
    words = [f"Optimizing saves more than 5 % from depth {noticed[0]} on." if noticed and all(saved[d] > 5.0 for d in saved if d >= noticed[0])
             else f"Optimizing saves more than 5 % at depths {', '.join(map(str, noticed))}." if noticed else "Optimizing saves more than 5 % at no depth."]
    words.append(f"At most it saves {max(saved.values()):.0f} %, at depth {max(saved, key=saved.get)}.")
    both = sorted(set(times["none"]) & set(times["kdtree"]))
    if both:
        deepest = both[-1]
        tree = times["none"][deepest] / times["kdtree"][deepest]
        more = times["kdtree"][deepest] / times["optimized"][deepest]
        words.append(f"At depth {deepest} the kd-tree is worth a factor of {tree:.1f} over testing all triangles, the optimizations one of {more:.2f}: "
                     + ("the opposite of" if tree > more else "as") + " what the paper found on its scene.")
    return " ".join(words)


def quality_section(data):
    shots = [("unlimited reflections", image(data["images"]["unlimited"], "unlimited")), ("at most 3", image(data["images"]["3"], "3 reflections")),
             (f"where they differ: FLIP, mean {data['flip_mean']:.4f}, largest {data['flip_max']:.2f}", image(data["difference"], "difference", "image/png"))]
    psnr = "the same" if data["psnr_db"] is None else f"{data['psnr_db']:.1f} dB"
    return ("<section id=\"bounces\"><h2>Figure 2. What the limit of reflections does to the image</h2>\n<p>The paper: virtually the same with at most 3 reflections. "
            f"Here, at trace depth {data['depth']} with {data['spp']} samples: PSNR {psnr}, {100 * data['changed']:.1f} % of the pixels changed by more than 2/255; "
            f"{seconds(data['seconds']['unlimited'])} s and {seconds(data['seconds']['3'])} s on all cores.</p>\n"
            '<div class="row" style="--w: 300px; --m: 390px">' + "".join(f"<figure>{shot}<figcaption>{name}</figcaption></figure>" for name, shot in shots)
            + "</div></section>\n")


def edges_section(found):
    text = ["<section id=\"edges\"><h2>Figure 6. Antialiasing</h2>\n<p>Enlarged parts; RMSE of encoded values against the converged image of the same filter.</p>\n"
            '<div class="row crops" style="--w: 170px; --m: 190px">']
    for way in found:
        crops = "".join(image(png, way["name"], "image/png") for png in way["crops"])
        measured = "" if way["seconds"] is None else f"<br>RMSE {way['rmse']:.4f}, {seconds(way['seconds'])} s on all cores"
        text.append(f"<figure>{crops}<figcaption>{html.escape(way['name'])}{measured}</figcaption></figure>\n")
    return "".join(text) + "</div></section>\n"


def cores_section(by_job, processes):
    text = ["<section id=\"cores\"><h2>Multi-core and distribution</h2>\n<p>The paper: contiguous rectangles, one for each process; 20 to 40 % faster on the two cores of a "
            "Turion X2, about 43 % on the three of a Phenom 8400, at 900 x 675. Here: threads with one region each, and with tiles that are handed out.</p>\n"]
    series = [(f"{job}, {schedule}", job, schedule) for job in by_job for schedule in by_job[job]]
    text.append(plots.key([name for name, _, _ in series]) + '<div class="plots">\n')
    for title, label, value, factor in (("Speed-up over one thread", "times as fast", "speedup", 1.0), ("Idle time of the threads", "percent", "idle", 100.0)):
        groups = [(name, plots.color(number), False, [(threads, factor * entry[value]) for threads, entry in sorted(by_job[job][schedule].items())])
                  for number, (name, job, schedule) in enumerate(series)]
        text.append(plots.plot(title, "threads", label, groups, False, False))
    text.append("</div>\n")
    text.append(table(["job", "schedule", "threads", "seconds", "speed-up", "less time, %", "idle, %"], [
        [html.escape(job), schedule, threads, seconds(entry["seconds"]), f"{entry['speedup']:.2f}", f"{100 * (1 - 1 / entry['speedup']):.0f}", f"{100 * entry['idle']:.1f}"]
        for job in by_job for schedule in by_job[job] for threads, entry in sorted(by_job[job][schedule].items())]))
    if processes:
        parts = ", ".join(seconds(value) for value in processes["render_s"])
        text.append(f"<p>{processes['count']} processes, each with one region and one thread: {seconds(processes['wall_s'])} s from start to the last file, against "
                    f"{seconds(processes['whole_s'])} s of one process with one thread (regions alone: {parts} s). Put together the image is "
                    + ("the same to the bit." if processes["same"] else "<b>not the same</b>.") + "</p>\n")
    return "".join(text) + "</section>\n"
