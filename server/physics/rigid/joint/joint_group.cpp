// SPDX-License-Identifier: GPL-3.0-or-later
// Andersen 1983, RATTLE; Catto 2024, Solver2D (soft step); Cuthill and McKee 1969, reducing the bandwidth of
// sparse symmetric matrices.
#include "physics/rigid/joint/joint_group.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "physics/motion/free_rotation.h"
#include "physics/motion/vector_algebra.h"

namespace livegs {
namespace {

// Fraction of an initial error that is corrected per substep, and speed limits of the correction.
constexpr double kErrorReduction = 0.2;
constexpr double kMaxCorrection_m_s = 3.0;
constexpr double kMaxCorrection_rad_s = 10.0;
constexpr double kMaxCurvature = 0.5;  // of the correction, relative to the path length
// A new measurement is accepted if it differs from the last by at most `converges` times the previous
// difference. The first is compared with the curvature, or with `of_displacement` of the path. Small steps
// use tighter limits.
struct CurvatureLimits {
  double converges, of_displacement;
};
constexpr CurvatureLimits kCurvatureInSubstep{0.7, 0.1}, kCurvatureInSmallStep{0.3, 0.02};
// Larger: longer chains at high tension are resolved, more time.
constexpr int kMaxSmallSteps = 4;
// Sweeps that refine the curvature correction, per phase.
constexpr int kMaxCurvatureIterations = 3;
// Compliance of rows in closed loops, which may be linearly dependent, relative to their own response
// (constraint force mixing, Smith 2006). It equals a spring of 1 / (kLoopSoftness h²) per mass with step h,
// too stiff to be visible. Chains and trees have none.
constexpr double kLoopSoftness = 1e-4;
constexpr double kSameNode_m = 1e-3;  // joints closer than this form a node

// Rotation perpendicular to the axes that takes b to a. Its magnitude is the sine of the angle up to 90
// degrees.
Eigen::Vector3d tilt_of(const Eigen::Vector3d& axis_a, const Eigen::Vector3d& axis_b) {
  const Eigen::Vector3d tilt = axis_b.cross(axis_a);
  if (axis_a.dot(axis_b) >= 0.0) return tilt;
  return tilt.squaredNorm() > 1e-20 ? tilt.normalized() : axis_b.unitOrthogonal();
}

// Correction of an error within a substep.
template <class Vector>
Vector reduced_error(const Vector& error, double substep_s, double fastest) {
  const double size = error.norm();
  return size > 0.0 ? Vector(std::min(kErrorReduction, fastest * substep_s / size) * error) : error;
}

std::pair<const RigidBody*, const RigidBody*> ordered(const RigidBody* one, const RigidBody* two) {
  return std::less<>()(one, two) ? std::pair(one, two) : std::pair(two, one);
}

}  // namespace

JointGroup::JointGroup(std::vector<RigidJoint> joints) : joints_(std::move(joints)) {
  order_joints();
  for (const RigidJoint& joint : joints_) {
    for (RigidBody* body : {joint.a, joint.b}) {
      if (body) bodies_.push_back(body);
    }
  }
  std::ranges::sort(bodies_, {}, &RigidBody::body_id);
  bodies_.erase(std::ranges::unique(bodies_).begin(), bodies_.end());
  ends_.resize(bodies_.size());
  starts_.resize(bodies_.size());
  others_.resize(bodies_.size());
  given_.resize(bodies_.size());
  before_.resize(bodies_.size());
  mass_factors_.resize(bodies_.size());
  const auto index_of = [&](const RigidBody* body) {
    return static_cast<size_t>(std::ranges::find(bodies_, body) - bodies_.begin());
  };

  note_nodes();
  const bool to_world = std::ranges::any_of(joints_, [](const RigidJoint& joint) { return !joint.b; });
  softness_ = joints_.size() + 1 > bodies_.size() + (to_world ? 1 : 0) ? kLoopSoftness : 0.0;

  int row_count = 0;
  for (const RigidJoint& joint : joints_) {
    Rows rows;
    rows.a = index_of(joint.a);
    if (joint.b) rows.b = index_of(joint.b);
    rows.first = row_count;
    row_count += joint.row_count();
    // The envelope of a row starts at the first joint that shares a body.
    int first = rows.first;
    for (const Rows& earlier : rows_) {
      const auto has = [&](std::optional<size_t> body) {
        return body && (body == earlier.a || body == earlier.b);
      };
      if (has(rows.a) || has(rows.b)) {
        first = earlier.first;
        break;
      }
    }
    rows_.push_back(rows);
    begin_.insert(begin_.end(), static_cast<size_t>(joint.row_count()), first);
  }
  envelope_.push_back(0);
  for (int row = 0; row < row_count; ++row) {
    envelope_.push_back(envelope_.back() + static_cast<size_t>(row - begin_[static_cast<size_t>(row)] + 1));
  }
  factor_.resize(envelope_.back());
  inverse_pivot_.resize(static_cast<size_t>(row_count));
  residual_.resize(row_count);
  compliance_.resize(row_count);
}

// Cuthill-McKee ordering: breadth first from a joint with few neighbours, so that a chain has a narrow band.
void JointGroup::order_joints() {
  std::ranges::sort(joints_, {}, &RigidJoint::id);
  const size_t count = joints_.size();
  const auto neighbours = [&](size_t i, size_t j) {
    const auto touches = [&](const RigidBody* body) {
      return body && (body == joints_[j].a || body == joints_[j].b);
    };
    return i != j && (touches(joints_[i].a) || touches(joints_[i].b));
  };
  std::vector<size_t> degree(count, 0);
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = 0; j < count; ++j) degree[i] += neighbours(i, j) ? 1 : 0;
  }
  std::vector<size_t> order;
  std::vector<bool> taken(count, false);
  while (order.size() < count) {
    size_t start = count;
    for (size_t i = 0; i < count; ++i) {
      if (!taken[i] && (start == count || degree[i] < degree[start])) start = i;
    }
    taken[start] = true;
    order.push_back(start);
    for (size_t at = order.size() - 1; at < order.size(); ++at) {
      for (size_t j = 0; j < count; ++j) {
        if (taken[j] || !neighbours(order[at], j)) continue;
        taken[j] = true;
        order.push_back(j);
      }
    }
  }
  std::vector<RigidJoint> ordered;
  for (size_t i : order) ordered.push_back(std::move(joints_[i]));
  joints_ = std::move(ordered);
}

