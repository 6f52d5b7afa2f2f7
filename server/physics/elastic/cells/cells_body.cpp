// SPDX-License-Identifier: GPL-3.0-or-later
// Construction, and queries between substeps.
#include "physics/elastic/cells/cells_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/log.h"
#include "core/math/pseudo_inverse.h"
#include "core/revision.h"
#include "physics/ablation/ablation.h"
#include "physics/collision/surface_points.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/lattice/region_load.h"
#include "physics/surface_friction.h"

namespace livegs::cells {
namespace {

constexpr double kMinNodeMassRatio = 1e-3;  // minimum node mass relative to the heaviest node of its cells

}  // namespace

CellsBody::CellsBody(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep)
    : options_(description.cells),
      object_id_(description.object_id),
      extent_(measure_extent(description.particles)),
      particle_rest_m_(description.particles.positions_m),
      particle_volumes_m3_(description.particles.volumes_m3) {
  materials_.own = description.material;
  accuracy_.rate_hz = rate_hz;
  accuracy_.scene_substeps = substeps;
  accuracy_.given_substeps = description.substeps;
  accuracy_.max_node_substeps = description.cell_width_m > 0.0 ? std::numeric_limits<double>::infinity()
                                                               : description.max_node_substeps;
  accuracy_.scene_node_substeps = description.scene_node_substeps;
  holding_.world_from_object = {description.world_from_object.position_m,
                                description.world_from_object.orientation.normalized()};
  orientation_ = holding_.world_from_object.orientation;
  rest_.may_rest = may_sleep;
  rest_.sleep_timer = SleepTimer(may_sleep);
  for (const double volume : particle_volumes_m3_) volume_m3_ += volume;
  for (size_t i = 0; i < description.regions.size(); ++i) {
    const BodyRegion& region = description.regions[i];
    holding_.boundary_moved = holding_.boundary_moved || (region.boundary && region.motion);
    if (!region.material) continue;
    materials_.regions.push_back(*region.material);
    materials_.region_names.push_back(region.name.empty() ? "region " + std::to_string(i) : region.name);
  }
  set_up_materials();
  choose(description.cell_width_m);
  lattice_ = build_lattice(extent_, accuracy_.resolution.cell_width_m, description.regions);
  accuracy_.is_thin = thin_part(lattice_, extent_.loose) > kMaxThinPart;
  if (accuracy_.is_thin) {
    choose(description.cell_width_m);  // with the limit of thin material
    if (accuracy_.resolution.cell_width_m != lattice_.cell_width_m)
      lattice_ = build_lattice(extent_, accuracy_.resolution.cell_width_m, description.regions);
  }
  neighbours_ = find_node_neighbours(lattice_.node_coordinates);
  if (const int pieces = piece_count(lattice_), own = description.particles.piece_count;
      own > 0 && pieces > own) {
    log_warn(
        "object %u: the lattice has %d pieces but the surface has %d, so the body comes apart; "
        "reduce spacing_m below %.3g m",
        object_id_, pieces, own, extent_.spacing_m);
  }
  for (const Vector3d& particle : particle_rest_m_) particle_points_.push_back(lattice_.embed(particle));

  nodes_ = CellNodes(lattice_.node_coordinates.size(), lattice_.cell_width_m);
  inverse_masses_.assign(nodes_.count(), 1.0);
  hold_regions(description);
  set_masses();
  make_surface(description.patches ? *description.patches : surface_patches(description.particles));
  start_motion(description);
  load_regions(description);
  rebuild_cells();
}

void CellsBody::set_up_materials() {
  static_cast<BodyMaterials&>(materials_) = body_materials(materials_.own, materials_.regions, volume_m3_);
}

double CellsBody::material_friction(size_t material) const {
  const double own = materials_.own.friction;
  if (material == 0) return own;
  const RegionMaterial& region = materials_.regions[material - 1];
  return region.friction.value_or(std::min(region.friction_factor * own, kMaxFriction));
}

double CellsBody::friction_at(uint32_t point) const {
  if (surface_.lattice_cells.empty()) return materials_.own.friction;
  double friction = 0.0;
  for (const MaterialShare& share : lattice_.cells[surface_.lattice_cells[point]].materials)
    friction += share.part * material_friction(share.material);
  return friction;
}

double CellsBody::max_friction() const {
  double friction = materials_.own.friction;
  for (size_t k = 1; k <= materials_.regions.size(); ++k) friction = std::max(friction, material_friction(k));
  return friction;
}

void CellsBody::choose(double cell_width_m) {
  materials_.cells.materials = materials_.elastic;  // limited below if clipped
  ResolutionRequest request = resolution_request(extent_, materials_, holding_.boundary_moved,
                                                 accuracy_.rate_hz, accuracy_.scene_substeps);
  request.cell_width_m = cell_width_m;
  request.body_substeps = accuracy_.given_substeps;
  request.max_node_substeps = accuracy_.max_node_substeps;
  if (accuracy_.is_thin) request.max_courant = std::min(request.max_courant, kMaxThinCourant);
  accuracy_.resolution = choose_resolution(request);
  accuracy_.unbudgeted.reset();
  if (accuracy_.max_node_substeps < accuracy_.scene_node_substeps) {
    request.max_node_substeps = accuracy_.scene_node_substeps;
    const LatticeResolution alone = choose_resolution(request);
    if (alone.cell_width_m != accuracy_.resolution.cell_width_m ||
        alone.substeps != accuracy_.resolution.substeps)
      accuracy_.unbudgeted = alone;
  }
  if (!options_.choose) {
    accuracy_.resolution.substeps = accuracy_.scene_substeps;
    accuracy_.resolution.youngs_modulus_pa = request.youngs_modulus_pa;
    accuracy_.resolution.clipped = false;
    accuracy_.resolution.impact_substeps = 1;
    accuracy_.resolution.courant =
        std::sqrt(request.youngs_modulus_pa / request.density_kg_m3) /
        (accuracy_.rate_hz * accuracy_.scene_substeps * accuracy_.resolution.cell_width_m);
  }
  if (!accuracy_.resolution.clipped) return;
  const double ceiling = accuracy_.resolution.youngs_modulus_pa / request.density_kg_m3;
  for (size_t k = 0; k < materials_.densities_kg_m3.size(); ++k) {
    IsotropicMaterial& one = materials_.cells.materials[k];
    one.youngs_modulus_pa = std::min(one.youngs_modulus_pa, ceiling * materials_.densities_kg_m3[k]);
  }
}

// A node at the far corner of a nearly empty cell can have a millionth of its neighbours' mass; it then
// amplifies rounding errors. Such a node gets kMinNodeMassRatio of the mass of the heaviest node that it
// shares a cell with. All masses are then scaled to keep the mass of the body.
void CellsBody::regularise_node_masses() {
  std::vector<uint32_t> parents(masses_kg_.size());
  for (uint32_t i = 0; i < parents.size(); ++i) parents[i] = i;
  for (const LatticeCell& cell : lattice_.cells) {
    const uint32_t heaviest =
        *std::max_element(cell.nodes.begin(), cell.nodes.end(), [&](uint32_t a, uint32_t b) {
          return masses_kg_[a] < masses_kg_[b] || (masses_kg_[a] == masses_kg_[b] && a > b);
        });
    for (const uint32_t node : cell.nodes) {
      if (masses_kg_[heaviest] > masses_kg_[parents[node]]) parents[node] = heaviest;
    }
  }
  double before = 0.0, after = 0.0;
  const std::vector<double> own_kg = masses_kg_;
  for (uint32_t i = 0; i < masses_kg_.size(); ++i) {
    before += own_kg[i];
    if (!without(Mechanism::LightNodeMass) && own_kg[i] < kMinNodeMassRatio * own_kg[parents[i]]) {
      masses_kg_[i] = kMinNodeMassRatio * own_kg[parents[i]];
    }
    after += masses_kg_[i];
  }
  for (double& mass : masses_kg_) mass *= before / after;
}

// Scales the densities that are factors on the body's own, so that its mass does not depend on how cells
// divide the regions. Without factors other than 1 nothing changes.
void CellsBody::normalise_densities() {
  const double own_kg_m3 = materials_.own.mass_kg / volume_m3_;
  const auto factor = [&](size_t k) -> std::optional<double> {
    if (k == 0) return 1.0;
    const RegionMaterial& region = materials_.regions[k - 1];
    return region.density_kg_m3 ? std::nullopt : std::optional(region.density_factor);
  };
  double volume_m3 = 0.0, weighted_m3 = 0.0;
  for (size_t k = 0; k < lattice_.material_node_volumes_m3.size(); ++k) {
    if (!factor(k)) continue;
    for (const double one : lattice_.material_node_volumes_m3[k]) {
      volume_m3 += one;
      weighted_m3 += *factor(k) * one;
    }
  }
  if (!(weighted_m3 > 0.0)) return;
  for (size_t k = 0; k < materials_.densities_kg_m3.size(); ++k) {
    if (factor(k)) materials_.densities_kg_m3[k] = volume_m3 / weighted_m3 * *factor(k) * own_kg_m3;
  }
}

void CellsBody::set_masses() {
  normalise_densities();
  masses_kg_.assign(nodes_.count(), 0.0);
  for (size_t k = 0; k < lattice_.material_node_volumes_m3.size(); ++k) {
    for (size_t i = 0; i < masses_kg_.size(); ++i) {
      masses_kg_[i] += materials_.densities_kg_m3[k] * lattice_.material_node_volumes_m3[k][i];
    }
  }
  regularise_node_masses();
  mass_kg_ = 0.0;
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    mass_kg_ += masses_kg_[i];
    inverse_masses_[i] = inverse_masses_[i] > 0.0 ? 1.0 / masses_kg_[i] : 0.0;
    nodes_.set_mass(i, masses_kg_[i], inverse_masses_[i]);
  }
  set_moment_map();
}

