// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "gaussian/gaussian_asset.h"
#include "sample/tools/occlusion_grid.h"
#include "sample/tools/random.h"
#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// Material of a surface point. Colours are linear light.
struct Appearance {
  Eigen::Vector3d albedo{0.5, 0.5, 0.5};
  Eigen::Vector3d back_albedo{0.5, 0.5, 0.5};  // of a leaf's other side; used if two_sided
  bool two_sided = false;
  double translucency = 0.0;            // fraction of the light from behind that a leaf transmits
  double gloss = 0.0;                   // height of the highlight, display units
  double gloss_width = 0.25;            // roughness: 0.05 polished glaze, 0.5 satin
  Eigen::Vector3d subsurface{0, 0, 0};  // subsurface scattering that fills the shadows, linear light
  double sheen = 0.0;  // brightening of a clear coat at grazing angles, display units; needs degree 2
  double opacity = 0.96;
  double flatness = 0.15;  // thickness relative to the tangential size
  double overlap = 0.78;   // standard deviation relative to the spacing: 0.6 crisp, 0.9 closed
  // Elongation of a thread or fibre: longer along the tangent and thinner across, at constant area.
  double elongation = 1.0;
  bool across = false;            // the fibre is perpendicular to the tangent
  Eigen::Vector3d bump{0, 0, 0};  // added to the normal, for shading only
};

// Called from several threads concurrently.
using Material = std::function<Appearance(const SurfaceSample&)>;

struct BakeOptions {
  int sh_degree = 2;
  double contact_height_m = 0.02;  // height above y = 0 over which light from the floor fades in
  double exposure = 1.0;
  int sky_directions = 36;   // more where a cavity would show the grain
  int occlusion_cells = 72;  // 0: no occlusion; the material provides its own
};

// One light for all objects, for a consistent look: a tall window to the right and in front of the object
// (key), a cool sky above, and warm light reflected by the floor.
Eigen::Vector3d key_direction();  // unit, from the object to the window, modelling frame

// Makes one kernel per sample, flattened along the normal and coloured by the lit material. Ambient
// occlusion, shadow and contact darkening are in the constant band, gloss in the higher bands. The asset's
// frame (x right, -Y up, z forward) is the modelling frame rotated by 180 degrees about x.
GaussianAsset bake_kernels(const SurfaceSamples& samples, const Material& material,
                           const BakeOptions& options, Random& random);

}  // namespace livegs::sample
