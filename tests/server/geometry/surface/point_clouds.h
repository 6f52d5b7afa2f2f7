// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

// Clouds of known shapes. Reproducible on all platforms: the output of the engine is specified, but the
// distributions of the standard library are not.

namespace livegs::testing {

using Points = std::vector<Eigen::Vector3d>;

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  double uniform(double low = 0.0, double high = 1.0) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1.0p-53);
  }
  Eigen::Vector3d in_cube() {
    const double x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
    return {x, y, z};
  }
  Eigen::Vector3d direction() {
    while (true) {
      const Eigen::Vector3d v = in_cube();
      if (v.squaredNorm() <= 1.0 && v.squaredNorm() > 1e-4) return v.normalized();
    }
  }

 private:
  std::mt19937_64 engine_;
};

template <class Make>
Points cloud(size_t count, uint64_t seed, const Make& make) {
  Random random(seed);
  Points points;
  points.reserve(count);
  while (points.size() < count) points.push_back(make(random));
  return points;
}

inline Points sphere_cloud(size_t count, double radius_m, double noise_m = 0.0) {
  return cloud(count, 1, [=](Random& r) {
    const Eigen::Vector3d way = r.direction();
    return Eigen::Vector3d(way * (radius_m + noise_m * r.uniform(-1, 1)));
  });
}

// The surface of a cube with an edge of 2 half_m.
inline Points cube_cloud(size_t count, double half_m) {
  return cloud(count, 2, [=](Random& r) {
    Eigen::Vector3d p = half_m * r.in_cube();
    const int side = static_cast<int>(r.uniform(0, 6));
    p[side / 2] = side % 2 ? half_m : -half_m;
    return p;
  });
}

// Uniform over the surface of a torus about +Y.
inline Points torus_cloud(size_t count, double ring_m, double tube_m, double noise_m = 0.0) {
  return cloud(count, 3, [=](Random& r) {
    while (true) {
      const double turn = r.uniform(0, 2 * std::numbers::pi), tube = r.uniform(0, 2 * std::numbers::pi);
      const double out = ring_m + tube_m * std::cos(tube);
      if (r.uniform() * (ring_m + tube_m) > out) continue;
      const double t = tube_m + noise_m * r.uniform(-1, 1);
      const double ring = ring_m + t * std::cos(tube);
      return Eigen::Vector3d(ring * std::cos(turn), t * std::sin(tube), ring * std::sin(turn));
    }
  });
}

// A capsule along +Y, with height_m between the centres of its caps.
inline Points capsule_cloud(size_t count, double radius_m, double height_m) {
  return cloud(count, 4, [=](Random& r) {
    if (r.uniform() * (height_m + 2 * radius_m) < height_m) {
      const double turn = r.uniform(0, 2 * std::numbers::pi);
      return Eigen::Vector3d(radius_m * std::cos(turn), height_m * r.uniform(-0.5, 0.5),
                             radius_m * std::sin(turn));
    }
    Eigen::Vector3d p = radius_m * r.direction();
    p.y() += p.y() > 0 ? 0.5 * height_m : -0.5 * height_m;
    return p;
  });
}

// The lower half of a sphere: a bowl without thickness.
inline Points bowl_cloud(size_t count, double radius_m) {
  return cloud(count, 5, [=](Random& r) {
    Eigen::Vector3d p = radius_m * r.direction();
    p.y() = -std::abs(p.y());
    return p;
  });
}

}  // namespace livegs::testing
