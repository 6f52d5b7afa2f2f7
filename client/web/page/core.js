// SPDX-License-Identifier: Apache-2.0
// The client core (client/web/core/exports.cpp): its memory and the records that its functions describe.

// Where the members of KernelsView and DriversView are, in words.
const kKernelWords = 18, kDriverWords = 19;

export class Core {
  static async load(source) {
    let memory = null, line = '';
    const stubs = {
      fd_write: (file, parts, count, written) => { // assertions only
        const view = new DataView(memory.buffer);
        let total = 0;
        for (let i = 0; i < count; ++i) {
          const [at, size] = [view.getUint32(parts + 8 * i, true), view.getUint32(parts + 8 * i + 4, true)];
          line += new TextDecoder().decode(new Uint8Array(memory.buffer, at, size).slice());
          total += size;
        }
        view.setUint32(written, total, true);
        if (line.endsWith('\n')) {
          console.error(line.trimEnd());
          line = '';
        }
        return 0;
      },
      proc_exit: (code) => { throw new WebAssembly.RuntimeError(`the core exited with ${code}`); },
    };
    const module = await WebAssembly.compile(source), imports = {};
    for (const { name } of WebAssembly.Module.imports(module)) imports[name] = stubs[name] ?? (() => 8); // EBADF
    const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: imports });
    memory = instance.exports.memory;
    instance.exports._initialize?.();
    return new Core(instance.exports);
  }

  constructor(exports) { this.call = exports; }
  get buffer() { return this.call.memory.buffer; }

  // Calls `name` with bytes as address and size between the arguments; throws its error.
  take(name, before, bytes, after = []) {
    const at = this.call.allocate(Math.max(1, bytes.length)) >>> 0;
    if (at === 0) throw new WebAssembly.RuntimeError('the memory of the core is full');
    new Uint8Array(this.buffer, at, bytes.length).set(bytes);
    const failed = this.call[name](...before, at, bytes.length, ...after);
    this.call.release(at);
    if (failed) throw new Error(this.error());
  }
  error() {
    const from = this.call.error_text() >>> 0, bytes = new Uint8Array(this.buffer);
    return new TextDecoder().decode(bytes.slice(from, bytes.indexOf(0, from)));
  }
  words(at, count) { return new Uint32Array(this.buffer, at >>> 0, count); }
  floats(at, count) { return new Float32Array(this.buffer, at >>> 0, count); }

  drawn() { return [...this.words(this.call.drawn_ids(), this.call.drawn_count())]; }
  // Drivers of an object; `rows` is a view, valid until the next call.
  drivers(id) {
    const at = this.call.describe_drivers(id) >>> 0, [rows, count, isLattice, moved, unpacked] = this.words(at, kDriverWords);
    const values = this.floats(at, kDriverWords).slice(5);
    return { rows: this.floats(rows, 16 * count), moved: moved !== 0, unpacked: unpacked !== 0,
      lattice: isLattice ? { cell_width_m: values[0], lattice_from_asset: values.slice(1, 5), body_gradient: values.slice(5, 14) } : null };
  }
  // Static data of an object as copies, once after each binding.
  kernels(id) {
    const at = this.call.describe_kernels(id) >>> 0, words = this.words(at, kKernelWords).slice(), bounds = this.floats(at, kKernelWords).slice(12);
    const [base, count, sh_degree, antialiased, isLattice, cell_count, node_count, rest, cells, looks, bands, bandWords] = words;
    const copied = { base, count, sh_degree, antialiased: antialiased !== 0, cell_count, node_count, rest: this.words(rest, 10 * count).slice(),
      cells: isLattice ? this.words(cells, 8 * cell_count).slice() : null, looks: this.words(looks, 4 * count).slice(),
      bands: this.words(bands, bandWords).slice(), bounds_m: [...bounds] };
    this.call.release_kernels();
    return copied;
  }
}
