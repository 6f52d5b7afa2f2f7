// SPDX-License-Identifier: Apache-2.0
// The session of a browser client: joins, keeps the stream open, decodes frames, and gives the page rows and
// an order to draw. It answers the page by these messages; typed arrays are transferred.
//
//   kernels  rest    10 words a kernel, RestKernelRow: driver; x y z (m in its body, or 0..1 in its cell); covariance xx xy xz
//                    yy yz zz, m2. Floats are in their bits.
//            cells   8 words a cell, its nodes: bit 0 of a corner is +x, 1 +y, 2 +z. null: rigid
//            looks   4 words a kernel, KernelLookRow: log2 of the opacity; red green blue of the constant term
//            bands   ceil(3 ((d + 1)^2 - 1) / 2) words a kernel of degree d: half floats, two a word, coefficient by
//                    coefficient, three channels each
//            lattice null, or { cell_width_m, cell_count, node_count, lattice_from_asset [x y z w], body_gradient [9, by rows] }
//            bounds_m [min x y z, max x y z] of 98 % of the kernels, when it was sent
//   frame    drivers [{ id, rows, body_gradient }]: rows of 16 floats. Lattice node: x y z 0, then the gradient's columns
//                    dx/dX 0, dx/dY 0, dx/dZ 0. Rigid body: rows of [R | t], then world_from_asset x y z w.
//                    body_gradient is of this moment, by rows; rigid: undefined.
//            order   global indices (base + i), nearest first, by depth along the axis of the view or by distance from its
//                    position; equal depths in the order of objects and kernels. All kernels are in it; the page culls.
//                    Absent if only hands or the state of the run changed.
//   moved    address, token: the server shut down, and the session continues at that one; the last message
// Kernels of an object come before the first frame or order that has their indices. Objects that are hidden, or that have
// no drivers yet, have no kernels in the order.
import { Core } from './core.js';
import { decode, encode } from './messages.js';
import { methods } from './fields.js';

// Times in ms. Values and reasons: client/stream/session/session_stream.h, session_client.cpp, channel/retry_schedule.h.
const kKeepalive = 50, kServerTimeout = 1000, kMaxSilence = 30000, kKeyframeRetry = 250;
const kRetryPause = 150, kLongRetryPause = 400, kLongRetryAfter = 60000, kMaxRetryPause = 2000;
const kJoinTimeout = 10000, kRejoinTimeout = 2000;
const kSamplesPerMessage = 3, kMaxQueued_bytes = 65536, kMaxOrdersOut = 3;
const kCloseCode = 4000, kHandPose = ['aim_position', 'aim_orientation', 'grip_position', 'grip_orientation'];
const status = { deadline: 4, permissionDenied: 7, resourceExhausted: 8, precondition: 9, internal: 13, unavailable: 14, unauthenticated: 16 };
const isFinal = (code) => [3, 7, 9, 11, 12, 15, 16].includes(code); // another attempt would not help
const now_ns = () => Math.round(performance.now() * 1e6);
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
// After messages that wait.
const nextTask = () => new Promise((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => { port1.close(); resolve(); };
  port2.postMessage(0);
});
const sameBytes = (a, b) => a.length === b.length && a.every((byte, i) => byte === b[i]);

class CallError extends Error {
  constructor(code, message) {
    super(message);
    this.status = code;
  }
}

class Session {
  constructor({ token, rate_hz, wasm, film }) {
    Object.assign(this, { token, rate_hz: rate_hz || 60, wasm, film, stopped: false, id: '', instance: '', next: null, socket: null, silentStreams: 0 });
    this.assetsFolder = new URL('/assets/', location.href).href;
    this.view = null; // the last of the page
    this.hands = { left: null, right: null };
    this.samples = [];
    this.sequence = 0;
    this.orders = []; // buffers for reuse
    this.counters = { frames: 0, decode_ms: 0, plays: 0, keys_ms: 0, sort_ms: 0, bytes: 0 };
    this.forget();
  }

