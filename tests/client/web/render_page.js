// SPDX-License-Identifier: Apache-2.0
// Draws all views of the reference scene into a window and into an 8-bit target as of a headset.
import { makeEye, Renderer } from '/renderer.js';
import { rotate } from '/vector.js';
import { readScene } from '/test/scene.js';

window.checks = [];

function psnr(mine, theirs) {
  let sum = 0, most = 0, lit = 0;
  for (let i = 0; i < mine.length; ++i) {
    if (i % 4 === 3) continue;
    const d = mine[i] - theirs[i];
    sum += d * d;
    most = Math.max(most, Math.abs(d));
    if (i % 4 === 0 && mine[i] > 40) ++lit;
  }
  const mean = sum / (0.75 * mine.length);
  return { psnr_db: mean > 0 ? 10 * Math.log10((255 * 255) / mean) : 99, most, lit };
}

// Rows of readPixels are from the bottom.
function flipped(pixels, width, height) {
  const rows = new Uint8Array(pixels.length);
  for (let y = 0; y < height; ++y) rows.set(pixels.subarray(4 * width * (height - 1 - y), 4 * width * (height - y)), 4 * width * y);
  return rows;
}

function png(pixels, width, height) {
  const canvas = document.createElement('canvas');
  canvas.width = width;
  canvas.height = height;
  canvas.getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(pixels), width, height), 0, 0);
  return canvas.toDataURL('image/png');
}

async function render() {
  const scene = await readScene('/reference');
  const canvas = document.createElement('canvas');
  const [width, height] = scene.views[0].size;
  canvas.width = width;
  canvas.height = height;
  const gl = canvas.getContext('webgl2', { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true });
  const renderer = new Renderer(gl);
  for (const object of scene.objects) {
    renderer.setKernels(object);
    renderer.objects.get(object.id).environment = object.environment;
    renderer.setDrivers(object.id, object.rows);
  }
  const results = [];
  const layer = renderer.target(gl.RGBA8, width, height, 1);
  for (const [index, view] of scene.views.entries()) {
    const eye = makeEye({ ...view, right: rotate(view.orientation, [1, 0, 0]), down: rotate(view.orientation, [0, -1, 0]), forward: rotate(view.orientation, [0, 0, -1]) });
    renderer.setOrder(view.order, view.order.length, false);
    const pixels = new Uint8Array(4 * width * height);
    const keep = (target) => {
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      const rows = flipped(pixels, width, height);
      results.push({ view: index, target, ...psnr(rows, view.rgba), png: png(rows, width, height) });
    };
    renderer.drawWindow(eye);
    keep('window');
    renderer.setOrder(view.order.slice(), view.order.length, true);
    renderer.prepare([eye]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    renderer.drawEye(0, eye, [0, 0, width, height], new Float32Array(16), []);
    keep('layer');
    renderer.setOrder(view.order, view.order.length, false);
    if (index === 0) {
      // The broken box is left of the middle, the lattice right of it; the floor cannot be touched.
      const at = (m) => {
        const offset = m.map((x, i) => x - view.position[i]);
        const along = (axis) => axis.reduce((sum, x, i) => sum + x * offset[i], 0);
        return [view.centre[0] + (view.focal[0] * along(eye.right)) / along(eye.forward), view.centre[1] + (view.focal[1] * along(eye.down)) / along(eye.forward)];
      };
      const found = [renderer.pick(eye, ...at([-0.6, 0.3, 0.2])), renderer.pick(eye, ...at([0.1, 0.3, 0.3])), renderer.pick(eye, ...at([0.0, 0.0, 1.2])), renderer.pick(eye, 2, 2)];
      window.checks.push({ name: 'pick', value: JSON.stringify(found), good: JSON.stringify(found) === '[12,40,null,null]' });
    }
  }
  window.checks.push({ name: 'gl error', value: gl.getError(), good: gl.getError() === 0 });
  return results;
}

window.rendered = render();
