// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/contact_constraints.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "core/parallel_for.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A pair of bodies is solved when a sweep over its rows, and the other pairs of its bodies since then, change
// their impulses by less than this fraction of those that the more loaded body bears. What a light body lacks
// in a step, it gets in the next ones. Friction that has not converged lets bodies creep and keeps them
// awake.
constexpr double kConvergence = 0.002;
// Sweeps over the pushing rows of a pair after each sweep over all of them. Larger: cheaper sweeps, and rows
// that close in the meantime are found later.
constexpr int kPushingSweeps = 4;
// Maximum number of rounds over the pairs that are not solved. Smaller: friction in heaps creeps; larger:
// more time in steps that do not converge.
constexpr int kMaxRounds = 20;
// Rows in the block of a thread. Smaller: handing over takes longer than the work.
constexpr size_t kRowsOfThread = 128;
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
  NodeSample sample;
  std::array<float, 8> pulls;

  [[gnu::always_inline]] Float4 displacement_m() const {
    Float4 low{}, high{};  // two sums, to break the dependency chain
#pragma GCC unroll 4
    for (int c = 0; c < 4; ++c) {
      low += sample.weights[c] * corrections[sample.nodes[c]];
      high += sample.weights[c + 4] * corrections[sample.nodes[c + 4]];
    }
    return low + high;
  }
  double response() const {  // in any direction, m/(N s)
    float sum = 0.0f;
    for (int c = 0; c < 8; ++c) sum += sample.weights[c] * pulls[c];
    return sum;
  }
  [[gnu::always_inline]] void apply(const Float4& impulse_n_s) const {
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) corrections[sample.nodes[c]] += pulls[c] * impulse_n_s;
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

  // `nodes`: both sides have corrections.
  template <bool nodes>
  [[gnu::always_inline]] Double4 displacement_m() const {
    Double4 sum = base_m;
    if (nodes || a.corrections) {
      sum += __builtin_convertvector(a.displacement_m(), Double4);
    } else {
      sum += wide(row->a->displacement_m(row->anchor_a));
    }
    if (nodes || b.corrections) {
      sum -= __builtin_convertvector(b.displacement_m(), Double4);
    } else {
      sum -= wide(row->b->displacement_m(row->anchor_b));
    }
    return sum;
  }
  template <bool nodes>
  [[gnu::always_inline]] void apply(const Double4& by_n_s) const {
    const Float4 narrow = __builtin_convertvector(by_n_s, Float4);
    if (nodes || a.corrections) {
      a.apply(narrow);
    } else {
      row->a->apply_impulse(row->anchor_a, row->point_m, vector(by_n_s));
    }
    if (nodes || b.corrections) {
      b.apply(-narrow);
    } else {
      row->b->apply_impulse(row->anchor_b, row->point_m, vector(-by_n_s));
    }
  }
};

// Response of a relative to b, m/(N s): along the normal, and the largest one in the tangent plane.
struct RowResponse {
  double normal, tangent;
};

RowResponse response_of(const ContactConstraint& row, const RowNodes& a, const RowNodes& b) {
  // That of nodes is the same in any direction.
  const double of_nodes = (a.corrections ? a.response() : 0.0) + (b.corrections ? b.response() : 0.0);
  if (a.corrections && b.corrections) return {of_nodes, of_nodes};
  Matrix3d response = of_nodes * Matrix3d::Identity();
  if (!a.corrections) response += row.a->response(row.anchor_a);
  if (!b.corrections) response += row.b->response(row.anchor_b);
  const Vector3d tangent = row.normal.unitOrthogonal(), bitangent = row.normal.cross(tangent);
  const double k1 = tangent.dot(response * tangent), k2 = bitangent.dot(response * bitangent);
  // An upper bound of the tangent one.
  return {row.normal.dot(response * row.normal),
          std::max(k1, k2) + std::abs(tangent.dot(response * bitangent))};
}

