// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "gaussian/gaussian_asset.h"
#include "sample/tools/profile.h"
#include "sample/tools/surface_sampler.h"

// Building blocks for the objects of the sample scene. Modelling frame: y up, z towards the viewer.

namespace livegs::sample {

// A surface of revolution about y. u is the angle from +z towards +x, v the position on the profile. The
// outside is to the right of the profile's direction, with the radius to the right and height up. A profile
// that runs up the outside and down the inside of a vessel faces air everywhere.
ParametricSurface lathe(Profile profile, double spacing_m, int part);

// A tube of elliptical section along a curve. u is the curve's parameter (0..1), v the angle around it.
// `reference` must never be parallel to the curve; the first half-axis is in its direction, the second
// perpendicular to both. Half-axes in metres.
ParametricSurface sweep(std::function<Eigen::Vector3d(double u)> curve, const Eigen::Vector3d& reference,
                        std::function<Eigen::Vector2d(double u)> half_axes_m, double spacing_m, int part);

// A smooth curve through points, with u in 0..1 divided equally among the spans (uniform Catmull-Rom).
std::function<Eigen::Vector3d(double u)> curve_through(std::vector<Eigen::Vector3d> points_m);

// Shifts an asset so that its lowest kernel centre is at y = 0 and its bounding box is centred at x = z = 0.
void stand_at_origin(GaussianAsset& asset);

}  // namespace livegs::sample
