// SPDX-License-Identifier: GPL-3.0-or-later
// A workshop stool in oiled oak: a dished round seat of three boards, four turned legs with wedged tenons
// that show as end grain in the seat, and a ring of stretchers.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sample/sample_scene.h"
#include "sample/tools/baked_light.h"
#include "sample/tools/colour.h"
#include "sample/tools/noise.h"
#include "sample/tools/shapes.h"
#include "sample/tools/wood.h"

namespace livegs {
namespace {

using namespace sample;
using Eigen::Vector3d;

constexpr int kSeat = 0, kLeg = 1, kStretcher = 5;  // legs 1..4, stretchers 5..8
constexpr double kSeatRadius_m = 0.165, kUnderside_m = 0.4180;

Vector3d leg_top(int leg) {
  const double angle = std::numbers::pi / 4 + std::numbers::pi / 2 * leg;
  return {0.100 * std::sin(angle), 0.430, 0.100 * std::cos(angle)};
}
Vector3d leg_foot(int leg) {
  const double angle = std::numbers::pi / 4 + std::numbers::pi / 2 * leg;
  return {0.178 * std::sin(angle), 0.0, 0.178 * std::cos(angle)};
}
Vector3d leg_at(int leg, double height_m) {
  const double share = height_m / 0.430;
  return leg_foot(leg) + (leg_top(leg) - leg_foot(leg)) * share;
}

Profile seat_profile() {
  return Profile({{0.0, kUnderside_m},
                  {0.060, kUnderside_m},
                  {0.130, kUnderside_m},
                  {0.147, 0.4190},
                  {0.1590, 0.4255},
                  {0.1640, 0.4330},
                  {kSeatRadius_m, 0.4400},
                  {0.1638, 0.4462},
                  {0.1600, 0.4492},
                  {0.1540, 0.4500},
                  {0.1380, 0.4492},
                  {0.100, 0.4462},
                  {0.050, 0.4442},
                  {0.0, 0.4438}});
}

// Radius by height along the leg, from foot to top: taper, two beads, a vase, the shoulder.
Profile leg_profile() {
  return Profile({{0.0, 0.0},      {0.0100, 0.0005}, {0.0118, 0.0035}, {0.0124, 0.012}, {0.0150, 0.070},
                  {0.0172, 0.118}, {0.0178, 0.128},  {0.0150, 0.1345}, {0.0150, 0.138}, {0.0182, 0.144},
                  {0.0188, 0.150}, {0.0182, 0.156},  {0.0152, 0.162},  {0.0152, 0.166}, {0.0185, 0.173},
                  {0.0205, 0.190}, {0.0210, 0.215},  {0.0200, 0.250},  {0.0176, 0.300}, {0.0158, 0.335},
                  {0.0150, 0.352}, {0.0175, 0.358},  {0.0180, 0.3635}, {0.0172, 0.369}, {0.0148, 0.375},
                  {0.0150, 0.390}, {0.0155, 0.430}});
}

class OiledOak {
 public:
  explicit OiledOak(uint64_t seed) : seed_(seed) {
    tone_.early = linear_from_hex(0xCB9A63);
    tone_.late = linear_from_hex(0x94602F);
  }

  Appearance operator()(const SurfaceSample& s) const {
    Appearance a;
    a.gloss = 0.16;
    a.gloss_width = 0.30;
    a.sheen = 0.06;
    a.overlap = 0.78;
    a.opacity = 0.96;
    if (s.part == kSeat)
      seat(s, a);
    else
      turned(s, a);
    return a;
  }

