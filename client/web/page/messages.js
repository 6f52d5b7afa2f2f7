// SPDX-License-Identifier: Apache-2.0
// Codec of protobuf messages (protobuf.dev, "Encoding") as plain objects in field names of the protos, by the table
// fields.js. Integers are Numbers: exact below 2^53, which ticks, counts and nanoseconds of 104 days are. Enums are
// numbers, bytes are views of the input.
//
// encode() writes each field that is not undefined or null. decode() sets every field: one without presence gets its
// default, a missing one with presence stays undefined. Malformed bytes throw a RangeError; the depth of messages is
// limited, and memory is a small multiple of the input.
import { messages } from './fields.js';

const kRepeated = 1, kPresence = 2, kMaxDepth = 32;
const kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5;
const wireTypes = { double: kFixed64, fixed64: kFixed64, sfixed64: kFixed64, float: kFixed32, fixed32: kFixed32, sfixed32: kFixed32, string: kBytes, bytes: kBytes };
const toText = new TextDecoder(), fromText = new TextEncoder();
const wireTypeOf = (type) => wireTypes[type] ?? (messages[type] ? kBytes : kVarint);
const defaultOf = (type) => (type === 'string' ? '' : type === 'bytes' ? new Uint8Array(0) : type === 'bool' ? false : 0);

class Writer {
  constructor() { this.bytes = []; }
  varint(value) {
    let rest = BigInt.asUintN(64, BigInt(Math.trunc(Number(value))));
    for (; rest > 127n; rest >>= 7n) this.bytes.push(Number(rest & 127n) | 128);
    this.bytes.push(Number(rest));
  }
  raw(bytes) { for (const byte of bytes) this.bytes.push(byte); }
  sized(bytes) {
    this.varint(bytes.length);
    this.raw(bytes);
  }
  value(type, value) {
    if (messages[type]) return this.sized(encode(type, value));
    switch (type) {
      case 'double': return this.raw(new Uint8Array(new Float64Array([value]).buffer));
      case 'float': return this.raw(new Uint8Array(new Float32Array([value]).buffer));
      case 'string': return this.sized(fromText.encode(value));
      case 'bytes': return this.sized(value);
      default: return this.varint(value);
    }
  }
}

export function encode(name, object) {
  const out = new Writer();
  for (const [field, [number, type, flags]] of Object.entries(messages[name])) {
    const value = object[field];
    if (value === undefined || value === null || (flags === kRepeated && value.length === 0)) continue;
    const wire = wireTypeOf(type);
    if (flags === kRepeated && wire !== kBytes) {
      const packed = new Writer();
      for (const one of value) packed.value(type, one);
      out.varint(number * 8 + kBytes);
      out.sized(packed.bytes);
      continue;
    }
    for (const one of flags === kRepeated ? value : [value]) {
      out.varint(number * 8 + wire);
      out.value(type, one);
    }
  }
  return new Uint8Array(out.bytes);
}

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    this.at = 0;
  }
  skip(size) {
    if (!(size <= this.bytes.length - this.at)) throw new RangeError('message: is truncated');
    this.at += size;
    return this.at - size;
  }
  // Two halves of 32 bits.
  varint() {
    let low = 0, high = 0;
    for (let shift = 0; shift < 70; shift += 7) {
      const byte = this.bytes[this.skip(1)], part = byte & 127;
      if (shift < 28) low |= part << shift;
      else if (shift === 28) [low, high] = [low | (part << 28), part >> 4];
      else if (shift < 63) high |= part << (shift - 32);
      else high |= part << 31;
      if (byte < 128) return [low >>> 0, high >>> 0];
    }
    throw new RangeError('message: a number is too long');
  }
  size() {
    const [low, high] = this.varint();
    if (high !== 0) throw new RangeError('message: is truncated');
    return low;
  }
  sized() {
    const size = this.size(), from = this.skip(size);
    return this.bytes.subarray(from, from + size);
  }
  value(type, depth) {
    if (messages[type]) return decode(type, this.sized(), depth + 1);
    switch (type) {
      case 'double': return this.view.getFloat64(this.skip(8), true);
      case 'float': return this.view.getFloat32(this.skip(4), true);
      case 'string': return toText.decode(this.sized());
      case 'bytes': return this.sized();
    }
    const [low, high] = this.varint();
    if (type === 'bool') return low !== 0 || high !== 0;
    if (type === 'uint32') return low;
    if (type === 'int32' || type === 'enum') return low | 0;
    return (type === 'int64' ? high | 0 : high) * 4294967296 + low;
  }
  skipValue(wire) {
    if (wire === kVarint) this.varint();
    else if (wire === kFixed64) this.skip(8);
    else if (wire === kBytes) this.sized();
    else if (wire === kFixed32) this.skip(4);
    else throw new RangeError('message: has an unknown type of field');
  }
}

const tables = new Map(); // by message: by field number [name, type, flags]

export function decode(name, bytes, depth = 0) {
  if (depth > kMaxDepth) throw new RangeError('message: is nested too deeply');
  const object = {};
  for (const [field, [, type, flags]] of Object.entries(messages[name])) {
    if (flags !== kPresence) object[field] = flags === kRepeated ? [] : defaultOf(type);
  }
  if (!tables.has(name)) tables.set(name, new Map(Object.entries(messages[name]).map(([field, [number, type, flags]]) => [number, [field, type, flags]])));
  const table = tables.get(name), input = new Reader(bytes);
  while (input.at < bytes.length) {
    const key = input.size(), wire = key & 7, known = table.get(key >>> 3);
    const [field, type, flags] = known ?? [];
    if (!known || (wire !== wireTypeOf(type) && !(wire === kBytes && flags === kRepeated))) {
      input.skipValue(wire);
    } else if (flags !== kRepeated) {
      object[field] = input.value(type, depth);
    } else if (wire !== wireTypeOf(type)) {
      const packed = new Reader(input.sized());
      while (packed.at < packed.bytes.length) object[field].push(packed.value(type, depth));
    } else {
      object[field].push(input.value(type, depth));
    }
  }
  return object;
}
