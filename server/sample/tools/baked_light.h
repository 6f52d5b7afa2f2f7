// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "gaussian/gaussian_asset.h"
#include "sample/tools/occlusion_grid.h"
#include "sample/tools/random.h"
#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// What a point of a surface is made of. Colours are linear light.
struct Appearance {
  Eigen::Vector3d albedo{0.5, 0.5, 0.5};
  Eigen::Vector3d back_albedo{0.5, 0.5, 0.5};  // of a leaf's other side; used when two_sided
  bool two_sided = false;
  double translucency = 0.0;            // share of the light from behind that a leaf lets through
  double gloss = 0.0;                   // height of the highlight, display units
  double gloss_width = 0.25;            // how rough: 0.05 polished glaze, 0.5 satin
  Eigen::Vector3d subsurface{0, 0, 0};  // light that wanders inside and fills the shadows, linear
  double sheen = 0.0;                   // grazing brightening of a clear coat, display units; needs degree 2
  double opacity = 0.96;
  double flatness = 0.15;         // thickness over tangential size
  double overlap = 0.78;          // standard deviation over spacing: 0.6 crisp, 0.9 closed
  double elongation = 1.0;        // a thread or fibre: longer along the tangent, thinner across, area kept
  bool across = false;            // the fibre runs across the tangent instead
  Eigen::Vector3d bump{0, 0, 0};  // added to the normal for shading only
};

// Called from several threads at once.
using Material = std::function<Appearance(const SurfaceSample&)>;

struct BakeOptions {
  int sh_degree = 2;
  double contact_height_m = 0.02;  // over which light from the floor fades in above the plane y = 0
  double exposure = 1.0;
  int sky_directions = 36;   // more where a hollow would show their grain
  int occlusion_cells = 72;  // 0: nothing shades anything (the material brings its own)
};

// One light for all objects, so that they belong together: a tall window to the right of and before the
// object (key), a cool sky above, warm light back from the floor.
Eigen::Vector3d key_direction();  // unit, from the object to the window, modelling frame

// One kernel a sample: flattened along the normal, coloured by the material under the light, with ambient
// occlusion, shadow and contact darkening in the constant band and gloss in the higher ones. The asset is in
// its own frame (x right, -Y up, z forward), half a turn about x from the modelling frame.
GaussianAsset bake_kernels(const SurfaceSamples& samples, const Material& material,
                           const BakeOptions& options, Random& random);

}  // namespace livegs::sample