void prepare(ContactConstraint& row, double step_s, SolvedRow& solved) {
  solved.row = &row;
  const AnchorNodes a = row.a->nodes_of(row.anchor_a), b = row.b->nodes_of(row.anchor_b);
  solved.a = {reinterpret_cast<Float4*>(a.corrections), row.anchor_a.sample, a.pulls};
  solved.b = {reinterpret_cast<Float4*>(b.corrections), row.anchor_b.sample, b.pulls};
  solved.base_m = wide(a.base_m - b.base_m);

  const RowResponse response = response_of(row, solved.a, solved.b);
  const bool moves = response.normal > 0.0;
  solved.proximal = (row.normal_impulse_n_s > 0.0 ? kProximalWeight : 0.0) * response.normal;
  solved.per_normal_response = moves ? 1.0 / (response.normal + solved.proximal) : 0.0;
  solved.per_tangent_response = moves ? 1.0 / response.tangent : 0.0;
  solved.normal = wide(row.normal);
  solved.friction = row.friction;
  solved.impulse_n_s = solved.last_impulse_n_s = moves ? row.normal_impulse_n_s : 0.0;
  const Vector3d friction = row.friction_impulse_n_s - row.normal * row.normal.dot(row.friction_impulse_n_s);
  solved.friction_n_s = wide(moves ? friction : Vector3d::Zero());

  const double before_m = dot(solved.normal, solved.displacement_m<false>());
  const double least_gap_m = std::min(0.0, row.gap_m - before_m + row.max_separation_m_s * step_s);
  solved.gap_m = row.gap_m - before_m - least_gap_m;
}

// Sums over rows.
struct RowChanges {
  double size_n_s = 0.0;    // magnitudes of the changes of their impulses
  double normal_n_s = 0.0;  // changes of their normal impulses
};

template <bool nodes>
void solve(SolvedRow& row, RowChanges& changes) {
  const Double4 displacement = row.displacement_m<nodes>();
  const double along = dot(row.normal, displacement);
  const double open_m = row.gap_m + along + row.proximal * (row.impulse_n_s - row.last_impulse_n_s);
  const double normal = std::max(0.0, row.impulse_n_s - open_m * row.per_normal_response);
  if (row.per_normal_response == 0.0 || (normal == 0.0 && row.impulse_n_s == 0.0)) return;
  const Double4 slid = displacement - along * row.normal;
  Double4 friction = row.friction_n_s - row.per_tangent_response * slid;
  const double square = dot(friction, friction), limit = row.friction * normal;
  if (square > limit * limit) friction *= limit / std::sqrt(square);
  const Double4 change = (normal - row.impulse_n_s) * row.normal + friction - row.friction_n_s;
  changes.normal_n_s += normal - row.impulse_n_s;
  changes.size_n_s += std::sqrt(dot(change, change));
  row.impulse_n_s = normal;
  row.friction_n_s = friction;
  row.apply<nodes>(change);
}

// The rows between two bodies. Pairs of one colour share no body.
struct RowPair {
  uint32_t a, b;  // numbers of the bodies
  uint32_t colour;
  SolvedRow* rows = nullptr;
  size_t row_count = 0;
  bool converged = false;    // the last sweep over all rows changed little
  bool solved = false;       // and so did the other pairs of its bodies since then
  bool backward = false;     // direction of the next sweep
  bool nodes = true;         // all rows have corrections on both sides
  double total_n_s = 0.0;    // sum of the impulses
  double changed_n_s = 0.0;  // sum of their changes in this round
  double seen_n_s = 0.0;     // sum of the changes at its bodies that its last sweeps started from or made

  std::span<SolvedRow> all() const { return {rows, row_count}; }
};

template <bool nodes>
RowChanges sweep(std::span<SolvedRow* const> rows, bool backward) {
  RowChanges changes;
  for (size_t n = 0; n < rows.size(); ++n) solve<nodes>(*rows[backward ? rows.size() - 1 - n : n], changes);
  return changes;
}

