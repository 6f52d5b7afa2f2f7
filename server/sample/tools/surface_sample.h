// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs::sample {

// One point of a surface that will become one kernel. Modelling frame: metres, x right, y up, z towards the
// viewer (right-handed), the object standing on the plane y = 0.
struct SurfaceSample {
  Eigen::Vector3d position_m;
  Eigen::Vector3d normal;   // unit, outward
  Eigen::Vector3d tangent;  // unit, perpendicular to the normal: the long axis of a stretched kernel
  double u = 0.0, v = 0.0;  // where on its surface, in that surface's own parameters
  double spacing_m = 0.0;   // distance to its neighbours across the tangent
  double stretch = 1.0;     // spacing along the tangent over spacing across it
  int part = 0;             // which piece of the object, as its author numbered them
};

using SurfaceSamples = std::vector<SurfaceSample>;

}  // namespace livegs::sample
