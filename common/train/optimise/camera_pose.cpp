// SPDX-License-Identifier: Apache-2.0
#include "train/optimise/camera_pose.h"

#include <Eigen/Geometry>
#include <cmath>

#include "train/optimise/adam.h"

namespace livegs {
namespace {

// Updates the moments and returns the step for a rate of 1.
Eigen::Vector3d adam_vector(const Eigen::Vector3d& gradient, uint64_t steps, Eigen::Vector3d& first,
                            double& second) {
  first = kAdamBeta1 * first + (1 - kAdamBeta1) * gradient;
  second = kAdamBeta2 * second + (1 - kAdamBeta2) * gradient.squaredNorm() / 3;
  if (!(second > 0)) return Eigen::Vector3d::Zero();
  const auto t = static_cast<double>(steps);
  const Eigen::Vector3d mean = first / (1 - std::pow(kAdamBeta1, t));
  return -mean / std::sqrt(second / (1 - std::pow(kAdamBeta2, t)));
}

}  // namespace

void step_camera_pose(const CameraGradient& gradient, double position_rate, double turn_rate,
                      CameraPose& pose) {
  ++pose.steps;
  pose.world_from_camera.position_m +=
      position_rate * adam_vector(gradient.position, pose.steps, pose.position_first, pose.position_second);
  const Eigen::Vector3d turn =
      turn_rate * adam_vector(gradient.turn, pose.steps, pose.turn_first, pose.turn_second);
  if (const double angle = turn.norm(); angle > 0) {
    pose.world_from_camera.orientation =
        (Eigen::AngleAxisd(angle, turn / angle) * pose.world_from_camera.orientation).normalized();
  }
}

}  // namespace livegs