// One sweep over all rows of the pair and, unless it is solved, some over those that push. `borne_n_s`: the
// impulses that its bodies bear.
void solve_pair(RowPair& pair, double borne_n_s) {
  std::vector<SolvedRow*> rows;
  rows.reserve(pair.row_count);
  for (SolvedRow& row : pair.all()) rows.push_back(&row);
  for (int k = 0; k <= kPushingSweeps; ++k) {
    const RowChanges changes =
        pair.nodes ? sweep<true>(rows, pair.backward) : sweep<false>(rows, pair.backward);
    pair.backward = !pair.backward;
    pair.total_n_s += changes.normal_n_s;
    pair.changed_n_s += changes.size_n_s;
    const bool converged = changes.size_n_s <= kConvergence * std::max(borne_n_s, pair.total_n_s);
    if (k == 0) {
      pair.converged = converged;
      std::erase_if(rows, [](const SolvedRow* row) { return row->impulse_n_s == 0.0; });
    }
    if (converged) return;
  }
}

// The rows of a step, by pair.
class ContactPairs {
 public:
  ContactPairs(std::span<ContactConstraint* const> constraints, double step_s);

  size_t body_count() const { return bodies_.size(); }
  std::span<RowPair> pairs() { return pairs_; }
  // Calls visit(pair) for the pairs that are not solved, colour after colour. Those of one colour are visited
  // on several threads; the result is that of one after the other.
  void visit_unsolved(const std::function<void(RowPair& pair)>& visit);

 private:
  std::unordered_map<const ContactParticipant*, uint32_t> bodies_;
  std::unique_ptr<SolvedRow[]> rows_;  // those of a pair next to each other
  std::vector<RowPair> pairs_;         // by colour
};

ContactPairs::ContactPairs(std::span<ContactConstraint* const> constraints, double step_s) {
  const auto number_of = [this](const ContactParticipant* body) {
    return bodies_.try_emplace(body, static_cast<uint32_t>(bodies_.size())).first->second;
  };
  std::unordered_map<uint64_t, uint32_t> known;  // pairs, by their bodies
  std::vector<std::vector<bool>> used;           // the colours of each body's pairs
  std::vector<uint32_t> pair_of(constraints.size());
  for (size_t i = 0; i < constraints.size(); ++i) {
    const ContactConstraint& constraint = *constraints[i];
    if (i > 0 && constraint.a == constraints[i - 1]->a && constraint.b == constraints[i - 1]->b) {
      pair_of[i] = pair_of[i - 1];
      ++pairs_[pair_of[i]].row_count;
      continue;
    }
    const uint32_t a = number_of(constraint.a), b = number_of(constraint.b);
    const uint64_t key = uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [found, is_new] = known.try_emplace(key, static_cast<uint32_t>(pairs_.size()));
    pair_of[i] = found->second;
    if (is_new) {
      used.resize(bodies_.size());
      const auto is_used = [&](uint32_t body, size_t colour) {
        return colour < used[body].size() && used[body][colour];
      };
      uint32_t colour = 0;
      while (is_used(a, colour) || is_used(b, colour)) ++colour;
      for (const uint32_t body : {a, b}) {
        if (used[body].size() <= colour) used[body].resize(colour + 1);
        used[body][colour] = true;
      }
      pairs_.push_back({a, b, colour});
    }
    ++pairs_[found->second].row_count;
  }
  std::vector<size_t> next(pairs_.size());  // row of each pair
  std::vector<uint32_t> order(pairs_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](uint32_t i) { return pairs_[i].colour; });
  rows_ = std::make_unique_for_overwrite<SolvedRow[]>(constraints.size());
  size_t begin = 0;
  for (const uint32_t i : order) {
    pairs_[i].rows = &rows_[begin];
    next[i] = begin;
    begin += pairs_[i].row_count;
  }
  std::vector<ContactConstraint*> by_row(constraints.size());
  for (size_t i = 0; i < constraints.size(); ++i) by_row[next[pair_of[i]]++] = constraints[i];
  parallel_for(by_row.size(), kRowsOfThread, [&](size_t first, size_t end) {
    for (size_t i = first; i < end; ++i) prepare(*by_row[i], step_s, rows_[i]);
  });
  std::ranges::stable_sort(pairs_, {}, &RowPair::colour);
}

