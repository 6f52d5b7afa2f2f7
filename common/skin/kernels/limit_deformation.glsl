// SPDX-License-Identifier: Apache-2.0
// GPU twin of limit_deformation.cpp, which explains the steps. Values that select between two ways to flatten
// a cell are `precise`, so that rounding selects the same way on every device.

const int kNewtonSteps = 6;
const int kJacobiSweeps = 6;
const float kMinKnownStretch = 1e-4;
const float kOrthogonalCosine_squared = 1e-14;
const float kEqualRatio_squared = 1.0001;
const float kEqualCosine_squared = 1e-10;
const float kMaxStretch = float(kKernelStretchLimit);
const float kMinStretch = 1.0 / kMaxStretch;

struct LimitedDeformation {
  mat3 gradient;
  vec4 rotation;  // x y z w, unit
};

float exact_dot(vec3 a, vec3 b) {
  precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

vec3 exact_cross(vec3 a, vec3 b) {
  precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return c;
}

vec3 exact_sum(float s, vec3 a, float t, vec3 b) {  // s a + t b
  precise vec3 sum = s * a + t * b;
  return sum;
}

vec3 exact_unit(vec3 v) {
  precise float inverse = 1.0 / sqrt(exact_dot(v, v));
  precise vec3 unit = inverse * v;
  return unit;
}

vec4 quaternion_of(mat3 m) {  // columns
  vec4 q;
  const float trace = m[0][0] + m[1][1] + m[2][2];
  if (trace > 0.0) {
    const float t = sqrt(trace + 1.0);
    const float s = 0.5 / t;
    q = vec4((m[1][2] - m[2][1]) * s, (m[2][0] - m[0][2]) * s, (m[0][1] - m[1][0]) * s, 0.5 * t);
  } else if (m[0][0] >= m[1][1] && m[0][0] >= m[2][2]) {
    const float t = sqrt(m[0][0] - m[1][1] - m[2][2] + 1.0);
    const float s = 0.5 / t;
    q = vec4(0.5 * t, (m[0][1] + m[1][0]) * s, (m[0][2] + m[2][0]) * s, (m[1][2] - m[2][1]) * s);
  } else if (m[1][1] >= m[2][2]) {
    const float t = sqrt(m[1][1] - m[2][2] - m[0][0] + 1.0);
    const float s = 0.5 / t;
    q = vec4((m[1][0] + m[0][1]) * s, 0.5 * t, (m[1][2] + m[2][1]) * s, (m[2][0] - m[0][2]) * s);
  } else {
    const float t = sqrt(m[2][2] - m[0][0] - m[1][1] + 1.0);
    const float s = 0.5 / t;
    q = vec4((m[2][0] + m[0][2]) * s, (m[2][1] + m[1][2]) * s, 0.5 * t, (m[0][1] - m[1][0]) * s);
  }
  return normalize(q);
}

void part_columns(inout vec3 b_p, inout vec3 b_q, inout vec3 v_p, inout vec3 v_q) {
  const float alpha = exact_dot(b_p, b_p);
  const float beta = exact_dot(b_q, b_q);
  const float gamma = exact_dot(b_p, b_q);
  precise float alpha_limit = kEqualRatio_squared * beta;
  precise float beta_limit = kEqualRatio_squared * alpha;
  const bool equal = alpha <= alpha_limit && beta <= beta_limit;
  precise float little = (equal ? kEqualCosine_squared : kOrthogonalCosine_squared) * alpha * beta;
  precise float square = gamma * gamma;
  if (square <= little) return;
  precise float zeta = (beta - alpha) / (2.0 * gamma);
  precise float magnitude = 1.0 / (abs(zeta) + sqrt(1.0 + zeta * zeta));
  const float t = zeta < 0.0 ? -magnitude : magnitude;
  precise float c = 1.0 / sqrt(1.0 + t * t);
  precise float s = c * t;
  const vec3 b_before = b_p;
  const vec3 v_before = v_p;
  b_p = exact_sum(c, b_before, -s, b_q);
  b_q = exact_sum(s, b_before, c, b_q);
  v_p = exact_sum(c, v_before, -s, v_q);
  v_q = exact_sum(s, v_before, c, v_q);
}

void order_columns(inout vec3 b_p, inout vec3 b_q, inout vec3 v_p, inout vec3 v_q) {
  precise float limit = kEqualRatio_squared * exact_dot(b_p, b_p);
  if (exact_dot(b_q, b_q) <= limit) return;
  const vec3 b = b_p;
  const vec3 v = v_p;
  b_p = b_q;
  b_q = b;
  v_p = v_q;
  v_q = v;
}

LimitedDeformation limit_by_singular_values(mat3 gradient) {
  const vec3 most = max(max(abs(gradient[0]), abs(gradient[1])), abs(gradient[2]));
  const float scale = max(max(most.x, most.y), most.z);
  if (scale < kMinKnownStretch) return LimitedDeformation(mat3(kMinStretch), vec4(0.0, 0.0, 0.0, 1.0));
  precise vec3 f0 = gradient[0] / scale;
  precise vec3 f1 = gradient[1] / scale;
  precise vec3 f2 = gradient[2] / scale;
  vec3 b0 = f0;
  vec3 b1 = f1;
  vec3 b2 = f2;
  vec3 v0 = vec3(1.0, 0.0, 0.0);
  vec3 v1 = vec3(0.0, 1.0, 0.0);
  vec3 v2 = vec3(0.0, 0.0, 1.0);
  for (int sweep = 0; sweep < kJacobiSweeps; ++sweep) {
    part_columns(b0, b1, v0, v1);
    part_columns(b0, b2, v0, v2);
    part_columns(b1, b2, v1, v2);
  }
  order_columns(b0, b1, v0, v1);
  order_columns(b1, b2, v1, v2);
  order_columns(b0, b1, v0, v1);
  v0 = exact_unit(v0);
  v1 = exact_unit(exact_sum(1.0, v1, -exact_dot(v0, v1), v0));
  v2 = exact_cross(v0, v1);

  const vec3 u0 = exact_unit(b0);
  const vec3 second = exact_sum(1.0, b1, -exact_dot(u0, b1), u0);
  precise float second_length = sqrt(exact_dot(second, second));
  precise float second_stretch = scale * second_length;
  vec3 u1;
  if (second_stretch > kMinKnownStretch) {
    precise float inverse = 1.0 / second_length;
    u1 = inverse * second;
  } else {
    const float along = 1.0 + exact_dot(v0, u0);
    precise float share = exact_dot(u0, v1) / along;
    const vec3 turned = along > 1e-3 ? exact_sum(1.0, v1, -share, u0 + v0) : v1;
    u1 = exact_unit(exact_sum(1.0, turned, -exact_dot(u0, turned), u0));
  }
  const vec3 u2 = exact_cross(u0, u1);
  precise vec3 third_column = v2.x * f0 + v2.y * f1 + v2.z * f2;
  const float third = exact_dot(u2, third_column);

  const vec3 sigma = vec3(scale * sqrt(exact_dot(b0, b0)), second_stretch, scale * third);
  const vec3 stretch = clamp(sigma, kMinStretch, kMaxStretch);
  const mat3 limited =
      outerProduct(stretch.x * u0, v0) + outerProduct(stretch.y * u1, v1) + outerProduct(stretch.z * u2, v2);
  const mat3 turn = outerProduct(u0, v0) + outerProduct(u1, v1) + outerProduct(u2, v2);
  return LimitedDeformation(limited, quaternion_of(turn));
}

// Clamps the singular values to kMinStretch..kMaxStretch and finds the rotation.
LimitedDeformation limit_deformation(mat3 gradient) {
  vec3 c0 = gradient[0];
  vec3 c1 = gradient[1];
  vec3 c2 = gradient[2];
  vec3 co0 = exact_cross(c1, c2);
  vec3 co1 = exact_cross(c2, c0);
  vec3 co2 = exact_cross(c0, c1);
  float determinant = exact_dot(c0, co0);
  precise float norm_squared = exact_dot(c0, c0) + exact_dot(c1, c1) + exact_dot(c2, c2);
  if (!(norm_squared < 3e38)) return LimitedDeformation(mat3(1.0), vec4(0.0, 0.0, 0.0, 1.0));
  if (!(norm_squared <= kMaxStretch * kMaxStretch && 2.0 * determinant >= kMinStretch * norm_squared &&
        determinant > 0.0)) {
    return limit_by_singular_values(gradient);
  }
  for (int i = 0; i < kNewtonSteps; ++i) {
    const float inverse = 0.5 / determinant;
    c0 = 0.5 * c0 + inverse * co0;
    c1 = 0.5 * c1 + inverse * co1;
    c2 = 0.5 * c2 + inverse * co2;
    co0 = cross(c1, c2);
    co1 = cross(c2, c0);
    co2 = cross(c0, c1);
    determinant = dot(c0, co0);
  }
  return LimitedDeformation(gradient, quaternion_of(mat3(c0, c1, c2)));
}
