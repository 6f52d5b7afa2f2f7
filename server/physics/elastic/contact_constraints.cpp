// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/contact_constraints.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "core/parallel_for.h"

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
// Weight of the change of the impulse of a row that pushed in the last step, relative to its response
// (proximal point iteration, Rockafellar 1976). Rows that share nodes leave parts of their impulses
// undetermined, which sweeps alone settle slowly. Constant loads are met exactly. 0: twice the sweeps; above
// 1: contact oscillates.
constexpr double kProximalWeight = 0.3;

using Float4 = float __attribute__((vector_size(16)));    // x, y, z, unused
using Double4 = double __attribute__((vector_size(32)));  // x, y, z, 0

Double4 wide(const Vector3d& v) { return {v.x(), v.y(), v.z(), 0.0}; }
Vector3d vector(const Double4& v) { return {v[0], v[1], v[2]}; }
double dot(const Double4& a, const Double4& b) {
  const Double4 product = a * b;
  return product[0] + product[1] + product[2];
}

// The nodes of one side. Without corrections the participant computes displacements and applies impulses.
struct RowNodes {
  Float4* corrections = nullptr;
  uint32_t nodes[8];
  float weights[8], pulls[8];

  Float4 displacement_m() const {
    Float4 low{}, high{};  // two sums, to break the dependency chain
#pragma GCC unroll 4
    for (int c = 0; c < 4; ++c) {
      low += weights[c] * corrections[nodes[c]];
      high += weights[c + 4] * corrections[nodes[c + 4]];
    }
    return low + high;
  }
  double response() const {  // in any direction, m/(N s)
    float sum = 0.0f;
    for (int c = 0; c < 8; ++c) sum += weights[c] * pulls[c];
    return sum;
  }
  void apply(const Float4& impulse_n_s) const {
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) corrections[nodes[c]] += pulls[c] * impulse_n_s;
  }
};

// The data of a row that sweeps read, in one place.
struct SolvedRow {
  Double4 normal, friction_n_s;
  Double4 base_m;                                    // displacement of a relative to b without corrections
  double gap_m;                                      // to least_gap_m, without displacement
  double per_normal_response, per_tangent_response;  // N s/m; 0: the row gives no impulse
  double proximal;                                   // kProximalWeight times the response, m/(N s)
  double friction, impulse_n_s, last_impulse_n_s;
  RowNodes a, b;
  ContactConstraint* row;

  Double4 displacement_m() const {
    Double4 sum = base_m;
    if (a.corrections) {
      sum += __builtin_convertvector(a.displacement_m(), Double4);
    } else {
      sum += wide(row->a->displacement_m(row->anchor_a));
    }
    if (b.corrections) {
      sum -= __builtin_convertvector(b.displacement_m(), Double4);
    } else {
      sum -= wide(row->b->displacement_m(row->anchor_b));
    }
    return sum;
  }
  void apply(const Double4& by_n_s) const {
    const Float4 narrow = __builtin_convertvector(by_n_s, Float4);
    if (a.corrections) {
      a.apply(narrow);
    } else {
      row->a->apply_impulse(row->anchor_a, row->point_m, vector(by_n_s));
    }
    if (b.corrections) {
      b.apply(-narrow);
    } else {
      row->b->apply_impulse(row->anchor_b, row->point_m, vector(-by_n_s));
    }
  }
};

RowNodes row_nodes(const AnchorNodes& view, const NodeSample& sample) {
  RowNodes nodes;
  nodes.corrections = reinterpret_cast<Float4*>(view.corrections);
  std::copy(std::begin(sample.nodes), std::end(sample.nodes), nodes.nodes);
  std::copy(std::begin(sample.weights), std::end(sample.weights), nodes.weights);
  std::copy(std::begin(view.pulls), std::end(view.pulls), nodes.pulls);
  return nodes;
}

// Displacement of a relative to b per unit impulse, m/(N s).
Matrix3d response_of(const ContactConstraint& row, const RowNodes& a, const RowNodes& b) {
  const auto of = [](const RowNodes& nodes, const ContactParticipant& participant,
                     const ContactAnchor& anchor) {
    if (!nodes.corrections) return participant.response(anchor);
    return Matrix3d(nodes.response() * Matrix3d::Identity());
  };
  return of(a, *row.a, row.anchor_a) + of(b, *row.b, row.anchor_b);
}

