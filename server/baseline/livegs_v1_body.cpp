// SPDX-License-Identifier: GPL-3.0-or-later
#include "baseline/livegs_v1_body.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {

using Eigen::Matrix3d;
using Eigen::Vector3d;

LivegsV1Body::LivegsV1Body(const ElasticBodyDescription& description, double rate_hz, int substeps,
                           bool may_sleep, bool steady)
    : material_(description.material),
      object_id_(description.object_id),
      rate_hz_(rate_hz),
      substeps_(substeps),
      steady_(steady),
      rest_m_(description.particles.positions_m),
      volumes_m3_(description.particles.volumes_m3),
      on_surface_(description.particles.on_surface),
      regions_(description.regions),
      world_from_object_(description.world_from_object),
      orientation_(description.world_from_object.orientation.normalized()),
      sleep_timer_(may_sleep) {
  const size_t count = rest_m_.size();
  world_from_object_.orientation = orientation_;
  on_surface_.resize(count, false);
  for (const SurfacePoint& point : surface_points(description.particles)) {
    if (surface_.empty() || surface_.back().particle != point.particle)
      surface_.push_back(point);  // one ball each
  }
  contact_points_ = surface_;
  std::vector<bool> outer(count, false);
  for (const SurfacePoint& point : surface_) outer[point.particle] = true;
  for (uint32_t i = 0; i < count; ++i) {
    if (!outer[i]) contact_points_.push_back({i, rest_m_[i], 0.0, {}});
  }
  for (const double v : volumes_m3_) volume_m3_ += v;
  spacing_m_ = description.particles.spacing_m > 0.0 ? description.particles.spacing_m
                                                     : std::cbrt(volume_m3_ / static_cast<double>(count));
  low_m_.setConstant(std::numeric_limits<double>::infinity());
  high_m_ = -low_m_;
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < count; ++i) {
    masses_kg_.push_back(material_.mass_kg * volumes_m3_[i] / volume_m3_);
    rest_centre += volumes_m3_[i] / volume_m3_ * rest_m_[i];
    const double half_m = on_surface_[i] ? 0.0 : 0.5 * spacing_m_;
    low_m_ = low_m_.cwiseMin(rest_m_[i] - Vector3d::Constant(half_m));
    high_m_ = high_m_.cwiseMax(rest_m_[i] + Vector3d::Constant(half_m));
  }
  released_.assign(regions_.size(), false);
  hold_regions();
  load_regions();
  make_clusters();

  origin_m_ = world_from_object_ * rest_centre;
  for (size_t i = 0; i < count; ++i) {
    const Vector3d r = rest_m_[i] - rest_centre;
    positions_m_.push_back(orientation_ * (held(i) ? r : Vector3d(description.initial_deformation * r)));
    Vector3d v = description.velocity_m_s + description.angular_velocity_rad_s.cross(positions_m_[i]);
    if (!description.particle_velocities_m_s.empty()) v += description.particle_velocities_m_s[i];
    velocities_m_s_.push_back(held(i) ? Vector3d::Zero() : v);
  }
  predicted_m_ = goals_m_ = positions_m_;
  for (size_t i = 0; i < count; ++i) goals_m_[i] *= cluster_counts_[i];
  motion_ = body_momentum(positions_m_, velocities_m_s_, masses_kg_);
  for (const Vector3d& x : positions_m_) reach_m_ = std::max(reach_m_, (x - motion_.centre_m).norm());
}

double resistance_stiffness_per_s2(double deformation_resistance) {
  const double resistance = std::clamp(deformation_resistance, 0.0, 1.0);
  if (resistance == 1.0) return std::numeric_limits<double>::infinity();
  return resistance / ((1.0 - resistance) * kPaperSubstep_s * kPaperSubstep_s);
}

double resistance_blend(double stiffness_per_s2, double substep_s) {
  if (std::isinf(stiffness_per_s2)) return 1.0;
  const double odds = stiffness_per_s2 * substep_s * substep_s;
  return odds / (1.0 + odds);
}

double LivegsV1Body::blend(double h) const {
  const double resistance = deformation_resistance(material_.effective_youngs_modulus_pa());
  return steady_ ? resistance_blend(resistance_stiffness_per_s2(resistance), h) : resistance;
}

// Fitted to a stretched bar; elastic_livegs_v1_test.cpp checks it at 1 to 64 substeps. For the steady variant
// it is rho s² / (1/omega² + h²): a step passes a load on by one cluster only, so even d_R = 1 is not rigid.
double LivegsV1Body::apparent_modulus_pa(double h) const {
  return blend(h) * material_.mass_kg / volume_m3_ * std::pow(spacing_m_ / h, 2);
}

// As in CellsBody: hysteretic damping, matched at the lowest mode for the apparent stiffness.
double LivegsV1Body::damping_rate(double h) const {
  if (!(material_.loss_factor > 0.0)) return 0.0;
  const Vector3d size = high_m_ - low_m_;
  const double length = std::max(size.maxCoeff(), spacing_m_),
               thickness = std::max(size.minCoeff(), spacing_m_);
  const double wave_m_s = std::sqrt(apparent_modulus_pa(h) * volume_m3_ / material_.mass_kg);
  const double axial = (anchored_ ? M_PI_2 : M_PI) / length;
  const double bending = (anchored_ ? 3.516 : 22.37) / std::sqrt(12.0) * thickness / (length * length);
  return material_.loss_factor * wave_m_s * std::min(axial, bending);
}

