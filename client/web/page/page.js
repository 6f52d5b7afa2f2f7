// SPDX-License-Identifier: Apache-2.0
// Start and state of the page: the worker's messages go to the renderer and the panels, the user's actions to the
// worker. Pictures are drawn only when something changed.
import { metresANewton, OrbitCamera, pixelOf, projectArrow, WindowControls } from './controls.js';
import { number, Panels } from './panels.js';
import { kBackground, Renderer } from './renderer.js';
import { length } from './vector.js';
import { Headset } from './xr.js';

const kTokenKey = 'livegs-token';
const kRate_hz = 60;
const kViewActions = ['frame', 'hide', 'enter']; // those of a client that may only watch
const kMaxPixelRatio = 2; // of a window; a phone's 3 costs twice the pixels and shows no more of a splat

const canvas = document.getElementById('picture'), overlay = document.getElementById('overlay');
const gl = canvas.getContext('webgl2', { alpha: false, antialias: false, depth: false, stencil: false, powerPreference: 'high-performance' });

// In a frame one can only watch, without the token that this browser keeps.
const kFramed = window.top !== window;
// In the fragment, which is never sent: a one-time code `pair`; or `token` and `view`, of <livegs-view>. `film`: of a
// recording that was exported.
const given = new URLSearchParams(location.hash.slice(1)), film = document.body.dataset.film && new URL(document.body.dataset.film, location.href).href;