// Bars in a node overlap, although each is joined to only one other.
void JointGroup::note_nodes() {
  const auto note = [&](const RigidBody* one, const RigidBody* two) {
    if (one && two && one != two) joined_pairs_.push_back(ordered(one, two));
  };
  for (size_t i = 0; i < joints_.size(); ++i) {
    const RigidJoint& joint = joints_[i];
    note(joint.a, joint.b);
    for (size_t j = 0; j < i; ++j) {
      if ((joints_[j].world_anchor_a() - joint.world_anchor_a()).norm() > kSameNode_m) continue;
      for (const RigidBody* one : {joint.a, joint.b}) {
        for (const RigidBody* two : {joints_[j].a, joints_[j].b}) note(one, two);
      }
    }
  }
  std::ranges::sort(joined_pairs_);
  joined_pairs_.erase(std::ranges::unique(joined_pairs_).begin(), joined_pairs_.end());
}

bool JointGroup::share_joint(const RigidBody& a, const RigidBody& b) const {
  return std::ranges::binary_search(joined_pairs_, ordered(&a, &b));
}

bool JointGroup::asleep() const { return std::ranges::all_of(bodies_, &RigidBody::asleep); }

void JointGroup::wake_together() {
  if (asleep()) return;
  for (RigidBody* body : bodies_) {
    if (body->asleep) body->wake();
  }
}

