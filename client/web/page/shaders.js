// SPDX-License-Identifier: Apache-2.0
// The shaders of the page, in GLSL ES 3.00. Each names its twin of the native client. Differences: storage
// buffers are textures, a compute invocation is a fragment, and `precise` does not exist. Products that must not
// be contracted or cancelled are multiplied by the uniform `one`, whose value a compiler cannot use.

import { limitDeformation, splatConstants, stretchLimit } from './native_shaders.js'; // generated (make_shaders)

export const kPoseWidth = 1024; // kernels in a row of the textures of poses and splats
export const kWordWidth = 4096; // texels in a row of all other textures

const head = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
const int kPoseWidth = ${kPoseWidth};
const int kWordShift = ${Math.log2(kWordWidth)};
uniform float one;
ivec2 placeOf(int i) { return ivec2(i & ((1 << kWordShift) - 1), i >> kWordShift); }
`;

// One triangle over the whole target. Twin: client/render/vulkan/resolve_eyes.vert.glsl.
export const coverVertex = `${head}
void main() {
  gl_Position = vec4(float((gl_VertexID & 1) * 4 - 1), float((gl_VertexID & 2) * 2 - 1), 0.0, 1.0);
}`;

const kernelHead = `
uniform usampler2D rest;   // RestKernelRow: five RG texels a kernel
uniform sampler2D drivers; // four texels a node or a body
uniform int base;          // global index of the first kernel
uniform int kernelCount;
uniform int driverCount;
layout(location = 0) out uvec4 pose0; // x y z sxx
layout(location = 1) out uvec4 pose1; // sxy sxz syy syz
layout(location = 2) out uvec4 pose2; // szz qx qy qz
layout(location = 3) out uvec4 pose3; // qw
struct Rest { uint driver; vec3 at; mat3 covariance; };
int kernelIndex() { return int(gl_FragCoord.y) * kPoseWidth + int(gl_FragCoord.x) - base; }
Rest restOf(int i) {
  uvec2 a = texelFetch(rest, placeOf(5 * i), 0).rg;
  vec2 b = uintBitsToFloat(texelFetch(rest, placeOf(5 * i + 1), 0).rg);
  vec2 c = uintBitsToFloat(texelFetch(rest, placeOf(5 * i + 2), 0).rg);
  vec2 d = uintBitsToFloat(texelFetch(rest, placeOf(5 * i + 3), 0).rg);
  vec2 e = uintBitsToFloat(texelFetch(rest, placeOf(5 * i + 4), 0).rg);
  return Rest(a.x, vec3(uintBitsToFloat(a.y), b), mat3(c.x, c.y, d.x, c.y, d.y, e.x, d.x, e.x, e.y));
}
void writePose(vec3 place, mat3 s, vec4 turn) {
  pose0 = floatBitsToUint(vec4(place, s[0][0]));
  pose1 = floatBitsToUint(vec4(s[1][0], s[2][0], s[1][1], s[2][1]));
  pose2 = floatBitsToUint(vec4(s[2][2], turn.xyz));
  pose3 = uvec4(floatBitsToUint(turn.w), 0u, 0u, 0u);
}
`;

// Twin: common/skin/kernels/skin_lattice.comp.glsl.
export const skinLatticeFragment = `${head}${kernelHead}
${stretchLimit}
${limitDeformation}
uniform usampler2D cells;  // two texels a cell
uniform int cellCount;
uniform float cellWidth_m;
uniform vec4 latticeFromAsset;  // x y z w
uniform mat3 bodyGradient;
vec4 nodeRow(int node, int row) { return texelFetch(drivers, placeOf(4 * node + row), 0); }
void main() {
  int i = kernelIndex();
  if (i < 0 || i >= kernelCount) discard;
  Rest k = restOf(i);
  int cell = int(min(k.driver, uint(cellCount - 1)));
  uvec4 low = texelFetch(cells, placeOf(2 * cell), 0);
  uvec4 high = texelFetch(cells, placeOf(2 * cell + 1), 0);
  vec3 at = clamp(k.at, 0.0, 1.0);
  vec3 beyond = 1.0 - at;
  vec3 position = vec3(0.0), dx = vec3(0.0), dy = vec3(0.0), dz = vec3(0.0);
  for (int corner = 0; corner < 8; ++corner) {
    float across = ((corner & 2) == 0 ? beyond.y : at.y) * ((corner & 4) == 0 ? beyond.z : at.z);
    float weight = one * (((corner & 1) == 0 ? beyond.x : at.x) * across);
    int node = int(min(corner < 4 ? low[corner] : high[corner - 4], uint(driverCount - 1)));
    position += one * (weight * nodeRow(node, 0).xyz);
    dx += one * (weight * nodeRow(node, 1).xyz);
    dy += one * (weight * nodeRow(node, 2).xyz);
    dz += one * (weight * nodeRow(node, 3).xyz);
  }
  LimitedDeformation limited = limit_deformation(mat3(dx, dy, dz));
  mat3 f = limited.gradient;
  vec3 offset = cellWidth_m * (k.at - at);
  // Outside its cell: the first cell width moves with F at that point, the rest with the mean F of the body.
  if (offset != vec3(0.0)) {
    float nearShare = min(1.0, cellWidth_m / length(offset));
    position += f * (nearShare * offset) + bodyGradient * ((1.0 - nearShare) * offset);
  }
  vec4 a = limited.rotation, b = latticeFromAsset;
  writePose(position, f * k.covariance * transpose(f),
            vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz)));
}`;

// Twin: common/skin/kernels/skin_rigid.comp.glsl.
export const skinRigidFragment = `${head}${kernelHead}
void main() {
  int i = kernelIndex();
  if (i < 0 || i >= kernelCount) discard;
  Rest k = restOf(i);
  int body = 4 * int(min(k.driver, uint(driverCount - 1)));
  vec4 row0 = texelFetch(drivers, placeOf(body), 0);
  vec4 row1 = texelFetch(drivers, placeOf(body + 1), 0);
  vec4 row2 = texelFetch(drivers, placeOf(body + 2), 0);
  mat3 turn = mat3(row0.xyz, row1.xyz, row2.xyz);  // the rotation transposed: v * turn is R v
  writePose(k.at * turn + vec3(row0.w, row1.w, row2.w), transpose(turn) * k.covariance * turn,
            texelFetch(drivers, placeOf(body + 3), 0));
}`;

// Twins: common/splat/passes/project_splats.comp.glsl, common/splat/project/precise.glsl and
// spherical_harmonics.glsl. Without shadows. Depth keys are made by the worker.
export const projectFragment = `${head}
uniform usampler2D pose0, pose1, pose2, pose3;
uniform usampler2D looks; // KernelLookRow: a texel a kernel
uniform usampler2D bands; // packed halves, a word a texel
uniform int base, kernelCount, shDegree, shRowWords;
uniform bool antialiased, hidden;
uniform vec2 slot; // index of the object; 1: it can be touched
uniform vec3 eyeAt_m, axisX, axisY, axisZ;
uniform vec4 lens;   // focal length and centre, px
uniform vec4 slopes; // least and most of the Jacobian, x and y
uniform vec2 size_px;
uniform float near_m, maxRadius_px, minContribution_log2;
layout(location = 0) out uvec4 splat0; // centre x y, across x y
layout(location = 1) out uvec4 splat1; // down y, log2 opacity, slot
layout(location = 2) out uvec4 splat2; // red green blue
const float kHalfLog2E = 0.72134752;
${splatConstants}

