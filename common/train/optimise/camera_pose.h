// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/pose.h"
#include "train/render/project_trained.h"

namespace livegs {

// Adam (Kingma and Ba 2015) for the pose of a camera. Its position and its turn are two vectors with one
// second moment each: the mean over the axes, so that a change of axes does not change the step.
struct CameraPose {
  Pose world_from_camera;
  Eigen::Vector3d position_first = Eigen::Vector3d::Zero(), turn_first = Eigen::Vector3d::Zero();
  double position_second = 0, turn_second = 0;
  uint64_t steps = 0;
};

// `position_rate` in scene units and `turn_rate` in radians: about the size of a step.
void step_camera_pose(const CameraGradient& gradient, double position_rate, double turn_rate,
                      CameraPose& pose);

}  // namespace livegs
