// SPDX-License-Identifier: Apache-2.0
// Headless Chromium and a small file server for the checks of the browser client. The page is served with the
// Content-Security-Policy of the real server; test pages are under /test.
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import puppeteer from 'puppeteer-core';

const here = path.dirname(fileURLToPath(import.meta.url));
const pageFolder = path.join(here, '../../../client/web/page');
// Generated files of the page, of a build.
const generatedFolder = process.env.LIVEGS_WEB_FILES ?? path.join(here, '../../../build/release/client/web');
const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.json': 'application/json',
  '.bin': 'application/octet-stream', '.png': 'image/png' };
export const kPolicy = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; img-src 'self' data:; style-src 'self'; worker-src 'self'";

// Serves the page's folder, this folder under /test, and other folders or files by their address. `replaced` maps
// an address of the page to a file. `post` answers POST requests.
export async function serve(folders = {}, replaced = {}, post = null) {
  const mounted = Object.entries({ '/test': here, ...folders });
  const server = http.createServer((request, response) => {
    const address = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    if (request.method === 'POST') {
      const chunks = [];
      request.on('data', (chunk) => chunks.push(chunk));
      request.on('end', () => {
        const [status, body] = post ? post(address, Buffer.concat(chunks).toString()) : [404, ''];
        response.writeHead(status);
        response.end(body);
      });
      return;
    }
    const mount = mounted.find(([prefix]) => address.startsWith(`${prefix}/`));
    const file = replaced[address] ?? (mount ? path.join(mount[1], address.slice(mount[0].length)) : pageFile(address));
    if (!fs.existsSync(file) || !fs.statSync(file).isFile()) {
      response.writeHead(404);
      response.end();
      return;
    }
    const headers = { 'content-type': types[path.extname(file)] ?? 'application/octet-stream', 'cache-control': 'no-store' };
    if (!address.startsWith('/test')) headers['content-security-policy'] = kPolicy;
    response.writeHead(200, headers);
    fs.createReadStream(file).pipe(response);
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  return { origin: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

function pageFile(address) {
  const file = path.join(pageFolder, address === '/' ? 'index.html' : address);
  return fs.existsSync(file) ? file : path.join(generatedFolder, address);
}

export async function openPage(address, { width = 960, height = 720, touch = false, before = null } = {}) {
  const browser = await puppeteer.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', headless: true, protocolTimeout: 300000,
    args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', ...(process.getuid() === 0 ? ['--no-sandbox'] : [])] });
  const page = await browser.newPage();
  await page.setViewport({ width, height, hasTouch: touch, isMobile: touch });
  const errors = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error') errors.push(`${message.text()} ${message.location()?.url ?? ''}`);
  });
  if (before) await page.evaluateOnNewDocument(before);
  await page.goto(address);
  return { browser, page, errors };
}
