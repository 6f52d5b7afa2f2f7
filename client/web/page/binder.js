// SPDX-License-Identifier: Apache-2.0
// Fetches assets and binds objects to what has arrived of them, for worker.js, whose stream must not wait for it. Each asset
// is fetched once, in the order of requests, and kept by its hash in the Cache API. Messages of the session:
//
//   start     module, token, assets: address of their folder
//   describe  description (its number), rest: the rest body, or null if its kernels are bound already; session: its id;
//             store: { url, hashes: SHA-256 of the form for browsers, by the hash of the asset }, or undefined; name: of the
//             object; asset_hash, asset_bytes; broken_asset_hash, broken_asset_bytes: of an object that may break
//   forget    description: it was removed or replaced
//
// Answers: bound (Core.bound()), failed { description, message }, loading { message }, received { bytes }, crashed { message }.
import { Core } from './core.js';

const kFetches = 4, kRetryPause_ms = 150, kLoading_ms = 100, kCacheName = 'livegs-assets-1';
const kStoreAttempts = 5; // without a byte, before the asset is fetched from the server
const kStoreStall_ms = 5000; // without a byte, after which an attempt ends; larger: a silent store holds up the scene
class CutError extends Error {}
class StoreError extends Error {} // of the whole store, not of one object
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

class Binder {
  constructor(core, token, folder) {
    Object.assign(this, { core, token, folder, session: '', assets: new Map(), newest: new Map(), fetching: 0 }); // newest: hash by name of the object
  }

  describe({ description, rest, session, store, name, asset_hash, asset_bytes, broken_asset_hash, broken_asset_bytes }) {
    if (session !== this.session) this.failedStore = null;
    this.session = session;
    const mixed = globalThis.location?.protocol === 'https:' && store?.url?.startsWith('http:'); // browsers refuse it
    this.store = store?.url && !mixed && store.url !== this.failedStore ? store : null;
    const asset = this.request(asset_hash, asset_bytes, false, this.newest.get(name));
    this.newest.set(name, asset_hash);
    if (broken_asset_hash) this.request(broken_asset_hash, broken_asset_bytes, true, asset_hash);
    if (rest) {
      if (asset.failed) throw new Error(asset.failed);
      this.core.take('bind_object', [description, asset.number], rest);
      asset.waiting.add(description);
    }
    this.bind();
    queueMicrotask(() => this.fetchNext());
  }

  // Binds all that is due.
  bind() {
    const { core } = this;
    for (let answer = core.call.bind_next(); answer !== 0; answer = core.call.bind_next()) {
      const message = answer === 2 ? core.error() : '', bound = core.bound();
      if (answer === 2) {
        postMessage({ type: 'failed', description: bound.description, message });
      } else {
        const { kernels: { rest, looks, bands }, node_terms } = bound;
        for (const asset of this.assets.values()) asset.waiting.delete(bound.description);
        postMessage({ type: 'bound', ...bound }, [rest.buffer, looks.buffer, bands.buffer, node_terms.buffer]);
      }
    }
  }

  // `early`: of an object that may break; fetched when nothing else is. `base`: hash of an asset requested before, which the
  // server may send the difference to.
  request(hash, bytes, early, base) {
    let asset = this.assets.get(hash);
    if (!asset) {
      asset = { hash, number: this.assets.size, early, base: this.assets.get(base), arrived: 0, total: bytes, state: 'waits', waiting: new Set(), failed: '' };
      this.assets.set(hash, asset);
    }
    asset.early = asset.early && early;
    return asset;
  }

  fetchNext() {
    const waiting = [...this.assets.values()].filter((asset) => asset.state === 'waits');
    for (const asset of waiting.sort((a, b) => a.early - b.early)) {
      if (this.fetching >= (asset.early ? 1 : kFetches)) return;
      asset.state = 'loads';
      ++this.fetching;
      asset.loaded = this.load(asset).catch((error) => {
        if (error instanceof WebAssembly.RuntimeError) crashed(error);
        else this.fail(asset, `asset ${asset.hash.slice(0, 12)}: ${error.message}`);
      }).finally(() => {
        asset.state = 'done';
        --this.fetching;
        this.fetchNext();
      });
    }
  }

  // Objects are not waited for that need this asset, now or later.
  fail(asset, message) {
    asset.failed = message;
    for (const description of asset.waiting) {
      this.core.call.forget_object(description);
      postMessage({ type: 'failed', description, message });
    }
    if (asset.waiting.size === 0) postMessage({ type: 'failed', description: 0, message });
  }