void JointGroup::prepare(ContactPhase phase) {
  for (size_t i = 0; i < joints_.size(); ++i) {
    const RigidJoint& joint = joints_[i];
    Rows& rows = rows_[i];
    const Eigen::Vector3d anchor_a = joint.world_anchor_a(), anchor_b = joint.world_anchor_b();
    // Both bodies are pushed at the same point, which conserves angular momentum.
    const Eigen::Vector3d point = joint.b ? Eigen::Vector3d(0.5 * (anchor_a + anchor_b)) : anchor_a;
    rows.arm_a_m = point - joint.a->world_from_body.position_m;
    rows.turn_a.topRows<3>() = -cross_matrix(rows.arm_a_m);
    if (joint.b) {
      rows.arm_b_m = point - joint.b->world_from_body.position_m;
      rows.turn_b.topRows<3>() = -cross_matrix(rows.arm_b_m);
    }
    if (joint.hinge) {
      const Eigen::Vector3d axis_a = joint.world_axis_a(), axis_b = joint.world_axis_b();
      rows.across.col(0) = axis_b.unitOrthogonal();
      rows.across.col(1) = axis_b.cross(rows.across.col(0));
      rows.turn_a.bottomRows<2>() = rows.across.transpose();
      if (joint.b) rows.turn_b.bottomRows<2>() = rows.across.transpose();
      if (phase == ContactPhase::Push) rows.start_tilt = rows.across.transpose() * tilt_of(axis_a, axis_b);
    }
    if (phase == ContactPhase::Push) rows.start_gap_m = anchor_a - anchor_b;
  }
  factorise();
  warm_start(phase);
}

// Assembles J M^-1 J^T and factorises it in place to L D L^T.
void JointGroup::factorise() {
  std::fill(factor_.begin(), factor_.end(), 0.0);
  const auto entry = [&](int row, int column) -> double& {
    const auto r = static_cast<size_t>(row);
    return factor_[envelope_[r] + static_cast<size_t>(column - begin_[r])];
  };
  const auto couple = [&](size_t i, size_t j, size_t body_index, double sign,
                          const Eigen::Matrix<double, 5, 3>& turn_i,
                          const Eigen::Matrix<double, 5, 3>& turn_j) {
    const RigidBody& body = *bodies_[body_index];
    const Eigen::Matrix<double, 5, 5> block = turn_i * body.inverse_inertia * turn_j.transpose();
    const int count_i = joints_[i].row_count(), count_j = joints_[j].row_count();
    for (int r = 0; r < count_i; ++r) {
      const int last = i == j ? r + 1 : count_j;
      for (int c = 0; c < last; ++c) {
        const double direct = r == c && r < 3 ? body.inverse_mass : 0.0;
        entry(rows_[i].first + r, rows_[j].first + c) += sign * (block(r, c) + direct);
      }
    }
  };
  for (size_t i = 0; i < rows_.size(); ++i) {
    const Rows& one = rows_[i];
    for (size_t j = 0; j <= i; ++j) {
      const Rows& two = rows_[j];
      if (two.first < begin_[static_cast<size_t>(one.first)]) continue;
      if (one.a == two.a) couple(i, j, one.a, 1.0, one.turn_a, two.turn_a);
      if (one.b && one.b == two.b) couple(i, j, *one.b, 1.0, one.turn_b, two.turn_b);
      if (one.a == two.b) couple(i, j, one.a, -1.0, one.turn_a, two.turn_b);
      if (one.b && one.b == two.a) couple(i, j, *one.b, -1.0, one.turn_b, two.turn_a);
    }
  }
  const auto row_count = static_cast<int>(inverse_pivot_.size());
  for (int r = 0; r < row_count; ++r) {
    const int begin = begin_[static_cast<size_t>(r)];
    double* const row = &factor_[envelope_[static_cast<size_t>(r)]];
    const double diagonal = row[r - begin];
    compliance_[r] = softness_ * diagonal;
    double pivot = diagonal + compliance_[r];
    for (int c = begin; c < r; ++c) {
      const int begin_c = begin_[static_cast<size_t>(c)];
      const double* const other = &factor_[envelope_[static_cast<size_t>(c)]];
      double sum = row[c - begin];
      for (int k = std::max(begin, begin_c); k < c; ++k) sum -= row[k - begin] * other[k - begin_c];
      row[c - begin] = sum;  // L D until the pivot is known
    }
    for (int c = begin; c < r; ++c) {
      const double scaled = row[c - begin];
      row[c - begin] = scaled * inverse_pivot_[static_cast<size_t>(c)];
      pivot -= scaled * row[c - begin];
    }
    // With a smaller pivot the row is linearly dependent (two hinges on one door).
    inverse_pivot_[static_cast<size_t>(r)] = pivot > 1e-11 * diagonal ? 1.0 / pivot : 0.0;
  }
}

