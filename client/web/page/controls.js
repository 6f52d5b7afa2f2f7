// SPDX-License-Identifier: Apache-2.0
// Camera and hands of a window: mouse, keys and touch. A drag from an object pulls it, a drag from the background
// orbits. Keys are those of the native client (client/xr/window/window_display.cpp):
//   right drag orbits, middle drag (or shift) pans, wheel zooms, ctrl-drag pulls, W A S D Q E fly, space shoots,
//   P pauses, full stop steps, H hides the panels, Home frames all, ctrl-Z and ctrl-Y undo and redo
import { makeEye } from './renderer.js';
import { add, clamp, dot, multiply, rotate, scaled, subtract, turnAheadTo, unit } from './vector.js';

// Twin of client/viewer/camera/orbit_camera.cpp, and of frame_boxes in common/splat/camera/frame_bounds.cpp.
const kVerticalFov_rad = 0.7, kElevation_rad = 0.35, kMaxElevation_rad = 1.55, kMinDistance_m = 0.05;
const kFillShare = 0.9; // of the half width and height, for motion
const kMaxCentreOffset = 0.15; // of an environment that surrounds the objects, relative to their size
const kLongPress_ms = 350, kTapMotion_px = 8;

const middleOf = (box) => [0, 1, 2].map((i) => 0.5 * (box[i] + box[i + 3]));

export class OrbitCamera {
  constructor() {
    this.target = [0, 0, 0];
    this.distance_m = 2;
    this.azimuth = 0;
    this.elevation = kElevation_rad;
  }
  get orientation() {
    const a = 0.5 * this.azimuth, e = -0.5 * this.elevation;
    return multiply([Math.cos(a), 0, Math.sin(a), 0], [Math.cos(e), Math.sin(e), 0, 0]);
  }
  get position() {
    return add(this.target, rotate(this.orientation, [0, 0, this.distance_m]));
  }
  orbit(dx, dy, height) {
    this.azimuth -= (Math.PI * dx) / height;
    this.elevation = clamp(this.elevation + (Math.PI * dy) / height, -kMaxElevation_rad, kMaxElevation_rad);
  }
  pan(dx, dy, height) {
    const metresAPixel = (2 * this.distance_m * Math.tan(0.5 * kVerticalFov_rad)) / height;
    this.target = add(this.target, rotate(this.orientation, [-dx * metresAPixel, dy * metresAPixel, 0]));
  }
  zoom(notches) {
    this.distance_m = Math.max(kMinDistance_m, this.distance_m * 0.9 ** notches);
  }
  // `seconds`: by axis.
  fly(seconds) {
    this.target = add(this.target, rotate(this.orientation, scaled(seconds, this.distance_m)));
  }
  // Sees all boxes [min, max] from slightly above, with the environment behind them. `freeWidth_px`: of the columns
  // at the left that no panel covers.
  frame(boxes, environment, size, freeWidth_px = size[0]) {
    if (!boxes.length) boxes = [[-0.5, -0.5, -0.5, 0.5, 0.5, 0.5]];
    const all = [0, 1, 2, 3, 4, 5].map((i) => (i < 3 ? Math.min : Math.max)(...boxes.map((box) => box[i])));
    const middle = middleOf(all), largest = Math.max(...[0, 1, 2].map((i) => all[i + 3] - all[i]));
    this.azimuth = 0;
    this.elevation = kElevation_rad;
    if (environment) {
      const away = subtract(middle, middleOf(environment));
      if (Math.hypot(away[0], away[2]) > kMaxCentreOffset * largest) this.azimuth = Math.atan2(away[0], away[2]);
    }
    const focal = (0.5 * size[1]) / Math.tan(0.5 * kVerticalFov_rad);
    const half = [0.5 * kFillShare * freeWidth_px, 0.5 * kFillShare * size[1]], offset = [0.5 * (freeWidth_px - size[0]), 0];
    const lowEdge = [0, 1].map((i) => (half[i] - offset[i]) / focal), highEdge = [0, 1].map((i) => (half[i] + offset[i]) / focal);
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => rotate(this.orientation, axis));
    const high = [-Infinity, -Infinity], low = [Infinity, Infinity];
    for (const box of boxes) {
      for (let corner = 0; corner < 8; ++corner) {
        const at = [0, 1, 2].map((i) => box[i + ((corner >> i) & 1 ? 3 : 0)]);
        const seen = axes.map((axis) => dot(axis, at));
        for (const i of [0, 1]) {
          high[i] = Math.max(high[i], seen[i] + highEdge[i] * seen[2]);
          low[i] = Math.min(low[i], seen[i] - lowEdge[i] * seen[2]);
        }
      }
    }
    const back = Math.max(...[0, 1].map((i) => (high[i] - low[i]) / (lowEdge[i] + highEdge[i])));
    const across = [0, 1].map((i) => 0.5 * (high[i] + low[i] + (lowEdge[i] - highEdge[i]) * back));
    const position = add(add(scaled(axes[0], across[0]), scaled(axes[1], across[1])), scaled(axes[2], back));
    this.distance_m = Math.max(kMinDistance_m, Math.hypot(...subtract(middle, position)));
    this.target = subtract(position, scaled(axes[2], this.distance_m));
  }
  eye(size) {
    const focal = (0.5 * size[1]) / Math.tan(0.5 * kVerticalFov_rad), turn = this.orientation;
    return makeEye({ position: this.position, right: rotate(turn, [1, 0, 0]), down: rotate(turn, [0, -1, 0]), forward: rotate(turn, [0, 0, -1]),
      focal: [focal, focal], centre: [0.5 * size[0], 0.5 * size[1]], size });
  }
  // Half angle of a cone around the picture, with the margin of the native client for turning.
  halfAngle_rad(size) {
    return Math.min(Math.PI, Math.atan(Math.tan(0.5 * kVerticalFov_rad) * Math.hypot(1, size[0] / size[1])) + 0.35);
  }
}

