// SPDX-License-Identifier: GPL-3.0-or-later
// Rolling resistance of a soft body, and of balls on one. Rolling deforms the contact zone continuously, and
// part of the strain energy is lost: a couple against the spin, M = 3/16 alpha P a for a cylinder or ball
// with load P and contact radius a, with alpha the fraction of strain energy lost per cycle (Johnson 1985,
// Contact mechanics, 9.4). The damping of the sweep barely acts on it, because slow rolling deforms slowly.
// Without rolling resistance, a soft ball rocks for minutes, and a rigid ball rolls off a soft block.
#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/motion/vector_algebra.h"

namespace livegs::cells {
namespace {

// Minimum decay time of the spin; prevents excitation of jittering bodies.
constexpr double kSpinDecayTime_s = 0.02;

struct Push {
  Vector3d at_m, impulse_n_s;
  // The surface's radii of curvature at the point, m: of a sphere r (1 - n n^T), of a cylinder r across its
  // axis.
  Matrix3d radii_m;
};

// Couple against the relative spin w, N m s, that a contact with the impulses `pushes` can bear; zero without
// load. The points approach the other body at w.((x - c) x n); Q is the mean square of that by the load, so
// that sqrt(w.Q w) is the speed of rolling times the extent of the contact, and the couple is its gradient:
// none against a spin about the normal, and less about the line of contact than across it. Each point
// stands for a Hertzian contact of its own force, of the radius (3 f r / 4 E*)^(1/3), with `stiffness_pa` the
// plane strain modulus E*. `stop` is the couple that ends the spin per spin, N m s²; where less than the
// whole couple does, the rolling ends.
Vector3d rolling_resistance(const std::vector<Push>& pushes, const Vector3d& spin, double loss_factor,
                            double stiffness_pa, double step_s, double stop) {
  double pressed = 0.0;
  Vector3d push = Vector3d::Zero(), centre = Vector3d::Zero();
  for (const auto& [at_m, impulse_n_s, radii_m] : pushes) {
    const double size = impulse_n_s.norm();
    pressed += size;
    centre += size * at_m;
    push += impulse_n_s;
  }
  const double through = push.norm();
  if (!(through > 0.0)) return Vector3d::Zero();
  centre /= pressed;
  const Vector3d normal = push / through;
  // Mean square of the points about their centre, by the load; that of a Hertzian pressure over a circle of
  // radius a is a² / 5 along a line.
  Matrix3d spread = Matrix3d::Zero();
  for (const auto& [at_m, impulse_n_s, radii_m] : pushes) {
    const double size = impulse_n_s.norm();
    spread += size / pressed * (at_m - centre) * (at_m - centre).transpose();
    const double sum_m = radii_m.trace();
    if (!(sum_m > 0.0)) continue;
    const double radius_m = radii_m.squaredNorm() / sum_m;
    const double contact_m = std::cbrt(0.75 * size / step_s * radius_m / stiffness_pa);
    spread += size / pressed * contact_m * contact_m / 5.0 / radius_m * radii_m;
  }
  const Matrix3d across = cross_matrix(normal);
  const Matrix3d extent = across * spread * across.transpose();
  const Vector3d rolling = spin - normal * normal.dot(spin), rolled = extent * spin;
  const double speed = std::sqrt(std::max(0.0, spin.dot(rolled)));
  if (!(speed > 0.0)) return Vector3d::Zero();
  const double lost = std::min(1.0, 2.0 * M_PI * loss_factor);
  const double most = 3.0 / 16.0 * lost * through * std::sqrt(5.0);
  // As friction: the rolling ends if the couple can take its energy.
  if (most * speed >= stop * rolling.squaredNorm()) return -stop * spin;
  return -most / speed * rolled;
}

}  // namespace

double CellsBody::plane_strain_modulus_pa() const {
  const IsotropicMaterial& own = materials_.cells.materials[0];
  return own.youngs_modulus_pa / (1.0 - own.poisson_ratio * own.poisson_ratio);
}

// Rolling on colliders, by the contact impulses from `first_contact` on.
void CellsBody::apply_rolling_resistance(size_t first_contact, double step_s) {
  if (without(Mechanism::RollingResistance)) return;
  // No rolling resistance during impacts.
  if (!free() || !step_.is_slow || colliders_.contacts.size() == first_contact) return;
  const Vector3d spin = ledger_.motion.angular_velocity_rad_s();
  const double speed = spin.norm();
  if (!(speed > 0.0)) return;
  std::vector<Push> pushes;
  const Matrix3d world_from_lattice =
      (ledger_.step_orientation * extent_.object_from_lattice).toRotationMatrix();
  for (size_t i = first_contact; i < colliders_.contacts.size(); ++i) {
    const ColliderContact& touch = colliders_.contacts[i];
    Matrix3d radii_m = Matrix3d::Zero();
    if (!surface_.patches.empty()) {
      const Matrix3d in_lattice = surface_.patches[touch.point].flatten.cast<double>();
      radii_m = world_from_lattice * in_lattice * world_from_lattice.transpose();
    }
    pushes.push_back({nodes_.corrected_m(touch.sample), touch.impulse_n_s, radii_m});
  }
  const Vector3d axis = spin / speed;
  const double stop = std::min(1.0, step_s / kSpinDecayTime_s) * axis.dot(ledger_.motion.inertia * axis);
  ledger_.contact_moment +=
      rolling_resistance(pushes, spin, materials_.own.loss_factor, plane_strain_modulus_pa(), step_s, stop);
}

// Resistance of balls that roll on this body, by the rows that it listed. Only balls: faces rest on their
// own, and a box leaning on a block and a floor would jitter between them. A held body takes part. The spin
// ends as soon as the couple suffices; a decay over kSpinDecayTime_s would let balls creep away.
void CellsBody::apply_rolling_resistance(std::span<const ContactConstraint> rows) {
  if (without(Mechanism::RollingResistance)) return;
  if (!step_.is_slow) return;
  std::vector<RigidProxy*> met;
  for (const ContactConstraint& row : rows) {
    const bool rolls = row.rigid && row.rigid->shape->is_ball() && row.normal_impulse_n_s > 0.0;
    if (rolls && std::find(met.begin(), met.end(), row.rigid) == met.end()) met.push_back(row.rigid);
  }
  std::vector<Push> pushes;
  for (RigidProxy* rigid : met) {
    const Vector3d spin =
        rigid->spin_rad_s - (free() ? ledger_.motion.angular_velocity_rad_s() : Vector3d::Zero());
    const double speed = spin.norm();
    if (!(speed > 0.0)) continue;
    pushes.clear();
    for (const ContactConstraint& row : rows) {
      if (row.rigid != rigid || !(row.normal_impulse_n_s > 0.0)) continue;
      pushes.push_back(
          {row.point_m - origin_m_, row.normal_impulse_n_s * row.normal,
           rigid->shape->sphere_radius_m * (Matrix3d::Identity() - row.normal * row.normal.transpose())});
    }
    const Vector3d axis = spin / speed;
    double mobility = axis.dot(rigid->inverse_inertia * axis);
    if (free()) mobility += axis.dot(solve_inertia(ledger_.motion.inertia, axis));
    const Vector3d couple = rolling_resistance(pushes, spin, materials_.own.loss_factor,
                                               plane_strain_modulus_pa(), rigid->step_s, 1.0 / mobility);
    rigid->turn(couple);
    ledger_.contact_moment -= couple;
  }
}

}  // namespace livegs::cells
