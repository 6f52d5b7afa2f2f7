// SPDX-License-Identifier: Apache-2.0
// The page in a headset, emulated by IWER: enter, both eyes, parallax, pull by ray, grip, shot, haptics, hands, hidden,
// recentred, a stalled session, and ten sessions one after the other.
// Usage: node xr_test.mjs REFERENCE_DIRECTORY [OUTPUT_DIRECTORY]
import fs from 'node:fs';
import path from 'node:path';
import { openPage, serve } from './browser.mjs';

const [reference, out = 'out'] = process.argv.slice(2);
fs.mkdirSync(out, { recursive: true });
const here = path.dirname(new URL(import.meta.url).pathname);
const iwer = fs.readFileSync(path.join(here, 'node_modules/iwer/build/iwer.min.js'), 'utf8');
const before = `${iwer}
window.headset = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true });
window.headset.installRuntime({ forceInstall: true });
window.pulses = 0;`;
const server = await serve({ '/reference': reference }, { '/worker.js': path.join(here, 'synthetic_worker.js') });
let failures = 0;
function check(name, good, value) {
  if (!good) ++failures;
  console.log(`${name}: ${typeof value === 'string' ? value : JSON.stringify(value)}${good ? '' : ' FAILED'}`);
}
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const { browser, page, errors } = await openPage(`${server.origin}/`, { width: 480, height: 240, before });
const log = () => page.evaluate(() => window.livegs.send('Log', {}));
const counts = () => page.evaluate(() => window.livegs.headset.counts);
async function until(good) {
  for (let i = 0; i < 80; ++i) {
    const now = await log();
    if (good(now)) return now;
    await pause(150);
  }
  return log();
}
const inSession = (wanted) => page.waitForFunction((is) => Boolean(window.livegs.headset.session) === is, { timeout: 20000 }, wanted);
const frames = async (count) => {
  const from = (await counts()).frames;
  await page.waitForFunction((least) => window.livegs.headset.counts.frames >= least, { timeout: 60000 }, from + count);
};

await page.waitForFunction(() => document.getElementById('state').textContent === 'live', { timeout: 60000 });
await page.waitForSelector('#enter:not([hidden])');
await page.evaluate(() => { window.livegs.camera.azimuth = 0.7; window.headset.quaternion.set(0.1, 0.3, 0.05, 0.94); });
await page.click('#enter');
await inSession(true);
await frames(3);
check('view sorts by distance', (await until((now) => now.view?.by_distance)).view.by_distance, 'by distance');
await pause(1500);
await frames(3);
// The layer under IWER is the page's canvas, one half an eye. Frames come from the page, so the picture is read in one.
const readEyes = () => page.evaluate(() => new Promise((done) => {
  const canvas = document.getElementById('picture'), gl = canvas.getContext('webgl2'), headset = window.livegs.headset, renderer = window.livegs.renderer;
  const draw = renderer.drawEye, plates = renderer.drawPlates;
  let eyes = [];
  renderer.drawEye = function (index, eye, viewport, ...more) {
    draw.call(this, index, eye, viewport, ...more);
    const clip = [...more[0]];
    eyes.push({ position: eye.position, right: eye.right, down: eye.down, forward: eye.forward, focal: eye.focal, centre: eye.centre, viewport, clip });
  };
  renderer.drawPlates = function (...all) {
    plates.apply(this, all);
    if (eyes.length < 2) return;
    Object.assign(renderer, { drawEye: draw, drawPlates: plates });
    gl.disable(gl.SCISSOR_TEST);
    const pixels = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const rows = new Uint8ClampedArray(pixels.length);
    for (let y = 0; y < canvas.height; ++y) rows.set(pixels.subarray(4 * canvas.width * (canvas.height - 1 - y), 4 * canvas.width * (canvas.height - y)), 4 * canvas.width * y);
    const copy = document.createElement('canvas');
    copy.width = canvas.width;
    copy.height = canvas.height;
    copy.getContext('2d').putImageData(new ImageData(rows, canvas.width, canvas.height), 0, 0);
    let lit = 0, opaque = 0;
    for (let i = 0; i < rows.length; i += 4) {
      lit += rows[i] > 40 ? 1 : 0;
      opaque += rows[i + 3] === 255 ? 1 : 0;
    }
    done({ eyes, lit, opaque, total: canvas.width * canvas.height, png: copy.toDataURL('image/png'), farthestFirst: renderer.farthestFirst, frames: headset.counts.frames });
  };
}));
const keepEyes = async (name) => {
  const picture = await readEyes();
  fs.writeFileSync(path.join(out, name), Buffer.from(picture.png.split(',')[1], 'base64'));
  return picture;
};
const picture = await keepEyes('xr_eyes.png');
const [left, right] = picture.eyes;
const apart = Math.hypot(...left.position.map((x, i) => x - right.position[i]));
check('two eyes', picture.eyes.length === 2 && Math.abs(apart - 0.063) < 0.002 && left.viewport[0] !== right.viewport[0], [apart, left.viewport, right.viewport]);
check('lit pixels', picture.lit > 2000 && picture.opaque === picture.total, [picture.lit, picture.opaque, picture.total]);
check('farthest first in 8 bits', picture.farthestFirst, picture.farthestFirst);
// Pixels of points by the matrices of WebXR and by the eyes that the splats are projected with.
let worst_px = 0, shift_px = 0;
for (const point of [[0.1, 0.35, 0.1], [-0.6, 0.3, 0], [0.7, 0.25, -0.2], [0, 0, 1]]) {
  const at = [left, right].map((eye) => {
    const clip = [0, 1, 3].map((row) => point.reduce((sum, x, i) => sum + x * eye.clip[4 * i + row], eye.clip[12 + row]));
    const size = [eye.viewport[2], eye.viewport[3]], byMatrix = [0.5 * size[0] * (1 + clip[0] / clip[2]), 0.5 * size[1] * (1 - clip[1] / clip[2])];
    const offset = point.map((x, i) => x - eye.position[i]), along = (axis) => axis.reduce((sum, x, i) => sum + x * offset[i], 0);
    const byEye = [eye.centre[0] + (eye.focal[0] * along(eye.right)) / along(eye.forward), eye.centre[1] + (eye.focal[1] * along(eye.down)) / along(eye.forward)];
    worst_px = Math.max(worst_px, Math.abs(byMatrix[0] - byEye[0]), Math.abs(byMatrix[1] - byEye[1]));
    return byEye;
  });
  shift_px = Math.max(shift_px, Math.abs(at[0][0] - at[1][0]));
}
check('parallax of WebXR', worst_px < 0.05 && shift_px > 0.5, [worst_px, shift_px]);
const place = await page.evaluate(() => ({ camera: window.livegs.camera.position }));
const middle = left.position.map((x, i) => 0.5 * (x + right.position[i]));
check('user stands where the camera was', Math.hypot(...middle.map((x, i) => x - place.camera[i])) < 0.05, [middle, place.camera]);

