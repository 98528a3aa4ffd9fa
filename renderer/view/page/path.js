// The path of one sample: its vertices over the image, and a list of its events.
// SPDX-License-Identifier: Apache-2.0
import { $ } from "./panel.js";

const SVG = "http://www.w3.org/2000/svg";
const short = (x) => x === 0 ? "0" : Math.abs(x) >= 1e4 || Math.abs(x) < 1e-3 ? x.toExponential(1) : String(+x.toPrecision(3));
const list = (values) => values.map(short).join(" ");

const STEPS = { // what happened at the vertex before
  camera: "from the camera", diffuse: "reflected diffusely", glossy: "reflected specularly", transmission: "transmitted",
  straight: "straight through", medium: "scattered in a medium",
};

function line(from, to, step) {
  const element = document.createElementNS(SVG, "line");
  for (const [name, value] of [["x1", from[0]], ["y1", from[1]], ["x2", to[0]], ["y2", to[1]]]) element.setAttribute(name, value);
  element.setAttribute("class", step);
  return element;
}

// SVG elements have no property `hidden`: the attribute is set.
function hide(hidden) {
  for (const id of ["path", "path-events", "path-note", "path-next", "path-clear"]) $(id).toggleAttribute("hidden", hidden);
}

export class PathView {
  constructor(onError) {
    this.onError = onError;
    this.at = null;  // fractions of the image
    this.sample = 0;
    this.asked = 0;  // number of the newest question; answers to older ones are dropped
    $("path-show").addEventListener("click", () => this.show());
    $("path-next").addEventListener("click", () => { ++this.sample; this.show(); });
    $("path-clear").addEventListener("click", () => this.clear());
  }

  // A pixel was picked. Where paths are shown, that of the new pixel is.
  moveTo(x, y) {
    const shown = !$("path").hasAttribute("hidden");
    this.clear();
    this.at = [x, y];
    this.sample = 0;
    $("path-actions").hidden = false;
    if (shown) this.show();
  }

  clear() {
    ++this.asked;
    $("path").replaceChildren();
    $("path-events").replaceChildren();
    hide(true);
  }

  async show() {
    if (!this.at) return;
    const question = ++this.asked;
    $("path-note").hidden = false;
    $("path-note").textContent = "Tracing the sample again";
    try {
      const [x, y] = this.at;
      const response = await fetch(`path?x=${x.toFixed(6)}&y=${y.toFixed(6)}&sample=${this.sample}`);
      const path = await response.json();
      if (question !== this.asked) return;
      if (response.ok) this.draw(path);
      else {
        $("path-note").hidden = true;
        this.onError(path.error);
      }
    } catch {
      if (question === this.asked) $("path-note").hidden = true; // the connection says so
    }
  }

  draw({ pixel, size, sample, radiance, vertices }) {
    const ways = vertices.filter((vertex) => vertex.way && vertex.step !== "camera");
    // A dark line below each makes it visible on any image.
    $("path").replaceChildren(...ways.map(({ way }) => line(...way, "below")), ...ways.map(({ way, step }) => line(...way, step)));
    const escaped = vertices.some((vertex) => vertex.event === "escaped");
    $("path-events").replaceChildren(...vertices.map((vertex, i) => {
      const item = document.createElement("li");
      const step = document.createElement("span");
      step.className = `step ${vertex.step}`;
      step.textContent = i === 0 ? "" : STEPS[vertex.step];
      const where = vertex.material ? `${vertex.event}: ${vertex.material}` : vertex.event;
      const more = i === 0 ? "" : `throughput ${list(vertex.throughput)}, light so far ${list(vertex.radiance)}`;
      const details = document.createElement("small");
      details.textContent = more;
      item.append(step, i === 0 ? where : ` ${where}`, details);
      return item;
    }));
    $("path-note").textContent = `Sample ${sample} of pixel ${pixel[0]}, ${pixel[1]} of ${size[0]} × ${size[1]}: ` +
      `radiance ${list(radiance)}${escaped ? "" : ", ended inside of the scene"}.`;
    hide(false);
  }
}
