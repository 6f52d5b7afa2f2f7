// SPDX-License-Identifier: Apache-2.0
// node read_usd.mjs MODULES FILE...: parses .usda files with TinyUSDZ (MODULES/node_modules), a reader of OpenUSD by others,
// and prints the prims below /World. The exit code is 1 if a file is refused or has no bodies.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, ...files] = process.argv.slice(2);
const folder = path.resolve(modules, 'node_modules/tinyusdz');
// The package is built for browsers.
process.type = 'renderer';
globalThis.window = globalThis.self = globalThis;
const create = (await import(pathToFileURL(path.join(folder, 'tinyusdz.js')))).default;
const wasm = fs.readFileSync(path.join(folder, 'tinyusdz.wasm'));
const usd = await create({
  instantiateWasm: (imports, done) => {
    WebAssembly.instantiate(wasm, imports).then((result) => done(result.instance, result.module));
    return {};
  },
});
let failed = files.length === 0;
for (const file of files) {
  const loader = new usd.TinyUSDZLoaderNative();
  const read = loader.loadFromBinary(fs.readFileSync(file), file);
  const root = read ? loader.getDefaultRootNode() : undefined;
  const bodies = (root?.children ?? []).filter((prim) => prim.children.some((child) => child.absPath.endsWith('/splats')));
  console.log(`${path.basename(file)}: ${read ? root.absPath : loader.error()}, ${bodies.length} bodies`);
  if (!read || root.absPath !== '/World' || bodies.length === 0) failed = true;
}
process.exit(failed ? 1 : 0);
