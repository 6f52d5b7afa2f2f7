// SPDX-License-Identifier: Apache-2.0
// A headset by WebXR: both eyes straight into the session's layer, hands and controllers, haptics, frame rate and
// resolution by what the device holds. The page draws nothing meanwhile.
import { makeEye } from './renderer.js';
import { metresANewton } from './controls.js';
import { number } from './panels.js';
import { add, length, multiply, rotate, scaled, subtract } from './vector.js';

const kFrameTimeout_ms = 4000; // without a frame of a visible session; then it is ended, so that a user is never stuck
const kWindow_ms = 2000; // in which late frames are counted
const kLateShare = 0.1; // of frames; above, the rate or the resolution falls
const kScales = [1, 0.85, 0.7, 0.6, 0.5]; // of the viewport's sides
const kRay_m = 1.2, kRayHalfWidth_m = 0.0015;
const kRayColour = [0.85, 0.9, 1, 0.7], kForceColour = [1, 0.59, 0.12, 1]; // client/viewer/hands/hand_markers.cpp

// Pulses of one hand from the server's reports. Twin of client/viewer/hands/haptics.cpp without its predictions.
class Feel {
  constructor() { this.held = 0; this.impulse = 0; this.last_ms = -Infinity; }
  report(held, impulse_n_s, now_ms) {
    if (held !== this.held) {
      Object.assign(this, { held, impulse: 0, last_ms: -Infinity });
      if (held) return [0.3, 15];
    }
    if (!(impulse_n_s > 0.02)) return null;
    const goesOn = now_ms - this.last_ms < 100, knocks = goesOn && impulse_n_s > 3 * this.impulse;
    this.impulse = goesOn ? Math.max(impulse_n_s, 0.8 * this.impulse + 0.2 * impulse_n_s) : impulse_n_s;
    this.last_ms = now_ms;
    return goesOn && !knocks ? null : [Math.min(1, Math.sqrt(impulse_n_s)), 20];
  }
}

function multiplied(a, b) { // 4 by 4, by columns
  const c = new Float32Array(16);
  for (let column = 0; column < 4; ++column)
    for (let row = 0; row < 4; ++row)
      for (let k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return c;
}

// Rotation about +y by an angle, then a translation; by columns.
const turnedAndMoved = (angle, t) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  return new Float32Array([c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, t[0], t[1], t[2], 1]);
};

function eyeOf(sceneFromEye, p, viewport) {
  const m = sceneFromEye, size = [viewport.width, viewport.height];
  const column = (i, sign) => [sign * m[4 * i], sign * m[4 * i + 1], sign * m[4 * i + 2]];
  return makeEye({ position: column(3, 1), right: column(0, 1), down: column(1, -1), forward: column(2, -1), size,
    focal: [0.5 * size[0] * p[0], 0.5 * size[1] * p[5]], centre: [0.5 * size[0] * (1 - p[8]), 0.5 * size[1] * (1 + p[9])] });
}

export class Headset {
  // `host`: renderer(), camera, sendHands(left, right), sendView(view), held(), objectOf(id), ended(), notice(text), problem(): a text for the user, or empty.
  constructor(gl, host) {
    Object.assign(this, { gl, host, session: null, counts: { sessions: 0, frames: 0, pulses: 0, recentred: 0 } });
  }

  async enter() {
    if (this.session || this.entering) return;
    this.entering = true;
    let session;
    try {
      session = await navigator.xr.requestSession('immersive-vr', { optionalFeatures: ['local-floor', 'hand-tracking'] });
      await this.gl.makeXRCompatible?.();
      this.layer = new XRWebGLLayer(session, this.gl, { antialias: false, depth: false, stencil: false, alpha: true });
      if ('fixedFoveation' in this.layer) this.layer.fixedFoveation = 1 / 3;
      session.updateRenderState({ baseLayer: this.layer, depthNear: 0.05, depthFar: 1000 });
      this.base = await session.requestReferenceSpace('local-floor').catch(() => session.requestReferenceSpace('local'));
    } catch (error) {
      session?.end().catch(() => {});
      throw error;
    } finally {
      this.entering = false;
    }
    this.session = session;
    ++this.counts.sessions;
    this.feel = [new Feel(), new Feel()];
    this.pressed = new Map(); // [select, squeeze] by input source, from events: hands may have no buttons
    this.hands = [null, null];
    this.sceneFromLocal = null;
    this.scale = 0;
    this.frameTimes = [];
    this.lastFrame_ms = performance.now();
    this.base.addEventListener('reset', () => {
      this.sceneFromLocal = null; // placed again by the next frame
      ++this.counts.recentred;
    });
    const press = (event, which, down) => {
      const now = this.pressed.get(event.inputSource) ?? [false, false];
      now[which] = down;
      this.pressed.set(event.inputSource, now);
    };
    for (const [which, name] of ['select', 'squeeze'].entries()) {
      session.addEventListener(`${name}start`, (event) => press(event, which, true));
      session.addEventListener(`${name}end`, (event) => press(event, which, false));
    }
    session.addEventListener('visibilitychange', () => {
      this.lastFrame_ms = performance.now();
      if (session.visibilityState !== 'visible') this.letGo();
    });
    session.addEventListener('end', () => this.onEnd(session));
    this.watchdog = setInterval(() => {
      if (session.visibilityState === 'visible' && performance.now() - this.lastFrame_ms > kFrameTimeout_ms) {
        this.host.notice('the headset requests no pictures, so the session was ended; enter VR again');
        session.end().catch(() => this.onEnd(session));
      }
    }, 500);
    this.chooseRate(90);
    session.requestAnimationFrame((time, frame) => this.frame(time, frame));
  }

