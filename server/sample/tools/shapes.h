// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "gaussian/gaussian_asset.h"
#include "sample/tools/profile.h"
#include "sample/tools/surface_sampler.h"

// The few ways in which the objects of the sample scene are formed. Modelling frame: y up, z towards the
// viewer.

namespace livegs::sample {

// Surface of revolution about y. u is the angle from +z towards +x, v the place on the profile; outward is to
// the right of the profile's direction seen with the radius to the right and height up (a profile that runs
// up the outside and down the inside of a vessel faces air everywhere).
ParametricSurface lathe(Profile profile, double spacing_m, int part);

// A tube of elliptical section along a curve. u is the curve's parameter (0..1), v the angle about it.
// `reference` is never along the curve; the first half-axis lies in its direction, the second across both.
// Half-axes in metres.
ParametricSurface sweep(std::function<Eigen::Vector3d(double u)> curve, const Eigen::Vector3d& reference,
                        std::function<Eigen::Vector2d(double u)> half_axes_m, double spacing_m, int part);

// Smooth curve through points, u in 0..1 in equal shares a span (uniform Catmull-Rom).
std::function<Eigen::Vector3d(double u)> curve_through(std::vector<Eigen::Vector3d> points_m);

// Shifts an asset so that its lowest kernel centre is at y = 0 and its box is centred at x = z = 0.
void stand_at_origin(GaussianAsset& asset);

}  // namespace livegs::sample
