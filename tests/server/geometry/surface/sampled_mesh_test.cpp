// SPDX-License-Identifier: GPL-3.0-or-later
// Splats sampled on the surface of a closed mesh: one kernel a cell of a grid on each face, flat or round.
// The body is the solid; a skin that leaks is said to leak.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/math/rotation_between.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/reconstruct_surface.h"
#include "rates.h"

namespace livegs {
namespace {

struct Sampling {
  int per_edge;
  double deviation;  // in cells
  bool flat;
  double jitter = 0;  // in cells
  bool ball = false;  // the cube is blown up to a ball
};

// A cube of 0.2 m, or a ball of radius 0.1 m.
GaussianAsset sampled(const Sampling& sampling) {
  constexpr double kHalf_m = 0.1;
  GaussianAsset asset;
  std::mt19937 engine(5);
  const auto jitter = [&] {
    return sampling.jitter * (static_cast<double>(engine() % 10001) / 10000.0 - 0.5);
  };
  const double cell = 2 * kHalf_m / sampling.per_edge;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-kHalf_m, kHalf_m}) {
      for (int i = 0; i < sampling.per_edge; ++i) {
        for (int j = 0; j < sampling.per_edge; ++j) {
          Eigen::Vector3d position;
          position[axis] = side;
          position[(axis + 1) % 3] = (i + 0.5 + jitter()) * cell - kHalf_m;
          position[(axis + 2) % 3] = (j + 0.5 + jitter()) * cell - kHalf_m;
          Eigen::Vector3d normal = Eigen::Vector3d::Unit(axis);
          if (sampling.ball) {
            normal = position.normalized();
            position = kHalf_m * normal;
          }
          asset.positions.push_back(position.cast<float>());
          const auto wide = static_cast<float>(std::log(sampling.deviation * cell));
          asset.log_scales.emplace_back(sampling.flat ? std::log(1e-5f) : wide, wide, wide);
          asset.rotations.push_back(rotation_between(Eigen::Vector3d::UnitX(), normal).cast<float>());
          asset.opacity_logits.push_back(3);
          asset.sh_dc.emplace_back(Eigen::Vector3f::Zero());
        }
      }
    }
  }
  return asset;
}

void expect_solid_or_leak(const Sampling& sampling) {
  const auto surface = reconstruct_surface(body_points(sampled(sampling), {}), elastic_surface_options());
  ASSERT_TRUE(surface) << surface.error().message;
  const double volume_m3 = solid_mass_properties(surface->mesh).volume_m3;
  const double solid_m3 = sampling.ball ? 4.0 / 3.0 * M_PI * 1e-3 : 8e-3;
  // Round kernels extend the body by up to a standard deviation.
  const double beyond = sampling.flat ? 0 : 2 * sampling.deviation / sampling.per_edge;
  const bool right = volume_m3 >= 0.8 * solid_m3 && volume_m3 <= 1.2 * solid_m3 * std::pow(1 + beyond, 3);
  EXPECT_TRUE(right || surface->note.find("leak") != std::string::npos)
      << sampling.per_edge << " an edge, deviation " << sampling.deviation
      << (sampling.flat ? ", flat" : ", round") << ", jitter " << sampling.jitter
      << (sampling.ball ? ", ball" : "") << ": " << volume_m3 << " of " << solid_m3 << " m3, note '"
      << surface->note << "'";
}

TEST(SampledMesh, CubesAreSolid) {
  for (const int per_edge : gate_or_full<int>(
           {8, 13, 15, 19, 24}, {6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24}))
    expect_solid_or_leak({per_edge, 0.5, true});
  for (const int per_edge : {8, 14, 19}) expect_solid_or_leak({per_edge, 0.5, false});
}

TEST(SampledMesh, BallsAreSolid) {
  for (const int per_edge : {8, 13, 21}) {
    for (const bool flat : {true, false}) expect_solid_or_leak({per_edge, 0.5, flat, 0, true});
  }
}

TEST(SampledMesh, NarrowWideAndScatteredKernelsAsWell) {
  for (const int per_edge : gate_or_full<int>({8, 11}, {8, 11, 16})) {
    for (const double deviation : {0.25, 0.7}) {
      for (const double jitter : {0.0, 0.8}) {
        for (const bool flat : gate_or_full<bool>({per_edge % 2 == 0}, {false, true}))
          expect_solid_or_leak({per_edge, deviation, flat, jitter});
      }
    }
  }
}

// Nothing is closed that is open: a single sheet, curled to a half pipe, stays a sheet.
TEST(SampledMesh, OpenSheetsStayOpen) {
  for (const int per_edge : {16, 24}) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i <= per_edge; ++i) {
      for (int j = 0; j <= per_edge; ++j) {
        const double turn = M_PI * i / per_edge;
        points.emplace_back(0.1 * std::cos(turn), 0.1 * std::sin(turn), 0.3 * j / per_edge);
      }
    }
    const auto surface = reconstruct_surface(points, elastic_surface_options());
    ASSERT_TRUE(surface);
    const double pipe_m3 = 0.5 * M_PI * 0.01 * 0.3;
    EXPECT_LE(solid_mass_properties(surface->mesh).volume_m3, 0.4 * pipe_m3) << per_edge << surface->note;
  }
}

// Kernels as wide as the object cost a bounded number of points.
TEST(SampledMesh, WideKernelsCostBoundedPoints) {
  for (const double deviation_m : {0.05, 0.2, 1.0}) {
    GaussianAsset asset = sampled({80, 1, false});
    for (Eigen::Vector3f& scale : asset.log_scales)
      scale.setConstant(static_cast<float>(std::log(deviation_m)));
    const size_t points = body_points(asset, {}).size();
    EXPECT_LE(points, 2000000 + 9 * asset.size()) << deviation_m;
    EXPECT_GE(points, asset.size());
  }
}

}  // namespace
}  // namespace livegs