  leave() { this.session?.end().catch(() => {}); }

  onEnd(session) {
    if (this.session !== session) return;
    clearInterval(this.watchdog);
    this.session = null;
    this.letGo();
    this.host.ended();
  }

  letGo() {
    this.hands = [null, null];
    this.pressed.clear();
    this.host.sendHands(null, null);
  }

  // The highest supported rate that is at most `most`, hertz.
  chooseRate(most) {
    const rates = [...(this.session.supportedFrameRates ?? [])].filter((rate) => rate <= most);
    this.rate_hz = rates.length ? Math.max(...rates) : (this.session.frameRate ?? 72);
    if (rates.length) this.session.updateTargetFrameRate?.(this.rate_hz)?.catch(() => {});
    return rates.length > 0;
  }

  // Lowers the rate, then the resolution, while frames are late; raises the resolution after ten good windows.
  adapt(passed_ms) {
    this.frameTimes.push(passed_ms);
    if (this.frameTimes.reduce((a, b) => a + b, 0) < kWindow_ms) return;
    const late = this.frameTimes.filter((ms) => ms > 1500 / this.rate_hz).length / this.frameTimes.length;
    this.frameTimes = [];
    this.goodWindows = late < 0.02 ? (this.goodWindows ?? 0) + 1 : 0;
    if (late > kLateShare) {
      if (!(this.rate_hz > 72 && this.chooseRate(this.rate_hz - 1))) this.scale = Math.min(this.scale + 1, kScales.length - 1);
    } else if (this.goodWindows >= 10 && this.scale > 0) {
      --this.scale;
      this.goodWindows = 0;
    }
  }

  // Puts the user where the window's camera is, upright: sceneFromLocal and its inverse, and the turn as a quaternion.
  place(pose) {
    const m = pose.transform.matrix, camera = this.host.camera, head = [m[12], m[13], m[14]];
    const angle = camera.azimuth - Math.atan2(m[8], m[10]), turn = (sign) => [Math.cos(0.5 * angle), 0, sign * Math.sin(0.5 * angle), 0];
    this.turn = turn(1);
    this.moved_m = subtract(camera.position, rotate(this.turn, head));
    this.sceneFromLocal = turnedAndMoved(angle, this.moved_m);
    this.localFromScene = turnedAndMoved(-angle, scaled(rotate(turn(-1), this.moved_m), -1));
  }

  placed(transform) {
    const { position: p, orientation: q } = transform;
    return [add(rotate(this.turn, [p.x, p.y, p.z]), this.moved_m), multiply(this.turn, [q.w, q.x, q.y, q.z])];
  }

  sampleHands(frame) {
    const hands = [null, null];
    for (const source of this.session.inputSources) {
      if (source.targetRayMode !== 'tracked-pointer' && source.targetRayMode !== 'transient-pointer') continue;
      const aim = frame.getPose(source.targetRaySpace, this.base);
      if (!aim) continue;
      const grip = (source.gripSpace && frame.getPose(source.gripSpace, this.base)) || aim;
      const [aim_position, aim_orientation] = this.placed(aim.transform), [grip_position, grip_orientation] = this.placed(grip.transform);
      const [select, squeeze] = this.pressed.get(source) ?? [false, false], buttons = source.gamepad?.buttons ?? [];
      hands[source.handedness === 'left' ? 0 : 1] = {
        aim_position, aim_orientation, grip_position, grip_orientation,
        trigger: Math.max(select ? 1 : 0, source.hand ? 0 : (buttons[0]?.value ?? 0)), squeeze: Math.max(squeeze ? 1 : 0, buttons[1]?.value ?? 0),
        shoot: !source.hand && Boolean(buttons[4]?.pressed) };
    }
    this.hands = hands;
    this.host.sendHands(hands[0], hands[1]);
  }

  // Vibrates by the reports of a frame of the stream: [{ hand, object_id, contact_impulse_n_s }].
  onHands(reported) {
    if (!this.session) return;
    for (const hand of [0, 1]) {
      const held = reported.find((one) => Number(one.hand ?? 0) === hand);
      const pulse = this.feel[hand].report(held?.object_id ?? 0, Number(held?.contact_impulse_n_s ?? 0), performance.now());
      if (pulse) this.pulse(hand, ...pulse);
    }
  }

