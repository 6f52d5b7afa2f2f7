// SPDX-License-Identifier: Apache-2.0
// core_test.mjs WASM TRACE [NATIVE_TIMES_JSON]: replays a trace of core_trace in the WebAssembly module and compares all
// results to the bit; prints the least times of both, ms. Then, without a trace: core_test.mjs WASM --mutate TRACE COUNT
// feeds mutated frames, assets and rest bodies, none of which may trap.
import { readFileSync } from 'node:fs';
import { Core } from '../../../client/web/page/core.js';

const kinds = { asset: 1, describe: 2, frame: 3, view: 4, play: 5, drivers: 6, kernels: 7, order: 8 };

function* recordsOf(file) {
  const bytes = readFileSync(file);
  for (let at = 0; at < bytes.length;) {
    const kind = bytes.readUInt32LE(at), size = bytes.readUInt32LE(at + 4);
    const part = new Uint8Array(bytes.subarray(at + 8, at + 8 + size));
    yield { kind, bytes: part, words: size % 4 === 0 ? new Uint32Array(part.buffer) : null, view: new DataView(part.buffer) };
    at += 8 + size + ((4 - (size % 4)) % 4);
  }
}

function same(what, found, expected) {
  if (found.length !== expected.length) throw new Error(`${what}: ${found.length} words, natively ${expected.length}`);
  for (let i = 0; i < found.length; ++i) if (found[i] !== expected[i]) throw new Error(`${what}: word ${i} differs: ${found[i]}, natively ${expected[i]}`);
}

const times = { decode_ms: Infinity, play_ms: Infinity, keys_ms: Infinity, sort_ms: Infinity }; // the quickest frame
function timed(name, step) {
  const begun = performance.now(), result = step();
  times[name] = Math.min(times[name], performance.now() - begun);
  return result;
}

// Binds all that is due, as binder.js and worker.js do; kernels by the number of their description.
async function bindArrived(core, kernels) {
  for (let answer = core.call.bind_next(); answer !== 0; answer = core.call.bind_next()) {
    if (answer === 2) {
      core.call.bind_failed(core.bound().description);
      throw new Error(core.error());
    }
    const bound = core.bound();
    if (await core.takeBound(bound)) kernels.set(bound.description, bound.kernels);
  }
}

async function feed(core, { kind, bytes, view }, kernels) {
  if (kind === kinds.asset) {
    const number = view.getUint32(0, true), size = 65536;
    for (let at = 4; at < bytes.length; at += size) {
      core.take('take_asset', [number], bytes.subarray(at, at + size));
      await bindArrived(core, kernels);
    }
    core.call.finish_asset(number);
    await bindArrived(core, kernels);
  } else if (kind === kinds.describe) {
    const [description, id, added, environment, hidden, asset] = [0, 4, 8, 12, 16, 20].map((at) => view.getUint32(at, true));
    if (core.take('describe_object', [description, id, added, environment, hidden], bytes.subarray(24))) core.take('bind_object', [description, asset], bytes.subarray(24));
    await bindArrived(core, kernels);
  } else if (kind === kinds.frame) {
    timed('decode_ms', () => core.take('take_frame', [], bytes.subarray(16), [view.getFloat64(0, true), view.getFloat64(8, true), 0]));
  } else if (kind === kinds.view) {
    core.call.set_view(...[0, 4, 8, 12, 16, 20].map((at) => view.getFloat32(at, true)), view.getUint32(24, true));
  }
}

