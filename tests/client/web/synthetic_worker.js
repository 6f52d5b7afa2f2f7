// SPDX-License-Identifier: Apache-2.0
// A worker for checks of the page without a server: it sends the scene of reference_picture, sorts it for the view,
// moves the broken box (12) while a hand pulls or grips it, and answers calls. Tokens: 'wrong' is refused.
import { readScene } from '/test/scene.js';

let scene = null, positions = null, view = null, timer = 0, tick = 0, paused = false, viewMoved = false, heldBefore = true;
const hands = { left: null, right: null };
const log = { shots: 0, hands: 0, views: 0, orders: 0, done: 0, calls: [] };
const lifted = { base: null, offset: 0 };

// Positions of the kernels of an object, as the passes skin_rigid and skin_lattice without haze.
function skin(object) {
  const floats = new Float32Array(object.rest.buffer, object.rest.byteOffset, object.rest.length), rows = object.rows;
  for (let i = 0; i < object.count; ++i) {
    const at = [floats[10 * i + 1], floats[10 * i + 2], floats[10 * i + 3]], driver = object.rest[10 * i], out = 3 * (object.base + i);
    if (!object.lattice) {
      for (let axis = 0; axis < 3; ++axis) {
        const r = 16 * driver + 4 * axis;
        positions[out + axis] = rows[r] * at[0] + rows[r + 1] * at[1] + rows[r + 2] * at[2] + rows[r + 3];
      }
      continue;
    }
    positions.fill(0, out, out + 3);
    const c = at.map((x) => Math.min(1, Math.max(0, x)));
    for (let corner = 0; corner < 8; ++corner) {
      const weight = [0, 1, 2].reduce((w, axis) => w * ((corner >> axis) & 1 ? c[axis] : 1 - c[axis]), 1);
      const node = 16 * object.cells[8 * driver + corner];
      for (let axis = 0; axis < 3; ++axis) positions[out + axis] += weight * rows[node + axis];
    }
  }
}

function sorted() {
  const count = positions.length / 3, keys = new Float32Array(count), order = new Uint32Array(count);
  for (let i = 0; i < count; ++i) {
    const d = [0, 1, 2].map((axis) => positions[3 * i + axis] - view.position[axis]);
    keys[i] = view.by_distance ? Math.hypot(...d) : d[0] * view.axis[0] + d[1] * view.axis[1] + d[2] * view.axis[2];
    order[i] = i;
  }
  ++log.orders;
  return order.sort((a, b) => keys[a] - keys[b]);
}

function holds(hand, index) {
  if (!hand || !(hand.trigger > 0.5 || hand.squeeze > 0.5)) return null;
  return { hand: index, object_id: 12, point_m: [-0.6, 0.4 + lifted.offset, 0.1], force_n: [2, 6, 0], grabbed: hand.squeeze > 0.5, contact_impulse_n_s: 0 };
}

function frame() {
  if (!view) return;
  const held = [holds(hands.left, 0), holds(hands.right, 1)].filter(Boolean);
  const box = scene.objects.find((object) => object.id === 12), drivers = [];
  if (held.length && !paused) {
    lifted.offset = Math.min(0.4, lifted.offset + 0.02);
    for (let body = 0; body < box.rows.length / 16; ++body) box.rows[16 * body + 7] = lifted.base[16 * body + 7] + lifted.offset;
    skin(box);
    drivers.push({ id: 12, rows: box.rows.slice() });
  }
  if (!held.length && !heldBefore) {
    if (!viewMoved) return;
    viewMoved = false;
    const moved = sorted();
    return postMessage({ type: 'order', order: moved, count: moved.length }, [moved.buffer]);
  }
  heldBefore = held.length > 0;
  viewMoved = false;
  const order = sorted();
  ++tick;
  postMessage({ type: 'frame', tick, drivers, order, count: order.length, removed: [], hands: held, run: { paused, simulated_s: tick / 30, edit_revision: 3 }, step_ms: 1.5 }, [order.buffer]);
}

