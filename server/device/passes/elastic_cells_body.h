// SPDX-License-Identifier: GPL-3.0-or-later

// Body of the pass elastic_cells, for GLSL and C++ (shader_math.h): one cell of the sweep, as solve_cut of
// server/physics/elastic/cells/kernels/cell_kernels.cpp, whose comments have the equations. A full cell is a
// cut cell with the constants of full cells.
//
// A row of constants: centroid (3), mobility G (6), mode coupling (4 x 3). A row of gains: H (21, upper
// triangle by rows, Mandel), volume compliance (1), mode gains (4 x 3).

// A pair of corners along one axis: sum and difference.
LIVEGS_SHARED_BODY void butterfly(LIVEGS_INOUT(vec3) low, LIVEGS_INOUT(vec3) high) {
  const vec3 a = low, b = high;
  low = a + b;
  high = b - a;
}
// The inverse, without the factor 1/2.
LIVEGS_SHARED_BODY void butterfly_back(LIVEGS_INOUT(vec3) low, LIVEGS_INOUT(vec3) high) {
  const vec3 a = low, b = high;
  low = a - b;
  high = a + b;
}

LIVEGS_SHARED_BODY mat3 turn_of(vec4 q) {
  const float x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const float xx = q.x * x2, yy = q.y * y2, zz = q.z * z2, xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const float wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  return mat3(vec3(1.0f - yy - zz, xy + wz, xz - wy), vec3(xy - wz, 1.0f - xx - zz, yz + wx),
              vec3(xz + wy, yz - wx, 1.0f - xx - yy));
}

LIVEGS_SHARED_BODY float determinant_of(mat3 m) { return dot(m[0], cross(m[1], m[2])); }

// Rotates q so that m = R^T F becomes more symmetric; returns the angle (turn in cell_algebra.h).
LIVEGS_SHARED_BODY float turn_towards(LIVEGS_INOUT(vec4) q, mat3 m) {
  const vec3 tau = vec3(m[1].z - m[2].y, m[2].x - m[0].z, m[0].y - m[1].x);
  const float k00 = m[1].y + m[2].z, k11 = m[0].x + m[2].z, k22 = m[0].x + m[1].y;
  const float k12 = -0.5f * (m[2].y + m[1].z), k02 = -0.5f * (m[2].x + m[0].z),
              k01 = -0.5f * (m[1].x + m[0].y);
  const float a00 = k11 * k22 - k12 * k12, a01 = k02 * k12 - k01 * k22, a02 = k01 * k12 - k02 * k11;
  const float a11 = k00 * k22 - k02 * k02, a12 = k01 * k02 - k00 * k12, a22 = k00 * k11 - k01 * k01;
  const float det = k00 * a00 + k01 * a01 + k02 * a02;
  vec3 w;
  if (k00 > 0.1f && a22 > 0.01f && det > 0.001f) {
    w = (1.0f / det) * vec3(a00 * tau.x + a01 * tau.y + a02 * tau.z, a01 * tau.x + a11 * tau.y + a12 * tau.z,
                            a02 * tau.x + a12 * tau.y + a22 * tau.z);
  } else if (dot(tau, tau) < 1e-8f && determinant_of(m) > 0.01f) {
    w = vec3(0.01f, 0.02f, 0.03f);  // half a turn away: no torque
  } else {
    w = (1.0f / (abs(m[0].x + m[1].y + m[2].z) + 1e-3f)) * tau;
  }
  const float angle = length(w);
  w = (angle > 0.5f ? 0.5f * (0.5f / angle) : 0.5f) * w;
  const vec4 n = vec4(q.x + q.w * w.x + q.y * w.z - q.z * w.y, q.y + q.w * w.y + q.z * w.x - q.x * w.z,
                      q.z + q.w * w.z + q.x * w.y - q.y * w.x, q.w - q.x * w.x - q.y * w.y - q.z * w.z);
  q = inverse_root(dot(n, n)) * n;
  return angle;
}

// sym(s G) in Mandel's notation; G starts at `at` of the constants.
LIVEGS_SHARED_BODY void times_mobility(float s[6], uint at, LIVEGS_INOUT(vec3) normal,
                                       LIVEGS_INOUT(vec3) shear) {
  const float half_root = 0.70710678f;
  const float yz = s[3] * half_root, xz = s[4] * half_root, xy = s[5] * half_root;
  const vec3 row0 = vec3(s[0], xy, xz), row1 = vec3(xy, s[1], yz), row2 = vec3(xz, yz, s[2]);
  const vec3 col0 = vec3(rows[at], rows[at + 5u], rows[at + 4u]),
             col1 = vec3(rows[at + 5u], rows[at + 1u], rows[at + 3u]),
             col2 = vec3(rows[at + 4u], rows[at + 3u], rows[at + 2u]);
  normal = vec3(dot(row0, col0), dot(row1, col1), dot(row2, col2));
  shear = half_root * vec3(dot(row1, col2) + dot(row2, col1), dot(row0, col2) + dot(row2, col0),
                           dot(row0, col1) + dot(row1, col0));
}

