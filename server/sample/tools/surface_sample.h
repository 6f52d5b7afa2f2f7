// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs::sample {

// A surface point that becomes one kernel. Modelling frame: metres, x right, y up, z towards the viewer
// (right-handed), with the object on the plane y = 0.
struct SurfaceSample {
  Eigen::Vector3d position_m;
  Eigen::Vector3d normal;   // unit, outward
  Eigen::Vector3d tangent;  // unit, perpendicular to the normal: the long axis of a stretched kernel
  double u = 0.0, v = 0.0;  // surface parameters
  double spacing_m = 0.0;   // distance to neighbours across the tangent
  double stretch = 1.0;     // spacing along the tangent relative to the spacing across it
  int part = 0;             // part of the object, numbered by its source file
};

using SurfaceSamples = std::vector<SurfaceSample>;

}  // namespace livegs::sample