// Called after changes of masses, held nodes or plastic state. The rotations of the sweep are kept.
void CellsBody::rebuild_cells() {
  std::vector<Quaterniond> rotations(lattice_.cells.size(), orientation_ * extent_.object_from_lattice);
  if (!batches_.places.empty()) {
    for (size_t i = 0; i < rotations.size(); ++i) {
      if (batches_.places[i].kind != CellPlace::Kind::Held) rotations[i] = batches_.rotation(i);
    }
  }
  surface_.mobility.clear();
  for (const NodeSample& sample : surface_.points)
    surface_.mobility.push_back(static_cast<float>(mobility(sample)));
  predict_accuracy();
  batches_ = make_cell_batches(lattice_, inverse_masses_, rotations, nodes_.spare(), plastic_.parts.empty(),
                               options_.thin);
  gains_.own = gains_.impact = gains_.imposed = {};
  gains_.last_step_s = 0.0;
  flat_revision_ = new_revision();
  if (!plastic_.parts.empty()) set_all_plastic();
}

// Assumes second-order steps, which all bodies in motion use. The band of a clipped material is that of the
// simulated modulus, scaled by its ratio to the requested modulus.
void CellsBody::predict_accuracy() {
  const double step_s =
      (options_.second_order ? 2.0 / 3.0 : 1.0) / (accuracy_.rate_hz * accuracy_.resolution.substeps);
  const Vector3d cells = size_m() / lattice_.cell_width_m;
  accuracy_.materials.clear();
  accuracy_.thin_part = thin_part(lattice_, extent_.loose);
  for (size_t k = 0; k < materials_.densities_kg_m3.size(); ++k) {
    const IsotropicMaterial& one = materials_.cells.materials[k];
    const double courant =
        std::sqrt(one.youngs_modulus_pa / materials_.densities_kg_m3[k]) * step_s / lattice_.cell_width_m;
    ModulusBand band =
        band_of({.mean_pass_compliance =
                     mean_pass_compliance(lattice_, inverse_masses_, one.youngs_modulus_pa, step_s),
                 .poisson_ratio = one.poisson_ratio,
                 .cells_across = cells.minCoeff(),
                 .cells_along = cells.maxCoeff(),
                 .courant = courant,
                 .ceiling_ratio = modulus_ceiling_pa(lattice_, materials_.densities_kg_m3[k], step_s) /
                                  one.youngs_modulus_pa});
    if (accuracy_.thin_part > kMaxThinPart && band.band != ElasticBand::Unknown) {
      if (band.band == ElasticBand::Exact) band.band = ElasticBand::Band;
      band.ratio_low *= kThinBendsFrom;
      band.ratio_high *= kThinBendsTo;
      band.ratio_across = std::max(band.ratio_across, band.ratio_high);
    }
    const double requested_pa = materials_.elastic[k].youngs_modulus_pa,
                 kept = one.youngs_modulus_pa / requested_pa;
    const bool clipped = one.youngs_modulus_pa < requested_pa;
    accuracy_.materials.push_back({clipped ? ElasticBand::Clipped : band.band, requested_pa,
                                   one.youngs_modulus_pa, band.ratio_low * kept, band.ratio_high * kept,
                                   band.ratio_across * kept, clipped});
  }
}