async function start(token) {
  postMessage({ type: 'status', state: 'connecting', message: '' });
  if (token === 'wrong') return postMessage({ type: 'status', state: 'refused', message: 'the token is not known' });
  scene = await readScene('/reference');
  postMessage({ type: 'status', state: 'loading', message: '50 %' });
  postMessage({ type: 'joined', join: { view_only: false, rate_hz: 90 } });
  positions = new Float32Array(3 * scene.objects.reduce((sum, object) => sum + object.count, 0));
  const names = { 1: 'floor', 12: 'broken box', 40: 'soft block', 41: 'small box' };
  for (const object of scene.objects) {
    const value = (best, reason) => ({ low: 0.8 * best, best, high: 1.3 * best, source: 1, reason });
    postMessage({ type: 'object', object: { id: object.id, name: names[object.id], environment: object.environment, hidden: false, kind: object.lattice ? 'lattice' : 'rigid',
      description: { mass_kg: object.environment ? 0 : 0.4, physics: { label: 'box', material: 'oak', behavior: object.lattice ? 3 : 2, behavior_reason: 'a synthetic object', mass_kg: value(0.4, 'volume times density'), friction: value(0.5, 'oak on oak') }, warnings: [] } } });
    skin(object);
    const { id, base, count, sh_degree, antialiased, lattice, bounds_m } = object;
    postMessage({ type: 'kernels', id, base, count, sh_degree, antialiased, lattice, bounds_m, rest: object.rest.slice(), looks: object.looks.slice(), bands: object.bands.slice(), cells: object.cells?.slice() ?? null });
  }
  lifted.base = scene.objects.find((object) => object.id === 12).rows.slice();
  view ??= { position: [0, 1, 2.5], axis: [0, -0.3, -1], by_distance: false };
  const order = sorted();
  postMessage({ type: 'frame', tick, drivers: scene.objects.map(({ id, rows }) => ({ id, rows: rows.slice() })), order, count: order.length, removed: [], hands: [], run: { simulated_s: 0, edit_revision: 3 }, step_ms: 1 }, [order.buffer]);
  postMessage({ type: 'status', state: 'live', message: '' });
  postMessage({ type: 'stats', rtt_ms: 0.4, decode_ms: 0.1, keys_ms: 0.5, sort_ms: 0.7, bytes_s: 12000, kernels: positions.length / 3 });
  timer = setInterval(frame, 100);
}

const replies = {
  GetScene: () => ({ scene: { background_rgb: [] }, undo: 'Move broken box', redo: '' }),
  ControlRun: (request) => { if ('pause' in request) paused = request.pause; heldBefore = true; return { paused }; },
  UndoEdit: () => ({}),
  AnalyzeObject: (request) => ({ object: request.object, parameters: { label: 'box', material: 'oak', behavior: 2, mass_kg: { low: 0.3, best: 0.41, high: 0.6, source: 2, reason: 'asked the model' } }, warnings: [] }),
  Log: () => ({ ...log, right: hands.right, left: hands.left, view, lifted: lifted.offset, paused }),
};

onmessage = ({ data }) => {
  if (data.type === 'start') start(data.token);
  if (data.type === 'view') { view = data; viewMoved = true; ++log.views; }
  if (data.type === 'hands') {
    if (data.right?.shoot && !hands.right?.shoot) ++log.shots;
    ++log.hands;
    hands.left = data.left;
    hands.right = data.right;
  }
  if (data.type === 'order_done') ++log.done;
  if (data.type === 'stop') clearInterval(timer);
  if (data.type === 'call') {
    if (data.method !== 'Log') log.calls.push(data.method);
    const reply = replies[data.method];
    if (reply) postMessage({ type: 'reply', id: data.id, reply: reply(data.request) });
    else postMessage({ type: 'reply', id: data.id, error: { status: 5, message: `no method ${data.method}` } });
  }
};
