// SPDX-License-Identifier: GPL-3.0-or-later
// Rolling friction of a soft body. What rolls is pressed flat and springs back all the time, and loses a part of that energy:
// a couple against the spin, M = 3/16 alpha P a for a cylinder or ball that presses with P on a contact of radius a, alpha the
// part of the strain energy that a cycle takes (Johnson 1985, Contact mechanics, 9.4). The damping of the sweep sees next to
// nothing of it, because what rolls slowly deforms slowly; without it a soft ball on a floor rocks for minutes.
#include <algorithm>
#include <cmath>

#include "physics/cells_body.h"

namespace livegs {
namespace {

constexpr double kGripTime_s = 0.02;  // no spin is ended sooner: what trembles is not stirred

}  // namespace

using Eigen::Vector3d;

void CellsBody::resist_rolling(size_t first_touch, double step_s) {
  if (!free() || !quiet_ || touches_.size() == first_touch) return;  // an impact is not rolled through
  double pressed = 0.0;
  Vector3d push = Vector3d::Zero(), centre = Vector3d::Zero();
  const auto each = [&](const auto& visit) {
    for (size_t i = first_touch; i < touches_.size(); ++i) {
      visit(touches_[i].impulse_n_s.norm(), nodes_.corrected_m(surface_[touches_[i].sample]), touches_[i].impulse_n_s);
    }
  };
  each([&](double size, const Vector3d& point, const Vector3d& impulse) {
    pressed += size;
    centre += size * point;
    push += impulse;
  });
  const double through = push.norm();
  if (!(through > 0.0)) return;
  centre /= pressed;
  const Vector3d spin = motion_.angular_velocity_rad_s();
  const double speed = spin.norm();
  if (!(speed > 0.0)) return;
  const Vector3d axis = spin / speed;
  double variance = 0.0;
  each([&](double size, const Vector3d& point, const Vector3d&) {
    variance += size / pressed * axis.cross(point - centre).squaredNorm();
  });
  // Hertz's pressure over a circle of radius a: a mean square of a² / 5 along a line.
  const double radius_m = std::sqrt(5.0 * variance), lost = std::min(1.0, 2.0 * M_PI * material_.loss_factor);
  const double part = std::min(1.0, step_s / kGripTime_s), inertia = axis.dot(motion_.inertia * axis);
  contact_moment_ -= std::min(3.0 / 16.0 * lost * through * radius_m, part * inertia * speed) * axis;
}

}  // namespace livegs