// The gains of a thin cell need the inverse of an 18 x 18 matrix, and a body can alternate between step
// lengths (alone, in an impact, with neighbours). The gains of each are therefore cached.
const GaussSeidelGains& CellsBody::gains_of(double h, bool second_order) {
  const auto alike = [&](double other_s) { return std::abs(h - other_s) <= 1e-9 * h; };
  const double own_s = 1.0 / (accuracy_.rate_hz * accuracy_.resolution.substeps);
  Gains::OfStep& gains = alike(own_s)                                          ? gains_.own
                         : alike(own_s / accuracy_.resolution.impact_substeps) ? gains_.impact
                                                                               : gains_.imposed;
  if (!alike(gains.step_s)) gains = {h, {}};
  std::optional<GaussSeidelGains>& found = gains.of_order[second_order];
  if (!found) {
    found = make_gauss_seidel_gains(lattice_, batches_, inverse_masses_, materials_.cells,
                                    options_.compensate, second_order ? 2.0 * h / 3.0 : h);
  }
  return *found;
}

// Node velocities from particle velocities: the best fit that is linear in position, so that rotation,
// stretch and shear are exact, plus mass-weighted means of the residuals.
std::vector<Vector3d> CellsBody::node_velocities(std::span<const Vector3d> velocities_m_s,
                                                 const Vector3d& rest_centre_m,
                                                 const Matrix3d& world_from_rest) const {
  const auto arm = [&](const Vector3d& rest_m) -> Vector3d {
    return world_from_rest * (rest_m - rest_centre_m);
  };
  double volume_m3 = 0.0;
  Vector3d middle = Vector3d::Zero(), mean = Vector3d::Zero();
  for (size_t p = 0; p < velocities_m_s.size(); ++p) {
    volume_m3 += particle_volumes_m3_[p];
    middle += particle_volumes_m3_[p] * arm(particle_rest_m_[p]);
    mean += particle_volumes_m3_[p] * velocities_m_s[p];
  }
  middle /= volume_m3;
  mean /= volume_m3;
  Matrix3d spread = Matrix3d::Zero(), moved = Matrix3d::Zero();
  for (size_t p = 0; p < velocities_m_s.size(); ++p) {
    const Vector3d r = arm(particle_rest_m_[p]) - middle;
    spread += particle_volumes_m3_[p] * r * r.transpose();
    moved += particle_volumes_m3_[p] * (velocities_m_s[p] - mean) * r.transpose();
  }
  const Matrix3d gradient = moved * pseudo_inverse(spread);
  const auto linear = [&](const Vector3d& r) -> Vector3d { return mean + gradient * (r - middle); };

  std::vector<Vector3d> velocities(nodes_.count(), Vector3d::Zero());
  std::vector<double> shares(nodes_.count(), 0.0);
  for (size_t p = 0; p < velocities_m_s.size(); ++p) {
    const NodeSample sample = sample_at(particle_points_[p]);
    const Vector3d left = velocities_m_s[p] - linear(arm(particle_rest_m_[p]));
    for (int c = 0; c < 8; ++c) {
      const double share = particle_volumes_m3_[p] * std::max(0.0f, sample.weights[c]);
      velocities[sample.nodes[c]] += share * left;
      shares[sample.nodes[c]] += share;
    }
  }
  for (size_t i = 0; i < velocities.size(); ++i) {
    if (shares[i] > 0.0) velocities[i] /= shares[i];
    velocities[i] += linear(arm(lattice_.node_position_m(i)));
  }
  return velocities;
}

