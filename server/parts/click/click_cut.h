// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"

// The kernels that one or several rays take out of a room. Prepared
// once per room, in the background; afterwards any thread may call it.

namespace livegs {

struct Click {
  Eigen::Vector3d origin_m, direction;  // a ray in the frame of the asset; the direction is unit
  bool take = true;                     // false: what it hits does not belong to the thing
};

struct CutThing {
  std::vector<uint32_t> kernels;  // ascending; empty if no ray that takes hits anything
  std::optional<uint16_t> part;   // the part that the first ray hits; none: the room
  size_t region_kernels = 0;      // in whose neighbourhood the cut was made
};

class ClickCut {
 public:
  // Keeps references to both. Builds a k-d tree and a graph that joins each kernel to its nearest neighbours
  // where their ellipsoids touch.
  ClickCut(const GaussianAsset& asset, const RoomParts& parts);
  ~ClickCut();

  // A minimum cut (Boykov and Kolmogorov 2004) around the hit points. The labels of the parts are evidence,
  // the rays are constraints; edges are weak between kernels that are far apart for their surroundings, of
  // other colours, or meet in a concave edge. Deterministic.
  CutThing cut(std::span<const Click> clicks) const;

 private:
  struct Graph;
  const GaussianAsset& asset_;
  const RoomParts& parts_;
  std::unique_ptr<Graph> graph_;
};

}  // namespace livegs