// Controllers.
await page.evaluate(() => {
  for (const source of window.livegs.headset.session.inputSources) {
    const actuator = source.gamepad?.hapticActuators?.[0];
    if (!actuator) continue;
    const pulse = actuator.pulse.bind(actuator);
    actuator.pulse = (value, ms) => { ++window.pulses; return pulse(value, ms); };
  }
  window.headset.controllers.right.updateButtonValue('trigger', 1);
});
const pulled = await until((now) => now.right?.trigger > 0.5 && now.lifted > 0.05);
check('trigger pulls by ray', pulled.right?.trigger > 0.5 && pulled.lifted > 0.05 && pulled.left !== null, [pulled.right?.trigger, pulled.lifted]);
await frames(2);
await keepEyes('xr_pull.png');
check('haptic pulse of the take', (await page.evaluate(() => window.pulses)) >= 1, await page.evaluate(() => window.pulses));
await page.evaluate(() => {
  window.headset.controllers.right.updateButtonValue('trigger', 0);
  window.headset.controllers.left.updateButtonValue('squeeze', 1);
});
const gripped = await until((now) => now.left?.squeeze > 0.5);
check('squeeze grips', gripped.left?.squeeze > 0.5 && gripped.right?.trigger === 0, [gripped.left?.squeeze]);
await page.evaluate(() => window.headset.controllers.right.updateButtonValue('a-button', 1));
const shot = await until((now) => now.shots > 0);
check('A shoots', shot.shots === 1, shot.shots);
await page.evaluate(() => {
  window.headset.controllers.right.updateButtonValue('a-button', 0);
  window.headset.controllers.left.updateButtonValue('squeeze', 0);
  window.headset.controllers.right.updateButtonValue('trigger', 1);
});
await until((now) => now.right?.trigger > 0.5);
await page.evaluate(() => window.headset.updateVisibilityState('hidden'));
const hidden = await until((now) => now.right === null);
check('hidden session lets go', hidden.right === null && hidden.left === null, 'no hands');
await page.evaluate(() => {
  window.headset.controllers.right.updateButtonValue('trigger', 0);
  window.headset.updateVisibilityState('visible');
});
await frames(2);
check('shown again', (await until((now) => now.right !== null)).right !== null, 'hands');
await page.evaluate(() => {
  window.headset.position.set(0.4, 1.6, 0.3);
  window.headset.recenter();
});
await frames(3);
const recentred = await counts();
check('recentre', recentred.recentred === 1, recentred);

// Hands: a pinch is the trigger.
await page.evaluate(() => { window.headset.primaryInputMode = 'hand'; });
await frames(2);
await page.evaluate(() => window.headset.hands.right.updatePinchValue(1));
const pinched = await until((now) => now.right?.trigger > 0.5);
check('pinch is the trigger', pinched.right?.trigger > 0.5, pinched.right?.trigger);
await page.evaluate(() => { window.headset.hands.right.updatePinchValue(0); window.headset.primaryInputMode = 'controller'; });

for (let i = 0; i < 10; ++i) {
  await page.evaluate(() => window.livegs.headset.leave());
  await inSession(false);
  if (i === 0) check('end lets go', (await until((now) => now.right === null)).right === null, 'no hands');
  await page.click('#enter');
  await inSession(true).catch(async (error) => { console.log(await page.$eval('#run', (e) => e.textContent), await page.$eval('#enter', (e) => e.textContent)); throw error; });
  await frames(1);
}
check('entered again ten times', (await counts()).sessions === 11, await counts());
// A session that asks for no pictures any more.
await page.evaluate(() => { window.livegs.headset.frame = () => {}; });
await page.waitForFunction(() => !window.livegs.headset.session, { timeout: 15000 }).catch(() => {});
check('watchdog ends a stalled session', await page.evaluate(() => !window.livegs.headset.session), await page.$eval('#run', (e) => e.textContent));
await page.waitForFunction(() => window.livegs.pictures + window.livegs.fps > 0, { timeout: 20000 }).catch(() => {});
check('window draws again', (await page.evaluate(() => window.livegs.pictures + window.livegs.fps)) > 0, 'pictures');
check('console', errors.length === 0, errors);
await browser.close();
server.close();
process.exit(failures > 0 ? 1 : 0);
