// SPDX-License-Identifier: Apache-2.0
// node --experimental-websocket moving_test.mjs SERVER WASM FIELDS: the worker at a server of a fleet that shuts down and
// names the next one. The fleet's sidecar is a server in this process.
import assert from 'node:assert/strict';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Page, Server } from './worker_host.mjs';

const [program, wasm, fields] = process.argv.slice(2), kNext = '10.0.0.8:7777';
const calls = [];
const sidecar = createServer((request, reply) => {
  calls.push(`${request.method} ${request.url}`);
  const server = { object_meta: { name: 'room', annotations: { 'livegs.io/next-address': kNext } }, status: { state: 'Ready' } };
  reply.end(JSON.stringify(request.url === '/gameserver' ? server : {}));
});
await new Promise((resolve) => sidecar.listen(0, '127.0.0.1', resolve));
process.env.AGONES_SDK_HTTP_PORT = sidecar.address().port;
const file = join(mkdtempSync(join(tmpdir(), 'livegs_scene_')), 'test.scene.json');
writeFileSync(file, JSON.stringify({ environment: { colliders: [{ plane: {} }] },
  objects: [{ name: 'box', shape: { box: { size_m: [0.2, 0.2, 0.2] } }, pose: { position_m: [0, 0.1, 0] }, physics: { behavior: 'RIGID', mass_kg: 1 } }] }));
const server = new Server(program, ['--fleet', 'agones', file]);
try {
  const page = await Page.open({ port: await server.start(), wasm, fields });
  await page.until('live', () => page.state === 'live');
  await server.kill('SIGTERM');
  await page.until('moved', () => page.moved);
  assert.deepEqual(page.moved, { type: 'moved', address: kNext, token: '' });
  const { message } = page.states.at(-1);
  assert.ok(message.startsWith('server is shutting down: ') && message.endsWith(`; continuing at ${kNext}`), message);
  assert.equal(calls.at(-1), 'POST /shutdown');
  assert.deepEqual(page.faults, []);
  process.exit(0);
} catch (error) {
  console.error(error, server.log?.slice(-2000), calls);
  server.child?.kill('SIGKILL');
  process.exit(1);
}
