// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/click/kernel_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/parallel_for.h"
#include "parts/graph/kernel_tree.h"

namespace livegs {
namespace {

using Eigen::Vector3f;

constexpr float kTouch = 2.0f;            // deviations of both ellipsoids along their line that touch
constexpr float kTouchGap = 0.9f;         // allowed beyond, in distances of neighbours
constexpr float kColourDeviation = 0.1f;  // of the colours of neighbours on one thing
constexpr float kConcaveWeight = 0.1f;    // factor on an edge across a concave corner
constexpr float kConcaveEdge = 0.35f;     // (n1 - n2) · d of a concave corner

}  // namespace

KernelGraph::KernelGraph(const GaussianAsset& asset, std::span<const uint16_t> label,
                         const Eigen::Vector3d& up)
    : neighbours_(kEdges * asset.size()), weights_(kEdges * asset.size(), 0.0f) {
  std::vector<Vector3f> points;
  std::vector<uint32_t> index;
  std::map<uint16_t, std::pair<Eigen::Vector3d, double>> middle;  // sum of positions, number
  for (uint32_t k = 0; k < asset.size(); ++k) {
    if (label[k] == kNotJoined) continue;
    points.push_back(asset.positions[k]);
    index.push_back(k);
    auto& [sum, count] = middle.try_emplace(label[k], Eigen::Vector3d::Zero(), 0.0).first->second;
    sum += asset.positions[k].cast<double>();
    ++count;
  }
  // Along the shortest axis, out of the part: upwards, or for upright faces away from the middle of the part
  // and into the middle of the room.
  std::vector<Vector3f> normals(asset.size());
  parallel_for(asset.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      std::fill_n(&neighbours_[kEdges * k], kEdges, static_cast<uint32_t>(k));
      const auto part = middle.find(label[k]);
      if (part == middle.end()) continue;
      Eigen::Vector3d out = asset.positions[k].cast<double>() - part->second.first / part->second.second;
      out = (out - up * up.dot(out)).normalized();
      out = (label[k] == 0 ? Eigen::Vector3d(-out) : out) + up;
      Eigen::Index shortest = 0;
      asset.log_scales[k].minCoeff(&shortest);
      normals[k] = asset.rotations[k] * Vector3f::Unit(shortest);
      if (normals[k].dot(out.cast<float>()) < 0) normals[k] = -normals[k];
    }
  });
  const auto deviation = [&](size_t i, const Vector3f& d) {
    return (asset.log_scales[i].array().exp() * (asset.rotations[i].conjugate() * d).array()).matrix().norm();
  };
  const KernelTree tree(points);
  parallel_for(index.size(), 1024, [&](size_t begin, size_t end) {
    std::vector<KernelTree::Neighbour> nearest;
    for (size_t i = begin; i < end; ++i) {
      const uint32_t k = index[i];
      tree.nearest(points[i], kEdges + 1, nearest);
      const float usual2 = nearest[nearest.size() / 2].distance2;
      size_t used = 0;
      for (const auto& n : nearest) {
        const uint32_t other = index[n.index];
        if (other == k || used == kEdges) continue;
        const size_t at = kEdges * k + used++;
        neighbours_[at] = other;
        const float distance = std::sqrt(n.distance2);
        Vector3f d = asset.positions[k] - asset.positions[other];
        if (distance > 0) d /= distance;
        if (distance > kTouch * (deviation(k, d) + deviation(other, d)) + kTouchGap * std::sqrt(usual2))
          continue;
        const float rgb = kShBand0 * (asset.sh_dc[k] - asset.sh_dc[other]).norm();
        float weight = std::exp(-0.5f * n.distance2 / std::max(usual2, 1e-12f) -
                                0.5f * rgb * rgb / (kColourDeviation * kColourDeviation));
        if ((normals[k] - normals[other]).dot(d) < -kConcaveEdge) weight *= kConcaveWeight;
        weights_[at] = weight;
      }
    }
  });
}

}  // namespace livegs
