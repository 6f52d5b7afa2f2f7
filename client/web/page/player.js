// SPDX-License-Identifier: Apache-2.0
// Plays an exported recording (livegs export web) in place of a live stream. film.json, written by
// server/cli/export_web.cpp, has the places in film.bin:
//
//   rate_hz, length_s  of the recording
//   descriptions       [offset, bytes] of each ObjectDescription
//   keys               [at_s, offset, objects]: where playing may begin, ascending; objects: indices of descriptions
//   end                offset after the last record
//
// A record is u32 bytes, f64 at_s, and a ServerMessage, whose frame is that of the recording; little-endian. Messages of the
// page: film { pause } or { seek_s } or { loop }. Answer, four times a second: film { at_s, length_s, paused }.
import { Core } from './core.js';
import { decode } from './messages.js';

const kHeadBytes = 12, kReport_ms = 250;

export const playerOf = (Session) => class extends Session {
  async run() {
    try {
      const get = async (address) => {
        const reply = await fetch(address);
        if (!reply.ok) throw new Error(`${address}: status ${reply.status}; export the recording again`);
        return reply;
      };
      this.tell('loading', '0 %');
      const folder = new URL('.', this.film).href;
      Object.assign(this, { loop: true, paused: false, opening: true, bytes: new Uint8Array(0), socket: { close() {} }, current: { frames: 0 }, tickRate_hz: 1, assetsFolder: `${folder}assets/` });
      const [wasm, index, bytes] = await Promise.all([get(this.wasm).then((reply) => reply.arrayBuffer()), get(this.film).then((reply) => reply.json()),
        get(`${folder}film.bin`).then((reply) => reply.arrayBuffer())]);
      if (this.stopped) return;
      this.core = await Core.load(wasm);
      Object.assign(this, { index, bytes: new Uint8Array(bytes), data: new DataView(bytes), tickRate_hz: index.rate_hz });
      this.fail = (error) => this.crashed(error);
      this.startBinder();
      this.post({ type: 'joined', join: { view_only: true, objects: this.objectsOf(index.keys[0]) } });
      this.seek(0);
      this.statsTimer = setInterval(() => this.sendStats(), 1000);
      this.reportTimer = setInterval(() => this.post({ type: 'film', at_s: Math.max(0, Math.min(this.at_s(), index.length_s)), length_s: index.length_s, paused: this.paused }), kReport_ms);
      this.play();
    } catch (error) {
      this.crashed(error);
    }
  }

  crashed(error) {
    console.error(error);
    this.stop();
    this.tell('ended', error.message);
  }
  stop() {
    super.stop();
    clearInterval(this.reportTimer);
  }
  call() { return Promise.reject(new Error('a recording cannot be changed')); }
  send() {}

  at_s() { return this.paused || this.opening ? this.held_s : 1e-3 * (performance.now() - this.begun_ms); }

  objectsOf([, , objects]) {
    return objects.map((one) => {
      const [offset, size] = this.index.descriptions[one];
      return decode('ObjectDescription', this.bytes.subarray(offset, offset + size));
    });
  }

  // Begins at the last key before this moment, as if its frames had arrived in time.
  seek(at_s) {
    const key = this.index.keys.findLast(([key_s], i) => i === 0 || key_s <= at_s);
    if (!key) throw new Error('the recording has no frames');
    this.core.call.restart();
    this.core.call.begin_stream(this.tickRate_hz);
    this.meta.clear();
    this.takeObjects(this.objectsOf(key), true);
    Object.assign(this, { next: key[1], held_s: at_s, begun_ms: performance.now() - 1e3 * at_s, viewChanged: true });
    this.feed(at_s);
  }

  // Takes the messages up to this moment.
  feed(until_s) {
    while (this.next < this.index.end) {
      const size = this.data.getUint32(this.next, true), at_s = this.data.getFloat64(this.next + 4, true), from = this.next + kHeadBytes;
      if (at_s > until_s && this.current.frames > 0) return;
      this.takeMessage(this.bytes.subarray(from, from + size), this.current, Math.round(1e6 * (this.begun_ms + 1e3 * at_s)));
      this.next = from + size;
    }
    if (until_s < this.index.length_s) return;
    if (this.loop && this.index.length_s > 0) return this.seek(0);
    [this.paused, this.held_s] = [true, this.index.length_s];
  }

  show() {
    if (this.opening && this.core.call.waiting_objects() === 0) { // begins with all kernels
      this.opening = false;
      this.seek(0);
    }
    if (!this.opening && !this.paused) this.feed(this.at_s());
    super.show();
  }

  control({ pause, seek_s, loop }) {
    if (!this.index) return;
    if (loop !== undefined) this.loop = loop;
    if (pause === true) [this.held_s, this.paused] = [this.at_s(), true];
    if (pause === false && this.paused) {
      this.paused = false;
      this.seek(this.held_s >= this.index.length_s ? 0 : this.held_s);
    }
    if (seek_s !== undefined) this.seek(Math.max(0, Math.min(seek_s, this.index.length_s)));
  }
};