void LivegsV1Body::set_material(const Material& material) {
  for (double& mass : masses_kg_) mass *= material.mass_kg / material_.mass_kg;
  for (Cluster& cluster : clusters_) {
    cluster.mass_kg *= material.mass_kg / material_.mass_kg;
    cluster.rest_moment_inverse *= material_.mass_kg / material.mass_kg;
  }
  material_ = material;
  motion_ = body_momentum(positions_m_, velocities_m_s_, masses_kg_);
  wake();
}

RestBody LivegsV1Body::rest_body() const {
  RestBody rest;
  rest.kind = DriverKind::Particles;
  for (const Vector3d& x : rest_m_) rest.particles_m.push_back(x.cast<float>());
  return rest;
}

void LivegsV1Body::write_drivers(ObjectDrivers& drivers) const {
  drivers.kind = DriverKind::Particles;
  drivers.poses.clear();
  drivers.positions_m.resize(positions_m_.size());
  drivers.rotations.resize(positions_m_.size());
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    drivers.positions_m[i] = (origin_m_ + positions_m_[i]).cast<float>();
    drivers.rotations[i] = clusters_[i].rotation.cast<float>();
  }
}

Pose LivegsV1Body::centre_pose() const {
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < rest_m_.size(); ++i) rest_centre += masses_kg_[i] / motion_.mass_kg * rest_m_[i];
  Matrix3d match = Matrix3d::Zero();
  for (size_t i = 0; i < rest_m_.size(); ++i) {
    match += masses_kg_[i] * (positions_m_[i] - motion_.centre_m) * (rest_m_[i] - rest_centre).transpose();
  }
  return {origin_m_ + motion_.centre_m, extract_rotation(match, orientation_)};
}

std::vector<ParticleState> LivegsV1Body::particles() const {
  std::vector<ParticleState> states(positions_m_.size());
  for (size_t i = 0; i < states.size(); ++i) {
    states[i] = {origin_m_ + positions_m_[i], velocities_m_s_[i], masses_kg_[i], clusters_[i].deformation};
  }
  return states;
}

// Shape matching has no elastic energy of its own. elastic_j is the energy that corresponds to the blend,
// from the squared distances to the goals over the squared step; zero at rest.
BodyEnergy LivegsV1Body::energy(const Vector3d& gravity_m_s2) const {
  BodyEnergy energy;
  const double h = 1.0 / (rate_hz_ * substeps_), part = blend(h);
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    const Vector3d x = origin_m_ + positions_m_[i];
    energy.kinetic_j += 0.5 * masses_kg_[i] * velocities_m_s_[i].squaredNorm();
    energy.gravity_j -= masses_kg_[i] * gravity_m_s2.dot(x);
    energy.linear_momentum += masses_kg_[i] * velocities_m_s_[i];
    energy.angular_momentum += masses_kg_[i] * x.cross(velocities_m_s_[i]);
    energy.elastic_j += 0.5 * masses_kg_[i] * part / (h * h) *
                        (goals_m_[i] / cluster_counts_[i] - positions_m_[i]).squaredNorm();
  }
  return energy;
}

ElasticAccuracy LivegsV1Body::accuracy() const {
  ElasticAccuracy accuracy;
  const double h = 1.0 / (rate_hz_ * substeps_);
  accuracy.cell_width_m = spacing_m_;
  accuracy.substeps = substeps_;
  accuracy.youngs_modulus_pa = material_.effective_youngs_modulus_pa();
  accuracy.courant = std::sqrt(accuracy.youngs_modulus_pa * volume_m3_ / material_.mass_kg) * h / spacing_m_;
  accuracy.reached_youngs_modulus_pa = apparent_modulus_pa(h);
  accuracy.clipped = accuracy.reached_youngs_modulus_pa < accuracy.youngs_modulus_pa;
  accuracy.particles = positions_m_.size();
  accuracy.bytes =
      clusters_.size() * sizeof(Cluster) + members_.size() * sizeof(uint32_t) +
      positions_m_.size() * (5 * sizeof(Vector3d) + 2 * sizeof(double) + sizeof(uint32_t) + sizeof(int)) +
      (surface_.size() + contact_points_.size()) * sizeof(SurfacePoint);
  return accuracy;
}

size_t LivegsV1Body::nearest_particle(const Vector3d& rest_point_m) const {
  size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < rest_m_.size(); ++i) {
    const double distance = (rest_m_[i] - rest_point_m).squaredNorm();
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  return nearest;
}

// A material point rotates with the cluster of its nearest particle.
Vector3d LivegsV1Body::world_point(const Vector3d& rest_point_m) const {
  const size_t i = nearest_particle(rest_point_m);
  return origin_m_ + positions_m_[i] + clusters_[i].rotation * (rest_point_m - rest_m_[i]);
}

Vector3d LivegsV1Body::point_velocity_m_s(const Vector3d& rest_point_m) const {
  return velocities_m_s_[nearest_particle(rest_point_m)];
}

std::optional<ElasticBody::RayHit> LivegsV1Body::ray_cast(const Vector3d& origin_m,
                                                          const Vector3d& direction) const {
  const double within = 0.75 * spacing_m_;
  std::optional<RayHit> hit;
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    const Vector3d to = origin_m_ + positions_m_[i] - origin_m;
    const double along = to.dot(direction);
    if (along < 0.0 || (hit && along >= hit->distance_m)) continue;
    if ((to - along * direction).squaredNorm() > within * within) continue;
    hit = RayHit{along, rest_m_[i]};
  }
  return hit;
}

}  // namespace livegs
