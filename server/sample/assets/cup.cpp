// SPDX-License-Identifier: GPL-3.0-or-later
// A thrown stoneware cup: unglazed clay foot, speckled cream glaze with two painted cobalt rings, celadon
// inside.
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

constexpr int kBody = 0, kHandle = 1;
constexpr double kInsideStartShare = 0.56;  // share of the profile at which it passes the lip

Profile cup_profile() {
  return Profile({{0.0, 0.0045},    {0.0190, 0.0045}, {0.0215, 0.0035}, {0.0228, 0.0008}, {0.0250, 0.0},
                  {0.0272, 0.0010}, {0.0282, 0.0035}, {0.0310, 0.0080}, {0.0362, 0.0165}, {0.0395, 0.0290},
                  {0.0409, 0.0450}, {0.0414, 0.0650}, {0.0416, 0.0850}, {0.0419, 0.0960}, {0.0416, 0.0990},
                  {0.0403, 0.1000}, {0.0390, 0.0990}, {0.0386, 0.0955}, {0.0382, 0.0830}, {0.0379, 0.0600},
                  {0.0370, 0.0400}, {0.0342, 0.0240}, {0.0290, 0.0148}, {0.0200, 0.0100}, {0.0100, 0.0087},
                  {0.0, 0.0084}});
}

class CupGlaze {
 public:
  explicit CupGlaze(uint64_t seed) : seed_(seed) {}

  Appearance operator()(const SurfaceSample& s) const {
    const Vector3d p = s.position_m;
    const bool inside = s.part == kBody && s.v > kInsideStartShare;
    Appearance a;
    a.gloss = 0.40;
    a.gloss_width = 0.10;
    a.sheen = 0.16;
    a.opacity = 0.97;
    a.overlap = 0.75;
    const double cloud = fractal_noise(p / 0.018, 3, seed_);
    if (inside) {
      // The celadon is deeper and bluer towards the bottom.
      const double depth = smooth_step(0.085, 0.012, p.y());
      a.albedo = blend(linear_from_hex(0xC3DDD0), linear_from_hex(0x6FA79C), depth);
      a.albedo *= 1 + 0.05 * cloud;
    } else {
      a.albedo = linear_from_hex(0xE4D8C2) * (1 + 0.035 * cloud);
    }
    speckle(p, a);
    if (!inside) paint(p, s.part, a);
    // The glaze is thin on the lip, where the warm clay shows through.
    const double lip = s.part == kBody ? smooth_step(0.0978, 0.0993, p.y()) : 0.0;
    a.albedo = blend(a.albedo, linear_from_hex(0xA9794F), 0.65 * lip);
    if (s.part == kBody && !inside) bare_foot(p, a);
    return a;
  }

  // Signed distance to the nearest painted ring, metres, negative under the paint. The brush line wavers.
  double ring_distance_m(const Vector3d& p) const {
    const double angle = std::atan2(p.x(), p.z());
    const Vector3d around(4.4 * std::cos(angle), 4.4 * std::sin(angle), 0.0);
    const double height_m = p.y() + 0.0006 * fractal_noise(around, 2, seed_ + 41);
    return std::min({std::abs(height_m - 0.0800) - 0.0037, std::abs(height_m - 0.0722) - 0.0008,
                     std::abs(height_m - 0.0315) - 0.0009});
  }

 private:
  // Iron specks of 0.3 to 1.3 mm with a brown halo.
  void speckle(const Vector3d& p, Appearance& a) const {
    const double fine = speckle_distance(p / 0.0034, 0.26, 0.08, 0.24, seed_ + 11) * 0.0034;
    const double coarse = speckle_distance(p / 0.009, 0.20, 0.05, 0.13, seed_ + 29) * 0.009;
    a.albedo = blend(linear_from_hex(0x7A5A3E), a.albedo, 0.35 + 0.65 * smooth_step(-0.0002, 0.0003, fine));
    a.albedo = blend(linear_from_hex(0x3E2B20), a.albedo, smooth_step(-0.0003, 0.0004, coarse));
  }

