// SPDX-License-Identifier: GPL-3.0-or-later
// The body as flat arrays, for ticks that another machine steps (flat_body.h).
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/revision.h"
#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"

namespace livegs::cells {
namespace {

FlatLattice::Gains flat_gains(const auto& shear, float volume_compliance, const auto& mode) {
  FlatLattice::Gains row{};
  for (size_t k = 0; k < 21; ++k) row[k] = shear(k);
  row[21] = volume_compliance;
  for (size_t j = 0; j < 4; ++j) {
    for (size_t d = 0; d < 3; ++d) row[22 + 3 * j + d] = mode(j, d);
  }
  return row;
}

uint32_t colour_of(const Lattice& lattice, uint32_t cell) {
  uint32_t colour = 0;
  while (lattice.colour_begin[colour + 1] <= cell) ++colour;
  return colour;
}

}  // namespace

const char* CellsBody::flat_obstacle() const {
  if (!batches_.thin.empty()) return "it has sheets or cords thinner than a cell";
  if (!plastic_.parts.empty()) return "it has flowed plastically";
  if (holding_.moved) return "part of it is moved";
  for (const ConstrainedRegion& held : holding_.regions) {
    if (!held.released && !held.particles.empty()) return "it is held at single particles";
  }
  return nullptr;
}

void CellsBody::write_flat(FlatLattice& lattice) {
  lattice = {};
  lattice.node_count = nodes_.count();
  uint32_t full_row = UINT32_MAX;
  std::vector<size_t> row_cells;  // a cell of each row
  for (uint32_t i = 0; i < lattice_.cells.size(); ++i) {
    const CellPlace& at = batches_.places[i];
    if (at.kind == CellPlace::Kind::Held) continue;
    FlatLattice::Cell cell;
    std::copy(lattice_.cells[i].nodes.begin(), lattice_.cells[i].nodes.end(), cell.nodes);
    cell.colour = colour_of(lattice_, i);
    cell.constants = full_row;
    if (at.kind == CellPlace::Kind::Cut || full_row == UINT32_MAX) {
      cell.constants = static_cast<uint32_t>(lattice.constants.size());
      if (at.kind == CellPlace::Kind::Full) full_row = cell.constants;
      row_cells.push_back(i);
      lattice.constants.push_back({});
      auto& row = lattice.constants.back();
      for (size_t k = 0; at.kind == CellPlace::Kind::Cut && k < 3; ++k) {
        const CutCells& eight = batches_.cut[at.index];
        row[k] = eight.centroid[k][at.lane];
        row[3 + k] = eight.mobility[k][at.lane];
        row[6 + k] = eight.mobility[3 + k][at.lane];
        for (size_t j = 0; j < 4; ++j) row[9 + 3 * j + k] = eight.mode_coupling[j][k][at.lane];
      }
    }
    lattice.cells.push_back(cell);
  }
  const double own_s = 1.0 / (accuracy_.rate_hz * accuracy_.resolution.substeps);
  const int impact = accuracy_.resolution.impact_substeps;
  for (size_t variant = 0; variant < (impact > 1 ? 4u : 2u); ++variant) {
    const GaussSeidelGains& gains = gains_of(variant < 2 ? own_s : own_s / impact, variant % 2 == 1);
    for (size_t r = 0; r < row_cells.size(); ++r) {
      const CellPlace& at = batches_.places[row_cells[r]];
      if (at.kind == CellPlace::Kind::Full) {
        for (size_t k = 0; k < 3; ++k) lattice.constants[r][3 + k] = gains.full.mobility;
        lattice.gains[variant].push_back(flat_gains(
            [&](size_t k) {  // the diagonal of the upper triangle by rows
              const bool diagonal = k == 0 || k == 6 || k == 11 || k == 15 || k == 18 || k == 20;
              return diagonal ? gains.full.shear : 0.0f;
            },
            gains.full.volume_compliance, [&](size_t j, size_t d) { return gains.full.mode[j][d]; }));
      } else {
        const CutGains& eight = gains.cut[at.index];
        lattice.gains[variant].push_back(
            flat_gains([&](size_t k) { return eight.shear[k][at.lane]; }, eight.volume_compliance[at.lane],
                       [&](size_t j, size_t d) { return eight.mode[j][d][at.lane]; }));
      }
    }
  }
  // The points of a surface cell are in the lattice cell at the same place of the order (make_surface).
  uint32_t index = 0;
  for (const SurfaceCell& cell : surface_.cells) {
    while (lattice_.cells[index].nodes != cell.nodes) ++index;
    FlatLattice::SurfaceCell flat;
    std::copy(cell.nodes.begin(), cell.nodes.end(), flat.nodes);
    flat.begin = cell.begin;
    flat.end = cell.end;
    flat.colour = colour_of(lattice_, index);
    lattice.surface_cells.push_back(flat);
  }
  for (size_t i = 0; i < surface_.points.size(); ++i) {
    FlatLattice::SurfacePoint point;
    std::copy(std::begin(surface_.points[i].weights), std::end(surface_.points[i].weights), point.weights);
    point.mobility = surface_.mobility[i];
    lattice.surface_points.push_back(point);
  }
}

const char* CellsBody::begin_flat_tick(const FlatTick& tick, FlatState& state) {
  if (asleep()) return "it sleeps";
  if (rest_.rigid) return "it moves as a rigid body";
  if (!bodies_.stuck.empty()) return "a contact is stuck";
  if (tick.substeps != accuracy_.scene_substeps ||
      std::abs(tick.duration_s * accuracy_.rate_hz - 1.0) > 1e-9) {
    return "the tick is not that of its substeps";
  }
  for (const PointForce& force : tick.forces) {
    if (force.spring) return "a hand holds it";
  }
  if (free()) {
    const Matrix3d scaled = ledger_.node_inertia / ledger_.node_inertia.trace();
    if (!(scaled.determinant() > 1e-5)) return "it is slender";  // not solvable in single precision
  }
  SubstepContext context;
  context.start_s = tick.start_s;
  context.duration_s = tick.duration_s / tick.substeps;
  context.gravity_m_s2 = tick.gravity_m_s2;
  context.colliders = tick.colliders;
  context.forces = tick.forces;

  find_candidates(context);
  const double margin = 2.0 * colliders_.margin_m;  // of a tick, and as much again
  colliders_.margin_m = 0.0;
  state = {};
  const auto end = surface_.cells.cend();
  for (const Collider& collider : tick.colliders) {
    if (!reaches(collider, origin_m_ + ledger_.motion.centre_m, 1.5 * reach_m_ + extent_.box_edge_m + margin))
      continue;
    const auto found = std::find_if(surface_.cells.cbegin(), end, [&](const SurfaceCell& cell) {
      const Ball ball = ball_around(cell);
      return reaches(collider, origin_m_ + ball.centre_m, ball.radius_m + margin);
    });
    if (found == end) continue;
    if (!surface_.patches.empty()) return "its surface is curved and something is near";
    if (!surface_.lattice_cells.empty()) return "its friction varies and something is near";
    FlatCollider flat;
    flat.friction = mixed_friction(materials_.own.friction, collider.friction);
    flat.at_m = collider.world_from_collider.position_m - origin_m_;
    flat.world_from_collider = collider.world_from_collider.orientation.toRotationMatrix();
    if (const auto* box = std::get_if<BoxShape>(&collider.shape)) {
      flat.kind = FlatCollider::Kind::Box;
      flat.half_m = 0.5 * box->size_m;
      flat.thickness_m = box->size_m.minCoeff();
    } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
      flat.kind = FlatCollider::Kind::Sphere;
      flat.half_m = Vector3d::Constant(sphere->radius_m);
      flat.thickness_m = 2.0 * sphere->radius_m;
    } else if (std::holds_alternative<PlaneShape>(collider.shape)) {
      // Relative to the foot of the origin: a plane may be far away along itself.
      flat.at_m = flat.world_from_collider.col(1).dot(flat.at_m) * flat.world_from_collider.col(1);
    } else {
      return "a mesh is near";
    }
    state.colliders.push_back(flat);
  }

