// SPDX-License-Identifier: Apache-2.0
// The controls around the picture: status, run, force, and the list of objects with their values and reasons.
// `host` has act(name) and send(method, request), a promise of the reply.
const kStates = { connecting: 'connecting', loading: 'loading', live: 'live', lost: 'connection lost', refused: 'refused', ended: 'ended' };
const kBehaviors = ['auto', 'static', 'rigid', 'elastic'];
const kSources = ['', 'offline estimate', 'model', 'scene file', 'edited', 'default'];
// Estimated values of PhysicalParameters: field, name, unit.
const kValues = [['mass_kg', 'Mass', 'kg'], ['youngs_modulus_pa', "Young's modulus", 'Pa'], ['poisson_ratio', "Poisson's ratio", ''],
  ['structure_coefficient', 'Structure', ''], ['deformation_resistance', 'Resistance', ''], ['plasticity', 'Plasticity', ''],
  ['damping', 'Damping', ''], ['friction', 'Friction', ''], ['restitution', 'Restitution', ''], ['wall_thickness_m', 'Wall', 'm'],
  ['break_impulse_n_s', 'Breaks at', 'N s'], ['longest_side_m', 'Longest side', 'm']];

const at = (id) => document.getElementById(id);

function element(name, text, kind) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (kind) made.className = kind;
  return made;
}

// Three digits; large and small values with a power of ten.
export function number(value) {
  if (!(Math.abs(value) > 0)) return '0';
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : String(Number(value.toPrecision(3)));
}

export class Panels {
  constructor(host) {
    this.host = host;
    this.items = new Map(); // list items by object id
    for (const name of ['pause', 'step', 'reset', 'undo', 'redo', 'frame', 'shoot', 'enter']) at(name).addEventListener('click', () => host.act(name));
    at('pull').addEventListener('click', () => at('pull').setAttribute('aria-pressed', String(host.togglePull())));
    at('play').addEventListener('click', () => host.post({ type: 'film', pause: at('play').textContent === 'Pause' }));
    at('moment').addEventListener('input', () => host.post({ type: 'film', seek_s: Number(at('moment').value) }));
    at('loop').addEventListener('change', () => host.post({ type: 'film', loop: at('loop').checked }));
    at('fold').addEventListener('click', () => this.fold());
    if (matchMedia('(max-width: 700px)').matches) this.fold();
    at('pair').addEventListener('submit', (event) => {
      event.preventDefault();
      host.pair(at('code').value.trim());
    });
  }

  fold() {
    const hidden = (at('panel').hidden = !at('panel').hidden);
    at('fold').setAttribute('aria-expanded', String(!hidden));
  }

  status(state, message) {
    at('state').textContent = kStates[state] ?? state;
    at('state').dataset.state = state;
    at('message').textContent = message || { lost: 'trying again', ended: 'reload the page to start again' }[state] || '';
    if (state === 'refused') this.askForCode(message);
    else if (state === 'live' || state === 'loading') at('pair').hidden = true;
  }

  askForCode(reason) {
    at('pair_reason').textContent = reason || 'This browser is not paired with the server yet.';
    if (at('pair').hidden) {
      at('pair').hidden = false;
      at('code').value = '';
      at('code').focus();
    }
  }

  // The moment of a recording.
  film({ at_s, length_s, paused }) {
    at('film').hidden = false;
    at('play').textContent = paused ? 'Play' : 'Pause';
    at('moment').max = length_s;
    if (!at('moment').matches(':active')) at('moment').value = at_s; // not while it is dragged
  }

  notice(text) { at('run').textContent = text; }
  xr(text, enabled) {
    at('enter').hidden = false;
    at('enter').textContent = text;
    at('enter').disabled = !enabled;
  }

  // State of the simulation (RunState), and whether this client may only watch.
  run(run, step_ms, viewOnly) {
    const text = `${run.waiting ? 'waits for the start' : run.loading ? 'loading' : run.paused ? 'paused' : 'running'}, ${Number(run.simulated_s ?? 0).toFixed(1)} s, step ${Number(step_ms ?? 0).toFixed(1)} ms${run.message ? `; ${run.message}` : ''}`;
    if (this.runText !== text) at('run').textContent = this.runText = text;
    const pause = run.waiting ? 'Start' : run.paused ? 'Continue' : 'Pause';
    if (at('pause').textContent !== pause) at('pause').textContent = pause;
    for (const name of ['pause', 'step', 'reset']) at(name).disabled = viewOnly;
  }

