// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "capture/capture.h"

namespace livegs {

// The up axis of a place from its photos, unit: people hold cameras level, so that the right axes of the
// pictures are horizontal, and the axis that is perpendicular to most of them is vertical. If the photos look
// in one direction only, the mean up axis of the pictures. Photos that were taken upright and are stored
// lying (EXIF) count as they were taken. Precondition: at least one view.
Eigen::Vector3d photo_up(const Capture& capture);

// Turns poses and points about the origin so that `up` becomes y.
void level_capture(Capture& capture, const Eigen::Vector3d& up);

// Median distance between the cameras and the points, in units of the capture; 0 without points.
double median_distance(const Capture& capture);

}  // namespace livegs