// Solves L D L^T x = rows in place; dependent rows get zero.
void JointGroup::substitute(Eigen::VectorXd& rows) const {
  const auto row_count = static_cast<int>(inverse_pivot_.size());
  const auto for_columns = [&](int r, const auto& visit) {
    const int begin = begin_[static_cast<size_t>(r)];
    const double* const row = &factor_[envelope_[static_cast<size_t>(r)]];
    for (int c = begin; c < r; ++c) visit(c, row[c - begin]);
  };
  for (int r = 0; r < row_count; ++r) {
    for_columns(r, [&](int c, double entry) { rows[r] -= entry * rows[c]; });
  }
  for (int r = 0; r < row_count; ++r) rows[r] *= inverse_pivot_[static_cast<size_t>(r)];
  for (int r = row_count - 1; r >= 0; --r) {
    for_columns(r, [&](int c, double entry) { rows[c] -= entry * rows[r]; });
  }
}

void JointGroup::apply(const RigidJoint& joint, const Rows& rows, const RigidJoint::Impulse& impulse) {
  const auto give = [&](size_t index, double sign, const Eigen::Vector3d& arm_m) {
    const Eigen::Vector3d push = sign * impulse.point_n_s;
    const Eigen::Vector3d turn = arm_m.cross(push) + sign * impulse.turn;
    RigidBody& body = *bodies_[index];
    if (body.asleep) return;
    body.velocity_m_s += body.inverse_mass * push;
    body.apply_angular_impulse(turn);
    given_[index].push_n_s += push;
    given_[index].turn += turn;
  };
  give(rows.a, 1.0, rows.arm_a_m);
  if (joint.b) give(*rows.b, -1.0, rows.arm_b_m);
}

void JointGroup::warm_start(ContactPhase phase) {
  for (size_t i = 0; i < joints_.size(); ++i) {
    RigidJoint::Impulse& impulse = phase == ContactPhase::Push ? joints_[i].push : joints_[i].relax;
    if (joints_[i].hinge) {
      impulse.turn = rows_[i].across * (rows_[i].across.transpose() * impulse.turn).eval();
    }
    apply(joints_[i], rows_[i], impulse);
  }
  if (phase == ContactPhase::Relax) return;
  curvature_converges_ = true;
  curvature_change_.reset();
  for (Rows& rows : rows_) rows.curvature = rows.next_curvature;
}