  rest_.forced = std::ranges::any_of(
      tick.forces, [](const PointForce& force) { return force.force_n.squaredNorm() > 0.0; });
  rest_.driven = false;
  gather_point_loads(context);
  state.impact = in_impact(context) && accuracy_.resolution.impact_substeps > 1;
  state.steps = accuracy_.resolution.substeps * (state.impact ? accuracy_.resolution.impact_substeps : 1);
  state.step_s = tick.duration_s / state.steps;
  state.uneven = std::abs(state.step_s - gains_.last_step_s) > 1e-9 * state.step_s;
  state.held = !free();
  state.may_be_second_order = options_.second_order;
  state.mass_kg = mass_kg_;
  state.damping_per_s = damping_rate();
  state.weight_n = mass_kg_ * tick.gravity_m_s2.norm();
  state.moving_part = free() ? M_PI * M_PI / 144.0 : 1.0 / 3.0;
  state.friction = materials_.own.friction;
  state.loss_factor = materials_.own.loss_factor;
  state.inverse_four_widths = 0.25 / lattice_.cell_width_m;
  state.slow_m_s = slow_speed_m_s(tick.gravity_m_s2);
  state.stiffness_pa = plane_strain_modulus_pa();
  for (Load& load : loads_.points) {
    load.from_m = nodes_.position_m(load.sample);
    state.load_n += load.force_n;
    state.load_torque += (load.from_m - ledger_.motion.centre_m).cross(load.force_n);
    if (state.loads_n.empty()) state.loads_n.assign(nodes_.count(), FlatVector{});
    for (int c = 0; c < 8; ++c) {
      for (int d = 0; d < 3; ++d) {
        state.loads_n[load.sample.nodes[c]][static_cast<size_t>(d)] +=
            load.sample.weights[c] * static_cast<float>(load.force_n[d]);
      }
    }
  }

