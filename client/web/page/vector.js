// SPDX-License-Identifier: Apache-2.0
// Vectors are arrays of three numbers, quaternions [w, x, y, z] as in the protocol.
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
export const unit = (a) => scaled(a, 1 / Math.max(length(a), 1e-12));
export const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

// Rotates -z to a unit vector, by the shortest way.
export function turnAheadTo(v) {
  const w = 1 - v[2];
  if (w < 1e-9) return [0, 0, 1, 0];
  const q = [w, v[1], -v[0], 0];
  const s = 1 / Math.hypot(...q);
  return q.map((x) => x * s);
}

export function multiply(a, b) {
  return [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]];
}

export function rotate(q, v) {
  const axis = [q[1], q[2], q[3]], twice = scaled(cross(axis, v), 2);
  return add(add(v, scaled(twice, q[0])), cross(axis, twice));
}
