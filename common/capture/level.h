// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "capture/capture.h"

namespace livegs {

// Returns the up axis of a place from its photos, a unit vector. Most photos are taken level, so the right
// axes of the pictures are horizontal. The axis that is perpendicular to most of them is vertical. If all
// photos have one direction, the result is the mean up axis of the pictures. The EXIF orientation of photos
// is applied. Precondition: at least one view.
Eigen::Vector3d photo_up(const Capture& capture);

// Turns poses and points about the origin so that `up` becomes y.
void level_capture(Capture& capture, const Eigen::Vector3d& up);

// Median distance between the cameras and the points, in units of the capture; 0 without points.
double median_distance(const Capture& capture);

}  // namespace livegs
