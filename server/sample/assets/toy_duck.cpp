// SPDX-License-Identifier: GPL-3.0-or-later
// A bath duck of soft vinyl: blown body with head, wings and upturned tail, orange beak, painted eyes.
// The shape uses signed distances and the polynomial smooth minimum (Quilez 2013).
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

double smooth_min(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - 0.25 * h * h * width;
}

// Distance to an ellipsoid, accurate near its surface.
double ellipsoid(const Vector3d& p, const Vector3d& radii) {
  const double near = p.cwiseQuotient(radii).norm();
  const double slope = p.cwiseQuotient(radii.cwiseProduct(radii)).norm();
  return slope > 1e-9 ? near * (near - 1) / slope : -radii.minCoeff();
}

// A rotation about x that raises +z by the angle.
struct Tip {
  explicit Tip(double angle_rad) : c(std::cos(angle_rad)), s(std::sin(angle_rad)) {}
  Vector3d operator()(const Vector3d& p) const {
    return {p.x(), c * p.y() - s * p.z(), s * p.y() + c * p.z()};
  }
  double c, s;
};

constexpr double kEyeWhite_m = 0.0062, kPupil_m = 0.0049;  // radii
const Vector3d kHeadCentre(0, 0.0845, 0.0225);
constexpr double kHeadRadius = 0.0288;

double body_distance(const Vector3d& p) {
  static const Tip tail_tip(-0.78), wing_tip(-0.35);
  double d = ellipsoid(p - Vector3d(0, 0.0365, -0.003), {0.0425, 0.0375, 0.0525});
  d = smooth_min(d, ellipsoid(p - Vector3d(0, 0.036, 0.022), {0.036, 0.034, 0.034}), 0.02);  // breast
  d = smooth_min(d, ellipsoid(tail_tip(p - Vector3d(0, 0.0570, -0.0480)), {0.0165, 0.0100, 0.0280}),
                 0.024);  // tail
  d = smooth_min(d, (p - kHeadCentre).norm() - kHeadRadius, 0.012);
  d = smooth_min(d, ellipsoid(p - Vector3d(0, 0.1125, 0.017), {0.0045, 0.0055, 0.008}), 0.008);  // tuft
  // Wings: pads that rise towards the tail.
  const Vector3d side(std::abs(p.x()), p.y(), p.z());
  const double back_m = 0.5 * (-p.z() - 0.02 + std::hypot(p.z() + 0.02, 0.012));
  const Vector3d w = wing_tip(side - Vector3d(0.0385 - 0.10 * back_m, 0.044, -0.012));
  d = smooth_min(d, ellipsoid(w, {0.0085, 0.0185, 0.0310}), 0.004);
  // Flat base with a rounded edge.
  return -smooth_min(-d, p.y(), 0.006);
}

double beak_distance(const Vector3d& p) {
  static const Tip upper_tip(0.22), lower_tip(0.10);
  const double lift = 0.16 * p.x() * p.x() / 0.016;  // the corners of the mouth turn up
  const Vector3d q(p.x(), p.y() - lift, p.z());
  const double upper = ellipsoid(upper_tip(q - Vector3d(0, 0.0800, 0.0530)), {0.0165, 0.0054, 0.0175});
  const double lower = ellipsoid(lower_tip(q - Vector3d(0, 0.0738, 0.0490)), {0.0128, 0.0040, 0.0132});
  return smooth_min(upper, lower, 0.0016);
}

Vector3d eye_centre(double sign) {
  return kHeadCentre + kHeadRadius * Vector3d(sign * 0.50, 0.36, 0.79).normalized();
}

double eye_distance_m(const Vector3d& p) {
  const Vector3d d = p - eye_centre(p.x() > 0 ? 1 : -1);
  return Vector3d(d.x(), 0.82 * d.y(), d.z()).norm();
}

class Vinyl {
 public:
  explicit Vinyl(uint64_t seed) : seed_(seed) {}

