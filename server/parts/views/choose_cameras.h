// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "gaussian/gaussian_asset.h"
#include "splat/camera.h"

namespace livegs {

// Cameras in the free space of a room whose photos are not known. Candidates on rings around dense places are
// scored by the kernels that their rays meet in a coarse grid; the best are taken one after the other, and
// what was seen before counts less. `up` is a unit vector. Deterministic. Empty if there is no free place.
std::vector<Camera> choose_cameras(const GaussianAsset& asset, const Eigen::Vector3d& up, size_t count,
                                   int width);

// The camera with a picture of another width, px, and the same field of view.
Camera with_width(Camera camera, int width);
// The mean up axis of some cameras, unit: photos are mostly taken level.
Eigen::Vector3d mean_up(const std::vector<Camera>& cameras);

// At most `count` of the cameras, evenly taken, scaled to at most `width` pixels.
std::vector<Camera> thin_cameras(const std::vector<Camera>& cameras, size_t count, int width);

}  // namespace livegs