  take(asset, chunk) {
    this.core.take('take_asset', [asset.number], chunk);
    asset.arrived += chunk.length;
    this.bind();
    this.loadTimer ??= setTimeout(() => {
      this.loadTimer = null;
      const all = [...this.assets.values()].filter((one) => !one.early), sum = (of) => all.reduce((total, one) => total + of(one), 0);
      postMessage({ type: 'loading', message: `${Math.floor((100 * sum((a) => Math.min(a.arrived, a.total))) / Math.max(1, sum((a) => a.total)))} %` });
    }, kLoading_ms);
  }

  // Binds objects to the whole asset. Returns false if bytes are missing.
  finish(asset) {
    const whole = this.core.call.finish_asset(asset.number);
    if (whole) this.bind();
    return whole;
  }

  // The difference to an earlier asset, in one attempt. Returns false if that fails.
  async loadEdit(asset, path, headers) {
    await asset.base.loaded; // it was requested first
    if (!this.core.call.edit_asset(asset.number, asset.base.number)) return false;
    const reply = await fetch(`${path}?base=${asset.base.hash}`, { headers });
    if (!reply.ok) return false;
    await eachChunk(reply.body, (chunk) => {
      postMessage({ type: 'received', bytes: chunk.length });
      this.take(asset, chunk);
    });
    return this.finish(asset);
  }

  // From the store, resumed by ranges. Throws if it fails or its bytes have another hash.
  async loadStored(asset, cache, path) {
    const { store } = this, fetched = [], plain = [], webHash = store.hashes[asset.hash];
    const inflater = new Inflater((chunk) => {
      this.take(asset, chunk);
      if (cache) plain.push(chunk);
    });
    let have = 0, failures = 0;
    for (let total = Infinity; have < total;) {
      let reply = null;
      const ending = new AbortController();
      let stall = setTimeout(() => ending.abort(), kStoreStall_ms);
      try {
        reply = await fetch(`${store.url}/${webHash}`, { credentials: 'omit', signal: ending.signal, ...(have > 0 ? { headers: { range: `bytes=${have}-` } } : {}) });
      } catch { /* tried again */ }
      const passing = !reply || reply.status >= 500 || reply.status === 429 || reply.status === 408;
      if (reply?.status === 401 || reply?.status === 403) throw new StoreError(`status ${reply.status}`);
      if (!passing && reply.status !== 206 && reply.status !== 200) throw new Error(`status ${reply.status}`);
      const begun = have;
      if (!passing) {
        let skip = reply.status === 200 ? have : 0; // a store without ranges
        const length = Number(reply.headers.get('content-length')); // 0: unknown
        if (length > 0) total = length + (reply.status === 206 ? have : 0);
        try {
          let broken = null;
          await eachChunk(reply.body, async (all) => {
            clearTimeout(stall);
            stall = setTimeout(() => ending.abort(), kStoreStall_ms);
            postMessage({ type: 'received', bytes: all.length });
            const chunk = all.subarray(Math.min(skip, all.length));
            skip -= all.length - chunk.length;
            have += chunk.length;
            fetched.push(chunk);
            try { await inflater.write(chunk); } catch (error) { broken = error; throw error; }
          }).catch((error) => { if (broken) throw broken; throw new CutError(error.message); });
          if (length === 0) total = have;
        } catch (error) {
          if (!(error instanceof CutError)) throw error;
        }
      }
      clearTimeout(stall);
      failures = have > begun ? 0 : failures + 1;
      if (failures > kStoreAttempts) throw new StoreError(reply ? `status ${reply.status}` : 'no connection');
      if (have < total) await sleep(kRetryPause_ms);
    }
    if (await sha256(new Blob(fetched)) !== webHash) throw new Error('its bytes have another hash');
    await inflater.end();
    if (!this.finish(asset)) throw new Error('its bytes are incomplete');
    await cache?.put(path, new Response(new Blob(plain), { headers: { 'content-length': String(asset.arrived) } })).catch(() => {});
  }