// The joints' positions at the end of the substep deviate from linear extrapolation because arms rotate. The
// deviation is measured after each sweep and used while measurements converge.
bool JointGroup::measure_curvature(double substep_s) {
  for (size_t i = 0; i < bodies_.size(); ++i) ends_[i] = bodies_[i]->orientation_after(substep_s);
  // For gaps and tilts: largest curvature, largest change, fastest path.
  std::array<double, 2> largest{}, change{}, speed{};
  const auto limited = [&](const auto& displacement, const auto& present, double present_speed) {
    const auto curvature = (displacement / substep_s - present).eval();
    const double most = kMaxCurvature * present_speed, size = curvature.norm();
    return (std::min(1.0, most / std::max(size, 1e-300)) / substep_s * curvature).eval();
  };
  const auto note = [&](size_t kind, const auto& curvature, const auto& last) {
    largest[kind] = std::max(largest[kind], curvature.norm());
    change[kind] = std::max(change[kind], (curvature - last).norm());
  };
  const auto arm_curvature = [&](size_t index, const Eigen::Vector3d& anchor_m) {
    const RigidBody& body = *bodies_[index];
    const Eigen::Vector3d arm = body.world_from_body.orientation * anchor_m;
    const Eigen::Vector3d present = body.angular_velocity_rad_s.cross(arm);
    speed[0] = std::max(speed[0], present.norm());
    return limited(Eigen::Vector3d(ends_[index] * anchor_m - arm), present, present.norm());
  };
  for (size_t i = 0; i < joints_.size(); ++i) {
    const RigidJoint& joint = joints_[i];
    Rows& rows = rows_[i];
    rows.next_curvature.gap_m_s2 = arm_curvature(rows.a, joint.anchor_a_m);
    if (joint.b) rows.next_curvature.gap_m_s2 -= arm_curvature(*rows.b, joint.anchor_b_m);
    note(0, rows.next_curvature.gap_m_s2, rows.curvature.gap_m_s2);
    if (!joint.hinge) continue;
    const Eigen::Vector3d turning = joint.turning_rad_s();
    const double fastest =
        joint.a->angular_velocity_rad_s.norm() + (joint.b ? joint.b->angular_velocity_rad_s.norm() : 0.0);
    const Eigen::Vector3d axis_b = joint.b ? Eigen::Vector3d(ends_[*rows.b] * joint.axis_b) : joint.axis_b;
    const Eigen::Vector2d tilt = rows.across.transpose() * tilt_of(ends_[rows.a] * joint.axis_a, axis_b);
    rows.next_curvature.tilt_rad_s2 =
        limited(Eigen::Vector2d(tilt - rows.start_tilt), (rows.across.transpose() * turning).eval(), fastest);
    speed[1] = std::max(speed[1], fastest);
    note(1, rows.next_curvature.tilt_rad_s2, rows.curvature.tilt_rad_s2);
  }
  if (!curvature_converges_) return false;
  const double least = 1e-9;  // smaller changes, relative to the path, are ignored
  const CurvatureLimits& limits = in_small_steps_ ? kCurvatureInSmallStep : kCurvatureInSubstep;
  for (size_t kind : {0, 1}) {
    const double allowed = curvature_change_ ? limits.converges * (*curvature_change_)[kind]
                                             : std::max(limits.converges * largest[kind],
                                                        limits.of_displacement * speed[kind] / substep_s);
    if (change[kind] > std::max(allowed, least * speed[kind] / substep_s)) curvature_converges_ = false;
  }
  if (!curvature_converges_) return false;
  curvature_change_ = change;
  for (Rows& rows : rows_) rows.curvature = rows.next_curvature;
  return change[0] > least * speed[0] / substep_s || change[1] > least * speed[1] / substep_s;
}

// Mean opening speed of the joints over the substep, minus the wanted one.
void JointGroup::push_residual(double substep_s) {
  for (size_t i = 0; i < joints_.size(); ++i) {
    const RigidJoint& joint = joints_[i];
    Rows& rows = rows_[i];
    Eigen::Vector3d opening =
        joint.a->mean_velocity(substep_s) + joint.a->angular_velocity_rad_s.cross(rows.arm_a_m);
    if (joint.b)
      opening -= joint.b->mean_velocity(substep_s) + joint.b->angular_velocity_rad_s.cross(rows.arm_b_m);
    const Eigen::Vector3d correction_m_s =
        reduced_error(rows.start_gap_m, substep_s, kMaxCorrection_m_s) / substep_s;
    rows.correction_m_s = correction_m_s.norm();
    residual_.segment<3>(rows.first) = -(opening + substep_s * rows.curvature.gap_m_s2 + correction_m_s);
    if (!joint.hinge) continue;
    const Eigen::Vector2d tilt_correction = reduced_error(rows.start_tilt, substep_s, kMaxCorrection_rad_s);
    residual_.segment<2>(rows.first + 3) =
        -(rows.across.transpose() * joint.turning_rad_s() + substep_s * rows.curvature.tilt_rad_s2 +
          tilt_correction / substep_s);
  }
}

