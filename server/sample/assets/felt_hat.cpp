// SPDX-License-Identifier: GPL-3.0-or-later
// A fedora of burgundy wool felt: pinched crown, curled brim, grosgrain ribbon with a flat bow, lining and
// sweatband.
#include <algorithm>
#include <cmath>

#include "sample/sample_scene.h"
#include "sample/tools/baked_light.h"
#include "sample/tools/colour.h"
#include "sample/tools/noise.h"
#include "sample/tools/shapes.h"

namespace livegs {
namespace {

using namespace sample;
using Eigen::Vector3d;

constexpr double kSweatbandFrom_m = 0.0048, kSweatbandTo_m = 0.036;  // heights on the block
constexpr int kFelt = 0, kRibbon = 1, kBow = 2, kKnot = 3;

// The profile runs down the inside, out under the brim, around its edge, back over it and up the crown.
Profile hat_profile() {
  return Profile({{0.0, 0.1135},    {0.030, 0.1135},  {0.056, 0.1115},  {0.0705, 0.1020}, {0.0760, 0.0860},
                  {0.0785, 0.0600}, {0.0805, 0.0300}, {0.0830, 0.0120}, {0.0890, 0.0045}, {0.1000, 0.0020},
                  {0.1220, 0.0010}, {0.1450, 0.0020}, {0.1492, 0.0030}, {0.1508, 0.0050}, {0.1492, 0.0070},
                  {0.1450, 0.0068}, {0.1220, 0.0060}, {0.1020, 0.0075}, {0.0930, 0.0110}, {0.0885, 0.0180},
                  {0.0862, 0.0320}, {0.0842, 0.0600}, {0.0815, 0.0890}, {0.0755, 0.1080}, {0.0600, 0.1180},
                  {0.0320, 0.1200}, {0.0, 0.1200}});
}

// Deforms a round block to a worn hat. The front is +z.
Vector3d worn(Vector3d p) {
  const double radius = std::hypot(p.x(), p.z());
  const double front = radius > 1e-9 ? p.z() / radius : 0.0, side = radius > 1e-9 ? p.x() / radius : 0.0;
  const double high = smooth_step(0.045, 0.118, p.y());
  // A head is longer than wide; the brim is less oval.
  const double oval = 0.90 + 0.05 * smooth_step(0.09, 0.15, radius);
  p.x() *= oval;
  // The front of the crown is pinched, with a crease along the top.
  const double pinch = high * smooth_step(0.005, 0.075, p.z());
  p.x() *= 1 - 0.34 * pinch;
  const double across = p.x() / (0.026 + 0.006 * front), along = (p.z() + 0.004) / 0.058;
  p.y() -= 0.027 * high * std::exp(-across * across - std::pow(std::abs(along), 3.0));
  p.y() += 0.010 * high * smooth_step(-0.07, 0.08, p.z());
  // Brim: the sides curl up, front and back dip.
  const double out = smooth_step(0.088, 0.152, radius);
  p.y() += out * out * (0.024 * side * side - 0.009 * front * front);
  p.y() += 0.0012 * out * std::sin(3 * std::atan2(side, front) + 0.6);
  return p;
}

class HatCloth {
 public:
  HatCloth(uint64_t seed, const Profile& profile, double brim_edge)
      : seed_(seed), profile_(profile), brim_edge_(brim_edge) {}

  Appearance operator()(const SurfaceSample& s) const {
    if (s.part != kFelt) return ribbon(s);
    if (s.v < brim_edge_ && profile_.at(s.v).y() > kSweatbandFrom_m) return lining(s);
    return felt(s);
  }

 private:
  // Matted fibres of several dyed tones: short strokes in all directions.
  Appearance felt(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    const double cloud = fractal_noise(p / 0.03, 3, seed_), fibre = fractal_noise(p / 0.0019, 2, seed_ + 3);
    a.albedo = linear_from_hex(0x782C33) * (1 + 0.10 * cloud + 0.13 * fibre);
    const double stray = lattice_random(static_cast<int64_t>(std::floor(p.x() / 0.0013)),
                                        static_cast<int64_t>(std::floor(p.y() / 0.0013)),
                                        static_cast<int64_t>(std::floor(p.z() / 0.0013)), seed_ + 5);
    if (stray > 0.94) a.albedo = blend(a.albedo, linear_from_hex(0xA25A5E), 0.18);
    if (stray < 0.06) a.albedo = blend(a.albedo, linear_from_hex(0x481A20), 0.25);
    a.flatness = 0.2;
    a.overlap = 0.80;
    a.elongation = 1.9;
    a.across = stray * 8 - std::floor(stray * 8) < 0.5;
    a.bump = 0.12 * Vector3d(value_noise(p / 0.004, seed_ + 6), value_noise(p / 0.004, seed_ + 7),
                             value_noise(p / 0.004, seed_ + 8));
    return a;
  }

  Appearance lining(const SurfaceSample& s) const {
    Appearance a;
    const Vector3d& p = s.position_m;
    const double height_m = profile_.at(s.v).y();
    if (height_m < kSweatbandTo_m) {  // leather with a stitched edge
      a.albedo = linear_from_hex(0x7B4E2E) * (1 + 0.12 * fractal_noise(p / 0.004, 3, seed_ + 21));
      if (height_m > kSweatbandTo_m - 0.003) a.albedo *= std::sin(s.u * 160) > 0 ? 1.7 : 0.55;
      a.gloss = 0.06;
      a.gloss_width = 0.4;
    } else {
      a.albedo = linear_from_hex(0xC9B38E) *
                 (1 + 0.05 * std::sin(s.u * 90) + 0.04 * fractal_noise(p / 0.01, 2, seed_));
      a.gloss = 0.08;
      a.gloss_width = 0.4;
    }
    return a;
  }

