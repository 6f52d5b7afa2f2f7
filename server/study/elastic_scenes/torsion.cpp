// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/torsion.h"

#include <algorithm>
#include <cmath>

#include "study/harness/block.h"
#include "study/harness/particle_fit.h"
#include "study/harness/quasi_static.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

// torsion constant of a square over a^4 (Timoshenko and Goodier, 109)
constexpr double kSaintVenant = 0.1406;

// Tangential forces on a grid of points over the end at `x_m`, proportional to the distance from the axis.
void add_torque(std::vector<PointForce>& forces, double x_m, double torque_n_m, int across) {
  std::vector<Vector3d> points;
  double moment = 0.0;
  for (int j = 0; j < across; ++j) {
    for (int k = 0; k < across; ++k) {
      points.push_back(
          {x_m, ((j + 0.5) / across - 0.5) * kBarWidth_m, ((k + 0.5) / across - 0.5) * kBarWidth_m});
      moment += points.back().tail<2>().squaredNorm();
    }
  }
  for (const Vector3d& p : points) forces.push_back({p, torque_n_m / moment * Vector3d(0, -p.z(), p.y())});
}

}  // namespace

Result<Outcome> torsion(const Setup& setup) {
  ElasticBodyDescription bar = describe_bar(setup);
  bar.material.loss_factor = 2.0;
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  const double shear_modulus_pa = 0.5 * setup.youngs_modulus_pa / (1 + setup.poisson_ratio);
  const double softness = predicted_softness(setup, stage.body());
  if (softness < 1.0) damp(stage, softness);
  const double twist_rad_m = 0.1 * softness;  // 0.5 % of shear at the surface
  const double torque_n_m = kSaintVenant * std::pow(kBarWidth_m, 4) * shear_modulus_pa * twist_rad_m;
  const int across = std::max(2, points_across(setup, stage.body(), kBarWidth_m));
  const auto turn = [&](double share) {
    stage.forces.clear();
    add_torque(stage.forces, 0.5 * kBarLength_m, share * torque_n_m, across);
    add_torque(stage.forces, -0.5 * kBarLength_m, -share * torque_n_m, across);
  };
  const RestBox middle{{-0.25 * kBarLength_m, -1, -1}, {0.25 * kBarLength_m, 1, 1}};
  const auto twist = [&]() -> Eigen::Vector2d {
    return {twist_rate_rad_m(stage.body(), stage.rest(), middle), 0.0};
  };
  // Torsional waves: c² = (torsion constant * G) / (rho * polar moment).
  const double wave_m_s = std::sqrt(6 * kSaintVenant * softness * shear_modulus_pa / setup.density_kg_m3);
  const double measured = load_quasi_statically(stage, {turn, twist, 2 * kBarLength_m / wave_m_s})[0];
  if (setup.engine != Engine::Bullet) stage.measure_unforced_cost();
  const double cells_across = kBarWidth_m / std::max(1e-9, stage.body().accuracy().cell_width_m);
  return stage.finish({relative("twist", measured / twist_rad_m, 1.0, cells_across > 7.5 ? 0.04 : 0.08)});
}

Result<Outcome> torsion_release(const Setup& setup) {
  ElasticBodyDescription bar = describe_bar(setup);
  bar.material.loss_factor = 0.5;
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  // Damped springs pull both ends towards faces that rotate by two turns each, in opposite directions.
  const double wave_m_s = std::sqrt(setup.youngs_modulus_pa / setup.density_kg_m3);
  const double turning_s = 30 * kBarLength_m / wave_m_s;
  constexpr int across = 4;
  const double face_n_m = 100 * setup.youngs_modulus_pa * kBarWidth_m * kBarWidth_m / kBarLength_m;
  const double spring_n_m = face_n_m / (across * across);
  const double point_kg = setup.density_kg_m3 * std::pow(kBarWidth_m / across, 3);
  const double damping_n_s_m = 0.3 * std::sqrt(spring_n_m * point_kg);
  const auto drag = [&] {
    const double share = std::min(1.0, stage.time_s() / turning_s);
    const double angle = 4 * M_PI * share, rate = share < 1.0 ? 4 * M_PI / turning_s : 0.0;
    stage.forces.clear();
    for (const double side : {-1.0, 1.0}) {
      const Eigen::AngleAxisd turn(side * angle, Vector3d::UnitX());
      for (int j = 0; j < across; ++j) {
        for (int k = 0; k < across; ++k) {
          const Vector3d rest(side * 0.5 * kBarLength_m, ((j + 0.5) / across - 0.5) * kBarWidth_m,
                              ((k + 0.5) / across - 0.5) * kBarWidth_m);
          const Vector3d target = turn * rest;
          const Vector3d moving = side * rate * Vector3d::UnitX().cross(target);
          const Vector3d force = spring_n_m * (target - stage.body().world_point(rest)) +
                                 damping_n_s_m * (moving - stage.body().point_velocity_m_s(rest));
          stage.forces.push_back({rest, force});
        }
      }
    }
  };
  // Relative rotation of the ends, tracked from substep to substep.
  double angles[2] = {0.0, 0.0};
  const auto follow = [&] {
    for (const int end : {0, 1}) {
      const double x_m = (end - 0.5) * kBarLength_m;
      const Vector3d arm = stage.body().world_point({x_m, 0.25 * kBarWidth_m, 0}) -
                           stage.body().world_point({x_m, -0.25 * kBarWidth_m, 0});
      angles[end] += std::remainder(std::atan2(arm.z(), arm.y()) - angles[end], 2 * M_PI);
    }
  };
  stage.run(1.2 * turning_s, drag, follow);
  const double turns = (angles[1] - angles[0]) / (2 * M_PI);
  stage.forces.clear();
  // Ten decay times of the lowest mode, free bending.
  const double lowest_rad_s =
      22.37 / std::sqrt(12.0) * kBarWidth_m / (kBarLength_m * kBarLength_m) * wave_m_s;
  stage.run(10.0 / (0.5 * bar.material.loss_factor * lowest_rad_s));
  const double left = distance_from_rest_shape_m(stage.body(), stage.rest()) / kBarLength_m;
  return stage.finish({absolute("rest_shape", left, 0.0, 1e-3), absolute("turns", turns, 4.0, 0.2)});
}

}  // namespace livegs::study
