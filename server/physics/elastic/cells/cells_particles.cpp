// SPDX-License-Identifier: GPL-3.0-or-later
// The state of the body's particles for output.
#include "physics/elastic/cells/cells_body.h"

namespace livegs::cells {

// Deformation gradients of the nodes, from the lattice to the world: means over the adjacent cells of the
// gradients at their corners, as for the kernels (common/skin/kernels/skin_lattice.cpp).
std::vector<Matrix3d> CellsBody::node_gradients() const {
  std::vector<Matrix3d> gradients(nodes_.count(), Matrix3d::Zero());
  std::vector<int> cells_around(nodes_.count(), 0);
  for (const LatticeCell& cell : lattice_.cells) {
    for (int c = 0; c < 8; ++c) {
      const uint32_t node = cell.nodes[c];
      ++cells_around[node];
      for (int d = 0; d < 3; ++d) {
        const double sign = c & 1 << d ? 1.0 : -1.0;
        gradients[node].col(d) +=
            sign * (nodes_.position_m(node) - nodes_.position_m(cell.nodes[c ^ 1 << d]));
      }
    }
  }
  for (size_t i = 0; i < gradients.size(); ++i) gradients[i] /= cells_around[i] * lattice_.cell_width_m;
  return gradients;
}

std::vector<ParticleState> CellsBody::particles() const {
  std::vector<ParticleState> states(particle_points_.size());
  const Matrix3d lattice_from_object = extent_.object_from_lattice.conjugate().toRotationMatrix();
  const std::vector<Matrix3d> gradients = node_gradients();
  double mass = 0.0;
  for (size_t p = 0; p < states.size(); ++p) {
    const NodeSample sample = sample_at(particle_points_[p]);
    const double density = density_of(lattice_.cells[particle_points_[p].cell]);
    states[p].position_m = origin_m_ + nodes_.position_m(sample);
    states[p].velocity_m_s = velocity_of(sample);
    states[p].mass_kg = density * particle_volumes_m3_[p];
    mass += states[p].mass_kg;
    Matrix3d f = Matrix3d::Zero();
    for (int c = 0; c < 8; ++c) f += sample.weights[c] * gradients[sample.nodes[c]];
    states[p].deformation_gradient = f * lattice_from_object;
  }
  for (ParticleState& state : states) state.mass_kg *= mass_kg_ / mass;
  if (free()) match_momentum(states);
  return states;
}

// The particles have nearly the body's centre and inertia. A rigid velocity gives them its linear and angular
// momentum.
void CellsBody::match_momentum(std::vector<ParticleState>& states) const {
  const BodyEnergy body = energy(Vector3d::Zero());
  std::vector<Vector3d> positions, velocities;
  std::vector<double> masses;
  for (const ParticleState& state : states) {
    positions.push_back(state.position_m - origin_m_);
    velocities.push_back(state.velocity_m_s);
    masses.push_back(state.mass_kg);
  }
  const BodyMomentum own = body_momentum(positions, velocities, masses);
  const Vector3d centre = origin_m_ + own.centre_m;
  const Vector3d faster = (body.linear_momentum - own.momentum) / own.mass_kg;
  const Vector3d spin = solve_inertia(
      own.inertia, body.angular_momentum - centre.cross(body.linear_momentum) - own.angular_momentum);
  for (ParticleState& state : states) state.velocity_m_s += faster + spin.cross(state.position_m - centre);
}

}  // namespace livegs::cells