  forget() {
    this.known = new Map(); // by id: description and rest body, as the server last sent them
    this.asked = new Map(); // by number of the description: { id, added } of objects that the core has; added: in place of one before
    this.bound = new Map(); // by the same number: { id, kernels } that the page does not have yet
    this.described = 0;
    this.binder?.terminate();
    this.binder = null;
    this.ordersOut = 0;
    this.meta = new Map(); // by tick: hands and state of the run
    this.removedLater = new Set(); // while the objects of a restarted server are bound
    this.holds = false;
    this.viewChanged = false;
    this.sentRun = '';
  }

  post(message, transfer = []) { postMessage(message, transfer); }
  tell(state, message = '') {
    if (state === this.state && message === this.told) return;
    [this.state, this.told] = [state, message];
    this.post({ type: 'status', state, message });
  }

  headers(more = {}) { return { ...more, ...(this.token ? { authorization: `Bearer ${this.token}` } : {}) }; }

  // A unary RPC. Throws CallError.
  async call(method, request, timeout_ms = kJoinTimeout) {
    const [asked, answered] = methods[method] ?? [];
    if (!asked) throw new CallError(status.internal, `${method}: no such call`);
    let reply, bytes;
    try {
      reply = await fetch(`/livegs.v1.LiveGs/${method}`, { method: 'POST', body: encode(asked, request), headers: this.headers(), signal: AbortSignal.timeout(timeout_ms) });
      bytes = new Uint8Array(await reply.arrayBuffer());
    } catch (error) {
      throw new CallError(error.name === 'TimeoutError' ? status.deadline : status.unavailable, 'the server does not answer; try again later');
    }
    if (reply.ok) return decode(answered, bytes);
    const codes = { 400: 3, 401: status.unauthenticated, 403: status.permissionDenied, 404: 5, 412: status.precondition, 503: status.unavailable };
    const code = Number(reply.headers.get('grpc-status') ?? codes[reply.status] ?? status.internal);
    throw new CallError(code, new TextDecoder().decode(bytes) || `${method}: status ${code}`);
  }

  async run() {
    this.play();
    this.statsTimer = setInterval(() => this.sendStats(), 1000);
    let pause = 0, lost_ms = 0;
    while (!this.stopped) {
      try {
        if (!this.core) {
          const bytes = await fetch(this.wasm).then((reply) => (reply.ok ? reply.arrayBuffer() : null)).catch(() => null);
          if (!bytes) {
            this.tell('connecting', 'the server does not answer; try again later');
            await sleep(kRetryPause);
            continue;
          }
          this.core = await Core.load(bytes);
          this.startBinder();
        }
        this.takeJoin(await this.join(lost_ms));
        const end = await this.stream();
        if (this.stopped) return;
        if (this.next) {
          this.stop();
          return this.post({ type: 'moved', ...this.next });
        }
        if (isFinal(end.code)) return this.end(end.code, end.reason);
        this.tell('lost', this.draining ? `server is shutting down: ${this.draining}` : `${end.reason}; reconnecting`);
        pause = end.frames > 0 ? 0 : Math.min(Math.max(2 * pause, kRetryPause), kMaxRetryPause);
        this.silentStreams = end.frames > 0 ? 0 : this.silentStreams + 1;
        lost_ms = end.last_ms;
      } catch (error) {
        if (this.stopped) return;
        if (error instanceof CallError) return this.end(error.status, error.message);
        this.crashed(error);
        pause = Math.min(Math.max(2 * pause, kRetryPause), kMaxRetryPause);
      }
      await sleep(pause);
    }
  }

  end(code, reason) {
    this.stop();
    const refused = [status.unauthenticated, status.permissionDenied, status.precondition].includes(code);
    this.tell(refused ? 'refused' : 'ended', reason);
  }

  stop() {
    this.stopped = true;
    clearInterval(this.statsTimer);
    clearTimeout(this.playTimer);
    this.binder?.terminate();
    this.socket?.close(1000);
  }

  // The core trapped, or received data are unusable: begins again with a new core.
  crashed(error) {
    console.error(error);
    this.tell('lost', `the client failed: ${error.message}; restarting`);
    this.socket?.close(1000);
    for (const id of this.known.keys()) this.post({ type: 'removed', id });
    this.core = null;
    this.forget();
  }