 private:
  void seat(const SurfaceSample& s, Appearance& a) const {
    const Vector3d& p = s.position_m;
    // Three boards, each cut from a different part of the log.
    const int board = p.z() < -0.052 ? 0 : p.z() < 0.060 ? 1 : 2;
    const double shift_m[3] = {0.031, 0.0, -0.022};
    const double depth_m[3] = {0.052, 0.070, 0.045};
    const double middle_m[3] = {-0.108, 0.004, 0.112};
    const Vector3d grain(p.x() + 0.4 * board, p.y() - 0.45 + depth_m[board] + 0.06 * p.x(),
                         p.z() - middle_m[board] + shift_m[board]);
    WoodTone tone = tone_;
    tone.ring_m = 0.0075;
    a.albedo = wood_albedo(grain, tone, seed_ + 100 * board) * (1.0 + 0.07 * (board - 1));
    const double joint_m = std::min(std::abs(p.z() + 0.052), std::abs(p.z() - 0.060));
    a.albedo *= 0.55 + 0.45 * smooth_step(0.0003, 0.0016, joint_m);
    for (int leg = 0; leg < 4; ++leg) tenon(leg, p, a);
    // Darker at the edge, from handling.
    a.albedo *= 1 - 0.10 * smooth_step(0.150, 0.165, std::hypot(p.x(), p.z()));
  }

  void tenon(int leg, const Vector3d& p, Appearance& a) const {
    if (p.y() < 0.44) return;
    Vector3d d = p - leg_at(leg, 0.447);
    d.y() = 0;
    const double distance_m = d.norm();
    if (distance_m > 0.018) return;
    const Vector3d end_grain(0.3 * leg, d.x() + 0.02, d.z() + 0.011);
    WoodTone tone = tone_;
    tone.ring_m = 0.0035;
    Vector3d round = 0.72 * wood_albedo(end_grain, tone, seed_ + 900 + leg);
    const double wedge_m = std::abs(d.x());
    round = blend(linear_from_hex(0x5A3517), round, smooth_step(0.0007, 0.0016, wedge_m));
    a.albedo = blend(round, a.albedo, smooth_step(0.0143, 0.0149, distance_m));
    a.albedo *= 1 - 0.45 * smooth_step(0.0013, 0.0003, std::abs(distance_m - 0.0148));
  }

  void turned(const SurfaceSample& s, Appearance& a) const {
    const Vector3d& p = s.position_m;
    const bool leg = s.part < kStretcher;
    const int other = leg ? s.part - kLeg : s.part - kStretcher;
    // Grain along the piece: legs are nearly vertical, stretchers horizontal.
    Vector3d grain;
    if (leg) {
      const Vector3d off = p - leg_at(other, p.y());
      grain = Vector3d(p.y(), off.x() + 0.028, off.z() + 0.012);
    } else {
      const bool along_x = other % 2 == 0;
      grain = Vector3d(along_x ? p.x() : p.z(), p.y() - 0.14, (along_x ? p.z() : p.x()) * 0.9 + 0.03);
    }
    WoodTone tone = tone_;
    tone.ring_m = 0.0060;
    tone.late = blend(tone.early, tone.late, 0.7);
    a.albedo = wood_albedo(grain, tone, seed_ + 300 + 17 * s.part);
    if (leg) {
      // Dirt and oil in the grooves of the turning; scuffed feet.
      const double share = p.y();
      for (const double groove_m : {0.1363, 0.164, 0.3535, 0.374})
        a.albedo *= 1 - 0.30 * smooth_step(0.005, 0.0, std::abs(share - groove_m));
      a.albedo *= 1 - 0.25 * smooth_step(0.02, 0.0, p.y());
    }
  }

