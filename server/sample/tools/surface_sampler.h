// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "sample/tools/random.h"
#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// A patch P(u, v) over a rectangle of parameters. The normal is dP/du x dP/dv, so the order of the parameters
// selects the side; `tangent` is along dP/du. Poles and creases are allowed.
struct ParametricSurface {
  std::function<Eigen::Vector3d(double u, double v)> position_m;
  double u_min = 0.0, u_max = 1.0, v_min = 0.0, v_max = 1.0;
  double spacing_m = 0.002;  // target distance between neighbours; curvature may reduce it
  double stretch = 1.0;      // factor on the distance of neighbours along dP/du (wood grain, leaf blades)
  int part = 0;
  int cells_u = 64, cells_v = 64;  // grid on which area and curvature are measured
  // Additional refinement, a factor on spacing_m in (0, 1]; empty for none.
  std::function<double(double u, double v)> refinement;
  // Points for which this is false are removed (hidden inside another part); empty keeps all.
  std::function<bool(const Eigen::Vector3d& position_m)> keep;
  // Position in which distances between samples are measured: a stretched surface shortens its long direction
  // by `stretch`. Empty: the position itself.
  std::function<Eigen::Vector3d(double u, double v, const Eigen::Vector3d& position_m)> metric;
};

// Appends an even, irregular covering of the surface: Poisson-disc darts (Cook 1986) over area-weighted
// candidates until almost no space is left, about 0.65 samples per spacing². Where the normal rotates by more
// than a third of a radian within one spacing, the spacing shrinks to a third at most.
void sample_surface(const ParametricSurface& surface, Random& random, SurfaceSamples& samples);

// Zero set of a distance-like function: negative inside, gradient near unit length close to the surface.
struct ImplicitSurface {
  std::function<double(const Eigen::Vector3d& position_m)> distance_m;
  Eigen::Vector3d min_m, max_m;  // a box that contains the surface
  double spacing_m = 0.001;
  // Factor on spacing_m in (0, 1]; empty for none.
  std::function<double(const Eigen::Vector3d& position_m)> refinement;
};

// Appends an even covering as above; u and v are 0, tangents are arbitrary.
void sample_implicit(const ImplicitSurface& surface, Random& random, SurfaceSamples& samples);

}  // namespace livegs::sample