  // Joins, with the id of the session if there is one; tries until the server answers.
  async join(lost_ms) {
    this.tell(this.id ? 'lost' : 'connecting', this.id ? this.told : '');
    let timeout = this.id ? kRejoinTimeout : kJoinTimeout;
    const begun_ms = lost_ms || performance.now();
    for (;;) {
      try {
        return await this.call('Join', { protocol_version: this.core.call.protocol_version(), client_name: 'livegs-web', resumed_session_id: this.id,
          rate_hz: this.rate_hz, starts_run: true }, timeout);
      } catch (error) {
        if (this.stopped || isFinal(error.status) || (error.status === status.resourceExhausted && !this.id)) throw error;
        timeout = Math.min(2 * timeout, kJoinTimeout);
        if (!this.id) this.tell('connecting', error.message);
      }
      const pause = performance.now() - begun_ms < kLongRetryAfter ? kRetryPause : kLongRetryPause;
      await sleep(pause * (1 - Math.random() / 5));
    }
  }

  takeJoin(reply) {
    const first = this.instance === '', restarted = !first && reply.server_instance !== this.instance;
    this.store = { url: reply.asset_store, hashes: Object.fromEntries(reply.stored_assets.map((one) => [one.hash, one.web_sha256])) };
    Object.assign(this, { id: reply.session_id, instance: reply.server_instance, tickRate_hz: reply.rate_hz, draining: '' });
    const { objects, ...join } = reply;
    this.post({ type: 'joined', join: { ...join, objects: objects.map(withoutBody) } });
    if (restarted) {
      this.core.call.restart();
      this.meta.clear();
      this.holds = true;
      this.gotFrame = false;
    }
    this.takeObjects(objects, restarted);
    // A simulation that waits for its first client starts when the first picture is there.
    this.startsRun = true;
    if (this.state === 'connecting') this.tell('loading', '0 %');
  }

  // All objects that exist now. `replaced`: a different description is that of another object.
  takeObjects(objects, replaced) {
    const ids = new Set(objects.map((object) => object.object_id));
    for (const id of [...this.known.keys()]) if (!ids.has(id)) this.remove(id);
    for (const object of objects) {
      const known = this.known.get(object.object_id);
      if (!known) this.describe(object, true);
      else if (known.text !== JSON.stringify(withoutBody(object)) || !sameBytes(known.rest, object.rest_body)) this.describe(object, replaced);
    }
  }

  describe(description, added) {
    const id = description.object_id, plain = withoutBody(description), rest = description.rest_body.slice();
    this.known.set(id, { text: JSON.stringify(plain), rest, name: description.name, hash: description.asset_hash });
    this.removedLater.delete(id);
    const { name, environment, hidden } = description;
    this.post({ type: 'object', object: { id, name, environment, hidden, description: plain, kind: rest[6] === 2 ? 'lattice' : 'rigid' } });
    this.attempt(name, () => {
      const { asset_hash, asset_bytes, broken_asset_hash, broken_asset_bytes } = description, number = ++this.described;
      const binds = this.core.take('describe_object', [number, id, added, environment, hidden], rest) === 1;
      if (added) dropOf(this.asked, id);
      if (binds) this.asked.set(number, { id, added });
      this.binder.postMessage({ type: 'describe', description: number, rest: binds ? rest : null, session: this.id, store: this.store, name, asset_hash, asset_bytes, broken_asset_hash, broken_asset_bytes });
    });
    this.viewChanged = true; // it may be hidden or shown
  }

  remove(id) {
    this.known.delete(id);
    dropOf(this.asked, id);
    dropOf(this.bound, id);
    this.core.call.remove_object(id);
    if (this.holds) this.removedLater.add(id);
    else this.post({ type: 'removed', id });
  }

  // Runs a step whose failure concerns one object only. A trap of the core ends the session.
  attempt(name, step) {
    try {
      return step();
    } catch (error) {
      if (error instanceof WebAssembly.RuntimeError) throw error;
      console.warn(`${name}: ${error.message}`);
    }
  }