void CellsBody::start_motion(const ElasticBodyDescription& description) {
  const size_t count = nodes_.count();
  std::vector<Vector3d> velocities(count, Vector3d::Zero()), positions(count);

  std::mt19937_64 random(description.cells.scramble);
  const auto anywhere = [&] { return 2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0; };
  const Vector3d rest_centre = rest_centre_m();
  origin_m_ = holding_.world_from_object * rest_centre;
  const Matrix3d world_from_rest = orientation_.toRotationMatrix() * description.initial_deformation;
  if (!description.particle_velocities_m_s.empty()) {
    velocities = node_velocities(description.particle_velocities_m_s, rest_centre, world_from_rest);
  }
  for (size_t i = 0; i < count; ++i) {
    const Vector3d r = lattice_.node_position_m(i) - rest_centre;
    positions[i] = orientation_ * (description.initial_deformation * r);
    velocities[i] += description.velocity_m_s + description.angular_velocity_rad_s.cross(positions[i]);
    if (description.cells.scramble > 0) {
      const Vector3d far(anywhere(), anywhere(), anywhere());
      positions[i] = orientation_ * (extent_.object_from_lattice * far.cwiseProduct(size_m()));
    }
    if (inverse_masses_[i] == 0.0) {
      positions[i] = orientation_ * r;
      velocities[i].setZero();
    }
    nodes_.set_motion(i, positions[i], velocities[i]);
  }
  ledger_.motion = body_momentum(positions, velocities, masses_kg_);
  ledger_.step_orientation = orientation_;
  use_material_inertia();
  ledger_.momentum_before = ledger_.motion.momentum;
  ledger_.angular_before = ledger_.motion.angular_momentum;
  whole_ = {centre_m(), orientation_};
  for (const Vector3d& position : positions)
    reach_m_ = std::max(reach_m_, (position - ledger_.motion.centre_m).norm());
}

