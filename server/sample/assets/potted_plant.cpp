// SPDX-License-Identifier: GPL-3.0-or-later
// A spider plant: arching striped blades in a terracotta pot on its saucer.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sample/sample_scene.h"
#include "sample/tools/baked_light.h"
#include "sample/tools/colour.h"
#include "sample/tools/noise.h"
#include "sample/tools/shapes.h"

namespace livegs {
namespace {

using namespace sample;
using Eigen::Vector3d;

constexpr int kPot = 0, kSaucer = 1, kSoil = 2, kLeaf = 3;  // leaves are numbered 3, 4, 5, ...
constexpr int kLeafCount = 36;
constexpr double kSoil_m = 0.1235;
constexpr double kHeight_m = 0.50;

Profile pot_profile() {
  return Profile({{0.0, 0.006},
                  {0.040, 0.006},
                  {0.0455, 0.0065},
                  {0.0478, 0.0090},
                  {0.0520, 0.0400},
                  {0.0580, 0.0840},
                  {0.0600, 0.0990},
                  {0.0600, 0.0990},
                  {0.0655, 0.0995},
                  {0.0672, 0.1015},
                  {0.0695, 0.1180},
                  {0.0715, 0.1350},
                  {0.0712, 0.1385},
                  {0.0695, 0.1400},
                  {0.0672, 0.1395},
                  {0.0658, 0.1370},
                  {0.0648, 0.1280},
                  {0.0640, 0.1180}});
}

Profile saucer_profile() {
  return Profile({{0.0, 0.0},
                  {0.0600, 0.0},
                  {0.0650, 0.0012},
                  {0.0690, 0.0045},
                  {0.0775, 0.0180},
                  {0.0772, 0.0200},
                  {0.0755, 0.0205},
                  {0.0735, 0.0195},
                  {0.0660, 0.0085},
                  {0.0620, 0.0060},
                  {0.0, 0.0055}});
}

// One blade: its spine, lateral direction and width, as functions of the relative distance to the tip.
struct Blade {
  static constexpr int kSteps = 64;
  std::array<Vector3d, kSteps + 1> spine;
  std::array<Vector3d, kSteps + 1> across;
  double length_m = 0.0, width_m = 0.0, roll = 0.0, brown = 0.0, tone = 0.0;

  double half_width_m(double s) const {
    const double shape = std::pow(s + 0.02, 0.32) * std::pow(std::max(0.0, 1.0 - s), 0.85);
    return 0.5 * width_m * shape / 0.519 + 0.0003;  // 0.519 is the maximum of the shape
  }
  Vector3d at(double s, double q) const {
    const double place = std::clamp(s, 0.0, 1.0) * kSteps;
    const int i = std::min(static_cast<int>(place), kSteps - 1);
    const double t = place - i;
    const Vector3d centre = spine[i] + (spine[i + 1] - spine[i]) * t;
    const Vector3d side = (across[i] + (across[i + 1] - across[i]) * t).normalized();
    const Vector3d along = (spine[std::min(i + 2, kSteps)] - spine[std::max(i - 1, 0)]).normalized();
    const Vector3d up = side.cross(along);
    const double half_m = half_width_m(s);
    // Folded along the middle, most at the base.
    const double fold = 0.62 - 0.35 * s;
    return centre + side * (half_m * q * (1 - 0.12 * fold)) +
           up * (half_m * fold * (std::sqrt(q * q + 0.03) - 0.17));
  }
};

Blade grow(int index, Random& random) {
  Blade blade;
  // Old blades are at the outside and hang; young ones stand upright in the middle.
  const double age = (index + 0.5) / kLeafCount;
  const double azimuth = 2.399963229728653 * index + 0.35 * random.uniform(-1, 1);
  double elevation = 1.52 - 0.70 * std::pow(age, 0.9) + 0.08 * random.uniform(-1, 1);
  blade.length_m =
      (0.30 + 0.17 * std::sin(std::numbers::pi * (0.18 + 0.70 * age))) * (1 + 0.12 * random.uniform(-1, 1));
  blade.width_m = 0.021 + 0.008 * random.uniform();
  blade.brown = random.uniform();
  blade.tone = random.uniform(-1, 1);
  const double bend = 0.55 + 1.75 * std::pow(age, 0.75) + 0.25 * random.uniform(-1, 1);
  const double sway = 0.5 * random.uniform(-1, 1), twist = 0.9 * random.uniform(-1, 1);
  Vector3d p(0.026 * age * std::sin(azimuth), kSoil_m - 0.004, 0.026 * age * std::cos(azimuth));
  for (int i = 0; i <= Blade::kSteps; ++i) {
    const double s = static_cast<double>(i) / Blade::kSteps;
    const double heading = azimuth + sway * s * s;
    const double rise = elevation - bend * std::pow(s, 1.7);
    const Vector3d out(std::sin(heading), 0, std::cos(heading));
    const Vector3d along = std::cos(rise) * out + std::sin(rise) * Vector3d::UnitY();
    const Vector3d level = Vector3d::UnitY().cross(out);
    const Vector3d up = along.cross(level);
    const double roll = twist * s * s;
    blade.spine[i] = p;
    blade.across[i] = std::cos(roll) * level + std::sin(roll) * up;
    p += along * (blade.length_m / Blade::kSteps);
  }
  return blade;
}

class PlantSkin {
 public:
  PlantSkin(uint64_t seed, const std::vector<Blade>& blades) : seed_(seed), blades_(blades) {}

