// SPDX-License-Identifier: GPL-3.0-or-later
// Construction and what is asked of a body between substeps; the substep itself is in cells_step.cpp.
#include "physics/cells_body.h"

#include <algorithm>
#include <cmath>

#include "core/log.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

double density(const Material& material, double volume_m3) { return material.mass_kg / volume_m3; }

}  // namespace

CellsBody::CellsBody(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep)
    : material_(description.material),
      extent_(measure_extent(description.particles)),
      particle_rest_m_(description.particles.positions_m),
      particle_volumes_m3_(description.particles.volumes_m3),
      object_id_(description.object_id),
      rate_hz_(rate_hz),
      scene_substeps_(substeps),
      orientation_(description.world_from_object.orientation.normalized()),
      rest_clock_(may_sleep) {
  for (const double volume : particle_volumes_m3_) volume_m3_ += volume;
  choose_substeps(description.cell_width_m);

  lattice_ = build_lattice(extent_, choice_.cell_width_m, description.regions);
  for (const Vector3d& particle : particle_rest_m_) particle_points_.push_back(lattice_.embed(particle));
  make_surface(description.particles);

  const size_t count = lattice_.node_coordinates.size();
  masses_kg_.resize(count);
  inverse_masses_.assign(count, 1.0);
  for (const LatticeCell& cell : lattice_.cells) {
    if (!cell.fixed) continue;
    for (const uint32_t node : cell.nodes) inverse_masses_[node] = 0.0;
    held_ = true;
  }
  set_masses();
  start_motion(description);
  hold_regions(description);

  std::vector<CellBlock> blocks;
  for (const LatticeCell& cell : lattice_.cells) {
    std::array<double, 8> inverse;
    for (int c = 0; c < 8; ++c) inverse[c] = inverse_masses_[cell.nodes[c]];
    blocks.push_back(make_cell_block(cell, lattice_.cell_width_m, inverse));
  }
  const Quaterniond rotation = orientation_ * extent_.object_from_lattice;
  batches_ = make_cell_batches(lattice_, blocks, inverse_masses_, rotation, static_cast<uint32_t>(count));
  NodeLanes nothing;
  nothing.value = all_lanes(0.0);
  predicted_.assign(count + 1, nothing);
  corrections_.assign(count + 1, nothing);
}

void CellsBody::make_surface(const ParticleSet& particles) {
  std::vector<EmbeddedPoint> points;
  for (const SurfacePoint& point : surface_points(particles)) points.push_back(lattice_.embed(point.rest_m));
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
  for (uint32_t i = 0; i < points.size(); ++i) {
    surface_.push_back(sample_at(points[i]));
    if (i == 0 || points[i].cell != points[i - 1].cell) surface_cells_.push_back({surface_.back().nodes, i, i});
    surface_cells_.back().end = i + 1;
  }
}

void CellsBody::choose_substeps(double cell_width_m) {
  CellDemand demand;
  demand.size_m = extent_.max_m - extent_.min_m;
  demand.particle_edge_m = extent_.box_edge_m;
  demand.youngs_modulus_pa = material_.effective_youngs_modulus_pa();
  demand.poisson_ratio = material_.poisson_ratio;
  demand.density_kg_m3 = density(material_, volume_m3_);
  demand.rate_hz = rate_hz_;
  demand.substeps = scene_substeps_;
  demand.cell_width_m = cell_width_m;
  choice_ = choose_cells(demand);
  if (choice_.clipped) {
    log_warn("object %u: stiffness clipped from %.3g to %.3g Pa, the most that %.3g m cells reach in %d substeps; "
             "wider cells, a higher rate or a rigid body would be stiffer",
             object_id_, demand.youngs_modulus_pa, choice_.youngs_modulus_pa, choice_.cell_width_m, choice_.substeps);
  }
}

void CellsBody::set_masses() {
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    masses_kg_[i] = density(material_, volume_m3_) * lattice_.node_volumes_m3[i];
    if (inverse_masses_[i] > 0.0) inverse_masses_[i] = 1.0 / masses_kg_[i];
  }
}

