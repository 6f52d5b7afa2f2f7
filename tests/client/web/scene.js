// SPDX-License-Identifier: Apache-2.0
// Reads the files of reference_picture as messages of the worker.
export async function readScene(folder) {
  const scene = await (await fetch(`${folder}/scene.json`)).json();
  const words = new Uint32Array(await (await fetch(`${folder}/scene.bin`)).arrayBuffer());
  const uints = ([first, count]) => words.slice(first, first + count);
  for (const object of scene.objects) {
    for (const name of ['rest', 'looks', 'bands']) object[name] = uints(object[name]);
    if (object.cells) object.cells = uints(object.cells);
    object.rows = new Float32Array(uints(object.rows).buffer);
  }
  for (const view of scene.views) {
    view.order = uints(view.order);
    view.rgba = new Uint8Array(uints(view.rgb).buffer);
    view.near_m = view.near_m[0];
  }
  return scene;
}