LIVEGS_SHARED_BODY float times_row(float s[6], float a, float b, float c, float d, float e, float f) {
  return a * s[0] + b * s[1] + c * s[2] + d * s[3] + e * s[4] + f * s[5];
}

// H s; H starts at `at` of the gains.
LIVEGS_SHARED_BODY void times_shear(float s[6], uint at, LIVEGS_INOUT(vec3) normal,
                                    LIVEGS_INOUT(vec3) shear) {
  normal = vec3(
      times_row(s, gains[at], gains[at + 1u], gains[at + 2u], gains[at + 3u], gains[at + 4u], gains[at + 5u]),
      times_row(s, gains[at + 1u], gains[at + 6u], gains[at + 7u], gains[at + 8u], gains[at + 9u],
                gains[at + 10u]),
      times_row(s, gains[at + 2u], gains[at + 7u], gains[at + 11u], gains[at + 12u], gains[at + 13u],
                gains[at + 14u]));
  shear = vec3(times_row(s, gains[at + 3u], gains[at + 8u], gains[at + 12u], gains[at + 15u], gains[at + 16u],
                         gains[at + 17u]),
               times_row(s, gains[at + 4u], gains[at + 9u], gains[at + 13u], gains[at + 16u], gains[at + 18u],
                         gains[at + 19u]),
               times_row(s, gains[at + 5u], gains[at + 10u], gains[at + 14u], gains[at + 17u],
                         gains[at + 19u], gains[at + 20u]));
}

LIVEGS_SHARED_BODY vec3 mode_gain(uint at, uint mode) {
  return vec3(gains[at + 22u + 3u * mode], gains[at + 23u + 3u * mode], gains[at + 24u + 3u * mode]);
}
LIVEGS_SHARED_BODY vec3 mode_coupling(uint at, uint mode) {
  return vec3(rows[at + 9u + 3u * mode], rows[at + 10u + 3u * mode], rows[at + 11u + 3u * mode]);
}
LIVEGS_SHARED_BODY vec3 times_each(vec3 a, vec3 b) { return vec3(a.x * b.x, a.y * b.y, a.z * b.z); }