  Appearance operator()(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    a.gloss = 0.32;
    a.gloss_width = 0.20;
    a.sheen = 0.12;
    a.opacity = 0.97;
    a.overlap = 0.74;
    const double cloud = fractal_noise(p / 0.02, 3, seed_);
    if (beak_distance(p) < body_distance(p)) {
      a.albedo = linear_from_hex(0xF2721A) * (1 + 0.04 * cloud);
      a.subsurface = Vector3d(0.22, 0.05, 0.0);
      nostrils(p, a);
      return a;
    }
    // The dye is slightly deeper below and bleached by the sun on top.
    a.albedo = blend(linear_from_hex(0xF5B70C), linear_from_hex(0xFFD83A), smooth_step(0.01, 0.1, p.y()));
    a.albedo *= 1 + 0.03 * cloud;
    a.subsurface = Vector3d(0.34, 0.17, 0.0);
    const double eye_m = eye_distance_m(p);
    a.albedo = blend(a.albedo, linear_from_hex(0xF6F4EC),
                     smooth_step(kEyeWhite_m + 0.0002, kEyeWhite_m - 0.0002, eye_m));
    const double pupil = smooth_step(kPupil_m + 0.0002, kPupil_m - 0.0002, eye_m);
    a.albedo = blend(a.albedo, linear_from_hex(0x0C0A08), pupil);
    a.gloss *= 1 - 0.8 * pupil;
    a.sheen *= 1 - pupil;
    if (eye_m < kEyeWhite_m) a.subsurface.setZero();
    const double sign = p.x() > 0 ? 1 : -1;
    const Vector3d catchlight = eye_centre(sign) + Vector3d(0.0013, 0.0018, 0.0006);
    a.albedo =
        blend(a.albedo, linear_from_hex(0xFFFFFF), smooth_step(0.0017, 0.0011, (p - catchlight).norm()));
    // Sprayed blush on the cheeks.
    const Vector3d cheek = kHeadCentre + kHeadRadius * Vector3d(sign * 0.80, -0.10, 0.58).normalized();
    a.albedo = blend(linear_from_hex(0xF7902A), a.albedo,
                     0.62 + 0.38 * smooth_step(0.001, 0.010, (p - cheek).norm()));
    if (s.position_m.y() < 0.0008) a.gloss = 0.0;
    return a;
  }

 private:
  static void nostrils(const Vector3d& p, Appearance& a) {
    const Vector3d n(0.0040, 0.0868, 0.0535);
    const Vector3d d(std::abs(p.x()) - n.x(), 0.4 * (p.y() - n.y()), 0.6 * (p.z() - n.z()));
    a.albedo = blend(linear_from_hex(0x9C3A06), a.albedo, smooth_step(0.0006, 0.0012, d.norm()));
  }
  uint64_t seed_;
};

}  // namespace

GaussianAsset make_toy_duck(uint64_t seed) {
  Random random(seed * 8 + 5);
  ImplicitSurface duck;
  // The beak begins 20 mm in front of this plane; behind it only the body is evaluated.
  constexpr double kBehindBeak_m = 0.015;
  duck.distance_m = [](const Vector3d& p) {
    const double body_m = body_distance(p);
    return p.z() < kBehindBeak_m ? body_m : smooth_min(body_m, beak_distance(p), 0.0022);
  };
  duck.min_m = Vector3d(-0.055, -0.004, -0.080);
  duck.max_m = Vector3d(0.055, 0.124, 0.076);
  duck.spacing_m = 0.00098;
  duck.refinement = [](const Vector3d& p) {
    if (p.z() < kBehindBeak_m) return 1.0;
    const double seam_m = std::abs(beak_distance(p) - body_distance(p));
    return std::min(0.50 + 0.50 * smooth_step(0.0066, 0.009, eye_distance_m(p)),
                    beak_distance(p) < 0.01 ? 0.60 + 0.40 * smooth_step(0.002, 0.004, seam_m) : 1.0);
  };
  SurfaceSamples samples;
  sample_implicit(duck, random, samples);
  line_up_along_edge(
      [](const SurfaceSample& s) {
        const double eye_m = eye_distance_m(s.position_m);
        return eye_m - (eye_m > 0.5 * (kEyeWhite_m + kPupil_m) ? kEyeWhite_m : kPupil_m);
      },
      0.00030, samples);
  BakeOptions options;
  options.sh_degree = 3;
  options.contact_height_m = 0.010;
  options.occlusion_cells = 112;
  options.exposure = 0.92;
  GaussianAsset asset = bake_kernels(samples, Vinyl(seed), options, random);
  stand_at_origin(asset);
  return asset;
}

}  // namespace livegs
