// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/livegs_v1_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// A cluster is the particles within a voxel and a half along each axis: 27 on a regular grid. Where that finds fewer
// than four, the nearest eight.
constexpr double kClusterReach = 1.5;
constexpr size_t kFewestMembers = 4, kNearestMembers = 8;

Matrix3d pseudo_inverse(const Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
  Matrix3d inverse = Matrix3d::Zero();
  const double least = 1e-6 * solver.eigenvalues()[2];
  for (int d = 0; d < 3; ++d) {
    if (solver.eigenvalues()[d] <= least) continue;
    const Vector3d axis = solver.eigenvectors().col(d);
    inverse += axis * axis.transpose() / solver.eigenvalues()[d];
  }
  return inverse;
}

}  // namespace

LivegsV1Body::LivegsV1Body(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep)
    : material_(description.material),
      object_id_(description.object_id),
      rate_hz_(rate_hz),
      substeps_(substeps),
      resistance_(deformation_resistance(description.material.effective_youngs_modulus_pa())),
      rest_m_(description.particles.positions_m),
      volumes_m3_(description.particles.volumes_m3),
      orientation_(description.world_from_object.orientation.normalized()),
      rest_clock_(may_sleep) {
  const size_t count = rest_m_.size();
  for (const SurfacePoint& point : surface_points(description.particles)) {
    if (surface_.empty() || surface_.back().particle != point.particle) surface_.push_back(point);  // a ball each
  }
  double volume = 0.0;
  for (const double v : volumes_m3_) volume += v;
  spacing_m_ = description.particles.spacing_m > 0.0 ? description.particles.spacing_m
                                                     : std::cbrt(volume / static_cast<double>(count));
  fixed_.assign(count, false);
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < count; ++i) {
    masses_kg_.push_back(material_.mass_kg * volumes_m3_[i] / volume);
    rest_centre += volumes_m3_[i] / volume * rest_m_[i];
    for (const BodyRegion& region : description.regions) {
      if (region.fixed && region.contains(rest_m_[i], 1e-9)) fixed_[i] = held_ = true;
    }
  }
  make_clusters(description);

  origin_m_ = description.world_from_object * rest_centre;
  for (size_t i = 0; i < count; ++i) {
    const Vector3d r = rest_m_[i] - rest_centre;
    positions_m_.push_back(orientation_ * (fixed_[i] ? r : Vector3d(description.initial_deformation * r)));
    Vector3d v = description.velocity_m_s + description.angular_velocity_rad_s.cross(positions_m_[i]);
    if (!description.particle_velocities_m_s.empty()) v += description.particle_velocities_m_s[i];
    velocities_m_s_.push_back(fixed_[i] ? Vector3d::Zero() : v);
  }
  predicted_m_ = goals_m_ = positions_m_;
  motion_ = mass_motion(positions_m_, velocities_m_s_, masses_kg_);
  for (const Vector3d& x : positions_m_) reach_m_ = std::max(reach_m_, (x - motion_.centre_m).norm());
}

void LivegsV1Body::make_clusters(const ElasticBodyDescription&) {
  using Key = std::tuple<int64_t, int64_t, int64_t>;
  const double reach = kClusterReach * spacing_m_;
  const auto key = [&](const Vector3d& p) {
    return Key{static_cast<int64_t>(std::floor(p.x() / reach)), static_cast<int64_t>(std::floor(p.y() / reach)),
               static_cast<int64_t>(std::floor(p.z() / reach))};
  };
  std::map<Key, std::vector<uint32_t>> voxels;
  for (uint32_t i = 0; i < rest_m_.size(); ++i) voxels[key(rest_m_[i])].push_back(i);

  cluster_counts_.assign(rest_m_.size(), 0);
  std::vector<std::pair<double, uint32_t>> nearest;
  for (uint32_t i = 0; i < rest_m_.size(); ++i) {
    Cluster cluster{static_cast<uint32_t>(members_.size()), 0, 0.0, Vector3d::Zero(), Matrix3d::Zero(), orientation_,
                    orientation_.toRotationMatrix()};
    const auto [x, y, z] = key(rest_m_[i]);
    for (int64_t dx = -1; dx <= 1; ++dx) {
      for (int64_t dy = -1; dy <= 1; ++dy) {
        for (int64_t dz = -1; dz <= 1; ++dz) {
          const auto found = voxels.find({x + dx, y + dy, z + dz});
          if (found == voxels.end()) continue;
          for (const uint32_t j : found->second) {
            if ((rest_m_[j] - rest_m_[i]).cwiseAbs().maxCoeff() <= reach * (1.0 - 1e-9)) members_.push_back(j);
          }
        }
      }
    }
    if (members_.size() - cluster.begin < kFewestMembers) {
      members_.resize(cluster.begin);
      nearest.clear();
      for (uint32_t j = 0; j < rest_m_.size(); ++j) nearest.emplace_back((rest_m_[j] - rest_m_[i]).squaredNorm(), j);
      const size_t take = std::min(kNearestMembers, nearest.size());
      std::partial_sort(nearest.begin(), nearest.begin() + static_cast<ptrdiff_t>(take), nearest.end());
      for (size_t k = 0; k < take; ++k) members_.push_back(nearest[k].second);
    }
    std::sort(members_.begin() + cluster.begin, members_.end());
    cluster.end = static_cast<uint32_t>(members_.size());
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      cluster.mass_kg += masses_kg_[members_[k]];
      cluster.rest_centre_m += masses_kg_[members_[k]] * rest_m_[members_[k]];
      ++cluster_counts_[members_[k]];
    }
    cluster.rest_centre_m /= cluster.mass_kg;
    Matrix3d moment = Matrix3d::Zero();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      const Vector3d r = rest_m_[members_[k]] - cluster.rest_centre_m;
      moment += masses_kg_[members_[k]] * r * r.transpose();
    }
    cluster.rest_moment_inverse = pseudo_inverse(moment);
    clusters_.push_back(cluster);
  }
}

