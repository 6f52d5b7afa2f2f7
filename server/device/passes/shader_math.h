// SPDX-License-Identifier: GPL-3.0-or-later

// The part of GLSL that the bodies of the elastic passes use, for C++. The bodies are compiled twice from one
// text: as a shader, and as the CPU function. Literals end in f, and matrices are columns, as in GLSL.

#ifndef LIVEGS_DEVICE_SHADER_MATH_H
#define LIVEGS_DEVICE_SHADER_MATH_H

#ifdef __cplusplus

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>

namespace livegs::shader {

using uint = uint32_t;

struct vec3 {
  float x = 0, y = 0, z = 0;
  vec3() = default;
  explicit vec3(float all) : x(all), y(all), z(all) {}
  vec3(float a, float b, float c) : x(a), y(b), z(c) {}
  template <class Four>
  requires requires(Four four) { four.w; }
  explicit vec3(const Four& four) : x(four.x), y(four.y), z(four.z) {}
  float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
struct alignas(16) vec4 {
  float x = 0, y = 0, z = 0, w = 0;
  vec4() = default;
  explicit vec4(float all) : x(all), y(all), z(all), w(all) {}
  vec4(float a, float b, float c, float d) : x(a), y(b), z(c), w(d) {}
  vec4(const vec3& v, float d) : x(v.x), y(v.y), z(v.z), w(d) {}
};
inline vec3 operator+(const vec3& a, const vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline vec3 operator-(const vec3& a, const vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline vec3 operator-(const vec3& a) { return {-a.x, -a.y, -a.z}; }
inline vec3 operator*(float s, const vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline vec3 operator*(const vec3& a, float s) { return s * a; }
inline vec3 operator/(const vec3& a, float s) { return {a.x / s, a.y / s, a.z / s}; }
inline vec3& operator+=(vec3& a, const vec3& b) { return a = a + b; }
inline vec3& operator-=(vec3& a, const vec3& b) { return a = a - b; }
inline vec4 operator+(const vec4& a, const vec4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
inline vec4 operator*(float s, const vec4& a) { return {s * a.x, s * a.y, s * a.z, s * a.w}; }
inline float dot(const vec3& a, const vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float dot(const vec4& a, const vec4& b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }
inline vec3 cross(const vec3& a, const vec3& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
inline float length(const vec3& a) { return std::sqrt(dot(a, a)); }
inline float length(const vec4& a) { return std::sqrt(dot(a, a)); }

struct mat3 {
  vec3 column[3];
  mat3() = default;
  explicit mat3(float diagonal) {
    for (int i = 0; i < 3; ++i) column[i][i] = diagonal;
  }
  mat3(const vec3& a, const vec3& b, const vec3& c) : column{a, b, c} {}
  vec3& operator[](int i) { return column[i]; }
  const vec3& operator[](int i) const { return column[i]; }
};
inline vec3 operator*(const mat3& a, const vec3& v) { return v.x * a[0] + v.y * a[1] + v.z * a[2]; }
inline mat3 operator*(const mat3& a, const mat3& b) { return {a * b[0], a * b[1], a * b[2]}; }
inline mat3 operator*(float s, const mat3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline mat3 operator+(const mat3& a, const mat3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline mat3 operator-(const mat3& a, const mat3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline mat3 transpose(const mat3& a) {
  return {{a[0].x, a[1].x, a[2].x}, {a[0].y, a[1].y, a[2].y}, {a[0].z, a[1].z, a[2].z}};
}
inline mat3 outerProduct(const vec3& a, const vec3& b) { return {b.x * a, b.y * a, b.z * a}; }

inline float sqrt(float a) { return std::sqrt(a); }
inline float abs(float a) { return std::fabs(a); }
inline float min(float a, float b) { return b < a ? b : a; }
inline float max(float a, float b) { return a < b ? b : a; }
inline uint min(uint a, uint b) { return b < a ? b : a; }
inline float sin(float a) { return std::sin(a); }
inline float cos(float a) { return std::cos(a); }
inline uint floatBitsToUint(float a) { return std::bit_cast<uint>(a); }
inline float uintBitsToFloat(uint a) { return std::bit_cast<float>(a); }
inline uint peek(uint& place) { return std::atomic_ref<uint>(place).load(std::memory_order_relaxed); }
inline void atomicMax(uint& place, uint value) {
  std::atomic_ref<uint> shared(place);
  uint seen = shared.load(std::memory_order_relaxed);
  while (seen < value && !shared.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

}  // namespace livegs::shader

#define LIVEGS_INOUT(type) type&
#define LIVEGS_PRECISE
#define LIVEGS_SHARED_BODY inline

#else

#define peek(place) (place)
#define LIVEGS_INOUT(type) inout type
#define LIVEGS_PRECISE precise
#define LIVEGS_SHARED_BODY

#endif

// 1 / sqrt(a). A driver may use the processor's estimate, which has only half of the digits. One step of
// Newton's method refines it.
#ifdef __cplusplus
namespace livegs::shader {
#endif
LIVEGS_SHARED_BODY float inverse_root(float a) {
  LIVEGS_PRECISE float root = sqrt(a);
  LIVEGS_PRECISE float estimate = 1.0f / root;
  LIVEGS_PRECISE float better = estimate * (1.5f - 0.5f * a * estimate * estimate);
  return better;
}
#ifdef __cplusplus
}
#endif

#endif
