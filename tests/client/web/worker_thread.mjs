// SPDX-License-Identifier: Apache-2.0
// A thread with the globals of a worker of the page, for worker_host.mjs. The Cache API is a map; fetched paths are reported.
import { parentPort, workerData } from 'node:worker_threads';

const plainFetch = globalThis.fetch, cached = new Map();
Object.assign(globalThis, {
  postMessage: (message, transfer) => parentPort.postMessage(message, transfer),
  onmessage: null,
  caches: { open: async () => ({
    match: async (path) => cached.get(path)?.clone(),
    put: async (path, reply) => void cached.set(path, reply),
    delete: async (path) => cached.delete(path) }) },
  fetch: (path, options) => {
    const { pathname, search } = new URL(path, workerData.href);
    parentPort.postMessage({ type: 'fetched', path: pathname, edit: search.startsWith('?base=') });
    return plainFetch(new URL(path, workerData.href), options);
  },
});
await import(workerData.url);
parentPort.on('message', (data) => globalThis.onmessage({ data }));
