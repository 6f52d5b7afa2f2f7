// SPDX-License-Identifier: GPL-3.0-or-later
// Inertia of the body's material, for a free body. That of its nodes as point masses is larger.
#include <Eigen/Eigenvalues>

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"

namespace livegs::cells {

double CellsBody::density_of(const LatticeCell& cell) const {
  double density_kg_m3 = 0.0;
  for (const MaterialShare& share : cell.materials)
    density_kg_m3 += share.part * materials_.densities_kg_m3[share.material];
  return density_kg_m3;
}

// Nodes as point masses have a larger inertia than the material: a cube of n cells across 1 + 2 / n² times.
void CellsBody::set_moment_map() {
  const Matrix3d object_from_lattice = lattice_.object_from_lattice.orientation.toRotationMatrix();
  double mass = 0.0;
  Vector3d centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) centre += masses_kg_[i] * lattice_.node_position_m(i);
  centre /= mass_kg_;
  Matrix3d of_nodes = Matrix3d::Zero(), of_material = Matrix3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    const Vector3d r = lattice_.node_position_m(i) - centre;
    of_nodes += masses_kg_[i] * r * r.transpose();
  }
  Vector3d material_centre = Vector3d::Zero();
  // A list of points is its own mass distribution: the momentum of the points that are given and written is
  // that of the body. A mesh is filled with material.
  for (size_t p = 0; extent_.of_points && p < particle_rest_m_.size(); ++p) {
    const double of_point = density_of(lattice_.cells[particle_points_[p].cell]) * particle_volumes_m3_[p];
    const Vector3d& r = particle_rest_m_[p];
    mass += of_point;
    material_centre += of_point * r;
    of_material += of_point * r * r.transpose();
  }
  const double half = 0.5 * lattice_.cell_width_m;
  for (const LatticeCell& cell : lattice_.cells) {
    if (extent_.of_points) break;
    const double of_cell = density_of(cell) * cell.volume_m3;
    const Vector3d lattice_m =
        half * (2.0 * cell.coordinates.cast<double>() + Vector3d::Ones() + cell.centroid);
    const Vector3d r = lattice_.object_from_lattice * lattice_m;
    const Vector3d variance = half * half / 3.0 * cell.spread;
    mass += of_cell;
    material_centre += of_cell * r;
    of_material += of_cell * (r * r.transpose() +
                              object_from_lattice * variance.asDiagonal() * object_from_lattice.transpose());
  }
  material_centre /= mass;
  of_material = mass_kg_ * (of_material / mass - material_centre * material_centre.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> map(map_between_moments(of_nodes, of_material));
  // At least 1/sqrt(3) of a node's distance counts as inertia, that of one full cell. Contacts act on the
  // nodes, whose inertia they would exceed many times in a thin cord if its own counted.
  const Vector3d kept = map.eigenvalues().cwiseMax(0.577).cwiseMin(1.0);
  ledger_.map = map.eigenvectors() * kept.asDiagonal() * map.eigenvectors().transpose();
}

// A badly strained body has the inertia of its nodes, because the moments at rest do not describe it.
bool CellsBody::has_material_inertia() const {
  return free() && !step_.strained && !without(Mechanism::MaterialInertia);
}

// World frame.
Matrix3d CellsBody::moment_map_now() const {
  if (!has_material_inertia()) return Matrix3d::Identity();
  const Matrix3d turn = ledger_.step_orientation.toRotationMatrix();
  return turn * ledger_.map * turn.transpose();
}

void CellsBody::use_material_inertia() {
  ledger_.node_inertia = ledger_.motion.inertia;
  if (!has_material_inertia()) return;
  const Matrix3d map = moment_map_now();
  ledger_.motion.inertia = inertia_of(map * second_moments_of(ledger_.node_inertia) * map);
  ledger_.motion.angular_momentum = material_angular(ledger_.motion.angular_momentum);
}

// Rate of the spin's pull on the nodes, 1/s²: that of the material less that of the nodes. With the map G
// from the nodes' moments to the material's, the kinetic energy of the spin is that of points at G r, whose
// pull on r is G W G r, W = w² - w w^T.
Matrix3d CellsBody::centrifugal_correction() const {
  if (without(Mechanism::CentrifugalCorrection) || !has_material_inertia()) return Matrix3d::Zero();
  const Matrix3d map = moment_map_now();
  const Vector3d spin = ledger_.motion.angular_velocity_rad_s();
  const Matrix3d pull = spin.squaredNorm() * Matrix3d::Identity() - spin * spin.transpose();
  return map * pull * map - pull;
}

}  // namespace livegs::cells
