// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "export/portable_scene.h"

namespace livegs {

// Errors of kernels that a format may make. The default is that of floats.
struct KernelSteps {
  float position = 1e-6f;                                   // in units of the asset
  float log_scale = 1e-5f;                                  // scale, relative
  float opacity = 1e-6f;                                    // between 0 and 1
  float sh_dc = 1e-6f, sh_rest_1 = 1e-5f, sh_rest = 1e-5f;  // degree 0, 1, above
  float rotation_deg = 0.05f;
};
// .spz as encode_spz documents it.
inline constexpr KernelSteps kSpzSteps{0x1p-13f * 1.01f, 1.01f / 32,  1.01f / 510, 0.0132f,
                                       4.51f / 128,      8.51f / 128, 0.29f};

// The first difference of two scenes beyond `tolerance`, relative to max(1, magnitude) for positions and to
// the magnitude for masses, inertias and moduli; empty if there is none. Bodies are compared by name, kernels
// within `steps`, and motion within `motion_tolerance`.
std::string scene_difference(const PortableScene& a, const PortableScene& b, double tolerance,
                             double motion_tolerance, const KernelSteps& steps = {});

// The first property in which kernels of the same order differ beyond `steps`, with the number of the kernel;
// empty if there is none.
std::string kernel_difference(const GaussianAsset& a, const GaussianAsset& b, const KernelSteps& steps);

}  // namespace livegs
