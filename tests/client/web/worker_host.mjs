// SPDX-License-Identifier: Apache-2.0
// Runs worker.js in this process against a real server, with the globals of a worker. Node's own fetch and WebSocket are
// used (node --experimental-websocket); the Cache API is a map.
import { spawn } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { Worker as Thread } from 'node:worker_threads';

const plainFetch = globalThis.fetch, PlainSocket = globalThis.WebSocket;
export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Server {
  constructor(program, args) { Object.assign(this, { program, args, port: 0 }); }
  // Resolves when clients can join; keeps the port of the first start.
  start() {
    const child = this.child = spawn(this.program, [...this.args, '--listen', `127.0.0.1:${this.port}`, '--print-port'], { stdio: ['ignore', 'pipe', 'pipe'] });
    this.log = '';
    child.stderr.on('data', (text) => { this.log += text; });
    return new Promise((resolve, reject) => {
      child.stdout.on('data', (text) => {
        this.port = Number(String(text).trim().split('\n')[0]) || this.port;
        resolve(this.port);
      });
      child.once('exit', (code) => reject(new Error(`the server ended with ${code}: ${this.log}`)));
    });
  }
  kill(signal) {
    if (this.child.exitCode !== null || this.child.signalCode) return Promise.resolve();
    const ended = new Promise((resolve) => this.child.once('exit', resolve));
    this.child.kill(signal);
    return ended;
  }
}

// What the page would know, and the messages of the worker.
export class Page {
  static async open({ port, wasm, fields, token = '' }) {
    const folder = mkdtempSync(join(tmpdir(), 'livegs_worker_')), page = new Page();
    cpSync(fileURLToPath(new URL('../../../client/web/page', import.meta.url)), folder, { recursive: true });
    cpSync(fields, join(folder, 'fields.js'));
    Object.assign(globalThis, {
      location: { href: `http://127.0.0.1:${port}/` },
      postMessage: (message) => page.take(message),
      onmessage: null,
      WebSocket: class extends PlainSocket {
        constructor(...args) {
          super(...args);
          page.sockets.push(this);
        }
      },
      Worker: class { // binder.js, as a thread
        constructor(url) {
          this.thread = new Thread(new URL('./worker_thread.mjs', import.meta.url), { workerData: { url: String(url), href: globalThis.location.href } });
          this.thread.on('message', (data) => {
            if (data.type === 'fetched') (data.edit ? page.edits : page.fetches).push(data.path);
            else this.onmessage?.({ data });
          });
          this.thread.on('error', (error) => this.onerror?.(error));
        }
        postMessage(data, transfer) { this.thread.postMessage(data, transfer); }
        terminate() { this.thread.terminate(); }
      },
      fetch: (path, options) => {
        if (path === '/livegs.wasm') return Promise.resolve(new Response(readFileSync(wasm)));
        page.fetches.push(path);
        return plainFetch(new URL(path, globalThis.location.href), options);
      },
    });
    await import(pathToFileURL(join(folder, 'worker.js')));
    page.post({ type: 'start', token, rate_hz: 60, wasm: '/livegs.wasm' });
    return page;
  }

  constructor() {
    Object.assign(this, { fetches: [], edits: [], sockets: [], states: [], objects: new Map(), kernels: new Map(), rows: new Map(), frames: 0, orders: 0, stats: [], hands: [], waits: [], calls: new Map(), faults: [] });
  }
  post(message) { globalThis.onmessage?.({ data: message }); }
  call(method, request) {
    const id = this.calls.size + 1;
    this.post({ type: 'call', id, method, request });
    return new Promise((resolve, reject) => this.calls.set(id, { resolve, reject }));
  }

  take(m) {
    if (m.type === 'status') this.states.push({ state: m.state, message: m.message, at_ms: performance.now() });
    if (m.type === 'joined') this.join = m.join;
    if (m.type === 'moved') this.moved = m;
    if (m.type === 'object') this.objects.set(m.object.id, m.object);
    if (m.type === 'removed') for (const map of [this.objects, this.kernels, this.rows]) map.delete(m.id);
    if (m.type === 'kernels') this.kernels.set(m.id, m);
    if (m.type === 'stats') this.stats.push(m);
    if (m.type === 'reply') m.error ? this.calls.get(m.id).reject(Object.assign(new Error(m.error.message), m.error)) : this.calls.get(m.id).resolve(m.reply);
    if (m.type === 'frame') {
      ++this.frames;
      this.run = m.run;
      if (m.hands) this.hands = m.hands;
      for (const { id, rows } of m.drivers) this.rows.set(id, rows);
      if (m.drivers.length) this.moved_ms = performance.now();
    }
    if (m.order) this.checkOrder(m);
    this.waits = this.waits.filter(({ until, resolve }) => !until() || void resolve());
  }

  // Each index belongs to the kernels of an object that the page has, and comes once.
  checkOrder({ order, count }) {
    ++this.orders;
    const seen = new Set();
    const ranges = [...this.kernels.values()].map(({ base, count: size }) => [base, base + size]);
    for (let i = 0; i < count; i += 1 + (count >> 12)) {
      if (seen.has(order[i]) || !ranges.some(([begin, end]) => order[i] >= begin && order[i] < end)) this.faults.push(`order: index ${order[i]} at ${i}`);
      seen.add(order[i]);
    }
    this.count = count;
    setTimeout(() => this.post({ type: 'order_done', order }), 2);
  }

  summary() {
    const objects = [...this.objects.values()].map((one) => `${one.id} ${one.name}: ${this.kernels.get(one.id)?.count} of ${one.description.kernel_count} kernels, ${(this.rows.get(one.id)?.length ?? 0) / 16} drivers, fragility ${JSON.stringify(one.description.fragility)}`);
    return `${this.frames} frames, ${this.orders} orders; fetched ${this.fetches.length}; ${objects.join('; ')}; states ${JSON.stringify(this.states)}`;
  }
  get state() { return this.states.at(-1)?.state; }
  until(what, condition, timeout_ms = 20000) {
    if (condition()) return Promise.resolve();
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`${what}: not within ${timeout_ms} ms; ${this.summary()}`)), timeout_ms);
      this.waits.push({ until: condition, resolve: () => { clearTimeout(timer); resolve(); } });
    });
  }
}