void CellsBody::set_node_substep_budget(double node_substeps) {
  if (std::isfinite(accuracy_.max_node_substeps)) accuracy_.max_node_substeps = node_substeps;
}

void CellsBody::set_material(const Material& material) {
  become_elastic();
  materials_.own = material;
  set_up_materials();
  choose(accuracy_.resolution.cell_width_m);
  const double before = mass_kg_;
  set_masses();
  // The velocities stay, so momentum changes with the mass.
  if (mass_kg_ != before) restart_motion();
  rebuild_cells();
  wake();
}

BodyMomentum CellsBody::node_motion() const {
  std::vector<Vector3d> positions, velocities;
  for (size_t i = 0; i < nodes_.count(); ++i) {
    positions.push_back(nodes_.position_m(i));
    velocities.push_back(nodes_.velocity_m_s(i));
  }
  return body_momentum(positions, velocities, masses_kg_);
}

void CellsBody::restart_motion() {
  for (size_t i = 0; i < nodes_.count(); ++i)
    nodes_.set_motion(i, nodes_.position_m(i), nodes_.velocity_m_s(i));
  ledger_.motion = node_motion();
  ledger_.step_orientation = orientation_;
  use_material_inertia();
  ledger_.restart();
  colliders_.margin_m = 0.0;
  bodies_.revision = new_revision();
  step_.first = true;
}

void CellsBody::wake() {
  if (asleep()) bodies_.revision = new_revision();  // bodies around have moved uncounted
  become_elastic();
  rest_.sleep_timer.wake();
  rest_.stationary_s = 0.0;
  colliders_.margin_m = 0.0;  // colliders may have changed
}

// Hysteretic damping dissipates 2 pi eta of a vibration's energy per cycle. Damping at the rate eta omega is
// equivalent at one frequency, here the lowest.
double CellsBody::damping_rate() const { return materials_.own.loss_factor * lowest_rate_rad_s(); }