float product_error(float a, float b, float product) {
  float wide_a = one * (4097.0 * a);
  float high_a = wide_a - one * (wide_a - a);
  float low_a = one * (a - high_a);
  float wide_b = one * (4097.0 * b);
  float high_b = wide_b - one * (wide_b - b);
  float low_b = one * (b - high_b);
  return one * (one * (one * (high_a * high_b - product) + high_a * low_b) + low_a * high_b) + low_a * low_b;
}
float product_difference(float a, float b, float c, float d) {
  float first = one * (a * b);
  float second = one * (c * d);
  return one * (first - second) + one * (product_error(a, b, first) - product_error(c, d, second));
}
float log2_of(float x) {
  uint bits = floatBitsToUint(x);
  int exponent = int(bits >> 23) - 127;
  float m = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u);
  if (m > 1.41421356) {
    m *= 0.5;
    exponent += 1;
  }
  float s = (m - 1.0) / (m + 1.0);
  float ss = s * s;
  float series = 1.0 + ss * (0.333333333 + ss * (0.2 + ss * (0.142857143 + ss * 0.111111111)));
  return float(exponent) + 2.88539008 * s * series;
}
uint bandWord(int word) { return texelFetch(bands, placeOf(word), 0).r; }
vec3 bandsTowards(vec3 direction, int word) {
  float x = direction.x, y = direction.y, z = direction.z;
  float xx = x * x, yy = y * y, zz = z * z;
  float basis[16] = float[16](
      -0.48860251 * y, 0.48860251 * z, -0.48860251 * x,
      1.09254843 * x * y, -1.09254843 * y * z, 0.31539157 * (2.0 * zz - xx - yy), -1.09254843 * x * z,
      0.54627422 * (xx - yy),
      -0.59004359 * y * (3.0 * xx - yy), 2.89061144 * x * y * z, -0.45704580 * y * (4.0 * zz - xx - yy),
      0.37317633 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy), -0.45704580 * x * (4.0 * zz - xx - yy),
      1.44530572 * z * (xx - yy), -0.59004359 * x * (xx - 3.0 * yy), 0.0);
  int count = (shDegree + 1) * (shDegree + 1) - 1;
  vec3 sum = vec3(0.0);
  for (int b = 0; b < 15; b += 2) {
    if (b >= count) break;
    vec2 first = unpackHalf2x16(bandWord(word));
    vec2 middle = unpackHalf2x16(bandWord(word + 1));
    sum += basis[b] * vec3(first, middle.x);
    if (b + 1 < count) sum += basis[b + 1] * vec3(middle.y, unpackHalf2x16(bandWord(word + 2)));
    word += 3;
  }
  return sum;
}
void main() {
  int global = int(gl_FragCoord.y) * kPoseWidth + int(gl_FragCoord.x);
  int i = global - base;
  if (i < 0 || i >= kernelCount) discard;
  splat0 = uvec4(0u);
  splat1 = uvec4(0u, floatBitsToUint(kCulled_log2), 0u, 0u);
  splat2 = uvec4(0u);
  if (hidden) return;
  ivec2 place = ivec2(gl_FragCoord.xy);
  vec4 p0 = uintBitsToFloat(texelFetch(pose0, place, 0));
  vec3 offset = p0.xyz - eyeAt_m;
  float z = dot(axisZ, offset);
  if (!(z > near_m)) return;
  vec4 p1 = uintBitsToFloat(texelFetch(pose1, place, 0));
  vec4 p2 = uintBitsToFloat(texelFetch(pose2, place, 0));
  vec4 look = uintBitsToFloat(texelFetch(looks, placeOf(i), 0));
  float sxx = p0.w, sxy = p1.x, sxz = p1.y, syy = p1.z, syz = p1.w, szz = p2.x;
  mat3 s = mat3(sxx, sxy, sxz, sxy, syy, syz, sxz, syz, szz);
  float slope_x = dot(axisX, offset) / z;
  float slope_y = dot(axisY, offset) / z;
  vec3 row_x = (lens.x / z) * (axisX - clamp(slope_x, slopes.x, slopes.y) * axisZ);
  vec3 row_y = (lens.y / z) * (axisY - clamp(slope_y, slopes.z, slopes.w) * axisZ);
  vec3 across = s * row_x;
  float sharp_xx = dot(across, row_x);
  float sharp_yy = dot(s * row_y, row_y);
  float xy = dot(across, row_y);
  // Determinant of J S Jt by Cauchy-Binet: n adj(S) nt, with n the cross product of the rows.
  vec3 n = cross(row_x, row_y);
  float c_xx = product_difference(syy, szz, syz, syz), c_xy = product_difference(sxz, syz, sxy, szz);
  float c_xz = product_difference(sxy, syz, sxz, syy), c_yy = product_difference(sxx, szz, sxz, sxz);
  float c_yz = product_difference(sxy, sxz, sxx, syz), c_zz = product_difference(sxx, syy, sxy, sxy);
  vec3 spread_n = mat3(c_xx, c_xy, c_xz, c_xy, c_yy, c_yz, c_xz, c_yz, c_zz) * n;
  float sharp_det = max(0.0, dot(spread_n, n));
  float det = sharp_det + kSplatLowPass_px2 * (sharp_xx + sharp_yy) + kSplatLowPass_px2 * kSplatLowPass_px2;
  float xx = sharp_xx + kSplatLowPass_px2;
  float yy = sharp_yy + kSplatLowPass_px2;
  if (!(det > 0.0 && det < 1e37 && xx > 0.0 && yy > 0.0)) return;
  float log2_opacity = look.x;
  if (near_m > 0.0 && z < 3.0 * near_m) log2_opacity += log2_of((z - near_m) / (2.0 * near_m));
  if (antialiased) {
    if (!(sharp_det > 0.0)) return;
    log2_opacity += 0.5 * log2_of(sharp_det / det);
  }
  if (!(log2_opacity >= -kSplatLog2Of255)) return;
  float rim = (log2_opacity + kSplatLog2Of255) / kHalfLog2E;  // of the ellipse where alpha is 1/255
  if (maxRadius_px > 0.0) {
    float half_gap = 0.5 * (xx - yy);
    float longest = rim * (0.5 * (xx + yy) + sqrt(half_gap * half_gap + xy * xy));
    float most = maxRadius_px * maxRadius_px;
    if (longest > most) {
      float shrink = most / longest;
      xx *= shrink;
      xy *= shrink;
      yy *= shrink;
      det *= shrink * shrink;
    }
  }
  if (minContribution_log2 > kCulled_log2 &&
      log2_opacity + 0.5 * log2_of(det) + kLog2OfTwoPi < minContribution_log2) return;
  vec2 centre = lens.xy * vec2(slope_x, slope_y) + lens.zw;
  vec2 reach = sqrt(rim * vec2(xx, yy));
  if (!(all(greaterThanEqual(centre + reach, vec2(0.0))) && all(lessThanEqual(centre - reach, size_px)))) return;
  float scale = sqrt(kHalfLog2E), root_yy = sqrt(yy), root_det = sqrt(det);
  vec3 colour = vec3(0.5) + 0.28209479 * look.yzw;
  if (shDegree > 0) {
    vec3 axis = -p2.yzw;
    vec3 twice = 2.0 * cross(axis, offset);
    float w = uintBitsToFloat(texelFetch(pose3, place, 0).r);
    colour += bandsTowards(normalize(offset + w * twice + cross(axis, twice)), i * shRowWords);
  }
  splat0 = floatBitsToUint(vec4(centre, scale * (root_yy / root_det), -scale * (xy / (root_yy * root_det))));
  splat1 = floatBitsToUint(vec4(scale / root_yy, log2_opacity, slot));
  splat2 = floatBitsToUint(vec4(max(colour, vec3(0.0)), 0.0));
}`;

// Twin: client/render/vulkan/draw_splats.vert.glsl. One splat per instance, nearest first: the parallelogram
// around the ellipse at whose rim alpha is 1/255.
export const drawVertex = `${head}
layout(location = 0) in uint place;
uniform usampler2D splat0, splat1, splat2;
uniform vec4 viewport_px;
uniform int rows; // of the splat textures
uniform bool picks;
flat out vec4 centre_across;
flat out vec4 colour_log2_opacity;
flat out float down_y;
${splatConstants}
void main() {
  ivec2 at = ivec2(int(place) % kPoseWidth, int(place) / kPoseWidth);
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  centre_across = vec4(0.0);
  colour_log2_opacity = vec4(0.0);
  down_y = 0.0;
  if (at.y < 0 || at.y >= rows) return;
  vec4 b = uintBitsToFloat(texelFetch(splat1, at, 0));
  float rim = b.y + kSplatLog2Of255;
  if (!(rim > 0.0)) return;
  vec4 a = uintBitsToFloat(texelFetch(splat0, at, 0));
  centre_across = a;
  // A pick adds up the share of objects that can be touched, and their slots.
  vec3 colour = picks ? vec3(b.w, b.w * b.z, 0.0) : uintBitsToFloat(texelFetch(splat2, at, 0).rgb);
  colour_log2_opacity = vec4(colour, b.y);
  down_y = b.x;
  float reach = sqrt(rim) + 1e-3;
  float u = (gl_VertexID & 1) == 0 ? -reach : reach;
  float v = (gl_VertexID & 2) == 0 ? -reach : reach;
  float dy = v / b.x;
  float dx = (u - a.w * dy) / a.z;
  vec2 ndc = 2.0 * (a.xy + vec2(dx, dy)) / viewport_px.zw - 1.0;
  gl_Position = vec4(ndc.x, -ndc.y, 0.0, 1.0);
}`;

// Twin: client/render/vulkan/draw_splats.frag.glsl.
export const drawFragment = `${head}
uniform vec4 viewport_px;
flat in vec4 centre_across;
flat in vec4 colour_log2_opacity;
flat in float down_y;
layout(location = 0) out vec4 premultiplied;
void main() {
  vec2 at = gl_FragCoord.xy - viewport_px.xy;
  vec2 d = vec2(at.x, viewport_px.w - at.y) - centre_across.xy;
  float u = centre_across.z * d.x + centre_across.w * d.y;
  float v = down_y * d.y;
  float alpha = min(0.99, exp2(colour_log2_opacity.w - v * v - u * u));
  if (alpha < 1.0 / 255.0) discard;
  premultiplied = vec4(alpha * colour_log2_opacity.rgb, alpha);
}`;

// Twin: client/render/vulkan/resolve_eyes.frag.glsl; the canvas is display-encoded, so nothing is decoded.
export const resolveFragment = `${head}
uniform sampler2D blended;
uniform vec3 background;
layout(location = 0) out vec4 encoded;
void main() {
  vec4 sum = texelFetch(blended, ivec2(gl_FragCoord.xy), 0);
  encoded = vec4(clamp(sum.rgb + (1.0 - sum.a) * background, 0.0, 1.0), 1.0);
}`;

// One colour: the background behind blended splats, and the marks of hands.
export const plainFragment = `${head}
uniform vec4 colour;
layout(location = 0) out vec4 premultiplied;
void main() { premultiplied = vec4(colour.rgb * colour.a, colour.a); }`;

// A segment with a width in metres that faces the eye: rays and arrows in a headset.
export const markVertex = `${head}
uniform mat4 clipFromWorld;
uniform vec3 from_m, to_m, eyeAt_m;
uniform vec2 halfWidth_m; // at both ends
void main() {
  vec3 at = (gl_VertexID & 1) == 0 ? from_m : to_m;
  vec3 side = cross(to_m - from_m, at - eyeAt_m);
  float width = (gl_VertexID & 1) == 0 ? halfWidth_m.x : halfWidth_m.y;
  at += ((gl_VertexID & 2) == 0 ? -width : width) * side / max(length(side), 1e-9);
  gl_Position = clipFromWorld * vec4(at, 1.0);
}`;

// A text on a plate in the scene, for a headset.
export const plateVertex = `${head}
uniform mat4 clipFromWorld;
uniform vec3 at_m, halfRight_m, halfUp_m;
out vec2 place;
void main() {
  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));
  place = vec2(corner.x, 1.0 - corner.y);
  corner = 2.0 * corner - 1.0;
  gl_Position = clipFromWorld * vec4(at_m + corner.x * halfRight_m + corner.y * halfUp_m, 1.0);
}`;
export const plateFragment = `${head}
uniform sampler2D words;
in vec2 place;
layout(location = 0) out vec4 premultiplied;
void main() { premultiplied = texture(words, place); }`;
