// SPDX-License-Identifier: Apache-2.0
// The page in a window, with the synthetic worker: first picture, orbit, pull with its force, keys, buttons, touch on
// an upright phone, the form for the code, and a lost context.
// Usage: node page_test.mjs REFERENCE_DIRECTORY [OUTPUT_DIRECTORY]
import fs from 'node:fs';
import path from 'node:path';
import { openPage, serve } from './browser.mjs';

const [reference, out = 'out'] = process.argv.slice(2);
fs.mkdirSync(out, { recursive: true });
const here = path.dirname(new URL(import.meta.url).pathname);
const posts = [];
const server = await serve({ '/reference': reference }, { '/worker.js': path.join(here, 'synthetic_worker.js') }, (address, body) => {
  posts.push([address, body]);
  return body === 'good-code' ? [200, 'token-1'] : [401, ''];
});
let failures = 0;
function check(name, good, value) {
  if (!good) ++failures;
  console.log(`${name}: ${typeof value === 'string' ? value : JSON.stringify(value)}${good ? '' : ' FAILED'}`);
}
// Waits for the worker's log: software drawing takes long.
async function until(page, good) {
  for (let i = 0; i < 60; ++i) {
    const log = await logOf(page);
    if (good(log)) return log;
    await pause(150);
  }
  return logOf(page);
}
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const keep = async (page, name) => page.screenshot({ path: path.join(out, name) });
const logOf = (page) => page.evaluate(() => window.livegs.send('Log', {}));
const live = (page) => page.waitForFunction(() => document.getElementById('state').textContent === 'live' && window.livegs.pictures + (window.livegs.fps ?? 0) > 0, { timeout: 60000 });
// Whether the page draws something; reads the canvas through a picture.
const pixelOf = (page, id) => page.evaluate((object) => {
  const { eye, objects } = window.livegs, box = objects.get(object).bounds_m, at = [0, 1, 2].map((i) => 0.5 * (box[i] + box[i + 3]) - eye.position[i]);
  const along = (axis) => axis.reduce((sum, x, i) => sum + x * at[i], 0), ratio = eye.size[1] / innerHeight;
  return [(eye.centre[0] + (eye.focal[0] * along(eye.right)) / along(eye.forward)) / ratio, (eye.centre[1] + (eye.focal[1] * along(eye.down)) / along(eye.forward)) / ratio];
}, id);

