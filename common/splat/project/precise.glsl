// SPDX-License-Identifier: Apache-2.0
// Arithmetic with identical results on every device and on the CPU (precise.h).

// a b - c d with compensated rounding of each product (Dekker 1971; Kahan). Does not use fma, which only some
// devices have.
float product_error(float a, float b, float product) {
  precise float wide_a = 4097.0 * a;
  precise float high_a = wide_a - (wide_a - a);
  precise float low_a = a - high_a;
  precise float wide_b = 4097.0 * b;
  precise float high_b = wide_b - (wide_b - b);
  precise float low_b = b - high_b;
  precise float error = ((high_a * high_b - product) + high_a * low_b + low_a * high_b) + low_a * low_b;
  return error;
}

float product_difference(float a, float b, float c, float d) {
  precise float first = a * b;
  precise float second = c * d;
  precise float difference = (first - second) + (product_error(a, b, first) - product_error(c, d, second));
  return difference;
}

// log2 of a positive finite number, accurate to a few roundings: x = 2^e m with m in [sqrt(1/2), sqrt(2)),
// and ln m = 2 artanh((m - 1) / (m + 1)) as a series, with a truncation error s^11 / 11 < 4e-10. The log2 of
// devices differs by up to 1e-5.
float log2_of(float x) {
  uint bits = floatBitsToUint(x);
  int exponent = int(bits >> 23) - 127;
  float m = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u);
  if (m > 1.41421356) {
    m *= 0.5;
    exponent += 1;
  }
  const float s = (m - 1.0) / (m + 1.0);
  const float ss = s * s;
  const float series = 1.0 + ss * (0.333333333 + ss * (0.2 + ss * (0.142857143 + ss * 0.111111111)));
  return float(exponent) + 2.88539008 * s * series;  // 2 / ln 2
}
