// The settings: shows the state of the server, and sends what is chosen.
// SPDX-License-Identifier: Apache-2.0

export const $ = (id) => document.getElementById(id);
const RESTING = 400; // ms after the last touch of a slider, until it follows the server again

function fill(select, entries, chosen) {
  select.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
  select.value = chosen;
}

const named = (names, first) => [...(first ? [["", first]] : []), ...names.map((name, i) => [String(i), name || `${i}`])];

const number = (x) => x === null ? "nan" : x === 0 ? "0" : Math.abs(x) >= 1e4 || Math.abs(x) < 1e-3 ? x.toExponential(2) : String(+x.toPrecision(4));
const list = (values) => values.map(number).join("  ");

// 8-bit sRGB of a linear color.
const css = (rgb) => `rgb(${rgb.map((x) => Math.round(255 * Math.min(1, Math.max(0, x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055)))).join(" ")})`;

export class Panel {
  // view: { change(members), getCamera(), setCamera(camera), resetCamera() }
  constructor(view) {
    this.view = view;
    this.touched = new Map(); // inputs by the time they were used last
    const choose = (id, event, members) => $(id).addEventListener(event, () => {
      this.touched.set(id, performance.now());
      members($(id));
    });
    choose("camera", "change", (input) => view.change({ camera: input.value, orbit: null, fov: null, roll: 0, orthographic: null, f_stop: null, focus: null }));
    choose("fov", "input", (input) => view.setCamera({ ...view.getCamera(), fov: +input.value }));
    choose("f-stop", "change", (input) => view.setLens(input.value === "" ? null : +input.value));
    choose("scene", "change", (input) => view.change({ scene: input.value, camera: "", orbit: null, fov: null, roll: 0, orthographic: null }));
    choose("variant", "change", (input) => view.change({ variant: input.value }));
    choose("time", "input", (input) => view.change({ time: +input.value }));
    choose("shown", "change", (input) => view.change({ shown: input.value }));
    choose("view", "change", (input) => view.change({ view: input.value }));
    choose("exposure", "input", (input) => view.change({ exposure: +input.value }));
    choose("false-color", "change", (input) => view.change({ false_color: input.checked }));
    choose("denoise", "change", (input) => view.change({ denoise: input.checked }));
    choose("spp", "change", (input) => view.change({ spp: +input.value }));
    choose("guiding", "change", (input) => view.change({ guiding: input.checked }));
    choose("size", "change", () => view.chooseSize());
    $("reset").addEventListener("click", () => view.resetCamera());
    $("play").addEventListener("click", () => this.play());
    this.theme();
  }

  theme() {
    const apply = (theme) => document.documentElement.dataset.theme = theme;
    let stored = "auto";
    try { stored = localStorage.getItem("theme") || stored; } catch { /* no storage: of the system */ }
    $("theme").value = stored;
    apply($("theme").value);
    $("theme").addEventListener("change", () => {
      apply($("theme").value);
      try { localStorage.setItem("theme", $("theme").value); } catch { /* for this time only */ }
    });
  }

  // The animation runs by the clock, as fast as images come.
  play() {
    const playing = $("play").getAttribute("aria-pressed") === "true";
    $("play").setAttribute("aria-pressed", String(!playing));
    $("play").textContent = playing ? "▶" : "❚❚";
    clearInterval(this.playing);
    if (playing) return;
    const [begin, end] = this.scene.times;
    const start = performance.now() - 1000 * (+$("time").value - begin);
    this.playing = setInterval(() => {
      const time = begin + ((performance.now() - start) / 1000) % Math.max(end - begin, 1e-3);
      this.view.change({ time: +time.toFixed(3) });
    }, 60);
  }

  async load() {
    this.scene = await (await fetch("scene")).json();
    const { file, cameras, scenes, variants, times, views, aovs } = this.scene;
    $("file").textContent = file;
    document.title = `${file} - Kindling`;
    fill($("camera"), cameras.length ? named(cameras) : [["", "fitted to the scene"]], "");
    fill($("scene"), named(scenes, "default"), "");
    fill($("variant"), [["", "as modeled"], ...variants.map((name) => [name, name])], "");
    fill($("view"), views.map((name, i) => [i === 0 ? "" : name, name]), "");
    fill($("shown"), aovs.map((name) => [name, name === "beauty" ? "image" : name]), "beauty");
    $("row-scene").hidden = scenes.length < 2;
    $("row-variant").hidden = variants.length === 0;
    $("row-time").hidden = times === null;
    $("section-scene").hidden = scenes.length < 2 && variants.length === 0 && times === null;
    if (times) [$("time").min, $("time").max, $("time").value] = [...times, times[0]];
  }

