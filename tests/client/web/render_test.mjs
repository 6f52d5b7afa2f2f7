// SPDX-License-Identifier: Apache-2.0
// Renders the scene of reference_picture in headless Chromium and compares each picture with the CPU rasteriser's.
// Usage: node render_test.mjs REFERENCE_DIRECTORY [OUTPUT_DIRECTORY]
// A window (16-bit floats) must reach 50 dB, a headset's 8-bit layer 45 dB.
import fs from 'node:fs';
import path from 'node:path';
import { openPage, serve } from './browser.mjs';

const [reference, out = 'out'] = process.argv.slice(2);
fs.mkdirSync(out, { recursive: true });
const server = await serve({ '/reference': reference });
const { browser, page, errors } = await openPage(`${server.origin}/test/render.html`);
let failed = false;
try {
  const results = await page.evaluate(() => window.rendered);
  for (const result of results) {
    const least = result.target === 'window' ? 50 : 45;
    const good = result.psnr_db >= least && result.lit > 500;
    failed ||= !good;
    console.log(`view ${result.view} ${result.target}: ${result.psnr_db.toFixed(1)} dB, most ${result.most}/255, ${result.lit} lit${good ? '' : ' FAILED'}`);
    fs.writeFileSync(path.join(out, `view_${result.view}_${result.target}.png`), Buffer.from(result.png.split(',')[1], 'base64'));
  }
  for (const check of await page.evaluate(() => window.checks)) {
    failed ||= !check.good;
    console.log(`${check.name}: ${check.value}${check.good ? '' : ' FAILED'}`);
  }
  if (results.length === 0) failed = true;
} catch (error) {
  failed = true;
  console.log(String(error));
}
for (const error of errors) console.log(`console: ${error}`);
await browser.close();
server.close();
process.exit(failed || errors.length > 0 ? 1 : 0);