// The ray of a pixel as a hand: its aim and its grip.
export function handThrough(eye, x_px, y_px, trigger) {
  const across = (x_px - eye.centre[0]) / eye.focal[0], down = (y_px - eye.centre[1]) / eye.focal[1];
  const direction = unit(add(eye.forward, add(scaled(eye.right, across), scaled(eye.down, down))));
  const orientation = turnAheadTo(direction);
  return { aim_position: eye.position, aim_orientation: orientation, grip_position: eye.position, grip_orientation: orientation, trigger, squeeze: 0, shoot: false };
}

export function pixelOf(eye, point) {
  const offset = subtract(point, eye.position), depth = dot(eye.forward, offset);
  if (!(depth > eye.near_m)) return null;
  return [eye.centre[0] + (eye.focal[0] * dot(eye.right, offset)) / depth, eye.centre[1] + (eye.focal[1] * dot(eye.down, offset)) / depth];
}

// Corners of the arrow of a force in pixels, or null. Twin of client/viewer/hands/force_arrow.cpp.
export function projectArrow(eye, point, force_n, metresANewton) {
  const tail = pixelOf(eye, point);
  if (!tail) return null;
  const offset = subtract(point, eye.position), depth = dot(eye.forward, offset), along = scaled(force_n, metresANewton);
  const away = dot(eye.forward, along);
  const step = [(eye.focal[0] * (dot(eye.right, along) - (away * dot(eye.right, offset)) / depth)) / depth,
    (eye.focal[1] * (dot(eye.down, along) - (away * dot(eye.down, offset)) / depth)) / depth];
  const full = Math.hypot(...step);
  if (!(full >= 4)) return null;
  const ahead = step.map((x) => x / full);
  const room = [0, 1].map((i) => (ahead[i] === 0 ? Infinity : Math.max(0, ((ahead[i] > 0 ? eye.size[i] - 24 : 24) - tail[i]) / ahead[i])));
  const reach = Math.min(full, 0.3 * Math.min(...eye.size), ...room);
  if (!(reach >= 4)) return null;
  const neck = reach - Math.min(18, 0.6 * reach), left = [ahead[1], -ahead[0]];
  const corner = (forward, width) => [tail[0] + forward * ahead[0] + 0.5 * width * left[0], tail[1] + forward * ahead[1] + 0.5 * width * left[1]];
  return [corner(0, 8), corner(neck, 8), corner(neck, 22), corner(reach, 0), corner(neck, -22), corner(neck, -8), corner(0, -8)];
}

// Length of an arrow: an object's weight is 0.4 of its size.
export const metresANewton = (mass_kg, size_m) => (mass_kg > 0 && size_m > 0 ? (0.4 * size_m) / (9.81 * mass_kg) : 0.01);