void CellsBody::start_motion(const ElasticBodyDescription& description) {
  const size_t count = masses_kg_.size();
  positions_m_.resize(count);
  velocities_m_s_.assign(count, Vector3d::Zero());

  // Velocities of single particles reach the nodes by their share of mass.
  if (!description.particle_velocities_m_s.empty()) {
    std::vector<double> shares(count, 0.0);
    for (size_t p = 0; p < particle_points_.size(); ++p) {
      const Sample sample = sample_at(particle_points_[p]);
      for (int c = 0; c < 8; ++c) {
        const double share = particle_volumes_m3_[p] * std::max(0.0, sample.weights[c]);
        velocities_m_s_[sample.nodes[c]] += share * description.particle_velocities_m_s[p];
        shares[sample.nodes[c]] += share;
      }
    }
    for (size_t i = 0; i < count; ++i) {
      if (shares[i] > 0.0) velocities_m_s_[i] /= shares[i];
    }
  }

  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < count; ++i) rest_centre += masses_kg_[i] / material_.mass_kg * lattice_.node_position_m(i);
  origin_m_ = description.world_from_object * rest_centre;
  for (size_t i = 0; i < count; ++i) {
    positions_m_[i] = orientation_ * (description.initial_deformation * (lattice_.node_position_m(i) - rest_centre));
    velocities_m_s_[i] += description.velocity_m_s + description.angular_velocity_rad_s.cross(positions_m_[i]);
    if (inverse_masses_[i] == 0.0) {
      positions_m_[i] = orientation_ * (lattice_.node_position_m(i) - rest_centre);
      velocities_m_s_[i].setZero();
    }
  }
  previous_positions_m_ = positions_m_;
  previous_velocities_m_s_ = velocities_m_s_;
  predicted_velocities_m_s_ = velocities_m_s_;
  accelerations_m_s2_.assign(count, Vector3d::Zero());
  motion_ = mass_motion(positions_m_, velocities_m_s_, masses_kg_);
  for (const Vector3d& position : positions_m_) reach_m_ = std::max(reach_m_, (position - motion_.centre_m).norm());
}

void CellsBody::hold_regions(const ElasticBodyDescription& description) {
  for (const BodyRegion& region : description.regions) {
    if (!region.fixed) continue;
    bool holds = false;
    for (const LatticeCell& cell : lattice_.cells) holds = holds || cell.fixed;
    for (size_t p = 0; p < particle_rest_m_.size(); ++p) {
      const Vector3d& rest = particle_rest_m_[p];
      const double margin = 1e-6 * lattice_.cell_width_m;
      if (((rest - region.min_m).array() < -margin).any() || ((region.max_m - rest).array() < -margin).any()) continue;
      holds = true;
      held_ = true;
      const Sample sample = sample_at(particle_points_[p]);
      if (mobility(sample) <= 0.0) continue;  // its nodes are held already
      held_particles_.push_back({sample, description.world_from_object * rest});
    }
    if (!holds) {
      log_warn("object %u: a fixed region from (%.3g, %.3g, %.3g) to (%.3g, %.3g, %.3g) m holds no material", object_id_,
               region.min_m.x(), region.min_m.y(), region.min_m.z(), region.max_m.x(), region.max_m.y(),
               region.max_m.z());
    }
  }
}

void CellsBody::set_gains(double h) {
  const IsotropicMaterial isotropic{choice_.youngs_modulus_pa, material_.poisson_ratio};
  std::vector<CellGains> gains(lattice_.cells.size());
  for (const bool second_order : {false, true}) {
    const double step_s = second_order ? 2.0 * h / 3.0 : h;
    for (size_t i = 0; i < gains.size(); ++i) {
      const LatticeCell& cell = lattice_.cells[i];
      std::array<double, 8> inverse;
      for (int c = 0; c < 8; ++c) inverse[c] = inverse_masses_[cell.nodes[c]];
      const CellBlock block = make_cell_block(cell, lattice_.cell_width_m, inverse);
      gains[i] = make_cell_gains(cell, block, lattice_.cell_width_m, isotropic, step_s);
    }
    gains_[second_order] = make_batch_gains(batches_, gains);
  }
  gains_step_s_ = h;
}