  async load(asset) {
    const { core } = this, path = this.folder + asset.hash;
    const cache = await globalThis.caches?.open(kCacheName).catch(() => null); // secure contexts only
    const restart = () => {
      core.call.drop_asset(asset.number);
      asset.arrived = 0;
    };
    const kept = await cache?.match(path).catch(() => null);
    if (kept) {
      try {
        asset.total = Number(kept.headers.get('content-length')) || asset.total;
        await eachChunk(kept.body, (chunk) => this.take(asset, chunk));
        if (this.finish(asset)) return;
      } catch (error) {
        if (error instanceof WebAssembly.RuntimeError) throw error;
        console.warn(`asset ${asset.hash.slice(0, 12)}: the kept copy is damaged; fetching it again`);
      }
      await cache.delete(path);
      restart();
    }
    const headers = () => ({ ...(this.token ? { authorization: `Bearer ${this.token}` } : {}), ...(this.session ? { 'livegs-session': this.session } : {}) });
    if (asset.base && this.session) {
      try {
        if (await this.loadEdit(asset, path, headers())) return;
      } catch (error) {
        if (error instanceof WebAssembly.RuntimeError) throw error;
      }
      restart(); // and fetch the whole asset
    }
    const { store } = this;
    if (store?.hashes[asset.hash]) {
      try {
        return await this.loadStored(asset, cache, path);
      } catch (error) {
        if (error instanceof WebAssembly.RuntimeError) throw error;
        console.warn(`asset ${asset.hash.slice(0, 12)}: ${store.url}: ${error.message}; fetching it from the server`);
        if (error instanceof StoreError) { // for the other assets too
          this.failedStore = store.url;
          this.store = null;
        }
        restart();
      }
    }
    const chunks = [];
    for (let damaged = false; ;) {
      let reply = null;
      try {
        reply = await fetch(`${path}?from=${asset.arrived}`, { headers: headers() });
      } catch { /* tried again */ }
      if (reply && !reply.ok && reply.status < 500) throw new Error(`status ${reply.status}: ${await reply.text()}`);
      if (reply?.ok) {
        asset.total = Number(reply.headers.get('livegs-total-bytes')) || asset.total;
        if (asset.arrived > 0 && !reply.headers.has('livegs-total-bytes')) { // a plain file server sends the whole file
          chunks.length = 0;
          restart();
        }
        let broken = null; // the error of the core, which a network does not explain
        try {
          await eachChunk(reply.body, (chunk) => {
            postMessage({ type: 'received', bytes: chunk.length });
            try { this.take(asset, chunk); } catch (error) { broken = error; throw error; }
            if (cache) chunks.push(chunk);
          });
        } catch (error) {
          if (broken instanceof WebAssembly.RuntimeError) throw error;
        }
        if (this.finish(asset)) {
          await cache?.put(path, new Response(new Blob(chunks), { headers: { 'content-length': String(asset.arrived) } })).catch(() => {});
          return;
        }
        if (broken || asset.arrived >= asset.total) {
          if (damaged) throw broken ?? new Error('the data are incomplete');
          damaged = true;
          chunks.length = 0;
          restart();
        }
      }
      await sleep(kRetryPause_ms);
    }
  }
}

// Takes what was fetched of a gzip stream, piece by piece.
class Inflater {
  constructor(take) {
    const stream = new DecompressionStream('gzip');
    this.writer = stream.writable.getWriter();
    this.done = eachChunk(stream.readable, take);
    this.done.catch(() => {}); // reported by whichever is awaited
  }
  write(chunk) { return Promise.race([this.writer.write(chunk), this.done]); }
  async end() {
    await Promise.race([this.writer.close(), this.done]);
    await this.done;
  }
}

async function sha256(blob) {
  const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', await blob.arrayBuffer()));
  return Array.from(digest, (byte) => byte.toString(16).padStart(2, '0')).join('');
}

async function eachChunk(body, take) {
  for (const reader = body.getReader();;) {
    const { done, value } = await reader.read();
    if (done) return;
    await take(value);
  }
}

function crashed(error) { postMessage({ type: 'crashed', message: error.message }); }

let binder = null, ready = null;
onmessage = async ({ data }) => {
  if (data.type === 'start') {
    ready = Core.load(data.module).then((core) => { binder = new Binder(core, data.token, data.assets); });
    return;
  }
  try {
    await ready;
    if (data.type === 'describe') binder.describe(data);
    if (data.type === 'forget') binder.core.call.forget_object(data.description);
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError) return crashed(error);
    postMessage({ type: 'failed', description: data.description, message: error.message });
  }
};