  uint64_t seed_;
  WoodTone tone_;
};

}  // namespace

GaussianAsset make_wooden_stool(uint64_t seed) {
  Random random(seed * 8 + 6);
  SurfaceSamples samples;
  const Profile seat_curve = seat_profile();
  // The seat is a polar patch with kernels stretched along the boards (x), so distances in x count less.
  constexpr double kStretch = 1.7;
  ParametricSurface seat = lathe(seat_curve, 0.0021, kSeat);
  seat.stretch = kStretch;
  seat.metric = [](double, double, const Vector3d& p) { return Vector3d(p.x() / kStretch, p.y(), p.z()); };
  seat.cells_v = 256;
  seat.refinement = [seat_curve](double u, double v) {
    const Eigen::Vector2d p = seat_curve.at(v);
    if (p.y() < 0.44) return 1.0;
    const Vector3d at(p.x() * std::sin(u), 0, p.x() * std::cos(u));
    double nearest_m = 1.0;
    for (int leg = 0; leg < 4; ++leg) {
      Vector3d tenon = leg_at(leg, 0.447);
      tenon.y() = 0;
      nearest_m = std::min(nearest_m, (at - tenon).norm());
    }
    return 0.55 + 0.45 * smooth_step(0.017, 0.022, nearest_m);
  };
  sample_surface(seat, random, samples);
  for (SurfaceSample& s : samples) {
    Vector3d along = Vector3d::UnitX() - s.normal * s.normal.x();
    if (along.norm() > 0.5) {
      s.tangent = along.normalized();
    } else {  // end of the boards: round kernels
      s.stretch = 1.0;
    }
  }

  const Profile leg_curve = leg_profile();
  for (int leg = 0; leg < 4; ++leg) {
    ParametricSurface turned;
    turned.part = kLeg + leg;
    turned.spacing_m = 0.0020;
    turned.stretch = 1.5;
    turned.u_max = 1;
    turned.v_max = 2 * std::numbers::pi;
    turned.cells_u = 256;
    turned.cells_v = 32;
    // u runs down the leg and v around it, so that the long axis of the kernels follows the grain.
    const Vector3d axis = (leg_top(leg) - leg_foot(leg)) / 0.430;
    const Vector3d foot = leg_foot(leg);
    turned.position_m = [leg_curve, axis, foot](double u, double v) {
      const Eigen::Vector2d p = leg_curve.at(1 - u);
      return Vector3d(foot + axis * p.y() + Vector3d(p.x() * std::sin(v), 0, p.x() * std::cos(v)));
    };
    turned.metric = [](double, double, const Vector3d& p) { return Vector3d(p.x(), p.y() / 1.5, p.z()); };
    turned.keep = [](const Vector3d& p) { return p.y() < kUnderside_m + 0.001; };
    sample_surface(turned, random, samples);
  }
  for (int side = 0; side < 4; ++side) {
    const double height_m = side % 2 == 0 ? 0.1500 : 0.2150;
    const Vector3d from = leg_at((side + 3) % 4, height_m), to = leg_at(side, height_m);
    const bool along_x = std::abs(from.x() - to.x()) > std::abs(from.z() - to.z());
    ParametricSurface rail =
        sweep([from, to](double u) { return Vector3d(from + (to - from) * u); }, Vector3d::UnitY(),
              [](double u) {
                const double r = 0.0078 + 0.0035 * std::sin(std::numbers::pi * u);
                return Eigen::Vector2d(r, r);
              },
              0.0021, kStretcher + (along_x ? 0 : 1) + 2 * (side / 2));
    rail.stretch = 1.5;
    rail.metric = [along_x](double, double, const Vector3d& p) {
      return along_x ? Vector3d(p.x() / 1.5, p.y(), p.z()) : Vector3d(p.x(), p.y(), p.z() / 1.5);
    };
    rail.keep = [from, to](const Vector3d& p) {
      return std::min(Eigen::Vector2d(p.x() - from.x(), p.z() - from.z()).norm(),
                      Eigen::Vector2d(p.x() - to.x(), p.z() - to.z()).norm()) > 0.0135;
    };
    sample_surface(rail, random, samples);
  }

  BakeOptions options;
  options.sh_degree = 2;
  options.contact_height_m = 0.02;
  GaussianAsset asset = bake_kernels(samples, OiledOak(seed * 977), options, random);
  stand_at_origin(asset);
  return asset;
}

}  // namespace livegs