  // Brushed cobalt: wavering edges, and a thinner colour where the brush was dry.
  void paint(const Vector3d& p, int part, Appearance& a) const {
    if (part == kHandle) return;
    const double angle = std::atan2(p.x(), p.z());
    const double cover = smooth_step(0.0002, -0.0002, ring_distance_m(p));
    const double streak = fractal_noise(Vector3d(angle * 5.0, p.y() / 0.0011, 0.0), 3, seed_ + 43);
    const Vector3d cobalt = blend(linear_from_hex(0x21408F), linear_from_hex(0x5C7FC4), 0.5 + 0.5 * streak);
    a.albedo = blend(a.albedo, cobalt, 0.94 * cover);
  }

  void bare_foot(const Vector3d& p, Appearance& a) const {
    const double angle = std::atan2(p.x(), p.z());
    const double edge_m =
        0.0128 +
        0.0012 * fractal_noise(Vector3d(3 * std::cos(angle), 3 * std::sin(angle), 7.0), 2, seed_ + 53);
    const double bare = smooth_step(edge_m + 0.0004, edge_m - 0.0004, p.y());
    // The glaze is thicker at its edge.
    const double drop = smooth_step(0.0012, 0.0, std::abs(p.y() - edge_m - 0.0007));
    a.albedo = blend(a.albedo, linear_from_hex(0xC7AE88), 0.45 * drop);
    const Vector3d clay = linear_from_hex(0xB98E66) * (1 + 0.10 * fractal_noise(p / 0.0016, 2, seed_ + 59));
    a.albedo = blend(a.albedo, clay, bare);
    a.gloss *= 1 - bare;
    a.sheen *= 1 - bare;
  }

  uint64_t seed_;
};

}  // namespace

GaussianAsset make_cup(uint64_t seed) {
  Random random(seed * 8 + 1);
  const Profile profile = cup_profile();
  // Thrown by hand: slightly oval.
  const double oval = 0.004 + 0.004 * random.uniform(), turn = random.uniform(0, 6.28);
  SurfaceSamples samples;
  ParametricSurface body = lathe(profile, 0.00104, kBody);
  body.position_m = [profile, oval, turn](double u, double v) {
    Vector3d p = profile.turned(v, u);
    const double round = 1 + oval * std::cos(2 * (u - turn));
    return Vector3d(p.x() * round, p.y(), p.z() * round);
  };
  // Finer at the brush lines and the lip.
  body.refinement = [profile](double, double v) {
    const double y = profile.at(v).y();
    if (v > kInsideStartShare) return 1.0;
    const double edge_m =
        std::min({std::abs(y - 0.0762), std::abs(y - 0.0838), std::abs(y - 0.0722), std::abs(y - 0.0315)});
    return 0.66 + 0.34 * smooth_step(0.0012, 0.0026, edge_m);
  };
  sample_surface(body, random, samples);

  const auto spine = curve_through({{0.0375, 0.0795, 0},
                                    {0.0480, 0.0835, 0},
                                    {0.0600, 0.0815, 0},
                                    {0.0680, 0.0715, 0},
                                    {0.0695, 0.0570, 0},
                                    {0.0640, 0.0440, 0},
                                    {0.0520, 0.0355, 0},
                                    {0.0370, 0.0325, 0}});
  ParametricSurface handle = sweep(
      spine, Vector3d::UnitZ(),
      [](double u) {
        const double flare = std::exp(-u / 0.07) + std::exp(-(1 - u) / 0.07);
        return Eigen::Vector2d(0.0062 + 0.0045 * flare, 0.0040 + 0.0028 * flare);
      },
      0.00095, kHandle);
  handle.keep = [profile](const Vector3d& p) {
    return std::hypot(p.x(), p.z()) > profile.radius_at(p.y(), 0.1, kInsideStartShare) - 0.0003;
  };
  sample_surface(handle, random, samples);

  const CupGlaze glaze(seed);
  line_up_along_edge(
      [&glaze](const SurfaceSample& s) {
        const bool painted =
            s.part == kBody && s.v < kInsideStartShare && s.position_m.y() > 0.025 && s.position_m.y() < 0.09;
        return painted ? glaze.ring_distance_m(s.position_m) : 1.0;
      },
      0.00035, samples);

  BakeOptions options;
  options.sh_degree = 3;
  options.contact_height_m = 0.008;
  options.sky_directions = 80;
  options.exposure = 0.96;
  GaussianAsset asset = bake_kernels(samples, glaze, options, random);
  stand_at_origin(asset);
  return asset;
}

}  // namespace livegs