// Axial or bending mode of a beam with the body's smallest thickness and its longest side, with free ends, or
// with one held end and the length holding_.reach_m.
double CellsBody::lowest_rate_rad_s() const {
  const Vector3d size = size_m();
  const double length = free() ? size.maxCoeff() : holding_.reach_m, thickness = size.minCoeff();
  const double wave_m_s =
      std::sqrt(materials_.cells.materials[0].youngs_modulus_pa / materials_.densities_kg_m3[0]);
  const double axial = (free() ? M_PI : M_PI_2) / length;
  const double bending = (free() ? 22.37 : 3.516) / std::sqrt(12.0) * thickness / (length * length);
  return wave_m_s * std::min(axial, bending);
}

RestBody CellsBody::rest_body() const {
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.object_from_lattice = lattice_.object_from_lattice;
  rest.cell_width_m = lattice_.cell_width_m;
  rest.node_coordinates = lattice_.node_coordinates;
  for (const LatticeCell& cell : lattice_.cells) {
    rest.cells.push_back(cell.nodes);
    if (lattice_.has_virtual_cells) rest.cell_fills.push_back(cell.fill);
  }
  return rest;
}

void CellsBody::write_drivers(ObjectDrivers& drivers) const {
  drivers.kind = DriverKind::Lattice;
  drivers.neighbours = neighbours_;
  drivers.poses.clear();
  drivers.rotations.clear();
  drivers.positions_m.resize(nodes_.count());
  for (size_t i = 0; i < nodes_.count(); ++i) {
    drivers.positions_m[i] = (origin_m_ + nodes_.position_m(i)).cast<float>();
  }
}

Pose CellsBody::centre_pose() const {
  Matrix3d match = Matrix3d::Zero();
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) rest_centre += masses_kg_[i] * lattice_.node_position_m(i);
  rest_centre /= mass_kg_;
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    match += masses_kg_[i] * (nodes_.position_m(i) - ledger_.motion.centre_m) *
             (lattice_.node_position_m(i) - rest_centre).transpose();
  }
  return {origin_m_ + ledger_.motion.centre_m, extract_rotation(match, orientation_)};
}

Vector3d CellsBody::velocity_m_s() const { return ledger_.motion.velocity_m_s(); }
Vector3d CellsBody::angular_velocity_rad_s() const { return ledger_.motion.angular_velocity_rad_s(); }

double CellsBody::elastic_j() const {
  double sum = 0.0;
  for (size_t i = 0; i < lattice_.cells.size(); ++i) sum += energy_of(i, shape_of(i));
  return sum;
}

BodyEnergy CellsBody::energy(const Vector3d& gravity_m_s2) const {
  BodyEnergy energy;
  Matrix3d second = Matrix3d::Zero();
  const Vector3d centre = centre_m();
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    const double mass = masses_kg_[i];
    const Vector3d position = origin_m_ + nodes_.position_m(i), velocity = node_velocity(i);
    energy.kinetic_j += 0.5 * mass * velocity.squaredNorm();
    energy.gravity_j -= mass * gravity_m_s2.dot(position);
    energy.linear_momentum += mass * velocity;
    energy.angular_momentum += mass * position.cross(velocity);
    const Vector3d r = position - centre;
    second += mass * r * r.transpose();
  }
  // The spin of the nodes as point masses counts with the inertia of the material.
  if (free()) {
    const Vector3d spin = ledger_.motion.angular_velocity_rad_s();
    const Vector3d excess = (inertia_of(second) - ledger_.motion.inertia) * spin;
    energy.kinetic_j -= 0.5 * spin.dot(excess);
    energy.angular_momentum -= excess;
  }
  energy.elastic_j = elastic_j();
  energy.plastic_work_j = plastic_.work_j;
  return energy;
}

AlignedBox3d CellsBody::bounds_m() const {
  if (frozen()) {  // the nodes still have their positions from the freeze
    const Vector3d around = Vector3d::Constant(reach_m_);
    return {centre_m() - around, centre_m() + around};
  }
  AlignedBox3d box;
  for (uint32_t i = 0; i < nodes_.count(); ++i) box.extend(nodes_.position_m(i));
  return box.translate(origin_m_);
}