{
  const { browser, page, errors } = await openPage(`${server.origin}/`, { width: 720, height: 480 });
  await live(page);
  await pause(500);
  await keep(page, 'page_first.png');
  const first = await page.evaluate(() => window.livegs.camera.position);
  check('camera sees the scene', first[2] > 1 && first[1] > 0, first);
  await page.mouse.move(330, 440);
  await page.mouse.down();
  await page.mouse.move(380, 450, { steps: 4 });
  await page.mouse.up();
  await pause(300);
  const turned = await page.evaluate(() => [window.livegs.camera.azimuth, window.livegs.camera.elevation]);
  check('drag of the background orbits', Math.abs(turned[0]) > 0.1, turned);
  const at = await pixelOf(page, 12);
  await page.mouse.move(...at);
  await page.mouse.down();
  await page.mouse.move(at[0] + 20, at[1] - 60, { steps: 3 });
  const pulled = await until(page, (log) => log.right?.trigger === 1 && log.lifted > 0.05);
  await pause(500);
  const azimuth = await page.evaluate(() => window.livegs.camera.azimuth);
  check('drag of an object pulls it', pulled.right?.trigger === 1 && azimuth === turned[0] && pulled.lifted > 0, [at, pulled.right?.trigger, pulled.lifted]);
  check('force is shown', /broken box: 6\.32 N/.test(await page.$eval('#force', (e) => e.textContent)), await page.$eval('#force', (e) => e.textContent));
  check('picked object is chosen', await page.$eval('#objects li[data-chosen] summary', (e) => e.textContent.startsWith('broken box')).catch(() => false), 'broken box');
  await keep(page, 'page_pull.png');
  await page.mouse.up();
  check('release', (await until(page, (log) => log.right?.trigger === 0)).right?.trigger === 0, 'trigger 0');
  await page.mouse.move(...(await pixelOf(page, 12)).map((x, i) => x - 40 * i));
  await page.mouse.down();
  await until(page, (log) => log.right?.trigger === 1);
  const away = await page.evaluate(async () => {
    window.dispatchEvent(new Event('blur'));
    return (await window.livegs.send('Log', {})).right;
  });
  check('a page without focus lets go at once', away === null, away);
  await page.mouse.up();
  const before = await page.evaluate(() => window.livegs.camera.target);
  await page.keyboard.down('w');
  await pause(500);
  await page.keyboard.up('w');
  await page.keyboard.press(' ');
  await until(page, (log) => log.shots > 0);
  check('W flies', JSON.stringify(before) !== JSON.stringify(await page.evaluate(() => window.livegs.camera.target)), before);
  check('space shoots once', (await logOf(page)).shots === 1, (await logOf(page)).shots);
  await page.click('#pause');
  await pause(400);
  check('pause', (await logOf(page)).paused && (await page.$eval('#pause', (e) => e.textContent)) === 'Continue', await page.$eval('#pause', (e) => e.textContent));
  await page.keyboard.press('p');
  await page.click('#undo');
  await page.click('#objects summary');
  const analyse = await page.$$('#objects li button');
  await page.evaluate(() => document.querySelectorAll('#objects details').forEach((one) => { one.open = true; }));
  await analyse[0].click();
  await pause(400);
  const log = await logOf(page);
  check('calls', ['GetScene', 'ControlRun', 'UndoEdit', 'AnalyzeObject'].every((name) => log.calls.includes(name)) && !log.paused, log.calls);
  check('values and reasons', (await page.$eval('#objects', (e) => e.textContent)).includes('asked the model'), 'reason shown');
  check('orders come back', log.done >= log.orders - 3, [log.orders, log.done]);
  await pause(1500);
  check('no arrow after the release', await page.$eval('#overlay', (e) => e.hidden), 'overlay hidden');
  await keep(page, 'page_values.png');
  const lost = await page.evaluate(async () => {
    const extension = document.getElementById('picture').getContext('webgl2').getExtension('WEBGL_lose_context');
    extension.loseContext();
    await new Promise((done) => setTimeout(done, 300));
    const state = document.getElementById('state').textContent;
    extension.restoreContext();
    await new Promise((done) => setTimeout(done, 2500));
    return [state, document.getElementById('state').textContent, window.livegs.renderer.count];
  });
  check('lost context comes back', lost[0] === 'connection lost' && lost[1] === 'live' && lost[2] > 0, lost);
  await keep(page, 'page_restored.png');
  check('console', errors.length === 0, errors);
  await browser.close();
}
{
  const { browser, page, errors } = await openPage(`${server.origin}/#pair=good-code`, { width: 390, height: 844, touch: true });
  await live(page);
  await pause(500);
  check('code in the link', posts.some(([address, body]) => address === '/pair' && body === 'good-code') && !page.url().includes('pair') && (await page.evaluate(() => localStorage.getItem('livegs-token'))) === 'token-1', page.url());
  await keep(page, 'page_phone.png');
  const touch = await page.target().createCDPSession();
  const points = (type, ...touchPoints) => touch.send('Input.dispatchTouchEvent', { type, touchPoints: touchPoints.map(([x, y], id) => ({ x, y, id })) });
  const camera = () => page.evaluate(() => [window.livegs.camera.azimuth, window.livegs.camera.distance_m]);
  const before = await camera();
  await points('touchStart', [150, 500]);
  await points('touchMove', [200, 520]);
  await points('touchEnd');
  const turned = await camera();
  check('one finger orbits', turned[0] !== before[0], turned);
  await points('touchStart', [150, 400], [240, 400]);
  await points('touchMove', [120, 400], [270, 400]);
  await points('touchEnd');
  check('two fingers zoom', (await camera())[1] < turned[1], await camera());
  const at = await pixelOf(page, 12);
  await points('touchStart', at);
  await pause(600);
  await points('touchMove', [at[0], at[1] - 40]);
  await until(page, (log) => log.lifted > 0.05);
  await pause(500);
  check('long press pulls', (await logOf(page)).right?.trigger === 1, (await logOf(page)).right?.trigger);
  await keep(page, 'page_phone_pull.png');
  await points('touchEnd');
  check('lifted finger lets go', (await until(page, (log) => log.right?.trigger === 0)).right?.trigger === 0, 'trigger 0');
  await page.tap('#fold');
  await pause(200);
  await keep(page, 'page_phone_panel.png');
  check('nothing wider than the phone', await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth && document.getElementById('panels').getBoundingClientRect().right <= innerWidth), 'width');
  check('console', errors.length === 0, errors);
  await browser.close();
}
{
  const { browser, page, errors } = await openPage(`${server.origin}/`, { before: () => localStorage.setItem('livegs-token', 'wrong') });
  await page.waitForSelector('#pair:not([hidden])');
  await page.type('#code', 'bad-code');
  await page.click('#pair button');
  await page.waitForFunction(() => document.getElementById('pair_reason').textContent.includes('wrong'));
  await keep(page, 'page_code.png');
  await page.$eval('#code', (e) => { e.value = ''; });
  await page.type('#code', 'good-code');
  await page.click('#pair button');
  await live(page);
  check('code of the form', await page.$eval('#pair', (e) => e.hidden), 'live');
  check('console', errors.filter((one) => !one.includes('401')).length === 0, errors);
  await browser.close();
}
server.close();
process.exit(failures > 0 ? 1 : 0);
