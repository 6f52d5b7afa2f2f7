// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/click/click_cut.h"

#include <maxflow.h>

#include <algorithm>

namespace livegs {
namespace {

constexpr float kHard = 1e4f;       // of a constraint
constexpr float kOwnPart = 0.6f;    // evidence of a label for the thing, in edges
constexpr float kOtherPart = 1.5f;  // evidence of another label against it
constexpr int kBrushSteps = 3;      // edges from a clicked kernel to those that it fixes
constexpr int kBorderSteps = 4;     // edges from a border of labels to the last nodes
// Evidence of a divided part for the thing, in the weight of the edges around the clicks that take away. At 1
// they separate nothing but their surroundings; at 0 a click at the rim divides the part anywhere.
constexpr float kDividedEvidence = 0.8f;

// Kernels of a divided part of more than this number are joined to nodes of up to eleven along strong edges.
constexpr size_t kMaxSingleNodes = 4000;
constexpr float kJoinedEdge = 0.3f;

// A kernel of a divided part speaks against the thing if it is nearer than this to a click that takes away,
// in the distance to one that takes.
constexpr float kAwayReach = 0.5f;
constexpr uint32_t kUnreached = 1u << 24;  // steps to a kernel that no click reaches

enum Role : uint8_t { kNone, kWanted, kDivided };

// The kernel and those within some edges of it, nearest first; only of its label if `same`.
std::vector<uint32_t> around(const KernelGraph& graph, std::span<const uint16_t> label, uint32_t kernel,
                             int steps, bool same) {
  std::vector<uint32_t> found{kernel};
  size_t begin = 0;
  for (int step = 0; step < steps; ++step) {
    const size_t end = found.size();
    for (; begin < end; ++begin) {
      const auto neighbours = graph.neighbours(found[begin]);
      const auto weights = graph.weights(found[begin]);
      for (size_t e = 0; e < KernelGraph::kEdges; ++e)
        if (weights[e] > 0 && (!same || label[neighbours[e]] == label[kernel]) &&
            std::find(found.begin(), found.end(), neighbours[e]) == found.end())
          found.push_back(neighbours[e]);
    }
  }
  return found;
}

float weight_around(const KernelGraph& graph, const std::vector<uint32_t>& brush) {
  float sum = 0;
  for (const uint32_t k : brush) {
    const auto neighbours = graph.neighbours(k);
    for (size_t e = 0; e < KernelGraph::kEdges; ++e)
      if (std::find(brush.begin(), brush.end(), neighbours[e]) == brush.end()) sum += graph.weights(k)[e];
  }
  return sum;
}

// Number of edges to the nearest click of a kind, within the divided part of the click. Edges of no weight
// count: a patch of another colour is not another thing.
std::vector<uint32_t> steps_from(const KernelGraph& graph, std::span<const uint16_t> label,
                                 std::span<const Role> role, std::span<const Click> clicks, bool take) {
  std::vector<uint32_t> steps(label.size(), kUnreached);
  std::vector<uint32_t> reached;
  for (const Click& click : clicks)
    if (click.take == take && role[label[click.kernel]] == kDivided) {
      steps[click.kernel] = 0;
      reached.push_back(click.kernel);
    }
  for (size_t i = 0; i < reached.size(); ++i)
    for (const uint32_t other : graph.neighbours(reached[i]))
      if (steps[other] == kUnreached && label[other] == label[reached[i]]) {
        steps[other] = steps[reached[i]] + 1;
        reached.push_back(other);
      }
  return steps;
}

}  // namespace

CutThing cut_thing(const KernelGraph& graph, std::span<const uint16_t> label, std::span<const Click> clicks) {
  CutThing result;
  uint16_t most = 0;
  for (const uint16_t one : label) most = std::max(most, one);
  std::vector<Role> role(most + size_t{1}, kNone);
  std::vector<uint32_t> corrected;  // kernels whose label is ignored
  for (const Click& click : clicks) {
    const uint16_t own_label = label[click.kernel];
    if (!click.take || (own_label != 0 && role[own_label] == kWanted)) continue;
    const std::vector<uint32_t> near = around(graph, label, click.kernel, kBorderSteps, false);
    if (std::any_of(near.begin(), near.end(), [&](uint32_t k) { return role[label[k]] == kWanted; }))
      corrected.insert(corrected.end(), near.begin(), near.end());
    else if (own_label != 0)
      role[own_label] = kWanted;
  }
  for (const Click& click : clicks)
    if (!click.take && role[label[click.kernel]] == kWanted) role[label[click.kernel]] = kDivided;
  const auto role_of = [&](uint32_t k) { return role[label[k]]; };

  std::vector<uint32_t> own;  // kernels of wanted and divided parts
  std::vector<size_t> kernel_count(role.size(), 0);
  for (uint32_t k = 0; k < label.size(); ++k) {
    if (role_of(k) == kNone) continue;
    own.push_back(k);
    ++kernel_count[label[k]];
  }
  if (own.empty()) return result;
  std::vector<uint8_t> open(label.size(), 0);
  for (const uint32_t k : corrected) open[k] = role_of(k) == kNone;
  std::vector<uint32_t> members;  // kernels with a node
  std::vector<int32_t> node(label.size(), -1);
  int32_t node_count = 0;
  const auto add_node = [&](uint32_t k) {
    if (node[k] >= 0) return;
    node[k] = node_count++;
    members.push_back(k);
  };
  for (const uint32_t k : own) {
    if (role_of(k) == kDivided && node[k] < 0) {
      add_node(k);
      if (kernel_count[label[k]] > kMaxSingleNodes)
        for (size_t e = 0; e < KernelGraph::kEdges; ++e) {
          const uint32_t other = graph.neighbours(k)[e];
          if (node[other] >= 0 || label[other] != label[k] || graph.weights(k)[e] < kJoinedEdge) continue;
          node[other] = node[k];
          members.push_back(other);
        }
    }
    for (const uint32_t other : graph.neighbours(k))
      if (role_of(other) != role_of(k)) add_node(k), add_node(other);
  }
  for (const uint32_t k : corrected) add_node(k);
  for (size_t step = 0, begin = 0; step < kBorderSteps; ++step) {
    const size_t end = members.size();
    for (; begin < end; ++begin)
      for (const uint32_t other : graph.neighbours(members[begin])) add_node(other);
  }
  const std::vector<uint32_t> to_take = steps_from(graph, label, role, clicks, true),
                              to_away = steps_from(graph, label, role, clicks, false);
  std::vector<float> evidence(role.size(), 0.0f);  // of a divided part, for each of its kernels
  std::vector<int> fixed(static_cast<size_t>(node_count), 0);
  for (const Click& click : clicks) {
    // Kernels of the room may be wide, and a correction is next to kernels of another label.
    const bool correction = click.take && role_of(click.kernel) == kNone;
    const std::vector<uint32_t> brush =
        around(graph, label, click.kernel, correction ? 0 : kBrushSteps, true);
    if (!click.take)
      evidence[label[click.kernel]] +=
          kDividedEvidence * weight_around(graph, brush) /
          static_cast<float>(std::max<size_t>(kernel_count[label[click.kernel]], 1));
    for (const uint32_t k : brush)
      if (node[k] >= 0) fixed[static_cast<size_t>(node[k])] += click.take ? 1 : -1;
  }

  result.nodes = static_cast<size_t>(node_count);
  maxflow::Graph_FFF flow(node_count, static_cast<int>(members.size() * KernelGraph::kEdges));
  flow.add_node(node_count);
  for (const uint32_t k : members) {
    const Role own_role = role_of(k);
    float source = own_role == kWanted ? kOwnPart : 0.0f;
    float sink = own_role == kNone && !open[k] ? kOtherPart : 0.0f;
    if (own_role == kDivided)
      (static_cast<float>(to_away[k]) < kAwayReach * static_cast<float>(to_take[k]) ? sink : source) +=
          evidence[label[k]];
    const auto neighbours = graph.neighbours(k);
    const auto weights = graph.weights(k);
    for (size_t e = 0; e < KernelGraph::kEdges; ++e) {
      const int32_t other = node[neighbours[e]];
      if (weights[e] <= 0 || other == node[k]) continue;
      if (other >= 0)
        flow.add_edge(node[k], other, weights[e], weights[e]);
      else
        (role_of(neighbours[e]) == kWanted ? source : sink) += weights[e];
    }
    flow.add_tweights(node[k], source, sink);
  }
  for (int n = 0; n < node_count; ++n)
    if (const int votes = fixed[static_cast<size_t>(n)])
      flow.add_tweights(n, votes > 0 ? kHard : 0, votes < 0 ? kHard : 0);
  flow.maxflow();
  for (const uint32_t k : own)
    if (node[k] < 0) result.kernels.push_back(k);
  for (const uint32_t k : members)
    if (flow.what_segment(node[k], maxflow::Graph_FFF::SINK) == maxflow::Graph_FFF::SOURCE)
      result.kernels.push_back(k);
  std::sort(result.kernels.begin(), result.kernels.end());
  return result;
}

}  // namespace livegs