ElasticAccuracy CellsBody::accuracy() const {
  ElasticAccuracy accuracy;
  static_cast<MaterialAccuracy&>(accuracy) = accuracy_.materials[0];
  for (size_t k = 1; k < accuracy_.materials.size(); ++k)
    accuracy.regions.push_back({accuracy_.materials[k], materials_.region_names[k - 1]});
  accuracy.cell_width_m = accuracy_.resolution.cell_width_m;
  accuracy.substeps = accuracy_.resolution.substeps;
  accuracy.courant = accuracy_.resolution.courant;
  accuracy.recovery_count = recovery_count_;
  accuracy.node_substeps = accuracy_.resolution.node_substeps;
  if (accuracy_.unbudgeted) {
    accuracy.unbudgeted_cell_width_m = accuracy_.unbudgeted->cell_width_m;
    accuracy.unbudgeted_reached_pa = accuracy_.unbudgeted->youngs_modulus_pa;
  }
  accuracy.over_budget = accuracy_.resolution.over_budget;
  accuracy.sag = materials_.densities_kg_m3[0] * 9.81 * size_m().minCoeff() /
                 materials_.cells.materials[0].youngs_modulus_pa;
  accuracy.thin_part = accuracy_.thin_part;
  accuracy.nodes = nodes_.count();
  accuracy.cells = lattice_.cells.size();
  accuracy.particles = particle_points_.size();
  accuracy.bytes = nodes_.bytes() + batches_.bytes() +
                   surface_.points.capacity() * (sizeof(NodeSample) + sizeof(Eigen::Vector3f)) +
                   surface_.lattice_cells.capacity() * sizeof(uint32_t) +
                   surface_.face_normals.capacity() * sizeof(Eigen::Vector3f) +
                   surface_.cells.capacity() * sizeof(SurfaceCell);
  for (const Gains::OfStep* gains : {&gains_.own, &gains_.impact, &gains_.imposed}) {
    for (const auto& of_order : gains->of_order) accuracy.bytes += of_order ? of_order->bytes() : 0;
  }
  return accuracy;
}

Vector3d CellsBody::world_point(const Vector3d& rest_point_m) const {
  return origin_m_ + nodes_.position_m(sample_at(lattice_.embed(rest_point_m)));
}

Vector3d CellsBody::point_velocity_m_s(const Vector3d& rest_point_m) const {
  return velocity_of(sample_at(lattice_.embed(rest_point_m)));
}

std::optional<ElasticBody::RayHit> CellsBody::ray_cast(const Vector3d& origin_m,
                                                       const Vector3d& direction) const {
  const double within = 0.75 * extent_.box_edge_m;  // no gaps between voxels in an edge-on view
  std::optional<RayHit> hit;
  for (size_t p = 0; p < particle_points_.size(); ++p) {
    const Vector3d to = origin_m_ + nodes_.position_m(sample_at(particle_points_[p])) - origin_m;
    const double along = to.dot(direction);
    if (along < 0.0 || (hit && along >= hit->distance_m)) continue;
    if ((to - along * direction).squaredNorm() > within * within) continue;
    hit = RayHit{along, particle_rest_m_[p]};
  }
  return hit;
}

NodeSample CellsBody::sample_at(const EmbeddedPoint& point) const {
  return sample_of(lattice_.cells[point.cell].nodes, point.local);
}

Vector3d CellsBody::node_velocity(size_t node) const {
  if (inverse_masses_[node] == 0.0) return nodes_.velocity_m_s(node);
  return nodes_.velocity_m_s(node) + ledger_.velocity_correction +
         ledger_.spin_correction.cross(nodes_.position_m(node) - ledger_.motion.centre_m);
}

Vector3d CellsBody::velocity_of(const NodeSample& sample) const {
  Vector3d sum = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) sum += sample.weights[c] * node_velocity(sample.nodes[c]);
  return sum;
}

}  // namespace livegs::cells

namespace livegs {

Result<std::unique_ptr<ElasticBody>> make_elastic_body(const ElasticBodyDescription& description,
                                                       double rate_hz, int substeps, bool may_sleep) {
  if (auto checked = check_elastic_body(description, rate_hz, substeps); !checked) return checked.error();
  return std::unique_ptr<ElasticBody>(
      std::make_unique<cells::CellsBody>(description, rate_hz, substeps, may_sleep));
}

}  // namespace livegs