class Page {
  constructor() {
    this.panels = new Panels(this);
    this.camera = new OrbitCamera();
    this.controls = new WindowControls(canvas, this.camera, this);
    this.headset = new Headset(gl, { camera: this.camera, renderer: () => this.renderer, held: () => this.held, objectOf: (id) => this.objectOf(id),
      sendHands: (left, right) => this.viewOnly || this.post({ type: 'hands', left, right }), sendView: (view) => this.post({ type: 'view', ...view }),
      notice: (text) => this.panels.notice(text), problem: () => (this.state === 'live' ? '' : `${this.state}: ${this.message || 'please wait'}`), ended: () => { this.offerHeadset(); this.changed(); } });
    this.calls = new Map();
    this.nextCall = 1;
    this.pictures = 0;
    this.reset();
    addEventListener('resize', () => this.changed());
    document.addEventListener('visibilitychange', () => this.changed());
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      this.headset.leave();
      this.worker?.terminate();
      this.panels.status('lost', 'the graphics device was lost; waiting for it');
    });
    // All data of the device are gone: the worker sends them again, from its cache.
    canvas.addEventListener('webglcontextrestored', () => this.start());
    navigator.xr?.addEventListener?.('devicechange', () => this.offerHeadset());
    this.offerHeadset();
    setInterval(() => {
      this.fps = this.pictures;
      this.pictures = 0;
    }, 1000);
  }

  reset() {
    this.objects = new Map();
    this.waitingKernels = new Map(); // until an order that contains them
    this.waitingRows = new Map(); // of objects without kernels yet
    this.held = [];
    this.run = {};
    this.framed = false;
    this.unseen = new Set(); // objects of the start without kernels yet
    this.viewOnly = kFramed || given.has('view');
    this.editRevision = 0;
    for (const id of [...this.panels.items.keys()]) this.panels.remove(id);
    for (const { reject } of this.calls.values()) reject(new Error('the connection was restarted; try again'));
    this.calls.clear();
  }

  start() {
    this.worker?.terminate();
    this.reset();
    this.renderer = new Renderer(gl);
    this.worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    this.worker.onmessage = ({ data }) => this.take(data);
    this.worker.onerror = (event) => this.panels.status('ended', `the worker failed: ${event.message ?? 'it could not be loaded'}; reload the page`);
    this.panels.status('connecting', '');
    this.post({ type: 'start', token: given.get('token') ?? (kFramed ? '' : load(kTokenKey)), rate_hz: kRate_hz, wasm: new URL('./livegs.wasm', import.meta.url).href, film });
    this.changed();
  }

  post(message, transfer = []) { this.worker?.postMessage(message, transfer); }

  // A unary call; a promise of the reply.
  send(method, request) {
    const id = this.nextCall++;
    return new Promise((resolve, reject) => {
      this.calls.set(id, { resolve, reject });
      this.post({ type: 'call', id, method, request });
    });
  }

  async pair(code) {
    try {
      const reply = await fetch('/pair', { method: 'POST', body: code });
      if (!reply.ok) return this.panels.askForCode(reply.status === 401 ? 'This code is wrong, used or too old. Ask for a new link.' : `The server answered ${reply.status}.`);
      save(kTokenKey, await reply.text());
    } catch {
      return this.panels.askForCode('The server does not answer. Check that it is running.');
    }
    document.getElementById('pair').hidden = true;
    this.start();
  }

  take(m) {
    const takers = {
      status: () => {
        Object.assign(this, { state: m.state, message: m.message });
        this.panels.status(m.state, m.message);
      },
      joined: () => {
        this.viewOnly = Boolean(m.join.view_only) || kFramed || given.has('view');
        document.body.toggleAttribute('data-view-only', this.viewOnly);
        this.unseen = new Set((m.join.objects ?? []).map((one) => one.object_id));
        this.askForScene();
      },
      object: () => {
        this.objects.set(m.object.id, { ...this.objects.get(m.object.id), ...m.object });
        this.mark(m.object.id);
        this.panels.object(m.object);
      },
      removed: () => {
        this.objects.delete(m.id);
        this.waitingKernels.delete(m.id);
        this.renderer.remove(m.id);
        this.panels.remove(m.id);
      },
      kernels: () => this.waitingKernels.set(m.id, m),
      moved: () => this.moveTo(m),
      film: () => this.panels.film(m),
      frame: () => this.takeFrame(m),
      order: () => this.takeOrder(m),
      stats: () => this.panels.stats({ ...m, fps: this.fps }),
      reply: () => {
        const call = this.calls.get(m.id);
        this.calls.delete(m.id);
        if (m.error) call?.reject(Object.assign(new Error(m.error.message), { status: m.error.status }));
        else call?.resolve(m.reply);
      },
    };
    takers[m.type]?.();
    if (m.type === 'object' || m.type === 'removed') this.changed();
  }

  // The page of the next server. Only the token for that server goes there.
  moveTo({ address, token }) {
    const next = new URL(`${location.protocol}//${address}/`);
    next.hash = new URLSearchParams({ ...(token ? { token } : {}), ...(given.has('view') ? { view: '' } : {}) });
    location.replace(next);
  }

  takeFrame(m) {
    for (const driver of m.drivers ?? []) this.waitingRows.set(driver.id, driver);
    for (const id of m.removed ?? []) this.take({ type: 'removed', id });
    if (m.hands && (m.hands.length || this.held.length)) {
      this.changed();
      this.held = m.hands.map((one) => ({ ...one, force_n: one.force_n?.length === 3 ? one.force_n : [0, 0, 0], point_m: one.point_m ?? [0, 0, 0] }));
      this.headset.onHands(this.held);
      this.panels.force(this.held.map((one) => ({ name: this.objectOf(one.object_id).name, force_n: length(one.force_n) })));
    }
    if (m.run) {
      this.run = m.run;
      this.panels.run(m.run, m.step_ms, this.viewOnly);
      const revision = Number(m.run.edit_revision ?? 0);
      if (revision !== this.editRevision) {
        this.editRevision = revision;
        this.askForScene();
      }
    }
    this.takeOrder(m);
  }

  // Kernels wait for the first order that has their places, so that a picture never mixes two layouts.
  takeOrder(m) {
    if (m.order) {
      let frames = this.waitingKernels.size > 0 && (!this.framed || this.state !== 'live');
      for (const [id, kernels] of this.waitingKernels) {
        this.renderer.setKernels(kernels);
        const object = this.objects.get(id) ?? { id, name: `object ${id}` };
        this.objects.set(id, { ...object, bounds_m: kernels.bounds_m });
        this.mark(id);
        frames = this.unseen.delete(id) || frames; // of those at the start, each comes into view
      }
      this.waitingKernels.clear();
      this.changed();
      this.renderer.setOrder(m.order, m.count, Boolean(this.headset.session));
      this.post({ type: 'order_done', order: m.order }, [m.order.buffer]);
      if (frames && !this.controls.used) this.frameAll();
    }
    for (const [id, driver] of this.waitingRows) {
      if (!this.renderer.objects.has(id)) continue;
      this.renderer.setDrivers(id, driver.rows, driver.body_gradient ?? driver.lattice?.body_gradient);
      this.waitingRows.delete(id);
      this.changed();
    }
  }

  // Tells the renderer which kernels are hidden, and which cannot be touched.
  mark(id) {
    const drawn = this.renderer.objects.get(id), object = this.objects.get(id);
    if (drawn) Object.assign(drawn, { environment: Boolean(object?.environment), hidden: Boolean(object?.hidden) });
  }

  objectOf(id) {
    const object = this.objects.get(id), box = object?.bounds_m;
    return { name: object?.name ?? `object ${id}`, mass_kg: Number(object?.description?.mass_kg ?? 0),
      size_m: box ? Math.max(box[3] - box[0], box[4] - box[1], box[5] - box[2]) : 0 };
  }

  async askForScene() {
    try {
      const scene = await this.send('GetScene', {});
      this.panels.undo(scene);
      const rgb = scene.scene?.background_rgb ?? [];
      this.renderer.background = rgb.length === 3 ? rgb.map(Number) : kBackground;
      this.changed();
    } catch {
      this.panels.undo(null); // the token has no scope for it, or the scene cannot be edited
    }
  }

  frameAll() {
    const boxes = [...this.objects.values()].filter((o) => o.bounds_m && !o.environment && !o.hidden).map((o) => o.bounds_m);
    const environment = [...this.objects.values()].find((o) => o.environment && o.bounds_m)?.bounds_m;
    if (!boxes.length && environment) boxes.push(environment);
    const panel = document.getElementById('panel').getBoundingClientRect(), size = [canvas.clientWidth, canvas.clientHeight];
    this.camera.frame(boxes, environment, size, panel.left > 0.3 * size[0] ? panel.left : size[0]);
    this.framed = boxes.length > 0;
    this.changed();
  }

  async act(name) {
    if (this.viewOnly && !kViewActions.includes(name)) return;
    const control = (request) => this.send('ControlRun', request);
    const actions = {
      pause: () => control({ pause: !(this.run.paused || this.run.waiting) }),
      step: () => control({ step_ticks: 1 }),
      reset: () => control({ reset: true }),
      undo: () => this.send('UndoEdit', { redo: false }).then(() => this.askForScene()),
      redo: () => this.send('UndoEdit', { redo: true }).then(() => this.askForScene()),
      frame: () => this.frameAll(),
      hide: () => { document.getElementById('panels').hidden = !document.getElementById('panels').hidden; },
      shoot: () => { ++this.controls.shots; this.controls.cursor = null; this.changed(); },
      enter: () => (this.headset.session ? this.headset.leave() : this.headset.enter().then(() => this.offerHeadset())),
    };
    try {
      await actions[name]();
    } catch (error) {
      this.panels.notice(`${name}: ${error.message}`);
    }
  }

  // Sent at once: a hidden page draws no pictures.
  released() {
    if (this.headset.session || this.viewOnly) return; // the headset has hands of its own
    this.post({ type: 'hands', left: null, right: null });
    this.sentHand = '';
    this.changed();
  }

  togglePull() { return (this.controls.pullsByTouch = !this.controls.pullsByTouch); }

  pick(x_px, y_px) {
    if (!this.eye || !this.renderer.count || this.viewOnly) return null;
    const id = this.renderer.pick(this.eye, x_px, y_px);
    if (id !== null) this.panels.choose(id);
    this.changed();
    return id;
  }

  async offerHeadset() {
    const supported = await navigator.xr?.isSessionSupported?.('immersive-vr').catch(() => false);
    if (supported || this.headset?.session) this.panels.xr(this.headset.session ? 'Leave VR' : 'Enter VR', true);
  }

  // Asks for a picture.
  changed() {
    if (this.asked || this.headset?.session) return;
    this.asked = true;
    requestAnimationFrame((now) => this.picture(now));
  }

  picture(now_ms) {
    this.asked = false;
    if (this.headset.session || !this.renderer || gl.isContextLost()) return;
    const passed_s = 1e-3 * (now_ms - (this.last_ms ?? now_ms));
    this.last_ms = now_ms;
    if (this.controls.fly(Math.min(passed_s, 0.1))) this.changed(); // again while a key is down
    const ratio = Math.min(devicePixelRatio, kMaxPixelRatio), limit = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const size = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.min(limit, Math.round(side * ratio))));
    for (const one of [canvas, overlay]) {
      if (one.width !== size[0]) one.width = size[0];
      if (one.height !== size[1]) one.height = size[1];
    }
    this.eye = this.camera.eye(size);
    this.sendInput(size);
    this.renderer.drawWindow(this.eye);
    this.drawOverlay(ratio);
    ++this.pictures;
  }

  sendInput(size) {
    const view = { type: 'view', position: this.camera.position, axis: this.eye.forward, by_distance: false, half_angle_rad: this.camera.halfAngle_rad(size) };
    const text = JSON.stringify(view);
    if (text !== this.sentView) this.post(view);
    this.sentView = text;
    if (this.viewOnly) return;
    for (const right of this.controls.hands(this.eye)) {
      const hand = JSON.stringify(right);
      if (hand === this.sentHand) continue;
      this.sentHand = hand;
      this.post({ type: 'hands', left: null, right });
    }
  }

  // Forces as arrows with their newtons. Twin of client/xr/window/draw_arrow.cpp.
  drawOverlay(ratio) {
    overlay.hidden = this.held.length === 0;
    if (overlay.hidden) return;
    const pen = overlay.getContext('2d');
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, overlay.width, overlay.height);
    const eye = { ...this.eye, size: this.eye.size.map((x) => x / ratio), focal: this.eye.focal.map((x) => x / ratio), centre: this.eye.centre.map((x) => x / ratio) };
    pen.setTransform(ratio, 0, 0, ratio, 0, 0); // CSS pixels
    pen.font = '600 14px system-ui, sans-serif';
    pen.textBaseline = 'middle';
    for (const one of this.held) {
      const at = pixelOf(eye, one.point_m), object = this.objectOf(one.object_id);
      if (!at) continue;
      const outline = projectArrow(eye, one.point_m, one.force_n, metresANewton(object.mass_kg, object.size_m));
      let label = [at[0] + 16, at[1]];
      if (outline) {
        pen.beginPath();
        outline.forEach(([x, y]) => pen.lineTo(x, y));
        pen.closePath();
        for (const [ink, width] of [['#fffaf0', 7], ['#14100a', 4]]) {
          pen.lineWidth = width;
          pen.strokeStyle = ink;
          pen.stroke();
        }
        pen.fillStyle = '#ff961e';
        pen.fill();
        label = [outline[3][0] + 16, outline[3][1] + (outline[3][1] < at[1] ? -10 : 10)];
      }
      for (const [ink, radius] of [['#fffaf0', 8], ['#14100a', 6.5], ['#ff961e', 4]]) {
        pen.beginPath();
        pen.arc(at[0], at[1], radius, 0, 2 * Math.PI);
        pen.fillStyle = ink;
        pen.fill();
      }
      const text = `${number(length(one.force_n))} N  ${object.name}`, width = pen.measureText(text).width;
      const x = Math.max(6, Math.min(label[0], eye.size[0] - width - 6)), y = Math.max(12, Math.min(label[1], eye.size[1] - 12));
      pen.fillStyle = 'rgb(16 18 22 / 85%)';
      pen.fillRect(x - 6, y - 12, width + 12, 24);
      pen.fillStyle = '#ffbe5a';
      pen.fillText(text, x, y);
    }
  }
}

// A browser may forbid storage; the token then lasts as long as the page.
const kept = new Map();
function load(key) {
  try { return localStorage.getItem(key) ?? kept.get(key) ?? ''; } catch { return kept.get(key) ?? ''; }
}
function save(key, value) {
  kept.set(key, value);
  try { localStorage.setItem(key, value); } catch { /* kept for this page only */ }
}

if (!gl) {
  document.getElementById('state').textContent = 'no WebGL2';
  document.getElementById('message').textContent = 'this browser or its graphics driver cannot draw the scene; try another browser';
} else {
  const page = new Page();
  window.livegs = page; // for checks and for the console
  const code = given.get('pair');
  if (code || given.has('token')) history.replaceState(null, '', location.pathname + location.search); // secrets leave the address
  if (code) page.pair(code);
  else page.start();
}