  Appearance operator()(const SurfaceSample& s) const {
    if (s.part >= kLeaf) return leaf(s);
    if (s.part == kSoil) return soil(s);
    return terracotta(s);
  }

 private:
  Appearance leaf(const SurfaceSample& s) const {
    const Blade& blade = blades_[s.part - kLeaf];
    const double along = s.u, q = s.v;
    Appearance a;
    a.two_sided = true;
    a.translucency = 0.30;
    a.gloss = 0.13;
    a.gloss_width = 0.35;
    a.overlap = 0.74;
    a.opacity = 0.97;
    a.flatness = 0.14;
    // A cream stripe along the middle with a streaked edge, and parallel veins next to it.
    const double streak = value_noise(Vector3d(along * 14, q * 9, s.part), seed_ + 1);
    const double stripe = smooth_step(0.40, 0.26, std::abs(q) + 0.07 * streak) *
                          smooth_step(0.0, 0.10, along) * smooth_step(0.99, 0.86, along);
    const double vein =
        std::sin(q * 26) * 0.5 + 0.5 * value_noise(Vector3d(along * 5, q * 22, s.part), seed_ + 2);
    Vector3d green =
        blend(linear_from_hex(0x2F6B2A), linear_from_hex(0x6CA63E), smooth_step(0.0, 1.0, along));
    green *= 1 + 0.14 * vein + 0.14 * blade.tone;
    const Vector3d pale = blend(linear_from_hex(0xC9D58C), linear_from_hex(0xE6E7B4), 0.5 + 0.5 * streak);
    Vector3d albedo = blend(green, pale, 0.92 * stripe);
    albedo = blend(albedo, linear_from_hex(0xD5DDB0), 0.75 * smooth_step(0.16, 0.0, along));  // pale base
    const double scorch = smooth_step(0.965 - 0.03 * blade.brown, 0.992, along + 0.01 * streak);
    albedo = blend(albedo, linear_from_hex(0x8A6234), scorch * smooth_step(0.25, 0.6, blade.brown));
    a.albedo = albedo;
    a.back_albedo = blend(albedo, linear_from_hex(0xA9BF86), 0.28);
    return a;
  }

  Appearance terracotta(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    a.overlap = 0.76;
    a.sheen = 0.05;
    a.gloss = 0.05;
    a.gloss_width = 0.5;
    const double angle = std::atan2(p.x(), p.z());
    const double cloud = fractal_noise(p / 0.035, 4, seed_ + 11),
                 grit = fractal_noise(p / 0.0022, 2, seed_ + 12);
    a.albedo = linear_from_hex(s.part == kPot ? 0xC4693F : 0xB86540) * (1 + 0.13 * cloud + 0.08 * grit);
    // Turning marks, and a lime bloom on the lower part of the wall.
    a.albedo *= 1 + 0.04 * std::sin(p.y() / 0.0011) * (0.5 + 0.5 * cloud);
    const double bloom = smooth_step(
        0.05, 0.55,
        fractal_noise(Vector3d(4 * std::cos(angle), 4 * std::sin(angle), p.y() / 0.03), 3, seed_ + 13) +
            0.5 * smooth_step(0.075, 0.01, p.y()) - 0.12);
    a.albedo = blend(a.albedo, linear_from_hex(0xE3CDBB), 0.30 * bloom);
    if (s.part == kPot && std::hypot(p.x(), p.z()) < 0.0665 && p.y() > 0.11)
      a.albedo *= 0.55 + 0.45 * smooth_step(0.120, 0.136, p.y());
    return a;
  }