void ContactPairs::visit_unsolved(const std::function<void(RowPair& pair)>& visit) {
  std::vector<RowPair*> visited;
  for (size_t k = 0, end = 0; k < pairs_.size(); k = end) {
    visited.clear();
    size_t rows = 0;
    for (; end < pairs_.size() && pairs_[end].colour == pairs_[k].colour; ++end) {
      if (pairs_[end].solved) continue;
      visited.push_back(&pairs_[end]);
      rows += pairs_[end].row_count;
    }
    const size_t pairs_of_thread = visited.size() * kRowsOfThread / std::max<size_t>(rows, 1) + 1;
    parallel_for(visited.size(), pairs_of_thread, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) visit(*visited[i]);
    });
  }
}

void record(const SolvedRow& of) {
  ContactConstraint& row = *of.row;
  row.normal_impulse_n_s = of.impulse_n_s;
  row.friction_impulse_n_s = vector(of.friction_n_s);
  if (of.impulse_n_s <= 0.0) return;
  const Vector3d push = row.normal_impulse_n_s * row.normal, impulse = push + row.friction_impulse_n_s;
  if (of.a.corrections) row.a->count_impulse(row.point_m, impulse);
  if (of.b.corrections) row.b->count_impulse(row.point_m, -impulse);
  row.a->record_impulse(row.anchor_a, {row.point_m, impulse, push, row.other_body_id});
  row.b->record_impulse(row.anchor_b, {row.point_m, -impulse, -push, row.body_id});
}

}  // namespace

void solve_contacts(std::span<ContactConstraint* const> constraints, double step_s) {
  ContactPairs contacts(constraints, step_s);
  contacts.visit_unsolved([](RowPair& pair) {
    for (const SolvedRow& row : pair.all()) {
      if (row.impulse_n_s != 0.0) row.apply<false>(row.impulse_n_s * row.normal + row.friction_n_s);
      pair.total_n_s += row.impulse_n_s;
      pair.nodes = pair.nodes && row.a.corrections && row.b.corrections;
    }
  });
  struct Body {
    double borne_n_s = 0.0, changed_n_s = 0.0;  // sums of the impulses of its pairs and of their changes
  };
  std::vector<Body> bodies(contacts.body_count());
  const auto borne_n_s = [&](const RowPair& pair) {
    return std::max(bodies[pair.a].borne_n_s, bodies[pair.b].borne_n_s);
  };
  const auto changed_n_s = [&](const RowPair& pair) {
    return bodies[pair.a].changed_n_s + bodies[pair.b].changed_n_s;
  };
  bool all_solved = contacts.pairs().empty();
  for (int round = 0; round < kMaxRounds && !all_solved; ++round) {
    for (Body& body : bodies) body.borne_n_s = 0.0;
    for (RowPair& pair : contacts.pairs()) {
      for (const uint32_t body : {pair.a, pair.b}) bodies[body].borne_n_s += pair.total_n_s;
      pair.changed_n_s = 0.0;
      if (!pair.solved) pair.seen_n_s = changed_n_s(pair);
    }
    contacts.visit_unsolved([&](RowPair& pair) { solve_pair(pair, borne_n_s(pair)); });
    for (RowPair& pair : contacts.pairs()) {
      for (const uint32_t body : {pair.a, pair.b}) bodies[body].changed_n_s += pair.changed_n_s;
      pair.seen_n_s += 2.0 * pair.changed_n_s;
    }
    all_solved = true;
    for (RowPair& pair : contacts.pairs()) {
      const double disturbed_n_s = changed_n_s(pair) - pair.seen_n_s;
      pair.solved = pair.converged && disturbed_n_s <= kConvergence * borne_n_s(pair);
      all_solved = all_solved && pair.solved;
    }
  }
  for (RowPair& pair : contacts.pairs()) pair.solved = false;
  contacts.visit_unsolved([](RowPair& pair) {
    for (const SolvedRow& row : pair.all()) record(row);
  });
}

}  // namespace livegs
