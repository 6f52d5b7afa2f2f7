// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/click/click_cut.h"

#include <maxflow.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "parts/click/kernel_on_ray.h"
#include "parts/graph/kernel_tree.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr size_t kEdges = 10;               // nearest neighbours of a kernel
constexpr float kTouch = 2.0f;              // deviations of both ellipsoids along their line that touch
constexpr float kColourDeviation = 0.1f;    // of the colours of neighbours on one thing
constexpr float kConcaveWeight = 0.1f;      // factor on an edge across a concave corner
constexpr float kConcaveEdge = 0.35f;       // (n1 - n2) · d of a concave corner
constexpr float kHard = 1e4f;               // of a constraint
constexpr float kOwnPart = 0.6f;            // evidence of a label for the thing, in edges
constexpr float kOtherPart = 1.5f;          // evidence of another label against it
constexpr double kBrush_voxels = 1.5;       // radius of the kernels that a ray fixes
constexpr double kMargin_voxels = 4.0;      // of the region of a cut around the part
constexpr double kRoomReach_voxels = 30.0;  // of the region if the ray hits the room

}  // namespace

struct ClickCut::Graph {
  explicit Graph(std::span<const Vector3f> points) : tree(points) {}
  KernelTree tree;
  std::vector<uint32_t> neighbours;  // kEdges per kernel; own index: none
  std::vector<float> weights;
  std::vector<Vector3f> normals;  // along the shortest axis, towards the side from which it is seen
};

ClickCut::ClickCut(const GaussianAsset& asset, const RoomParts& parts)
    : asset_(asset), parts_(parts), graph_(std::make_unique<Graph>(asset.positions)) {
  Graph& g = *graph_;
  const size_t count = asset.size();
  g.neighbours.resize(kEdges * count);
  g.weights.assign(kEdges * count, 0.0f);
  g.normals.resize(count);
  Vector3d eye = Vector3d::Zero();
  for (const Camera& camera : parts.cameras) eye += camera.world_from_camera.position_m;
  if (!parts.cameras.empty()) eye /= static_cast<double>(parts.cameras.size());
  parallel_for(count, 4096, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      Eigen::Index shortest = 0;
      asset.log_scales[k].minCoeff(&shortest);
      Vector3f normal = asset.rotations[k] * Vector3f::Unit(shortest);
      if (normal.dot(eye.cast<float>() - asset.positions[k]) < 0) normal = -normal;
      g.normals[k] = normal;
    }
  });
  parallel_for(count, 1024, [&](size_t begin, size_t end) {
    std::vector<KernelTree::Neighbour> nearest;
    for (size_t k = begin; k < end; ++k) {
      g.tree.nearest(asset.positions[k], kEdges + 1, nearest);
      const float usual2 = nearest.empty() ? 0.0f : nearest[nearest.size() / 2].distance2;
      const auto deviation = [&](size_t i, const Vector3f& d) {
        return (asset.log_scales[i].array().exp() * (asset.rotations[i].conjugate() * d).array())
            .matrix()
            .norm();
      };
      size_t used = 0;
      for (const auto& n : nearest) {
        if (n.index == k || used == kEdges) continue;
        const size_t at = kEdges * k + used++;
        g.neighbours[at] = n.index;
        const float distance = std::sqrt(n.distance2);
        Vector3f d = asset.positions[k] - asset.positions[n.index];
        if (distance > 0) d /= distance;
        if (distance >
            kTouch * (deviation(k, d) + deviation(n.index, d)) + static_cast<float>(parts.footprint_m))
          continue;
        const float rgb = kShBand0 * (asset.sh_dc[k] - asset.sh_dc[n.index]).norm();
        float weight = std::exp(-0.5f * n.distance2 / std::max(usual2, 1e-12f) -
                                0.5f * rgb * rgb / (kColourDeviation * kColourDeviation));
        if ((g.normals[k] - g.normals[n.index]).dot(d) < -kConcaveEdge) weight *= kConcaveWeight;
        g.weights[at] = weight;
      }
      for (; used < kEdges; ++used) g.neighbours[kEdges * k + used] = static_cast<uint32_t>(k);
    }
  });
}

ClickCut::~ClickCut() = default;

