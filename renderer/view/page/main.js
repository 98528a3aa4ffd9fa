// The page: draws frames, and connects camera, settings and server.
// SPDX-License-Identifier: Apache-2.0
import { retargeted } from "./camera.js";
import { Connection } from "./connection.js";
import { attachControls } from "./controls.js";
import { $, Panel } from "./panel.js";
import { PathView } from "./path.js";

const DEFAULT_STOP = 2.8; // of a camera without a lens that is told to focus
const HOVER_MS = 120;     // between questions for the values below the mouse

const canvas = $("canvas"), context = canvas.getContext("2d", { alpha: false });
let header = null;     // of the frame that is shown
let sceneNumber = -1;
let camera = null;     // as the user moves it, ahead of the server
let picked = null;
let moving = 0;        // when the camera was moved last

const connection = new Connection({
  onFrame: show,
  onState: (state) => {
    if (state === "lost") panel.touched.clear(); // inputs follow the server again
    status(state);
  },
  onError: (message) => { $("error").textContent = message; },
});

// --- the camera ------------------------------------------------------------------------------------

function cameraOf({ state, camera: seen }) {
  return state.orbit
    ? { orbit: state.orbit, target: state.target, fov: state.fov ?? 45, roll: state.roll, orthographic: state.orthographic }
    : { orbit: seen.orbit, target: seen.target, fov: state.fov ?? seen.fov, roll: seen.roll, orthographic: seen.orthographic };
}

const view = {
  change: (members) => connection.change(members),
  getCamera: () => camera ?? { orbit: [0, 90, 1], target: [0, 0, 0], fov: 45, roll: 0, orthographic: null },
  setCamera(next) {
    if (!header) return;
    camera = next;
    moving = performance.now();
    $("marker").hidden = true;
    path.clear();
    // A lens of the scene's camera stays when it becomes an orbit.
    const lens = header.state.orbit === null && header.state.f_stop === null && header.camera.f_stop !== null
      ? { f_stop: header.camera.f_stop, focus: header.camera.focus } : {};
    const { orbit, target, fov, roll, orthographic } = next;
    connection.change({ orbit, target, fov, roll, orthographic, ...lens });
  },
  resetCamera() {
    camera = null;
    path.clear();
    connection.change({ orbit: null, fov: null, roll: 0, orthographic: null, f_stop: null, focus: null });
  },
  setLens(stop) {
    const distance = header?.state.focus ?? header?.camera.focus ?? null;
    connection.change(stop ? { f_stop: stop, focus: distance } : { f_stop: stop, focus: null });
  },
  chooseSize: () => resize({ chosenNow: true }),
};
const panel = new Panel(view);
const path = new PathView((message) => { $("error").textContent = message; });

attachControls(canvas, {
  get: view.getCamera,
  set: view.setCamera,
  pick,
  focus: async (x, y) => {
    await pick(x, y);
    focusHere();
  },
  hover,
});

// --- frames ----------------------------------------------------------------------------------------

async function show(next, blob) {
  if (next.scene !== sceneNumber) {
    sceneNumber = next.scene;
    await panel.load();
  }
  if (blob) {
    const bitmap = await createImageBitmap(blob);
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
    }
    context.drawImage(bitmap, 0, 0);
    bitmap.close();
  }
  const first = header === null;
  header = next;
  if (!connection.busy && performance.now() - moving > 300) camera = cameraOf(header);
  panel.show(header);
  fit();
  showNumbers();
  if (first) resize();
  document.dispatchEvent(new CustomEvent("frame", { detail: header })); // for measurements
}

function showNumbers() {
  const { frame, state, status: doing, error } = header;
  $("waiting").textContent = frame ? "" : error || { loading: "Loading", building: "Building" }[doing] || "Rendering";
  $("error").textContent = error;
  $("rays").textContent = `${(header.rays_per_s / 1e6).toFixed(2)} M rays/s`;
  $("memory").textContent = `${(header.resident_bytes / 2 ** 20).toFixed(0)} MiB`;
  $("copy").disabled = !header.command;
  if (!frame) return;
  const share = frame.moving ? 0 : frame.samples / state.spp;
  $("samples").textContent = frame.moving ? "preview" : `${frame.samples} / ${state.spp} samples`;
  $("size-value").textContent = `${frame.size[0]} × ${frame.size[1]}`;
  $("progress").firstElementChild.style.width = `${100 * share}%`;
  $("progress").setAttribute("aria-valuemax", state.spp);
  $("progress").setAttribute("aria-valuenow", frame.moving ? 0 : frame.samples);
  status(doing === "building" || doing === "loading" || doing === "failed" ? doing
    : frame.moving ? "moving" : frame.complete ? "complete" : "rendering");
}

