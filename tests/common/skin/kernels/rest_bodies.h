// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "skin/skin_kernels.h"

// Bodies, kernels and motions shared by the tests and benchmarks of skinning.

namespace livegs::testing {

// Uniform over [low, high), identical on all platforms, unlike the std:: distributions.
inline double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

inline Eigen::Vector3d uniform3(std::mt19937_64& random, double low, double high) {
  const double x = uniform(random, low, high), y = uniform(random, low, high), z = uniform(random, low, high);
  return {x, y, z};
}

inline Eigen::Quaterniond random_rotation(std::mt19937_64& random) {
  Eigen::Vector4d v;
  do {
    for (int i = 0; i < 4; ++i) v[i] = uniform(random, -1.0, 1.0);
  } while (v.squaredNorm() > 1.0 || v.squaredNorm() < 1e-3);
  v.normalize();
  return Eigen::Quaterniond(v[0], v[1], v[2], v[3]);
}

// A lattice of nx x ny x nz possible cells; `keep` selects the existing ones. `first` is the lowest lattice
// coordinate.
inline RestBody lattice_body(int nx, int ny, int nz, double cell_width_m,
                             const std::function<bool(int, int, int)>& keep = nullptr,
                             const Eigen::Vector3i& first = Eigen::Vector3i::Zero()) {
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.cell_width_m = cell_width_m;
  std::map<std::array<int, 3>, uint32_t> node_of;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        if (keep && !keep(x, y, z)) continue;
        std::array<uint32_t, 8> cell;
        for (int c = 0; c < 8; ++c) {
          const std::array<int, 3> at{first[0] + x + (c & 1), first[1] + y + ((c >> 1) & 1),
                                      first[2] + z + (c >> 2)};
          const auto [place, added] =
              node_of.emplace(at, static_cast<uint32_t>(rest.node_coordinates.size()));
          if (added) rest.node_coordinates.emplace_back(at[0], at[1], at[2]);
          cell[c] = place->second;
        }
        rest.cells.push_back(cell);
      }
    }
  }
  return rest;
}

// Half of the cells of a block, selected by `seed`; at least one.
inline RestBody ragged_body(int nx, int ny, int nz, double cell_width_m, uint64_t seed) {
  std::mt19937_64 random(seed);
  return lattice_body(nx, ny, nz, cell_width_m, [&random](int x, int y, int z) {
    return (random() & 1u) != 0 || (x == 0 && y == 0 && z == 0);
  });
}

inline Eigen::Vector3d node_rest_m(const RestBody& rest, size_t node) {
  return rest.object_from_lattice * (rest.cell_width_m * rest.node_coordinates[node].cast<double>());
}

// Drivers of a lattice or of particles with every point moved by `motion` (object frame to world).
inline ObjectDrivers moved_drivers(const RestBody& rest,
                                   const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& motion,
                                   const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity()) {
  ObjectDrivers drivers;
  drivers.kind = rest.kind;
  if (rest.kind == DriverKind::Lattice) {
    for (size_t n = 0; n < rest.node_coordinates.size(); ++n) {
      drivers.positions_m.push_back(motion(node_rest_m(rest, n)).cast<float>());
    }
  } else {
    for (const Eigen::Vector3f& particle : rest.particles_m) {
      drivers.positions_m.push_back(motion(particle.cast<double>()).cast<float>());
      drivers.rotations.push_back(turn.cast<float>());
    }
  }
  return drivers;
}

inline ObjectDrivers rest_drivers(const RestBody& rest) {
  return moved_drivers(rest, [](const Eigen::Vector3d& x) { return x; });
}

// Kernels at the given points of the object frame, with random shapes: 1 to 20 mm along each axis.
inline GaussianAsset kernels_at(const RestBody& rest, const std::vector<Eigen::Vector3d>& points_m,
                                uint64_t seed) {
  std::mt19937_64 random(seed);
  GaussianAsset asset;
  asset.resize(points_m.size());
  const Similarity& to_object = rest.object_from_asset;
  for (size_t k = 0; k < points_m.size(); ++k) {
    const Eigen::Vector3d in_asset =
        to_object.rotation.conjugate() * ((points_m[k] - to_object.translation_m) / to_object.scale);
    asset.positions[k] = in_asset.cast<float>();
    asset.log_scales[k] = (uniform3(random, std::log(0.001), std::log(0.02)) -
                           Eigen::Vector3d::Constant(std::log(to_object.scale)))
                              .cast<float>();
    asset.rotations[k] = random_rotation(random).cast<float>();
  }
  return asset;
}

// Points inside random cells of a lattice, in the object frame.
inline std::vector<Eigen::Vector3d> points_inside(const RestBody& rest, size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < count; ++i) {
    const std::array<uint32_t, 8>& cell = rest.cells[random() % rest.cells.size()];
    const Eigen::Vector3d local = rest.node_coordinates[cell[0]].cast<double>() + uniform3(random, 0.0, 1.0);
    points.push_back(rest.object_from_lattice * (rest.cell_width_m * local));
  }
  return points;
}

// A typical placement: 0.3 m per asset unit, lattice and asset rotated and translated relative to the object.
inline void place(RestBody& rest, uint64_t seed) {
  std::mt19937_64 random(seed);
  rest.object_from_asset.scale = 0.3;
  rest.object_from_asset.rotation = random_rotation(random);
  rest.object_from_asset.translation_m = uniform3(random, -0.2, 0.2);
  rest.object_from_lattice.orientation = random_rotation(random);
  rest.object_from_lattice.position_m = uniform3(random, -0.2, 0.2);
}

inline Eigen::Matrix3d matrix_of(const Symmetric3f& s) {
  Eigen::Matrix3d m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return m;
}

// The rest covariance of kernel k in the object frame, computed from the definition in doubles.
inline Eigen::Matrix3d rest_covariance_m2(const GaussianAsset& asset, const RestBody& rest, size_t k) {
  const Eigen::Matrix3d axes =
      (rest.object_from_asset.rotation * asset.rotations[k].cast<double>()).toRotationMatrix();
  const Eigen::Vector3d deviation_m =
      asset.log_scales[k].cast<double>().array().exp().matrix() * rest.object_from_asset.scale;
  return axes * deviation_m.cwiseAbs2().asDiagonal() * axes.transpose();
}

inline Eigen::Vector3d rest_position_m(const GaussianAsset& asset, const RestBody& rest, size_t k) {
  return rest.object_from_asset * asset.positions[k].cast<double>();
}

// The angle between two rotations, in radians.
inline double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b);
}

}  // namespace livegs::testing
