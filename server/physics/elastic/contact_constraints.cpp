// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/contact_constraints.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The iteration stops when a sweep changes the impulses by less than this fraction of their sum. Friction
// that has not converged lets bodies creep and keeps them awake.
constexpr int kMaxIterations = 100;
constexpr double kConvergence = 0.002;
// Sweeps over the pushing rows alone after each sweep over all. Larger: cheaper sweeps, and rows that close
// in the meantime are found later.
constexpr int kPushingSweeps = 4;

Vector3d relative_displacement(const ContactConstraint& row) {
  return row.a->displacement_m(row.anchor_a) - row.b->displacement_m(row.anchor_b);
}

void prepare(ContactConstraint& row, double step_s) {
  const Matrix3d response = row.a->response(row.anchor_a) + row.b->response(row.anchor_b);
  row.displacement_before_m = relative_displacement(row);
  row.normal_response = row.normal.dot(response * row.normal);
  // Upper bound of the response in any direction of the tangent plane.
  const Vector3d tangent = row.normal.unitOrthogonal(), bitangent = row.normal.cross(tangent);
  const double k1 = tangent.dot(response * tangent), k2 = bitangent.dot(response * bitangent);
  row.tangent_response = std::max(k1, k2) + std::abs(tangent.dot(response * bitangent));
  row.friction_impulse_n_s -= row.normal * row.normal.dot(row.friction_impulse_n_s);
  if (!(row.normal_response > 0.0)) {
    row.normal_impulse_n_s = 0.0;
    row.friction_impulse_n_s.setZero();
  }
  const double gap_before = row.gap_m - row.normal.dot(row.displacement_before_m);
  row.least_gap_m = std::min(0.0, gap_before + row.push_m_s * step_s);
}

void apply(const ContactConstraint& row, const Vector3d& impulse_n_s) {
  row.a->apply_impulse(row.anchor_a, row.point_m, impulse_n_s);
  row.b->apply_impulse(row.anchor_b, row.point_m, -impulse_n_s);
}

// Returns the magnitude of the change of the row's impulse.
double solve(ContactConstraint& row) {
  if (!(row.normal_response > 0.0)) return 0.0;
  const Vector3d displacement = relative_displacement(row);
  const double gap = row.gap_m + row.normal.dot(displacement - row.displacement_before_m) - row.least_gap_m;
  const double normal = std::max(0.0, row.normal_impulse_n_s - gap / row.normal_response);
  if (normal == 0.0 && row.normal_impulse_n_s == 0.0) return 0.0;
  const Vector3d slid = displacement - row.normal * row.normal.dot(displacement);
  Vector3d friction = row.friction_impulse_n_s - slid / row.tangent_response;
  const double size = friction.norm(), limit = row.friction * normal;
  if (size > limit) friction *= limit / size;
  const Vector3d change =
      (normal - row.normal_impulse_n_s) * row.normal + friction - row.friction_impulse_n_s;
  row.normal_impulse_n_s = normal;
  row.friction_impulse_n_s = friction;
  apply(row, change);
  return change.norm();
}

}  // namespace

void solve_contacts(std::span<ContactConstraint* const> rows, double step_s) {
  for (ContactConstraint* row : rows) prepare(*row, step_s);
  for (ContactConstraint* row : rows) {
    if (row->normal_impulse_n_s == 0.0) continue;
    apply(*row, row->normal_impulse_n_s * row->normal + row->friction_impulse_n_s);
  }
  // Most rows do not push. Sweeps over those that do alternate with sweeps over all; only the latter can end.
  std::vector<ContactConstraint*> pushing;
  bool of_all = true;
  for (int sweep = 0, since_all = 0; sweep < kMaxIterations; ++sweep) {
    const std::span<ContactConstraint* const> swept =
        of_all ? rows : std::span<ContactConstraint* const>(pushing);
    double changed = 0.0, total = 0.0;
    for (size_t n = 0; n < swept.size(); ++n) {
      ContactConstraint& row = *swept[sweep % 2 ? swept.size() - 1 - n : n];
      changed += solve(row);
      total += row.normal_impulse_n_s;
    }
    const bool converged = changed <= kConvergence * total;
    if (of_all && converged) break;
    if (of_all) {
      pushing.clear();
      for (ContactConstraint* row : rows) {
        if (row->normal_impulse_n_s > 0.0) pushing.push_back(row);
      }
      since_all = 0;
    }
    of_all = (!of_all && converged) || ++since_all > kPushingSweeps || sweep + 2 >= kMaxIterations;
  }
  for (ContactConstraint* row : rows) {
    if (row->normal_impulse_n_s <= 0.0) continue;
    const Vector3d impulse = row->normal_impulse_n_s * row->normal + row->friction_impulse_n_s;
    row->a->record_impulse(row->anchor_a, row->point_m, impulse);
    row->b->record_impulse(row->anchor_b, row->point_m, -impulse);
  }
}

}  // namespace livegs
