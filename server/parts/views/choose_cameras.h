// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "gaussian/gaussian_asset.h"
#include "splat/camera.h"

namespace livegs {

// Chooses cameras in the free space of a room without photos. Candidates lie on rings around dense places.
// Their score is the number of kernels that their rays hit in a coarse grid. The best one is chosen
// repeatedly; kernels seen before count less. `up` is a unit vector. Deterministic. Empty if there is no free
// place.
std::vector<Camera> choose_cameras(const GaussianAsset& asset, const Eigen::Vector3d& up, size_t count,
                                   int width);

// The camera with a picture of another width, px, and the same field of view.
Camera with_width(Camera camera, int width);
// The mean up axis of some cameras, unit: photos are mostly taken level.
Eigen::Vector3d mean_up(const std::vector<Camera>& cameras);

// At most `count` of the cameras, evenly taken, scaled to at most `width` pixels.
std::vector<Camera> thin_cameras(const std::vector<Camera>& cameras, size_t count, int width);

}  // namespace livegs
