// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"

namespace livegs {

// Scene painted for a coverage mask: the target white, everything else black. Rendered with the blending of
// the scene itself, each pixel is the fraction of light from the target. Keeps pointers to the given objects.
class CoverageMaskScene {
 public:
  // `max_kernels` limits the kernels of the target and of all other objects together: if exceeded, every k-th
  // is used, with k times the area.
  CoverageMaskScene(std::span<const DrawnObject> scene, uint32_t target_id,
                    size_t target_kernels = std::numeric_limits<size_t>::max(),
                    size_t other_kernels = std::numeric_limits<size_t>::max());
  CoverageMaskScene(const CoverageMaskScene&) = delete;
  CoverageMaskScene& operator=(const CoverageMaskScene&) = delete;

  std::span<const DrawnObject> target() const { return target_; }  // alone, white
  // Objects that may be visible to the camera, painted, and the same in their own colours.
  std::vector<DrawnObject> seen_by(const Camera& camera) const;
  std::vector<DrawnObject> coloured_seen_by(const Camera& camera) const;

 private:
  struct Member {
    DrawnObject own, painted;
    Eigen::Vector3d centre_m;  // of the bounding sphere
    double radius_m;
  };
  bool sees(const Camera& camera, const Member& member) const;

  std::deque<GaussianAsset> assets_;
  std::deque<PosedKernels> kernels_;
  std::vector<Member> members_;
  std::vector<DrawnObject> target_;
};

}  // namespace livegs
