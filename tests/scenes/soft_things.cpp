// SPDX-License-Identifier: Apache-2.0
#include "scenes/soft_things.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sample/tools/baked_light.h"
#include "sample/tools/colour.h"
#include "sample/tools/noise.h"
#include "sample/tools/shapes.h"

namespace livegs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Spots of two sizes on the surface, of one hue.
sample::Material spotted(uint32_t rgb, uint64_t seed) {
  return [rgb, seed](const sample::SurfaceSample& sample) {
    sample::Appearance appearance;
    const Vector3d& p = sample.position_m;
    const double fine = sample::value_noise(p / 0.004, seed),
                 coarse = sample::fractal_noise(p / 0.015, 2, seed + 1);
    appearance.albedo = sample::linear_from_hex(rgb) * std::max(0.15, 1.0 + 0.5 * fine + 0.5 * coarse);
    return appearance;
  };
}

GaussianAsset baked(const sample::SurfaceSamples& samples, uint32_t rgb) {
  sample::Random random(5);
  sample::BakeOptions options;
  options.sh_degree = 0;
  options.occlusion_cells = 0;
  GaussianAsset asset = sample::bake_kernels(samples, spotted(rgb, 17), options, random);
  sample::stand_at_origin(asset);
  return asset;
}

void add_sweep(sample::SurfaceSamples& samples, const std::function<Vector3d(double)>& curve,
               const Vector3d& reference, const std::function<Vector2d(double)>& half_axes_m, int part) {
  sample::Random random(static_cast<uint64_t>(part) + 11);
  sample::ParametricSurface surface = sample::sweep(curve, reference, half_axes_m, 0.003, part);
  surface.cells_u = 256;
  sample::sample_surface(surface, random, samples);
}

}  // namespace

GaussianAsset make_spiral_cord() {
  sample::SurfaceSamples samples;
  const auto curve = [](double u) {
    const double angle = 7 * 2 * std::numbers::pi * u;
    return Vector3d(0.03 * std::cos(angle), 0.005 + 0.29 * u, 0.03 * std::sin(angle));
  };
  add_sweep(
      samples, curve, Vector3d::UnitY(), [](double) { return Vector2d(0.005, 0.005); }, 0);
  return baked(samples, 0xB05030);
}

GaussianAsset make_flowers() {
  sample::SurfaceSamples samples;
  add_sweep(
      samples, [](double u) { return Vector3d(0, 0.05 * u, 0); }, Vector3d::UnitX(),
      [](double u) {
        const double r = 0.04 * std::sqrt(std::max(0.0, std::min(1.0, 20 * std::min(u, 1 - u))));
        return Vector2d(r, r);
      },
      0);
  for (int stem = 0; stem < 3; ++stem) {
    const double lean = 0.08 * (stem - 1), height = 0.20 + 0.02 * stem;
    const auto curve = [=](double u) {
      return Vector3d(0.02 * (stem - 1) + lean * u * u, 0.04 + height * u, 0);
    };
    add_sweep(
        samples, curve, Vector3d::UnitZ(), [](double) { return Vector2d(0.007, 0.007); }, 1 + stem);
    const Vector3d head = curve(1.0);
    add_sweep(
        samples, [=](double u) { return Vector3d(head + Vector3d(0, -0.025 + 0.05 * u, 0)); },
        Vector3d::UnitX(),
        [](double u) {
          const double r = 0.028 * std::sqrt(std::max(0.0, 1 - std::pow(2 * u - 1, 2)));
          return Vector2d(r, r);
        },
        4 + stem);
  }
  return baked(samples, 0x70A048);
}

GaussianAsset make_large_leaf() {
  sample::SurfaceSamples samples;
  const auto curve = [](double u) { return Vector3d(-0.2 + 0.4 * u, 0.02 + 0.18 * u - 0.12 * u * u, 0); };
  add_sweep(
      samples, curve, Vector3d::UnitZ(),
      [](double u) {
        const double width =
            0.012 + 0.068 * std::sin(std::numbers::pi * std::clamp((u - 0.15) / 0.85, 0.0, 1.0));
        return Vector2d(width, 0.004);
      },
      0);
  return baked(samples, 0x4C8A3A);
}

}  // namespace livegs
