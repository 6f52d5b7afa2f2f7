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

// A scene painted by who is who: the target white, everything else black, so that a picture of it holds each
// pixel's share of light that comes from the target, by the very blend that draws the scene. Keeps pointers
// to what it was made from.
class CoverageMaskScene {
 public:
  // At most so many kernels of the target and of everything else together: every k-th is taken, k times as
  // wide in area.
  CoverageMaskScene(std::span<const DrawnObject> scene, uint32_t target_id,
                    size_t target_kernels = std::numeric_limits<size_t>::max(),
                    size_t other_kernels = std::numeric_limits<size_t>::max());
  CoverageMaskScene(const CoverageMaskScene&) = delete;
  CoverageMaskScene& operator=(const CoverageMaskScene&) = delete;

  std::span<const DrawnObject> target() const { return target_; }  // alone, white
  // Those that may be seen by the camera, painted, and in their own colours.
  std::vector<DrawnObject> seen_by(const Camera& camera) const;
  std::vector<DrawnObject> coloured_seen_by(const Camera& camera) const;

 private:
  struct Member {
    DrawnObject own, painted;
    Eigen::Vector3d centre_m;  // of the ball around it
    double radius_m;
  };
  bool sees(const Camera& camera, const Member& member) const;

  std::deque<GaussianAsset> assets_;
  std::deque<PosedKernels> kernels_;
  std::vector<Member> members_;
  std::vector<DrawnObject> target_;
};

}  // namespace livegs
