// SPDX-License-Identifier: Apache-2.0
#include "sample/tools/surface_sampler.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "sample/tools/sharp_edge.h"

namespace livegs::sample {
namespace {

constexpr double kPi = 3.14159265358979323846;

ParametricSurface sphere(double radius_m, double spacing_m) {
  ParametricSurface surface;
  surface.position_m = [radius_m](double u, double v) {
    return Eigen::Vector3d(radius_m * std::sin(v) * std::sin(u), -radius_m * std::cos(v),
                           radius_m * std::sin(v) * std::cos(u));
  };
  surface.u_max = 2 * kPi;
  surface.v_max = kPi;
  surface.spacing_m = spacing_m;
  return surface;
}

// Optical depth at a point, with kernels of the default size and opacity.
double depth_over(const Eigen::Vector3d& point, const SurfaceSamples& samples) {
  double depth = 0.0;
  for (const SurfaceSample& s : samples) {
    const double sigma = 0.75 * s.spacing_m, square = (s.position_m - point).squaredNorm() / (sigma * sigma);
    if (square < 20) depth -= std::log1p(-0.95 * std::exp(-0.5 * square));
  }
  return depth;
}

TEST(SurfaceSampler, SphereIsCoveredEvenlyIncludingPoles) {
  Random random(3);
  SurfaceSamples samples;
  sample_surface(sphere(0.1, 0.005), random, samples);
  // Between saturated random packing (0.70 per spacing²) and that plus the darts that fill its holes.
  const double discs = 4 * kPi * 0.01 / (0.005 * 0.005);
  EXPECT_GT(static_cast<double>(samples.size()), 0.60 * discs);
  EXPECT_LT(static_cast<double>(samples.size()), 1.20 * discs);
  for (const SurfaceSample& s : samples) {
    EXPECT_NEAR(s.position_m.norm(), 0.1, 1e-12);
    // Differences over 0.3 % of the parameter range rotate the normal by less than that.
    EXPECT_GT(s.normal.dot(s.position_m.normalized()), 0.99);
    EXPECT_NEAR(s.tangent.dot(s.normal), 0.0, 1e-9);
  }
  // A tenth of the light may pass at the worst point, because random candidates may miss the last holes.
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (2 * i + 1.0) / 2000, r = std::sqrt(1 - z * z), a = 2.399963229728653 * i;
    EXPECT_GT(depth_over(0.1 * Eigen::Vector3d(r * std::cos(a), z, r * std::sin(a)), samples),
              std::log(10.0));
  }
}

TEST(SurfaceSampler, SharpBendsAreSampledFiner) {
  Random random(3);
  SurfaceSamples wide, narrow;
  sample_surface(sphere(0.1, 0.002), random, wide);
  sample_surface(sphere(0.004, 0.002), random, narrow);
  EXPECT_DOUBLE_EQ(wide.front().spacing_m, 0.002);
  for (const SurfaceSample& s : narrow)
    EXPECT_LT(s.spacing_m, 0.0017);  // a third of a radian on 4 mm is 1.4 mm
}

TEST(SurfaceSampler, ImplicitSphereLiesOnItsSurfaceAndIsClosed) {
  ImplicitSurface surface;
  surface.distance_m = [](const Eigen::Vector3d& p) { return p.norm() - 0.05; };
  surface.min_m = Eigen::Vector3d::Constant(-0.06);
  surface.max_m = Eigen::Vector3d::Constant(0.06);
  surface.spacing_m = 0.003;
  Random random(5);
  SurfaceSamples samples;
  sample_implicit(surface, random, samples);
  for (const SurfaceSample& s : samples) {
    EXPECT_NEAR(s.position_m.norm(), 0.05,
                0.05 * 0.003);  // the sampler's own bound: a twentieth of the spacing
    EXPECT_GT(s.normal.dot(s.position_m.normalized()), 0.999);
  }
  for (int i = 0; i < 1000; ++i) {
    const double z = 1 - (2 * i + 1.0) / 1000, r = std::sqrt(1 - z * z), a = 2.399963229728653 * i;
    EXPECT_GT(depth_over(0.05 * Eigen::Vector3d(r * std::cos(a), z, r * std::sin(a)), samples),
              std::log(10.0));
  }
}

TEST(SharpEdge, SamplesKeepTheirSideAndMargin) {
  Random random(9);
  SurfaceSamples samples;
  for (int i = 0; i < 1000; ++i) {
    SurfaceSample s{};
    s.position_m = {random.uniform(-0.01, 0.01), 0.0, random.uniform(-0.01, 0.01)};
    s.normal = Eigen::Vector3d::UnitY();
    s.tangent = Eigen::Vector3d::UnitX();
    samples.push_back(s);
  }
  const SurfaceSamples before = samples;
  line_up_along_edge([](const SurfaceSample& s) { return s.position_m.x() - 0.002; }, 0.001, samples);
  for (size_t i = 0; i < samples.size(); ++i) {
    const double from = before[i].position_m.x() - 0.002, to = samples[i].position_m.x() - 0.002;
    EXPECT_EQ(from < 0, to < 0);
    EXPECT_GE(std::abs(to), 0.001 - 1e-9);  // the edge is straight: differences are exact to rounding
    if (std::abs(from) >= 0.001) {
      EXPECT_EQ(from, to);
    }
  }
}

}  // namespace
}  // namespace livegs::sample