  undo(scene) {
    at('undo').disabled = !scene?.undo;
    at('redo').disabled = !scene?.redo;
    at('undo').title = scene?.undo ? `Undo: ${scene.undo}` : 'Nothing to undo';
    at('redo').title = scene?.redo ? `Redo: ${scene.redo}` : 'Nothing to redo';
  }

  // Forces of held objects: [{ name, force_n }].
  force(held) {
    const text = held.map((one) => `${one.name}: ${number(one.force_n)} N`).join(', ') || 'No object is held.';
    if (this.forceText !== text) at('force').textContent = this.forceText = text;
  }

  stats(s) {
    const part = (value, digits, unit) => (Number.isFinite(value) ? `${value.toFixed(digits)} ${unit}` : null);
    at('stats').textContent = [part(s.kernels, 0, 'kernels'), part(s.fps, 0, 'pictures/s'), part(s.rtt_ms, 1, 'ms round trip'),
      part(s.decode_ms, 2, 'ms decode'), part(s.sort_ms, 1, 'ms sort'), part(s.bytes_s / 1e3, 0, 'kB/s')].filter(Boolean).join(', ');
  }

  choose(id) {
    for (const [other, item] of this.items) item.toggleAttribute('data-chosen', other === id);
    this.items.get(id)?.scrollIntoView({ block: 'nearest' });
  }

  object(object) {
    let item = this.items.get(object.id);
    if (!item) {
      item = element('li');
      this.items.set(object.id, item);
      at('objects').append(item);
    }
    const open = item.querySelector('details')?.open ?? false;
    const description = object.description ?? {};
    const mass = Number(description.mass_kg ?? 0);
    const kind = object.environment ? 'environment' : object.kind === 'lattice' ? 'elastic' : mass > 0 ? 'rigid' : 'static';
    const details = element('details');
    details.open = open;
    details.append(element('summary', `${object.name || `object ${object.id}`}: ${kind}${mass > 0 ? `, ${number(mass)} kg` : ''}${object.hidden ? ', hidden' : ''}`));
    this.values(details, description.physics, description.warnings ?? []);
    if (!object.environment) {
      const again = element('button', 'Values and reasons');
      again.type = 'button';
      again.addEventListener('click', async () => {
        again.disabled = true;
        try {
          const reply = await this.host.send('AnalyzeObject', { object: object.name });
          this.values(details, reply.parameters, reply.warnings ?? []);
        } catch (error) {
          again.textContent = error.message;
        }
        again.disabled = false;
      });
      details.append(again);
    }
    item.replaceChildren(details);
  }

  values(details, physics, warnings) {
    const list = element('dl');
    const row = (name, text, reason) => {
      list.append(element('dt', name), element('dd', text));
      if (reason) list.append(element('p', reason, 'reason'));
    };
    if (physics) {
      const behavior = typeof physics.behavior === 'number' ? kBehaviors[physics.behavior] : String(physics.behavior ?? '').toLowerCase();
      row('What', [physics.label, physics.material].filter(Boolean).join(', ') || 'unknown', '');
      row('Behaviour', behavior, physics.behavior_reason);
      for (const part of physics.parts ?? []) row('Part', `${part.name} of ${part.material}, ${number(100 * part.mass_share)} %`, '');
      for (const [field, name, unit] of kValues) {
        const value = physics[field];
        if (!value || !(value.best || value.reason)) continue;
        const range = value.low < value.high ? ` (${number(value.low)} to ${number(value.high)})` : '';
        const source = typeof value.source === 'number' ? kSources[value.source] : String(value.source ?? '').toLowerCase();
        row(name, `${number(value.best)} ${unit}${range}`, [value.reason, source && `[${source}]`].filter(Boolean).join(' '));
      }
    }
    for (const warning of warnings) list.append(element('p', warning, 'reason'));
    const old = details.querySelector('dl');
    if (old) old.replaceWith(list);
    else details.append(list);
  }

  remove(id) {
    this.items.get(id)?.remove();
    this.items.delete(id);
  }
}
