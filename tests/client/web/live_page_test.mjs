// SPDX-License-Identifier: Apache-2.0
// live_page_test.mjs SERVER WASM FIELDS SCENE [PICTURE.png]: the page in Chromium against a server, through a proxy that
// serves the page of this folder: first picture, a moving scene, bytes on the way, no error in the console.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import net from 'node:net';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { kPolicy, openPage } from './browser.mjs';
import { Server, sleep } from './worker_host.mjs';

const [program, wasm, fields, scene, picture] = process.argv.slice(2);
const folder = fileURLToPath(new URL('../../../client/web/page', import.meta.url));
const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
const server = new Server(program, [scene]);
await server.start();

const upstream = (request) => ({ host: '127.0.0.1', port: server.port, path: request.url, method: request.method, headers: request.headers });
const proxy = http.createServer((request, reply) => {
  const address = new URL(request.url, 'http://localhost').pathname, name = address === '/' ? 'index.html' : address.slice(1);
  const file = { 'livegs.wasm': wasm, 'fields.js': fields }[name] ?? path.join(folder, name);
  if (request.method === 'GET' && fs.existsSync(file)) {
    reply.writeHead(200, { 'content-type': types[path.extname(file)] ?? 'application/octet-stream', 'content-security-policy': kPolicy });
    return void fs.createReadStream(file).pipe(reply);
  }
  const asked = http.request(upstream(request), (answer) => {
    reply.writeHead(answer.statusCode, answer.headers);
    answer.pipe(reply);
  });
  asked.on('error', () => reply.destroy());
  request.pipe(asked);
});
proxy.on('upgrade', (request, socket, head) => {
  const through = net.connect(server.port, '127.0.0.1', () => {
    through.write(`${request.method} ${request.url} HTTP/1.1\r\n${request.rawHeaders.reduce((text, part, i) => text + part + (i % 2 ? '\r\n' : ': '), '')}\r\n`);
    through.write(head);
    socket.pipe(through).pipe(socket);
  });
  for (const one of [socket, through]) one.on('error', () => { socket.destroy(); through.destroy(); });
});
await new Promise((done) => proxy.listen(0, '127.0.0.1', done));

let browser = null;
try {
  const opened = await openPage(`http://127.0.0.1:${proxy.address().port}/`, { width: 480, height: 360 });
  browser = opened.browser;
  const { page, errors } = opened;
  await page.waitForFunction(() => window.livegs?.state === 'live' && window.livegs.pictures >= 0 && window.livegs.renderer?.count > 0, { timeout: 60000 });
  await sleep(3000);
  const seen = await page.evaluate(() => ({ kernels: window.livegs.renderer.count, objects: window.livegs.objects.size, tick: window.livegs.run.simulated_s, state: window.livegs.state,
    first_ms: performance.getEntriesByName('first-contentful-paint')[0]?.startTime }));
  await sleep(1000);
  assert.ok((await page.evaluate(() => window.livegs.run.simulated_s)) > seen.tick, 'the simulation does not go on');
  if (picture) await page.screenshot({ path: picture });
  assert.deepEqual(errors.filter((text) => !/favicon/.test(text)), []);
  console.log(JSON.stringify(seen));
} catch (error) {
  console.error(error, server.log?.slice(-1500));
  process.exitCode = 1;
}
await browser?.close();
await server.kill('SIGTERM');
proxy.close();
process.exit();
