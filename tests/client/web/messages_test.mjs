// SPDX-License-Identifier: Apache-2.0
// messages_test.mjs FIELDS PROTO_FOLDER: the codec against protoc, and against damaged bytes.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const [fields, protos] = process.argv.slice(2), folder = mkdtempSync(join(tmpdir(), 'livegs_messages_'));
cpSync(fileURLToPath(new URL('../../../client/web/page/messages.js', import.meta.url)), join(folder, 'messages.js'));
cpSync(fields, join(folder, 'fields.js'));
writeFileSync(join(folder, 'package.json'), '{"type": "module"}');
const { decode, encode } = await import(pathToFileURL(join(folder, 'messages.js')));
const protoc = (how, name, input) => execFileSync('protoc', [`--${how}=livegs.v1.${name}`, '-I', protos, 'livegs/v1/session.proto'], { input });

const text = `tick: 9007199254740991 stepped_ns: -5 sent_ns: 123456789012345 step_ms: 1.5
events { object_added { object_id: 7 name: "Tässchen" asset_hash: "ab" rest_body: "\\000\\377" mass_kg: 0.25 hidden: true warnings: "a" warnings: "b" } }
events { draining: "" } events { object_removed { object_id: 4000000000 } }
hands { hand: 1 point_m: [0.5, -2, 3] grabbed: true contact_impulse_n_s: 0.75 } run { paused: true simulated_s: 1e-3 edit_revision: 18446744073709 } frame: "\\326\\002"`;
const message = decode('ServerMessage', new Uint8Array(protoc('encode', 'ServerMessage', text)));
assert.equal(message.tick, 9007199254740991);
assert.equal(message.stepped_ns, -5);
assert.equal(message.events.length, 3);
assert.deepEqual({ ...message.events[0].object_added, rest_body: [...message.events[0].object_added.rest_body] }.rest_body, [0, 255]);
assert.equal(message.events[0].object_added.name, 'Tässchen');
assert.deepEqual(message.events[0].object_added.warnings, ['a', 'b']);
assert.equal(message.events[0].object_added.environment, false); // a default
assert.equal(message.events[0].object_added.physics, undefined);
assert.equal(message.events[1].draining, ''); // present, although it is the default
assert.equal(message.events[1].object_removed, undefined);
assert.equal(message.events[2].object_removed.object_id, 4000000000);
assert.deepEqual(message.hands[0].point_m, [0.5, -2, 3]);
assert.deepEqual(message.hands[0].force_n, []);
assert.equal(message.run.edit_revision, 18446744073709);
assert.deepEqual(decode('ServerMessage', encode('ServerMessage', message)), message);

const client = { session_id: 'ä', acknowledged_tick: 4294967297, sent_ns: -1, key_frame_wanted: true, view: { position_m: [1, 2, 3], forward: [0, 0, -1], half_angle_rad: 0.5 },
  inputs: [{ sequence: 3, sampled_ns: 9e15, right: { aim_position_m: [1, 0, 0], trigger: 0.5, shoot: true }, left: null }] };
const decoded = String(protoc('decode', 'ClientMessage', encode('ClientMessage', client))).replace(/\s+/g, ' ');
for (const part of ['acknowledged_tick: 4294967297', 'sent_ns: -1', 'key_frame_wanted: true', 'position_m: 1 position_m: 2 position_m: 3', 'sampled_ns: 9000000000000000', 'trigger: 0.5', 'shoot: true'])
  assert.ok(decoded.includes(part), `${part} in ${decoded}`);
assert.ok(!decoded.includes('left'));
assert.ok(String(protoc('decode', 'ControlRunRequest', encode('ControlRunRequest', { pause: false }))).includes('pause: false'));

const bytes = encode('ServerMessage', message);
let refused = 0, state = 12345;
const random = (n) => { state = (Math.imul(state, 1103515245) + 12345) >>> 0; return (state >>> 8) % n; };
for (let i = 0; i < 20000; ++i) {
  const damaged = bytes.slice(0, random(3) ? bytes.length : random(bytes.length));
  for (let n = random(4); n >= 0 && damaged.length; --n) damaged[random(damaged.length)] ^= 1 << random(8);
  try {
    decode('ServerMessage', damaged);
  } catch (error) {
    assert.ok(error instanceof RangeError, error.stack);
    ++refused;
  }
}
console.log(JSON.stringify({ damaged: 20000, refused }));