  pulse(hand, amplitude, ms) {
    ++this.counts.pulses;
    for (const source of this.session.inputSources) {
      if ((source.handedness === 'left' ? 0 : 1) !== hand || source.hand) continue;
      try {
        const actuator = source.gamepad?.hapticActuators?.[0];
        const done = actuator?.pulse ? actuator.pulse(amplitude, ms)
          : source.gamepad?.vibrationActuator?.playEffect?.('dual-rumble', { duration: ms, strongMagnitude: amplitude, weakMagnitude: amplitude });
        done?.catch?.(() => {});
      } catch { /* a device without haptics */ }
    }
  }

  // Rays of the hands, and the forces on what they hold.
  marks() {
    const marks = [];
    const mark = (from, to, near_m, far_m, colour) => marks.push({ from, to, halfWidth_m: [near_m, far_m], colour });
    const held = this.host.held();
    this.hands.forEach((hand, index) => {
      if (!hand) return;
      const ray = held.find((one) => Number(one.hand ?? 0) === index && !one.grabbed);
      const end = ray?.point_m ?? add(hand.aim_position, scaled(rotate(hand.aim_orientation, [0, 0, -1]), kRay_m));
      mark(hand.aim_position, end, kRayHalfWidth_m, ray ? kRayHalfWidth_m : 0, kRayColour);
      const back = rotate(hand.grip_orientation, [0, 0, 0.04]);
      mark(subtract(hand.grip_position, back), add(hand.grip_position, back), 0.008, 0.008, kRayColour);
    });
    for (const one of held) {
      const object = this.host.objectOf(one.object_id), arrow = scaled(one.force_n, metresANewton(object.mass_kg, object.size_m));
      if (!(length(arrow) > 0.005)) continue;
      const neck = add(one.point_m, scaled(arrow, 0.75)), tip = add(one.point_m, arrow), width = Math.min(0.012, 0.1 * length(arrow));
      mark(one.point_m, neck, 0.4 * width, 0.4 * width, kForceColour);
      mark(neck, tip, width, 0, kForceColour);
    }
    return marks;
  }

  // The force at each held point in newtons, and a notice in front of the eyes while the connection is lost.
  texts(eye) {
    const plate = (text, at, half_m) => ({ text, at, halfRight_m: scaled(eye.right, half_m), halfUp_m: scaled(eye.down, (-56 / 512) * half_m) });
    const plates = this.host.held().map((one) => {
      const away = Math.max(0.3, length(subtract(one.point_m, eye.position)));
      return plate(`${number(length(one.force_n))} N  ${this.host.objectOf(one.object_id).name}`, add(one.point_m, scaled(eye.down, -0.06 * away)), 0.1 * away);
    });
    const notice = this.host.problem();
    if (notice) plates.push(plate(notice, add(eye.position, add(scaled(eye.forward, 1.2), scaled(eye.down, 0.25))), 0.4));
    return plates;
  }

  frame(time, frame) {
    const session = frame.session;
    if (session !== this.session) return;
    session.requestAnimationFrame((next, nextFrame) => this.frame(next, nextFrame));
    const now = performance.now(), gl = this.gl, renderer = this.host.renderer();
    this.adapt(now - this.lastFrame_ms);
    this.lastFrame_ms = now;
    const pose = frame.getViewerPose(this.base);
    if (!pose) return void this.letGo();
    if (!this.sceneFromLocal) this.place(pose);
    if (session.visibilityState === 'visible') this.sampleHands(frame);
    const views = pose.views.filter((view) => view.eye !== 'none' || pose.views.length === 1).slice(0, 2);
    for (const view of views) view.requestViewportScale?.(kScales[this.scale]);
    const viewports = views.map((view) => this.layer.getViewport(view));
    const eyes = views.map((view, i) => eyeOf(multiplied(this.sceneFromLocal, view.transform.matrix), view.projectionMatrix, viewports[i]));
    if (!eyes.length || !(viewports[0].width > 1)) return;
    const middle = scaled(eyes.reduce((sum, eye) => add(sum, eye.position), [0, 0, 0]), 1 / eyes.length);
    this.host.sendView({ position: middle, axis: eyes[0].forward, by_distance: true, half_angle_rad: 1.3 });
    renderer.prepare(eyes);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.layer.framebuffer);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    const marks = this.marks(), texts = this.texts(eyes[0]);
    views.forEach((view, i) => {
      const { x, y, width, height } = viewports[i];
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(x, y, width, height);
      const clipFromWorld = multiplied(view.projectionMatrix, multiplied(view.transform.inverse.matrix, this.localFromScene));
      renderer.drawEye(i, eyes[i], [x, y, width, height], clipFromWorld, marks);
      renderer.drawPlates(texts, clipFromWorld);
    });
    gl.disable(gl.SCISSOR_TEST);
    ++this.counts.frames;
  }
}