void JointGroup::relax_residual() {
  for (size_t i = 0; i < joints_.size(); ++i) {
    const RigidJoint& joint = joints_[i];
    const Rows& rows = rows_[i];
    Eigen::Vector3d opening = joint.a->point_velocity(rows.arm_a_m);
    if (joint.b) opening -= joint.b->point_velocity(rows.arm_b_m);
    residual_.segment<3>(rows.first) = -opening;
    if (joint.hinge)
      residual_.segment<2>(rows.first + 3) = -(rows.across.transpose() * joint.turning_rad_s());
  }
}

void JointGroup::solve(ContactPhase phase, double substep_s) {
  if (phase == ContactPhase::Relax) {
    relax_residual();
    solve_residual(phase);
    for (RigidJoint& joint : joints_) joint.force_n = (joint.load_n_s + joint.relax.point_n_s) / substep_s;
    return;
  }
  for (int sweep = 0; sweep < kMaxCurvatureIterations; ++sweep) {
    push_residual(substep_s);
    solve_residual(phase);
    if (!measure_curvature(substep_s)) break;
  }
  if (!in_small_steps_) limit_push();
}

void JointGroup::begin_impact() {
  for (RigidJoint& joint : joints_) joint.resting = std::exchange(joint.relax, {});
  prepare(ContactPhase::Relax);
}

void JointGroup::solve_impact() {
  relax_residual();
  solve_residual(ContactPhase::Relax);
}

void JointGroup::end_impact(double factor, double remaining_s) {
  for (RigidJoint& joint : joints_) {
    joint.record(factor * joint.relax.point_n_s, ImpulseKind::Impact, remaining_s);
    joint.relax = joint.resting;
  }
}

void JointGroup::solve_residual(ContactPhase phase) {
  for (size_t i = 0; i < joints_.size(); ++i) {
    const Rows& rows = rows_[i];
    const RigidJoint::Impulse& total = phase == ContactPhase::Push ? joints_[i].push : joints_[i].relax;
    residual_.segment<3>(rows.first) -= compliance_.segment<3>(rows.first).cwiseProduct(total.point_n_s);
    if (!joints_[i].hinge) continue;
    residual_.segment<2>(rows.first + 3) -=
        compliance_.segment<2>(rows.first + 3).cwiseProduct(rows.across.transpose() * total.turn);
  }
  substitute(residual_);
  for (size_t i = 0; i < joints_.size(); ++i) {
    const Rows& rows = rows_[i];
    RigidJoint::Impulse change;
    change.point_n_s = residual_.segment<3>(rows.first);
    if (joints_[i].hinge) change.turn = rows.across * residual_.segment<2>(rows.first + 3);
    RigidJoint::Impulse& total = phase == ContactPhase::Push ? joints_[i].push : joints_[i].relax;
    total.point_n_s += change.point_n_s;
    total.turn += change.turn;
    apply(joints_[i], rows, change);
  }
}

// Tension acts on a link as a torsional spring: -[f][r] for each force at its arm. The fastest oscillation
// determines the step, 1 rad of it; above 2 rad it would be unstable.
int JointGroup::small_steps(double substep_s) {
  std::vector<Eigen::Matrix3d> stiffness(bodies_.size(), Eigen::Matrix3d::Zero());
  double turn = 0.0;
  const auto add = [&](size_t body, const Eigen::Vector3d& impulse, const Eigen::Vector3d& arm) {
    stiffness[body] -= cross_matrix(impulse) * cross_matrix(arm);
    const double length = arm.norm();
    if (length > 0.0) turn = std::max(turn, bodies_[body]->angular_velocity_rad_s.cross(arm).norm() / length);
  };
  for (size_t i = 0; i < joints_.size(); ++i) {
    const Eigen::Vector3d impulse = joints_[i].push.point_n_s + joints_[i].relax.point_n_s;
    add(rows_[i].a, impulse, rows_[i].arm_a_m);
    if (joints_[i].b) add(*rows_[i].b, -impulse, rows_[i].arm_b_m);
  }
  double fastest = 0.0;  // (h omega)^2
  for (size_t i = 0; i < bodies_.size(); ++i) {
    mass_factors_[i] = substep_s * (bodies_[i]->inverse_inertia * stiffness[i]).norm();
    fastest = std::max(fastest, mass_factors_[i]);
  }
  const double wanted = std::max(std::sqrt(fastest), turn * substep_s / kMaxTurn_rad);
  const double steps = std::clamp(std::ceil(wanted), 1.0, static_cast<double>(kMaxSmallSteps));
  for (double& swing : mass_factors_) swing = std::max(1.0, swing / (steps * steps));
  return static_cast<int>(steps);
}