void LivegsV1Body::match_shapes() {
  std::fill(goals_m_.begin(), goals_m_.end(), Vector3d::Zero());
  for (Cluster& cluster : clusters_) {
    Vector3d centre = Vector3d::Zero();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) centre += masses_kg_[members_[k]] * predicted_m_[members_[k]];
    centre /= cluster.mass_kg;
    Matrix3d match = Matrix3d::Zero();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      const uint32_t i = members_[k];
      match += masses_kg_[i] * (predicted_m_[i] - centre) * (rest_m_[i] - cluster.rest_centre_m).transpose();
    }
    cluster.rotation = extract_rotation(match, cluster.rotation);
    cluster.deformation = match * cluster.rest_moment_inverse;
    const Matrix3d rotation = cluster.rotation.toRotationMatrix();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      const uint32_t i = members_[k];
      goals_m_[i] += centre + rotation * (rest_m_[i] - cluster.rest_centre_m);
    }
  }
  for (size_t i = 0; i < goals_m_.size(); ++i) {
    if (fixed_[i]) continue;
    predicted_m_[i] += resistance_ * (goals_m_[i] / cluster_counts_[i] - predicted_m_[i]);
  }
}

void LivegsV1Body::substep(const SubstepContext& context) {
  bool forced = false;
  for (const PointForce& force : context.forces) forced = forced || force.force_n.squaredNorm() > 0.0;
  if (asleep()) {
    bool touched = forced;
    for (const MovingSphere& sphere : context.spheres) {
      const double reach = reach_m_ + sphere.radius_m + context.duration_s * sphere.velocity_m_s.norm();
      touched = touched || (sphere.position_m - origin_m_ - motion_.centre_m).norm() < reach;
    }
    if (!touched) return;
    wake();
  }
  const double h = context.duration_s;
  for (const PointForce& force : context.forces) {
    const size_t i = nearest_particle(force.point_m);
    if (!fixed_[i]) velocities_m_s_[i] += h / masses_kg_[i] * force.force_n;
  }
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    if (!fixed_[i]) velocities_m_s_[i] += h * context.gravity_m_s2;
    predicted_m_[i] = positions_m_[i] + h * velocities_m_s_[i];
  }
  match_shapes();
  touching_ = false;
  const double reach = 1.1 * (reach_m_ + h * motion_.velocity_m_s().norm() + spacing_m_);
  reachable_colliders(context.colliders, origin_m_ + motion_.centre_m, reach, reachable_);
  resolve_contacts(h, context.spheres);
  for (size_t i = 0; i < positions_m_.size(); ++i) velocities_m_s_[i] = (predicted_m_[i] - positions_m_[i]) / h;
  std::swap(positions_m_, predicted_m_);
  motion_ = mass_motion(positions_m_, velocities_m_s_, masses_kg_);
  reach_m_ = 0.0;
  for (const Vector3d& x : positions_m_) reach_m_ = std::max(reach_m_, (x - motion_.centre_m).norm());
  forced_ = forced;
  supported_ = touching_ || held_ || context.gravity_m_s2.squaredNorm() == 0.0;
}

void LivegsV1Body::resolve_contacts(double h, std::span<MovingSphere> spheres) {
  for (const SurfacePoint& point : surface_) {
    const size_t i = point.particle;
    for (const Collider* collider : reachable_) {
      const SurfaceSample surface = sample_surface(*collider, origin_m_ + predicted_m_[i]);
      const double depth = point.radius_m - surface.distance_m;
      if (depth <= 0.0) continue;
      touching_ = true;
      if (fixed_[i]) continue;
      predicted_m_[i] += contact_correction(surface.normal, depth, predicted_m_[i] - positions_m_[i],
                                            mixed_friction(material_.friction, collider->friction));
    }
  }
  for (MovingSphere& sphere : spheres) {
    const Vector3d start = sphere.position_m;
    Vector3d end = start + h * sphere.velocity_m_s;
    const double reach = 1.1 * (reach_m_ + h * motion_.velocity_m_s().norm() + spacing_m_) + sphere.radius_m;
    if ((end - origin_m_ - motion_.centre_m).norm() < reach) {
      const double friction = mixed_friction(material_.friction, sphere.friction);
      for (const SurfacePoint& point : surface_) {
        const size_t i = point.particle;
        const auto contact = ball_contact(origin_m_ + predicted_m_[i], point.radius_m, predicted_m_[i] - positions_m_[i],
                                          fixed_[i] ? 0.0 : 1.0 / masses_kg_[i], end, end - start, sphere.radius_m,
                                          1.0 / sphere.mass_kg, friction);
        if (!contact) continue;
        predicted_m_[i] += contact->correction_m;
        sphere.impulse_n_s -= contact->pull_kg_m / h;
        sphere.velocity_m_s -= contact->pull_kg_m / (h * sphere.mass_kg);
        end -= contact->pull_kg_m / sphere.mass_kg;
      }
    }
    sphere.position_m = end;
  }
}

