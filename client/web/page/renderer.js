// SPDX-License-Identifier: Apache-2.0
// Draws posed splats with WebGL2. A kernel has one texel in the textures of poses and splats, at its global index:
//   skin     once for each object that moved: position, covariance and rotation of its kernels
//   project  once an eye: the screen ellipse and the colour of each kernel, as SplatRow of the native client
//   draw     once an eye: an instanced quad a kernel, nearest first, blended under what is there
// Poses are RGBA32UI, which needs no extension. Shadows are not drawn in this version.
import * as shaders from './shaders.js';

const { kPoseWidth, kWordWidth } = shaders;
export const kBackground = [0.08, 0.08, 0.1]; // client/render/scene_view.h
const kCulled_log2 = -1000;
const kPlate_px = [512, 56];

// Projection of one eye for the shaders; image axes are x right, y down, z forward (twin of Projection).
export function makeEye({ position, right, down, forward, focal, centre, size, near_m = 0.05, maxRadius_px = 2 * Math.max(...size) }) {
  const beyond = [0.15 * size[0], 0.15 * size[1]];
  const slopes = [];
  for (const a of [0, 1]) slopes.push(-(centre[a] + beyond[a]) / focal[a], (size[a] - centre[a] + beyond[a]) / focal[a]);
  return { position, right, down, forward, focal, centre, size, near_m, maxRadius_px, slopes, minContribution_px: 0 };
}

class Program {
  constructor(gl, vertex, fragment) {
    this.gl = gl;
    this.handle = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.handle, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
    }
    gl.linkProgram(this.handle);
    if (!gl.getProgramParameter(this.handle, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(`program: ${gl.getProgramInfoLog(this.handle)}`);
    this.places = new Map();
  }
  at(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.handle, name));
    return this.places.get(name);
  }
  use(textures) {
    const gl = this.gl;
    gl.useProgram(this.handle);
    gl.uniform1f(this.at('one'), 1);
    Object.entries(textures).forEach(([name, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(this.at(name), unit);
    });
    return this;
  }
}

export class Renderer {
  constructor(gl) {
    this.gl = gl;
    this.objects = new Map(); // by id: GPU data of its kernels
    this.rows = 0; // of the pose and splat textures
    this.count = 0; // of the order
    this.background = kBackground;
    this.half = gl.getExtension('EXT_color_buffer_float') || gl.getExtension('EXT_color_buffer_half_float');
    gl.getExtension('EXT_float_blend');
    this.programs = {
      lattice: new Program(gl, shaders.coverVertex, shaders.skinLatticeFragment),
      rigid: new Program(gl, shaders.coverVertex, shaders.skinRigidFragment),
      project: new Program(gl, shaders.coverVertex, shaders.projectFragment),
      draw: new Program(gl, shaders.drawVertex, shaders.drawFragment),
      resolve: new Program(gl, shaders.coverVertex, shaders.resolveFragment),
      cover: new Program(gl, shaders.coverVertex, shaders.plainFragment),
      mark: new Program(gl, shaders.markVertex, shaders.plainFragment),
      plate: new Program(gl, shaders.plateVertex, shaders.plateFragment),
    };
    this.plainArray = gl.createVertexArray();
    this.orderArray = gl.createVertexArray();
    this.orderBuffer = gl.createBuffer();
    gl.bindVertexArray(this.orderArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.orderBuffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribIPointer(0, 1, gl.UNSIGNED_INT, 0, 0);
    gl.vertexAttribDivisor(0, 1);
    gl.bindVertexArray(null);
    this.splats = []; // per eye
    this.blend = null;
    this.pickTarget = null;
    this.plates = []; // textures of texts, and their texts
  }

  texture(format, width, height) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    return texture;
  }

  target(format, width, height, count) {
    const gl = this.gl, textures = [], attachments = [];
    const framebuffer = gl.createFramebuffer();
    for (let i = 0; i < count; ++i) textures.push(this.texture(format, width, height));
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    textures.forEach((texture, i) => {
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
      attachments.push(gl.COLOR_ATTACHMENT0 + i);
    });
    gl.drawBuffers(attachments);
    return { framebuffer, textures, width, height };
  }

  drop(target) {
    if (!target) return;
    target.textures.forEach((texture) => this.gl.deleteTexture(texture));
    this.gl.deleteFramebuffer(target.framebuffer);
  }