LIVEGS_SHARED_BODY void solve_cell(uint i, uint step, uint rank, uint rank_count, uint row_count) {
  const uint body = cells[i].body;
  if (step >= bodies[body].steps) return;
  if (cells[i].rank != (bodies[body].backward != 0u ? rank_count - 1u - rank : rank)) return;
  const uint at = cells[i].constants * kCellConstants;
  const uint gain =
      ((2u * bodies[body].gains + bodies[body].second_order) * row_count + cells[i].constants) * kCellGains;
  const float q4 = bodies[body].inverse_four_widths;

  vec3 h[8];
  for (int c = 0; c < 8; ++c) {
    const uint node = cells[i].nodes[c];
    h[c] = vec3(solve[node].predicted) + vec3(solve[node].swept);
  }
  butterfly(h[0], h[1]);
  butterfly(h[2], h[3]);
  butterfly(h[4], h[5]);
  butterfly(h[6], h[7]);
  butterfly(h[0], h[2]);
  butterfly(h[1], h[3]);
  butterfly(h[4], h[6]);
  butterfly(h[5], h[7]);
  butterfly(h[0], h[4]);
  butterfly(h[1], h[5]);
  butterfly(h[2], h[6]);
  butterfly(h[3], h[7]);
  const vec3 xi = vec3(rows[at], rows[at + 1u], rows[at + 2u]);
  const float yz = xi.y * xi.z, xz = xi.x * xi.z, xy = xi.x * xi.y;
  const mat3 f = mat3(q4 * (h[1] + xi.y * h[3] + xi.z * h[5] + yz * h[7]),
                      q4 * (h[2] + xi.x * h[3] + xi.z * h[6] + xz * h[7]),
                      q4 * (h[4] + xi.x * h[5] + xi.y * h[6] + xy * h[7]));

  vec4 q = rotations[i];
  mat3 r = turn_of(q), m = transpose(r) * f;
  for (int k = 0; k < 8; ++k) {
    const float angle = turn_towards(q, m);
    r = turn_of(q);
    m = transpose(r) * f;
    if (!(angle > 0.05f)) break;
  }
  rotations[i] = q;

  const float half_root = 0.70710678f, root = 1.41421356f;
  float s[6], lack[6];
  s[0] = m[0].x;
  s[1] = m[1].y;
  s[2] = m[2].z;
  s[3] = half_root * (m[2].y + m[1].z);
  s[4] = half_root * (m[2].x + m[0].z);
  s[5] = half_root * (m[1].x + m[0].y);
  float strain = 0.0f;
  for (int k = 0; k < 6; ++k) {
    lack[k] = (k < 3 ? 1.0f : 0.0f) - s[k];
    strain += lack[k] * lack[k];
  }
  const float volume = determinant_of(m);

  vec3 d_normal = vec3(0.0f), d_shear = vec3(0.0f), normal = vec3(0.0f), shear = vec3(0.0f);
  times_shear(lack, gain, d_normal, d_shear);
  float d[6];
  for (int k = 0; k < 3; ++k) {
    d[k] = d_normal[k];
    d[k + 3] = d_shear[k];
  }
  times_mobility(d, at + 3u, normal, shear);
  float s1[6];
  for (int k = 0; k < 3; ++k) {
    s1[k] = s[k] + normal[k];
    s1[k + 3] = s[k + 3] + shear[k];
  }
  const float syz = s1[3] * half_root, sxz = s1[4] * half_root, sxy = s1[5] * half_root;
  float c[6];
  c[0] = s1[1] * s1[2] - syz * syz;
  const float c01 = sxz * syz - sxy * s1[2], c02 = sxy * syz - s1[1] * sxz;
  const float det = s1[0] * c[0] + sxy * c01 + sxz * c02;
  c[1] = s1[0] * s1[2] - sxz * sxz;
  c[2] = s1[0] * s1[1] - sxy * sxy;
  c[3] = root * (sxy * sxz - s1[0] * syz);
  c[4] = root * c02;
  c[5] = root * c01;
  times_mobility(c, at + 3u, normal, shear);
  float ac[6];
  for (int k = 0; k < 3; ++k) {
    ac[k] = normal[k];
    ac[k + 3] = shear[k];
  }
  times_shear(ac, gain, normal, shear);
  float c_ac = 0.0f, ac_hac = 0.0f;
  for (int k = 0; k < 3; ++k) {
    c_ac += c[k] * ac[k] + c[k + 3] * ac[k + 3];
    ac_hac += ac[k] * normal[k] + ac[k + 3] * shear[k];
  }
  const float p = (1.0f - det) / (c_ac - ac_hac + gains[gain + 21u]);
  float sigma[6];
  for (int k = 0; k < 3; ++k) {
    sigma[k] = d[k] + p * (c[k] - normal[k]);
    sigma[k + 3] = d[k + 3] + p * (c[k + 3] - shear[k]);
  }
  const float tyz = sigma[3] * half_root, txz = sigma[4] * half_root, txy = sigma[5] * half_root;
  const mat3 stress = mat3(vec3(sigma[0], txy, txz), vec3(txy, sigma[1], tyz), vec3(txz, tyz, sigma[2]));

  // Modes yz, xz, xy, xyz: amplitudes after the strain update, in the rotated frame, and their forces.
  const mat3 back = transpose(r);
  const vec3 turned0 = back * h[6], turned1 = back * h[5], turned2 = back * h[3], turned3 = back * h[7];
  const float bent =
      dot(turned0, turned0) + dot(turned1, turned1) + dot(turned2, turned2) + dot(turned3, turned3);
  const vec3 eta0 =
                 (-1.0f / 64.0f) * times_each(mode_gain(gain, 0u), turned0 + stress * mode_coupling(at, 0u)),
             eta1 =
                 (-1.0f / 64.0f) * times_each(mode_gain(gain, 1u), turned1 + stress * mode_coupling(at, 1u)),
             eta2 =
                 (-1.0f / 64.0f) * times_each(mode_gain(gain, 2u), turned2 + stress * mode_coupling(at, 2u)),
             eta3 =
                 (-1.0f / 64.0f) * times_each(mode_gain(gain, 3u), turned3 + stress * mode_coupling(at, 3u));

  // The largest bits are those of the largest number, because all are at least 0.
  const float fold = strain + 4.0f * q4 * q4 * bent;
  if (strain > uintBitsToFloat(peek(bodies[body].strain_bits)))
    atomicMax(bodies[body].strain_bits, floatBitsToUint(strain));
  if (fold > uintBitsToFloat(peek(bodies[body].bent_bits)))
    atomicMax(bodies[body].bent_bits, floatBitsToUint(fold));
  if (1.0f - volume > uintBitsToFloat(peek(bodies[body].lack_bits)))
    atomicMax(bodies[body].lack_bits, floatBitsToUint(1.0f - volume));

  const vec3 tx = q4 * stress[0], ty = q4 * stress[1], tz = q4 * stress[2];
  h[0] = vec3(0.0f);
  h[1] = r * tx;
  h[2] = r * ty;
  h[3] = r * (xi.y * tx + xi.x * ty + eta2);
  h[4] = r * tz;
  h[5] = r * (xi.z * tx + xi.x * tz + eta1);
  h[6] = r * (xi.z * ty + xi.y * tz + eta0);
  h[7] = r * (yz * tx + xz * ty + xy * tz + eta3);
  butterfly_back(h[0], h[1]);
  butterfly_back(h[2], h[3]);
  butterfly_back(h[4], h[5]);
  butterfly_back(h[6], h[7]);
  butterfly_back(h[0], h[2]);
  butterfly_back(h[1], h[3]);
  butterfly_back(h[4], h[6]);
  butterfly_back(h[5], h[7]);
  butterfly_back(h[0], h[4]);
  butterfly_back(h[1], h[5]);
  butterfly_back(h[2], h[6]);
  butterfly_back(h[3], h[7]);
  for (int corner = 0; corner < 8; ++corner) {
    const uint node = cells[i].nodes[corner];
    solve[node].swept = vec4(vec3(solve[node].swept) + solve[node].predicted.w * h[corner], 0.0f);
  }
}