void LivegsV1Body::end_frame(double frame_s) {
  if (asleep()) return;
  for (Vector3d& x : positions_m_) x -= motion_.centre_m;
  origin_m_ += motion_.centre_m;
  motion_.centre_m.setZero();
  orientation_ = centre_pose().orientation;
  double fastest = 0.0;
  for (const Vector3d& v : velocities_m_s_) fastest = std::max(fastest, v.squaredNorm());
  if (!rest_clock_.tick(frame_s, std::sqrt(fastest), supported_, forced_)) return;
  for (Vector3d& v : velocities_m_s_) v.setZero();
  motion_.momentum.setZero();
  motion_.angular_momentum.setZero();
}

void LivegsV1Body::set_material(const Material& material) {
  for (double& mass : masses_kg_) mass *= material.mass_kg / material_.mass_kg;
  for (Cluster& cluster : clusters_) {
    cluster.mass_kg *= material.mass_kg / material_.mass_kg;
    cluster.rest_moment_inverse *= material_.mass_kg / material.mass_kg;
  }
  material_ = material;
  resistance_ = deformation_resistance(material.effective_youngs_modulus_pa());
  motion_ = mass_motion(positions_m_, velocities_m_s_, masses_kg_);
  wake();
}

RestBody LivegsV1Body::rest_body() const {
  RestBody rest;
  rest.kind = DriverKind::Particles;
  for (const Vector3d& x : rest_m_) rest.particles_m.push_back(x.cast<float>());
  return rest;
}

void LivegsV1Body::write_drivers(ObjectDrivers& drivers) const {
  drivers.object_id = object_id_;
  drivers.kind = DriverKind::Particles;
  drivers.asleep = asleep();
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

// Shape matching has no elastic energy of its own: elastic_j is what the blend would do, the squared way to the goals
// over the step, and is zero at rest.
BodyEnergy LivegsV1Body::energy(const Vector3d& gravity_m_s2) const {
  BodyEnergy energy;
  const double h = 1.0 / (rate_hz_ * substeps_);
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    const Vector3d x = origin_m_ + positions_m_[i];
    energy.kinetic_j += 0.5 * masses_kg_[i] * velocities_m_s_[i].squaredNorm();
    energy.gravity_j -= masses_kg_[i] * gravity_m_s2.dot(x);
    energy.linear_momentum += masses_kg_[i] * velocities_m_s_[i];
    energy.angular_momentum += masses_kg_[i] * x.cross(velocities_m_s_[i]);
    energy.elastic_j += 0.5 * masses_kg_[i] * resistance_ / (h * h) *
                        (goals_m_[i] / cluster_counts_[i] - positions_m_[i]).squaredNorm();
  }
  return energy;
}

ElasticAccuracy LivegsV1Body::accuracy() const {
  ElasticAccuracy accuracy;
  const double h = 1.0 / (rate_hz_ * substeps_);
  double volume = 0.0;
  for (const double v : volumes_m3_) volume += v;
  const double density = material_.mass_kg / volume;
  accuracy.cell_width_m = spacing_m_;
  accuracy.substeps = substeps_;
  accuracy.courant = std::sqrt(material_.effective_youngs_modulus_pa() / density) * h / spacing_m_;
  // physics.md 0: about half of rho s²/h² times the odds of the blend.
  accuracy.reached_youngs_modulus_pa =
      0.5 * density * std::pow(spacing_m_ / h, 2) * resistance_ / std::max(1e-9, 1.0 - resistance_);
  accuracy.clipped = accuracy.reached_youngs_modulus_pa < material_.effective_youngs_modulus_pa();
  accuracy.particles = positions_m_.size();
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

// A material point turns with its nearest particle's cluster.
Vector3d LivegsV1Body::world_point(const Vector3d& rest_point_m) const {
  const size_t i = nearest_particle(rest_point_m);
  return origin_m_ + positions_m_[i] + clusters_[i].rotation * (rest_point_m - rest_m_[i]);
}

Vector3d LivegsV1Body::point_velocity_m_s(const Vector3d& rest_point_m) const {
  return velocities_m_s_[nearest_particle(rest_point_m)];
}

std::optional<ElasticBody::RayHit> LivegsV1Body::ray_cast(const Vector3d& origin_m, const Vector3d& direction) const {
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