  Appearance soil(const SurfaceSample& s) const {
    const Vector3d& p = s.position_m;
    Appearance a;
    a.overlap = 0.85;
    a.flatness = 0.35;
    const double grain = fractal_noise(p / 0.004, 3, seed_ + 21);
    a.albedo = blend(linear_from_hex(0x2E2019), linear_from_hex(0x5E4535), 0.5 + 0.6 * grain);
    const double perlite = speckle_distance(p / 0.008, 0.16, 0.12, 0.24, seed_ + 23);
    a.albedo = blend(linear_from_hex(0xD9D4C8), a.albedo, smooth_step(-0.02, 0.05, perlite));
    a.bump = 0.5 * Vector3d(value_noise(p / 0.003, seed_ + 24), 0, value_noise(p / 0.003, seed_ + 25));
    return a;
  }

  uint64_t seed_;
  const std::vector<Blade>& blades_;
};

}  // namespace

GaussianAsset make_potted_plant(uint64_t seed) {
  Random random(seed * 8 + 4);
  SurfaceSamples samples;
  ParametricSurface pot = lathe(pot_profile(), 0.0021, kPot);
  sample_surface(pot, random, samples);
  ParametricSurface saucer = lathe(saucer_profile(), 0.0022, kSaucer);
  saucer.keep = [](const Vector3d& p) { return p.y() < 0.003 || std::hypot(p.x(), p.z()) > 0.046; };
  sample_surface(saucer, random, samples);
  ParametricSurface soil;
  soil.part = kSoil;
  soil.spacing_m = 0.0020;
  soil.u_max = 2 * std::numbers::pi;
  soil.cells_u = soil.cells_v = 64;
  soil.position_m = [seed](double u, double v) {
    // v runs from the rim inwards, so that the patch faces up.
    const double r = 0.0648 * (1 - v);
    const Vector3d flat(r * std::sin(u), 0, r * std::cos(u));
    const double bumps = 0.0035 * fractal_noise(flat / 0.012, 3, seed + 81);
    return Vector3d(flat.x(), kSoil_m + bumps + 0.004 * (1 - r / 0.065), flat.z());
  };
  sample_surface(soil, random, samples);

  std::vector<Blade> blades;
  double top_m = 0.0;
  for (int i = 0; i < kLeafCount; ++i) {
    blades.push_back(grow(i, random));
    for (const Vector3d& p : blades.back().spine) top_m = std::max(top_m, p.y());
  }
  // Scaled so that the tallest blade has the specified height.
  const double grow_by = (kHeight_m - kSoil_m) / (top_m - kSoil_m);
  for (int i = 0; i < kLeafCount; ++i) {
    Blade& blade = blades[i];
    blade.length_m *= grow_by;
    for (Vector3d& p : blade.spine) {
      p = Vector3d(p.x() * grow_by, kSoil_m + (p.y() - kSoil_m) * grow_by, p.z() * grow_by);
      p.y() = std::max(p.y(), 0.012);
    }
    constexpr double kStretch = 2.2;
    ParametricSurface leaf;
    leaf.part = kLeaf + i;
    leaf.spacing_m = 0.0020;
    leaf.stretch = kStretch;
    leaf.v_min = -1;
    leaf.cells_u = 64;
    leaf.cells_v = 12;
    leaf.position_m = [&blade](double u, double v) { return blade.at(u, v); };
    leaf.metric = [&blade](double u, double v, const Vector3d&) {
      return Vector3d(u * blade.length_m / kStretch, v * blade.half_width_m(u), 0);
    };
    sample_surface(leaf, random, samples);
  }

  BakeOptions options;
  options.sh_degree = 2;
  options.contact_height_m = 0.03;
  options.occlusion_cells = 96;
  GaussianAsset asset = bake_kernels(samples, PlantSkin(seed, blades), options, random);
  stand_at_origin(asset);
  return asset;
}

}  // namespace livegs
