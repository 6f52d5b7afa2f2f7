// SPDX-License-Identifier: Apache-2.0
// The client core (client/web/core/exports.cpp): its memory and the records that its functions describe.

// Words of BoundView and ObjectView.
const kBoundWords = 13, kObjectWords = 25;
const kAnswers = new Set(['describe_object', 'end_bound']); // 0 or 1; others answer 0
const kSliceRows = 32768, kRowWords = 10;

export class Core {
  // `source`: the bytes of the module, or one that was compiled.
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
    const module = source instanceof WebAssembly.Module ? source : await WebAssembly.compile(source), imports = {};
    for (const { name } of WebAssembly.Module.imports(module)) imports[name] = stubs[name] ?? (() => 8); // EBADF
    const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: imports });
    memory = instance.exports.memory;
    instance.exports._initialize?.();
    return new Core(instance.exports, module);
  }

  constructor(exports, module) { Object.assign(this, { call: exports, module }); }
  get buffer() { return this.call.memory.buffer; }

  // Calls `name` with bytes as address and size between the arguments; its answer, 0 or 1. Throws its error.
  take(name, before, bytes, after = []) {
    const at = this.call.allocate(Math.max(1, bytes.length)) >>> 0;
    if (at === 0) throw new WebAssembly.RuntimeError('the memory of the core is full');
    new Uint8Array(this.buffer, at, bytes.length).set(bytes);
    const answer = this.call[name](...before, at, bytes.length, ...after);
    this.call.release(at);
    if (answer === 2 || (answer && !kAnswers.has(name))) throw new Error(this.error());
    return answer;
  }
  error() {
    const from = this.call.error_text() >>> 0, bytes = new Uint8Array(this.buffer);
    return new TextDecoder().decode(bytes.slice(from, bytes.indexOf(0, from)));
  }
  words(at, count) { return new Uint32Array(this.buffer, at >>> 0, count); }
  floats(at, count) { return new Float32Array(this.buffer, at >>> 0, count); }

  drawn() { return [...this.words(this.call.drawn_ids(), this.call.drawn_count())]; }
  // An object of the scene; `rows` and `cells` are views, valid until the next call.
  object(id) {
    const at = this.call.object(id) >>> 0, words = this.words(at, kObjectWords).slice(), values = this.floats(at, kObjectWords).slice(11);
    const [description, base, count, fresh, moved, rows, row_count, isLattice, cell_count, node_count, cells] = words;
    return { description, base, count, fresh: fresh !== 0, moved: moved !== 0, rows: this.floats(rows, 16 * row_count), cells: isLattice ? this.words(cells, 8 * cell_count) : null,
      lattice: isLattice ? { cell_width_m: values[0], lattice_from_asset: values.slice(1, 5), body_gradient: values.slice(5, 14), cell_count, node_count } : null };
  }

  // ---- kernels from the binder to the scene
  // Copies of what bind_next() has bound.
  bound() {
    const [description, reserved, count, sh_degree, antialiased, rest, looks, bands, bandWords, terms, termCount, begins, beginCount] = this.words(this.call.bound_kernels(), kBoundWords).slice();
    const node_terms = new Uint32Array(3 * termCount + beginCount);
    node_terms.set(this.words(terms, 3 * termCount));
    node_terms.set(this.words(begins, beginCount), 3 * termCount);
    const copies = { description, reserved, term_count: termCount, node_terms, kernels: { count, sh_degree, antialiased: antialiased !== 0,
      rest: this.words(rest, kRowWords * count).slice(), looks: this.words(looks, 4 * count).slice(), bands: this.words(bands, bandWords).slice() } };
    this.call.release_bound();
    return copies;
  }
  // Takes them in slices; waits for pause() between two. Whether they are used.
  async takeBound({ description, reserved, term_count, node_terms, kernels: { rest } }, pause = () => {}) {
    this.call.begin_bound(description, reserved);
    for (let from = 0; from < rest.length; from += kSliceRows * kRowWords) {
      const rows = rest.subarray(from, from + kSliceRows * kRowWords);
      this.take('take_rows', [], new Uint8Array(rows.buffer, rows.byteOffset, rows.byteLength));
      await pause();
    }
    return this.take('end_bound', [term_count], new Uint8Array(node_terms.buffer)) === 1;
  }
}