void CellsBody::set_material(const Material& material) {
  const double scale = material.mass_kg / material_.mass_kg;
  material_ = material;
  choose_substeps(choice_.cell_width_m);
  set_masses();
  // Batches hold mobilities, which are inverse masses.
  for (CellBatch& batch : batches_.batches) {
    for (Lanes& g : batch.mobility) g /= all_lanes(scale);
    for (auto& coupling : batch.mode_coupling) {
      for (Lanes& c : coupling) c /= all_lanes(scale);
    }
  }
  motion_ = mass_motion(positions_m_, velocities_m_s_, masses_kg_);
  gains_step_s_ = 0.0;
  wake();
}

// Hysteretic damping loses 2 pi eta of a vibration's energy a cycle; a rate of eta omega does the same at one
// frequency, and it is matched at the lowest: the axial or bending mode of a beam of the body's longest side and
// smallest thickness, free at both ends or clamped at one.
double CellsBody::damping_rate() const {
  const Vector3d size = extent_.max_m - extent_.min_m;
  const double length = size.maxCoeff(), thickness = size.minCoeff();
  const double wave_m_s = std::sqrt(choice_.youngs_modulus_pa / density(material_, volume_m3_));
  const double axial = (free() ? M_PI : M_PI_2) / length;
  const double bending = (free() ? 22.37 : 3.516) / std::sqrt(12.0) * thickness / (length * length);
  return material_.loss_factor * wave_m_s * std::min(axial, bending);
}

void CellsBody::end_frame(double frame_s) {
  if (asleep()) return;
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    positions_m_[i] -= motion_.centre_m;
    previous_positions_m_[i] -= motion_.centre_m;
  }
  origin_m_ += motion_.centre_m;
  motion_.centre_m.setZero();
  orientation_ = centre_pose().orientation;

  double fastest = 0.0;
  for (const Vector3d& velocity : velocities_m_s_) fastest = std::max(fastest, velocity.squaredNorm());
  if (!rest_clock_.tick(frame_s, std::sqrt(fastest), supported_, forced_)) return;
  for (Vector3d& velocity : velocities_m_s_) velocity.setZero();
  previous_velocities_m_s_ = velocities_m_s_;
  previous_positions_m_ = positions_m_;
  motion_.momentum.setZero();
  motion_.angular_momentum.setZero();
}

RestBody CellsBody::rest_body() const {
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.object_from_lattice = lattice_.object_from_lattice;
  rest.cell_width_m = lattice_.cell_width_m;
  rest.node_coordinates = lattice_.node_coordinates;
  for (const LatticeCell& cell : lattice_.cells) rest.cells.push_back(cell.nodes);
  return rest;
}

void CellsBody::write_drivers(ObjectDrivers& drivers) const {
  drivers.object_id = object_id_;
  drivers.kind = DriverKind::Lattice;
  drivers.asleep = asleep();
  drivers.poses.clear();
  drivers.rotations.clear();
  drivers.positions_m.resize(positions_m_.size());
  for (size_t i = 0; i < positions_m_.size(); ++i) {
    drivers.positions_m[i] = (origin_m_ + positions_m_[i]).cast<float>();
  }
}

Pose CellsBody::centre_pose() const {
  Matrix3d match = Matrix3d::Zero();
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) rest_centre += masses_kg_[i] * lattice_.node_position_m(i);
  rest_centre /= motion_.mass_kg;
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    match += masses_kg_[i] * (positions_m_[i] - motion_.centre_m) *
             (lattice_.node_position_m(i) - rest_centre).transpose();
  }
  return {origin_m_ + motion_.centre_m, extract_rotation(match, orientation_)};
}

Vector3d CellsBody::velocity_m_s() const { return motion_.velocity_m_s(); }
Vector3d CellsBody::angular_velocity_rad_s() const { return motion_.angular_velocity_rad_s(); }

std::vector<ParticleState> CellsBody::particles() const {
  std::vector<ParticleState> states(particle_points_.size());
  const Matrix3d lattice_from_object = extent_.object_from_lattice.conjugate().toRotationMatrix();
  for (size_t p = 0; p < states.size(); ++p) {
    const Sample sample = sample_at(particle_points_[p]);
    const auto gradients = trilinear_gradients(particle_points_[p].local, lattice_.cell_width_m);
    states[p].position_m = origin_m_ + at(sample, positions_m_);
    states[p].velocity_m_s = at(sample, velocities_m_s_);
    states[p].mass_kg = density(material_, volume_m3_) * particle_volumes_m3_[p];
    Matrix3d f = Matrix3d::Zero();
    for (int c = 0; c < 8; ++c) f += positions_m_[sample.nodes[c]] * gradients[c].transpose();
    states[p].deformation_gradient = f * lattice_from_object;
  }
  return states;
}