  // ---- kernels: another worker fetches assets and binds them to objects, which may take seconds.
  startBinder() {
    const binder = this.binder = new Worker(new URL('./binder.js', import.meta.url), { type: 'module' });
    binder.onmessage = ({ data }) => {
      if (this.binder !== binder) return;
      if (data.type === 'bound') this.taking = this.taking.then(() => this.takeBound(binder, data));
      if (data.type === 'failed') {
        console.warn(data.message);
        if (data.description) {
          this.asked.delete(data.description);
          this.core.call.bind_failed(data.description);
        }
      }
      if (data.type === 'loading' && this.state === 'loading') this.tell('loading', data.message);
      if (data.type === 'received') this.counters.bytes += data.bytes;
      if (data.type === 'crashed') this.fail ? this.fail(new Error(data.message)) : this.crashed(new Error(data.message));
    };
    binder.onerror = (event) => this.crashed(new Error(event.message ?? 'the binder could not be loaded'));
    this.taking = Promise.resolve();
    binder.postMessage({ type: 'start', module: this.core.module, token: this.token, assets: this.assetsFolder });
  }

  async takeBound(binder, bound) {
    const core = this.core;
    try {
      const used = await core.takeBound(bound, nextTask);
      if (this.binder !== binder) return;
      if (!used) return binder.postMessage({ type: 'forget', description: bound.description });
      const one = this.asked.get(bound.description);
      if (one.added) dropOf(this.bound, one.id);
      one.added = false; // what follows are more kernels of the same object
      this.bound.set(bound.description, { id: one.id, kernels: bound.kernels });
    } catch (error) {
      if (this.binder !== binder) return;
      if (error instanceof WebAssembly.RuntimeError) this.fail ? this.fail(error) : this.crashed(error);
      else console.warn(error.message);
    }
  }

  // ---- the stream. Resolves when it is over.
  stream() {
    return new Promise((resolve, reject) => {
      this.core.call.begin_stream(this.tickRate_hz);
      const url = new URL('/stream', location.href.replace(/^http/, 'ws'));
      const socket = this.socket = new WebSocket(url, ['livegs.v1', ...(this.token ? [`token.${this.token}`] : [])]);
      const end = { code: status.unavailable, reason: 'the stream ended', frames: 0, last_ms: performance.now() };
      Object.assign(this, { current: end, first: true, acknowledged: 0, echoed_ns: 0, keyframeWanted: false, keyframeAsked_ms: -Infinity, viewUnsent: this.view });
      socket.binaryType = 'arraybuffer';
      const finish = (settle, value) => {
        clearInterval(timer);
        socket.onopen = socket.onmessage = socket.onclose = socket.onerror = null;
        socket.close();
        if (this.socket === socket) this.socket = null;
        settle(value);
      };
      this.fail = (error) => finish(reject, error);
      const timer = setInterval(() => {
        const limit = end.frames > 0 ? kServerTimeout : Math.min(kServerTimeout * 2 ** Math.min(this.silentStreams, 8), kMaxSilence);
        if (performance.now() - end.last_ms > limit) return finish(resolve, Object.assign(end, { reason: `no message for ${(limit / 1000).toFixed(0)} s` }));
        if (this.hands.left || this.hands.right) this.sample();
        this.send();
      }, kKeepalive);
      socket.onopen = () => {
        end.last_ms = performance.now();
        this.send();
      };
      socket.onmessage = ({ data }) => {
        end.last_ms = performance.now();
        this.counters.bytes += data.byteLength;
        try { this.takeMessage(new Uint8Array(data), end); } catch (error) { this.fail(error); }
      };
      socket.onclose = ({ code, reason }) => {
        if (code >= kCloseCode && code < kCloseCode + 17) Object.assign(end, { code: code - kCloseCode, reason: reason || end.reason });
        finish(resolve, end);
      };
    });
  }

  sample() {
    const at_ns = now_ns(), hand = (one) => one && Object.fromEntries([...kHandPose.map((name) => [name.replace('position', 'position_m'), one[name]]),
      ['trigger', one.trigger ?? 0], ['squeeze', one.squeeze ?? 0], ['shoot', Boolean(one.shoot)]]);
    this.samples.push({ sequence: ++this.sequence, sampled_ns: at_ns, left: hand(this.hands.left), right: hand(this.hands.right), for_tick: this.core.call.aimed_tick(at_ns) });
    if (this.samples.length > kSamplesPerMessage) this.samples.shift();
  }

