// SPDX-License-Identifier: GPL-3.0-or-later
// A cushion of undyed linen with indigo stripes and piping, lying on its back.
#include <algorithm>
#include <cmath>

#include "sample/sample_scene.h"
#include "sample/tools/baked_light.h"
#include "sample/tools/colour.h"
#include "sample/tools/noise.h"
#include "sample/tools/shapes.h"
#include "sample/tools/sharp_edge.h"

namespace livegs {
namespace {

using namespace sample;
using Eigen::Vector3d;

constexpr int kTop = 0, kBottom = 1, kPiping = 2;
constexpr double kHalf_m = 0.2305;
constexpr double kHalfTurn = 1.5707963267948966;

// Stripes: distance of their centre from the pillow's centre, and half their width.
struct Band {
  double centre_m, half_m;
};
constexpr Band kBands[] = {{0.085, 0.0155}, {0.0590, 0.0035}, {0.1110, 0.0035}};

class PillowShape {
 public:
  explicit PillowShape(uint64_t seed) : seed_(seed) {}

  // a and b in -1..1 are angles to the edges, so that the steep rim is sampled evenly.
  Vector3d top(double a, double b) const {
    const double s = std::sin(kHalfTurn * a), t = std::sin(kHalfTurn * b);
    const double dome = std::cos(kHalfTurn * a) * std::cos(kHalfTurn * b);
    const Vector3d flat = seam_plane(s, t);
    const double height = 0.098 * std::pow(dome, 0.66) + wrinkles(s, t, dome, seed_);
    return {flat.x(), seam_height(s, t) + height, flat.z()};
  }

  Vector3d bottom(double a, double b) const {
    const double s = std::sin(kHalfTurn * a), t = std::sin(kHalfTurn * b);
    const double dome = std::cos(kHalfTurn * a) * std::cos(kHalfTurn * b);
    const Vector3d flat = seam_plane(s, t);
    const double sag = 0.085 * std::pow(dome, 0.66) + wrinkles(s, t, dome, seed_ + 5);
    // The pillow is flattened on the floor by its own weight.
    constexpr double kFlat_m = 0.052;
    const double depth = sag - 0.5 * (sag - kFlat_m + std::sqrt((sag - kFlat_m) * (sag - kFlat_m) + 4e-5));
    return {flat.x(), seam_height(s, t) - std::max(0.0, depth), flat.z()};
  }

  // u in 0..1 is the position along the seam; corners are rounded by the stiffness of the cord.
  Vector3d seam(double u) const {
    constexpr int kReach = 3;
    constexpr double kStep = 0.0022;
    Vector3d sum = Vector3d::Zero();
    for (int i = -kReach; i <= kReach; ++i) sum += border(u + kStep * i);
    const Vector3d p = sum / (2 * kReach + 1);
    return p * (1 + 0.0015 / std::hypot(p.x(), p.z()));
  }

 private:
  Vector3d border(double u) const {
    const double side = 4 * (u - std::floor(u)), along = 2 * (side - std::floor(side)) - 1;
    const double s = side < 1 ? along : side < 2 ? 1 : side < 3 ? -along : -1;
    const double t = side < 1 ? -1 : side < 2 ? along : side < 3 ? 1 : -along;
    Vector3d p = seam_plane(s, t);
    p.y() = seam_height(s, t);
    return p;
  }

  // The filling pulls the middle of each edge inwards, so that the corners protrude slightly.
  static double pull(double along) { return 0.070 * (1 - along * along); }

  static Vector3d seam_plane(double s, double t) {
    constexpr double kBlunt = 0.08;
    return {kHalf_m * s * std::sqrt(1 - kBlunt * t * t) * (1 - pull(t) * std::abs(s)), 0,
            kHalf_m * t * std::sqrt(1 - kBlunt * s * s) * (1 - pull(s) * std::abs(t))};
  }

  double seam_height(double s, double t) const {
    return 0.004 * value_noise(Vector3d(1.1 * s, 1.1 * t, 3.0), seed_ + 17) - 0.006 * s * s * t * t;
  }

  // Gathers at the seam, longer folds from the corners, and a soft dent in the middle.
  static double wrinkles(double s, double t, double dome, uint64_t seed) {
    const double edge = std::exp(-dome / 0.22) * std::min(1.0, dome / 0.05);
    const double toward_s = std::pow(std::abs(s), 6.0) * (1 - std::pow(t, 8.0)),
                 toward_t = std::pow(std::abs(t), 6.0) * (1 - std::pow(s, 8.0));
    const double gathers = toward_s * value_noise(Vector3d(14 * t, 2.0 * s, s > 0 ? 1.5 : 8.5), seed + 1) +
                           toward_t * value_noise(Vector3d(14 * s, 2.0 * t, t > 0 ? 3.5 : 6.5), seed + 2);
    const double around = std::atan2(t, s), radius = std::hypot(s, t);
    const double corner = std::pow(std::abs(std::sin(2 * around)), 3.0) * smooth_step(0.35, 0.9, radius);
    const double folds =
        corner * value_noise(Vector3d(9 * std::cos(around), 9 * std::sin(around), 1.2 * radius), seed + 3);
    const double soft = value_noise(Vector3d(2.3 * s, 2.3 * t, 0.5), seed + 4);
    const double crease = -std::exp(-std::pow((t + 0.25 * s - 0.18 + 0.1 * soft) / 0.035, 2.0)) *
                          smooth_step(0.75, 0.2, std::abs(s + 0.1));
    return 0.0050 * edge * gathers + 0.004 * folds * std::min(1.0, dome / 0.2) +
           std::min(1.0, dome / 0.3) * (0.004 * soft + 0.0028 * crease);
  }

