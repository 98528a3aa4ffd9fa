// Mouse, touch and keyboard on the image, as changes of the camera.
// SPDX-License-Identifier: Apache-2.0
import * as camera from "./camera.js";

const TURN = 220;       // degrees of a drag across the image's height
const CLICK_PX = 4;     // a drag shorter than this is a click
const KEY_TURN = 80;    // degrees a second
const KEY_PAN = 0.6;    // image heights a second
const KEY_DOLLY = 1.2;  // natural logarithm of the distance a second
const KEY_FLY = 0.8;    // distances of the target a second

const MOVING_KEYS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "+", "=", "-", "_", "w", "a", "s", "d", "q", "e"]);

// view: { get(): camera, set(camera), pick(x, y), focus(x, y), hover(x, y) }; x and y are fractions of the image.
export function attachControls(canvas, view) {
  const pointers = new Map();
  let moved = 0, mode = "orbit";

  const fractions = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, box.height];
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, event);
    if (pointers.size === 1) {
      moved = 0;
      mode = event.button === 2 ? "look" : event.button === 1 || event.shiftKey ? "pan" : "orbit";
    }
    canvas.classList.add("drags");
    if (event.button === 1) event.preventDefault();
  });

  canvas.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return view.hover(...fractions(event));
    const height = canvas.getBoundingClientRect().height;
    const dx = (event.clientX - last.clientX) / height, dy = (event.clientY - last.clientY) / height;
    if (pointers.size === 2) twoFingers(event, last, height);
    else if (pointers.size === 1) {
      moved += Math.hypot(event.clientX - last.clientX, event.clientY - last.clientY);
      if (moved < CLICK_PX) return pointers.set(event.pointerId, event);
      const now = view.get();
      if (mode === "pan") view.set(camera.panned(now, dx, dy));
      else if (mode === "look") view.set(camera.lookedAround(now, dx * now.fov, dy * now.fov));
      else view.set(camera.orbited(now, -dx * TURN, -dy * TURN));
    }
    pointers.set(event.pointerId, event);
  });

  // Pinch and pan together.
  const twoFingers = (event, last, height) => {
    moved = CLICK_PX;
    const other = [...pointers.values()].find((pointer) => pointer.pointerId !== event.pointerId);
    const distance = (a) => Math.max(1, Math.hypot(a.clientX - other.clientX, a.clientY - other.clientY));
    const dolly = camera.dollied(view.get(), distance(last) / distance(event));
    view.set(camera.panned(dolly, (event.clientX - last.clientX) / height / 2, (event.clientY - last.clientY) / height / 2));
  };

  const release = (event) => {
    const down = pointers.delete(event.pointerId);
    if (pointers.size === 0) canvas.classList.remove("drags");
    if (down && event.type === "pointerup" && moved < CLICK_PX && event.button === 0 && pointers.size === 0) {
      const [x, y] = fractions(event);
      if (x >= 0 && x <= 1 && y >= 0 && y <= 1) view.pick(x, y);
    }
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("dblclick", (event) => view.focus(...fractions(event)));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 20 : event.deltaMode === 2 ? 400 : 1);
    view.set(camera.dollied(view.get(), Math.exp(Math.max(-240, Math.min(240, pixels)) * 0.0016)));
  }, { passive: false });

  attachKeys(canvas, view);
}

// Keys that are held down move evenly.
function attachKeys(canvas, view) {
  const held = new Set();
  let shift = false, last = 0;

  const step = (now) => {
    if (held.size === 0) return;
    const s = Math.min(0.1, (now - last) / 1000);
    last = now;
    const sign = (more, less) => (more.some((key) => held.has(key)) ? 1 : 0) - (less.some((key) => held.has(key)) ? 1 : 0);
    const x = sign(["ArrowRight"], ["ArrowLeft"]), y = sign(["ArrowUp"], ["ArrowDown"]);
    let next = view.get();
    if (shift) next = camera.panned(next, -x * KEY_PAN * s, y * KEY_PAN * s);
    else next = camera.orbited(next, x * KEY_TURN * s, -y * KEY_TURN * s);
    next = camera.dollied(next, Math.exp(sign(["-", "_"], ["+", "="]) * KEY_DOLLY * s));
    const meters = KEY_FLY * next.orbit[2] * s;
    next = camera.flown(next, sign(["d"], ["a"]) * meters, sign(["e"], ["q"]) * meters, sign(["w"], ["s"]) * meters);
    view.set(next);
    requestAnimationFrame(step);
  };

  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    shift = event.shiftKey;
    if (key === "Enter") return view.pick(0.5, 0.5);
    if (key === "f") return view.focus(0.5, 0.5);
    if (!MOVING_KEYS.has(key)) return;
    event.preventDefault();
    if (held.size === 0) {
      last = performance.now();
      requestAnimationFrame(step);
    }
    held.add(key);
  });
  canvas.addEventListener("keyup", (event) => {
    shift = event.shiftKey;
    held.delete(event.key.length === 1 ? event.key.toLowerCase() : event.key);
  });
  canvas.addEventListener("blur", () => held.clear());
}
