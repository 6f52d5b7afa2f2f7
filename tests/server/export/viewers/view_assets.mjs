// SPDX-License-Identifier: Apache-2.0
// node view_assets.mjs FOLDER CAMERA.json OURS.png MIN_DB VIEWER:FILE...: draws files of FOLDER (with node_modules) in
// headless Chromium with a viewer of others, spark or playcanvas, and compares each picture with OURS, which livegs drew
// with the same camera. Writes VIEWER.FILE.png; the exit code is 1 if a picture is below MIN_DB.
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const [folder, cameraFile, oursFile, minimum, ...views] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));
const modules = createRequire(path.join(path.resolve(folder), 'package.json'));
const puppeteer = modules('puppeteer-core');
const { PNG } = modules('pngjs');
const ours = PNG.sync.read(fs.readFileSync(oursFile));
const camera = JSON.parse(fs.readFileSync(cameraFile));

const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm' };
const server = http.createServer((request, response) => {
  const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
  const file = [here, folder].map((root) => path.join(root, name)).find((one) => fs.existsSync(one) && fs.statSync(one).isFile());
  if (!file) return void response.writeHead(404).end();
  response.writeHead(200, { 'content-type': types[path.extname(file)] ?? 'application/octet-stream' });
  fs.createReadStream(file).pipe(response);
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));
const browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', headless: true,
  args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', ...(process.getuid() === 0 ? ['--no-sandbox'] : [])] });

// The PSNR of two pictures in dB, and the share of pixels of the first that are not black.
function compare(a, b) {
  let sum = 0, seen = 0;
  for (let i = 0; i < a.data.length; i += 4) {
    let brightest = 0;
    for (let c = 0; c < 3; ++c) {
      sum += (a.data[i + c] - b.data[i + c]) ** 2;
      brightest = Math.max(brightest, a.data[i + c]);
    }
    seen += brightest > 10;
  }
  return { db: 10 * Math.log10(255 * 255 * a.data.length * 0.75 / Math.max(sum, 1)), seen: seen / (a.data.length / 4) };
}

let failed = views.length === 0;
for (const view of views) {
  const [viewer, file] = view.split(':');
  const page = await browser.newPage();
  await page.setViewport({ width: ours.width, height: ours.height });
  const query = new URLSearchParams({ file, eye: camera.position_m, at: camera.look_at_m, fov: camera.vertical_fov_deg,
    width: ours.width, height: ours.height });
  await page.goto(`http://127.0.0.1:${server.address().port}/${viewer}.html?${query}`);
  await page.waitForFunction('window.done', { timeout: 120000 });
  const done = await page.evaluate('window.done');
  const picture = path.join(folder, `${viewer}.${file}.png`);
  await page.screenshot({ path: picture });
  await page.close();
  const { db, seen } = compare(ours, PNG.sync.read(fs.readFileSync(picture)));
  const good = done === 'drawn' && db >= Number(minimum) && seen > 0.01;
  console.log(`${viewer}: ${file}: ${done}; ${db.toFixed(1)} dB of at least ${minimum}, ${(100 * seen).toFixed(1)} % of the picture seen`);
  failed ||= !good;
}
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
