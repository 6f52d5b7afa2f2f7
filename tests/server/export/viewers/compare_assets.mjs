// SPDX-License-Identifier: Apache-2.0
// node compare_assets.mjs REFERENCE.csv FILE.csv...: compares kernels that another program has read from our files
// (splat-transform of PlayCanvas, as .csv) with those that it has read from the asset they were converted from. Formats
// have their own order, so each column is compared in ascending order: no entry may differ by more than the step of its
// format. Turns are compared by the covariances. FILE names its format: sog.csv.
import fs from 'node:fs';
import path from 'node:path';

// Worst-case errors, as common/gaussian/asset_file.h states them. `position` and `scale` (log) by the range of all
// values, `colour` (f_dc), `opacity` (0 to 1), `harmonics`; `covariance` of its range. `within`: values that the format
// holds; others become the nearest of these.
const steps = {
  ply: { position: () => 1e-6, scale: () => 1e-6, colour: () => 1e-6, opacity: 1e-6, harmonics: 1e-6, covariance: 1e-6 },
  'compressed.ply': { position: (r) => r / 2046, scale: (r) => r / 2046, colour: (r) => r / 510, opacity: 1 / 510,
    harmonics: 1 / 32, covariance: 0.02 },
  spz: { position: () => 2 ** -12, scale: () => 1 / 32, colour: () => 0.0131, opacity: 1 / 510, harmonics: 8.5 / 128,
    covariance: 0.1, within: { scale: [-10, 5.94], colour: [-3.33, 3.33] } },
  sog: { position: (r) => (r + 1) * 8 / 65535, scale: (r) => r / 128, colour: (r) => r / 128, opacity: 1 / 510,
    harmonics: 0.1, covariance: 0.2 },
  splat: { position: () => 1e-6, scale: () => 1e-5, colour: () => 0.007, opacity: 1 / 510, covariance: 0.1,
    within: { colour: [-1.77, 1.77] } },
};

function read(file) {
  const [head, ...lines] = fs.readFileSync(file, 'utf8').trim().split('\n');
  const names = head.split(',');
  const columns = Object.fromEntries(names.map((name) => [name, new Float64Array(lines.length)]));
  lines.forEach((line, row) => line.split(',').forEach((value, k) => { columns[names[k]][row] = Number(value); }));
  return { columns, count: lines.length };
}

// The six entries of R S² R^T of each kernel.
function covariances({ columns, count }) {
  const entries = Array.from({ length: 6 }, () => new Float64Array(count));
  for (let i = 0; i < count; ++i) {
    const q = [0, 1, 2, 3].map((k) => columns[`rot_${k}`][i]);
    const length = Math.hypot(...q);
    const [w, x, y, z] = q.map((value) => value / length);
    const s = [0, 1, 2].map((k) => Math.exp(columns[`scale_${k}`][i]));
    const r = [
      [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ];
    [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]].forEach(([a, b], k) => {
      entries[k][i] = [0, 1, 2].reduce((sum, c) => sum + r[a][c] * s[c] * s[c] * r[b][c], 0);
    });
  }
  return entries;
}

const range = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity) - values.reduce((a, b) => Math.min(a, b), Infinity);
function largest(a, b) {
  const one = Float64Array.from(a).sort(), other = Float64Array.from(b).sort();
  return one.reduce((most, value, i) => Math.max(most, Math.abs(value - other[i])), 0);
}
const sigmoid = (values) => values.map((value) => 1 / (1 + Math.exp(-value)));

const [reference, ...files] = process.argv.slice(2);
const truth = read(reference);
const truths = covariances(truth);
let failed = files.length === 0 || !(truth.count > 0);
for (const file of files) {
  const step = steps[path.basename(file, '.csv')];
  const found = read(file);
  const problems = [];
  if (found.count !== truth.count) problems.push(`${found.count} kernels instead of ${truth.count}`);
  const worst = {};
  const compare = (kind, name, a, b, bound) => {
    const off = b ? largest(a, b) : Infinity;
    worst[kind] = Math.max(worst[kind] ?? 0, off / bound);
    if (!(off <= bound * 1.001 + 1e-6)) problems.push(`${name} is off by ${off.toPrecision(3)}, of ${bound.toPrecision(3)}`);
  };
  const of = (kind, name) => {
    const [low, high] = step.within?.[kind] ?? [-Infinity, Infinity];
    const own = truth.columns[name].map((value) => Math.min(Math.max(value, low), high));
    compare(kind, name, own, found.columns[name], step[kind](range(own)));
  };
  ['x', 'y', 'z'].forEach((name) => of('position', name));
  [0, 1, 2].forEach((k) => of('scale', `scale_${k}`));
  [0, 1, 2].forEach((k) => of('colour', `f_dc_${k}`));
  compare('opacity', 'opacity', sigmoid(truth.columns.opacity), sigmoid(found.columns.opacity), step.opacity);
  if (step.harmonics) {
    Object.keys(truth.columns).filter((name) => name.startsWith('f_rest_'))
      .forEach((name) => compare('harmonics', name, truth.columns[name], found.columns[name], step.harmonics));
  }
  covariances(found).forEach((entry, k) =>
    compare('covariance', `covariance ${k}`, truths[k], entry, step.covariance * range(truths[k])));
  console.log(`${path.basename(file)}: ${found.count} kernels; errors over the step: ` +
              Object.entries(worst).map(([kind, part]) => `${kind} ${part.toFixed(2)}`).join(', '));
  problems.slice(0, 8).forEach((problem) => console.log(`${path.basename(file)}: ${problem}`));
  failed ||= problems.length > 0;
}
process.exit(failed ? 1 : 0);