const WORDS = { lost: "connection lost, trying again", refused: "this link is over: open the newest one", complete: "complete" };
function status(state) {
  if (state === "connected") {
    if ($("connection").dataset.state === "lost" && header) showNumbers();
    return;
  }
  $("connection").dataset.state = state;
  const text = WORDS[state] ?? state;
  if ($("connection").textContent !== text) $("connection").textContent = text;
  if (state === "refused" && !header) $("waiting").textContent = "This link is not valid any more.";
}

// --- size ------------------------------------------------------------------------------------------

// The image as large as fits.
function fit() {
  const [width, height] = header.state.size;
  const stage = $("stage").getBoundingClientRect();
  const scale = Math.min(stage.width / width, stage.height / height);
  const window = $("size").value === "window";
  const shown = window ? scale : Math.min(scale, 1);
  $("frame").style.width = `${Math.round(width * shown)}px`;
  $("frame").style.height = `${Math.round(height * shown)}px`;
}

let resizing = 0;
// A size that is chosen now is sent even if it is that of the last frame: another may be on its way.
function resize({ chosenNow = false } = {}) {
  if (!header) return;
  const chosen = $("size").value;
  let size = chosen.split("x").map(Number);
  if (chosen === "window") {
    const stage = $("stage").getBoundingClientRect();
    const scale = Math.min(1, Math.sqrt(2.4e6 / Math.max(1, stage.width * stage.height)));
    size = [stage.width, stage.height].map((side) => Math.max(16, 8 * Math.floor(side * scale / 8)));
  }
  if (chosenNow || size.some((side, i) => side !== header.state.size[i])) connection.change({ size });
}
new ResizeObserver(() => {
  if (!header) return;
  fit();
  clearTimeout(resizing);
  // With several windows, that in front decides.
  resizing = setTimeout(() => { if (document.hasFocus()) resize(); }, 250);
}).observe($("stage"));

// --- pixels ----------------------------------------------------------------------------------------

const valuesAt = async (x, y) => (await fetch(`pixel?x=${x.toFixed(6)}&y=${y.toFixed(6)}`)).json();

async function pick(x, y) {
  try {
    picked = await valuesAt(x, y);
  } catch {
    return; // the connection says so
  }
  panel.pixel(picked, true);
  path.moveTo(x, y);
  $("marker").style.left = `${x * 100}%`;
  $("marker").style.top = `${y * 100}%`;
  $("marker").hidden = false;
}

let asked = 0;
async function hover(x, y) {
  if (performance.now() - asked < HOVER_MS || picked || document.body.classList.contains("closed")) return;
  asked = performance.now();
  try {
    panel.pixel(await valuesAt(x, y), false);
  } catch { /* the connection says so */ }
}

function focusHere() {
  const surface = picked?.surface;
  if (!surface) return;
  const stop = header.state.f_stop || header.camera.f_stop || DEFAULT_STOP;
  connection.change({ f_stop: stop, focus: surface.depth_m });
}

$("focus-here").addEventListener("click", focusHere);
$("orbit-here").addEventListener("click", () => {
  if (picked?.surface) view.setCamera(retargeted(view.getCamera(), picked.surface.position));
});

// --- command line, keys, dialogs -------------------------------------------------------------------

async function copy() {
  if (!header?.command) return;
  const text = $("command-text");
  text.value = header.command;
  let copied = true;
  try {
    await navigator.clipboard.writeText(text.value);
  } catch {
    copied = false;
  }
  const { frame } = header;
  $("command").showModal();
  text.focus();
  text.select();
  if (!copied) copied = document.execCommand("copy"); // pages that did not come from this machine have no other way
  $("command-note").textContent = `${copied ? "Copied. It" : "It"} renders this image with its ${frame.samples} ` +
    `${frame.samples === 1 ? "sample" : "samples"} per pixel, to the bit.`;
}
$("copy").addEventListener("click", copy);
$("help-open").addEventListener("click", () => $("help").showModal());

function togglePanel() {
  const closed = document.body.classList.toggle("closed");
  $("panel-toggle").setAttribute("aria-expanded", String(!closed));
}
$("panel-toggle").addEventListener("click", togglePanel);
if (matchMedia("(max-width: 760px)").matches) togglePanel();

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
  if (document.querySelector("dialog[open]")) return;
  const exposure = header?.state.exposure ?? 0;
  const actions = {
    c: copy, p: togglePanel, t: () => path.show(), r: view.resetCamera, "?": () => $("help").showModal(),
    "[": () => connection.change({ exposure: Math.max(-10, +(exposure - 0.5).toFixed(2)) }),
    "]": () => connection.change({ exposure: Math.min(10, +(exposure + 0.5).toFixed(2)) }),
  };
  actions[event.key]?.();
});

canvas.focus({ preventScroll: true });
connection.run();
