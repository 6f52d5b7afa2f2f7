// SPDX-License-Identifier: Apache-2.0
#include "train/run/scene_extent.h"

#include <algorithm>

#include "core/percentile.h"

namespace livegs {

double robust_extent(const std::vector<CapturedView>& views) {
  std::vector<double> along(views.size());
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < views.size(); ++i) along[i] = views[i].camera.world_from_camera.position_m[axis];
    middle[axis] = median(along);
  }
  for (size_t i = 0; i < views.size(); ++i)
    along[i] = (views[i].camera.world_from_camera.position_m - middle).norm();
  const double usual = median(along);
  double largest = 0;
  for (double distance : along) {
    if (distance <= kFarCamera * usual) largest = std::max(largest, distance);
  }
  return largest > 0 ? 1.1 * largest : 1.0;
}

}  // namespace livegs