// Connects a canvas to a camera and a hand. `host` has pick(x_px, y_px) -> object id or null, act(name),
// changed(), which requests a picture, and released(), which removes the hand. Pixels are those of the
// canvas.
export class WindowControls {
  constructor(canvas, camera, host) {
    Object.assign(this, { canvas, camera, host });
    this.pointers = new Map(); // by id: { at, began, button }
    this.keys = new Set();
    this.taps = new Set(); // keys pressed since the last picture, which may be up again
    this.mode = null; // 'pull' | 'orbit' | 'pan' | 'touch2'
    this.pullsByTouch = false;
    this.cursor = null; // px
    this.shots = 0;
    this.picked = null;
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, (event) => this.up(event));
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      camera.zoom(-event.deltaY / (event.deltaMode === 0 ? 100 : 3));
      host.changed();
    }, { passive: false });
    addEventListener('keydown', (event) => this.key(event, true));
    addEventListener('keyup', (event) => this.key(event, false));
    addEventListener('blur', () => this.release());
    document.addEventListener('visibilitychange', () => document.hidden && this.release());
  }

  // Lets go of everything: of a pull, of keys, of fingers.
  release() {
    this.keys.clear();
    this.pointers.clear();
    clearTimeout(this.pressTimer);
    this.mode = null;
    this.host.released();
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [((event.clientX - box.left) * this.canvas.width) / box.width, ((event.clientY - box.top) * this.canvas.height) / box.height];
  }

  down(event) {
    this.used = true; // the camera is the user's from now on
    this.canvas.focus();
    this.canvas.setPointerCapture?.(event.pointerId);
    const at = this.place(event);
    this.cursor = at;
    this.pointers.set(event.pointerId, { at, began: at });
    clearTimeout(this.pressTimer);
    if (event.pointerType === 'touch') {
      if (this.pointers.size >= 2) this.mode = 'touch2';
      else {
        this.mode = this.pullsByTouch ? 'pull' : 'orbit';
        const pointer = this.pointers.get(event.pointerId);
        this.pressTimer = setTimeout(() => {
          if (this.mode === 'orbit' && Math.hypot(...[0, 1].map((i) => pointer.at[i] - pointer.began[i])) < kTapMotion_px * devicePixelRatio) {
            this.mode = 'pull';
            navigator.vibrate?.(15);
            this.host.changed();
          }
        }, kLongPress_ms);
      }
      if (this.mode === 'pull') this.picked = this.host.pick(...at);
    } else if (event.button === 1 || (event.button === 0 && event.shiftKey)) this.mode = 'pan';
    else if (event.button === 2) this.mode = 'orbit';
    else {
      this.picked = this.host.pick(...at);
      this.mode = this.picked !== null || event.ctrlKey ? 'pull' : 'orbit';
    }
    event.preventDefault();
    this.host.changed();
  }

  move(event) {
    const at = this.place(event), pointer = this.pointers.get(event.pointerId), height = this.canvas.height;
    this.cursor = at;
    if (!pointer) return;
    const dx = at[0] - pointer.at[0], dy = at[1] - pointer.at[1];
    if (this.mode === 'orbit') this.camera.orbit(dx, dy, height);
    if (this.mode === 'pan') this.camera.pan(dx, dy, height);
    if (this.mode === 'touch2' && this.pointers.size >= 2) {
      const other = [...this.pointers.values()].find((p) => p !== pointer);
      const apart = (p) => Math.hypot(p[0] - other.at[0], p[1] - other.at[1]);
      this.camera.pan(0.5 * dx, 0.5 * dy, height);
      this.camera.zoom(Math.log(apart(at) / Math.max(1, apart(pointer.at))) / -Math.log(0.9));
    }
    pointer.at = at;
    this.host.changed();
  }

  up(event) {
    this.pointers.delete(event.pointerId);
    clearTimeout(this.pressTimer);
    if (this.pointers.size === 0) this.mode = null;
    else if (this.mode !== 'touch2') return;
    this.host.changed();
  }

  key(event, down) {
    if (event.target.closest?.('input, textarea, select')) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!down) return void this.keys.delete(key);
    if (event.ctrlKey || event.metaKey) {
      if (key === 'z' || key === 'y') {
        event.preventDefault();
        this.host.act(key === 'y' || event.shiftKey ? 'redo' : 'undo');
      }
      return;
    }
    if (event.altKey) return;
    if (key === ' ' && event.target.closest?.('button, summary')) return; // presses the button
    const fresh = !event.repeat, act = { p: 'pause', '.': 'step', h: 'hide', Home: 'frame' }[key];
    if (act && fresh) this.host.act(act);
    if (key === ' ') event.preventDefault();
    if (key === ' ' && fresh) ++this.shots;
    this.keys.add(key);
    this.taps.add(key);
    this.used = true;
    this.host.changed();
  }

  // Moves the camera by the keys that are down; a press between two pictures counts for a sixtieth of a second.
  // Returns whether it moved.
  fly(passed_s) {
    const share = (key) => (this.keys.has(key) ? passed_s : this.taps.has(key) ? Math.min(passed_s, 1 / 60) : 0);
    const direction = [share('d') - share('a'), share('e') - share('q'), share('s') - share('w')];
    this.taps.clear();
    if (!direction.some((x) => x !== 0)) return false;
    this.camera.fly(direction);
    return true;
  }

  // Samples of the right hand since the last picture; a shot has one rising edge.
  hands(eye) {
    const at = this.cursor ?? [0.5 * eye.size[0], 0.5 * eye.size[1]];
    const hand = handThrough(eye, at[0], at[1], this.mode === 'pull' ? 1 : 0);
    const samples = [];
    for (; this.shots > 0; --this.shots) samples.push({ ...hand, shoot: true }, hand);
    return samples.length ? samples : [hand];
  }
}