  const NodeArrays nodes = nodes_.arrays();
  state.now.resize(nodes_.count());
  state.before.resize(nodes_.count());
  const auto copy = [](FlatVector& to, const NodeLanes& from) { std::memcpy(&to, &from, sizeof to); };
  for (size_t i = 0; i < nodes_.count(); ++i) {
    copy(state.now[i].place, nodes.position[i]);
    copy(state.now[i].speed, nodes.velocity[i]);
    copy(state.before[i].place, nodes.predicted[i]);
    copy(state.before[i].speed, nodes.predicted_velocity[i]);
  }
  for (const CellPlace& at : batches_.places) {
    if (at.kind == CellPlace::Kind::Held) continue;
    const Lanes(&q)[4] =
        at.kind == CellPlace::Kind::Full ? batches_.full[at.index].rotation : batches_.cut[at.index].rotation;
    state.rotations.push_back({q[1][at.lane], q[2][at.lane], q[3][at.lane], q[0][at.lane]});
  }
  static_cast<StepMemory&>(state) = step_;
  state.pressed_n = loads_.pressed_n;
  state.carried_n = loads_.carried_n;
  state.ledger = ledger_;
  return nullptr;
}

void CellsBody::end_flat_tick(const FlatTick& tick, const FlatState& state) {
  const NodeArrays nodes = nodes_.arrays();
  const auto copy = [](NodeLanes& to, const FlatVector& from) { std::memcpy(&to, &from, sizeof from); };
  for (size_t i = 0; i < nodes_.count(); ++i) {
    copy(nodes.position[i], state.now[i].place);
    copy(nodes.velocity[i], state.now[i].speed);
    copy(nodes.predicted[i], state.before[i].place);
    copy(nodes.predicted_velocity[i], state.before[i].speed);
  }
  size_t cell = 0;
  for (const CellPlace& at : batches_.places) {
    if (at.kind == CellPlace::Kind::Held) continue;
    Lanes(&q)[4] =
        at.kind == CellPlace::Kind::Full ? batches_.full[at.index].rotation : batches_.cut[at.index].rotation;
    const FlatVector& turned = state.rotations[cell++];
    for (size_t k = 0; k < 4; ++k) q[k][at.lane] = turned[(k + 3) % 4];
  }
  for (const Load& load : loads_.points)
    limiter_.work_j += load.force_n.dot(nodes_.position_m(load.sample) - load.from_m);

  static_cast<StepMemory&>(step_) = state;
  step_.first = false;
  step_.in_step = false;
  step_.second_order = state.second_order;
  step_.is_slow = state.slow;
  step_.strain_squared = state.strain_squared;
  step_.bent_squared = state.bent_squared;
  recovery_.degenerate = recovery_.degenerate || state.ever_strained;
  gains_.last_step_s = state.step_s;
  ledger_ = state.ledger;
  ledger_.step_orientation.normalize();
  ledger_.between_steps_impulse.setZero();
  loads_.pressed_n = state.pressed_n;
  loads_.carried_n = state.carried_n;
  loads_.contact_n_s = 0.0;
  loads_.contact_total.impulse_n_s += state.contact_n_s;
  loads_.contact_total.moment += state.contact_moment + state.contact_n_s * origin_m_;

  // The motion of the nodes in double precision, and the difference to the ledger as measure() has it.
  double kinetic_j = 0.0;
  for (size_t i = 0; i < nodes_.count(); ++i)
    kinetic_j += 0.5 * masses_kg_[i] * nodes_.velocity_m_s(i).squaredNorm();
  ledger_.motion = node_motion();
  use_material_inertia();
  ledger_.velocity_correction.setZero();
  ledger_.spin_correction.setZero();
  if (free()) {
    const BodyMomentum& motion = state.ledger.motion;
    ledger_.velocity_correction = (motion.momentum - ledger_.motion.momentum) / mass_kg_;
    ledger_.spin_correction =
        solve_inertia(ledger_.motion.inertia, motion.angular_momentum - ledger_.motion.angular_momentum);
    ledger_.motion.momentum = motion.momentum;
    ledger_.motion.angular_momentum = motion.angular_momentum;
  }
  const Vector3d spin = ledger_.motion.angular_velocity_rad_s();
  step_.spin_rad_s = spin.norm();
  step_.kinetic_j = kinetic_j - 0.5 * spin.dot((ledger_.node_inertia - ledger_.motion.inertia) * spin);

  colliders_.contacts.clear();
  colliders_.margin_m = 0.0;
  bodies_.contacts.clear();
  bodies_.revision = new_revision();
  surface_.boxes_known = false;
  SubstepContext context;
  context.gravity_m_s2 = tick.gravity_m_s2;
  end_substep(context);
}

}  // namespace livegs::cells