  // A texture that holds `data` in rows of kWordWidth texels of `channels` words. Reuses `old` of the same size.
  fill(old, data, channels, isFloat) {
    const gl = this.gl;
    const [format, layout, type] = isFloat ? [gl.RGBA32F, gl.RGBA, gl.FLOAT]
      : channels === 1 ? [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT]
        : channels === 2 ? [gl.RG32UI, gl.RG_INTEGER, gl.UNSIGNED_INT] : [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT];
    const texels = Math.floor(data.length / channels), rows = Math.floor(texels / kWordWidth), rest = texels % kWordWidth;
    const height = Math.max(1, Math.ceil(texels / kWordWidth)), width = height === 1 ? Math.max(1, texels) : kWordWidth;
    if (old && (old.height !== height || old.width !== width)) {
      gl.deleteTexture(old.texture);
      old = null;
    }
    const filled = old ?? { texture: this.texture(format, width, height), width, height };
    gl.bindTexture(gl.TEXTURE_2D, filled.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (rows > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, kWordWidth, rows, layout, type, data, 0);
    if (rest > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, rows, rest, 1, layout, type, data, rows * kWordWidth * channels);
    return filled;
  }

  // Static data of an object, in the layouts of the message 'kernels'.
  setKernels(m) {
    const old = this.objects.get(m.id);
    const object = { ...old, base: m.base, count: m.count, degree: m.sh_degree, antialiased: m.antialiased, lattice: m.lattice, dirty: true };
    object.slot = old?.slot ?? this.freeSlot();
    object.shRowWords = Math.ceil((3 * ((m.sh_degree + 1) ** 2 - 1)) / 2);
    object.rest = this.fill(old?.rest, m.rest, 2, false);
    object.looks = this.fill(old?.looks, m.looks, 4, false);
    object.bands = this.fill(old?.bands, m.bands?.length ? m.bands : new Uint32Array(1), 1, false);
    object.cells = m.cells?.length ? this.fill(old?.cells, m.cells, 4, false) : null;
    this.objects.set(m.id, object);
    const rows = Math.ceil((m.base + m.count) / kPoseWidth);
    if (rows > this.rows) this.resizePoses(rows);
  }

  freeSlot() {
    const used = new Set([...this.objects.values()].map((object) => object.slot));
    let slot = 0;
    while (used.has(slot)) ++slot;
    return slot;
  }

  idOfSlot(slot) {
    for (const [id, object] of this.objects) if (object.slot === slot) return id;
    return null;
  }

  resizePoses(rows) {
    this.rows = rows;
    this.drop(this.poses);
    this.poses = this.target(this.gl.RGBA32UI, kPoseWidth, rows, 4);
    this.splats.forEach((splats) => this.drop(splats));
    this.splats = [];
    for (const object of this.objects.values()) object.dirty = true;
  }

  remove(id) {
    const object = this.objects.get(id);
    if (!object) return;
    for (const held of [object.rest, object.looks, object.bands, object.cells, object.drivers]) if (held) this.gl.deleteTexture(held.texture);
    this.objects.delete(id);
  }

  setDrivers(id, rows, bodyGradient) {
    const object = this.objects.get(id);
    if (!object) return;
    object.drivers = this.fill(object.drivers, rows, 4, true);
    object.driverCount = rows.length / 16;
    if (bodyGradient) object.gradient = bodyGradient;
    object.dirty = true;
  }

  // `order`: nearest first. A headset's layer has 8 bits, where blending over from the farthest is more exact, so its
  // order is reversed here, in place.
  setOrder(order, count, farthestFirst) {
    const gl = this.gl, drawn = order.subarray(0, count);
    if (farthestFirst) drawn.reverse();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.orderBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, drawn, gl.STREAM_DRAW);
    Object.assign(this, { count, farthestFirst });
  }