async function compare(wasm, trace) {
  const core = await Core.load(wasm), kernels = new Map(), counts = { frames: 0, words: 0, kernels: 0 };
  core.call.begin_stream(60);
  for (const record of recordsOf(trace)) {
    const { kind, words, view } = record;
    await feed(core, record, kernels);
    if (kind === kinds.play) {
      const changed = timed('play_ms', () => core.call.play(view.getFloat64(0, true)));
      same('change and drawn objects', [changed, ...core.drawn()], words.slice(2));
      ++counts.frames;
    } else if (kind === kinds.drivers) {
      const { rows } = core.object(words[0]);
      same(`driver rows of object ${words[0]}`, new Uint32Array(rows.buffer, rows.byteOffset, rows.length), words.slice(1));
    } else if (kind === kinds.kernels) {
      const object = core.object(words[0]), cells = object.cells?.slice() ?? [], found = kernels.get(object.description);
      same(`kernels of object ${words[0]}`, [object.base, object.count, cells.length / 8, found.bands.length], words.slice(1, 5));
      const rows = new Uint32Array(words.length - 5);
      let at = 0;
      for (const part of [found.rest, cells, found.looks, found.bands]) {
        rows.set(part, at);
        at += part.length;
      }
      core.call.sent_kernels(words[0]);
      same(`kernel rows of object ${words[0]}`, rows, words.slice(5));
    } else if (kind === kinds.order) {
      timed('keys_ms', () => core.call.update_keys());
      const count = timed('sort_ms', () => core.call.sort_kernels());
      same('order', core.words(core.call.order(), count), words);
      counts.kernels += count;
    }
    counts.words += words?.length ?? 0;
  }
  for (const name of Object.keys(times)) times[name] = Number(times[name].toFixed(4));
  return { frames: counts.frames, kernels: counts.kernels / counts.frames, ...times };
}

// A generator of random numbers below n that gives the same run again (Steele et al. 2014, SplitMix).
function randomOf(seed) {
  let state = BigInt(seed);
  return (n) => {
    state = BigInt.asUintN(64, state + 0x9E3779B97F4A7C15n);
    let z = state;
    z = BigInt.asUintN(64, (z ^ (z >> 30n)) * 0xBF58476D1CE4E5B9n);
    z = BigInt.asUintN(64, (z ^ (z >> 27n)) * 0x94D049BB133111EBn);
    return Number((z ^ (z >> 31n)) % BigInt(n));
  };
}

async function mutate(wasm, trace, count) {
  const records = [...recordsOf(trace)].filter(({ kind }) => kind <= kinds.frame), random = randomOf(count);
  const head = { [kinds.asset]: 4, [kinds.describe]: 24, [kinds.frame]: 16 };
  let accepted = 0, core = null;
  for (let i = 0; i < count; ++i) {
    if (i % 2000 === 0) {
      core = await Core.load(wasm);
      core.call.begin_stream(60);
      for (const record of records.slice(0, 12)) await feed(core, record, new Map());
    }
    const { kind, bytes } = records[i % 3 === 0 ? random(records.length) : random(Math.min(16, records.length))], from = head[kind];
    const changed = bytes.slice(0, random(4) === 0 ? from + random(bytes.length - from + 1) : bytes.length);
    for (let n = random(4); n >= 0 && changed.length > from; --n) {
      // Near the beginning, where lengths and counts are, as often as anywhere.
      const at = from + random(random(2) ? Math.min(64, changed.length - from) : changed.length - from);
      changed[at] = random(3) === 0 ? 255 * random(2) : changed[at] ^ (1 << random(8));
    }
    const record = { kind, bytes: changed, view: new DataView(changed.buffer) };
    if (kind === kinds.asset) {
      record.view.setUint32(0, 100 + random(3), true);
      if (random(2)) core.call.drop_asset(record.view.getUint32(0, true));
    }
    if (kind === kinds.describe) {
      record.view.setUint32(0, 1000 + i, true);
      record.view.setUint32(8, random(2), true);
      if (random(2)) record.view.setUint32(20, 100 + random(3), true);
    }
    try {
      await feed(core, record, new Map());
      ++accepted;
    } catch (error) {
      if (error instanceof WebAssembly.RuntimeError) throw new Error(`mutation ${i} of kind ${kind} traps: ${error.stack}`);
    }
    if (i % 8 === 0) {
      core.call.play(6e9 + 1e7 * i);
      for (const id of core.drawn()) if (core.object(id).fresh) core.call.sent_kernels(id);
      core.call.update_keys();
      core.call.sort_kernels();
    }
  }
  return { mutations: count, accepted };
}

const [wasmFile, first, ...rest] = process.argv.slice(2), wasm = readFileSync(wasmFile);
try {
  if (first === '--mutate') {
    console.log(JSON.stringify(await mutate(wasm, rest[0], Number(rest[1]))));
  } else {
    const found = await compare(wasm, first), native = rest[0] ? JSON.parse(rest[0]) : null;
    console.log(JSON.stringify({ equal: true, wasm: found, native }));
    if (found.frames < 60) throw new Error(`the trace has ${found.frames} frames`);
  }
} catch (error) {
  console.error(error.message);
  process.exit(1);
}