void JointGroup::scale_mass(RigidBody& body, double factor) {
  body.mass_kg *= factor;
  body.angular_momentum *= factor;
  body.substep_acceleration_m_s2 /= factor;
  body.update_turning();
}

void JointGroup::reset_impulses() {
  work_j_ = peak_kinetic_j_ = 0.0;
  for (RigidJoint& joint : joints_) {
    joint.push = joint.relax = {};
    joint.force_n.setZero();
  }
  for (Rows& rows : rows_) rows.next_curvature = {};
}

// Links that would still oscillate too fast get a larger mass during the small steps, with unchanged forces:
// in a chain under a load of many times its weight their inertia is negligible. External impulses of the
// substep are distributed over the small steps, each with its own push, move and relax pass.
void JointGroup::move(double substep_s) {
  note_others();
  const int steps = small_steps(substep_s);
  for (RigidJoint& joint : joints_) joint.load_n_s = joint.push.point_n_s;
  if (steps == 1) {
    for (RigidBody* body : bodies_) body->move(substep_s);
  } else {
    move_in_small_steps(substep_s, steps);
  }
  for (size_t i = 0; i < bodies_.size(); ++i) {
    before_[i] = bodies_[i]->motion();
    given_[i] = {};
  }
}

void JointGroup::move_in_small_steps(double substep_s, int steps) {
  const double part = 1.0 / steps;
  std::vector<Impulses> others = others_;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    RigidBody& body = *bodies_[i];
    others[i].push_n_s *= part;
    others[i].turn *= part;
    body.velocity_m_s = starts_[i].velocity_m_s;
    body.apply_angular_impulse(starts_[i].angular_momentum - body.angular_momentum);
    if (mass_factors_[i] > 1.0) scale_mass(body, mass_factors_[i]);
  }
  std::vector<RigidJoint::Impulse> pushes;
  for (RigidJoint& joint : joints_) {
    pushes.push_back(joint.push);
    joint.load_n_s.setZero();
    joint.push = joint.push * part;
    joint.relax = joint.relax * part;
  }
  in_small_steps_ = true;
  const double step_s = part * substep_s;
  std::vector<RigidMotion> starts(bodies_.size());
  for (int step = 0; step < steps; ++step) {
    for (size_t i = 0; i < bodies_.size(); ++i) {
      starts[i] = bodies_[i]->motion();
      bodies_[i]->velocity_m_s += others[i].push_n_s / bodies_[i]->mass_kg;
      bodies_[i]->apply_angular_impulse(others[i].turn);
    }
    prepare(ContactPhase::Push);
    solve(ContactPhase::Push, step_s);
    for (RigidBody* body : bodies_) body->move(step_s);
    prepare(ContactPhase::Relax);
    solve(ContactPhase::Relax, step_s);
    limit_kinetic_energy(starts, others, 0.0);
    for (RigidJoint& joint : joints_) joint.load_n_s += joint.push.point_n_s + joint.relax.point_n_s;
  }
  in_small_steps_ = false;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    if (mass_factors_[i] > 1.0) scale_mass(*bodies_[i], 1.0 / mass_factors_[i]);
  }
  for (size_t i = 0; i < joints_.size(); ++i) {
    joints_[i].push = pushes[i];
    joints_[i].relax = {};
  }
}

std::vector<JointGroup*> joint_groups(std::span<RigidBody* const> bodies) {
  std::vector<JointGroup*> groups;
  for (RigidBody* body : bodies) {
    if (body->joints && body->joints->bodies().front() == body) groups.push_back(body->joints);
  }
  return groups;
}

bool joined(const RigidBody& a, const RigidBody& b) {
  return a.joints && a.joints == b.joints && a.joints->share_joint(a, b);
}

}  // namespace livegs
