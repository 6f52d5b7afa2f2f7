// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/graph/kernel_tree.h"

#include <algorithm>
#include <numeric>

#include "core/parallel_for.h"

namespace livegs {
namespace {

constexpr int kParallelDepth =
    4;  // levels that are split one after the other; below, subtrees run in parallel

}  // namespace

KernelTree::KernelTree(std::span<const Eigen::Vector3f> points) : order_(points.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  uint32_t levels = 0;
  while ((static_cast<uint64_t>(points.size()) >> levels) > kLeaf) ++levels;
  nodes_.assign((size_t{1} << levels) - 1, {0.0f, 3});
  struct Open {
    uint32_t node, begin, end;
  };
  // The top levels, then their subtrees.
  std::vector<Open> open{{0, 0, static_cast<uint32_t>(points.size())}}, next;
  for (int depth = 0; depth < kParallelDepth; ++depth) {
    next.clear();
    std::vector<Open> split(2 * open.size(), {0, 0, 0});
    parallel_for(open.size(), 1, [&](size_t i, size_t) {
      const auto [node, begin, end] = open[i];
      build(node, begin, end, points, 1);
      const uint32_t middle = begin + (end - begin) / 2;
      split[2 * i] = {2 * node + 1, begin, middle};
      split[2 * i + 1] = {2 * node + 2, middle, end};
    });
    for (const Open& part : split)
      if (part.end - part.begin > 0) next.push_back(part);
    open.swap(next);
  }
  parallel_for(open.size(), 1,
               [&](size_t i, size_t) { build(open[i].node, open[i].begin, open[i].end, points, 64); });
  points_.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) points_[i] = points[order_[i]];
}

void KernelTree::build(uint32_t node, uint32_t begin, uint32_t end, std::span<const Eigen::Vector3f> points,
                       int depth) {
  if (depth == 0 || node >= nodes_.size() || end - begin < 2) return;
  Eigen::Vector3f low = points[order_[begin]], high = low;
  for (uint32_t i = begin + 1; i < end; ++i) {
    low = low.cwiseMin(points[order_[i]]);
    high = high.cwiseMax(points[order_[i]]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](uint32_t a, uint32_t b) {
        return points[a][axis] < points[b][axis] || (points[a][axis] == points[b][axis] && a < b);
      });
  nodes_[node] = {points[order_[middle]][axis], static_cast<uint32_t>(axis)};
  build(2 * node + 1, begin, middle, points, depth - 1);
  build(2 * node + 2, middle, end, points, depth - 1);
}

void KernelTree::nearest(const Eigen::Vector3f& point, size_t count, std::vector<Neighbour>& found,
                         float radius) const {
  found.clear();
  if (order_.empty() || count == 0) return;
  struct Open {
    uint32_t node, begin, end;
    float distance2;  // of the half space
  };
  Open stack[64];
  int top = 0;
  stack[top++] = {0, 0, static_cast<uint32_t>(order_.size()), 0.0f};
  const auto worst = [&] { return found.size() < count ? radius * radius : found.front().distance2; };
  while (top > 0) {
    Open at = stack[--top];
    if (at.distance2 > worst()) continue;
    while (at.node < nodes_.size() && at.end - at.begin >= 2) {
      const Node& node = nodes_[at.node];
      const uint32_t middle = at.begin + (at.end - at.begin) / 2;
      const float d = point[node.axis] - node.split;
      const Open below{2 * at.node + 1, at.begin, middle, 0}, above{2 * at.node + 2, middle, at.end, 0};
      Open far = d < 0 ? above : below;
      far.distance2 = std::max(at.distance2, d * d);
      if (far.distance2 <= worst()) stack[top++] = far;
      const float distance2 = at.distance2;
      at = d < 0 ? below : above;
      at.distance2 = distance2;
    }
    for (uint32_t i = at.begin; i < at.end; ++i) {
      const Neighbour one{(points_[i] - point).squaredNorm(), order_[i]};
      if (found.size() < count) {
        if (one.distance2 > radius * radius) continue;
        found.push_back(one);
        std::push_heap(found.begin(), found.end());
      } else if (one < found.front()) {
        std::pop_heap(found.begin(), found.end());
        found.back() = one;
        std::push_heap(found.begin(), found.end());
      }
    }
  }
  std::sort_heap(found.begin(), found.end());
}

void KernelTree::within(const Eigen::Vector3f& point, float radius, std::vector<uint32_t>& found) const {
  found.clear();
  if (order_.empty()) return;
  struct Open {
    uint32_t node, begin, end;
  };
  std::vector<Open> stack{{0, 0, static_cast<uint32_t>(order_.size())}};
  while (!stack.empty()) {
    const Open at = stack.back();
    stack.pop_back();
    if (at.node >= nodes_.size() || at.end - at.begin < 2) {
      for (uint32_t i = at.begin; i < at.end; ++i)
        if ((points_[i] - point).squaredNorm() <= radius * radius) found.push_back(order_[i]);
      continue;
    }
    const Node& node = nodes_[at.node];
    const uint32_t middle = at.begin + (at.end - at.begin) / 2;
    const float d = point[node.axis] - node.split;
    if (d <= radius) stack.push_back({2 * at.node + 1, at.begin, middle});
    if (d >= -radius) stack.push_back({2 * at.node + 2, middle, at.end});
  }
}

}  // namespace livegs