  set(id, value, property = "value") {
    if (performance.now() - (this.touched.get(id) ?? -1e9) > RESTING && $(id)[property] !== value) $(id)[property] = value;
  }

  show(header) {
    const { state, frame, camera } = header;
    const optional = (select, value) => { // a value that is not in the list
      if (![...select.options].some((option) => option.value === value)) select.add(new Option(value, value));
    };
    const cameraName = this.scene?.cameras.length ? state.camera || "0" : "";
    if (state.orbit) {
      optional($("camera"), "moved");
      this.set("camera", "moved");
    } else {
      $("camera").querySelector('[value="moved"]')?.remove();
      this.set("camera", cameraName);
    }
    const fov = state.fov ?? camera.fov;
    const height = state.orbit ? state.orthographic : camera.orthographic;
    this.set("fov", String(fov));
    $("fov").disabled = height !== null;
    $("fov-value").textContent = height === null ? `${fov.toFixed(1)}°` : `${number(height)} m`;
    const stop = state.f_stop === null ? "" : String(state.f_stop);
    optional($("f-stop"), stop);
    this.set("f-stop", stop);
    const focus = state.focus ?? camera.focus;
    $("focus-value").textContent = (state.f_stop ?? camera.f_stop) ? (focus === null ? "center" : `${number(focus)} m`) : "no lens";
    this.set("scene", state.scene);
    this.set("variant", state.variant);
    if (state.time !== null) this.set("time", String(state.time));
    $("time-value").textContent = state.time === null ? "rest" : `${state.time.toFixed(2)} s`;
    this.set("shown", state.shown);
    this.set("view", state.view);
    this.set("exposure", String(state.exposure));
    $("exposure-value").textContent = `${state.exposure > 0 ? "+" : ""}${state.exposure.toFixed(1)}`;
    this.set("false-color", state.false_color, "checked");
    this.set("denoise", state.denoise, "checked");
    optional($("spp"), String(state.spp));
    this.set("spp", String(state.spp));
    this.set("guiding", state.guiding, "checked");
    if (frame) {
      this.histogram(frame.histogram);
      $("legend").hidden = frame.range[1] <= frame.range[0];
      $("legend-low").textContent = number(frame.range[0]);
      $("legend-high").textContent = number(frame.range[1]);
    }
  }

  histogram(counts) {
    const canvas = $("histogram"), context = canvas.getContext("2d");
    const style = getComputedStyle(canvas);
    context.clearRect(0, 0, canvas.width, canvas.height);
    const most = Math.max(1, ...counts.slice(1, -1));
    const width = canvas.width / counts.length;
    counts.forEach((count, i) => {
      const height = Math.min(1, Math.sqrt(count / most)) * (canvas.height - 4);
      context.fillStyle = i === 0 || i === counts.length - 1 ? style.getPropertyValue("--accent") : style.color;
      context.globalAlpha = 0.75;
      context.fillRect(i * width, canvas.height - height, Math.max(1, width - 1), height);
    });
  }

  // Values of a pixel, and with `full` those of its surface.
  pixel(values, full) {
    if (!values) return;
    const rows = [["pixel", `${values.pixel[0]}, ${values.pixel[1]}`], ["radiance", list(values.rgb), values.rgb]];
    if (values.denoised) rows.push(["denoised", list(values.denoised), values.denoised]);
    if (values.alpha < 1) rows.push(["alpha", number(values.alpha)]);
    if (values.shown) rows.push([values.shown.name, list(values.shown.values)]);
    if (full) {
      const surface = values.surface;
      if (!surface) rows.push(["surface", "none here"]);
      else {
        rows.push(["object", surface.node || "without a name"], ["material", surface.material || "without a name"]);
        for (const [name, value] of Object.entries(surface.values))
          rows.push([name, Array.isArray(value) ? list(value) : number(value), Array.isArray(value) ? value : null]);
        rows.push(["depth", `${number(surface.depth_m)} m`], ["position", list(surface.position)]);
      }
      $("pick-actions").hidden = !surface;
    }
    $("pixel").replaceChildren(...rows.flatMap(([name, text, color]) => {
      const term = document.createElement("dt"), description = document.createElement("dd");
      term.textContent = name;
      if (color) {
        const swatch = document.createElement("span");
        swatch.className = "swatch";
        swatch.style.background = css(color);
        description.append(swatch);
      }
      description.append(text);
      return [term, description];
    }));
  }
}