  send() {
    const socket = this.socket;
    if (socket?.readyState !== 1 || socket.bufferedAmount > kMaxQueued_bytes) return;
    const message = { acknowledged_tick: this.acknowledged, inputs: this.samples, sent_ns: now_ns() };
    if (this.first) message.session_id = this.id;
    if (this.keyframeWanted) message.key_frame_wanted = true;
    if (this.viewUnsent) message.view = { position_m: this.viewUnsent.position, forward: this.viewUnsent.axis, half_angle_rad: this.viewUnsent.half_angle_rad };
    this.first = this.keyframeWanted = false;
    this.viewUnsent = null;
    socket.send(encode('ClientMessage', message));
  }

  takeMessage(bytes, end, received_ns = now_ns()) {
    const message = decode('ServerMessage', bytes), core = this.core;
    if (message.echoed_ns > this.echoed_ns && message.received_ns !== 0) {
      this.echoed_ns = message.echoed_ns;
      core.call.take_clock(message.echoed_ns, message.received_ns, message.sent_ns, received_ns);
      this.rtt_ms = 1e-6 * (received_ns - message.echoed_ns - (message.sent_ns - message.received_ns));
    }
    for (const event of message.events) {
      if (event.object_added) this.describe(event.object_added, true);
      if (event.object_changed) this.describe(event.object_changed, false);
      if (event.object_removed) this.remove(event.object_removed.object_id);
      if (event.draining !== undefined) {
        this.draining = event.draining || 'no reason reported';
        this.next = event.next_server?.address ? event.next_server : null;
        this.tell(this.state, `server is shutting down: ${this.draining}${this.next ? `; continuing at ${this.next.address}` : ''}`);
      }
    }
    if (message.frame.length === 0) return;
    const { tick, hands, run, step_ms } = message, begun_ms = performance.now();
    const waits = core.call.needs_keyframe() && begun_ms - this.keyframeAsked_ms < kKeyframeRetry;
    const read = this.attempt(`frame ${tick}`, () => {
      core.take('take_frame', [], message.frame, [received_ns, tick, message.stepped_ns - 1e6 * step_ms]);
      return true;
    });
    this.counters.decode_ms += performance.now() - begun_ms;
    ++this.counters.frames;
    if (read) {
      ++end.frames;
      this.gotFrame = true;
      this.meta.set(tick, { tick, hands, run, step_ms });
      if (this.meta.size > 128) this.meta.delete(this.meta.keys().next().value);
    } else if (!waits) {
      this.keyframeWanted = true;
      this.keyframeAsked_ms = begun_ms;
    }
    this.acknowledged = tick;
    this.send();
  }

  // ---- playout: moves the scene to the moment of the next picture, and tells the page what changed.
  play() {
    if (this.stopped) return;
    clearTimeout(this.playTimer);
    const begun_ms = performance.now(), period_ms = 1000 / this.rate_hz;
    this.played_ms = begun_ms;
    try { if (this.core && (this.film || this.known.size > 0)) this.show(); } catch (error) { this.fail ? this.fail(error) : this.crashed(error); }
    const spent_ms = performance.now() - begun_ms; // leaves time for messages
    this.playTimer = setTimeout(() => this.play(), Math.max(period_ms - spent_ms, 0.25 * spent_ms));
  }

  show() {
    const core = this.core;
    if (this.holds) {
      if (core.call.waiting_objects() > 0 || !this.gotFrame) return;
      this.holds = false;
      for (const id of this.removedLater) this.post({ type: 'removed', id });
      this.removedLater.clear();
    }
    if (this.ordersOut >= kMaxOrdersOut) return; // the page is behind
    const moved = core.call.play(now_ns()) !== 0, drivers = [], transfer = [];
    for (const id of moved ? core.drawn() : []) {
      const object = core.object(id);
      if (!object.moved && !object.fresh) continue;
      const rows = object.rows.slice();
      transfer.push(rows.buffer);
      drivers.push({ id, rows, body_gradient: object.lattice?.body_gradient });
      if (object.fresh) this.sendKernels(id, object);
    }
    const shown = this.takeMeta(core.call.shown_tick()), run = JSON.stringify(shown && [shown.hands, { ...shown.run, simulated_s: 0 }]);
    const order = moved || this.viewChanged ? this.sort() : null;
    if (moved || (shown && (run !== this.sentRun || performance.now() - this.runSent_ms > 250))) {
      [this.sentRun, this.runSent_ms] = [run, performance.now()];
      this.post({ type: 'frame', drivers, removed: [], ...shown, ...order }, order ? [...transfer, order.order.buffer] : transfer);
    } else if (order) {
      this.post({ type: 'order', ...order }, [order.order.buffer]);
    }
    if (this.state !== 'live' && this.socket && this.current.frames > 0 && (order || this.state === 'lost')) this.tell('live');
    if (this.startsRun && this.state === 'live' && shown?.run) {
      this.startsRun = false;
      if (shown.run.waiting) this.call('ControlRun', { pause: false }).catch(() => { this.startsRun = true; });
    }
  }