BodyEnergy CellsBody::energy(const Vector3d& gravity_m_s2) const {
  BodyEnergy energy;
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    const double mass = masses_kg_[i];
    const Vector3d position = origin_m_ + positions_m_[i];
    energy.kinetic_j += 0.5 * mass * velocities_m_s_[i].squaredNorm();
    energy.gravity_j -= mass * gravity_m_s2.dot(position);
    energy.linear_momentum += mass * velocities_m_s_[i];
    energy.angular_momentum += mass * position.cross(velocities_m_s_[i]);
  }
  const IsotropicMaterial isotropic{choice_.youngs_modulus_pa, material_.poisson_ratio};
  for (size_t i = 0; i < lattice_.cells.size(); ++i) {
    const LatticeCell& cell = lattice_.cells[i];
    const auto gradients = trilinear_gradients(cell.centroid, lattice_.cell_width_m);
    Matrix3d f = Matrix3d::Zero();
    std::array<Vector3d, kModeCount> modes;
    modes.fill(Vector3d::Zero());
    for (int c = 0; c < 8; ++c) {
      const Vector3d& x = positions_m_[cell.nodes[c]];
      f += x * gradients[c].transpose();
      for (int j = 0; j < kModeCount; ++j) modes[j] += 0.125 * mode_sign(j, c) * x;
    }
    const Matrix3d r = extract_rotation(f, batches_.rotation(i)).toRotationMatrix();
    for (Vector3d& mode : modes) mode = r.transpose() * mode;
    const Matrix3d stretch = r.transpose() * f;
    energy.elastic_j += cell_energy(cell, lattice_.cell_width_m, isotropic,
                                    0.5 * (stretch + stretch.transpose()) - Matrix3d::Identity(), f.determinant(),
                                    modes);
  }
  return energy;
}

ElasticAccuracy CellsBody::accuracy() const {
  ElasticAccuracy accuracy;
  accuracy.cell_width_m = choice_.cell_width_m;
  accuracy.substeps = choice_.substeps;
  accuracy.courant = choice_.courant;
  accuracy.reached_youngs_modulus_pa = choice_.youngs_modulus_pa;
  accuracy.clipped = choice_.clipped;
  accuracy.nodes = masses_kg_.size();
  accuracy.cells = lattice_.cells.size();
  accuracy.particles = particle_points_.size();
  return accuracy;
}

Vector3d CellsBody::world_point(const Vector3d& rest_point_m) const {
  return origin_m_ + at(sample_at(lattice_.embed(rest_point_m)), positions_m_);
}

Vector3d CellsBody::point_velocity_m_s(const Vector3d& rest_point_m) const {
  return at(sample_at(lattice_.embed(rest_point_m)), velocities_m_s_);
}

std::optional<ElasticBody::RayHit> CellsBody::ray_cast(const Vector3d& origin_m, const Vector3d& direction) const {
  const double within = 0.75 * extent_.box_edge_m;  // voxels seen edge-on leave no gap
  std::optional<RayHit> hit;
  for (size_t p = 0; p < particle_points_.size(); ++p) {
    const Vector3d to = origin_m_ + at(sample_at(particle_points_[p]), positions_m_) - origin_m;
    const double along = to.dot(direction);
    if (along < 0.0 || (hit && along >= hit->distance_m)) continue;
    if ((to - along * direction).squaredNorm() > within * within) continue;
    hit = RayHit{along, particle_rest_m_[p]};
  }
  return hit;
}

CellsBody::Sample CellsBody::sample_at(const EmbeddedPoint& point) const {
  return {lattice_.cells[point.cell].nodes, trilinear_weights(point.local)};
}

Vector3d CellsBody::at(const Sample& sample, const std::vector<Vector3d>& values) const {
  Vector3d sum = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) sum += sample.weights[c] * values[sample.nodes[c]];
  return sum;
}

}  // namespace livegs
