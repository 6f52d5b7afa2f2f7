// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/pose.h"
#include "skin/driver_frame.h"
#include "skin/rest_body.h"

namespace livegs {

// Current pose of an object as a scene file states it (Object.pose): of the first body of a rigid object; the
// best fit for one that deforms. `lift_m` as in ObjectDescription.
Pose scene_pose(const RestBody& rest, const ObjectDrivers& drivers, double lift_m);

// Yaw about y, then pitch about x, then roll about z, degrees; and back.
Eigen::Vector3d yaw_pitch_roll_deg(const Eigen::Quaterniond& orientation);
Eigen::Quaterniond orientation_of(const Eigen::Vector3d& yaw_pitch_roll_deg);

}  // namespace livegs