  // Grosgrain: ribs along the ribbon's width, two millimetres apart, with finer structure.
  Appearance ribbon(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    const double rib = s.part == kRibbon ? std::sin(s.u * 290) : std::sin(s.u * (s.part == kKnot ? 40 : 150));
    a.albedo = linear_from_hex(0x2B2430) * (1 + 0.28 * rib + 0.10 * fractal_noise(p / 0.003, 2, seed_ + 31));
    if (s.part != kKnot && (s.v < 0.07 || s.v > 0.93)) a.albedo *= 1.9;  // selvedge
    a.gloss = 0.10;
    a.gloss_width = 0.4;
    a.overlap = 0.74;
    return a;
  }

  uint64_t seed_;
  const Profile& profile_;
  double brim_edge_;
};

}  // namespace

GaussianAsset make_felt_hat(uint64_t seed) {
  Random random(seed * 8 + 3);
  const Profile profile = hat_profile();
  const double soft = 0.0018;
  double brim_edge = 0.0;  // share of the profile at which the edge of the brim lies
  for (int i = 0; i <= 512; ++i)
    if (profile.at(i / 512.0).x() > profile.at(brim_edge).x()) brim_edge = i / 512.0;
  const auto shaped = [soft, seed](Vector3d p) {
    const Vector3d q = worn(p);
    return Vector3d(q + soft * Vector3d(value_noise(q / 0.05, seed + 71), value_noise(q / 0.05, seed + 72),
                                        value_noise(q / 0.05, seed + 73)));
  };
  SurfaceSamples samples;
  ParametricSurface felt = lathe(profile, 0.0023, kFelt);
  felt.position_m = [profile, shaped](double u, double v) { return shaped(profile.turned(v, u)); };
  felt.cells_u = 128;
  felt.refinement = [brim_edge](double, double v) { return v < brim_edge - 0.02 ? 1.0 : 0.88; };
  sample_surface(felt, random, samples);

  // The ribbon lies 1.2 mm off the felt, with its edges turned in.
  const auto crown_radius_m = [profile, brim_edge](double y) { return profile.radius_at(y, brim_edge, 1.0); };
  const double low_m = 0.0135, high_m = 0.0455;
  ParametricSurface ribbon = lathe(profile, 0.0018, kRibbon);
  ribbon.cells_v = 24;
  ribbon.position_m = [=](double u, double v) {
    const double y = low_m + (high_m - low_m) * v;
    const double off_m = 0.0018 * std::min(1.0, std::min(v, 1 - v) / 0.04);
    const double r = crown_radius_m(y) + off_m;
    return shaped({r * std::sin(u), y, r * std::cos(u)});
  };
  sample_surface(ribbon, random, samples);

  // The bow is on the wearer's left (+x): two flat loops and a knot over their middle.
  const double middle = 1.5707963;
  ParametricSurface bow = ribbon;
  bow.part = kBow;
  bow.u_min = -1;
  bow.cells_u = 48;
  bow.u_max = 1;
  bow.spacing_m = 0.0016;
  bow.position_m = [=](double u, double v) {
    const double waist = 0.62 + 0.38 * smooth_step(0.05, 0.6, std::abs(u));
    const double y = 0.5 * (low_m + high_m) + (v - 0.5) * 0.0265 * waist;
    const double tip = 1 - 0.16 * (2 * std::abs(v - 0.5));  // swallow-tail ends
    const double bulge_m = 0.0050 * std::sin(3.14159 * std::min(1.0, std::abs(u))) + 0.0022;
    const double off_m = bulge_m * (1 - 0.25 * std::pow(2 * v - 1, 2.0));
    const double angle = middle + 0.34 * u * tip, r = crown_radius_m(y) + off_m;
    return shaped({r * std::sin(angle), y, r * std::cos(angle)});
  };
  sample_surface(bow, random, samples);
  ParametricSurface knot = bow;
  knot.part = kKnot;
  knot.position_m = [=](double u, double v) {
    const double y = 0.5 * (low_m + high_m) + (v - 0.5) * 0.025;
    const double angle = middle + 0.062 * u;
    const double r =
        crown_radius_m(y) + 0.0012 +
        0.0045 * std::sqrt(std::max(0.0, 1 - u * u)) * std::pow(std::max(0.0, std::sin(3.14159 * v)), 0.4);
    return shaped({r * std::sin(angle), y, r * std::cos(angle)});
  };
  sample_surface(knot, random, samples);

  double floor_m = 1.0;
  for (const SurfaceSample& s : samples) floor_m = std::min(floor_m, s.position_m.y());
  for (SurfaceSample& s : samples) s.position_m.y() -= floor_m;
  BakeOptions options;
  options.sh_degree = 1;
  options.contact_height_m = 0.02;
  options.occlusion_cells = 84;
  GaussianAsset asset = bake_kernels(samples, HatCloth(seed, profile, brim_edge), options, random);
  stand_at_origin(asset);
  return asset;
}

}  // namespace livegs