SolvedRow prepare(ContactConstraint& row, double step_s) {
  SolvedRow solved;
  solved.row = &row;
  const AnchorNodes a = row.a->nodes_of(row.anchor_a), b = row.b->nodes_of(row.anchor_b);
  solved.a = row_nodes(a, row.anchor_a.sample);
  solved.b = row_nodes(b, row.anchor_b.sample);
  solved.base_m = wide(a.base_m - b.base_m);

  const Matrix3d response = response_of(row, solved.a, solved.b);
  const double normal_response = row.normal.dot(response * row.normal);
  // Upper bound of the response in any direction of the tangent plane.
  const Vector3d tangent = row.normal.unitOrthogonal(), bitangent = row.normal.cross(tangent);
  const double k1 = tangent.dot(response * tangent), k2 = bitangent.dot(response * bitangent);
  const double tangent_response = std::max(k1, k2) + std::abs(tangent.dot(response * bitangent));
  const bool moves = normal_response > 0.0;
  solved.proximal = (row.normal_impulse_n_s > 0.0 ? kProximalWeight : 0.0) * normal_response;
  solved.per_normal_response = moves ? 1.0 / (normal_response + solved.proximal) : 0.0;
  solved.per_tangent_response = moves ? 1.0 / tangent_response : 0.0;
  solved.normal = wide(row.normal);
  solved.friction = row.friction;
  solved.impulse_n_s = solved.last_impulse_n_s = moves ? row.normal_impulse_n_s : 0.0;
  const Vector3d friction = row.friction_impulse_n_s - row.normal * row.normal.dot(row.friction_impulse_n_s);
  solved.friction_n_s = wide(moves ? friction : Vector3d::Zero());

  const double before_m = dot(solved.normal, solved.displacement_m());
  const double least_gap_m = std::min(0.0, row.gap_m - before_m + row.push_m_s * step_s);
  solved.gap_m = row.gap_m - before_m - least_gap_m;
  return solved;
}

// Returns the magnitude of the change of the row's impulse.
double solve(SolvedRow& row) {
  const Double4 displacement = row.displacement_m();
  const double along = dot(row.normal, displacement);
  const double open_m = row.gap_m + along + row.proximal * (row.impulse_n_s - row.last_impulse_n_s);
  const double normal = std::max(0.0, row.impulse_n_s - open_m * row.per_normal_response);
  if (row.per_normal_response == 0.0 || (normal == 0.0 && row.impulse_n_s == 0.0)) return 0.0;
  const Double4 slid = displacement - along * row.normal;
  Double4 friction = row.friction_n_s - row.per_tangent_response * slid;
  const double square = dot(friction, friction), limit = row.friction * normal;
  if (square > limit * limit) friction *= limit / std::sqrt(square);
  const Double4 change = (normal - row.impulse_n_s) * row.normal + friction - row.friction_n_s;
  row.impulse_n_s = normal;
  row.friction_n_s = friction;
  row.apply(change);
  return std::sqrt(dot(change, change));
}

}  // namespace

void solve_contacts(std::span<ContactConstraint* const> constraints, double step_s) {
  std::vector<SolvedRow> all(constraints.size());
  parallel_for(all.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) all[i] = prepare(*constraints[i], step_s);
  });
  for (const SolvedRow& row : all) {
    if (row.impulse_n_s != 0.0) row.apply(row.impulse_n_s * row.normal + row.friction_n_s);
  }
  // Most rows do not push. Sweeps over those that do alternate with sweeps over all; only the latter can end.
  std::vector<SolvedRow*> rows, pushing;
  for (SolvedRow& row : all) rows.push_back(&row);
  bool of_all = true;
  for (int sweep = 0, since_all = 0; sweep < kMaxIterations; ++sweep) {
    const std::vector<SolvedRow*>& swept = of_all ? rows : pushing;
    double changed = 0.0, total = 0.0;
    for (size_t n = 0; n < swept.size(); ++n) {
      SolvedRow& row = *swept[sweep % 2 ? swept.size() - 1 - n : n];
      changed += solve(row);
      total += row.impulse_n_s;
    }
    const bool converged = changed <= kConvergence * total;
    if (of_all && converged) break;
    if (of_all) {
      pushing.clear();
      for (SolvedRow* row : rows) {
        if (row->impulse_n_s > 0.0) pushing.push_back(row);
      }
      since_all = 0;
    }
    of_all = (!of_all && converged) || ++since_all > kPushingSweeps || sweep + 2 >= kMaxIterations;
  }
  for (const SolvedRow& of : all) {
    ContactConstraint& row = *of.row;
    row.normal_impulse_n_s = of.impulse_n_s;
    row.friction_impulse_n_s = vector(of.friction_n_s);
    if (of.impulse_n_s <= 0.0) continue;
    const Vector3d push = row.normal_impulse_n_s * row.normal, impulse = push + row.friction_impulse_n_s;
    if (of.a.corrections) row.a->count_impulse(row.point_m, impulse);
    if (of.b.corrections) row.b->count_impulse(row.point_m, -impulse);
    row.a->record_impulse(row.anchor_a, {row.point_m, impulse, push, row.other_body_id});
    row.b->record_impulse(row.anchor_b, {row.point_m, -impulse, -push, row.body_id});
  }
}

}  // namespace livegs
