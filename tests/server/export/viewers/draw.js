// SPDX-License-Identifier: Apache-2.0
// Reads the query of the page, draws until the sorting of the splats has settled, and tells by window.done.
export async function draw(open) {
  const query = new URLSearchParams(location.search);
  const numbers = (name) => query.get(name).split(',').map(Number);
  window.done = null;
  try {
    const picture = await open({ file: query.get('file'), eye: numbers('eye'), at: numbers('at'),
      fov: Number(query.get('fov')), width: Number(query.get('width')), height: Number(query.get('height')) });
    for (let i = 0; i < 40; ++i) {
      picture();
      await new Promise((next) => setTimeout(next, 60));
    }
    window.done = 'drawn';
  } catch (error) {
    window.done = String(error.stack ?? error);
  }
}