  uint64_t seed_;
};

// Signed distance to the nearest stripe, metres, negative inside, for a pillow centred at x = 0.
double stripe_distance_m(double x) {
  double nearest_m = 1.0;
  for (const Band& b : kBands) nearest_m = std::min(nearest_m, std::abs(std::abs(x) - b.centre_m) - b.half_m);
  return nearest_m;
}

// Finer sampling near colour changes.
double near_stripe(double x) {
  return 0.72 + 0.28 * smooth_step(0.002, 0.004, std::abs(stripe_distance_m(x)));
}

class Linen {
 public:
  explicit Linen(uint64_t seed) : seed_(seed) {}

  Appearance operator()(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    a.opacity = 0.95;
    a.overlap = 0.80;
    a.flatness = 0.16;
    if (s.part == kPiping) {
      // Cord under bias-cut cloth, with a twill line around it.
      const double twist = std::sin(420 * s.u * 6.283 + 2 * s.v);
      a.albedo = linear_from_hex(0x3C4F78) * (1 + 0.14 * twist + 0.08 * fractal_noise(p / 0.004, 2, seed_));
      return a;
    }
    // Each kernel is a piece of one warp or weft thread. Each thread has its own tone and thickness (slubs).
    // At the edge of a stripe only warp is shown, which keeps it sharp.
    const double edge_m = std::abs(stripe_distance_m(p.x()));
    a.across = edge_m < 0.004 ||
               lattice_random(static_cast<int64_t>(std::floor(p.x() / 0.0011)),
                              static_cast<int64_t>(std::floor(p.z() / 0.0011)), s.part, seed_ + 2) < 0.5;
    // dP/du is along z on the top sheet and along x on the bottom sheet.
    const bool warp = a.across;
    if (s.part == kTop) a.across = !a.across;
    a.elongation = 2.0;
    const double across_m = warp ? p.x() : p.z(), along_m = warp ? p.z() : p.x();
    const auto thread = static_cast<int64_t>(std::floor(across_m / 0.0021));
    const double tone = lattice_random(thread, warp, s.part, seed_ + 7) - 0.5;
    const double slub =
        value_noise(Vector3d(along_m / 0.022, static_cast<double>(thread) * 1.7, warp), seed_ + 9);
    const double shade =
        1 + 0.16 * tone + 0.10 * std::max(0.0, slub) + 0.03 * fractal_noise(p / 0.05, 2, seed_ + 3);
    Vector3d cloth = linear_from_hex(0xD8CCB4);
    // Stripes are woven in, so the weft keeps some of the ground colour.
    const double stripe = smooth_step(0.0003, -0.0003, stripe_distance_m(p.x()));
    cloth = blend(cloth, linear_from_hex(0x465A86), stripe * (warp ? 0.96 : 0.82));
    a.albedo = cloth * shade;
    return a;
  }

 private:
  uint64_t seed_;
};

}  // namespace

GaussianAsset make_pillow(uint64_t seed) {
  Random random(seed * 8 + 2);
  const PillowShape shape(seed * 131 + 7);
  SurfaceSamples samples;
  ParametricSurface top;
  top.u_min = top.v_min = -1;
  top.cells_u = top.cells_v = 160;
  top.spacing_m = 0.0028;
  top.part = kTop;
  ParametricSurface bottom = top;
  // dP/du x dP/dv points up for (z, x) and down for (x, z).
  top.position_m = [shape](double u, double v) { return shape.top(v, u); };
  bottom.position_m = [shape](double u, double v) { return shape.bottom(u, v); };
  bottom.part = kBottom;
  bottom.spacing_m = 0.0038;
  top.refinement = [shape](double u, double v) { return near_stripe(shape.top(v, u).x()); };
  bottom.refinement = [shape](double u, double v) { return near_stripe(shape.bottom(u, v).x()); };
  sample_surface(top, random, samples);
  sample_surface(bottom, random, samples);
  ParametricSurface piping = sweep([shape](double u) { return shape.seam(u); }, Vector3d::UnitY(),
                                   [](double) { return Eigen::Vector2d(0.0042, 0.0042); }, 0.0019, kPiping);
  piping.cells_u = 600;
  sample_surface(piping, random, samples);
  line_up_along_edge(
      [](const SurfaceSample& s) { return s.part == kPiping ? 1.0 : stripe_distance_m(s.position_m.x()); },
      0.0009, samples);
  double floor_m = 0.0;
  for (const SurfaceSample& s : samples) floor_m = std::min(floor_m, s.position_m.y());
  for (SurfaceSample& s : samples) s.position_m.y() -= floor_m;

  BakeOptions options;
  options.sh_degree = 1;
  options.contact_height_m = 0.03;
  GaussianAsset asset = bake_kernels(samples, Linen(seed), options, random);
  stand_at_origin(asset);
  return asset;
}

}  // namespace livegs
