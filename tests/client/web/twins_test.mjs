// SPDX-License-Identifier: Apache-2.0
// The page's shader text of limit_deformation.glsl is that of the native client, apart from comments, `precise` and
// local `const`; and the constants of the projection are those of project_splats_layout.h.
// Usage: node twins_test.mjs
import fs from 'node:fs';
import path from 'node:path';
import { limitDeformation, projectFragment } from '../../../client/web/page/shaders.js';

const root = path.join(path.dirname(new URL(import.meta.url).pathname), '../../..');
const plain = (text) => text.replace(/\/\/.*/g, '').replace(/\bprecise /g, '').replace(/^( {2,})const /gm, '$1').replace(/\s+/g, ' ').trim();
let failed = false;
function check(name, good) {
  failed ||= !good;
  console.log(`${name}: ${good ? 'same' : 'differs FAILED'}`);
}
check('limit_deformation.glsl', plain(fs.readFileSync(path.join(root, 'common/skin/kernels/limit_deformation.glsl'), 'utf8')) === plain(limitDeformation));
const layout = fs.readFileSync(path.join(root, 'common/splat/passes/project_splats_layout.h'), 'utf8');
for (const name of ['kCulled_log2', 'kSplatLowPass_px2', 'kSplatLog2Of255', 'kLog2OfTwoPi']) {
  const value = (text) => text.match(new RegExp(`const float ${name} = ([^;]+);`))?.[1];
  check(name, value(layout) !== undefined && value(layout) === value(projectFragment));
}
process.exit(failed ? 1 : 0);
