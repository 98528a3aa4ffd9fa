// The connection to the server: asks for frames one after the other, and sends changes one after the other.
// SPDX-License-Identifier: Apache-2.0

const MAX_PAUSE_MS = 3000; // between attempts to reach a server that does not answer
const TIMEOUT_MS = 20000;  // the server answers after 10 s at the latest

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Connection {
  // onFrame(header, blob or null), onState("connected" | "lost" | "refused"), onError(message)
  constructor({ onFrame, onState, onError }) {
    Object.assign(this, { onFrame, onState, onError });
    this.version = 0;
    this.image = 0;
    this.pending = null; // members to send
    this.sending = false;
    this.lastSent = 0;
  }

  async run() {
    for (let wait = 250; ;) {
      this.poll = new AbortController();
      const signal = AbortSignal.any([this.poll.signal, AbortSignal.timeout(TIMEOUT_MS)]);
      try {
        const response = await fetch(`frame?after=${this.version}&image=${this.image}`, { signal });
        if (response.status === 403 || response.status === 421) return this.onState("refused");
        if (!response.ok) throw new Error(response.statusText);
        this.onState("connected");
        wait = 250;
        if (response.status === 204) continue;
        const bytes = await response.arrayBuffer();
        const length = new DataView(bytes).getUint32(0, true);
        const header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
        const blob = bytes.byteLength > 4 + length ? new Blob([new Uint8Array(bytes, 4 + length)], { type: "image/jpeg" }) : null;
        await this.onFrame(header, blob);
        this.version = header.version;
        if (blob) this.image = header.image;
      } catch {
        this.onState("lost");
        this.version = 0; // whatever there is now
        await pause(wait);
        wait = Math.min(MAX_PAUSE_MS, wait * 2);
      }
    }
  }

  // True while this page has changes that frames may not show yet.
  get busy() { return this.sending || this.pending !== null || performance.now() - this.lastSent < 250; }

  // Sends members of the state. Changes that come while others are on their way are sent together.
  change(members) {
    this.pending = { ...this.pending, ...members };
    if (!this.sending) this.send();
  }

  async send() {
    this.sending = true;
    while (this.pending) {
      const body = JSON.stringify(this.pending);
      this.pending = null;
      try {
        const response = await fetch("change", { method: "POST", headers: { "Content-Type": "application/json" }, body });
        if (!response.ok) this.onError((await response.json()).error);
      } catch {
        this.poll?.abort(); // the change is lost: the next frame shows what holds
      }
      this.lastSent = performance.now();
    }
    this.sending = false;
  }
}