  // Draws a texel for each kernel of an object: the rows of the target that it covers.
  coverKernels(object) {
    const gl = this.gl, first = Math.floor(object.base / kPoseWidth), last = Math.floor((object.base + object.count - 1) / kPoseWidth);
    gl.scissor(0, first, kPoseWidth, last - first + 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  toKernels(target) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.viewport(0, 0, target.width, target.height);
    gl.disable(gl.BLEND);
    gl.enable(gl.SCISSOR_TEST);
    gl.bindVertexArray(this.plainArray);
  }

  skin() {
    const gl = this.gl, moved = [...this.objects.values()].filter((o) => o.dirty && o.drivers && o.count > 0);
    if (!moved.length) return;
    this.toKernels(this.poses);
    for (const object of moved) {
      object.dirty = false;
      const lattice = object.lattice;
      const program = (lattice ? this.programs.lattice : this.programs.rigid).use({
        rest: object.rest.texture, drivers: object.drivers.texture, ...(lattice ? { cells: object.cells.texture } : {}) });
      gl.uniform1i(program.at('base'), object.base);
      gl.uniform1i(program.at('kernelCount'), object.count);
      gl.uniform1i(program.at('driverCount'), object.driverCount);
      if (lattice) {
        gl.uniform1i(program.at('cellCount'), lattice.cell_count);
        gl.uniform1f(program.at('cellWidth_m'), lattice.cell_width_m);
        gl.uniform4fv(program.at('latticeFromAsset'), lattice.lattice_from_asset);
        gl.uniformMatrix3fv(program.at('bodyGradient'), true, object.gradient ?? lattice.body_gradient); // by rows
      }
      this.coverKernels(object);
    }
  }

  project(eye, index) {
    const gl = this.gl;
    this.splats[index] ??= this.target(gl.RGBA32UI, kPoseWidth, this.rows, 3);
    this.toKernels(this.splats[index]);
    const [pose0, pose1, pose2, pose3] = this.poses.textures;
    for (const object of this.objects.values()) {
      if (!object.drivers || object.count === 0) continue;
      const program = this.programs.project.use({ pose0, pose1, pose2, pose3, looks: object.looks.texture, bands: object.bands.texture });
      const vec3 = (name, v) => gl.uniform3f(program.at(name), v[0], v[1], v[2]);
      gl.uniform1i(program.at('base'), object.base);
      gl.uniform1i(program.at('kernelCount'), object.count);
      gl.uniform1i(program.at('shDegree'), object.degree);
      gl.uniform1i(program.at('shRowWords'), object.shRowWords);
      gl.uniform1i(program.at('antialiased'), object.antialiased ? 1 : 0);
      gl.uniform1i(program.at('hidden'), object.hidden ? 1 : 0);
      gl.uniform2f(program.at('slot'), (object.slot + 1) / 256, object.environment ? 0 : 1);
      vec3('eyeAt_m', eye.position);
      vec3('axisX', eye.right);
      vec3('axisY', eye.down);
      vec3('axisZ', eye.forward);
      gl.uniform4f(program.at('lens'), ...eye.focal, ...eye.centre);
      gl.uniform4fv(program.at('slopes'), eye.slopes);
      gl.uniform2f(program.at('size_px'), ...eye.size);
      gl.uniform1f(program.at('near_m'), eye.near_m);
      gl.uniform1f(program.at('maxRadius_px'), eye.maxRadius_px);
      gl.uniform1f(program.at('minContribution_log2'), eye.minContribution_px > 0 ? Math.log2(eye.minContribution_px) : kCulled_log2);
      this.coverKernels(object);
    }
  }

  // Poses what moved and projects it for all eyes. Call before draw(), outside of the headset's framebuffer.
  prepare(eyes) {
    if (this.count === 0 || !this.poses) return;
    this.skin();
    eyes.forEach((eye, i) => this.project(eye, i));
    this.gl.disable(this.gl.SCISSOR_TEST);
  }

  // Blends the splats of an eye into the bound framebuffer. Nearest first: under what is there, at first nothing.
  // Farthest first: over what is there.
  blendSplats(index, viewport, picks) {
    const gl = this.gl;
    gl.enable(gl.BLEND);
    if (this.farthestFirst) gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    else gl.blendFunc(gl.ONE_MINUS_DST_ALPHA, gl.ONE);
    const splats = this.splats[index];
    if (this.count === 0 || !splats) return;
    const [splat0, splat1, splat2] = splats.textures;
    const program = this.programs.draw.use({ splat0, splat1, splat2 });
    gl.uniform4f(program.at('viewport_px'), ...viewport);
    gl.uniform1i(program.at('rows'), this.rows);
    gl.uniform1i(program.at('picks'), picks ? 1 : 0);
    gl.bindVertexArray(this.orderArray);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
    gl.bindVertexArray(this.plainArray);
  }

  // Draws a picture for a window: blended in 16-bit floats, then resolved over the background.
  drawWindow(eye) {
    const gl = this.gl, [width, height] = eye.size;
    if (!this.blend || this.blend.width !== width || this.blend.height !== height) {
      this.drop(this.blend);
      this.blend = this.target(this.half ? gl.RGBA16F : gl.RGBA8, width, height, 1);
    }
    this.prepare([eye]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.blend.framebuffer);
    gl.viewport(0, 0, width, height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    this.blendSplats(0, [0, 0, width, height], false);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.disable(gl.BLEND);
    gl.bindVertexArray(this.plainArray);
    const program = this.programs.resolve.use({ blended: this.blend.textures[0] });
    gl.uniform3fv(program.at('background'), this.background);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Draws one eye of a headset straight into its layer, which the caller has bound and cleared to zero: splats with
  // the background under them, then the marks over both.
  drawEye(index, eye, viewport, clipFromWorld, marks) {
    const gl = this.gl;
    const cover = () => {
      gl.bindVertexArray(this.plainArray);
      gl.uniform4f(this.programs.cover.use({}).at('colour'), ...this.background, 1);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    };
    gl.viewport(...viewport);
    gl.disable(gl.BLEND);
    if (this.farthestFirst) cover();
    this.blendSplats(index, viewport, false);
    if (!this.farthestFirst) cover();
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const program = this.programs.mark.use({});
    gl.uniformMatrix4fv(program.at('clipFromWorld'), false, clipFromWorld);
    gl.uniform3fv(program.at('eyeAt_m'), eye.position);
    for (const mark of marks) {
      gl.uniform3fv(program.at('from_m'), mark.from);
      gl.uniform3fv(program.at('to_m'), mark.to);
      gl.uniform2fv(program.at('halfWidth_m'), mark.halfWidth_m);
      gl.uniform4fv(program.at('colour'), mark.colour);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    gl.disable(gl.BLEND);
  }

  // Draws texts: [{ text, at, halfRight_m, halfUp_m }]. The sides of a plate are as kPlate_px.
  drawPlates(plates, clipFromWorld) {
    const gl = this.gl;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(this.plainArray);
    plates.forEach((plate, i) => {
      const held = (this.plates[i] ??= { texture: this.texture(gl.RGBA8, ...kPlate_px), text: '' });
      if (held.text !== plate.text) this.write(held, plate.text);
      const program = this.programs.plate.use({ words: held.texture });
      gl.uniformMatrix4fv(program.at('clipFromWorld'), false, clipFromWorld);
      gl.uniform3fv(program.at('at_m'), plate.at);
      gl.uniform3fv(program.at('halfRight_m'), plate.halfRight_m);
      gl.uniform3fv(program.at('halfUp_m'), plate.halfUp_m);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    });
    gl.disable(gl.BLEND);
  }

  write(plate, text) {
    const gl = this.gl, [width, height] = kPlate_px;
    this.paper ??= Object.assign(document.createElement('canvas'), { width, height });
    const pen = this.paper.getContext('2d');
    pen.clearRect(0, 0, width, height);
    pen.fillStyle = 'rgb(16 18 22 / 85%)';
    pen.fillRect(0, 0, width, height);
    pen.fillStyle = '#ffbe5a';
    pen.font = '600 34px system-ui, sans-serif';
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.fillText(text, width / 2, height / 2, width - 24);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, plate.texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, this.paper);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    plate.text = text;
  }

  // The object that has most of a pixel's light, if more than half of it is of objects that can be touched; else
  // null. Waits for the GPU, so only for clicks. The eye is that of the last picture.
  pick(eye, x_px, y_px) {
    const gl = this.gl;
    this.pickTarget ??= this.target(this.half ? gl.RGBA16F : gl.RGBA8, 1, 1, 1);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pickTarget.framebuffer);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    const corner = [-Math.floor(x_px), -(eye.size[1] - 1 - Math.floor(y_px))];
    gl.viewport(...corner, ...eye.size);
    this.blendSplats(0, [...corner, ...eye.size], true);
    gl.disable(gl.BLEND);
    const sum = this.half ? new Float32Array(4) : new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, this.half ? gl.FLOAT : gl.UNSIGNED_BYTE, sum);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const scale = this.half ? 1 : 1 / 255;
    return sum[0] * scale > 0.5 ? this.idOfSlot(Math.round((256 * sum[1]) / sum[0]) - 1) : null;
  }
}