CutThing ClickCut::cut(std::span<const Click> clicks) const {
  CutThing result;
  const auto brush_m = static_cast<float>(kBrush_voxels * parts_.voxel_m);
  // The rays: seeds for and against the thing.
  std::vector<uint32_t> seeds, against, near;
  std::optional<uint32_t> first;
  for (const Click& click : clicks) {
    const auto hit = kernel_on_ray(asset_, click.origin_m, click.direction);
    if (!hit) continue;
    if (click.take && !first) first = hit;
    graph_->tree.within(asset_.positions[*hit], brush_m, near);
    auto& seeded = click.take ? seeds : against;
    seeded.push_back(*hit);
    for (uint32_t k : near)
      if (parts_.label[k] == parts_.label[*hit]) seeded.push_back(k);
  }
  if (!first) return result;
  std::vector<uint8_t> wanted(parts_.parts.size() + 1, 0), unwanted(wanted);
  for (uint32_t k : seeds) wanted[parts_.label[k]] = 1;
  for (uint32_t k : against) unwanted[parts_.label[k]] = 1;
  if (parts_.label[*first] != kRoomLabel) result.part = parts_.label[*first];
  wanted[kRoomLabel] = wanted[kRoomLabel] && !result.part;

  // The region: the parts that rays take and their surroundings, or a ball in the room.
  Eigen::AlignedBox3f box;
  for (uint32_t k : seeds) box.extend(asset_.positions[k]);
  if (!result.part)
    box = Eigen::AlignedBox3f(
        box.min() - Vector3f::Constant(static_cast<float>(kRoomReach_voxels * parts_.voxel_m)),
        box.max() + Vector3f::Constant(static_cast<float>(kRoomReach_voxels * parts_.voxel_m)));
  for (const RoomPart& part : parts_.parts)
    if (wanted[part.label]) box.extend(part.bounds_m.cast<float>());
  const Vector3f margin = Vector3f::Constant(static_cast<float>(kMargin_voxels * parts_.voxel_m));
  const Eigen::AlignedBox3f region(box.min() - margin, box.max() + margin);
  graph_->tree.within(region.center(), 0.5f * region.diagonal().norm(), near);
  std::vector<uint32_t> members;
  for (uint32_t k : near)
    if (region.contains(asset_.positions[k])) members.push_back(k);
  std::sort(members.begin(), members.end());
  result.region_kernels = members.size();
  const auto place = [&](uint32_t k) -> int {
    const auto at = std::lower_bound(members.begin(), members.end(), k);
    return at != members.end() && *at == k ? static_cast<int>(at - members.begin()) : -1;
  };

  maxflow::Graph_FFF graph(static_cast<int>(members.size()), static_cast<int>(kEdges * members.size()));
  graph.add_node(static_cast<int>(members.size()));
  for (size_t m = 0; m < members.size(); ++m) {
    const uint32_t k = members[m];
    const uint16_t label = parts_.label[k];
    // A part with rays for and against it gives no evidence: the rays and the edges decide.
    const float share = std::max(parts_.share[k], 0.3f);
    const bool both = wanted[label] && unwanted[label];
    if (both)
      graph.add_tweights(static_cast<int>(m), 1e-3f, 0);
    else if (wanted[label])
      graph.add_tweights(static_cast<int>(m), kOwnPart * share, 0);
    else
      graph.add_tweights(static_cast<int>(m), 0, kOtherPart * share);
    for (size_t e = 0; e < kEdges; ++e) {
      const float weight = graph_->weights[kEdges * k + e];
      if (weight <= 0) continue;
      if (const int other = place(graph_->neighbours[kEdges * k + e]); other >= 0)
        graph.add_edge(static_cast<int>(m), other, weight, weight);
    }
  }
  for (uint32_t k : seeds)
    if (const int m = place(k); m >= 0) graph.add_tweights(m, kHard, 0);
  for (uint32_t k : against)
    if (const int m = place(k); m >= 0) graph.add_tweights(m, 0, kHard);
  graph.maxflow();
  for (size_t m = 0; m < members.size(); ++m)
    if (graph.what_segment(static_cast<int>(m), maxflow::Graph_FFF::SINK) == maxflow::Graph_FFF::SOURCE)
      result.kernels.push_back(members[m]);
  return result;
}

}  // namespace livegs