  takeMeta(tick) {
    for (const old of this.meta.keys()) if (old < tick) this.meta.delete(old);
    return this.meta.get(tick);
  }

  sendKernels(id, { description, base, cells, lattice }) {
    const { kernels } = this.bound.get(description), copy = cells?.slice() ?? null, bounds_m = [...this.core.floats(this.core.call.sent_kernels(id), 6)];
    this.bound.delete(description);
    this.post({ type: 'kernels', id, base, ...kernels, cells: copy, lattice, bounds_m },
      [kernels.rest, kernels.looks, kernels.bands, ...(copy ? [copy] : [])].map((array) => array.buffer));
  }

  sort() {
    const call = this.core.call, view = this.view, begun_ms = performance.now();
    if (this.viewChanged && view) call.set_view(...view.position, ...view.axis, view.by_distance ? 1 : 0);
    this.viewChanged = false;
    call.update_keys();
    const keyed_ms = performance.now(), count = call.sort_kernels(), sorted = this.core.words(call.order(), count);
    let order = this.orders.pop();
    if (!(order?.length >= count)) order = new Uint32Array(count + (count >> 4));
    order.set(sorted);
    ++this.ordersOut;
    Object.assign(this.counters, { plays: this.counters.plays + 1, keys_ms: this.counters.keys_ms + keyed_ms - begun_ms,
      sort_ms: this.counters.sort_ms + performance.now() - keyed_ms, kernels: count });
    return { order, count };
  }

  sendStats() {
    const { frames, decode_ms, plays, keys_ms, sort_ms, bytes, kernels } = this.counters, each = (sum, count) => (count > 0 ? sum / count : 0);
    this.post({ type: 'stats', rtt_ms: this.rtt_ms ?? 0, decode_ms: each(decode_ms, frames), keys_ms: each(keys_ms, plays), sort_ms: each(sort_ms, plays), bytes_s: bytes, kernels: kernels ?? 0 });
    this.counters = { frames: 0, decode_ms: 0, plays: 0, keys_ms: 0, sort_ms: 0, bytes: 0, kernels };
  }

  // ---- messages of the page
  setView(view) {
    this.view = this.viewUnsent = view;
    this.viewChanged = true;
    if (performance.now() - (this.played_ms ?? 0) > 500 / this.rate_hz) this.play();
  }
  setHands({ left, right }) {
    this.hands = { left, right };
    if (!this.core) return;
    this.sample();
    this.send();
  }
  giveBack(order) {
    this.ordersOut = Math.max(0, this.ordersOut - 1);
    if (this.orders.length < kMaxOrdersOut) this.orders.push(order);
  }
  async answer({ id, method, request }) {
    try {
      this.post({ type: 'reply', id, reply: await this.call(method, request) });
    } catch (error) {
      this.post({ type: 'reply', id, error: { status: error.status ?? status.internal, message: error.message } });
    }
  }
}

function dropOf(map, id) { for (const [number, one] of map) if (one.id === id) map.delete(number); }
function withoutBody({ rest_body, ...description }) { return description; }

let session = null;
onmessage = async ({ data }) => {
  if (data.type === 'start') {
    session?.stop();
    session = data.film ? new ((await import('./player.js')).playerOf(Session))(data) : new Session(data);
    session.run();
  }
  if (data.type === 'stop' && session) {
    session.stop();
    session.tell('ended');
  }
  if (data.type === 'view') session?.setView(data);
  if (data.type === 'hands') session?.setHands(data);
  if (data.type === 'order_done') session?.giveBack(data.order);
  if (data.type === 'call') session?.answer(data);
  if (data.type === 'film') session?.control?.(data);
};
