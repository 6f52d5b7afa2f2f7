// SPDX-License-Identifier: Apache-2.0
// node --experimental-websocket store_test.mjs SERVER TOOL WASM FIELDS KIND: the worker fetches assets from a store that is
// good, cuts each transfer once, has no ranges, has damaged bytes, has another asset with bytes after its end, or refuses.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { randomBytes } from 'node:crypto';
import { existsSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { gunzipSync, gzipSync } from 'node:zlib';
import { Page, Server } from './worker_host.mjs';

const [program, tool, wasm, fields, kind] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'livegs_store_')), place = join(folder, 'store');
const box = (name, x) => ({ name, shape: { box: { size_m: [0.2, 0.2, 0.2] } }, pose: { position_m: [x, 0.1, 0] }, physics: { behavior: 'RIGID', mass_kg: 0.3 } });
writeFileSync(join(folder, 'test.scene.json'), JSON.stringify({ environment: { colliders: [{ plane: {} }] }, objects: [box('one', 0), { ...box('two', 0.5), shape: { sphere: { radius_m: 0.1 } } }] }));
execFileSync(tool, ['publish', join(folder, 'test.scene.json'), '--asset-store', place]);
const forBrowsers = new Set(JSON.parse(readFileSync(join(place, 'test.files.json'), 'utf8')).assets.map((one) => `assets/${one.web_sha256}`));

// The next asset, which is whole before the bytes that follow it.
const other = (name) => {
  const names = [...forBrowsers], next = names[(names.indexOf(name) + 1) % names.length];
  return gzipSync(Buffer.concat([gunzipSync(readFileSync(join(place, next))), randomBytes(1 << 20)]));
};

const asked = new Map();
const store = createServer((request, reply) => {
  const name = request.url.slice(1), path = join(place, name), count = (asked.get(name) ?? 0) + 1;
  asked.set(name, count);
  const browser = forBrowsers.has(name);
  if (!existsSync(path) || (browser && kind === 'refuses')) return reply.writeHead(existsSync(path) ? 403 : 404).end();
  const bytes = browser && kind === 'other' ? other(name) : readFileSync(path), range = /bytes=(\d+)-/.exec(request.headers.range ?? '');
  const from = range && kind !== 'plain' ? Number(range[1]) : 0, body = bytes.subarray(from);
  if (browser && kind === 'wrong') body[body.length >> 1] ^= 1;
  reply.writeHead(from > 0 ? 206 : 200, { 'content-length': body.length, ...(from > 0 ? { 'content-range': `bytes ${from}-${bytes.length - 1}/${bytes.length}` } : {}) });
  const cuts = browser && ['cuts', 'plain'].includes(kind) && count === 1;
  if (!cuts) return reply.end(body);
  reply.write(body.subarray(0, body.length >> 1), () => setTimeout(() => reply.destroy(), 50));
});
await new Promise((resolve) => store.listen(0, '127.0.0.1', resolve));
const server = new Server(program, [`http://127.0.0.1:${store.address().port}/test.scene.json`]);
try {
  await server.start();
  const page = await Page.open({ port: server.port, wasm, fields });
  page.post({ type: 'view', position: [0, 0.8, 2.5], axis: [0, -0.2, -0.98], by_distance: false, half_angle_rad: 0.6 });
  await page.until('live', () => page.state === 'live');
  const wanted = () => [...page.objects.values()].filter((one) => !one.hidden);
  await page.until('all kernels', () => wanted().length >= 2 && wanted().every((one) => page.kernels.get(one.id)?.count === one.description.kernel_count));
  const own = page.fetches.filter((path) => /\/assets\/[0-9a-f]{64}$/.test(String(path)) && !forBrowsers.has(String(path).slice(-71)));
  const stored = [...asked].filter(([name]) => forBrowsers.has(name));
  assert.ok(stored.length >= (kind === 'refuses' ? 1 : 2), `asked of the store: ${JSON.stringify([...asked])}`);
  if (['good', 'cuts', 'plain'].includes(kind)) assert.equal(own.length, 0, `asked of the server: ${own}`);
  else assert.ok(own.length >= Math.max(2, stored.length), `asked of the server: ${own}`);
  if (['cuts', 'plain'].includes(kind)) assert.ok(stored.every(([, count]) => count === 2), JSON.stringify(stored));
  console.log(`${kind}: ${stored.length} assets of the store, ${own.length} fetches from the server`);
} finally {
  await server.kill('SIGTERM');
  store.close();
}
process.exit(0);
