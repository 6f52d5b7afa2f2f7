// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/find/split_things.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/disjoint_sets.h"

namespace livegs {
namespace {

using Eigen::Vector3f;

constexpr float kPatchRadius_voxels = 2.6f;  // of a patch about its seed; smaller ones have noisy normals
constexpr float kPatchTilt = 0.87f;          // cosine of 30 degrees between the normals of a patch
constexpr float kPatchColour = 0.12f;        // distance of the colours of a patch
constexpr float kClearNormal = 0.7f;     // length of the mean normal of a voxel; below, it shows two faces
constexpr float kSameColour = 0.12f;     // of patches that merge at once
constexpr float kConcave = 0.35f;        // (n1 - n2) · d of a concave edge: 20 degrees
constexpr double kConcaveShare = 0.2;    // of the border of two regions that keeps them apart
constexpr double kSmallShare = 0.3;      // size of a part that merges with a neighbour of the same colours
constexpr double kSameColours = 0.5;     // overlap of the colours of such a part and its neighbour
constexpr size_t kMinRegionVoxels = 40;  // smaller ones go to the neighbour with the longest border

struct Patch {
  Vector3f position_m = Vector3f::Zero(), normal = Vector3f::Zero(), rgb = Vector3f::Zero();
  uint32_t voxels = 0;
};

struct PatchEdge {
  uint32_t length = 0;  // pairs of neighbouring voxels
  bool concave = false;
};

struct Border {
  double length = 0, concave = 0;
};

// Patch of each voxel of the thing, by its place in thing.voxels. Voxels without a clear normal join the
// patch of a neighbour.
std::vector<uint32_t> grow_patches(const VoxelSet& voxels, const std::vector<uint32_t>& members,
                                   const std::vector<std::vector<uint32_t>>& neighbours,
                                   std::vector<Patch>& patches) {
  std::vector<uint32_t> patch(members.size(), kNoVoxel), open;
  const float radius_m = kPatchRadius_voxels * static_cast<float>(voxels.edge_m());
  const auto clear = [&](uint32_t m) { return voxels[members[m]].normal_length >= kClearNormal; };
  for (uint32_t seed = 0; seed < members.size(); ++seed) {
    if (patch[seed] != kNoVoxel || !clear(seed)) continue;
    const VoxelSet::Voxel& first = voxels[members[seed]];
    const auto number = static_cast<uint32_t>(patches.size());
    patches.emplace_back();
    patch[seed] = number;
    open.assign(1, seed);
    while (!open.empty()) {
      const uint32_t at = open.back();
      open.pop_back();
      const VoxelSet::Voxel& here = voxels[members[at]];
      Patch& grown = patches[number];
      grown.position_m += here.position_m, grown.normal += here.normal, grown.rgb += here.rgb, ++grown.voxels;
      for (uint32_t next : neighbours[at]) {
        const VoxelSet::Voxel& there = voxels[members[next]];
        if (patch[next] != kNoVoxel || !clear(next) || there.normal.dot(first.normal) < kPatchTilt ||
            (there.rgb - first.rgb).norm() > kPatchColour ||
            (there.position_m - first.position_m).norm() > radius_m)
          continue;
        patch[next] = number;
        open.push_back(next);
      }
    }
  }
  for (Patch& one : patches) {
    one.position_m /= static_cast<float>(one.voxels);
    one.rgb /= static_cast<float>(one.voxels);
    one.normal.normalize();
  }
  // The remaining voxels join the patches, from the patches outwards.
  for (bool changed = true; changed;) {
    changed = false;
    const std::vector<uint32_t> before = patch;
    for (uint32_t m = 0; m < members.size(); ++m) {
      if (before[m] != kNoVoxel) continue;
      float nearest = 1e9f;
      for (uint32_t next : neighbours[m]) {
        if (before[next] == kNoVoxel) continue;
        const float distance = (voxels[members[m]].rgb - patches[before[next]].rgb).norm();
        if (distance < nearest) nearest = distance, patch[m] = before[next], changed = true;
      }
    }
  }
  for (uint32_t& one : patch)
    if (one == kNoVoxel) {  // no clear voxel at all
      one = static_cast<uint32_t>(patches.size());
      patches.emplace_back();
      patches.back().voxels = 1;
    }
  return patch;
}

// Share of the colours of the smaller set that the larger set has too, in a coarse histogram.
double colour_overlap(const std::map<int, double>& small, const std::map<int, double>& large) {
  double overlap = 0, total_small = 0, total_large = 0;
  for (const auto& [cell, count] : small) total_small += count;
  for (const auto& [cell, count] : large) total_large += count;
  for (const auto& [cell, count] : small)
    if (const auto at = large.find(cell); at != large.end())
      overlap += std::min(count / total_small, 4 * at->second / total_large);
  return overlap;
}

std::vector<std::vector<uint32_t>> separate_thing(const VoxelSet& voxels,
                                                  const std::vector<uint32_t>& members) {
  std::map<uint32_t, uint32_t> place;
  for (uint32_t m = 0; m < members.size(); ++m) place[members[m]] = m;
  std::vector<std::vector<uint32_t>> neighbours(members.size());
  for (uint32_t m = 0; m < members.size(); ++m)
    for (const Eigen::Vector3i& step : later_neighbours()) {
      const auto at = place.find(voxels.at(voxels[members[m]].cell + step));
      if (at == place.end()) continue;
      neighbours[m].push_back(at->second);
      neighbours[at->second].push_back(m);
    }
  std::vector<Patch> patches;
  const std::vector<uint32_t> patch = grow_patches(voxels, members, neighbours, patches);
  std::map<std::pair<uint32_t, uint32_t>, PatchEdge> edges;
  for (uint32_t m = 0; m < members.size(); ++m)
    for (uint32_t next : neighbours[m])
      if (patch[m] < patch[next]) ++edges[{patch[m], patch[next]}].length;
  DisjointSets grown(patches.size());
  for (auto& [pair, edge] : edges) {
    const Patch &a = patches[pair.first], &b = patches[pair.second];
    const Vector3f d = (a.position_m - b.position_m).normalized();
    edge.concave = (a.normal - b.normal).dot(d) < -kConcave;
    if (!edge.concave && (a.rgb - b.rgb).norm() < kSameColour) grown.join(pair.first, pair.second);
  }
  // Regions: their sizes, colours and borders.
  std::vector<size_t> size(patches.size(), 0);
  std::vector<std::map<int, double>> colours(patches.size());
  for (uint32_t m = 0; m < members.size(); ++m) {
    const uint32_t region = grown.find(patch[m]);
    ++size[region];
    const Eigen::Vector3i cell = (voxels[members[m]].rgb.cwiseMax(0.0f).cwiseMin(0.999f) * 6).cast<int>();
    colours[region][(cell.x() * 6 + cell.y()) * 6 + cell.z()] += 1;
  }
  std::map<std::pair<uint32_t, uint32_t>, Border> borders;
  for (const auto& [pair, edge] : edges) {
    const uint32_t a = grown.find(pair.first), b = grown.find(pair.second);
    if (a == b) continue;
    Border& border = borders[{std::min(a, b), std::max(a, b)}];
    border.length += edge.length;
    border.concave += edge.concave ? edge.length : 0;
  }
  // Greedy: merges the pair with the highest score until no score is above 0.
  DisjointSets regions(patches.size());
  for (;;) {
    double best_score = 0;
    std::pair<uint32_t, uint32_t> best;
    for (const auto& [pair, border] : borders) {
      const size_t small = std::min(size[pair.first], size[pair.second]),
                   large = std::max(size[pair.first], size[pair.second]);
      const uint32_t lesser = size[pair.first] <= size[pair.second] ? pair.first : pair.second;
      const double concave = border.concave / border.length;
      double score = 0;  // above 0: merge
      if (concave < kConcaveShare)
        score = 2 - concave;
      else if (small < kMinRegionVoxels)
        score = 1 + 1e-6 * border.length;
      else if (static_cast<double>(small) < kSmallShare * static_cast<double>(large) &&
               colour_overlap(colours[lesser], colours[lesser == pair.first ? pair.second : pair.first]) >
                   kSameColours)
        score = 1 - concave / 2;
      if (score > best_score) best_score = score, best = pair;
    }
    if (best_score == 0) break;
    const auto [kept, gone] = best;
    regions.join(kept, gone);
    size[kept] += size[gone];
    for (const auto& [cell, count] : colours[gone]) colours[kept][cell] += count;
    std::map<std::pair<uint32_t, uint32_t>, Border> next;
    for (const auto& [pair, border] : borders) {
      const uint32_t a = pair.first == gone ? kept : pair.first, b = pair.second == gone ? kept : pair.second;
      if (a == b) continue;
      Border& sum = next[{std::min(a, b), std::max(a, b)}];
      sum.length += border.length;
      sum.concave += border.concave;
    }
    borders = std::move(next);
  }
  std::map<uint32_t, std::vector<uint32_t>> parts;
  for (uint32_t m = 0; m < members.size(); ++m)
    parts[regions.find(grown.find(patch[m]))].push_back(members[m]);
  std::vector<std::vector<uint32_t>> out;
  for (auto& [region, part] : parts) out.push_back(std::move(part));
  return out;
}

}  // namespace

void split_things(ThingVoxels& found) {
  std::vector<Thing> things;
  for (const Thing& thing : found.things)
    for (std::vector<uint32_t>& part : separate_thing(found.voxels, thing.voxels)) {
      Thing one = thing;
      one.voxels = std::move(part);
      things.push_back(std::move(one));
    }
  found.things = std::move(things);
}

}  // namespace livegs
